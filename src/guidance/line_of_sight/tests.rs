use std::f64::consts::PI;

use helmlink_mission::path::{Path, PathLimits};
use proptest::prelude::*;

use super::*;
use crate::control::Boat;
use crate::guidance::tests::{H_S, at, state};
use crate::guidance::{Water, unit};

fn guidance(kind: LineOfSightKind) -> LineOfSight {
    let boat = Boat::embedded("otter").unwrap();
    let gains = match kind {
        LineOfSightKind::Integral => boat.baselines.ilos_pid,
        LineOfSightKind::Adaptive => boat.baselines.alos_pid,
    };
    LineOfSight::new(gains.los, boat.limits, EndOfPath::RunThrough)
}

proptest! {
    #[test]
    fn the_turn_fed_forward_is_the_derivative_of_the_heading_wanted(
        wanted in prop::collection::vec(-PI..PI, 1..60), start in -PI..PI, dt_s in 0.01..0.2f64,
    ) {
        let mut guidance = guidance(LineOfSightKind::Integral);
        guidance.engage(&state(at(0.0, 0.0), start), 0.0);
        for wanted_rad in wanted {
            let before = guidance.heading_rad;
            guidance.refer(dt_s, wanted_rad);
            let moved = ssa(guidance.heading_rad - before) / dt_s;
            prop_assert!((moved - guidance.rate_radps).abs() < 1.0e-9);
            prop_assert!(moved.abs() <= guidance.limits.yaw_rate_max_radps + 1.0e-9);
        }
    }

    /// ALOS: V = ½y² + U/(2γ)(β − β̂)² falls as −U cos β̃ y²/√(Δ² + y²), up to the sine of a small angle.
    #[test]
    fn the_adaptive_law_cancels_its_term(
        right_m in -8.0..8.0f64, drift in -0.3..0.3f64, estimate in -0.3..0.3f64, speed in 0.5..2.0f64,
    ) {
        let mut guidance = guidance(LineOfSightKind::Adaptive);
        guidance.estimate = estimate;
        let ahead_m = guidance.settings.look_ahead_m.max(guidance.settings.look_ahead_s * speed);
        let gamma = guidance.settings.adaptation * speed / (ahead_m * ahead_m);
        let energy = |y: f64, estimate: f64| 0.5 * y * y + 0.5 * speed / gamma * (drift - estimate).powi(2);
        let before = energy(right_m, estimate);
        // The law is asked with the estimate before this step moves it.
        let heading = guidance.clone().angle_rad(0.0, 0.0, right_m, speed);
        guidance.angle_rad(H_S, 0.0, right_m, speed);
        let moved_m = right_m + H_S * speed * (heading + drift).sin();
        let slope = (energy(moved_m, guidance.estimate) - before) / H_S;
        let (off, far) = (drift - estimate, ahead_m.hypot(right_m));
        let expected = speed * right_m * (ahead_m * (off.sin() - off) - right_m * off.cos()) / far;
        prop_assert!((slope - expected).abs() < 1.0e-2 * (1.0 + before), "{slope} {expected}");
    }

    #[test]
    fn the_integral_law_integrates_as_printed(right_m in -8.0..8.0f64, integral in -30.0..30.0f64, speed in 0.5..2.0f64) {
        let mut guidance = guidance(LineOfSightKind::Integral);
        guidance.estimate = integral;
        let ahead_m = guidance.settings.look_ahead_m.max(guidance.settings.look_ahead_s * speed);
        let heading = guidance.angle_rad(H_S, 0.0, right_m, speed);
        // The same with the integrated angle seen from outside: sin and cos of the line of sight.
        prop_assert!((heading.tan() + (right_m + guidance.settings.adaptation * speed * integral) / ahead_m).abs() < 1.0e-9);
        let rate = (guidance.estimate - integral) / H_S;
        prop_assert!((rate - right_m * heading.cos().powi(2) / ahead_m).abs() < 1.0e-6, "{rate}");
    }
}

/// Where a boat that turns at once as wanted ends up beside its line, after a while in a cross current.
fn offset_m(kind: LineOfSightKind, across_mps: f64, adaptation_factor: f64) -> f64 {
    let path = Path::through(&[at(0.0, 0.0), at(2000.0, 0.0)], &PathLimits::new(6.0, 4.0)).unwrap();
    let mut guidance = guidance(kind);
    guidance.settings.adaptation *= adaptation_factor;
    let mut boat = VesselState { sway_mps: 0.0, ..state(at(5.0, 2.0), 0.0) };
    guidance.engage(&boat, 5.0);
    for _ in 0..12_000 {
        let input = GuidanceInput { state: &boat, path: &path, speed_mps: 1.2, water: Water::default() };
        let reference = guidance.step(0.05, &input);
        let bow = unit(reference.heading_rad);
        let velocity = bow * 1.2 + at(0.0, across_mps);
        boat.heading_rad = reference.heading_rad;
        (boat.surge_mps, boat.sway_mps) = (bow.dot(velocity), bow.cross(velocity));
        boat.position += velocity * 0.05;
    }
    boat.position.east_m
}

#[test]
fn a_current_from_either_side_leaves_no_offset_and_the_wrong_sign_does() {
    for kind in [LineOfSightKind::Integral, LineOfSightKind::Adaptive] {
        for across_mps in [0.3, -0.3] {
            let (right, still, wrong) = (
                offset_m(kind, across_mps, 1.0),
                offset_m(kind, across_mps, 0.0),
                offset_m(kind, across_mps, -1.0),
            );
            assert!(right.abs() < 0.02, "{kind:?} {across_mps}: {right}");
            assert!(still * across_mps > 0.0 && still.abs() > 0.3, "{kind:?} {across_mps}: {still}");
            assert!(wrong.abs() > 2.0 * still.abs(), "{kind:?} {across_mps}: {wrong}");
        }
    }
}
