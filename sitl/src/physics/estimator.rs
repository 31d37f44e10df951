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
        }
    }

    /// Dead reckoning over `dt_s`.
    pub(super) fn predict(&mut self, dt_s: f64, inertial: &Inertial) {
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

    /// Takes in a GPS fix.
    pub(super) fn correct(&mut self, fix: &GpsFix) {
        let estimate = &mut self.estimate;
        estimate.north_m += POSITION_GAIN * (fix.north_m - estimate.north_m);
        estimate.east_m += POSITION_GAIN * (fix.east_m - estimate.east_m);
        estimate.north_mps += self.velocity_gain * (fix.north_mps - estimate.north_mps);
        estimate.east_mps += self.velocity_gain * (fix.east_mps - estimate.east_mps);
    }

    pub(super) fn estimate(&self) -> Estimate {
        self.estimate
    }
}
