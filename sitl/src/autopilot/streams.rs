//! Which message goes out on a link at which rate.
//!
//! Messages are sent on a common grid of time: one with an interval T goes out in the first loop after each
//! multiple of T. Messages of equal rate therefore leave in the same loop with the same time stamp, in the
//! order of [`MESSAGES`], whenever their rates were asked for.

use std::collections::BTreeMap;
use std::time::Duration;

use helmlink_wire::dialect::*;
use helmlink_wire::enums::*;

use super::parameters::*;

/// Fastest rate of any message: 80 % of the loop rate, as measured on ArduRover 4.6.
pub(super) const SHORTEST_INTERVAL: Duration = Duration::from_millis(25);

/// A group of messages that REQUEST_DATA_STREAM and the `SR0_` parameters set together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Group {
    /// Once a second, in no group.
    Heartbeat,
    RawSensors,
    ExtendedStatus,
    RcChannels,
    RawController,
    Position,
    Extra1,
    Extra2,
    Extra3,
    /// Sent only on a link that asked for it.
    OnDemand,
}

impl Group {
    /// The groups that a MAV_DATA_STREAM number stands for.
    fn has_number(self, stream: u8) -> bool {
        let number = match self {
            Self::Heartbeat | Self::OnDemand => return false,
            Self::RawSensors => MAV_DATA_STREAM_RAW_SENSORS,
            Self::ExtendedStatus => MAV_DATA_STREAM_EXTENDED_STATUS,
            Self::RcChannels => MAV_DATA_STREAM_RC_CHANNELS,
            Self::RawController => MAV_DATA_STREAM_RAW_CONTROLLER,
            Self::Position => MAV_DATA_STREAM_POSITION,
            Self::Extra1 => MAV_DATA_STREAM_EXTRA1,
            Self::Extra2 => MAV_DATA_STREAM_EXTRA2,
            Self::Extra3 => MAV_DATA_STREAM_EXTRA3,
        };
        stream == MAV_DATA_STREAM_ALL || stream == number
    }

    /// The parameter that holds the group's rate, Hz.
    fn rate(self) -> Option<Param> {
        match self {
            Self::Heartbeat | Self::OnDemand => None,
            Self::RawSensors => Some(SR0_RAW_SENS),
            Self::ExtendedStatus => Some(SR0_EXT_STAT),
            Self::RcChannels => Some(SR0_RC_CHAN),
            Self::RawController => Some(SR0_RAW_CTRL),
            Self::Position => Some(SR0_POSITION),
            Self::Extra1 => Some(SR0_EXTRA1),
            Self::Extra2 => Some(SR0_EXTRA2),
            Self::Extra3 => Some(SR0_EXTRA3),
        }
    }
}

/// Every message that can be streamed or requested, in the order in which those due together are sent.
/// ATTITUDE stands before GLOBAL_POSITION_INT so that a client may pair each position with the attitude
/// before it.
pub(super) const MESSAGES: &[(u32, Group)] = &[
    (HEARTBEAT_DATA::ID, Group::Heartbeat),
    (ATTITUDE_DATA::ID, Group::Extra1),
    (ATTITUDE_QUATERNION_DATA::ID, Group::OnDemand),
    (GLOBAL_POSITION_INT_DATA::ID, Group::Position),
    (LOCAL_POSITION_NED_DATA::ID, Group::Position),
    (VFR_HUD_DATA::ID, Group::Extra2),
    (SYS_STATUS_DATA::ID, Group::ExtendedStatus),
    (POWER_STATUS_DATA::ID, Group::ExtendedStatus),
    (MEMINFO_DATA::ID, Group::ExtendedStatus),
    (MISSION_CURRENT_DATA::ID, Group::ExtendedStatus),
    (FENCE_STATUS_DATA::ID, Group::ExtendedStatus),
    (GPS_RAW_INT_DATA::ID, Group::ExtendedStatus),
    (NAV_CONTROLLER_OUTPUT_DATA::ID, Group::ExtendedStatus),
    (POSITION_TARGET_GLOBAL_INT_DATA::ID, Group::ExtendedStatus),
    (SERVO_OUTPUT_RAW_DATA::ID, Group::RcChannels),
    (RC_CHANNELS_DATA::ID, Group::RcChannels),
    (RC_CHANNELS_SCALED_DATA::ID, Group::RawController),
    (RC_CHANNELS_RAW_DATA::ID, Group::OnDemand),
    (RAW_IMU_DATA::ID, Group::RawSensors),
    (SCALED_IMU_DATA::ID, Group::OnDemand),
    (SCALED_IMU2_DATA::ID, Group::RawSensors),
    (SCALED_PRESSURE_DATA::ID, Group::RawSensors),
    (SIMSTATE_DATA::ID, Group::Extra1),
    (AHRS2_DATA::ID, Group::Extra1),
    (AHRS_DATA::ID, Group::Extra3),
    (SYSTEM_TIME_DATA::ID, Group::Extra3),
    (BATTERY_STATUS_DATA::ID, Group::Extra3),
    (VIBRATION_DATA::ID, Group::Extra3),
    (EKF_STATUS_REPORT_DATA::ID, Group::Extra3),
    (EXTENDED_SYS_STATE_DATA::ID, Group::OnDemand),
    (HOME_POSITION_DATA::ID, Group::OnDemand),
    (GPS_GLOBAL_ORIGIN_DATA::ID, Group::OnDemand),
    (AUTOPILOT_VERSION_DATA::ID, Group::OnDemand),
    (HWSTATUS_DATA::ID, Group::OnDemand),
];

/// Whether this message can be streamed or requested at all.
pub(super) fn is_known(message_id: u32) -> bool {
    MESSAGES.iter().any(|&(id, _)| id == message_id)
}

/// The rates that a link's client has asked for; all others have their defaults.
#[derive(Debug, Clone, Default)]
pub(super) struct Streams {
    /// Interval by message id; zero for never.
    asked: BTreeMap<u32, Duration>,
    timetable: Option<Timetable>,
}

/// When each message goes out next: what fifty loops a second would otherwise divide anew for every message.
#[derive(Debug, Clone)]
struct Timetable {
    /// The revision of the parameters that it was made from.
    revision: u64,
    /// All up to here has gone out.
    until_ns: u64,
    /// When the first departure is due.
    next_ns: u64,
    departures: Vec<Departure>,
}

/// The next time that a message goes out.
#[derive(Debug, Clone)]
struct Departure {
    id: u32,
    period_ns: u64,
    next_ns: u64,
}

impl Departure {
    /// The first multiple of the period after `now_ns`.
    fn after(id: u32, period_ns: u64, now_ns: u64) -> Self {
        Self { id, period_ns, next_ns: (now_ns / period_ns + 1).saturating_mul(period_ns) }
    }
}

impl Timetable {
    fn first_ns(departures: &[Departure]) -> u64 {
        departures.iter().map(|departure| departure.next_ns).min().unwrap_or(u64::MAX)
    }

    /// What goes out up to `now_ns`.
    fn departing(&mut self, now_ns: u64) -> Vec<u32> {
        self.until_ns = now_ns;
        if now_ns < self.next_ns {
            return Vec::new();
        }
        let mut due = Vec::new();
        for departure in &mut self.departures {
            if departure.next_ns <= now_ns {
                due.push(departure.id);
                *departure = Departure::after(departure.id, departure.period_ns, now_ns);
            }
        }
        self.next_ns = Self::first_ns(&self.departures);
        due
    }
}

impl Streams {
    /// SET_MESSAGE_INTERVAL: an interval (shortened ones are capped), zero for never, `None` for the default.
    pub(super) fn set(&mut self, message_id: u32, interval: Option<Duration>) {
        self.timetable = None;
        match interval {
            Some(interval) if interval.is_zero() => self.asked.insert(message_id, interval),
            Some(interval) => self.asked.insert(message_id, interval.max(SHORTEST_INTERVAL)),
            None => self.asked.remove(&message_id),
        };
    }

    /// REQUEST_DATA_STREAM: one rate for a group, or for all of them; 0 Hz stops.
    pub(super) fn set_group(&mut self, stream: u8, rate_hz: u16) {
        let interval = match rate_hz {
            0 => Duration::ZERO,
            rate => Duration::from_secs(1) / u32::from(rate),
        };
        for &(id, group) in MESSAGES {
            if group.has_number(stream) {
                self.set(id, Some(interval));
            }
        }
    }

    /// The interval of a message; zero for never.
    pub(super) fn interval(&self, message_id: u32, parameters: &Parameters) -> Duration {
        let group = MESSAGES.iter().find(|&&(id, _)| id == message_id).map(|&(_, group)| group);
        self.interval_in(group.unwrap_or(Group::OnDemand), message_id, parameters)
    }

    fn interval_in(&self, group: Group, message_id: u32, parameters: &Parameters) -> Duration {
        if let Some(&asked) = self.asked.get(&message_id) {
            return asked;
        }
        if group == Group::Heartbeat {
            return Duration::from_secs(1);
        }
        let rate_hz = group.rate().map_or(0, |param| parameters.int(param));
        match u32::try_from(rate_hz) {
            Ok(rate) if rate > 0 => (Duration::from_secs(1) / rate).max(SHORTEST_INTERVAL),
            _ => Duration::ZERO,
        }
    }

    /// The messages to send between the loop at `before` (excluded) and the one at `now`, in order.
    pub(super) fn due(&mut self, before: Duration, now: Duration, parameters: &Parameters) -> Vec<u32> {
        let (before_ns, now_ns, revision) = (nanoseconds(before), nanoseconds(now), parameters.revision());
        let known = self.timetable.take();
        let mut timetable = known
            .filter(|timetable| timetable.revision == revision && timetable.until_ns == before_ns)
            .unwrap_or_else(|| self.timetable_from(before_ns, parameters));
        let due = timetable.departing(now_ns);
        self.timetable = Some(timetable);
        due
    }

    /// What goes out when, from `before_ns` (excluded) on.
    fn timetable_from(&self, before_ns: u64, parameters: &Parameters) -> Timetable {
        let periods = MESSAGES
            .iter()
            .map(|&(id, group)| (id, nanoseconds(self.interval_in(group, id, parameters))))
            .filter(|&(_, period_ns)| period_ns > 0);
        let departures: Vec<Departure> =
            periods.map(|(id, period_ns)| Departure::after(id, period_ns, before_ns)).collect();
        Timetable {
            revision: parameters.revision(),
            until_ns: before_ns,
            next_ns: Timetable::first_ns(&departures),
            departures,
        }
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::autopilot::LOOP;

    fn count(streams: &mut Streams, id: u32, seconds: u32) -> usize {
        let parameters = Parameters::new();
        let loops = seconds * 50;
        (1..=loops)
            .filter(|&number| streams.due(LOOP * (number - 1), LOOP * number, &parameters).contains(&id))
            .count()
    }

    #[test]
    fn defaults_are_one_per_second_and_on_demand_ones_are_silent() {
        let mut streams = Streams::default();
        assert_eq!(count(&mut streams, HEARTBEAT_DATA::ID, 10), 10);
        assert_eq!(count(&mut streams, ATTITUDE_DATA::ID, 10), 10);
        assert_eq!(count(&mut streams, HOME_POSITION_DATA::ID, 10), 0);
    }

    #[test]
    fn rates_are_kept_exactly_and_capped() {
        let mut streams = Streams::default();
        for (rate_hz, expected) in [(1, 10), (4, 40), (10, 100), (25, 250), (40, 400), (50, 400), (200, 400)]
        {
            streams.set(ATTITUDE_DATA::ID, Some(Duration::from_secs(1) / rate_hz));
            assert_eq!(count(&mut streams, ATTITUDE_DATA::ID, 10), expected, "{rate_hz} Hz");
        }
    }

    #[test]
    fn groups_change_together_and_can_be_stopped_and_reset() {
        let mut streams = Streams::default();
        streams.set_group(MAV_DATA_STREAM_POSITION, 5);
        assert_eq!(count(&mut streams, GLOBAL_POSITION_INT_DATA::ID, 2), 10);
        assert_eq!(count(&mut streams, LOCAL_POSITION_NED_DATA::ID, 2), 10);
        assert_eq!(count(&mut streams, ATTITUDE_DATA::ID, 2), 2);
        streams.set_group(MAV_DATA_STREAM_ALL, 0);
        assert_eq!(count(&mut streams, GLOBAL_POSITION_INT_DATA::ID, 2), 0);
        assert_eq!(count(&mut streams, HEARTBEAT_DATA::ID, 2), 2);
        streams.set(GLOBAL_POSITION_INT_DATA::ID, None);
        assert_eq!(count(&mut streams, GLOBAL_POSITION_INT_DATA::ID, 2), 2);
    }

    #[test]
    fn messages_of_one_rate_leave_together_attitude_first() {
        let parameters = Parameters::new();
        let mut streams = Streams::default();
        let interval = Some(Duration::from_millis(100));
        streams.set(GLOBAL_POSITION_INT_DATA::ID, interval);
        streams.set(ATTITUDE_DATA::ID, interval);
        for number in 1..200 {
            let due = streams.due(LOOP * (number - 1), LOOP * number, &parameters);
            let at = |id| due.iter().position(|&due| due == id);
            let (attitude, position) = (at(ATTITUDE_DATA::ID), at(GLOBAL_POSITION_INT_DATA::ID));
            assert_eq!(attitude.is_some(), position.is_some());
            assert!(attitude <= position);
        }
    }

    #[test]
    fn a_changed_parameter_or_a_restart_is_followed_at_once() {
        let mut parameters = Parameters::new();
        let mut streams = Streams::default();
        let due = |streams: &mut Streams, parameters: &Parameters, number: u32| {
            streams.due(LOOP * (number - 1), LOOP * number, parameters).contains(&ATTITUDE_DATA::ID)
        };
        assert_eq!((1..=50).filter(|&number| due(&mut streams, &parameters, number)).count(), 1);
        parameters.put(SR0_EXTRA1, 10.0);
        assert_eq!((51..=100).filter(|&number| due(&mut streams, &parameters, number)).count(), 10);
        assert_eq!((1..=50).filter(|&number| due(&mut streams, &parameters, number)).count(), 10);
    }

    proptest! {
        #[test]
        fn any_interval_gives_its_rate(interval_ms in 25u64..5000) {
            let mut streams = Streams::default();
            streams.set(ATTITUDE_DATA::ID, Some(Duration::from_millis(interval_ms)));
            let expected = 20_000 / interval_ms as usize;
            let sent = count(&mut streams, ATTITUDE_DATA::ID, 20);
            prop_assert!(sent.abs_diff(expected) <= 1, "{sent} instead of {expected}");
        }
    }
}
