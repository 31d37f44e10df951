//! How long a command is under way: the round trip of a TIMESYNC question.
//!
//! The flight controller answers with our own time stamp (MAVLink's time synchronisation protocol), so the trip there
//! and back is measured on one clock. That is the part of the loop's delay that differs from link to link: the old
//! telemetry on its way here and the command on its way there.

use std::time::Duration;

use helmlink_wire::dialect::TIMESYNC_DATA;
use helmlink_wire::{Identity, Message};

/// Time between two questions.
const INTERVAL: Duration = Duration::from_millis(1000);
/// Round trips remembered; their median is believed, so that single stragglers do no harm.
const REMEMBERED: usize = 5;
/// Round trips longer than this are no measurement.
const LONGEST_S: f64 = 5.0;

/// Asks, and keeps the answers.
#[derive(Debug, Clone, Default)]
pub struct LoopDelay {
    last_question: Option<Duration>,
    trips_s: [f64; REMEMBERED],
    count: usize,
}

impl LoopDelay {
    /// The flight controller is new: nothing measured before holds.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// The next question to `vehicle`, when one is due.
    pub fn poll(&mut self, now: Duration, vehicle: Identity) -> Option<Message> {
        if self.last_question.is_some_and(|then| now.saturating_sub(then) < INTERVAL) {
            return None;
        }
        self.last_question = Some(now);
        Some(Message::TIMESYNC(TIMESYNC_DATA {
            tc1: 0,
            ts1: i64::try_from(now.as_nanos()).ok()?,
            target_system: vehicle.system,
            target_component: vehicle.component,
        }))
    }

    /// A TIMESYNC of the flight controller, which may be an answer to ours.
    pub fn on_timesync(&mut self, now: Duration, data: &TIMESYNC_DATA) {
        let Ok(asked_ns) = u64::try_from(data.ts1) else { return };
        if data.tc1 == 0 || asked_ns == 0 {
            return;
        }
        let Some(trip) = now.checked_sub(Duration::from_nanos(asked_ns)) else { return };
        if trip.as_secs_f64() < LONGEST_S {
            self.trips_s[self.count % REMEMBERED] = trip.as_secs_f64();
            self.count += 1;
        }
    }

    /// The median round trip, s; none before enough answers have come.
    #[must_use]
    pub fn seconds(&self) -> Option<f64> {
        if self.count < REMEMBERED / 2 + 1 {
            return None;
        }
        let mut sorted = self.trips_s;
        let known = &mut sorted[..self.count.min(REMEMBERED)];
        known.sort_unstable_by(f64::total_cmp);
        Some(known[known.len() / 2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VEHICLE: Identity = Identity { system: 1, component: 1 };

    fn answer(delay: &mut LoopDelay, asked: Duration, trip_ms: u64) {
        let Some(Message::TIMESYNC(question)) = delay.poll(asked, VEHICLE) else { panic!("due") };
        let reply = TIMESYNC_DATA { tc1: 1, ..question };
        delay.on_timesync(asked + Duration::from_millis(trip_ms), &reply);
    }

    #[test]
    fn the_median_of_the_last_trips_is_believed() {
        let mut delay = LoopDelay::default();
        for (second, trip_ms) in [(1, 100), (2, 900), (3, 120)] {
            assert_eq!(delay.seconds(), None);
            answer(&mut delay, Duration::from_secs(second), trip_ms);
        }
        assert_eq!(delay.seconds(), Some(0.12));
        for second in 4..9 {
            answer(&mut delay, Duration::from_secs(second), 400);
        }
        assert_eq!(delay.seconds(), Some(0.4));
        delay.forget();
        assert_eq!(delay.seconds(), None);
    }

    #[test]
    fn one_question_a_second() {
        let mut delay = LoopDelay::default();
        let questions =
            (0..100).filter(|tick| delay.poll(Duration::from_millis(tick * 50), VEHICLE).is_some());
        assert_eq!(questions.count(), 5);
    }

    #[test]
    fn what_is_no_answer_to_ours_is_ignored() {
        let mut delay = LoopDelay::default();
        for (tc1, ts1) in [(0, 5), (7, 0), (7, -3), (7, i64::MAX)] {
            for _ in 0..5 {
                delay.on_timesync(
                    Duration::from_secs(9),
                    &TIMESYNC_DATA { tc1, ts1, ..TIMESYNC_DATA::DEFAULT },
                );
            }
        }
        delay.on_timesync(
            Duration::from_secs(900),
            &TIMESYNC_DATA { tc1: 7, ts1: 5, ..TIMESYNC_DATA::DEFAULT },
        );
        assert_eq!(delay.count, 0);
    }
}
