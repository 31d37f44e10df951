//! Prediction of one actuator: slew limit, then first-order lag.

/// Where an actuator is believed to be.
#[derive(Debug, Clone, Copy, Default)]
pub struct Servo {
    position: f64,
}

impl Servo {
    /// Advances by `dt_s` toward `command`; returns the mean position over the step.
    ///
    /// `slew_per_s` is the largest rate in the command's unit, `lag_s` the time constant.
    pub fn step(&mut self, dt_s: f64, command: f64, slew_per_s: f64, lag_s: f64) -> f64 {
        let gap = command - self.position;
        let travel = gap * (-(-dt_s / lag_s.max(1.0e-6)).exp_m1());
        let limit = slew_per_s * dt_s;
        let before = self.position;
        self.position += travel.clamp(-limit, limit);
        0.5 * (before + self.position)
    }

    /// Whether the slew limit keeps the servo from following `command` over a step of `dt_s`.
    #[must_use]
    pub fn is_slewing(&self, dt_s: f64, command: f64, slew_per_s: f64, lag_s: f64) -> bool {
        let travel = (command - self.position) * (-(-dt_s / lag_s.max(1.0e-6)).exp_m1());
        travel.abs() > slew_per_s * dt_s
    }

    /// Present position.
    #[must_use]
    pub fn position(&self) -> f64 {
        self.position
    }
}
