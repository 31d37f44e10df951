//! Asks the flight controller for the messages that steering needs, and asks again when they stop.

use std::time::Duration;

use helmlink_wire::dialect::{COMMAND_LONG_DATA, MessageData};
use helmlink_wire::{Identity, Message, dialect, enums};

/// A request is repeated when its message has not come for this many of its intervals…
const MISSING_INTERVALS: f64 = 10.0;
/// …but not more often than this. ArduRover drops requests that come before it has
/// finished starting (measured on 4.6), so asking once is not enough.
const REPEAT_S: f64 = 2.0;

/// A message that comes in less than this share of what was asked for has been asked for differently by somebody else…
const SLOW_SHARE: f64 = 0.5;
/// …over this long. A link that loses a fifth of everything is not slow.
const RATE_WINDOW_S: f64 = 3.0;
/// A vehicle that stays slow after so many requests cannot do better: it is left alone for a while.
const PATIENCE: u32 = 3;
/// How long, seconds.
const RESIGNED_S: f64 = 30.0;

/// One message and how often it is wanted.
#[derive(Debug, Clone)]
struct Wanted {
    message_id: u32,
    interval_s: f64,
    last_seen: Option<Duration>,
    last_asked: Option<Duration>,
    window_start: Option<Duration>,
    in_window: u32,
    is_slow: bool,
    asked_slow: u32,
}

impl Wanted {
    fn new(message_id: u32, interval_s: f64) -> Self {
        Self {
            message_id,
            interval_s,
            last_seen: None,
            last_asked: None,
            window_start: None,
            in_window: 0,
            is_slow: false,
            asked_slow: 0,
        }
    }

    /// Counts what comes, and compares it with what was asked for.
    fn on_message(&mut self, now: Duration) {
        self.last_seen = Some(now);
        let start = *self.window_start.get_or_insert(now);
        self.in_window += 1;
        let length_s = now.saturating_sub(start).as_secs_f64();
        if length_s >= RATE_WINDOW_S.max(5.0 * self.interval_s) {
            let expected = length_s / self.interval_s;
            self.is_slow = f64::from(self.in_window) < SLOW_SHARE * expected;
            if !self.is_slow {
                self.asked_slow = 0;
            }
            (self.window_start, self.in_window) = (Some(now), 0);
        }
    }

    fn on_request(&mut self, now: Duration) {
        self.last_asked = Some(now);
        if std::mem::take(&mut self.is_slow) {
            self.asked_slow += 1;
        }
        (self.window_start, self.in_window) = (None, 0);
    }
}

/// The bridge's message intervals on one vehicle.
#[derive(Debug, Clone)]
pub struct StreamRequests {
    wanted: Vec<Wanted>,
}

impl StreamRequests {
    /// Everything the bridge listens to: position, attitude and heartbeat every `control_interval_s`, the rest slower.
    pub fn new(control_interval_s: f64) -> Self {
        let wanted = Wanted::new;
        Self {
            wanted: vec![
                wanted(dialect::ATTITUDE_DATA::ID, control_interval_s),
                wanted(dialect::GLOBAL_POSITION_INT_DATA::ID, control_interval_s),
                // The heartbeat carries the mode: at 1 Hz a pilot who takes over would be noticed a second late.
                wanted(dialect::HEARTBEAT_DATA::ID, control_interval_s),
                wanted(dialect::EKF_STATUS_REPORT_DATA::ID, 0.5),
                wanted(dialect::MISSION_CURRENT_DATA::ID, 0.5),
                wanted(dialect::SYS_STATUS_DATA::ID, 1.0),
            ],
        }
    }

    /// Notes that a message has come.
    pub fn on_message(&mut self, now: Duration, message_id: u32) {
        if let Some(wanted) = self.wanted.iter_mut().find(|wanted| wanted.message_id == message_id) {
            wanted.on_message(now);
        }
    }

    /// The next request that is due, if any.
    pub fn poll(&mut self, now: Duration, vehicle: Identity) -> Option<Message> {
        let age_s = |then: Duration| now.saturating_sub(then).as_secs_f64();
        let due = self.wanted.iter_mut().find(|wanted| {
            let patience_s = if wanted.asked_slow >= PATIENCE { RESIGNED_S } else { REPEAT_S };
            let repeat_s = if wanted.is_slow { patience_s.max(RATE_WINDOW_S) } else { REPEAT_S };
            let asked_lately = wanted.last_asked.is_some_and(|then| age_s(then) < repeat_s);
            let limit_s = (MISSING_INTERVALS * wanted.interval_s).max(REPEAT_S);
            let coming = wanted.last_asked.is_some()
                && !wanted.is_slow
                && wanted.last_seen.is_some_and(|then| age_s(then) < limit_s);
            !asked_lately && !coming
        })?;
        due.on_request(now);
        Some(set_message_interval(vehicle, due.message_id, due.interval_s))
    }

    /// Asks for everything again: after a reboot of the flight controller.
    pub fn ask_again(&mut self) {
        for wanted in &mut self.wanted {
            *wanted = Wanted::new(wanted.message_id, wanted.interval_s);
        }
    }
}

/// MAV_CMD_SET_MESSAGE_INTERVAL.
fn set_message_interval(vehicle: Identity, message_id: u32, interval_s: f64) -> Message {
    command_long(
        vehicle,
        enums::MAV_CMD_SET_MESSAGE_INTERVAL,
        [message_id as f32, (interval_s * 1e6) as f32, 0.0],
    )
}

/// COMMAND_LONG with its first three parameters; the others are zero.
pub fn command_long(vehicle: Identity, command: u16, params: [f32; 3]) -> Message {
    Message::COMMAND_LONG(COMMAND_LONG_DATA {
        target_system: vehicle.system,
        target_component: vehicle.component,
        command,
        param1: params[0],
        param2: params[1],
        param3: params[2],
        ..COMMAND_LONG_DATA::DEFAULT
    })
}

/// A request for a flight mode, as MAV_CMD_DO_SET_MODE, which is acknowledged (SET_MODE is not).
pub fn set_mode(vehicle: Identity, mode: super::Mode) -> Message {
    let custom = f32::from(enums::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED);
    command_long(vehicle, enums::MAV_CMD_DO_SET_MODE, [custom, mode.0 as f32, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    const VEHICLE: Identity = Identity { system: 1, component: 1 };

    fn asked(streams: &mut StreamRequests, now: Duration) -> usize {
        std::iter::from_fn(|| streams.poll(now, VEHICLE)).count()
    }

    #[test]
    fn asks_once_then_only_for_what_stopped() {
        let mut streams = StreamRequests::new(0.04);
        let all = asked(&mut streams, Duration::ZERO);
        assert_eq!(all, 6);
        for tenth in 1..100 {
            let now = Duration::from_millis(tenth * 100);
            for id in [0, 1, 30, 33, 42, 193] {
                if id != 33 || tenth < 50 {
                    streams.on_message(now, id);
                    streams.on_message(now, id);
                }
            }
            let again = asked(&mut streams, now);
            let expected = usize::from(tenth == 69 || tenth == 89);
            assert_eq!(again, expected, "at {tenth} tenths of a second");
        }
    }

    #[test]
    fn a_rate_that_somebody_else_has_lowered_is_asked_for_again_but_not_for_ever() {
        let mut streams = StreamRequests::new(0.04);
        asked(&mut streams, Duration::ZERO);
        let mut again = 0;
        for tenth in 1..900 {
            let now = Duration::from_millis(tenth * 100);
            for id in [0, 1, 30, 42, 193] {
                streams.on_message(now, id);
                streams.on_message(now, id);
            }
            if tenth % 10 == 0 {
                streams.on_message(now, 33);
            }
            again += asked(&mut streams, now);
        }
        assert!((3..=6).contains(&again), "{again} requests in 90 s");
    }

    #[test]
    fn a_default_rate_is_not_taken_for_an_answer() {
        let mut streams = StreamRequests::new(0.04);
        streams.on_message(Duration::ZERO, 30);
        assert_eq!(asked(&mut streams, Duration::ZERO), 6);
    }
}
