use proptest::prelude::*;

use super::*;
use crate::control::Boat;

fn allocator(name: &str) -> Allocator {
    let boat = Boat::embedded(name).unwrap();
    Allocator::new(&boat.actuators, &boat.hull)
}

fn situation(surge_mps: f64, heading_error_rad: f64) -> Situation {
    let motion = WaterMotion { surge_mps, sway_mps: 0.0, yaw_rate_radps: 0.0 };
    Situation { motion, heading_error_rad }
}

fn wrench(surge_n: f64, yaw_nm: f64) -> Wrench {
    Wrench { surge_n, sway_n: 0.0, yaw_nm }
}

/// The allocation after the actuators had time to follow.
fn settled(name: &str, demand: Wrench, situation: &Situation) -> Allocation {
    let mut allocator = allocator(name);
    (0..1000).map(|_| allocator.allocate(0.05, demand, situation)).last().unwrap()
}

proptest! {
    #[test]
    fn commands_stay_in_range(
        surge in -1.0e6..1.0e6f64, yaw in -1.0e8..1.0e8f64, speed in -5.0..10.0f64, error in -3.2..3.2f64,
    ) {
        for name in Boat::names() {
            let allocation = allocator(name).allocate(0.05, wrench(surge, yaw), &situation(speed, error));
            let Command { throttle, steering } = allocation.command;
            prop_assert!((-1.0..=1.0).contains(&throttle), "{name} throttle {throttle}");
            prop_assert!((-1.0..=1.0).contains(&steering), "{name} steering {steering}");
            if name == "otter" {
                prop_assert!(throttle.abs() + steering.abs() <= 1.0 + 1.0e-12);
            }
        }
    }

    #[test]
    fn twin_thrusters_give_what_they_can(surge in -100.0..200.0f64, yaw in -70.0..70.0f64) {
        let allocation = settled("otter", wrench(surge, yaw), &situation(1.0, 0.0));
        prop_assert!((allocation.achieved.yaw_nm - yaw).abs() < 1.0e-6, "yaw comes first");
        if !allocation.surge_saturated {
            prop_assert!((allocation.achieved.surge_n - surge).abs() < 1.0e-6);
        }
    }

    #[test]
    fn a_rudder_gives_what_it_can(yaw in -30.0..30.0f64, surge in 20.0..200.0f64, speed in 1.0..4.0f64) {
        let allocation = settled("skiff", wrench(surge, yaw), &situation(speed, 0.0));
        prop_assert!((allocation.achieved.surge_n - surge).abs() < 1.0e-6);
        prop_assert!((allocation.achieved.yaw_nm - yaw).abs() < 1.0e-6);
        prop_assert!((allocation.achieved.sway_n + yaw / 1.3).abs() < 1.0e-6);
    }

    #[test]
    fn thrust_curve_and_its_inverse_agree(thrust in -66.7..119.7f64, exponent in 1.0..3.0f64) {
        let curve = ThrustCurve { ahead_n: 119.7, astern_n: 66.7, exponent };
        prop_assert!((curve.thrust_n(curve.command(thrust)) - thrust).abs() < 1.0e-9);
    }
}

#[test]
fn steering_right_turns_right() {
    for name in Boat::names() {
        let allocation = settled(name, wrench(10.0, 1.0e-3), &situation(2.0, 0.0));
        assert!(allocation.command.steering > 0.0, "{name}");
        assert!(allocation.achieved.yaw_nm > 0.0, "{name}");
    }
}

#[test]
fn mixed_thrusters_are_left_and_right() {
    // Full right turn at a standstill: left ahead, right astern, as hard as the weaker way allows both.
    let allocation = settled("otter", wrench(0.0, 1.0e3), &situation(0.0, 0.0));
    let Command { throttle, steering } = allocation.command;
    assert!((throttle + steering - 1.0).abs() < 1.0e-9, "left full ahead");
    assert!((throttle - steering + 1.0).abs() < 1.0e-9, "right full astern");
    assert!(allocation.yaw_saturated);
}

#[test]
fn a_slow_rudder_boat_kicks_ahead_to_turn() {
    let still = allocator("monohull38").allocate(0.1, wrench(0.0, 5.0e5), &situation(0.2, 0.1));
    let off = allocator("monohull38").allocate(0.1, wrench(0.0, 5.0e5), &situation(0.2, 1.0));
    assert_eq!(still.command.throttle, 0.0);
    let thrust = 500.0e3 * off.command.throttle.powi(2);
    assert!(thrust > 1.0e4 && thrust <= 0.35 * 500.0e3 + 1.0, "{thrust}");
}

#[test]
fn a_rudder_boat_does_not_go_astern_to_turn() {
    let allocation = allocator("skiff").allocate(0.05, wrench(-100.0, 20.0), &situation(2.0, 1.0));
    assert_eq!(allocation.command.throttle, 0.0);
}

#[test]
fn a_dead_rudder_is_not_divided_by() {
    let allocation = allocator("skiff").allocate(0.05, wrench(0.0, 50.0), &situation(0.0, 0.0));
    assert!(allocation.command.steering.is_finite());
    assert!(allocation.yaw_saturated);
    assert!(allocation.achieved.yaw_nm.abs() < 1.0);
}

#[test]
fn a_rudder_turns_no_faster_than_its_rate() {
    let mut allocator = allocator("monohull38");
    let first = allocator.allocate(0.1, wrench(2.0e5, 4.0e5), &situation(4.0, 0.0));
    assert!(first.yaw_saturated, "the rudder is still on its way");
    assert!(first.achieved.yaw_nm < 0.2 * 4.0e5);
    let last =
        (0..200).map(|_| allocator.allocate(0.1, wrench(2.0e5, 4.0e5), &situation(4.0, 0.0))).last().unwrap();
    assert!(!last.yaw_saturated);
    assert!((last.achieved.yaw_nm - 4.0e5).abs() < 1.0e3);
}

#[test]
fn astern_a_turning_circle_is_steered_the_other_way() {
    let ahead = allocator("motorboat").allocate(0.05, wrench(0.0, 0.3), &situation(2.0, 0.0));
    let astern = allocator("motorboat").allocate(0.05, wrench(0.0, 0.3), &situation(-2.0, 0.0));
    assert!(ahead.command.steering > 0.0);
    assert!((ahead.command.steering + astern.command.steering).abs() < 1.0e-12);
}

#[test]
fn a_turning_circle_is_as_wide_as_measured() {
    // r = 2u/d with d = 1.8 m sin 35° / sin δ: at 5 m/s and full steering 5.56 rad/s.
    let allocation = settled("motorboat", wrench(0.0, 10.0 / 1.8), &situation(5.0, 0.0));
    assert!((allocation.command.steering - 1.0).abs() < 1.0e-3, "{allocation:?}");
    assert!((allocation.achieved.yaw_nm - 10.0 / 1.8).abs() < 1.0e-3);
}
