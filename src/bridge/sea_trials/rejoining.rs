//! Missions and drives taken up again in the middle: along the path, not across it and not back.

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::protocol::MissionType;
use helmlink_sitl::physics::Sea;
use helmlink_sitl::physics::sea::Current;

use super::rig::*;
use crate::pilot::supervisor::{Request, State};
use crate::vehicle::{Mode, OutputKind};

/// Two lanes to the north and back.
const LANES: [(f64, f64); 4] = [(20.0, 0.0), (120.0, 0.0), (120.0, 30.0), (20.0, 30.0)];

fn on_lanes() -> Rig {
    Rig::under_way(Setup { waypoints: LANES.to_vec(), ..Setup::new(OutputKind::RcOverride, true) }, |_| {})
}

fn position(rig: &Rig) -> NorthEast {
    let hull = rig.sitl.truth().hull;
    NorthEast::new(hull.north_m, hull.east_m)
}

fn next(rig: &Rig) -> usize {
    rig.bridge.as_ref().and_then(|bridge| bridge.status().progress).unwrap().next
}

/// Lets the boat drive until `is_so`, and gives every place where it has been.
fn track(rig: &mut Rig, limit_s: f64, mut is_so: impl FnMut(&Rig) -> bool) -> Vec<NorthEast> {
    let mut places = Vec::new();
    let done = rig.run_until(limit_s, |rig| {
        places.push(position(rig));
        is_so(rig)
    });
    assert!(done, "{:?} at {:?}", rig.texts(), position(rig));
    places
}

/// A current carries the boat, which nobody drives, by so much.
fn carry(rig: &mut Rig, by: NorthEast) {
    const SECONDS: f64 = 8.0;
    let current = Current {
        speed_mps: by.norm() / SECONDS,
        toward_deg: by.bearing_rad().to_degrees(),
        variability: 0.0,
    };
    rig.sitl.set_sea(Sea { current: Some(current), ..Sea::default() });
    rig.run(SECONDS);
    rig.sitl.set_sea(Sea::default());
}

#[test]
fn a_drive_taken_up_again_beside_the_lane_comes_back_to_it_ahead_and_stays_on_it() {
    for restarts in [false, true] {
        let mut rig = on_lanes();
        assert!(rig.run_until(120.0, |rig| next(rig) == 1 && position(rig).north_m > 50.0));
        if restarts {
            let point = rig.bridge().resume_point().unwrap();
            rig.bridge = None;
            carry(&mut rig, NorthEast::new(-4.0, 12.0));
            rig.settings.resume = Some(point);
            rig.start_bridge();
        } else {
            rig.choose(Mode::HOLD);
            assert!(rig.run_until(3.0, |rig| rig.state() == State::Ready));
            carry(&mut rig, NorthEast::new(-4.0, 12.0));
            let now = rig.now;
            rig.bridge().request(now, Request::Engage { patient: false }).unwrap();
        }
        assert!(rig.run_until(10.0, |rig| rig.state() == State::Engaged), "{:?}", rig.texts());
        let taken_up_at = position(&rig);
        let places = track(&mut rig, 120.0, |rig| next(rig) == 2);
        let back_m = places.iter().map(|place| place.north_m).fold(f64::INFINITY, f64::min);
        assert!(back_m > taken_up_at.north_m - 4.0, "goes back to {back_m} m from {taken_up_at:?}");
        let late = places.iter().filter(|place| (95.0..110.0).contains(&place.north_m));
        let off_m = late.map(|place| place.east_m.abs()).fold(0.0, f64::max);
        assert!(off_m < 1.0, "restarts {restarts}: {off_m} m off the lane 50 m later: it cuts across");
    }
}

#[test]
fn a_boat_that_drifted_past_its_waypoint_meanwhile_does_not_go_back_to_it() {
    let mut rig = on_lanes();
    assert!(rig.run_until(200.0, |rig| next(rig) == 1 && position(rig).north_m > 108.0));
    let point = rig.bridge().resume_point().unwrap();
    rig.bridge = None;
    carry(&mut rig, NorthEast::new(10.0, 6.0));
    rig.settings.resume = Some(point);
    rig.start_bridge();
    assert!(rig.run_until(10.0, |rig| rig.state() == State::Engaged), "{:?}", rig.texts());
    assert_eq!(next(&rig), 2, "{:?}", rig.texts());
}

#[test]
fn lanes_moved_under_way_are_joined_ahead_and_nothing_driven_is_driven_again() {
    let mut rig = on_lanes();
    assert!(rig.run_until(300.0, |rig| next(rig) == 3 && position(rig).north_m < 90.0), "{:?}", rig.texts());
    let from = position(&rig);
    let moved = LANES.map(|(north_m, east_m)| (north_m, east_m + 8.0));
    rig.upload(MissionType::Mission, items(&moved));
    let has_changed = |rig: &Rig| rig.texts().iter().any(|text| text.contains("has changed under way"));
    assert!(rig.run_until(10.0, has_changed), "{:?}", rig.texts());
    assert_eq!(next(&rig), 3, "{:?}", rig.texts());
    let places = track(&mut rig, 200.0, |rig| rig.state() == State::Finished);
    let north_m = places.iter().map(|place| place.north_m).fold(f64::NEG_INFINITY, f64::max);
    assert!(north_m < from.north_m + 2.0, "goes back north to {north_m} m");
    let late = places.iter().filter(|place| (30.0..45.0).contains(&place.north_m));
    let off_m = late.map(|place| (place.east_m - 38.0).abs()).fold(0.0, f64::max);
    assert!(off_m < 1.0, "{off_m} m off the new lane");
}
