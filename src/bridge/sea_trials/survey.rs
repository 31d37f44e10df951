//! The survey at speed, set up as the real firmware is: how far off the lanes.
//!
//! `helmlink simulate mission/plans/lawnmower-30m.waypoints --boat motorboat --speed 5 --sensors perfect
//! --current 1.5@90` prints the same figures.

use helmlink_mission::plan::Mission;
use helmlink_mission::route::Route;
use helmlink_sitl::physics::sea::Current;
use helmlink_sitl::physics::{Hull, Sea, SensorSettings};

use crate::control::{Boat, Controller};
use crate::simulation::Trial;
use crate::vehicle::OutputKind;

/// Root mean square distance from the lanes, metres: of the whole mission from its first waypoint on, and more than
/// 10 m from any waypoint.
struct Off {
    whole_m: f64,
    straight_m: f64,
}

fn survey(output: OutputKind, current_mps: f64, seed: u64) -> Off {
    let plan = include_str!("../../../mission/plans/lawnmower-30m.waypoints");
    let mission: Mission = plan.parse().unwrap();
    let home = mission.home.unwrap();
    let current = Current { speed_mps: current_mps, toward_deg: 90.0, variability: 0.0 };
    let trial = Trial {
        boat: Boat::embedded("motorboat").unwrap(),
        controller: Controller::default(),
        output,
        speed_mps: Some(5.0),
        interval_s: 0.04,
        hull: Hull::builtin("motorboat").unwrap(),
        sea: Sea { current: (current_mps > 0.0).then_some(current), ..Sea::default() },
        sensors: SensorSettings::perfect(),
        seed,
        delay_s: 0.0,
        route: Route::from_mission(&mission).unwrap(),
        mission,
        home,
        // The first lane leads north from home.
        heading_rad: 0.0,
    };
    let outcome = trial.run().unwrap();
    assert!(outcome.completed, "{output}, {current_mps} m/s: not completed");
    let score = outcome.score.unwrap();
    let rms = |spread: Option<crate::simulation::score::Spread>| spread.unwrap().rms;
    Off { whole_m: rms(score.cross_track_m), straight_m: rms(score.cross_track_straight_m) }
}

fn check(output: OutputKind, whole_m: f64, straight_m: f64) {
    for current_mps in [0.0, 1.0, 1.5] {
        for seed in 201..=205 {
            let off = survey(output, current_mps, seed);
            println!(
                "{output}, current {current_mps} m/s, seed {seed}: whole {:.3} m, straights {:.3} m",
                off.whole_m, off.straight_m
            );
            assert!(off.whole_m <= whole_m && off.straight_m <= straight_m, "see above");
        }
    }
}

#[test]
fn overrides_keep_a_fast_boat_on_its_lanes_in_a_cross_current() {
    check(OutputKind::RcOverride, 0.25, 0.06);
}

#[test]
fn setpoints_do_so_too() {
    check(OutputKind::Guided, 0.25, 0.05);
}

#[test]
fn a_ship_s_own_wide_turns_are_no_reason_to_stop_her() {
    let plan = include_str!("../../../mission/plans/arcs-monohull38.waypoints");
    let mission: Mission = plan.parse().unwrap();
    let home = mission.home.unwrap();
    let route = Route::from_mission(&mission).unwrap();
    let first = route.waypoints[0].position;
    let toward = helmlink_mission::geodesy::LocalFrame::new(home).to_local(first);
    let trial = Trial {
        boat: Boat::embedded("monohull38").unwrap(),
        controller: Controller::default(),
        output: OutputKind::RcOverride,
        speed_mps: Some(4.0),
        interval_s: 0.04,
        hull: Hull::builtin("monohull38").unwrap(),
        sea: Sea::default(),
        sensors: SensorSettings::perfect(),
        seed: 201,
        delay_s: 0.0,
        mission,
        route,
        home,
        heading_rad: toward.bearing_rad(),
    };
    let outcome = trial.run().unwrap();
    assert!(outcome.completed, "{outcome:?}");
}
