//! Times and what is said of them.

use std::fmt;
use std::time::Duration;

/// Times from question to answer.
#[derive(Debug, Default)]
pub(crate) struct Latencies {
    micros: Vec<f64>,
    questions: usize,
}

impl Latencies {
    pub(crate) fn question(&mut self) {
        self.questions += 1;
    }

    pub(crate) fn answer(&mut self, after: Duration) {
        self.micros.push(after.as_secs_f64() * 1e6);
    }

    pub(crate) fn and(mut self, other: Self) -> Self {
        self.micros.extend(other.micros);
        self.questions += other.questions;
        self
    }

    pub(crate) fn p99_us(&self) -> f64 {
        self.quantile_us(0.99)
    }

    fn quantile_us(&self, share: f64) -> f64 {
        let mut sorted = self.micros.clone();
        sorted.sort_by(f64::total_cmp);
        let at = (share * sorted.len() as f64) as usize;
        sorted.get(at.min(sorted.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
    }
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
