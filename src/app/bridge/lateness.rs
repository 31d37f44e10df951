//! How regularly the control loop steps, and how soon after the telemetry that drives it.

use std::time::Duration;

/// Steps that are looked back on: forty seconds at the usual rate.
const WINDOW: usize = 1000;

/// Times of the latest control steps.
#[derive(Debug, Default)]
pub(super) struct Lateness {
    steps: u64,
    last: Option<Duration>,
    /// Of each step: by how much its interval missed the usual one, and the time from taking the bytes to handing
    /// over the command, both in seconds.
    intervals: Ring,
    handling: Ring,
}

/// The 99th percentiles and the largest, in seconds, over the latest steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Quantiles {
    pub(super) p50_s: f64,
    pub(super) p99_s: f64,
    pub(super) max_s: f64,
}

impl Lateness {
    /// The loop has come round: bytes taken at `began` were handled by `ended`, and `steps` have been made in all.
    pub(super) fn on_turn(&mut self, began: Duration, ended: Duration, steps: u64, interval: Duration) {
        if !self.is_news(steps) {
            return;
        }
        // Several steps in one turn: what held them up has held up the first most.
        let made = (steps - self.steps).min(WINDOW as u64) as u32;
        self.steps = steps;
        self.handling.push(ended.saturating_sub(began).as_secs_f64());
        if let Some(last) = self.last.replace(ended) {
            let expected = interval * made;
            self.intervals.push(ended.saturating_sub(last).abs_diff(expected).as_secs_f64());
        }
    }

    /// Whether steps have been made since the last turn.
    pub(super) fn is_news(&self, steps: u64) -> bool {
        steps != self.steps
    }

    /// By how much the intervals between steps miss the usual one.
    pub(super) fn jitter(&self) -> Option<Quantiles> {
        self.intervals.quantiles()
    }

    /// From telemetry to command.
    pub(super) fn handling(&self) -> Option<Quantiles> {
        self.handling.quantiles()
    }
}

/// The latest values.
#[derive(Debug, Default)]
struct Ring {
    values: Vec<f64>,
    next: usize,
}

impl Ring {
    fn push(&mut self, value: f64) {
        if self.values.len() < WINDOW {
            self.values.push(value);
        } else {
            self.values[self.next] = value;
        }
        self.next = (self.next + 1) % WINDOW;
    }

    fn quantiles(&self) -> Option<Quantiles> {
        let mut sorted = self.values.clone();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let index = (share * sorted.len() as f64) as usize;
            sorted.get(index.min(sorted.len().saturating_sub(1))).copied()
        };
        Some(Quantiles { p50_s: at(0.5)?, p99_s: at(0.99)?, max_s: at(1.0)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERVAL: Duration = Duration::from_millis(40);

    #[test]
    fn an_even_loop_has_no_jitter_and_a_hiccup_shows() {
        let mut lateness = Lateness::default();
        assert_eq!(lateness.jitter(), None);
        let mut now = Duration::ZERO;
        for step in 1..=300 {
            now += if step == 200 { 3 * INTERVAL } else { INTERVAL };
            lateness.on_turn(now - Duration::from_micros(50), now, step, INTERVAL);
            lateness.on_turn(now, now + INTERVAL / 2, step, INTERVAL);
        }
        let jitter = lateness.jitter().unwrap();
        assert!(jitter.p50_s < 1e-9 && (jitter.max_s - 0.08).abs() < 1e-9, "{jitter:?}");
        assert!(
            (lateness.handling().unwrap().p99_s - 50e-6).abs() < 1e-9,
            "turns without a step do not count"
        );
    }

    #[test]
    fn only_the_latest_steps_count() {
        let mut ring = Ring::default();
        (0..WINDOW).for_each(|_| ring.push(9.0));
        (0..WINDOW).for_each(|_| ring.push(1.0));
        assert_eq!(ring.quantiles(), Some(Quantiles { p50_s: 1.0, p99_s: 1.0, max_s: 1.0 }));
    }
}
