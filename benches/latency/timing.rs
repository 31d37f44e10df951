//! Times and what is said of them.

use std::fmt;
use std::time::{Duration, Instant};

/// Times from question to answer.
#[derive(Debug, Default)]
pub(crate) struct Latencies {
    micros: Vec<f64>,
    questions: usize,
    last_answer: Option<Instant>,
    /// Times between answers, milliseconds.
    intervals_ms: Vec<f64>,
}

impl Latencies {
    pub(crate) fn question(&mut self) {
        self.questions += 1;
    }

    pub(crate) fn answer(&mut self, asked: Instant, now: Instant) {
        self.micros.push((now - asked).as_secs_f64() * 1e6);
        if let Some(last) = self.last_answer.replace(now) {
            self.intervals_ms.push((now - last).as_secs_f64() * 1e3);
        }
    }

    pub(crate) fn and(mut self, other: Self) -> Self {
        self.micros.extend(other.micros);
        self.intervals_ms.extend(other.intervals_ms);
        self.questions += other.questions;
        self
    }

    pub(crate) fn p99_us(&self) -> f64 {
        self.quantile_us(0.99)
    }

    /// By how much the time between two answers misses the usual one, 99th percentile, milliseconds.
    pub(crate) fn jitter_ms(&self, usual: Duration) -> f64 {
        let usual_ms = usual.as_secs_f64() * 1e3;
        quantile(self.intervals_ms.iter().map(|interval_ms| (interval_ms - usual_ms).abs()), 0.99)
    }

    fn quantile_us(&self, share: f64) -> f64 {
        quantile(self.micros.iter().copied(), share)
    }
}

fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let at = (share * sorted.len() as f64) as usize;
    sorted.get(at.min(sorted.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
}

impl fmt::Display for Latencies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [p50, p99, max] = [0.5, 0.99, 1.0].map(|share| self.quantile_us(share));
        write!(
            f,
            "{p50:>10.0}{p99:>10.0}{max:>10.0}{:>10}",
            format!("{}/{}", self.micros.len(), self.questions)
        )
    }
}
