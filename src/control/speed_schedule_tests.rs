//! Steering at all speeds: a rudder's force grows with the square of the flow past it, and dies with it.

use std::f64::consts::FRAC_PI_2;

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::{Path, PathLimits};

use super::boat::Actuators;
use super::testing::{Noise, Plant, Report, Run};
use super::{Boat, Helm};
use crate::guidance::EndOfPath;

/// Boats whose steering works by flow, the scale of their path, and their nominal speed.
const BOATS: [(&str, f64, f64); 3] = [("monohull38", 7.0, 4.0), ("motorboat", 1.5, 2.0), ("skiff", 1.5, 2.0)];

fn path(boat: &Boat, scale: f64) -> Path {
    let points = [(0.0, 0.0), (0.0, 200.0), (150.0, 200.0), (150.0, 0.0)]
        .map(|(north_m, east_m)| NorthEast { north_m: scale * north_m, east_m: scale * east_m });
    let radius_m = boat.limits.turn_radius_m;
    Path::through(&points, &PathLimits::new(radius_m, 0.75 * radius_m)).unwrap()
}

/// A run of `boat` as its controller believes it to be, on the plant of `truth`.
fn run(boat: &Boat, truth: &Boat, scale: f64, speed_mps: f64) -> Report {
    let across = NorthEast { north_m: 0.1 * speed_mps, east_m: 0.0 };
    let mut plant = Plant::of(truth).under_way(FRAC_PI_2, speed_mps, across);
    Run::new(boat, &path(boat, scale), speed_mps).run(&mut plant)
}

#[test]
fn steering_is_as_steady_at_a_quarter_as_at_one_and_a_half_times_the_speed() {
    for (name, scale, nominal_mps) in BOATS {
        let boat = Boat::embedded(name).unwrap();
        for part in [0.25, 0.5, 1.0, 1.5] {
            // The 38 m ship's model ends at one and a quarter.
            let speed_mps = (part * nominal_mps).min(boat.limits.speed_max_mps);
            let report = run(&boat, &boat, scale, speed_mps);
            println!("{name} at {speed_mps} m/s: {report:.4?}");
            assert!(report.finished, "{name} {speed_mps}: {report:?}");
            assert!(report.path_rms_m < 0.06 * boat.guidance.lead_m, "{name} {speed_mps}: {report:?}");
            assert!(report.settled_rms_m < 0.02 * boat.guidance.lead_m, "{name} {speed_mps}: {report:?}");
            // A limit cycle would move the rudder without end.
            assert!(report.settled_steering_per_min < 0.5, "{name} {speed_mps}: {report:?}");
            assert!(report.steering_per_min < 10.0, "{name} {speed_mps}: {report:?}");
        }
    }
}

#[test]
fn without_the_schedule_a_slow_ship_is_lost() {
    let (name, scale, nominal_mps) = BOATS[0];
    let truth = Boat::embedded(name).unwrap();
    let speed_mps = 0.35 * nominal_mps;
    // A controller that takes its rudder to be as strong as at the nominal speed, whatever the speed.
    let mut unaware = truth.clone();
    let Actuators::PropellerRudder(rudder) = &mut unaware.actuators else { panic!("{name}") };
    rudder.rudder_gain *= (nominal_mps / speed_mps).powi(2);
    let (aware, unaware) = (run(&truth, &truth, scale, speed_mps), run(&unaware, &truth, scale, speed_mps));
    assert!(unaware.path_rms_m > 3.0 * aware.path_rms_m, "with {aware:?}, without {unaware:?}");
}

/// Total variation of the steering in a minute of a boat made fast at a standstill, its sensors noisy.
fn at_rest(boat: &Boat, turn_noise: f64, wanted_mps: f64) -> f64 {
    let path = path(boat, 1.0);
    let plant = Plant::of(boat).under_way(FRAC_PI_2, 0.0, NorthEast::ZERO);
    let mut helm = Helm::new(boat, EndOfPath::Stop);
    helm.engage(&plant.state(), 0.0).unwrap();
    let mut noise = Noise::seeded(3);
    // A large boat's compass and gyro are read through a slower filter; no velocity jumps from tick to tick.
    (noise.turn, noise.speed) = (turn_noise, 0.1);
    let (mut variation, mut last) = (0.0, None);
    for _ in 0..1200 {
        let state = noise.disturb(0.05, plant.state());
        let command = helm.step(0.05, &state, &path, wanted_mps).unwrap().command;
        variation += last.map_or(0.0, |last: f64| (command.steering - last).abs());
        last = Some(command.steering);
    }
    variation
}

#[test]
fn a_boat_at_rest_leaves_its_rudder_alone() {
    // The ship's propeller holds against its moorings, and its rudder answers noise in that weak stream: a weakness,
    // kept within a bound.
    for (name, turn_noise, most) in
        [("monohull38", 0.014, 150.0), ("motorboat", 1.0, 5.0), ("skiff", 1.0, 60.0)]
    {
        let boat = Boat::embedded(name).unwrap();
        for wanted_mps in [0.0, boat.limits.cruise_mps] {
            let variation = at_rest(&boat, turn_noise, wanted_mps);
            println!("{name}, {wanted_mps} m/s wanted: {variation:.1} per minute");
            assert!(variation < most, "{name} {wanted_mps}: {variation}");
        }
    }
}
