//! Figures that are promised.

use std::time::Duration;

use super::rig::*;
use crate::pilot::supervisor::State;
use crate::vehicle::{Mode, OutputKind};

#[test]
fn a_pilot_who_takes_over_hears_no_more_of_us_after_the_next_control_period() {
    for output in OutputKind::ALL {
        // Every instant of a second between the telemetry, the heartbeat and the control loop.
        for phase in 0..25 {
            let mut rig = Rig::under_way(Setup::new(output, true), |_| {});
            rig.run(f64::from(phase) * 0.04 + f64::from(phase % 2) * 0.02);
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

#[test]
fn a_restarted_bridge_is_back_in_control_within_two_seconds() {
    let waypoints = vec![(20.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)];
    let mut longest_s: f64 = 0.0;
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
            longest_s = longest_s.max(after_s);
            assert!(back && after_s <= 2.0, "{case}: {after_s} s, {:?}", rig.texts());
            assert_eq!(rig.bridge().status().progress.unwrap().next, 2, "{case}: at the same waypoint");
            let finished = rig.run_until(200.0, |rig| rig.state() == State::Finished);
            assert!(finished, "{case}: {:?}", rig.texts());
        }
    }
    println!("back in control at most {longest_s:.2} s after the position is valid");
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
