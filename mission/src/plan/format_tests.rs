use helmlink_wire::enums::*;
use proptest::prelude::*;

use super::super::{Area, Fence, Mission, RallyPoint, Reading};
use super::*;
use crate::geodesy::Geodetic;

fn any_place() -> impl Strategy<Value = Geodetic> {
    (-899_999_999..899_999_999i32, -1_799_999_999..1_799_999_999i32)
        .prop_filter("no position", |(x, y)| (*x, *y) != (0, 0))
        .prop_map(|(x, y)| Geodetic::from_e7(x, y))
}

fn any_param() -> impl Strategy<Value = f32> {
    prop_oneof![
        Just(0.0),
        Just(f32::NAN),
        -1e3..1e3f32,
        any::<f32>().prop_filter("infinite", |p| !p.is_infinite())
    ]
}

fn any_waypoint() -> impl Strategy<Value = Item> {
    let frames = vec![0u8, 3, 5, 6, 10, 11];
    let command = prop_oneof![3 => Just(MAV_CMD_NAV_WAYPOINT), 1 => Just(MAV_CMD_NAV_LOITER_TURNS)];
    let params = [any_param(), any_param(), any_param(), any_param()];
    (command, prop::sample::select(frames), any_place(), params, -1e4..1e4f32, any::<bool>()).prop_map(
        |(command, frame, place, params, z, autocontinue)| Item {
            command,
            frame,
            params,
            z,
            autocontinue,
            ..Item::waypoint(place)
        },
    )
}

fn any_command() -> impl Strategy<Value = Item> {
    let command = prop::sample::select(vec![
        MAV_CMD_DO_CHANGE_SPEED,
        MAV_CMD_NAV_RETURN_TO_LAUNCH,
        MAV_CMD_DO_SET_SERVO,
        MAV_CMD_NAV_DELAY,
    ]);
    let params = [any_param(), any_param(), any_param(), any_param()];
    (command, params, -9..9i32, -1e4..1e4f32).prop_map(|(command, params, x, z)| Item {
        command,
        frame: MAV_FRAME_MISSION,
        params,
        x,
        y: 2 * x,
        z,
        autocontinue: true,
    })
}

fn any_outline() -> impl Strategy<Value = Outline> {
    prop_oneof![
        prop::collection::vec(any_place(), 3..7)
            .prop_filter("closed", |corners| corners.first() != corners.last())
            .prop_map(Outline::Polygon),
        (any_place(), 0.1..1e4f32).prop_map(|(centre, radius_m)| Outline::Circle { centre, radius_m }),
    ]
}

fn any_rally() -> impl Strategy<Value = RallyPoint> {
    (any_place(), -100.0..100f32).prop_map(|(position, altitude_m)| RallyPoint { position, altitude_m })
}

fn any_plan(item: impl Strategy<Value = Item>) -> impl Strategy<Value = Plan> {
    let area = (any::<bool>(), any_outline()).prop_map(|(inclusion, outline)| Area { inclusion, outline });
    (
        prop::option::of(any_place()),
        prop::collection::vec(item, 1..8),
        prop::collection::vec(area, 0..3),
        prop::option::of(any_rally()),
        prop::collection::vec(any_rally(), 0..3),
    )
        .prop_map(|(home, items, areas, return_point, rally)| Plan {
            mission: Mission { home, items },
            fence: Fence { areas, return_point },
            rally,
        })
}

/// What can be compared: positions as MAVLink's integers, NaN as one value.
fn comparable(plan: &Plan) -> String {
    let e7 = |place: Geodetic| place.to_e7();
    let items: Vec<String> = plan
        .mission
        .items
        .iter()
        .map(|item| {
            let params = item.params.map(|p| if p == 0.0 { 0.0 } else { p });
            format!(
                "{} {} {params:?} {} {} {} {}",
                item.command, item.frame, item.x, item.y, item.z, item.autocontinue
            )
        })
        .collect();
    let mut areas: Vec<String> = plan
        .fence
        .areas
        .iter()
        .map(|area| match &area.outline {
            Outline::Polygon(corners) => {
                format!("{} {:?}", area.inclusion, corners.iter().map(|c| e7(*c)).collect::<Vec<_>>())
            }
            Outline::Circle { centre, radius_m } => {
                format!("{} {:?} {radius_m}", area.inclusion, e7(*centre))
            }
        })
        .collect();
    // QGroundControl keeps polygons and circles apart.
    areas.sort();
    let place = |point: &RallyPoint| format!("{:?} {}", e7(point.position), point.altitude_m);
    let rally: Vec<String> = plan.rally.iter().map(place).collect();
    let back = plan.fence.return_point.as_ref().map(place);
    format!("{:?}\n{items:#?}\n{areas:#?}\n{back:?}\n{rally:#?}", plan.mission.home.map(e7))
}

fn through(format: Format, plan: &Plan) -> (Plan, Vec<Loss>) {
    let (bytes, losses) = format.encode(plan).unwrap();
    let reading = Reading::from_bytes(&bytes).unwrap();
    assert_eq!(reading.format, format);
    assert_eq!(format.encode(plan).unwrap().0, bytes, "the same plan, the same bytes");
    (reading.plan, losses)
}

#[test]
fn names_and_endings() {
    for format in Format::ALL {
        assert_eq!(Format::from_name(format.name()), Some(format));
        let path = format!("a.{}", format.name().to_uppercase());
        assert_eq!(Format::of_path(Path::new(&path)), Some(format));
    }
    assert_eq!(Format::of_path(Path::new("a.waypoints")), Some(Format::Wpl));
    assert_eq!(Format::of_path(Path::new("a.doc")), None);
}

#[test]
fn says_what_a_path_cannot_hold() {
    let here = Geodetic::new(59.9, 10.7);
    let hold = Item { params: [5.0, 0.0, 0.0, 0.0], ..Item::waypoint(here) };
    let loiter = Item { command: MAV_CMD_NAV_LOITER_TURNS, ..Item::waypoint(here) };
    let items = vec![Item::waypoint(here), Item::change_speed(1.0), hold, loiter];
    let circle = Area { inclusion: true, outline: Outline::circle(here, 9.0).unwrap() };
    let plan = Plan {
        mission: Mission { home: None, items },
        fence: Fence { areas: vec![circle], return_point: None },
        rally: Vec::new(),
    };
    let losses = |format: Format| format.losses(&plan).iter().map(Loss::to_string).collect::<Vec<_>>();
    assert_eq!(
        losses(Format::Gpx),
        [
            "item 2: MAV_CMD_DO_CHANGE_SPEED (178), which is left out",
            "item 4: MAV_CMD_NAV_LOITER_TURNS (18), of which only the place is kept",
            "item 3: hold time, acceptance radius or other parameters of the waypoint",
            "the areas of the fence",
        ]
    );
    assert_eq!(losses(Format::Kmz).last().unwrap(), "circles of the fence, which are drawn as polygons");
    assert_eq!(losses(Format::Wpl), ["the fence: write it to a file of its own, or as .plan"]);
    for whole in [Format::Qgc, Format::GeoJson, Format::Csv] {
        assert_eq!(losses(whole), [""; 0]);
    }
}

proptest! {
    #[test]
    fn nothing_is_lost_where_everything_can_be_held(plan in any_plan(prop_oneof![any_waypoint(), any_command()])) {
        for format in [Format::Qgc, Format::GeoJson, Format::Csv] {
            let (again, losses) = through(format, &plan);
            prop_assert_eq!(comparable(&again), comparable(&plan), "{}", format.name());
            prop_assert!(losses.is_empty());
        }
    }

    #[test]
    fn the_plain_text_holds_the_mission_or_else_one_list(plan in any_plan(prop_oneof![any_waypoint(), any_command()])) {
        let mission = Plan { mission: plan.mission.clone(), ..Plan::default() };
        prop_assert_eq!(comparable(&through(Format::Wpl, &plan).0), comparable(&mission));
        let fence = Plan { fence: plan.fence.clone(), ..Plan::default() };
        if !fence.is_empty() {
            prop_assert_eq!(comparable(&through(Format::Wpl, &fence).0), comparable(&fence));
        }
        let rally = Plan { rally: plan.rally, ..Plan::default() };
        if !rally.is_empty() {
            prop_assert_eq!(comparable(&through(Format::Wpl, &rally).0), comparable(&rally));
        }
    }

    #[test]
    fn paths_hold_the_places(mut plan in any_plan(any_waypoint())) {
        for item in &mut plan.mission.items {
            *item = Item { z: item.z, ..Item::waypoint(item.position().unwrap()) };
        }
        plan.fence = Fence::default();
        for format in [Format::Gpx, Format::Kml, Format::Kmz] {
            let (again, losses) = through(format, &plan);
            prop_assert_eq!(comparable(&again), comparable(&plan), "{}", format.name());
            prop_assert!(losses.is_empty());
        }
    }
}
