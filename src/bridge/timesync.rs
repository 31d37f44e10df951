//! TIMESYNC: tells the flight controller the time when it asks, and measures how far away it is.
//!
//! Source: <https://mavlink.io/en/services/timesync.html>.

use std::time::Duration;

use helmlink_wire::dialect::TIMESYNC_DATA;
use helmlink_wire::{Identity, Message};

/// Time between two questions: longer than any delay that a boat can still be steered across.
const INTERVAL: Duration = Duration::from_secs(2);
/// Round trips remembered; their median is believed, so that single stragglers do no harm.
const REMEMBERED: usize = 5;
/// Answers later than this belong to no question that still matters.
const TIMEOUT: Duration = Duration::from_secs(5);

/// One side of the exchange with the flight controller, on the driver's clock.
#[derive(Debug, Clone, Default)]
pub(super) struct TimeSync {
    asked: Option<Duration>,
    round_trip: Option<Duration>,
    trips: [Duration; REMEMBERED],
    count: usize,
}

impl TimeSync {
    /// The question, when it is due.
    pub(super) fn poll(&mut self, now: Duration, vehicle: Identity) -> Option<Message> {
        if self.asked.is_some_and(|then| now.saturating_sub(then) < INTERVAL) {
            return None;
        }
        self.asked = Some(now);
        Some(message(0, nanoseconds(now), vehicle))
    }

    /// Takes a TIMESYNC of the vehicle; returns the answer if it was a question.
    pub(super) fn on_message(
        &mut self,
        now: Duration,
        from: Identity,
        data: &TIMESYNC_DATA,
    ) -> Option<Message> {
        if data.tc1 == 0 {
            return Some(message(nanoseconds(now), data.ts1, from));
        }
        let asked = self.asked.filter(|asked| nanoseconds(*asked) == data.ts1);
        let trip = asked.map(|asked| now.saturating_sub(asked)).filter(|trip| *trip < TIMEOUT);
        if let Some(trip) = trip {
            self.trips[self.count % REMEMBERED] = trip;
            self.count += 1;
        }
        self.round_trip = trip.or(self.round_trip);
        None
    }

    /// The median of the last round trips: the part of the control loop's delay that differs from link to link, the
    /// telemetry's way here and the command's way there.
    pub(super) fn usual_trip(&self) -> Option<Duration> {
        let mut sorted = self.trips;
        let known = &mut sorted[..self.count.min(REMEMBERED)];
        known.sort_unstable();
        known.get(known.len() / 2).copied()
    }

    /// How long a question and its answer took the last time.
    pub(super) fn round_trip(&self) -> Option<Duration> {
        self.round_trip
    }
}

/// Never zero: that would be a question.
fn nanoseconds(time: Duration) -> i64 {
    i64::try_from(time.as_nanos()).unwrap_or(i64::MAX).max(1)
}

fn message(tc1: i64, ts1: i64, to: Identity) -> Message {
    let (target_system, target_component) = (to.system, to.component);
    Message::TIMESYNC(TIMESYNC_DATA { tc1, ts1, target_system, target_component })
}

#[cfg(test)]
mod tests {
    use super::*;

    const VEHICLE: Identity = Identity { system: 1, component: 1 };

    fn content(message: Option<Message>) -> TIMESYNC_DATA {
        let Some(Message::TIMESYNC(data)) = message else { panic!("{message:?}") };
        data
    }

    #[test]
    fn measures_the_way_there_and_back() {
        let mut sync = TimeSync::default();
        let question = content(sync.poll(Duration::ZERO, VEHICLE));
        assert_eq!(question.tc1, 0);
        assert!(sync.poll(Duration::from_secs(1), VEHICLE).is_none());
        let late = TIMESYNC_DATA { tc1: 77, ts1: question.ts1 + 1, ..question };
        assert!(sync.on_message(Duration::from_millis(20), VEHICLE, &late).is_none());
        assert_eq!(sync.round_trip(), None, "somebody else's");
        let answer = TIMESYNC_DATA { tc1: 77, ..question };
        assert!(sync.on_message(Duration::from_millis(30), VEHICLE, &answer).is_none());
        assert_eq!(sync.round_trip(), Some(Duration::from_millis(30)));
    }

    #[test]
    fn the_median_of_the_last_trips_is_the_usual_one() {
        let mut sync = TimeSync::default();
        assert_eq!(sync.usual_trip(), None);
        for (index, trip_ms) in (0..).zip([100, 900, 120, 110, 105, 400, 400, 400]) {
            let asked = INTERVAL * index;
            let question = content(sync.poll(asked, VEHICLE));
            let answer = TIMESYNC_DATA { tc1: 77, ..question };
            sync.on_message(asked + Duration::from_millis(trip_ms), VEHICLE, &answer);
            if index == 4 {
                assert_eq!(sync.usual_trip(), Some(Duration::from_millis(110)));
            }
        }
        assert_eq!(sync.usual_trip(), Some(Duration::from_millis(400)));
    }

    #[test]
    fn answers_with_what_it_was_asked_with() {
        let question = TIMESYNC_DATA { tc1: 0, ts1: 123, ..TIMESYNC_DATA::DEFAULT };
        let answer = content(TimeSync::default().on_message(Duration::from_secs(2), VEHICLE, &question));
        assert_eq!((answer.ts1, answer.tc1), (123, 2_000_000_000));
    }
}
