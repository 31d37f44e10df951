//! Writes a recording, call by call.

use std::collections::VecDeque;
use std::time::Duration;

use helmlink_wire::dialect::{CharArray, STATUSTEXT_DATA};
use helmlink_wire::tlog::TlogWriter;
use helmlink_wire::{Encoder, Frame, LinkId, Message};

use super::settings::tunnel;
use super::splitter::{Piece, Splitter};
use super::tape::{Call, Entry, MAX_TEXT};
use super::{ControlState, Header, RECORDER, TAPE, TUNNEL_LENGTH};

/// The values with names are logged with every so many control steps.
const STEPS_PER_NAMED: u32 = 5;
/// Characters in one STATUSTEXT.
const TEXT_LENGTH: usize = 50;
/// The longest event that is logged, in STATUSTEXT chunks.
const MOST_CHUNKS: usize = 8;

/// How a frame left the bridge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A request, a report, a heartbeat.
    Talk,
    /// It steers the boat.
    Steer,
}

/// What one link has brought.
#[derive(Debug)]
struct Stream {
    link: LinkId,
    splitter: Splitter,
    /// What is not in the log yet.
    held: VecDeque<Held>,
}

/// A frame, or bytes that belong to none.
#[derive(Debug)]
struct Held {
    bytes: Vec<u8>,
    is_frame: bool,
}

/// What was received and sent, as telemetry log records, until the driver writes them away.
#[derive(Debug)]
pub struct Journal {
    unix_start_us: u64,
    now: Duration,
    log: TlogWriter<Vec<u8>>,
    header: Vec<u8>,
    encoder: Encoder,
    streams: Vec<Stream>,
    tape: Vec<u8>,
    run: Option<Entry>,
    last_call_ns: u64,
    batches: u32,
    steps: u32,
    texts: u16,
}

impl Journal {
    /// A journal that begins with `header`.
    pub fn new(header: &Header) -> Self {
        let mut journal = Self {
            unix_start_us: header.unix_start_us.unsigned_abs(),
            now: Duration::ZERO,
            log: TlogWriter::new(Vec::new()),
            header: Vec::new(),
            encoder: Encoder::new(),
            streams: Vec::new(),
            tape: Vec::new(),
            run: None,
            last_call_ns: 0,
            batches: 0,
            steps: 0,
            texts: 0,
        };
        // A header that cannot be written leaves a log that can still be read, if not proven.
        for message in header.to_messages().unwrap_or_default() {
            journal.write_own(&message);
        }
        journal.header = journal.log.clone().into_inner();
        journal
    }

    /// The records with which every file of this recording begins; the first [`Self::take`] has them too.
    pub fn header(&self) -> &[u8] {
        &self.header
    }

    /// A peer has appeared.
    pub fn link_up(&mut self, now: Duration, link: LinkId) {
        self.call(now, Call::LinkUp(link));
    }

    /// A peer that is no flight controller has appeared.
    pub fn station_up(&mut self, now: Duration, link: LinkId) {
        self.call(now, Call::StationUp(link));
    }

    /// A peer has gone.
    pub fn link_down(&mut self, now: Duration, link: LinkId) {
        self.call(now, Call::LinkDown(link));
        self.split(link, &[], true);
    }

    /// Bytes of a peer have arrived.
    pub fn bytes(&mut self, now: Duration, link: LinkId, bytes: &[u8], is_datagram: bool) {
        let count = bytes.len() as u64;
        self.call(now, if is_datagram { Call::Datagram(link, count) } else { Call::Bytes(link, count) });
        self.split(link, bytes, is_datagram);
    }

    /// Time has passed.
    pub fn tick(&mut self, now: Duration) {
        self.call(now, Call::Tick);
    }

    /// The user asks something.
    pub fn request(&mut self, now: Duration, request: &impl serde::Serialize) {
        let text = serde_json::to_vec(request).unwrap_or_default();
        self.call(now, Call::Request(text));
    }

    /// How the bridge's process is.
    pub fn health(&mut self, now: Duration, health: &impl serde::Serialize) {
        let text = serde_json::to_vec(health).unwrap_or_default();
        self.call(now, Call::Health(text));
    }

    /// The log can no longer be written, or can again.
    pub fn recording_failed(&mut self, now: Duration, failed: bool) {
        self.call(now, Call::RecordingFailed(failed.into()));
    }

    /// A frame goes out.
    pub fn sent(&mut self, link: LinkId, frame: &Frame<'_>, purpose: Purpose) {
        self.write(frame);
        match purpose {
            Purpose::Talk => self.count(Entry::Sent(link, 1)),
            Purpose::Steer => self.count(Entry::Steered(link, 1)),
        }
    }

    /// A control step has been made.
    ///
    /// Its whole state is logged as one array, and now and then `named`: the best known of it by name.
    pub fn stepped(&mut self, state: &ControlState, named: impl Iterator<Item = Message>) {
        self.note(&state.to_message());
        if self.steps.is_multiple_of(STEPS_PER_NAMED) {
            named.for_each(|message| self.note(&message));
        }
        self.steps = self.steps.wrapping_add(1);
    }

    /// Something worth a line has happened; long lines go into several STATUSTEXT with one id.
    pub fn event(&mut self, severity: u8, text: &str) {
        let text: Vec<u8> = text.chars().map(|c| if c.is_ascii() { c as u8 } else { b'?' }).collect();
        self.texts = self.texts.wrapping_add(1).max(1);
        let chunks = text.chunks(TEXT_LENGTH).take(MOST_CHUNKS);
        let id = if text.len() > TEXT_LENGTH { self.texts } else { 0 };
        for (chunk_seq, chunk) in (0..).zip(chunks) {
            let text = CharArray::from(String::from_utf8_lossy(chunk).as_ref());
            self.note(&Message::STATUSTEXT(STATUSTEXT_DATA { severity, text, id, chunk_seq }));
        }
    }

    /// The records since the last call, whole ones only.
    pub fn take(&mut self) -> Vec<u8> {
        self.release_all();
        std::mem::replace(&mut self.log, TlogWriter::new(Vec::new())).into_inner()
    }

    /// Ends the recording and hands out its last records.
    pub fn finish(&mut self) -> Vec<u8> {
        for link in self.streams.iter().map(|stream| stream.link).collect::<Vec<_>>() {
            self.split(link, &[], true);
        }
        self.release_all();
        self.end_run();
        self.end_batch();
        self.take()
    }

    fn call(&mut self, now: Duration, call: Call) {
        self.release_all();
        self.now = now;
        let now_ns = now.as_nanos().min(u128::from(u64::MAX)) as u64;
        let since_ns = now_ns.saturating_sub(self.last_call_ns);
        self.last_call_ns = self.last_call_ns.max(now_ns);
        self.put(Entry::Call(since_ns, call));
    }

    /// The bridge looks at this frame now: it goes into the log in front of what the bridge makes of it.
    pub fn taken(&mut self, link: LinkId, frame: &[u8]) {
        let Some(at) = self.streams.iter().position(|stream| stream.link == link) else { return };
        let is_it = |held: &Held| held.is_frame && held.bytes == frame;
        let Some(before) = self.streams[at].held.iter().position(is_it) else { return };
        let released: Vec<Held> = self.streams[at].held.drain(..=before).collect();
        released.into_iter().for_each(|held| self.release(link, &held));
    }

    /// Cuts what a link has brought into frames for everybody and noise for the tape alone.
    fn split(&mut self, link: LinkId, bytes: &[u8], is_end: bool) {
        let at = self.streams.iter().position(|stream| stream.link == link).unwrap_or_else(|| {
            self.streams.push(Stream { link, splitter: Splitter::default(), held: VecDeque::new() });
            self.streams.len() - 1
        });
        let Stream { splitter, held, .. } = &mut self.streams[at];
        splitter.push(bytes, is_end, |piece| {
            held.push_back(match piece {
                Piece::Frame(frame) => Held { bytes: frame.bytes().to_vec(), is_frame: true },
                Piece::Noise(bytes) => Held { bytes: bytes.to_vec(), is_frame: false },
            });
        });
    }

    /// Logs what has come in and the bridge has not looked at.
    fn release_all(&mut self) {
        for at in 0..self.streams.len() {
            let link = self.streams[at].link;
            let held = std::mem::take(&mut self.streams[at].held);
            held.iter().for_each(|held| self.release(link, held));
        }
    }

    fn release(&mut self, link: LinkId, held: &Held) {
        // What looks like our own notes, because an old log is being played to us, must not be taken for them.
        match Frame::parse(&held.bytes) {
            Ok(frame) if held.is_frame && frame.identity() != RECORDER => {
                self.write(&frame);
                self.count(Entry::Received(link, 1));
            }
            _ => self.noise(link, &held.bytes),
        }
    }

    fn noise(&mut self, link: LinkId, bytes: &[u8]) {
        for part in bytes.chunks(MAX_TEXT) {
            self.put(Entry::Noise(link, part.to_vec()));
        }
    }

    /// Logs a message that was on no link.
    fn note(&mut self, message: &Message) {
        self.write_own(message);
        self.count(Entry::Noted(1));
    }

    fn write_own(&mut self, message: &Message) {
        let mut bytes = Vec::with_capacity(64);
        self.encoder.encode(RECORDER, message, &mut bytes);
        if let Ok(frame) = Frame::parse(&bytes) {
            self.write(&frame);
        }
    }

    fn write(&mut self, frame: &Frame<'_>) {
        let time_us = self.unix_start_us.saturating_add(self.now.as_micros() as u64);
        // Writing to memory does not fail.
        self.log.write(time_us, frame).ok();
    }

    /// One more frame of the log, of the kind that `entry` says.
    fn count(&mut self, entry: Entry) {
        let run = match (&mut self.run, &entry) {
            (Some(Entry::Received(a, run)), Entry::Received(b, _)) if a == b => run,
            (Some(Entry::Sent(a, run)), Entry::Sent(b, _)) if a == b => run,
            (Some(Entry::Steered(a, run)), Entry::Steered(b, _)) if a == b => run,
            (Some(Entry::Noted(run)), Entry::Noted(_)) => run,
            _ => {
                self.end_run();
                self.run = Some(entry);
                return;
            }
        };
        *run += 1;
    }

    fn end_run(&mut self) {
        if let Some(entry) = self.run.take() {
            self.append(&entry);
        }
    }

    fn put(&mut self, entry: Entry) {
        self.end_run();
        self.append(&entry);
    }

    /// Puts an entry on the tape; a batch of entries goes into the log when no more fit into one message.
    fn append(&mut self, entry: &Entry) {
        let mut bytes = Vec::with_capacity(16);
        entry.write(&mut bytes);
        if BATCH_HEAD + self.tape.len() + bytes.len() > TUNNEL_LENGTH {
            self.end_batch();
        }
        self.tape.extend_from_slice(&bytes);
    }

    fn end_batch(&mut self) {
        if self.tape.is_empty() {
            return;
        }
        let content = [&self.batches.to_le_bytes()[..], &self.tape].concat();
        self.batches = self.batches.wrapping_add(1);
        self.tape.clear();
        if content.len() <= TUNNEL_LENGTH {
            self.write_own(&tunnel(TAPE, &content));
        }
    }
}

/// A batch begins with its number, four bytes.
pub(crate) const BATCH_HEAD: usize = 4;
