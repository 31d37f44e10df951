//! When a message is to be sent, and whether once more.

use std::time::Duration;

use super::Timing;

/// The one outstanding message of an exchange: due now, waited for, or not at all.
#[derive(Debug, Clone, Copy)]
pub(super) struct Attempts {
    timing: Timing,
    state: State,
}

#[derive(Debug, Clone, Copy)]
enum State {
    /// To be sent at the next opportunity.
    Due,
    /// Sent; to be sent again at this time.
    Waiting { until: Duration },
}

impl Attempts {
    pub(super) fn new(timing: Timing) -> Self {
        Self { timing, state: State::Due }
    }

    pub(super) fn make_due(&mut self) {
        self.state = State::Due;
    }

    pub(super) fn is_due(&self, now: Duration) -> bool {
        match self.state {
            State::Due => true,
            State::Waiting { until } => now >= until,
        }
    }

    /// Zero when something is to be sent at once.
    pub(super) fn deadline(&self) -> Duration {
        match self.state {
            State::Due => Duration::ZERO,
            State::Waiting { until } => until,
        }
    }

    /// Whether a message sent `sent` times may be sent once more.
    pub(super) fn left(&self, sent: u32) -> bool {
        sent < self.timing.attempts.max(1)
    }

    pub(super) fn wait_for_first_reply(&mut self, now: Duration) {
        self.state = State::Waiting { until: now + self.timing.first_reply };
    }

    pub(super) fn wait_for_next_reply(&mut self, now: Duration) {
        self.state = State::Waiting { until: now + self.timing.next_reply };
    }
}
