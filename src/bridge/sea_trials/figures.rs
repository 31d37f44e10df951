//! Figures that are promised.

use std::time::Duration;

use helmlink_sitl::faults::{Fault, TimedFault};
use helmlink_wire::dialect::{CharArray, PARAM_SET_DATA};
use helmlink_wire::{Message, enums};

use super::rig::*;
use crate::pilot::supervisor::State;
use crate::simulation::RunRecorder;
use crate::vehicle::{Mode, OutputKind};

#[test]
fn a_pilot_who_takes_over_hears_no_more_of_us_after_the_next_control_period() {
    for output in OutputKind::ALL {
        for phase in 0..5 {
            let mut rig = Rig::under_way(Setup::new(output, true), |_| {});
            rig.run(f64::from(phase) * 0.02);
            rig.choose(Mode::LOITER);
            let chosen_at = rig.now;
            rig.run(2.0);
            let last = rig.steering.last().unwrap().at;
            // One loop until the firmware obeys, one control period until its heartbeat, one loop on the way.
            let after = last.saturating_sub(chosen_at);
            assert!(after <= Duration::from_millis(80), "{output}, phase {phase}: {after:?}");
            assert_eq!((rig.state(), rig.mode), (State::Ready, Mode::LOITER), "{output}: his mode stays");
        }
    }
}

/// Lets the bridge vanish, by a cut line or by death, and tells after how long the boat's throttle was neutral for good,
/// and its mode at the end.
fn vanish(setup: Setup, run: u32, throttle_failsafe: bool) -> (f64, Mode) {
    let mut rig = Rig::under_way(setup, |_| {});
    if throttle_failsafe {
        rig.say(&Message::PARAM_SET(PARAM_SET_DATA {
            param_id: CharArray::from("FS_THR_ENABLE"),
            param_value: 1.0,
            param_type: enums::MAV_PARAM_TYPE_INT8,
            target_system: VEHICLE.system,
            target_component: VEHICLE.component,
        }));
    }
    let interval = crate::vehicle::streams::command_long(
        VEHICLE,
        enums::MAV_CMD_SET_MESSAGE_INTERVAL,
        [36.0, 20_000.0, 0.0],
    );
    rig.say(&interval);
    rig.run(0.5 + 0.02 * f64::from(run % 50));
    if run.is_multiple_of(2) {
        rig.cut = true;
    } else {
        rig.bridge = None;
    }
    let gone_at = rig.now;
    let mut neutral_at = None;
    for _ in 0..300 {
        rig.step();
        if rig.servos_us == [1500, 1500] {
            neutral_at.get_or_insert(rig.now);
        } else {
            neutral_at = None;
        }
    }
    let after_s = neutral_at.map_or(f64::INFINITY, |at| (at - gone_at).as_secs_f64());
    (after_s, rig.mode)
}

/// The firmware takes up to a second to bring the throttle to neutral (MOT_SLEWRATE 100 % a second).
const SLEW_S: f64 = 1.05;

#[test]
fn a_boat_with_a_receiver_is_neutral_three_seconds_after_its_bridge_has_gone() {
    for run in 0..100 {
        let (after_s, mode) = vanish(Setup::new(OutputKind::RcOverride, true), run, false);
        assert!(
            (2.5..=3.1 + SLEW_S).contains(&after_s) && mode == Mode::MANUAL,
            "run {run}: {after_s} s, {mode}"
        );
    }
}

#[test]
fn a_boat_without_a_receiver_is_neutral_after_half_a_second_and_then_in_hold() {
    for run in 0..100 {
        let (after_s, mode) = vanish(Setup::new(OutputKind::RcOverride, false), run, true);
        assert!(after_s <= 0.55 + SLEW_S && mode == Mode::HOLD, "run {run}: {after_s} s, {mode}");
    }
}

#[test]
fn a_boat_in_guided_without_a_receiver_is_in_hold_after_two_seconds_anyway() {
    let mut rig = Rig::under_way(Setup::new(OutputKind::Guided, false), |_| {});
    rig.say(&Message::PARAM_SET(PARAM_SET_DATA {
        param_id: CharArray::from("FS_THR_ENABLE"),
        param_value: 1.0,
        param_type: enums::MAV_PARAM_TYPE_INT8,
        target_system: VEHICLE.system,
        target_component: VEHICLE.component,
    }));
    assert!(rig.run_until(3.0, |rig| rig.state() != State::Engaged), "the firmware takes over");
    rig.run(1.2);
    assert_eq!(rig.mode, Mode::HOLD);
}

#[test]
fn a_boat_in_guided_keeps_its_place_three_seconds_after_its_bridge_has_gone() {
    for run in 0..100 {
        let mut rig = Rig::under_way(Setup::new(OutputKind::Guided, true), |_| {});
        rig.run(0.02 * f64::from(run % 50));
        if run % 2 == 0 {
            rig.cut = true;
        } else {
            rig.bridge = None;
        }
        rig.run(3.1);
        let at_s = |rig: &Rig| (rig.sitl.truth().hull.north_m, rig.sitl.truth().hull.east_m);
        let stopped_from = at_s(&rig);
        rig.run(12.0);
        let (north_m, east_m) = at_s(&rig);
        let moved_m = (north_m - stopped_from.0).hypot(east_m - stopped_from.1);
        assert!(moved_m < 5.0 && rig.mode == Mode::GUIDED, "run {run}: {moved_m} m, {}", rig.mode);
    }
}

#[test]
fn a_restarted_bridge_is_back_in_control_within_two_seconds() {
    let waypoints = vec![(20.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)];
    for output in OutputKind::ALL {
        for receiver in [true, false] {
            let setup = Setup { waypoints: waypoints.clone(), ..Setup::new(output, receiver) };
            let mut rig = Rig::under_way(setup, |_| {});
            let on_second = |rig: &Rig| {
                rig.bridge.as_ref().and_then(|bridge| bridge.status().progress).is_some_and(|p| p.next == 2)
            };
            assert!(rig.run_until(120.0, on_second));
            let point = rig.bridge().resume_point().unwrap();
            assert_eq!((point.item, point.driving), (3, true));
            rig.bridge = None;
            rig.run(2.5);
            rig.settings.resume = Some(point);
            rig.start_bridge();
            assert!(rig.run_until(5.0, |rig| rig.bridge.as_ref().unwrap().conditions().steady));
            let valid_at = rig.now;
            let case = format!("{output}, receiver {receiver}");
            let back = rig.run_until(5.0, |rig| rig.state() == State::Engaged);
            let after_s = (rig.now - valid_at).as_secs_f64();
            assert!(back && after_s <= 2.0, "{case}: {after_s} s, {:?}", rig.texts());
            assert_eq!(rig.bridge().status().progress.unwrap().next, 2, "{case}: at the same waypoint");
            let finished = rig.run_until(200.0, |rig| rig.state() == State::Finished);
            assert!(finished, "{case}: {:?}", rig.texts());
        }
    }
}

#[test]
fn a_bridge_that_ended_in_order_does_not_start_again_by_itself() {
    let mut rig = Rig::under_way(Setup::new(OutputKind::RcOverride, true), |_| {});
    rig.choose(Mode::HOLD);
    rig.run(1.0);
    let point = rig.bridge().resume_point().unwrap();
    rig.settings.resume = Some(point);
    rig.start_bridge();
    rig.run(10.0);
    assert_eq!(rig.state(), State::Ready);
    assert!(rig.texts().iter().any(|text| text.contains("not resumed")), "{:?}", rig.texts());
}

/// Root mean square distance from the mission's legs, metres, and whether the mission was completed.
fn survey(spoil: impl FnOnce(&mut Rig)) -> (f64, bool) {
    let waypoints = vec![(20.0, 0.0), (100.0, 0.0), (100.0, 25.0), (20.0, 25.0), (20.0, 50.0), (100.0, 50.0)];
    let setup = Setup { waypoints, ..Setup::new(OutputKind::RcOverride, true) };
    let mut rig = Rig::under_way(setup, |_| {});
    spoil(&mut rig);
    let mut recorder = RunRecorder::new(HOME);
    for step in 0..30_000_u32 {
        rig.step();
        if step % 5 == 0 {
            let time_s = rig.now.as_secs_f64();
            recorder.sample(time_s, &rig.sitl, rig.bridge.as_ref().unwrap());
        }
        if rig.state() == State::Finished {
            break;
        }
    }
    let rms_m =
        recorder.score().and_then(|score| score.cross_track_m).map_or(f64::INFINITY, |spread| spread.rms);
    (rms_m, rig.state() == State::Finished)
}

#[test]
fn a_bad_link_and_a_bad_sky_at_most_double_the_distance_from_the_track() {
    let (clean_m, _) = survey(|_| {});
    let (spoilt_m, completed) = survey(|rig| {
        rig.sitl.inject(Fault::LinkLoss { share: 0.2 }).unwrap();
        rig.sitl.inject(Fault::LinkDelay { delay_s: 0.2, jitter_s: 0.0 }).unwrap();
        for minute in 0..8 {
            let from = Duration::from_secs(30 + 40 * minute);
            let until = Some(from + Duration::from_secs(2));
            let fault = TimedFault { fault: Fault::GpsLoss, from, until };
            rig.sitl.schedule(fault).unwrap();
        }
    });
    println!("off the track: {clean_m:.3} m rms clean, {spoilt_m:.3} m rms spoilt");
    assert!(completed);
    assert!(spoilt_m <= 2.0 * clean_m, "{clean_m} m clean, {spoilt_m} m spoilt");
}
