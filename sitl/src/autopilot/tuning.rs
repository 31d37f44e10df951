//! Parameters from a sea trial.
//!
//! Turn rate and speed each answer about like a first-order system with gain K and time constant T. With
//! proportional gain T/(K·Tc) and integral gain 1/(K·Tc) the controlled system has the time constant Tc
//! (internal model control: Rivera, Morari and Skogestad 1986, table I).

use super::parameters::*;
use crate::trial::Trial;

/// Closed-loop time constant of the turn rate: this share of the hull's own, but not below the limit, s.
const TURN_SHARE: f64 = 0.5;
/// Heavier filtering of the rate on long hulls calls for patience in proportion, s per m.
const TURN_TIME_LIMIT_S: f64 = 0.4;
const TURN_TIME_PER_LENGTH: f64 = 0.08;
/// Closed-loop time constant of the speed, as a share of the hull's own, but not below the limit, s.
const SPEED_SHARE: f64 = 0.4;
const SPEED_TIME_LIMIT_S: f64 = 0.8;
/// The heading is to be this much slower than the turn rate, and the track this much slower than the heading,
/// so that the loops do not disturb each other.
const HEADING_SEPARATION: f64 = 3.0;
const TRACK_SEPARATION: f64 = 3.0;
/// The shortest look-ahead, in lengths of the hull.
const LOOKAHEAD_LENGTHS: f64 = 4.0;
/// The throttle's slew rate follows no faster changes of speed, m/s².
const ACCELERATION_LIMIT_MPS2: f64 = 2.0;
/// Share of the full turn rate that is asked for at most.
const TURN_RESERVE: f64 = 0.8;

/// Sets the parameters for a boat that answers as `trial` says.
pub(super) fn apply(trial: &Trial, twin: bool, parameters: &mut Parameters) {
    let speed_mps = trial.cruise_speed_mps;
    let length_m = trial.length_m;
    let turn_gain = trial.turn_gain_radps;
    let turn_s = (TURN_SHARE * trial.turn_time_s).max(TURN_TIME_LIMIT_S).max(TURN_TIME_PER_LENGTH * length_m);
    let heading_s = HEADING_SEPARATION * turn_s;
    let track_m = TRACK_SEPARATION * heading_s * speed_mps;
    let speed_gain = speed_mps / trial.cruise_throttle;
    let speed_s = (SPEED_SHARE * trial.speed_time_s).max(SPEED_TIME_LIMIT_S);
    let acceleration_mps2 = (speed_mps / trial.speed_time_s).min(ACCELERATION_LIMIT_MPS2);
    let full_turn_degps = turn_gain.to_degrees();
    let turning_radius_m = speed_mps / turn_gain;

    let values = [
        (CRUISE_SPEED, speed_mps),
        (CRUISE_THROTTLE, 100.0 * trial.cruise_throttle),
        (WP_SPEED, speed_mps),
        (TURN_RADIUS, turning_radius_m),
        (ATC_STR_RAT_FF, 1.0 / turn_gain),
        (ATC_STR_RAT_P, trial.turn_time_s / (turn_gain * turn_s)),
        (ATC_STR_RAT_I, 1.0 / (turn_gain * turn_s)),
        (ATC_STR_RAT_MAX, TURN_RESERVE * full_turn_degps),
        (ATC_STR_ANG_P, 1.0 / heading_s),
        (ACRO_TURN_RATE, full_turn_degps.min(180.0)),
        (ATC_SPEED_P, trial.speed_time_s / (speed_gain * speed_s)),
        (ATC_SPEED_I, 1.0 / (speed_gain * speed_s)),
        (ATC_ACCEL_MAX, acceleration_mps2),
        (ATC_DECEL_MAX, 0.5 * acceleration_mps2),
        (WP_LOOKAHEAD, track_m.max(LOOKAHEAD_LENGTHS * length_m)),
        (WP_RADIUS, (0.5 * heading_s * speed_mps).max(length_m).max(2.0)),
        (LOIT_RADIUS, length_m.max(2.0)),
        (CIRC_RADIUS, (3.0 * turning_radius_m).max(5.0 * length_m).max(20.0)),
        (SRTL_ACCURACY, length_m.max(2.0)),
        // Two thrusters turn on the spot and may back up to a place; a rudder steers badly astern.
        (LOIT_TYPE, if twin { 0.0 } else { 1.0 }),
    ];
    for (param, value) in values {
        parameters.put(param, value as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_ship_gets_a_patient_autopilot() {
        let boat = Trial {
            cruise_speed_mps: 2.0,
            cruise_throttle: 0.5,
            speed_time_s: 2.0,
            turn_gain_radps: 1.0,
            turn_time_s: 0.5,
            length_m: 2.0,
        };
        let ship = Trial { turn_gain_radps: 0.1, turn_time_s: 20.0, length_m: 40.0, ..boat };
        let mut nimble = Parameters::new();
        let mut patient = Parameters::new();
        apply(&boat, false, &mut nimble);
        apply(&ship, false, &mut patient);
        assert!(patient.get(ATC_STR_ANG_P) < 0.2 * nimble.get(ATC_STR_ANG_P));
        assert!(patient.get(WP_LOOKAHEAD) > 5.0 * nimble.get(WP_LOOKAHEAD));
        assert_eq!(nimble.get(CRUISE_THROTTLE), 50.0);
    }
}
