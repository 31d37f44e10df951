//! The missions that come with Helmlink can be read, understood and drawn.
// Clippy takes only the test functions themselves for tests, not their helpers.
#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use helmlink_mission::geodesy::LocalFrame;
use helmlink_mission::path::{Path, PathLimits};
use helmlink_mission::plan::{self, Mission, PlanError};
use helmlink_mission::route::{Ending, Route};

fn sample(name: &str) -> Mission {
    plan::read(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("plans").join(name)).unwrap()
}

/// North and east of home, rounded to decimetres.
fn local_dm(mission: &Mission) -> Vec<(i64, i64)> {
    let frame = LocalFrame::new(mission.home.unwrap());
    let points = Route::from_mission(mission).unwrap().local_points(&frame);
    points.iter().map(|p| ((p.north_m * 10.0).round() as i64, (p.east_m * 10.0).round() as i64)).collect()
}

#[test]
fn the_harbour_survey_is_short_and_starts_near_home() {
    let mission = sample("harbour-survey.waypoints");
    let route = Route::from_mission(&mission).unwrap();
    assert_eq!(route.ending, Ending::Hold);
    let approach_m = mission.home.unwrap().distance_m(route.waypoints[0].position);
    assert!((10.0..20.0).contains(&approach_m), "{approach_m}");
    assert!((200.0..250.0).contains(&(route.length_m() + approach_m)), "{}", route.length_m());
}

#[test]
fn both_formats_hold_the_same_survey() {
    let [text, json] = ["harbour-survey.waypoints", "harbour-survey.plan"].map(sample);
    assert_eq!(text.home, json.home);
    assert_eq!(Route::from_mission(&text), Route::from_mission(&json));
}

#[test]
fn the_scenarios_are_where_they_should_be() {
    assert_eq!(
        local_dm(&sample("fossen-otter.waypoints")),
        [(0, 0), (0, 2000), (1500, 2000), (1500, -500), (-1000, -500), (-1000, 2500), (2000, 2500)]
    );
    assert_eq!(
        local_dm(&sample("lawnmower-30m.waypoints")),
        [(200, 0), (1200, 0), (1200, 300), (200, 300), (200, 600), (1200, 600), (1200, 900), (200, 900)]
    );
}

#[test]
fn every_sample_can_be_drawn_and_written_again() {
    for name in [
        "harbour-survey.waypoints",
        "harbour-survey.plan",
        "fossen-otter.waypoints",
        "lawnmower-30m.waypoints",
    ] {
        let mission = sample(name);
        let frame = LocalFrame::new(mission.home.unwrap());
        let points = Route::from_mission(&mission).unwrap().local_points(&frame);
        let path = Path::through(&points, &PathLimits::new(3.0, 1.0)).unwrap();
        assert!(path.corners().iter().all(|corner| corner.cut_m < 2.0 && corner.scale > 0.9), "{name}");
        let again: Mission = mission.to_wpl().parse().unwrap();
        assert_eq!(again.to_wpl(), mission.to_wpl(), "{name}");
    }
}

#[test]
fn files_are_written_and_errors_name_them() {
    let folder = std::env::temp_dir().join(format!("helmlink-mission-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("copy.txt");
    let mission = sample("lawnmower-30m.waypoints");
    plan::write(&file, &mission).unwrap();
    assert_eq!(plan::read(&file).unwrap(), mission);

    std::fs::write(&file, "QGC WPL 110\n0 1 0 16 0 0 0\n").unwrap();
    let text = plan::read(&file).unwrap_err().to_string();
    assert!(text.contains("copy.txt: line 2: found 7 columns, expected 12"), "{text}");
    std::fs::write(&file, [0xff, 0xfe, 0x00]).unwrap();
    assert!(plan::read(&file).unwrap_err().to_string().contains("not UTF-8 text"));
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(matches!(plan::read(&file), Err(PlanError::Read { .. })));
    assert!(matches!(plan::write(&file, &mission), Err(PlanError::Write { .. })));
}
