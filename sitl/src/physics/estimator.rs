//! The estimator of the simulated flight controller: dead reckoning from gyro and accelerometer, pulled
//! toward compass and GPS by constant gains. Simpler than an extended Kalman filter, with errors of the same
//! size and kind: smooth, slightly late, biased as the sensors are.

use super::angles::unit;
use super::dynamics::{NedVector, wrap};
use super::sensors::{Estimate, GpsFix, TrueMotion};

/// Share of a position error taken out per GPS fix.
const POSITION_GAIN: f64 = 0.12;
/// Share of a velocity error taken out per GPS fix, for a boat of [`REFERENCE_LENGTH_M`].
const VELOCITY_GAIN: f64 = 0.25;
/// Time constant of the pull toward the compass, s, for a boat of that length.
const HEADING_TIME_S: f64 = 2.0;
/// Low-pass of the yaw rate, s, for a boat of that length.
const RATE_TIME_S: f64 = 0.1;
/// A fix further off than this is not believed, m: five standard deviations of 0.5 m and a little for what dead
/// reckoning may have drifted (ArduPilot's EKF3: EK3_POS_I_GATE 500, EK3_POSNE_M_NSE 0.5).
const POSITION_GATE_M: f64 = 3.0;
/// After so long without a fix that was believed, s, the next one is taken as it is (EKF3: ten seconds while the
/// velocity is measured).
const DISBELIEF_S: f64 = 10.0;
/// Larger boats are filtered harder, in step with their slower motion.
const REFERENCE_LENGTH_M: f64 = 2.0;

/// One set of inertial readings and the compass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inertial {
    pub(super) r_radps: f64,
    pub(super) forward_mps2: f64,
    pub(super) starboard_mps2: f64,
    pub(super) compass_rad: f64,
}

/// Constant-gain estimator of position, velocity, heading and yaw rate.
#[derive(Debug, Clone)]
pub(super) struct Estimator {
    velocity_gain: f64,
    heading_time_s: f64,
    rate_time_s: f64,
    estimate: Estimate,
    /// Time since the last fix that was believed, s.
    unbelieved_s: f64,
}

impl Estimator {
    /// Starts at the true motion, as a filter that has had time to settle.
    pub(super) fn new(length_m: f64, motion: &TrueMotion) -> Estimator {
        let scale = length_m / REFERENCE_LENGTH_M;
        Estimator {
            velocity_gain: (VELOCITY_GAIN * scale.powf(-0.3)).min(0.5),
            heading_time_s: HEADING_TIME_S * scale.powf(0.6),
            rate_time_s: RATE_TIME_S * scale.powf(0.55),
            estimate: Estimate {
                north_m: motion.north_m,
                east_m: motion.east_m,
                psi_rad: motion.psi_rad,
                north_mps: motion.north_mps,
                east_mps: motion.east_mps,
                r_radps: motion.r_radps,
                ..Estimate::default()
            },
            unbelieved_s: 0.0,
        }
    }

    /// Dead reckoning over `dt_s`.
    pub(super) fn predict(&mut self, dt_s: f64, inertial: &Inertial) {
        self.unbelieved_s += dt_s;
        let estimate = &mut self.estimate;
        let compass_error = wrap(inertial.compass_rad - estimate.psi_rad);
        let pull = (dt_s / self.heading_time_s).min(1.0);
        estimate.psi_rad = wrap(estimate.psi_rad + dt_s * inertial.r_radps + pull * compass_error);
        estimate.r_radps += (dt_s / self.rate_time_s).min(1.0) * (inertial.r_radps - estimate.r_radps);
        let NedVector { north: north_mps2, east: east_mps2 } =
            NedVector::of_body(inertial.forward_mps2, inertial.starboard_mps2, unit(estimate.psi_rad));
        estimate.north_m += dt_s * (estimate.north_mps + 0.5 * dt_s * north_mps2);
        estimate.east_m += dt_s * (estimate.east_mps + 0.5 * dt_s * east_mps2);
        estimate.north_mps += dt_s * north_mps2;
        estimate.east_mps += dt_s * east_mps2;
    }

    /// Takes in a GPS fix, as far as it is believed: a GPS that jumps is followed only when it stays there.
    pub(super) fn correct(&mut self, fix: &GpsFix) {
        let estimate = &mut self.estimate;
        let (north_m, east_m) = (fix.north_m - estimate.north_m, fix.east_m - estimate.east_m);
        let is_off = north_m * north_m + east_m * east_m > POSITION_GATE_M * POSITION_GATE_M;
        let gain = match is_off {
            true if self.unbelieved_s < DISBELIEF_S => 0.0,
            true => 1.0,
            false => POSITION_GAIN,
        };
        if gain > 0.0 {
            self.unbelieved_s = 0.0;
        }
        estimate.north_m += gain * north_m;
        estimate.east_m += gain * east_m;
        estimate.north_mps += self.velocity_gain * (fix.north_mps - estimate.north_mps);
        estimate.east_mps += self.velocity_gain * (fix.east_mps - estimate.east_mps);
    }

    pub(super) fn estimate(&self) -> Estimate {
        self.estimate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gps_that_jumps_is_believed_only_when_it_stays_there() {
        let mut estimator = Estimator::new(2.0, &TrueMotion::default());
        let still = Inertial { r_radps: 0.0, forward_mps2: 0.0, starboard_mps2: 0.0, compass_rad: 0.0 };
        let mut hear = |north_m: f64, fixes: u32| {
            for _ in 0..fixes {
                (0..10).for_each(|_| estimator.predict(0.02, &still));
                estimator.correct(&GpsFix { north_m, ..GpsFix::default() });
            }
            estimator.estimate().north_m
        };
        // Five fixes a second: a glitch of eight seconds leaves no trace, one of more than ten is the new truth.
        assert_eq!(hear(20.0, 40), 0.0);
        assert_eq!(hear(0.0, 5), 0.0);
        assert_eq!(hear(20.0, 48), 0.0);
        assert_eq!(hear(20.0, 4), 20.0);
        // What lies within the gate is taken in bit by bit.
        let moved = hear(21.0, 1);
        assert!((moved - 20.12).abs() < 1e-9, "{moved}");
    }
}
