//! Black-box tests of the picture.

use super::*;
use proptest::prelude::*;
use quick_xml::events::Event;

/// A sample that is wholly known.
fn sample(time_s: f64, north_m: f64, east_m: f64) -> TrackPoint {
    TrackPoint {
        time_s,
        position: NorthEast::new(north_m, east_m),
        heading_rad: 0.3,
        cross_track_m: 0.2,
        speed_mps: 1.4,
        wanted_speed_mps: 1.5,
        steering: -0.1,
        throttle: 0.4,
        ..TrackPoint::UNKNOWN
    }
}

/// A run with rough readings that jump at every sample.
fn rough_run(samples: u32) -> Run {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(u32::MAX) * 2.0 - 1.0
    };
    let track = (0..samples)
        .map(|index| TrackPoint {
            time_s: f64::from(index) * 0.02,
            position: NorthEast::new(400.0 * next(), 400.0 * next()),
            heading_rad: 3.0 * next(),
            cross_track_m: 5.0 * next(),
            speed_mps: 2.0 * next(),
            wanted_speed_mps: 2.0 * next(),
            steering: next(),
            throttle: next(),
            ..TrackPoint::UNKNOWN
        })
        .collect();
    Run { title: "Rough".into(), track, ..Run::default() }
}

/// Reads the file with a strict parser and returns all texts, unescaped.
fn read_back(svg: &str) -> Vec<String> {
    let mut reader = quick_xml::Reader::from_str(svg);
    reader.config_mut().check_comments = true;
    // Text counts only between a start and the next end; the rest is white space between elements.
    let (mut texts, mut depth, mut inside) = (Vec::new(), 0, false);
    loop {
        let element = match reader.read_event().unwrap() {
            Event::Start(element) => {
                depth += 1;
                inside = true;
                texts.push(String::new());
                element
            }
            Event::Empty(element) => element,
            Event::End(_) => {
                depth -= 1;
                inside = false;
                continue;
            }
            Event::Text(text) if inside => {
                texts.last_mut().unwrap().push_str(&text.decode().unwrap());
                continue;
            }
            Event::Text(text) => {
                assert_eq!(text.decode().unwrap().trim(), "");
                continue;
            }
            Event::GeneralRef(name) => {
                let character = match name.decode().unwrap().as_ref() {
                    "amp" => '&',
                    "lt" => '<',
                    "gt" => '>',
                    other => panic!("unknown entity {other}"),
                };
                texts.last_mut().unwrap().push(character);
                continue;
            }
            Event::Eof => break,
            other => panic!("unexpected {other:?}"),
        };
        for attribute in element.attributes() {
            let attribute = attribute.unwrap();
            let value = String::from_utf8(attribute.value.to_vec()).unwrap();
            assert!(!value.contains(['<', '&']), "{value}");
            assert!(!value.contains("NaN") && !value.contains("inf"), "{value}");
        }
    }
    assert_eq!(depth, 0);
    let is_character = |c: char| matches!(c, '\t' | '\n' | '\r' | ' '..='\u{fffd}' | '\u{10000}'..);
    assert!(svg.chars().all(is_character));
    texts
}

#[test]
fn an_empty_run_is_an_empty_map() {
    let texts = read_back(&track_svg(&Run::default()));
    assert!(texts.iter().any(|text| text == "no positions"));
    let of_a_run = ["Figures", "Events", "start", "Cross-track error", "distance off the path, m"];
    assert!(!texts.iter().any(|text| of_a_run.contains(&text.as_str())), "{texts:?}");
}

#[test]
fn a_run_of_a_single_place_is_drawn() {
    let place = NorthEast::new(12.0, -7.0);
    let run = Run {
        mission: vec![place],
        path: vec![place],
        track: vec![sample(5.0, 12.0, -7.0)],
        events: vec![(5.0, "armed".into())],
        current: Some(NorthEast::ZERO),
        ..Run::default()
    };
    let texts = read_back(&track_svg(&run));
    for wanted in ["1", "start", "A", "armed", "0.00 m/s"] {
        assert!(texts.iter().any(|text| text == wanted), "{wanted} in {texts:?}");
    }
}

#[test]
fn texts_come_back_as_they_were_given() {
    let run = Run {
        title: "Boat <A> & \"B\"".into(),
        subtitle: vec!["5 < 6 && 7 > 2".into()],
        figures: vec![("p95 <m>".into(), "0.3 & less".into())],
        events: vec![(1.0, "]]> done".into())],
        ..Run::default()
    };
    let texts = read_back(&track_svg(&run));
    for wanted in ["Boat <A> & \"B\"", "5 < 6 && 7 > 2", "p95 <m>", "0.3 & less", "]]> done"] {
        assert!(texts.iter().any(|text| text == wanted), "{wanted} in {texts:?}");
    }
}

#[test]
fn all_waypoints_of_a_mission_are_numbered() {
    let mission = (0..8).map(|n| NorthEast::from_polar(50.0, f64::from(n) * 0.7)).collect();
    let texts = read_back(&track_svg(&Run { mission, ..Run::default() }));
    for number in 1..=8 {
        assert!(texts.contains(&number.to_string()), "{number}");
    }
}

#[test]
fn a_metre_is_equally_long_in_both_directions() {
    let mission = vec![NorthEast::new(0.0, 0.0), NorthEast::new(30.0, 100.0)];
    let area = Area { left: 0.0, top: 0.0, width: 600.0, height: 700.0 };
    let projection = map::Projection::fitting(&Run { mission, ..Run::default() }, area);
    let [origin, north, east] =
        [(0.0, 0.0), (10.0, 0.0), (0.0, 10.0)].map(|(n, e)| projection.point(NorthEast::new(n, e)));
    assert!(north.y < origin.y && north.x == origin.x);
    assert!(east.x > origin.x && east.y == origin.y);
    assert!((origin.distance(north) - origin.distance(east)).abs() < 1e-9);
}

#[test]
fn unknown_readings_leave_the_rest_of_a_sample() {
    let mut run = Run { track: vec![sample(0.0, 0.0, 0.0), sample(1.0, 5.0, 5.0)], ..Run::default() };
    let whole = track_svg(&run).matches("<path").count();
    for point in &mut run.track {
        point.speed_mps = f64::NAN;
    }
    let svg = track_svg(&run);
    read_back(&svg);
    assert_eq!(svg.matches("<path").count(), whole - 1);
}

#[test]
fn long_runs_stay_small_and_keep_their_peak() {
    let mut run = rough_run(100_000);
    let line: Vec<NorthEast> = run.track.iter().map(|sample| sample.position).collect();
    run.mission.clone_from(&line);
    run.path = line;
    run.events = (0..1000).map(|n| (f64::from(n), "x".repeat(1000))).collect();
    run.figures = (0..1000).map(|n| (format!("figure {n}"), "y".repeat(1000))).collect();
    run.track[54_321].cross_track_m = 49.0;
    let svg = track_svg(&run);
    assert!(svg.len() < 500_000, "{} bytes", svg.len());
    assert!(read_back(&svg).iter().any(|text| text == "40"), "the axis must reach the peak of 49 m");
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let run = rough_run(5000);
    assert_eq!(track_svg(&run), track_svg(&run.clone()));
}

/// Mostly ordinary numbers, some at the limits of what a number can be.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -500.0..500.0_f64, 1 => any::<f64>(), 1 => Just(f64::NAN), 1 => Just(0.0)]
}

fn any_place() -> impl Strategy<Value = NorthEast> {
    (any_number(), any_number()).prop_map(|(north_m, east_m)| NorthEast { north_m, east_m })
}

prop_compose! {
    fn any_sample()(place in any_place(), [t, psi, e, u, wanted, s, d] in prop::array::uniform7(any_number())) -> TrackPoint {
        TrackPoint {
            time_s: t, position: place, heading_rad: psi, cross_track_m: e,
            speed_mps: u, wanted_speed_mps: wanted, steering: s, throttle: d,
            surfaces: [e, d], disturbances: [s, u],
        }
    }
}

prop_compose! {
    fn any_run()(
        title in any::<String>(),
        subtitle in prop::collection::vec(any::<String>(), 0..6),
        mission in prop::collection::vec(any_place(), 0..12),
        path in prop::collection::vec(any_place(), 0..12),
        track in prop::collection::vec(any_sample(), 0..40),
        figures in prop::collection::vec(any::<(String, String)>(), 0..6),
        events in prop::collection::vec((any_number(), any::<String>()), 0..30),
        current in prop::option::of(any_place()),
        wind in prop::option::of(any_place()),
    ) -> Run {
        Run {
            title,
            subtitle,
            rally: path.iter().take(3).copied().collect(),
            fence: vec![FenceArea { inclusion: false, outline: path.clone() }],
            mission,
            path,
            track,
            figures,
            events,
            current,
            wind,
        }
    }
}

proptest! {
    #[test]
    fn any_run_becomes_well_formed_xml(run in any_run()) {
        let svg = track_svg(&run);
        read_back(&svg);
        prop_assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    }
}

#[test]
fn the_page_needs_nothing_else_and_escapes_what_it_shows() {
    let run = Run {
        title: "A <script> & \"more\"".into(),
        track: (0..500).map(|index| sample(f64::from(index), f64::from(index), 0.0)).collect(),
        figures: vec![("cross-track".into(), "<0.1 m".into())],
        events: vec![(3.0, "armed & away".into()), (f64::NAN, "never".into())],
        ..Run::default()
    };
    let page = report_html(&run, &[("log.tlog", "the log")]);
    assert!(page.contains("A &lt;script&gt; &amp; &quot;more&quot;") && page.contains("armed &amp; away"));
    assert!(!page.contains("<script") && !page.contains("never"));
    let addresses = page.matches("http").count() - page.matches("http://www.w3.org/2000/svg").count();
    assert_eq!(addresses, 0, "nothing is fetched");
    assert!(page.contains("href=\"log.tlog\"") && page.contains("prefers-color-scheme:dark"));
}

#[test]
fn fence_and_rally_points_are_drawn_within_the_map() {
    let harbour = FenceArea {
        inclusion: true,
        outline: [(-300.0, 0.0), (0.0, 400.0), (300.0, 0.0), (-300.0, 0.0)]
            .map(|(north_m, east_m)| NorthEast::new(north_m, east_m))
            .to_vec(),
    };
    let mut run = rough_run(10);
    let without = track_svg(&run);
    run.fence = vec![harbour];
    run.rally = vec![NorthEast::new(20.0, 20.0)];
    for picture in [track_svg(&run), report_html(&run, &[])] {
        assert!(picture.contains("keep inside") && picture.contains(">R1<"), "{picture}");
        assert!(!picture.contains("keep outside"));
    }
    assert!(!without.contains("keep inside"));
    let area = Area { left: 0.0, top: 0.0, width: 600.0, height: 600.0 };
    let projection = map::Projection::fitting(&run, area);
    for corner in &run.fence[0].outline {
        let point = projection.point(*corner);
        assert!((0.0..=600.0).contains(&point.x) && (0.0..=600.0).contains(&point.y));
    }
}
