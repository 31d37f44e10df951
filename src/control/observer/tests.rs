use super::*;
use crate::control::Boat;

const DT_S: f64 = 0.04;
const CALM: NorthEast = NorthEast::ZERO;
/// An observer that takes out much, whatever a boat's own is tuned for.
const SETTINGS: ObserverSettings = ObserverSettings {
    noise_radps: 0.03,
    noise_mps: 0.05,
    turn_bandwidth_radps: 2.0,
    move_bandwidth_radps: 2.0,
};

fn otter() -> Boat {
    Boat::embedded("otter").unwrap()
}

fn under_way() -> VesselState {
    VesselState { position: CALM, heading_rad: 0.4, surge_mps: 1.2, sway_mps: 0.0, yaw_rate_radps: 0.0 }
}

/// Forces that hold 1.2 m/s and swing the bow slowly.
fn wrench(time_s: f64) -> Wrench {
    Wrench { surge_n: 77.55 * 1.2, sway_n: 0.0, yaw_nm: 8.0 * (0.3 * time_s).sin() }
}

/// Runs observer and true hull side by side for two minutes; returns the root mean square of the yaw rate's
/// error of the measurement and of the estimate.
fn rate_errors(truth: &Hull, wave_radps: f64) -> (f64, f64) {
    let boat = otter();
    let mut observer = Observer::new(SETTINGS);
    let mut state = under_way();
    let (mut raw, mut seen, mut count) = (0.0, 0.0, 0.0);
    for step in 0..3000 {
        let time_s = f64::from(step) * DT_S;
        let (sin, cos) = (2.4 * time_s).sin_cos();
        let measured = VesselState {
            heading_rad: state.heading_rad - wave_radps / 2.4 * cos,
            yaw_rate_radps: state.yaw_rate_radps + wave_radps * sin,
            ..state
        };
        let acted = if step == 0 { Wrench::default() } else { wrench(time_s - DT_S) };
        let estimate = observer.observe(DT_S, &boat.hull, &measured, acted, CALM);
        if time_s > 30.0 {
            raw += (measured.yaw_rate_radps - state.yaw_rate_radps).powi(2);
            seen += (estimate.yaw_rate_radps - state.yaw_rate_radps).powi(2);
            count += 1.0;
        }
        let quiet = Observer { estimate: Some(state), ..Observer::new(SETTINGS) };
        state = quiet.expected(DT_S, truth, &state, wrench(time_s), CALM);
    }
    ((raw / count).sqrt(), (seen / count).sqrt())
}

#[test]
fn a_calm_measurement_is_taken_as_it_is() {
    let mut wrong = otter().hull;
    wrong.m33_kgm2 *= 1.5;
    wrong.yaw_damping[0] *= 0.7;
    let (_, seen) = rate_errors(&wrong, 0.0);
    assert!(seen < 1.0e-3, "{seen}");
}

#[test]
fn waves_are_taken_out_and_the_turn_is_left() {
    let (raw, seen) = rate_errors(&otter().hull, 0.08);
    assert!(seen < 0.75 * raw, "measured {raw}, estimated {seen}");
}

#[test]
fn waves_are_taken_out_with_a_wrong_model_too() {
    let mut wrong = otter().hull;
    wrong.m33_kgm2 *= 1.5;
    let (raw, seen) = rate_errors(&wrong, 0.08);
    assert!(seen < 0.75 * raw, "measured {raw}, estimated {seen}");
}

#[test]
fn a_jump_of_the_position_starts_anew() {
    let boat = otter();
    let mut observer = Observer::new(SETTINGS);
    observer.observe(DT_S, &boat.hull, &under_way(), Wrench::default(), CALM);
    let far = VesselState { position: NorthEast::new(500.0, 0.0), ..under_way() };
    assert_eq!(observer.observe(DT_S, &boat.hull, &far, Wrench::default(), CALM), far);
}
