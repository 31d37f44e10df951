//! First-order command filter with a limited rate: the command without its steps, and its exact derivative.

/// A filtered command.
#[derive(Debug, Clone, Copy, Default)]
pub struct CommandFilter {
    value: f64,
}

impl CommandFilter {
    /// Starts at `value` without a jump.
    #[must_use]
    pub fn starting_at(value: f64) -> Self {
        Self { value }
    }

    /// Moves toward `target` with time constant `time_s` and at most `rate_max` per second; returns the rate.
    pub fn step(&mut self, dt_s: f64, target: f64, time_s: f64, rate_max: f64) -> f64 {
        // The mean rate of the exact first-order response over the step: stable however long the step.
        let rate = (target - self.value) * (-(-dt_s / time_s).exp_m1()) / dt_s;
        let rate = rate.clamp(-rate_max, rate_max);
        self.value += rate * dt_s;
        rate
    }

    /// The filtered command.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.value
    }
}
