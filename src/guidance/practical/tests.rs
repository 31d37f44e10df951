//! What is fed forward against what really happens to the reference.

use std::f64::consts::PI;

use helmlink_mission::path::{Path, PathLimits};
use proptest::prelude::*;

use super::*;
use crate::control::Boat;
use crate::guidance::Water;
use crate::guidance::tests::{H_S, at, bent_path, state};

fn guidance(change: impl FnOnce(&mut Boat)) -> Practical {
    let mut boat = Boat::embedded("otter").unwrap();
    change(&mut boat);
    Practical::new(boat.guidance, boat.limits, boat.hull, EndOfPath::RunThrough)
}

/// Guidance whose reference is the geometry alone: no preview, and a hull that does not skid.
fn geometry() -> Practical {
    guidance(|boat| {
        boat.guidance.preview_s = 0.0;
        boat.hull.sway_damping = [1.0e9, 0.0, 0.0];
    })
}

fn look(guidance: &mut Practical, path: &Path, state: &VesselState, water: Water) -> Reference {
    guidance.step(H_S, &GuidanceInput { state, path, speed_mps: 1.2, water })
}

proptest! {
    #[test]
    fn the_turn_fed_forward_is_the_derivative_of_the_heading_wanted(
        along_m in 5.0..90.0f64, right_m in -3.0..3.0f64, off in -1.2..1.2f64, sway in -0.3..0.3f64,
    ) {
        let path = bent_path();
        let foot = path.point(along_m);
        let start = VesselState {
            sway_mps: sway,
            ..state(foot.position + unit(foot.heading_rad + 0.5 * PI) * right_m, foot.heading_rad + off)
        };
        let mut guidance = geometry();
        guidance.engage(&start, along_m);
        let seen: Vec<Reference> = (0..3)
            .map(|tick| {
                let position = start.position + start.ground_velocity() * (f64::from(tick) * H_S);
                look(&mut guidance, &path, &VesselState { position, ..start }, Water::default())
            })
            .collect();
        let measured = ssa(seen[2].heading_rad - seen[0].heading_rad) / (2.0 * H_S);
        let fed = seen[1].heading_rate_radps;
        prop_assert!((measured - fed).abs() < 2.0e-3 * (1.0 + measured.powi(2)), "{measured} {fed}");
    }

    #[test]
    fn the_planned_drift_fed_forward_is_the_derivative_of_its_angle(
        surge in 0.4..2.0f64, sway_excess in -0.6..1.0f64, turns in prop::collection::vec(-0.4..0.4f64, 1..40),
    ) {
        let mut guidance = guidance(|_| ());
        let boat = VesselState { surge_mps: surge, ..state(at(0.0, 0.0), 0.3) };
        let (path, water) = (bent_path(), Water { sway_excess, ..Water::default() });
        let input = GuidanceInput { state: &boat, path: &path, speed_mps: 1.2, water };
        for turn_radps in turns {
            for _ in 0..200 {
                guidance.planned_drift_radps(0.01, &input, turn_radps);
            }
            let angle = |guidance: &Practical| ((1.0 + sway_excess) * guidance.planned_sway.sway_mps()).atan2(surge);
            let before = angle(&guidance);
            let fed = guidance.planned_drift_radps(H_S, &input, -turn_radps);
            let after = angle(&guidance);
            prop_assert!(((after - before) / H_S - fed).abs() < 1.0e-3, "{fed}");
        }
    }

    #[test]
    fn yaw_per_course_is_how_a_boat_in_a_current_really_turns(
        heading in -PI..PI, through_water in 0.8..2.0f64, north in -0.4..0.4f64, east in -0.4..0.4f64,
    ) {
        let current = at(north, east);
        let course = |heading_rad: f64| (unit(heading_rad) * through_water + current).bearing_rad();
        let surge_mps = through_water + unit(heading).dot(current);
        prop_assume!(surge_mps > LEAST_DRIFT_SPEED_MPS);
        let boat = VesselState { surge_mps, ..state(at(0.0, 0.0), heading) };
        let path = bent_path();
        let water = Water { current, ..Water::default() };
        let input = GuidanceInput { state: &boat, path: &path, speed_mps: 1.2, water };
        let drift = guidance(|_| ()).drift(H_S, &input, unit(input.state.heading_rad));
        let course_per_yaw = ssa(course(heading + H_S) - course(heading - H_S)) / (2.0 * H_S);
        let (least, most) = YAW_PER_COURSE;
        prop_assert!((drift.yaw_per_course - (1.0 / course_per_yaw).clamp(least, most)).abs() < 1.0e-5);
        // The drift angle is what lies between heading and course.
        prop_assert!((ssa(heading + drift.angle_rad) - course(heading)).abs() < 1.0e-9);
    }

    #[test]
    fn the_speed_wanted_makes_the_error_of_the_lead_die_away(
        off in -0.3..0.3f64, sway in -0.1..0.1f64, lead_part in 0.85..1.5f64, right_m in -1.0..1.0f64,
    ) {
        let path = Path::through(&[at(0.0, 0.0), at(400.0, 0.0)], &PathLimits::new(6.0, 4.0)).unwrap();
        let mut guidance = guidance(|_| ());
        let boat = VesselState { sway_mps: sway, ..state(at(100.0, right_m), off) };
        let lead_m = guidance.settings.lead_at_m(1.2);
        guidance.ship = VirtualShip::at(100.0 + lead_part * lead_m);
        guidance.progress_m = 100.0;
        let reference = look(&mut guidance, &path, &boat, Water { sway_mps: sway, ..Water::default() });
        let driven = VesselState { surge_mps: reference.speed_mps, ..boat };
        let lead_rate = guidance.ship.speed_mps() - driven.ground_velocity().north_m;
        let slope = 1.2 / guidance.settings.lead_softness_m;
        let wanted = -slope * (reference.lead_m - lead_m);
        prop_assert!((lead_rate - wanted).abs() < 1.0e-3, "{lead_rate} {wanted}");
    }
}

#[test]
fn the_crab_angle_of_a_boat_that_slows_down_is_fed_forward() {
    let path = bent_path();
    let mut guidance = guidance(|_| ());
    let water = Water { current: at(0.0, 0.3), ..Water::default() };
    let mut look = |time_s: f64| {
        let boat = VesselState { surge_mps: 1.4 - 0.05 * time_s, ..state(at(0.0, 0.0), 0.0) };
        guidance.drift(
            0.01,
            &GuidanceInput { state: &boat, path: &path, speed_mps: 1.2, water },
            unit(boat.heading_rad),
        )
    };
    for tick in 0..1000 {
        look(0.01 * f64::from(tick));
    }
    let (before, after) = (look(10.0), look(10.01));
    let measured = (after.angle_rad - before.angle_rad) / 0.01;
    assert!(measured > 0.005, "slower, the same current drifts it more: {measured}");
    assert!((measured - after.slowing_radps).abs() < 0.02 * measured, "{measured} {}", after.slowing_radps);
}

#[test]
fn the_path_is_previewed_on_its_own_side() {
    // Ahead of a turn to the right the preview turns right, ahead of its end it turns back.
    let path = bent_path();
    let mut guidance = guidance(|boat| boat.guidance.preview_s = 2.0);
    let mut look = |along_m: f64| {
        let here = project(&path, path.point(along_m).position, along_m);
        guidance.progress_m = along_m;
        guidance.preview_radps(&path, &here, 1.2)
    };
    let bend_m = path.waypoint_s_m(1);
    let turn = path.point(bend_m).curvature_radpm.signum();
    let entering = (0..200).map(|i| look(bend_m - 0.05 * f64::from(i)) * turn).fold(0.0, f64::max);
    let leaving = (0..200).map(|i| look(bend_m + 0.05 * f64::from(i)) * turn).fold(0.0, f64::min);
    assert!(entering > 0.05 && leaving < -0.05, "{entering} {leaving}");
}
