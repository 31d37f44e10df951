//! How long to wait before trying again, and how often to speak about it.

use std::time::Duration;

/// Waiting times that double from a first to a longest one.
#[derive(Debug, Clone)]
pub(super) struct Backoff {
    first: Duration,
    longest: Duration,
    next: Duration,
}

impl Backoff {
    /// Starts at `first`; a `longest` below `first` counts as `first`.
    pub(super) fn new(first: Duration, longest: Duration) -> Self {
        Self { first, longest: longest.max(first), next: first }
    }

    /// The time to wait now; the following one is twice as long.
    pub(super) fn next_delay(&mut self) -> Duration {
        let delay = self.next;
        self.next = (delay * 2).min(self.longest);
        delay
    }

    /// Starts over at the first waiting time.
    pub(super) fn reset(&mut self) {
        self.next = self.first;
    }
}

/// Decides which of many failures in a row deserve a line in the log: the first, then the 2nd, 4th, 8th
/// and so on, and any whose reason differs from the one before.
#[derive(Debug, Default)]
pub(super) struct Complaints {
    failures: u64,
    last_reason: String,
}

impl Complaints {
    /// Counts one failure; true when it should be reported.
    pub(super) fn is_news(&mut self, reason: &str) -> bool {
        if reason != self.last_reason {
            self.failures = 0;
            reason.clone_into(&mut self.last_reason);
        }
        self.failures += 1;
        self.failures.is_power_of_two()
    }

    /// Forgets the failures: the next one is news again.
    pub(super) fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn delays_ms(backoff: &mut Backoff, count: usize) -> Vec<u128> {
        (0..count).map(|_| backoff.next_delay().as_millis()).collect()
    }

    #[test]
    fn doubles_up_to_the_longest_and_starts_over() {
        let mut backoff = Backoff::new(Duration::from_millis(100), Duration::from_secs(5));
        assert_eq!(delays_ms(&mut backoff, 8), [100, 200, 400, 800, 1600, 3200, 5000, 5000]);
        backoff.reset();
        assert_eq!(delays_ms(&mut backoff, 2), [100, 200]);
    }

    #[test]
    fn a_longest_below_the_first_keeps_the_first() {
        let mut backoff = Backoff::new(Duration::from_millis(100), Duration::ZERO);
        assert_eq!(delays_ms(&mut backoff, 3), [100, 100, 100]);
    }

    #[test]
    fn repeated_failures_are_reported_at_growing_intervals() {
        let mut complaints = Complaints::default();
        let reported: Vec<u32> = (1..=40).filter(|_| complaints.is_news("no such device")).collect();
        assert_eq!(reported, [1, 2, 4, 8, 16, 32]);
        assert!(complaints.is_news("permission denied"));
        complaints.reset();
        assert!(complaints.is_news("permission denied"));
    }
}
