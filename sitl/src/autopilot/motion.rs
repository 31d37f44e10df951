//! What the controllers know about the boat's motion, and what they ask of it.

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
}

impl Motion {
    pub(super) fn new(estimate: &Estimate) -> Self {
        Self {
            position: NorthEast::new(estimate.north_m, estimate.east_m),
            velocity_mps: NorthEast::new(estimate.north_mps, estimate.east_mps),
            heading_rad: estimate.psi_rad,
            turn_rate_radps: estimate.r_radps,
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
