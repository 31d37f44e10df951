use std::f64::consts::{FRAC_PI_2, PI};

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::{Path, PathLimits};
use proptest::prelude::*;

use super::*;

fn at(north_m: f64, east_m: f64) -> NorthEast {
    NorthEast { north_m, east_m }
}

fn path() -> Path {
    Path::through(&[at(0.0, 0.0), at(0.0, 100.0)], &PathLimits::new(4.0, 3.0)).unwrap()
}

fn state(position: NorthEast, heading_rad: f64) -> VesselState {
    VesselState { position, heading_rad, surge_mps: 1.0, sway_mps: 0.0, yaw_rate_radps: 0.0 }
}

fn helm() -> Helm {
    Helm::new(&Boat::embedded("otter").unwrap(), EndOfPath::Stop)
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let (path, good) = (path(), state(at(1.0, 5.0), 1.0));
    let (mut disturbed, mut calm) = (helm(), helm());
    disturbed.engage(&good, 0.0).unwrap();
    calm.engage(&good, 0.0).unwrap();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0e300] {
        let states = [
            VesselState { position: at(bad, 0.0), ..good },
            VesselState { position: at(0.0, bad), ..good },
            VesselState { heading_rad: bad, ..good },
            VesselState { surge_mps: bad, ..good },
            VesselState { sway_mps: bad, ..good },
            VesselState { yaw_rate_radps: bad, ..good },
        ];
        for state in states {
            assert!(matches!(disturbed.step(0.05, &state, &path, 1.0), Err(HelmError::State(_))));
            assert!(matches!(disturbed.engage(&state, 0.0), Err(HelmError::State(_))));
        }
        assert!(matches!(disturbed.step(bad, &good, &path, 1.0), Err(HelmError::Step { .. })));
        assert!(matches!(disturbed.step(0.05, &good, &path, bad), Err(HelmError::Speed { .. })));
        assert!(matches!(disturbed.engage(&good, bad), Err(HelmError::Progress { .. })) || bad == 1.0e300);
    }
    for dt_s in [0.0, -0.05, 1.5] {
        assert!(matches!(disturbed.step(dt_s, &good, &path, 1.0), Err(HelmError::Step { .. })));
    }
    for speed_mps in [-0.1, 2.6] {
        assert!(matches!(disturbed.step(0.05, &good, &path, speed_mps), Err(HelmError::Speed { .. })));
    }
    disturbed.engage(&good, 0.0).unwrap();
    assert_eq!(disturbed.step(0.05, &good, &path, 1.0), calm.step(0.05, &good, &path, 1.0));
}

proptest! {
    /// Whatever is not a number, in whichever field and at whatever moment: no controller gives anything for it, and
    /// none remembers it.
    #[test]
    fn what_is_not_a_number_leaves_no_trace_in_any_controller(
        field in 0..8usize, moment in 1..40u32, sway in -0.3..0.3f64, rate in -0.2..0.2f64, delay_s in 0.0..0.6f64,
        bad in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ) {
        let (boat, path) = (Boat::embedded("otter").unwrap(), path());
        for controller in Controller::ALL {
            let mut disturbed = Helm::with_controller(&boat, controller, EndOfPath::Stop);
            let mut calm = Helm::with_controller(&boat, controller, EndOfPath::Stop);
            for helm in [&mut disturbed, &mut calm] {
                helm.set_delay_s(delay_s);
                helm.engage(&state(at(1.0, 5.0), 1.0), 0.0).unwrap();
            }
            for tick in 0..60 {
                let good = VesselState {
                    sway_mps: sway,
                    yaw_rate_radps: rate,
                    ..state(at(1.0, 5.0 + 0.05 * f64::from(tick)), 1.0 + 0.05 * rate * f64::from(tick))
                };
                if tick == moment {
                    let (mut lost, mut dt_s, mut speed_mps) = (good, 0.05, 1.2);
                    *[
                        &mut lost.position.north_m, &mut lost.position.east_m, &mut lost.heading_rad, &mut lost.surge_mps,
                        &mut lost.sway_mps, &mut lost.yaw_rate_radps, &mut dt_s, &mut speed_mps,
                    ][field] = bad;
                    prop_assert!(disturbed.step(dt_s, &lost, &path, speed_mps).is_err(), "{controller}");
                }
                let output = disturbed.step(0.05, &good, &path, 1.2).unwrap();
                prop_assert!(output.command.throttle.is_finite() && output.command.steering.is_finite());
                prop_assert_eq!(output, calm.step(0.05, &good, &path, 1.2).unwrap(), "{}", controller);
            }
        }
    }
}

#[test]
fn errors_name_the_quantity_and_what_to_do() {
    let mut helm = helm();
    let bad = VesselState { sway_mps: f64::NAN, ..state(at(0.0, 0.0), 0.0) };
    let text = helm.engage(&bad, 0.0).unwrap_err().to_string();
    assert!(text.contains("sway speed") && text.contains("neutral"), "{text}");
    let text = helm.step(3.0, &state(at(0.0, 0.0), 0.0), &path(), 1.0).unwrap_err().to_string();
    assert!(text.contains("3 s") && text.contains("engage again"), "{text}");
}

#[test]
fn steps_are_reproducible() {
    let path = path();
    let run = || {
        let mut helm = helm();
        helm.engage(&state(at(3.0, 0.0), 1.0), 0.0).unwrap();
        (0..200)
            .map(|i| {
                helm.step(
                    0.02 + 0.001 * f64::from(i % 30),
                    &state(at(3.0, 0.05 * f64::from(i)), 1.0),
                    &path,
                    1.2,
                )
            })
            .map(|output| output.unwrap().command)
            .collect::<Vec<_>>()
    };
    assert_eq!(run(), run());
}

#[test]
fn every_heading_gives_a_finite_command_and_a_turn_the_short_way() {
    let path = path();
    for (error_rad, least, most) in
        [(FRAC_PI_2, 0.3, 1.0), (-FRAC_PI_2, -1.0, -0.3), (PI, -1.0, 1.0), (-PI, -1.0, 1.0)]
    {
        let mut helm = helm();
        let state = state(at(0.0, 20.0), FRAC_PI_2 - error_rad);
        helm.engage(&state, 20.0).unwrap();
        let mut last = 0.0;
        for tick in 0..40 {
            let output = helm.step(0.05, &state, &path, 1.2).unwrap();
            last = output.command.steering;
            assert!(output.diagnostics.law.alpha_r_radps.abs() <= 0.35);
            // Later on a boat that is held still contradicts its model, which believes that it has begun to turn.
            let slow = output.diagnostics.reference.speed_mps <= 0.01;
            assert!(slow || tick >= 10, "turns first");
        }
        assert!((least..=most).contains(&last), "{error_rad}: {last}");
        assert!(last.abs() > 0.3, "{error_rad}: {last}");
    }
}

#[test]
fn a_turn_through_half_a_circle_does_not_dither() {
    let path = path();
    let mut helm = helm();
    helm.engage(&state(at(0.0, 20.0), -FRAC_PI_2), 20.0).unwrap();
    let mut signs = Vec::new();
    for i in 0..60 {
        let wobble = if i % 2 == 0 { 0.02 } else { -0.02 };
        let output = helm.step(0.05, &state(at(0.0, 20.0), -FRAC_PI_2 + wobble), &path, 1.2).unwrap();
        signs.push(output.diagnostics.reference.heading_error_rad.signum());
    }
    assert!(signs.windows(2).all(|pair| pair[0] == pair[1]), "{signs:?}");
}

#[test]
fn on_top_of_the_virtual_ship_the_reference_is_its_direction() {
    let path = path();
    let mut helm = helm();
    let start = state(at(0.0, 20.0), FRAC_PI_2);
    helm.engage(&start, 20.0).unwrap();
    let lead_m = helm.step(0.05, &start, &path, 1.2).unwrap().diagnostics.reference.lead_m;
    // The boat stands where the virtual ship is, as seen before progress catches up.
    let jumped = state(at(1.0e-9, 20.0 + lead_m), FRAC_PI_2);
    let reference = helm.step(0.05, &jumped, &path, 1.2).unwrap().diagnostics.reference;
    assert!(reference.heading_error_rad.abs() < 1.0e-3, "{reference:?}");
    assert!(reference.heading_rate_radps.abs() < 1.0e-2);
}

#[test]
fn engaging_takes_over_without_a_jump() {
    let path = path();
    let boat = Boat::embedded("otter").unwrap();
    let steady_throttle = {
        // Thrust that holds 1 m/s, through the square of the thruster's curve.
        (boat.hull.surge_damping[0] / 2.0 / 119.7f64).sqrt()
    };
    let mut helm = helm();
    let state = state(at(0.0, 20.0), FRAC_PI_2);
    helm.engage(&state, 20.0).unwrap();
    let command = helm.step(0.02, &state, &path, 1.0).unwrap().command;
    assert!((command.throttle - steady_throttle).abs() < 0.03, "{command:?} {steady_throttle}");
    assert!(command.steering.abs() < 1.0e-6);
}
