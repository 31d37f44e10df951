//! What a boat can follow.

/// How sharply a path may turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathLimits {
    /// Smallest radius, metres.
    pub min_radius_m: f64,
    /// Length over which the curvature goes from zero to that of the smallest radius, metres.
    pub transition_m: f64,
    /// How far turns swing to the outer side first: 0 for plain turns inside the waypoint, 1 for turns
    /// through it, 0.5 to go as far outside of the legs as inside, which halves the largest distance from
    /// them at the price of two more changes of rudder. Hairpins always take 1.
    pub swing: f64,
}

/// Why limits cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LimitsError {
    /// The radius is not a positive number.
    #[error("the smallest turning radius must be a positive number of metres, got {0}")]
    Radius(f64),
    /// The transition is not a positive number.
    #[error("the transition into a turn must be a positive number of metres, got {0}: try half the radius")]
    Transition(f64),
    /// The swing is not a share.
    #[error("the swing of a turn must lie between 0 (inside the waypoint) and 1 (through it), got {0}")]
    Swing(f64),
}

impl PathLimits {
    /// Plain turns with a smallest radius and a length of transition, metres.
    pub fn new(min_radius_m: f64, transition_m: f64) -> Self {
        Self { min_radius_m, transition_m, swing: 0.0 }
    }

    /// Plain turns that ask no more than a turn rate and a yaw acceleration at a speed: R = U/r and
    /// transition = U r/ṙ.
    pub fn for_speed(speed_mps: f64, turn_rate_radps: f64, yaw_acceleration_radps2: f64) -> Self {
        Self::new(speed_mps / turn_rate_radps, speed_mps * turn_rate_radps / yaw_acceleration_radps2)
    }

    /// The same limits with another swing.
    pub fn with_swing(self, swing: f64) -> Self {
        Self { swing, ..self }
    }

    /// # Errors
    /// The first limit that is not finite or out of range.
    pub(super) fn check(&self) -> Result<(), LimitsError> {
        let is_length = |length_m: f64| length_m.is_finite() && length_m > 0.0;
        if !is_length(self.min_radius_m) {
            Err(LimitsError::Radius(self.min_radius_m))
        } else if !is_length(self.transition_m) {
            Err(LimitsError::Transition(self.transition_m))
        } else if !(0.0..=1.0).contains(&self.swing) {
            Err(LimitsError::Swing(self.swing))
        } else {
            Ok(())
        }
    }
}
