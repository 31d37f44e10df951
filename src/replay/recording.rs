//! Reads back what a bridge has recorded.

use std::collections::{BTreeMap, VecDeque};
use std::io::{self, Read};
use std::time::Duration;

use helmlink_wire::dialect::TUNNEL_DATA;
use helmlink_wire::tlog::TlogReader;
use helmlink_wire::{Frame, LinkId, LinkStatistics, Message};

use crate::bridge::{Bridge, Health};
use crate::pilot::supervisor::Request;
use crate::record::journal::BATCH_HEAD;
use crate::record::settings::HeaderParts;
use crate::record::tape::{Call, Entry};
use crate::record::{ControlState, Header, RECORDER, SETTINGS, TAPE};

/// One thing that happened to a bridge, in the order in which it did.
#[derive(Debug, Clone, PartialEq)]
pub enum Played {
    /// It was called.
    Call(Duration, Input),
    /// It sent a frame.
    Sent {
        /// By which link.
        link: LinkId,
        /// The frame.
        frame: Vec<u8>,
        /// The frame steers the boat.
        steers: bool,
    },
    /// It made a control step.
    Stepped(Box<ControlState>),
}

/// A call of a bridge.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// [`Bridge::link_up`].
    LinkUp(LinkId),
    /// [`Bridge::station_link_up`].
    StationUp(LinkId),
    /// [`Bridge::link_down`].
    LinkDown(LinkId),
    /// [`Bridge::on_bytes`]: link, bytes, whether they are a datagram.
    Bytes(LinkId, Vec<u8>, bool),
    /// [`Bridge::on_tick`].
    Tick,
    /// [`Bridge::request`].
    Request(Request),
    /// [`Bridge::set_health`].
    Health(Health),
    /// [`Bridge::set_recording_failed`].
    RecordingFailed(bool),
}

impl Input {
    /// Makes the call.
    pub fn apply(&self, now: Duration, bridge: &mut Bridge) {
        match self {
            Self::LinkUp(link) => bridge.link_up(now, *link),
            Self::StationUp(link) => bridge.station_link_up(now, *link),
            Self::LinkDown(link) => bridge.link_down(now, *link),
            Self::Bytes(link, bytes, is_datagram) => bridge.on_bytes(now, *link, bytes, *is_datagram),
            Self::Tick => bridge.on_tick(now),
            Self::Request(request) => drop(bridge.request(now, *request)),
            Self::Health(health) => bridge.set_health(now, *health),
            Self::RecordingFailed(failed) => bridge.set_recording_failed(now, *failed),
        }
    }
}

/// Why a recording cannot be read, or not further.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// Reading failed.
    #[error("the log cannot be read: {0}")]
    Io(#[from] io::Error),
    /// No settings and no tape.
    #[error(
        "this log was not recorded by helmlink (it holds no settings and no tape), so there is nothing to prove; \
         without --proof it is replayed through the controller"
    )]
    NotARecording,
    /// The settings are of another version.
    #[error("the settings in this log do not fit this version of helmlink: {0}")]
    Header(#[from] Box<toml::de::Error>),
    /// A part is missing.
    #[error(
        "part of the recording is missing: batch {found} of the tape follows batch {before}. Give all files of a \
         recording in order, from the first; a damaged file can be proven only up to the damage"
    )]
    Gap {
        /// The last batch before the gap, −1 if the beginning is missing.
        before: i64,
        /// The batch found.
        found: u32,
    },
    /// The tape tells of frames that the log does not hold.
    #[error("the log is damaged: its tape tells of {0} frames that are not there")]
    Torn(u64),
    /// The tape holds an entry that this version does not know.
    #[error(
        "the tape holds something that this version of helmlink does not know: it was recorded by a newer one"
    )]
    Unknown,
}

/// What is left to hand out.
enum Waiting {
    Call(Duration, Call),
    Out(Played),
}

/// Reads a recording in bounded memory.
pub struct Recording<R> {
    reader: TlogReader<R>,
    header: Header,
    /// Frames that the tape has not told of yet.
    frames: VecDeque<Vec<u8>>,
    streams: BTreeMap<LinkId, VecDeque<u8>>,
    waiting: VecDeque<Waiting>,
    next_batch: u32,
    now: Duration,
}

impl<R: Read> Recording<R> {
    /// Opens a recording.
    ///
    /// # Errors
    /// The log does not begin with settings that fit this version.
    pub fn open(source: R) -> Result<Self, RecordingError> {
        let mut reader = TlogReader::new(source);
        let mut parts = HeaderParts::default();
        while let Some(record) = reader.next_record()? {
            match note(&record.frame) {
                Some((SETTINGS, data)) => {
                    if let Some(text) = parts.push(content(&data)) {
                        let header = Header::from_text(&text)?;
                        return Ok(Self {
                            reader,
                            header,
                            frames: VecDeque::new(),
                            streams: BTreeMap::new(),
                            waiting: VecDeque::new(),
                            next_batch: 0,
                            now: Duration::ZERO,
                        });
                    }
                }
                _ => break,
            }
        }
        Err(RecordingError::NotARecording)
    }

    /// What stands at the head of the recording.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// What the log holds and lacks so far.
    pub fn statistics(&self) -> &LinkStatistics {
        self.reader.statistics()
    }

    /// The next thing that happened; `None` at the end, be it the end of the recording or of what a crash has left
    /// of it.
    ///
    /// # Errors
    /// The log cannot be read, or is damaged here.
    pub fn next_played(&mut self) -> Result<Option<Played>, RecordingError> {
        loop {
            match self.waiting.front() {
                Some(Waiting::Call(_, Call::Bytes(link, count) | Call::Datagram(link, count)))
                    if (self.streams.get(link).map_or(0, VecDeque::len) as u64) < *count => {}
                Some(_) => return self.hand_out(),
                None => {}
            }
            if !self.read_on()? {
                return Ok(None);
            }
        }
    }

    fn hand_out(&mut self) -> Result<Option<Played>, RecordingError> {
        let (now, call) = match self.waiting.pop_front() {
            Some(Waiting::Call(now, call)) => (now, call),
            Some(Waiting::Out(played)) => return Ok(Some(played)),
            None => return Ok(None),
        };
        let input = match call {
            Call::LinkUp(link) => Input::LinkUp(link),
            Call::StationUp(link) => Input::StationUp(link),
            Call::LinkDown(link) => Input::LinkDown(link),
            Call::Bytes(link, count) => Input::Bytes(link, self.take_bytes(link, count), false),
            Call::Datagram(link, count) => Input::Bytes(link, self.take_bytes(link, count), true),
            Call::Tick => Input::Tick,
            Call::RecordingFailed(failed) => Input::RecordingFailed(failed != 0),
            Call::Health(text) => {
                Input::Health(serde_json::from_slice(&text).map_err(|_| RecordingError::Unknown)?)
            }
            Call::Request(text) => {
                Input::Request(serde_json::from_slice(&text).map_err(|_| RecordingError::Unknown)?)
            }
        };
        Ok(Some(Played::Call(now, input)))
    }

    fn take_bytes(&mut self, link: LinkId, count: u64) -> Vec<u8> {
        let stream = self.streams.entry(link).or_default();
        stream.drain(..stream.len().min(count as usize)).collect()
    }

    /// Reads up to and including the next batch of the tape; false at the end of the log.
    fn read_on(&mut self) -> Result<bool, RecordingError> {
        while let Some(record) = self.reader.next_record()? {
            match note(&record.frame) {
                Some((TAPE, data)) => {
                    self.take_batch(content(&data))?;
                    return Ok(true);
                }
                // Every file of a recording begins with the settings.
                Some((SETTINGS, _)) => {}
                _ => self.frames.push_back(record.frame.bytes().to_vec()),
            }
        }
        Ok(false)
    }

    fn take_batch(&mut self, content: &[u8]) -> Result<(), RecordingError> {
        let Some((head, mut tape)) = content.split_first_chunk::<BATCH_HEAD>() else {
            return Err(RecordingError::Unknown);
        };
        let found = u32::from_le_bytes(*head);
        if found != self.next_batch {
            return Err(RecordingError::Gap { before: i64::from(self.next_batch) - 1, found });
        }
        self.next_batch = self.next_batch.wrapping_add(1);
        while !tape.is_empty() {
            let entry = Entry::read(&mut tape).ok_or(RecordingError::Unknown)?;
            self.take_entry(entry)?;
        }
        Ok(())
    }

    fn take_entry(&mut self, entry: Entry) -> Result<(), RecordingError> {
        match entry {
            Entry::Call(since_ns, call) => {
                self.now += Duration::from_nanos(since_ns);
                self.waiting.push_back(Waiting::Call(self.now, call));
            }
            Entry::Noise(link, bytes) => self.streams.entry(link).or_default().extend(bytes),
            Entry::Received(link, count) => {
                for _ in 0..count {
                    let frame = self.next_frame(count)?;
                    self.streams.entry(link).or_default().extend(frame);
                }
            }
            Entry::Sent(link, count) => self.take_sent(link, count, false)?,
            Entry::Steered(link, count) => self.take_sent(link, count, true)?,
            Entry::Noted(count) => {
                for _ in 0..count {
                    let frame = self.next_frame(count)?;
                    let message = Frame::parse(&frame).ok().and_then(|frame| frame.decode().ok());
                    if let Some(state) = message.as_ref().and_then(ControlState::from_message) {
                        self.waiting.push_back(Waiting::Out(Played::Stepped(Box::new(state))));
                    }
                }
            }
        }
        Ok(())
    }

    fn take_sent(&mut self, link: LinkId, count: u64, steers: bool) -> Result<(), RecordingError> {
        for _ in 0..count {
            let frame = self.next_frame(count)?;
            self.waiting.push_back(Waiting::Out(Played::Sent { link, frame, steers }));
        }
        Ok(())
    }

    fn next_frame(&mut self, count: u64) -> Result<Vec<u8>, RecordingError> {
        self.frames.pop_front().ok_or(RecordingError::Torn(count))
    }
}

/// Type and message of a note of the recorder that tells of the recording itself.
fn note(frame: &Frame<'_>) -> Option<(u16, TUNNEL_DATA)> {
    if frame.identity() != RECORDER {
        return None;
    }
    match frame.decode() {
        Ok(Message::TUNNEL(data)) if matches!(data.payload_type, TAPE | SETTINGS) => {
            Some((data.payload_type, data))
        }
        _ => None,
    }
}

fn content(data: &TUNNEL_DATA) -> &[u8] {
    &data.payload[..usize::from(data.payload_length).min(data.payload.len())]
}
