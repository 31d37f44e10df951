use helmlink_mission::plan::Mission;
use helmlink_mission::route::Route;
use helmlink_sitl::physics::{ActuatorCommand, Hull, Pose, Sea, SensorSettings, Vessel};

use super::*;
use crate::control::Controller;
use crate::simulation::{Perturbation, Trial};
use crate::vehicle::OutputKind;

/// What an owner would measure: one run along a line at full throttle, one circle at half throttle.
fn measured(hull: &Hull) -> Particulars {
    let command = |throttle: f64, steering: f64| {
        if hull.has_twin_thrusters() {
            ActuatorCommand::TwinThrusters { left: throttle + steering, right: throttle - steering }
        } else {
            ActuatorCommand::ThrottleSteering { throttle, steering }
        }
    };
    let run = |throttle: f64, steering: f64| {
        let (sea, sensors) = (Sea::default(), SensorSettings::perfect());
        let mut vessel = Vessel::new(hull.clone(), &sea, &sensors, 1, Pose::default());
        vessel.step(60.0, command(throttle, steering));
        let state = vessel.truth().hull;
        (state.u_mps.hypot(state.v_mps), state.r_radps)
    };
    let (top_speed_mps, _) = run(1.0, 0.0);
    let (speed_mps, rate_radps) = run(0.5, if hull.has_twin_thrusters() { 0.4 } else { 1.0 });
    Particulars {
        length_m: hull.length_m,
        top_speed_mps,
        turning_circle_m: 2.0 * speed_mps / rate_radps,
        delay_s: 0.1,
    }
}

/// A run of a boat by rule on this hull.
fn trial(hull: &Hull, particulars: &Particulars) -> Trial {
    let mission: Mission = include_str!("../../../../mission/plans/arcs-otter.waypoints").parse().unwrap();
    Trial {
        boat: Boat::derived("by-rule", particulars).unwrap(),
        controller: Controller::PiSmc,
        output: OutputKind::RcOverride,
        speed_mps: Some(1.2),
        interval_s: 0.04,
        sea: Sea { current: Some("0.2@40".parse().unwrap()), ..Sea::default() },
        sensors: SensorSettings::typical(),
        seed: 21,
        delay_s: 0.0,
        home: mission.home.unwrap(),
        heading_rad: 0.0,
        route: Route::from_mission(&mission).unwrap(),
        mission,
        hull: hull.clone(),
    }
}

/// Total variation of its steering per minute.
fn steering_per_min(trial: &Trial) -> f64 {
    trial.run().unwrap().score.unwrap().steering_variation_per_min
}

#[test]
fn a_boat_by_rule_does_not_ring_at_any_rate_of_its_telemetry() {
    for name in ["otter", "skiff"] {
        let hull = Hull::builtin(name).unwrap();
        for interval_s in [0.04, 0.1, 0.2] {
            let trial = Trial { interval_s, ..trial(&hull, &measured(&hull)) };
            let steering = steering_per_min(&trial);
            println!("{name} every {interval_s} s: {steering:.1} per minute");
            assert!(steering < 12.0, "{name} every {interval_s} s: {steering}");
        }
    }
}

/// Root mean square of its distance from the path, m; infinite where it does not arrive.
fn error_m(hull: &Hull, particulars: &Particulars) -> f64 {
    let outcome = trial(hull, particulars).run().unwrap();
    let spread = outcome.score.and_then(|score| score.path_error_m).filter(|_| outcome.completed);
    spread.map_or(f64::INFINITY, |spread| spread.rms)
}

#[test]
fn a_boat_by_rule_drives_hulls_that_the_rule_was_not_made_for() {
    for (name, change, lengths) in [
        ("otter", Perturbation::Nominal, 0.25),
        ("skiff", Perturbation::Nominal, 0.25),
        // Half as heavy again, and a slippery one: other boats altogether.
        ("skiff", Perturbation::Mass(1.5), 0.35),
        ("otter", Perturbation::Damping(0.6), 0.25),
        ("motorboat", Perturbation::Nominal, 0.25),
    ] {
        let nominal = Hull::builtin(name).unwrap();
        let mut changed = trial(&nominal, &measured(&nominal));
        change.apply(&mut changed);
        let hull = changed.hull;
        let right = measured(&hull);
        let error_m = error_m(&hull, &right);
        println!("{name} {change}: {right:?}, {error_m:.3} m");
        assert!(error_m < lengths * hull.length_m, "{name} {change}: {error_m} m by {right:?}");
    }
}

#[test]
fn a_boat_by_rule_from_wrong_figures_does_not() {
    let hull = Hull::builtin("skiff").unwrap();
    let right = measured(&hull);
    for wrong in [
        Particulars { turning_circle_m: 0.2 * right.turning_circle_m, ..right },
        Particulars { top_speed_mps: 5.0 * right.top_speed_mps, ..right },
    ] {
        let error_m = error_m(&hull, &wrong);
        println!("{wrong:?}: {error_m:.3} m");
        assert!(error_m > 0.25 * hull.length_m, "{wrong:?}: {error_m} m");
    }
}

#[test]
fn boats_of_any_size_are_within_the_ranges() {
    for length_m in [0.5, 2.0, 8.0, 38.0, 120.0] {
        for delay_s in [0.0, 0.3, 2.0] {
            let particulars = Particulars {
                length_m,
                top_speed_mps: 1.5 * f64::sqrt(length_m),
                turning_circle_m: 4.0 * length_m,
                delay_s,
            };
            Boat::derived("any", &particulars).unwrap();
        }
    }
}

#[test]
fn what_makes_no_sense_is_named() {
    let good = Particulars { length_m: 3.0, top_speed_mps: 3.0, turning_circle_m: 10.0, delay_s: 0.2 };
    for (bad, named) in [
        (Particulars { length_m: f64::NAN, ..good }, "length"),
        (Particulars { top_speed_mps: 0.0, ..good }, "top-speed"),
        (Particulars { turning_circle_m: -1.0, ..good }, "turning-circle"),
        (Particulars { delay_s: 9.0, ..good }, "delay"),
    ] {
        assert!(Boat::derived("bad", &bad).unwrap_err().to_string().contains(named));
    }
}
