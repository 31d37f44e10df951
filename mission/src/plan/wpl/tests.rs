use helmlink_wire::enums::*;
use proptest::prelude::*;

use super::*;
use crate::geodesy::PositionFault;

const LAWNMOWER: &str = "QGC WPL 110\n\
    0\t1\t0\t16\t0\t0\t0\t0\t43.53500000\t-5.65000000\t0.000000\t1\n\
    1\t0\t3\t16\t0\t3\t0\t0\t43.53518001\t-5.65000000\t0.000000\t1\n\
    2\t0\t3\t178\t1\t1.4\t-1\t0\t0\t0\t0\t1\n\
    3\t0\t3\t16\t5\t3\t0\t0\t43.53608008\t-5.64962885\t0.000000\t1\n";

fn fault(text: &str) -> (Place, Fault) {
    match text.parse::<Mission>() {
        Err(PlanError::Content { place, fault, .. }) => (place, fault),
        other => panic!("{other:?}"),
    }
}

/// The sample with one piece replaced.
fn with(from: &str, to: &str) -> String {
    assert!(LAWNMOWER.contains(from));
    LAWNMOWER.replacen(from, to, 1)
}

#[test]
fn reads_what_ground_stations_write() {
    let mission: Mission = LAWNMOWER.parse().unwrap();
    assert_eq!(mission.home, Some(Geodetic::new(43.535, -5.65)));
    assert_eq!(mission.items.len(), 3);
    let last = mission.items[2];
    assert_eq!((last.command, last.frame), (MAV_CMD_NAV_WAYPOINT, MAV_FRAME_GLOBAL_RELATIVE_ALT));
    assert_eq!((last.x, last.y), (435_360_801, -56_496_289));
    assert_eq!(last.params, [5.0, 3.0, 0.0, 0.0]);
    assert!(last.autocontinue);
}

#[test]
fn is_lenient_where_nothing_is_in_doubt() {
    let spaced = LAWNMOWER.replace('\t', "   ").replace('\n', "\r\n\r\n");
    let commented = format!("\u{feff}# from the office\n{}", LAWNMOWER.replace("1\t0\t3", "# leg\n1\t0\t3"));
    let noisy = with("3\t0\t3\t16\t5\t3", "3.000000\t0.0\t3.0\t16.000000\t5.00000000\t3e0");
    let auto = with("\t0\t0\t43.53608008", "\t0\tnan\t43.53608008");
    for text in [spaced, commented, noisy] {
        assert_eq!(text.parse::<Mission>().unwrap(), LAWNMOWER.parse().unwrap(), "{text}");
    }
    assert!(auto.parse::<Mission>().unwrap().items[2].params[3].is_nan());
}

#[test]
fn home_may_be_unknown_or_absent() {
    let unknown = with("43.53500000\t-5.65000000", "0\t0");
    assert_eq!(unknown.parse::<Mission>().unwrap().home, None);
    let absent = "QGC WPL 120\n0 1 3 16 0 0 0 0 43.5 -5.6 0 1\n";
    let mission: Mission = absent.parse().unwrap();
    assert_eq!((mission.home, mission.items.len()), (None, 1));
}

#[test]
fn says_where_and_what_is_wrong() {
    assert_eq!(fault(&with("43.53608008", "95")), (Place::Line(5), PositionFault::Latitude(95.0).into()));
    assert_eq!(fault(&with("43.53608008\t-5.64962885", "0\t0")).1, PositionFault::NoPosition.into());
    assert_eq!(fault(&with("110", "100")), (Place::Line(1), Fault::Version("QGC WPL 100".into())));
    assert_eq!(
        fault(&with("3\t0\t3\t16\t5\t3\t0", "3\t0\t3\t16\t5\t3")),
        (Place::Line(5), Fault::Columns(11))
    );
    assert_eq!(fault(&with("3\t0\t3", "4\t0\t3")).1, Fault::Index { expected: 3, found: 4 });
    assert_eq!(fault(&with("3\t0\t3\t16", "3\t0\t1\t16")).1, Fault::Frame(1));
    assert_eq!(fault(&with("3\t0\t3\t16", "3\t0\t2\t16")).1, Fault::NoFrame(CommandName(16)));
    assert_eq!(fault("QGC WPL 110\n"), (Place::File, Fault::Empty));
    assert_eq!(fault(&LAWNMOWER[..LAWNMOWER.find("\n1").unwrap()]), (Place::File, Fault::Empty));
    assert_eq!(fault(""), (Place::File, Fault::Nothing));
    assert_eq!(fault("<svg>"), (Place::File, Fault::NotAMission("<svg>".into())));
    for (column, from, to) in [
        ("latitude", "43.53608008", "nan"),
        ("longitude", "-5.64962885", "inf"),
        ("altitude", "0.000000", "NaN"),
        ("frame", "3\t0\t3\t16", "3\t0\t-3\t16"),
        ("command", "3\t0\t3\t16", "3\t0\t3\t16.5"),
        ("parameter 1", "16\t5\t3", "16\tx\t3"),
        ("parameter 2", "16\t5\t3", "16\t5\tinf"),
    ] {
        assert!(
            matches!(fault(&with(from, to)).1, Fault::Number { column: found, .. } if found == column),
            "{to}"
        );
    }
}

#[test]
fn an_error_reads_like_a_sentence() {
    let error =
        with("43.53608008", "95").parse::<Mission>().unwrap_err().in_file("harbour.waypoints".as_ref());
    assert_eq!(
        error.to_string(),
        "harbour.waypoints: line 5: latitude 95° is outside −90…90: correct the position of this item"
    );
}

/// Items of missions that a file can hold, in the frames of positions and of commands.
fn any_item() -> impl Strategy<Value = Item> {
    let param = prop_oneof![4 => -1e6..1e6f32, 1 => Just(f32::NAN), 1 => any::<f32>().prop_filter("", |x| x.is_finite())];
    let params = [param.clone(), param.clone(), param.clone(), param];
    let frame = prop::sample::select(vec![0u8, 3, 5, 6, 10, 11]);
    let place = (-900_000_000..=900_000_000i32, -1_800_000_000..=1_800_000_000i32, -100.0..100.0f32);
    // A fence or rally item among them would be read as what it is, which is no mission item.
    let command = prop_oneof![Just(16u16), any::<u16>()].prop_filter("no mission item", |command| {
        !is_fence_item(*command) && *command != MAV_CMD_NAV_RALLY_POINT
    });
    (command, frame, params, place, any::<bool>())
        .prop_filter("no position", |(_, _, _, (x, y, _), _)| *x != 0 || *y != 0)
        .prop_map(|(command, frame, params, (x, y, z), autocontinue)| Item {
            command,
            frame,
            params,
            x,
            y,
            z,
            autocontinue,
        })
}

proptest! {
    #[test]
    fn written_and_read_again_unchanged(
        items in prop::collection::vec(any_item(), 1..20),
        home in prop::option::of((-900_000_000..=900_000_000i32, 1..=1_800_000_000i32)),
    ) {
        let mission = Mission { home: home.map(|(x, y)| Geodetic::from_e7(x, y)), items };
        let text = mission.to_wpl();
        let again: Mission = text.parse().unwrap();
        prop_assert_eq!(again.home.map(Geodetic::to_e7), mission.home.map(Geodetic::to_e7));
        // As text, because NaN is not equal to itself.
        prop_assert_eq!(format!("{:?}", again.items), format!("{:?}", mission.items));
        prop_assert_eq!(again.to_wpl(), text);
    }

    #[test]
    fn no_text_makes_it_panic(text in "(QGC WPL 1[12]0\n|[{])?(\\PC|[\t\n 0-9.])*") {
        let _ = text.parse::<Mission>();
    }

    #[test]
    fn no_damage_makes_it_panic(
        cuts in prop::collection::vec((0..LAWNMOWER.len(), prop::sample::select(vec!["", "\t", "\n", "9", "-", ".", "e", "nan", "#", "é"])), 1..8),
    ) {
        let mut text = LAWNMOWER.to_owned();
        for (at, piece) in cuts {
            let at = (0..=at.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
            let end = (at + 1..=text.len()).find(|end| text.is_char_boundary(*end)).unwrap_or(text.len());
            text.replace_range(at..end, piece);
        }
        if let Ok(mission) = text.parse::<Mission>() {
            prop_assert!(!mission.items.is_empty());
        }
    }
}
