//! Two fixed thrusters side by side, behind the autopilot's skid-steer mixer.

use serde::{Deserialize, Serialize};

use super::{Allocation, Servo, ThrustCurve};
use crate::control::command::{Command, Wrench};

/// A pair of equal thrusters.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TwinSettings {
    /// Thrust curve of one thruster.
    pub thrust: ThrustCurve,
    /// Distance of each thruster from the centre line, m.
    pub arm_m: f64,
    /// Time constant of a shaft, s.
    pub lag_s: f64,
    /// Largest rate of a shaft's normalised command, 1/s.
    pub slew_per_s: f64,
}

/// Allocator for twin thrusters: yaw first, then what surge is left.
#[derive(Debug, Clone)]
pub struct TwinThrusters {
    settings: TwinSettings,
    left: Servo,
    right: Servo,
}

impl TwinThrusters {
    /// Thrusters at rest.
    #[must_use]
    pub fn new(settings: TwinSettings) -> Self {
        Self { settings, left: Servo::default(), right: Servo::default() }
    }

    /// Shafts at rest.
    pub fn reset(&mut self) {
        self.left = Servo::default();
        self.right = Servo::default();
    }

    /// Splits the demand and predicts the shafts `dt_s` ahead.
    pub fn allocate(&mut self, dt_s: f64, demand: Wrench) -> Allocation {
        let TwinSettings { thrust, arm_m, lag_s, slew_per_s } = &self.settings;
        let half_span = 0.5 * (thrust.ahead_n + thrust.astern_n);
        let wanted_difference = 0.5 * demand.yaw_nm / arm_m;
        let difference = wanted_difference.clamp(-half_span, half_span);
        let wanted_mean = 0.5 * demand.surge_n;
        let mean = wanted_mean.clamp(difference.abs() - thrust.astern_n, thrust.ahead_n - difference.abs());

        let left = thrust.command(mean + difference);
        let right = thrust.command(mean - difference);
        let left_n = thrust.thrust_n(self.left.step(dt_s, left, *slew_per_s, *lag_s));
        let right_n = thrust.thrust_n(self.right.step(dt_s, right, *slew_per_s, *lag_s));
        Allocation {
            command: Command { throttle: 0.5 * (left + right), steering: 0.5 * (left - right) },
            achieved: Wrench { surge_n: left_n + right_n, sway_n: 0.0, yaw_nm: arm_m * (left_n - right_n) },
            surge_saturated: mean != wanted_mean,
            yaw_saturated: difference != wanted_difference,
        }
    }
}
