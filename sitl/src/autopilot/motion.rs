//! What the controllers know about the boat's motion, and what they ask of it.

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::NorthEast;

use crate::physics::Estimate;

/// The estimated motion of the boat.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Motion {
    /// From the local origin.
    pub(super) position: NorthEast,
    /// Over ground, m/s per axis.
    pub(super) velocity_mps: NorthEast,
    /// Clockwise from north, (−π, π].
    pub(super) heading_rad: f64,
    pub(super) turn_rate_radps: f64,
    /// How much the course lies to the right of the heading in the mean (see [`Drift`]).
    pub(super) drift_rad: f64,
}

impl Motion {
    pub(super) fn new(estimate: &Estimate, drift: &Drift) -> Self {
        Self {
            position: NorthEast::new(estimate.north_m, estimate.east_m),
            velocity_mps: NorthEast::new(estimate.north_mps, estimate.east_mps),
            heading_rad: estimate.psi_rad,
            turn_rate_radps: estimate.r_radps,
            drift_rad: drift.rad,
        }
    }

    /// Speed over ground along the bow, m/s; negative astern.
    pub(super) fn forward_mps(&self) -> f64 {
        self.velocity_mps.dot(NorthEast::from_polar(1.0, self.heading_rad))
    }

    /// Speed over ground, m/s.
    pub(super) fn speed_mps(&self) -> f64 {
        self.velocity_mps.norm()
    }
}

/// The angle from heading to course, low-passed so that the skid of a turn is not taken for the set of a
/// current.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Drift {
    rad: f64,
}

impl Drift {
    /// Below this speed over ground along the bow the course says nothing, m/s.
    const KNOWN_FROM_MPS: f64 = 0.3;
    /// The largest angle that is still the drift of a boat making way, rad.
    const LIMIT_RAD: f64 = 0.7;

    /// Takes in the motion of a loop of `dt_s`; `time_s` is the time constant.
    pub(super) fn update(&mut self, motion: &Motion, time_s: f64, dt_s: f64) {
        let now_rad = if motion.forward_mps() > Self::KNOWN_FROM_MPS {
            ssa(motion.velocity_mps.bearing_rad() - motion.heading_rad)
                .clamp(-Self::LIMIT_RAD, Self::LIMIT_RAD)
        } else {
            0.0
        };
        self.rad += (now_rad - self.rad) * (dt_s / time_s.max(dt_s));
    }
}

/// What a mode asks of the boat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Demand {
    /// Actuators as they are, each [−1, 1]: steering to starboard, throttle ahead.
    Direct { steering: f64, throttle: f64 },
    /// A turn rate, rad/s to starboard, and a speed over ground along the bow, m/s.
    Drive { turn_rate_radps: f64, speed_mps: f64 },
    /// Brake, then let go.
    Stop,
}

impl Demand {
    pub(super) const NEUTRAL: Self = Self::Direct { steering: 0.0, throttle: 0.0 };
}
