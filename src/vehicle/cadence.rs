//! When enough new telemetry has come for one control step.

/// Two steps closer together than this share of the usual interval would only use the same data twice.
const CROWDED: f64 = 0.5;

/// Decides, message by message, when the control loop steps.
///
/// The loop is driven by telemetry and not by a timer, so that it keeps pace with a simulator run at any
/// speed, and so that a recorded log makes the same steps again. One step is due when attitude and position
/// are both new; when attitude comes twice with no position in between (a lower position rate, or a lost
/// message), the step is made without it.
#[derive(Debug, Clone)]
pub struct Cadence {
    interval_s: f64,
    attitude_is_new: bool,
    position_is_new: bool,
    position_s: f64,
    last_step_s: Option<f64>,
}

impl Cadence {
    /// A loop whose messages were asked for every `interval_s` seconds of vehicle time.
    pub fn new(interval_s: f64) -> Self {
        Self {
            interval_s,
            attitude_is_new: false,
            position_is_new: false,
            position_s: 0.0,
            last_step_s: None,
        }
    }

    /// A new attitude of vehicle time `boot_s`; true when a control step is due.
    pub fn on_attitude(&mut self, boot_s: f64) -> bool {
        if self.position_is_new {
            // Positions that follow soon after each attitude would wait for the next one all the time. This attitude
            // is kept for the position that follows, which puts the pair in order at the price of one step.
            let waited_long = boot_s - self.position_s > CROWDED * self.interval_s;
            let is_due = self.step_with_both(boot_s);
            self.attitude_is_new = waited_long;
            return is_due;
        }
        let due = self.attitude_is_new;
        self.attitude_is_new = true;
        if due {
            self.last_step_s = Some(boot_s);
        }
        due
    }

    /// A new position of vehicle time `boot_s`; true when a control step is due.
    pub fn on_position(&mut self, boot_s: f64) -> bool {
        if self.attitude_is_new {
            return self.step_with_both(boot_s);
        }
        self.position_is_new = true;
        self.position_s = boot_s;
        false
    }

    fn step_with_both(&mut self, boot_s: f64) -> bool {
        self.attitude_is_new = false;
        self.position_is_new = false;
        let crowded = self
            .last_step_s
            .is_some_and(|last_s| (0.0..CROWDED * self.interval_s).contains(&(boot_s - last_s)));
        if !crowded {
            self.last_step_s = Some(boot_s);
        }
        !crowded
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_rates_step_once_a_pair() {
        let mut cadence = Cadence::new(0.05);
        for index in 0..100 {
            let t = f64::from(index) * 0.05;
            assert!(!cadence.on_attitude(t));
            assert!(cadence.on_position(t));
        }
    }

    #[test]
    fn a_position_does_not_wait_for_the_next_attitude_for_long() {
        let mut cadence = Cadence::new(0.05);
        assert!(!cadence.on_position(0.0), "the first attitude was lost");
        let mut waited = 0;
        let mut steps = 0;
        for index in 1..=100 {
            let t = f64::from(index) * 0.05;
            waited += u32::from(cadence.on_attitude(t));
            steps += u32::from(cadence.on_position(t + 0.001));
        }
        assert_eq!((waited, steps), (1, 99));
    }

    #[test]
    fn slow_position_still_steps_at_the_attitude_rate() {
        let mut cadence = Cadence::new(0.05);
        let mut steps = 0;
        for index in 0..400 {
            let t = f64::from(index) * 0.05;
            steps += u32::from(cadence.on_attitude(t));
            if index % 4 == 0 {
                steps += u32::from(cadence.on_position(t));
            }
        }
        assert!((300..=400).contains(&steps), "{steps} steps");
    }

    #[test]
    fn a_lost_position_costs_no_lasting_lag() {
        let mut cadence = Cadence::new(0.05);
        let mut last = (0.0, false);
        for index in 0..100 {
            let t = f64::from(index) * 0.05;
            cadence.on_attitude(t);
            if index != 50 {
                last = (t, cadence.on_position(t));
            }
        }
        assert_eq!(last, (99.0 * 0.05, true));
    }
}
