//! When which frame of a log is due, played at any pace: pause, seek, loop, filters.

use std::io::{self, Read, Seek, SeekFrom};
use std::time::Duration;

use helmlink_wire::dialect::MessageSet;
use helmlink_wire::tlog::{Index, TlogReader};
use helmlink_wire::{Frame, Identity, Message};

/// Frames that make a vehicle do something or change what it has stored. They are played only when asked for.
const COMMANDS: [&str; 34] = [
    "SET_MODE",
    "COMMAND_LONG",
    "COMMAND_INT",
    "COMMAND_CANCEL",
    "PARAM_SET",
    "PARAM_EXT_SET",
    "PARAM_MAP_RC",
    "MISSION_COUNT",
    "MISSION_ITEM",
    "MISSION_ITEM_INT",
    "MISSION_SET_CURRENT",
    "MISSION_CLEAR_ALL",
    "MISSION_WRITE_PARTIAL_LIST",
    "RC_CHANNELS_OVERRIDE",
    "MANUAL_CONTROL",
    "MANUAL_SETPOINT",
    "SET_ATTITUDE_TARGET",
    "SET_POSITION_TARGET_LOCAL_NED",
    "SET_POSITION_TARGET_GLOBAL_INT",
    "SET_ACTUATOR_CONTROL_TARGET",
    "SET_GPS_GLOBAL_ORIGIN",
    "SET_HOME_POSITION",
    "SET_MAG_OFFSETS",
    "SETUP_SIGNING",
    "CHANGE_OPERATOR_CONTROL",
    "AUTH_KEY",
    "FENCE_POINT",
    "RALLY_POINT",
    "FILE_TRANSFER_PROTOCOL",
    "SERIAL_CONTROL",
    "GPS_INPUT",
    "GPS_RTCM_DATA",
    "GPS_INJECT_DATA",
    "SECURE_COMMAND",
];

/// Which frames are played.
#[derive(Debug, Clone, Default)]
pub struct PlayFilter {
    /// Only these messages; all where none is named.
    pub only: Vec<u32>,
    /// Never these.
    pub except: Vec<u32>,
    /// Only these systems; all where none is named.
    pub systems: Vec<u8>,
    /// Commands too.
    pub commands: bool,
}

impl PlayFilter {
    /// Whether a frame is played.
    pub fn passes(&self, frame: &Frame<'_>) -> bool {
        let (id, from) = (frame.message_id(), frame.identity());
        (self.only.is_empty() || self.only.contains(&id))
            && !self.except.contains(&id)
            && (self.systems.is_empty() || self.systems.contains(&from.system))
            && (self.commands || !is_command(frame))
    }
}

/// Nobody knows what an unknown message asks for.
fn is_command(frame: &Frame<'_>) -> bool {
    !frame.is_verified() || frame.name().is_some_and(|name| COMMANDS.contains(&name))
}

/// The number of a message by its name, or a number itself.
pub fn message_id(name: &str) -> Option<u32> {
    let known = |id: &u32| {
        Message::default_message_from_id(*id)
            .is_some_and(|message| message.message_name().eq_ignore_ascii_case(name))
    };
    name.parse().ok().or_else(|| Message::all_ids().iter().copied().find(known))
}

/// What is played, and how.
#[derive(Debug, Clone)]
pub struct PlaySettings {
    /// How many times faster than the stamps say.
    pub speedup: f64,
    /// Seconds from the start of the log at which to begin.
    pub from_s: f64,
    /// Seconds from the start of the log at which to end.
    pub until_s: Option<f64>,
    /// Begin again at the end.
    pub looped: bool,
    /// Which frames.
    pub filter: PlayFilter,
    /// Shift the wall-clock times that frames tell (SYSTEM_TIME) to now.
    pub rebase_us: Option<i64>,
}

/// Plays a log. It never looks at a clock: `now` is the caller's.
pub struct Player<S> {
    reader: TlogReader<S>,
    index: Index,
    settings: PlaySettings,
    /// The caller's time and the log's, seconds from its start, at the last change of pace or place.
    origin: (Duration, f64),
    paused: bool,
    speedup: f64,
    next: Option<(f64, Vec<u8>)>,
    ended: bool,
    /// Frames handed out.
    pub played: u64,
    /// Frames that the filter has kept back.
    pub kept_back: u64,
}

impl<S: Read + Seek> Player<S> {
    /// A player that starts when `now` is the caller's time.
    ///
    /// # Errors
    /// Those of the source.
    pub fn new(source: S, index: Index, settings: PlaySettings, now: Duration) -> io::Result<Self> {
        let mut player = Self {
            reader: TlogReader::new(source).with_unknown(),
            index,
            speedup: settings.speedup,
            origin: (now, settings.from_s),
            settings,
            paused: false,
            next: None,
            ended: false,
            played: 0,
            kept_back: 0,
        };
        let from_s = player.settings.from_s;
        player.seek(now, from_s)?;
        Ok(player)
    }

    /// Length of what the log holds, seconds by its stamps.
    pub fn length_s(&self) -> f64 {
        self.index.span_us.map_or(0.0, |(first, last)| (last - first) as f64 / 1e6)
    }

    /// Where the player is, seconds from the start of the log.
    pub fn position_s(&self, now: Duration) -> f64 {
        let played_s = now.saturating_sub(self.origin.0).as_secs_f64() * self.speedup;
        let position_s = if self.paused { self.origin.1 } else { self.origin.1 + played_s };
        position_s.min(self.end_s())
    }

    /// Stops where it is, or goes on.
    pub fn set_paused(&mut self, now: Duration, paused: bool) {
        self.origin = (now, self.position_s(now));
        self.paused = paused;
    }

    /// Whether it stands still.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Changes the pace.
    pub fn set_speedup(&mut self, now: Duration, speedup: f64) {
        self.origin = (now, self.position_s(now));
        self.speedup = speedup;
    }

    /// Goes to another place, seconds from the start of the log.
    ///
    /// # Errors
    /// Those of the source.
    pub fn seek(&mut self, now: Duration, to_s: f64) -> io::Result<()> {
        let to_s = to_s.clamp(0.0, self.end_s());
        self.origin = (now, to_s);
        self.ended = false;
        self.next = None;
        let first_us = self.index.span_us.map_or(0, |(first, _)| first);
        let offset = self.index.offset_before(first_us + (to_s * 1e6) as u64);
        self.reader.restart(|source| source.seek(SeekFrom::Start(offset)).map(drop))?;
        while let Some((at_s, frame)) = self.read()? {
            if at_s >= to_s {
                self.next = Some((at_s, frame));
                break;
            }
        }
        Ok(())
    }

    /// The next frame, if it is due.
    ///
    /// # Errors
    /// Those of the source.
    pub fn poll(&mut self, now: Duration) -> io::Result<Option<Vec<u8>>> {
        if self.paused || self.ended {
            return Ok(None);
        }
        match &self.next {
            Some((at_s, _)) if *at_s <= self.end_s() => {
                if *at_s > self.position_s(now) {
                    return Ok(None);
                }
                let due = self.next.take();
                self.next = self.read()?;
                self.played += 1;
                Ok(due.map(|(_, frame)| frame))
            }
            _ if self.settings.looped && self.end_s() > self.settings.from_s => {
                let from_s = self.settings.from_s;
                self.seek(now, from_s)?;
                Ok(None)
            }
            _ => {
                self.ended = true;
                Ok(None)
            }
        }
    }

    /// Everything has been played.
    pub fn is_ended(&self) -> bool {
        self.ended
    }

    fn end_s(&self) -> f64 {
        self.settings.until_s.unwrap_or(f64::INFINITY).min(self.length_s())
    }

    /// The next frame that passes the filter and its time, seconds from the start of the log.
    fn read(&mut self) -> io::Result<Option<(f64, Vec<u8>)>> {
        let first_us = self.index.span_us.map_or(0, |(first, _)| first);
        while let Some(record) = self.reader.next_record()? {
            if !self.settings.filter.passes(&record.frame) {
                self.kept_back += 1;
                continue;
            }
            let at_s = record.time_us.saturating_sub(first_us) as f64 / 1e6;
            let frame = match self.settings.rebase_us {
                Some(shift_us) => rebased(&record.frame, shift_us),
                None => record.frame.bytes().to_vec(),
            };
            return Ok(Some((at_s, frame)));
        }
        Ok(None)
    }
}

/// The frame with the wall-clock time in it shifted; its version and number are kept, a signature is not: it would be
/// wrong. Frames without such a time are handed out as they are.
fn rebased(frame: &Frame<'_>, shift_us: i64) -> Vec<u8> {
    let Ok(Message::SYSTEM_TIME(mut data)) = frame.decode() else { return frame.bytes().to_vec() };
    if data.time_unix_usec == 0 {
        return frame.bytes().to_vec();
    }
    data.time_unix_usec = data.time_unix_usec.saturating_add_signed(shift_us);
    let from: Identity = frame.identity();
    helmlink_wire::encoder::encode_numbered(
        frame.version(),
        from,
        frame.sequence(),
        &Message::SYSTEM_TIME(data),
    )
}
