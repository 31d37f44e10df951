use super::*;
use crate::autopilot::testing::{Bench, GCS, LINK};
use crate::physics::Sea;
use helmlink_wire::dialect::{Message, RC_CHANNELS_OVERRIDE_DATA};

#[test]
fn numbers_and_modes_agree() {
    for number in 0..40 {
        match Mode::from_number(number) {
            Ok(mode) => assert_eq!(mode.number(), number),
            Err(refusal) => assert!(
                matches!(number, 6 | 7 | 8 | 16) == (refusal == ModeRefusal::NotNow),
                "{number}: {refusal}"
            ),
        }
    }
}

#[test]
fn heartbeat_flags_are_the_measured_ones() {
    assert_eq!(Mode::Manual.base_mode(), 65);
    assert_eq!(Mode::Hold.base_mode(), 1);
    for mode in [Mode::Guided, Mode::Auto, Mode::Rtl, Mode::Loiter, Mode::Circle] {
        assert_eq!(mode.base_mode(), 9);
    }
}

#[test]
fn auto_needs_a_mission_even_when_disarmed() {
    let mut bench = Bench::ready();
    assert_eq!(bench.autopilot.enter_mode(Mode::Auto), Err(ModeRefusal::NoMission));
    assert_eq!(bench.autopilot.enter_mode(Mode::Guided), Ok(()));
}

#[test]
fn armed_without_a_position_only_simple_modes_are_open() {
    let mut bench = Bench::ready();
    bench.arm();
    bench.inject(crate::faults::Fault::GpsLoss).unwrap();
    bench.run_s(0.1);
    assert_eq!(bench.autopilot.enter_mode(Mode::Guided), Err(ModeRefusal::NotNow));
    assert_eq!(bench.autopilot.enter_mode(Mode::Acro), Err(ModeRefusal::NotNow));
    assert_eq!(bench.autopilot.enter_mode(Mode::Hold), Ok(()));
}

#[test]
fn return_to_launch_comes_home_and_smart_return_retraces() {
    for mode in [Mode::Rtl, Mode::SmartRtl] {
        let mut bench = Bench::ready();
        bench.arm();
        bench.autopilot.enter_mode(Mode::Guided).unwrap();
        bench.go_to(NorthEast::new(30.0, 0.0));
        bench.run_s(40.0);
        bench.go_to(NorthEast::new(30.0, 30.0));
        bench.run_s(40.0);
        assert!(bench.position().norm() > 30.0, "{:?}", bench.position());
        bench.autopilot.enter_mode(mode).unwrap();
        bench.run_s(90.0);
        assert!(bench.position().norm() < 6.0, "{mode:?}: {:?}", bench.position());
    }
}

#[test]
fn a_circle_is_kept() {
    for hull in ["otter", "skiff"] {
        let mut bench = Bench::with_hull(hull);
        bench.arm();
        let radius_m = bench.autopilot.parameters.get(CIRC_RADIUS);
        bench.autopilot.enter_mode(Mode::Circle).unwrap();
        let centre = bench.autopilot.mode_state.point;
        bench.run_s(60.0);
        let mut bearings = [false; 4];
        for _ in 0..300 {
            bench.run_s(1.0);
            let offset = bench.position() - centre;
            assert!((offset.norm() - radius_m).abs() < 0.15 * radius_m, "{hull}: {} m", offset.norm());
            let quarter = (offset.bearing_rad() / std::f64::consts::FRAC_PI_2 + 2.0).floor() as usize % 4;
            bearings[quarter] = true;
        }
        assert_eq!(bearings, [true; 4], "{hull} has been all around");
    }
}

#[test]
fn acro_turns_sticks_into_turn_rate_and_speed() {
    let mut bench = Bench::ready();
    bench.arm();
    bench.autopilot.enter_mode(Mode::Acro).unwrap();
    let sticks = RC_CHANNELS_OVERRIDE_DATA {
        chan1_raw: 1610,
        chan3_raw: 1765,
        target_system: 1,
        target_component: 1,
        ..RC_CHANNELS_OVERRIDE_DATA::DEFAULT
    };
    for _ in 0..30 {
        bench.send(LINK, GCS, &Message::RC_CHANNELS_OVERRIDE(sticks.clone()));
        bench.run_s(1.0);
    }
    let hull = bench.vessel.truth().hull;
    let full_radps = bench.autopilot.parameters.get(ACRO_TURN_RATE).to_radians();
    // 80 of 470 µs beyond the dead zone, and 50 % of the throttle.
    assert!((hull.r_radps - 80.0 / 470.0 * full_radps).abs() < 0.02, "{hull:?}");
    let full_mps = bench.autopilot.stick_speed_mps();
    assert!((hull.u_mps - 0.5 * full_mps).abs() < 0.05, "{hull:?}");
}

#[test]
fn loiter_holds_against_a_current() {
    let sea = Sea { current: Some("0.4@120".parse().unwrap()), ..Sea::default() };
    let mut bench = Bench::at_sea("otter", sea);
    bench.arm();
    bench.autopilot.enter_mode(Mode::Loiter).unwrap();
    bench.run_s(60.0);
    for _ in 0..120 {
        bench.run_s(1.0);
        assert!(bench.position().norm() < 5.0, "{:?}", bench.position());
    }
}
