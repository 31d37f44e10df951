//! Every kinematic formula against finite differences, and the corners where formulas go wrong.

use std::f64::consts::{FRAC_PI_2, PI};

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::{Path, PathLimits};
use proptest::prelude::*;

use super::azimuth::{azimuth, chord_bias};
use super::drift::DriftEstimator;
use super::progress::{foot_speed_mps, project};
use super::speed::SpeedLimits;
use super::virtual_ship::VirtualShip;
use super::*;
use crate::control::{Boat, Helm};

/// Step of the central differences, s.
pub(super) const H_S: f64 = 1.0e-4;

pub(super) fn at(north_m: f64, east_m: f64) -> NorthEast {
    NorthEast { north_m, east_m }
}

pub(super) fn bent_path() -> Path {
    Path::through(&[at(0.0, 0.0), at(0.0, 40.0), at(30.0, 40.0), at(60.0, 10.0)], &PathLimits::new(6.0, 4.0))
        .unwrap()
}

pub(super) fn state(position: NorthEast, heading_rad: f64) -> VesselState {
    VesselState { position, heading_rad, surge_mps: 1.2, sway_mps: 0.1, yaw_rate_radps: 0.0 }
}

pub(super) fn rate(before: f64, after: f64) -> f64 {
    ssa(after - before) / (2.0 * H_S)
}

proptest! {
    #[test]
    fn azimuth_rate_is_its_derivative(
        north in -6.0..6.0f64, east in -6.0..6.0f64, heading in -PI..PI, sway in -0.5..0.5f64,
        ship_m in 5.0..90.0f64, ship_mps in 0.0..2.0f64,
    ) {
        let path = bent_path();
        let boat = path.point(ship_m).position + at(north, east);
        let velocity = VesselState { sway_mps: sway, ..state(boat, heading) }.ground_velocity();
        let angle = |t: f64| azimuth(boat + velocity * t, velocity, &path.point(ship_m + ship_mps * t), ship_mps, 1.3);
        // Inside the blend the aim can pass through zero, where no direction has a derivative; on its edge the
        // rate jumps, and a difference across it sees both sides.
        let distance = at(north, east).norm();
        prop_assume!(distance > 0.1 && angle(0.0).radps.abs() < 20.0 && (distance - 1.3).abs() > 5.0 * H_S);
        let measured = rate(angle(-H_S).rad, angle(H_S).rad);
        prop_assert!((measured - angle(0.0).radps).abs() < 1.0e-3 * (1.0 + measured.powi(2)), "{measured} {:?}", angle(0.0));
    }

    #[test]
    fn far_from_the_ship_the_rate_is_the_printed_kinematics(
        distance in 2.0..30.0f64, bearing in -PI..PI, heading in -PI..PI, ship_mps in 0.0..2.0f64,
    ) {
        let path = bent_path();
        let ship = path.point(50.0);
        let boat = state(ship.position - unit(bearing) * distance, heading);
        let angle = azimuth(boat.position, boat.ground_velocity(), &ship, ship_mps, 1.3);
        let (u, v) = (boat.surge_mps, boat.sway_mps);
        let error = angle.rad - heading;
        let printed = (ship_mps * (ship.heading_rad - angle.rad).sin() + u * error.sin() - v * error.cos()) / distance;
        prop_assert!((printed - angle.radps).abs() < 1.0e-9);
    }

    #[test]
    fn distance_rate_is_the_printed_kinematics(
        distance in 2.0..30.0f64, bearing in -PI..PI, heading in -PI..PI, ship_mps in 0.0..2.0f64,
    ) {
        let path = bent_path();
        let boat = state(path.point(20.0).position - unit(bearing) * distance, heading);
        let velocity = boat.ground_velocity();
        let z = |t: f64| (path.point(20.0 + ship_mps * t).position - boat.position - velocity * t).norm();
        let ship = path.point(20.0);
        let error = bearing - heading;
        let printed = ship_mps * (bearing - ship.heading_rad).cos()
            - boat.surge_mps * error.cos() - boat.sway_mps * error.sin();
        prop_assert!(((z(H_S) - z(-H_S)) / (2.0 * H_S) - printed).abs() < 1.0e-5);
    }

    #[test]
    fn chord_bias_rate_is_its_derivative(
        foot_m in 2.0..90.0f64, lead_m in 1.0..6.0f64, foot_mps in -0.5..2.0f64, ship_mps in 0.0..2.0f64,
    ) {
        let path = bent_path();
        let bias = |t: f64| chord_bias(
            &path.point(foot_m + foot_mps * t), foot_mps, &path.point(foot_m + lead_m + ship_mps * t), ship_mps,
        );
        let measured = rate(bias(-H_S).rad, bias(H_S).rad);
        prop_assert!((measured - bias(0.0).radps).abs() < 1.0e-3, "{measured} {:?}", bias(0.0));
    }

    #[test]
    fn foot_speed_is_the_derivative_of_progress(
        along_m in 5.0..90.0f64, offset_m in -3.0..3.0f64, heading in -PI..PI,
    ) {
        let path = bent_path();
        let foot = path.point(along_m);
        let position = foot.position + unit(foot.heading_rad + FRAC_PI_2) * offset_m;
        let velocity = state(position, heading).ground_velocity();
        let here = project(&path, position, along_m);
        let s = |t: f64| project(&path, position + velocity * t, along_m).progress_m;
        let measured = (s(H_S) - s(-H_S)) / (2.0 * H_S);
        prop_assert!((measured - foot_speed_mps(&here, velocity)).abs() < 1.0e-3);
        prop_assert!((here.cross_track_m - offset_m).abs() < 1.0e-6);
    }

    #[test]
    fn the_lead_stays_within_its_limits(speeds in prop::collection::vec(-1.0..4.0f64, 1..300)) {
        let (mut ship, mut boat_m) = (VirtualShip::at(0.0), 0.0);
        for boat_mps in speeds {
            boat_m += boat_mps * 0.05;
            ship.step(0.05, boat_m, boat_mps, 1.4, 4.0, 10.0);
            let lead = ship.progress_m() - boat_m;
            prop_assert!((3.2 - 1.0e-9..=6.4 + 1.0e-9).contains(&lead), "{lead}");
        }
    }

    #[test]
    fn a_reference_is_finite_from_anywhere(
        north in -500.0..500.0f64, east in -500.0..500.0f64, heading in -10.0..10.0f64,
        surge in -3.0..3.0f64, sway in -3.0..3.0f64, start_m in 0.0..90.0f64,
    ) {
        let (path, boat) = (bent_path(), Boat::embedded("otter").unwrap());
        let mut helm = Helm::new(&boat, EndOfPath::Stop);
        let state = VesselState {
            position: at(north, east), heading_rad: heading, surge_mps: surge, sway_mps: sway, yaw_rate_radps: 0.0,
        };
        helm.engage(&state, start_m).unwrap();
        let output = helm.step(0.05, &state, &path, 1.4).unwrap();
        let reference = output.diagnostics.reference;
        prop_assert!(reference.heading_rad.is_finite() && reference.heading_rate_radps.is_finite());
        prop_assert!((0.0..=2.5 + 4.0).contains(&reference.speed_mps));
    }
}

#[test]
fn azimuth_is_right_on_the_axes_where_the_printed_formula_is_not() {
    let ship = |north_m, east_m| helmlink_mission::path::PathPoint {
        position: at(north_m, east_m),
        heading_rad: 0.3,
        tangent: unit(0.3),
        curvature_radpm: 0.0,
    };
    let azimuth_of =
        |north_m, east_m| azimuth(at(0.0, 0.0), at(0.0, 0.0), &ship(north_m, east_m), 0.0, 0.3).rad;
    assert!((azimuth_of(0.0, 5.0) - FRAC_PI_2).abs() < 1.0e-12);
    assert!((azimuth_of(0.0, -5.0) + FRAC_PI_2).abs() < 1.0e-12);
    assert!((azimuth_of(-5.0, 0.0).abs() - PI).abs() < 1.0e-12);
    assert!(azimuth_of(5.0, 0.0).abs() < 1.0e-12);
    // On top of the virtual ship: its own direction.
    assert!((azimuth_of(0.0, 0.0) - 0.3).abs() < 1.0e-12);
}

#[test]
fn on_the_path_the_course_wanted_is_the_path() {
    let path = bent_path();
    for along_m in [5.0, 33.0, 36.0, 40.0, 65.0] {
        let (foot, ship) = (path.point(along_m), path.point(along_m + 4.0));
        let velocity = unit(foot.heading_rad) * 1.2;
        let aim = azimuth(foot.position, velocity, &ship, 1.3, 1.3);
        let bias = chord_bias(&foot, 1.2, &ship, 1.3);
        assert!(ssa(aim.rad - bias.rad - foot.heading_rad).abs() < 1.0e-12, "{along_m}");
        assert!((aim.radps - bias.radps - foot.curvature_radpm * 1.2).abs() < 1.0e-12, "{along_m}");
    }
}

#[test]
fn the_drift_estimate_learns_the_current_from_two_legs() {
    let current = at(0.2, -0.25);
    let mut drift = DriftEstimator::default();
    for heading_rad in [0.4, 0.4 + FRAC_PI_2] {
        for _ in 0..400 {
            let sway_mps = unit(heading_rad).cross(current) + 0.05;
            let state = VesselState { sway_mps, ..state(at(0.0, 0.0), heading_rad) };
            drift.step(0.05, &state, 0.05, 0.9);
        }
    }
    assert!((drift.current() - current).norm() < 1.0e-6, "{:?}", drift.current());
}

proptest! {
    #[test]
    fn the_drift_estimate_never_moves_away_from_the_current(
        heading in -PI..PI, north in -1.0..1.0f64, east in -1.0..1.0f64,
        first_north in -1.0..1.0f64, first_east in -1.0..1.0f64, dt_s in 1.0e-4..0.5f64, model_mps in -0.3..0.3f64,
    ) {
        let current = at(north, east);
        let boat = |current: NorthEast| VesselState {
            sway_mps: unit(heading).cross(current) + model_mps, ..state(at(0.0, 0.0), heading)
        };
        // Two starts at right angles give any first estimate.
        let mut drift = DriftEstimator::starting_at(&boat(at(first_north, first_east)));
        let (before, across) = (drift.current() - current, unit(heading).cross(drift.current() - current));
        drift.step(dt_s, &boat(current), model_mps, 0.9);
        let after = drift.current() - current;
        prop_assert!(after.norm() <= before.norm() + 1.0e-12);
        // Across the bow the error dies with the time constant, along it nothing is known.
        let left = across * (-dt_s / 0.9).exp();
        prop_assert!((unit(heading).cross(after) - left).abs() < 1.0e-9);
        prop_assert!((unit(heading).dot(after) - unit(heading).dot(before)).abs() < 1.0e-9);
    }
}

fn limits() -> SpeedLimits {
    SpeedLimits {
        turn_rate_radps: 0.2,
        lateral_acceleration_mps2: 0.5,
        deceleration_mps2: 0.15,
        creep_mps: 0.2,
    }
}

#[test]
fn the_speed_falls_before_a_bend_and_before_the_end() {
    let path = bent_path();
    let calm = at(0.0, 0.0);
    let speed = |s, end| limits().speed_mps(&path, s, 1.4, calm, end);
    assert_eq!(speed(5.0, EndOfPath::Stop), 1.4);
    let bend_m = path.waypoint_s_m(1);
    let tightest = path.point(bend_m).curvature_radpm;
    assert!((speed(bend_m, EndOfPath::Stop) - 0.2 / tightest.abs()).abs() < 1.0e-9);
    assert!(speed(bend_m - 3.5, EndOfPath::Stop) < 1.4);
    let near_end_m = path.length_m() - 1.0;
    assert!((speed(near_end_m, EndOfPath::Stop) - 0.3f64.sqrt()).abs() < 1.0e-9);
    assert_eq!(speed(near_end_m, EndOfPath::RunThrough), 1.4);
    assert_eq!(speed(path.length_m(), EndOfPath::Stop), 0.2);
}

#[test]
fn the_speed_of_a_bend_keeps_the_bow_to_its_yaw_rate_in_a_current() {
    let path = bent_path();
    let bend_m = path.waypoint_s_m(1);
    let place = path.point(bend_m);
    for along_mps in [-0.4, -0.1, 0.1, 0.25] {
        let current = unit(place.heading_rad) * along_mps;
        let v = limits().speed_mps(&path, bend_m, 3.0, current, EndOfPath::RunThrough);
        let yaw_rate = place.curvature_radpm.abs() * v * v / (v - along_mps);
        assert!(yaw_rate <= 0.2 + 1.0e-9, "{along_mps}: {yaw_rate}");
    }
}
