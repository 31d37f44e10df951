//! Static thrust curve of one propeller, and its inverse.

use serde::{Deserialize, Serialize};

/// Below this part of full thrust the inverse curve is straight: the square root is infinitely steep at zero
/// and would turn the smallest wish into a twitch of the shaft.
const STRAIGHT_PART: f64 = 0.002;

/// Thrust against normalised command: T = T_max·|n|^p, with its own limit each way.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ThrustCurve {
    /// Thrust at full command ahead, N.
    pub ahead_n: f64,
    /// Thrust at full command astern, N (positive).
    pub astern_n: f64,
    /// Exponent p: 2 when the command sets shaft speed (T = k n|n|), 1 when it sets thrust.
    pub exponent: f64,
}

impl ThrustCurve {
    /// Limits a thrust (N) to what the propeller can give.
    #[must_use]
    pub fn limit(&self, thrust_n: f64) -> f64 {
        thrust_n.clamp(-self.astern_n, self.ahead_n)
    }

    /// Thrust (N) at a normalised command in −1…1.
    #[must_use]
    pub fn thrust_n(&self, command: f64) -> f64 {
        let part = command.abs().min(1.0);
        let curved = part.powf(self.exponent);
        let relative = if curved < STRAIGHT_PART { part / self.knee() * STRAIGHT_PART } else { curved };
        if command < 0.0 { -relative * self.astern_n } else { relative * self.ahead_n }
    }

    /// Normalised command in −1…1 for a thrust (N); beyond the limits, the limit.
    #[must_use]
    pub fn command(&self, thrust_n: f64) -> f64 {
        let full = if thrust_n < 0.0 { self.astern_n } else { self.ahead_n };
        let relative = (thrust_n.abs() / full).min(1.0);
        let part = if relative < STRAIGHT_PART {
            relative / STRAIGHT_PART * self.knee()
        } else {
            relative.powf(1.0 / self.exponent)
        };
        part.copysign(thrust_n)
    }

    fn knee(&self) -> f64 {
        STRAIGHT_PART.powf(1.0 / self.exponent)
    }
}
