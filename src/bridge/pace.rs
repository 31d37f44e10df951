//! How evenly the steering frames go out.

use std::time::Duration;

/// Share of a new interval in the running mean.
const SMOOTHING: f64 = 0.02;

/// Rate and jitter of the steering frames, on the vehicle's clock.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pace {
    last: Option<Duration>,
    mean_s: f64,
    deviation_s: f64,
    longest_s: f64,
}

impl Pace {
    /// A frame goes out.
    pub(super) fn on_frame(&mut self, now: Duration) {
        if let Some(last) = self.last.replace(now) {
            let interval_s = now.saturating_sub(last).as_secs_f64();
            let is_first = self.mean_s == 0.0;
            let share = if is_first { 1.0 } else { SMOOTHING };
            self.deviation_s += SMOOTHING * ((interval_s - self.mean_s).abs() - self.deviation_s);
            self.mean_s += share * (interval_s - self.mean_s);
            if is_first {
                self.deviation_s = 0.0;
            }
            self.longest_s = self.longest_s.max(interval_s);
        }
    }

    /// No frame is due any more.
    pub(super) fn pause(&mut self) {
        self.last = None;
    }

    /// The longest interval starts anew: it is told once a report.
    pub(super) fn start_over(&mut self) {
        self.longest_s = 0.0;
    }

    /// How long ago the last frame went out, seconds; none while none is due.
    pub(super) fn age_s(&self, now: Duration) -> Option<f64> {
        self.last.map(|last| now.saturating_sub(last).as_secs_f64())
    }

    /// Frames per second.
    pub fn rate_hz(&self) -> f64 {
        if self.mean_s > 0.0 { 1.0 / self.mean_s } else { 0.0 }
    }

    /// Mean deviation of the intervals from their mean, milliseconds.
    pub fn jitter_ms(&self) -> f64 {
        self.deviation_s * 1000.0
    }

    /// The longest interval since the last report, milliseconds.
    pub fn longest_ms(&self) -> f64 {
        self.longest_s * 1000.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_rate_and_jitter() {
        let mut pace = Pace::default();
        let mut now = Duration::ZERO;
        for step in 0..2000_u64 {
            now += Duration::from_millis(if step % 2 == 0 { 36 } else { 44 });
            pace.on_frame(now);
        }
        assert!((pace.rate_hz() - 25.0).abs() < 0.1, "{}", pace.rate_hz());
        assert!((pace.jitter_ms() - 4.0).abs() < 0.3, "{}", pace.jitter_ms());
        assert!((pace.longest_ms() - 44.0).abs() < 1e-9);
        pace.pause();
        pace.start_over();
        pace.on_frame(now + Duration::from_secs(60));
        assert_eq!(pace.longest_ms(), 0.0, "a pause is no jitter");
    }
}
