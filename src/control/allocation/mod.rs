//! From a demanded surge force and yaw moment to throttle and steering.
//!
//! Yaw first: a boat off its heading is lost sooner than one off its speed. Every allocator also predicts
//! what its actuators will really do (magnitude limits, slew, lag), so that the controller can tell the
//! part of its demand that never reached the hull.

mod curve;
mod rudder;
mod servo;
mod turning_circle;
mod twin;

pub use curve::ThrustCurve;
pub use rudder::{PropellerRudder, RudderSettings};
pub use servo::Servo;
pub use turning_circle::{CircleSettings, TurningCircle};
pub use twin::{TwinSettings, TwinThrusters};

use crate::control::boat::Actuators;
use crate::control::command::{Command, Wrench};
use crate::control::model::{Hull, WaterMotion};

/// What an allocator needs to know besides the demand.
#[derive(Debug, Clone, Copy)]
pub struct Situation {
    /// Motion through the water, as far as it is known.
    pub motion: WaterMotion,
    /// Heading error ψ_e, rad: a rudder boat that is slow and far off its heading kicks ahead.
    pub heading_error_rad: f64,
}

/// The command to send and what it will do to the hull.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Allocation {
    /// Normalised command.
    pub command: Command,
    /// Forces predicted to act now, after limits and lag.
    pub achieved: Wrench,
    /// Whether a limit cut the surge force off.
    pub surge_saturated: bool,
    /// Whether a limit cut the yaw moment off.
    pub yaw_saturated: bool,
}

/// The allocator of a boat.
#[derive(Debug, Clone)]
pub enum Allocator {
    /// Two fixed thrusters side by side.
    Twin(TwinThrusters),
    /// Propeller and rudder, or an outboard that turns.
    Rudder(PropellerRudder),
    /// A boat known by its turning circle alone.
    Circle(TurningCircle),
}

impl Allocator {
    /// The allocator for these actuators on this hull.
    #[must_use]
    pub fn new(actuators: &Actuators, hull: &Hull) -> Self {
        match actuators {
            Actuators::TwinThrusters(settings) => Self::Twin(TwinThrusters::new(settings.clone())),
            Actuators::PropellerRudder(settings) => Self::Rudder(PropellerRudder::new(settings.clone())),
            Actuators::TurningCircle(settings) => Self::Circle(TurningCircle::new(settings.clone(), hull)),
        }
    }

    /// Actuators at rest.
    pub fn reset(&mut self) {
        match self {
            Self::Twin(twin) => twin.reset(),
            Self::Rudder(rudder) => rudder.reset(),
            Self::Circle(circle) => circle.reset(),
        }
    }

    /// Allocates `demand` and advances the prediction of the actuators by `dt_s`.
    pub fn allocate(&mut self, dt_s: f64, demand: Wrench, situation: &Situation) -> Allocation {
        match self {
            Self::Twin(twin) => twin.allocate(dt_s, demand),
            Self::Rudder(rudder) => rudder.allocate(dt_s, demand, situation),
            Self::Circle(circle) => circle.allocate(dt_s, demand, situation),
        }
    }
}

#[cfg(test)]
mod tests;
