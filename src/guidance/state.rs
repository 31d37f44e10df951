//! What is known of the boat at one instant.

use helmlink_mission::geodesy::NorthEast;
use thiserror::Error;

use super::unit;

/// The boat's planar motion, as estimated at one instant. All velocities are over ground.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VesselState {
    /// Position in the mission's local north-east frame, metres.
    pub position: NorthEast,
    /// Heading of the bow ψ, radians clockwise from north; any turn of the circle.
    pub heading_rad: f64,
    /// Surge speed u over ground, along the bow, m/s.
    pub surge_mps: f64,
    /// Sway speed v over ground, to starboard, m/s.
    pub sway_mps: f64,
    /// Yaw rate r, clockwise positive, rad/s.
    pub yaw_rate_radps: f64,
}

/// Farthest position from the local origin that is still believed, metres.
pub const MAX_DISTANCE_M: f64 = 1.0e6;
/// Largest heading that is still believed (many turns, unwrapped), radians.
pub const MAX_HEADING_RAD: f64 = 1.0e6;
/// Largest speed component that is still believed, m/s.
pub const MAX_SPEED_MPS: f64 = 50.0;
/// Largest yaw rate that is still believed, rad/s.
pub const MAX_YAW_RATE_RADPS: f64 = 10.0;

/// Why a state cannot be steered by.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "{quantity} is {value}, which no boat can have (allowed: -{limit} to {limit}); \
     keep the output neutral until the telemetry is sound again"
)]
pub struct StateError {
    /// Name of the offending quantity.
    pub quantity: &'static str,
    /// Its value; may be NaN or infinite.
    pub value: f64,
    /// Largest magnitude accepted.
    pub limit: f64,
}

impl VesselState {
    /// Accepts finite, plausible states only.
    ///
    /// # Errors
    /// Names the first quantity that is not a number, infinite, or beyond its limit.
    pub fn check(&self) -> Result<(), StateError> {
        let quantities = [
            ("north position (m)", self.position.north_m, MAX_DISTANCE_M),
            ("east position (m)", self.position.east_m, MAX_DISTANCE_M),
            ("heading (rad)", self.heading_rad, MAX_HEADING_RAD),
            ("surge speed (m/s)", self.surge_mps, MAX_SPEED_MPS),
            ("sway speed (m/s)", self.sway_mps, MAX_SPEED_MPS),
            ("yaw rate (rad/s)", self.yaw_rate_radps, MAX_YAW_RATE_RADPS),
        ];
        for (quantity, value, limit) in quantities {
            // NaN is in no range.
            if !(-limit..=limit).contains(&value) {
                return Err(StateError { quantity, value, limit });
            }
        }
        Ok(())
    }

    /// Velocity over ground in north-east components, m/s (Eq. 1, first two rows).
    #[must_use]
    pub fn ground_velocity(&self) -> NorthEast {
        self.ground_velocity_with(unit(self.heading_rad))
    }

    /// The same where `bow`, the unit vector of the heading, is known already.
    #[must_use]
    pub(crate) fn ground_velocity_with(&self, bow: NorthEast) -> NorthEast {
        NorthEast {
            north_m: self.surge_mps * bow.north_m - self.sway_mps * bow.east_m,
            east_m: self.surge_mps * bow.east_m + self.sway_mps * bow.north_m,
        }
    }
}
