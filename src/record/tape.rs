//! The calls that a bridge has had and the frames that went with them, as bytes.
//!
//! A tape is a row of entries: one byte that names the kind, then its values. Whole numbers are written seven bits
//! at a time, lowest first, the top bit set where more follow. Times are nanoseconds since the call before.

use helmlink_wire::LinkId;

/// One entry of a tape.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Entry {
    /// The bridge was called, so many nanoseconds after the call before.
    Call(u64, Call),
    /// The next so many frames of the log came in by this link.
    Received(LinkId, u64),
    /// The next so many frames of the log were sent by this link.
    Sent(LinkId, u64),
    /// The same, and they steer the boat.
    Steered(LinkId, u64),
    /// The next so many frames of the log were on no link.
    Noted(u64),
    /// These bytes came in by this link and belong to no frame.
    Noise(LinkId, Vec<u8>),
}

/// What was asked of the bridge.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Call {
    /// A peer at the flight controller's end has appeared.
    LinkUp(LinkId),
    /// A peer that is no flight controller has appeared.
    StationUp(LinkId),
    /// A peer has gone.
    LinkDown(LinkId),
    /// The next so many bytes of this link's stream have arrived.
    Bytes(LinkId, u64),
    /// The same, as one datagram.
    Datagram(LinkId, u64),
    /// Time has passed.
    Tick,
    /// The user asks something, in JSON.
    Request(Vec<u8>),
    /// How the bridge's process is, in JSON.
    Health(Vec<u8>),
    /// The log can no longer be written (1), or can again (0).
    RecordingFailed(u64),
}

const RECEIVED: u8 = 1;
const SENT: u8 = 2;
const STEERED: u8 = 3;
const NOTED: u8 = 4;
const NOISE: u8 = 5;
const LINK_UP: u8 = 16;
const LINK_DOWN: u8 = 17;
const BYTES: u8 = 18;
const DATAGRAM: u8 = 19;
const TICK: u8 = 20;
const REQUEST: u8 = 21;
const RECORDING_FAILED: u8 = 22;
const STATION_UP: u8 = 23;
const HEALTH: u8 = 24;

/// Noise and requests longer than this are cut into several entries or refused, so that an entry fits in a TUNNEL.
pub const MAX_TEXT: usize = 96;

impl Entry {
    /// Appends the entry to a tape.
    pub fn write(&self, out: &mut Vec<u8>) {
        match self {
            Self::Call(since_ns, call) => {
                let (kind, numbers, text): (u8, [Option<u64>; 2], &[u8]) = match call {
                    Call::LinkUp(link) => (LINK_UP, [Some(link.0.into()), None], &[]),
                    Call::StationUp(link) => (STATION_UP, [Some(link.0.into()), None], &[]),
                    Call::LinkDown(link) => (LINK_DOWN, [Some(link.0.into()), None], &[]),
                    Call::Bytes(link, count) => (BYTES, [Some(link.0.into()), Some(*count)], &[]),
                    Call::Datagram(link, count) => (DATAGRAM, [Some(link.0.into()), Some(*count)], &[]),
                    Call::Tick => (TICK, [None, None], &[]),
                    Call::Request(text) => (REQUEST, [Some(text.len() as u64), None], text),
                    Call::Health(text) => (HEALTH, [Some(text.len() as u64), None], text),
                    Call::RecordingFailed(failed) => (RECORDING_FAILED, [Some(*failed), None], &[]),
                };
                out.push(kind);
                write_number(*since_ns, out);
                numbers.into_iter().flatten().for_each(|number| write_number(number, out));
                out.extend_from_slice(text);
            }
            Self::Received(link, count) => write_run(RECEIVED, *link, *count, out),
            Self::Sent(link, count) => write_run(SENT, *link, *count, out),
            Self::Steered(link, count) => write_run(STEERED, *link, *count, out),
            Self::Noted(count) => {
                out.push(NOTED);
                write_number(*count, out);
            }
            Self::Noise(link, bytes) => {
                write_run(NOISE, *link, bytes.len() as u64, out);
                out.extend_from_slice(bytes);
            }
        }
    }

    /// Takes the next entry off a tape; `None` when what is left is none.
    pub fn read(tape: &mut &[u8]) -> Option<Self> {
        let kind = take(tape, 1)?[0];
        Some(match kind {
            RECEIVED => Self::Received(read_link(tape)?, read_number(tape)?),
            SENT => Self::Sent(read_link(tape)?, read_number(tape)?),
            STEERED => Self::Steered(read_link(tape)?, read_number(tape)?),
            NOTED => Self::Noted(read_number(tape)?),
            NOISE => Self::Noise(read_link(tape)?, read_text(tape)?),
            _ => {
                let since_ns = read_number(tape)?;
                let call = match kind {
                    LINK_UP => Call::LinkUp(read_link(tape)?),
                    STATION_UP => Call::StationUp(read_link(tape)?),
                    LINK_DOWN => Call::LinkDown(read_link(tape)?),
                    BYTES => Call::Bytes(read_link(tape)?, read_number(tape)?),
                    DATAGRAM => Call::Datagram(read_link(tape)?, read_number(tape)?),
                    TICK => Call::Tick,
                    REQUEST => Call::Request(read_text(tape)?),
                    HEALTH => Call::Health(read_text(tape)?),
                    RECORDING_FAILED => Call::RecordingFailed(read_number(tape)?),
                    _ => return None,
                };
                Self::Call(since_ns, call)
            }
        })
    }
}

fn write_run(kind: u8, link: LinkId, count: u64, out: &mut Vec<u8>) {
    out.push(kind);
    write_number(link.0.into(), out);
    write_number(count, out);
}

fn write_number(mut number: u64, out: &mut Vec<u8>) {
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

fn read_number(tape: &mut &[u8]) -> Option<u64> {
    let mut number = 0;
    for shift in (0..64).step_by(7) {
        let byte = take(tape, 1)?[0];
        number |= u64::from(byte & 0x7F) << shift;
        if byte & 0x80 == 0 {
            return Some(number);
        }
    }
    None
}

fn read_link(tape: &mut &[u8]) -> Option<LinkId> {
    u32::try_from(read_number(tape)?).ok().map(LinkId)
}

fn read_text(tape: &mut &[u8]) -> Option<Vec<u8>> {
    let length = usize::try_from(read_number(tape)?).ok()?;
    take(tape, length).map(<[u8]>::to_vec)
}

fn take<'a>(tape: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (head, rest) = tape.split_at_checked(count)?;
    *tape = rest;
    Some(head)
}
