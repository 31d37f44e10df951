//! Bytes in, frames out.
//!
//! # How frames are found
//! Every byte is tried in turn as the start of a frame. What has a right checksum is a frame, and the search
//! goes on behind it; anything else is passed over by *one* byte, so that a false marker, a damaged frame or
//! a cut one never takes a good frame with it, whatever length it claims.
//!
//! A candidate that is not all there yet must be waited for, and a false one would hold up the frames behind
//! it. So the caller says when no more bytes belong to it: [`Framer::end_of_datagram`], at the end of each
//! datagram, at the end of input, and after a stream has been silent for [`IDLE_FLUSH`].
//!
//! # Unknown messages
//! The checksum covers the message's definition, so that of an unknown id proves nothing: such bytes are taken
//! for a frame only if frames (or the end of the datagram) follow right behind it and no verified frame lies
//! within it. Even then it is only counted and, on request ([`Framer::next_any`]), shown as unverified.

use std::time::Duration;

use crate::candidate::{Verdict, inspect};
use crate::frame::Frame;
use crate::layout::{MAX_FRAME, is_marker};
use crate::stats::{LinkStatistics, Sequences};

/// Silence after which the owner of a stream calls [`Framer::end_of_datagram`].
///
/// Far longer than the pauses within a frame on a radio or serial line, far shorter than any heartbeat.
pub const IDLE_FLUSH: Duration = Duration::from_millis(100);

/// Bytes that may wait to be taken out, on top of the latest push. Whoever takes out all frames after each
/// push never has more than a few frames' worth waiting.
pub const MAX_PENDING: usize = 256 * 1024;

/// So many frames of unknown messages in a row are believed without a verified one behind them.
const UNKNOWN_CHAIN: usize = 3;

/// Finds the frames of one link, of either protocol version, in a stream or in datagrams.
#[derive(Debug, Clone, Default)]
pub struct Framer {
    buffer: Vec<u8>,
    /// Where the search stands; all before it is done with.
    position: usize,
    /// No candidate that starts before this may reach beyond it.
    closed: usize,
    /// End of the last damaged frame, so that what lies within it is not counted again.
    damaged_until: usize,
    statistics: LinkStatistics,
    sequences: Sequences,
}

/// A frame's place in the buffer.
struct Found {
    start: usize,
    end: usize,
    verified: bool,
}

/// Whether an unknown message's frame is believed to be one.
enum Belief {
    Yes,
    No,
    NeedsMoreBytes,
}

impl Framer {
    /// A framer that has seen nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes in received bytes. Take out the frames with [`Framer::next_frame`] after each push: of bytes
    /// left waiting, all but the newest [`MAX_PENDING`] are given up.
    pub fn push(&mut self, bytes: &[u8]) {
        let excess = (self.buffer.len() - self.position).saturating_sub(MAX_PENDING);
        self.skip(excess);
        self.forget_done();
        self.buffer.extend_from_slice(bytes);
        self.statistics.bytes += bytes.len() as u64;
    }

    /// Says that no frame goes on from the bytes pushed so far to those pushed later: the datagram or the
    /// input has ended, or the line has been silent for [`IDLE_FLUSH`]. Frames that a false start has held
    /// up come out of the following calls of [`Framer::next_frame`]; what then remains is passed over.
    pub fn end_of_datagram(&mut self) {
        self.closed = self.buffer.len();
    }

    /// The next frame with a right checksum; `None` when more bytes are needed.
    pub fn next_frame(&mut self) -> Option<Frame<'_>> {
        loop {
            let found = self.search()?;
            if found.verified {
                return Some(self.frame(&found));
            }
        }
    }

    /// The next frame, those of unknown messages included: see [`Frame::is_verified`].
    pub fn next_any(&mut self) -> Option<Frame<'_>> {
        let found = self.search()?;
        Some(self.frame(&found))
    }

    /// What the link has carried and lost so far.
    pub fn statistics(&self) -> &LinkStatistics {
        &self.statistics
    }

    fn frame(&self, found: &Found) -> Frame<'_> {
        Frame::new(&self.buffer[found.start..found.end], found.verified)
    }

    fn search(&mut self) -> Option<Found> {
        loop {
            let waiting = &self.buffer[self.position..];
            let noise = waiting.iter().position(|&byte| is_marker(byte)).unwrap_or(waiting.len());
            self.skip(noise);
            if self.position == self.buffer.len() {
                return None;
            }
            match inspect(&self.buffer[self.position..self.limit()]) {
                Verdict::Verified(length) => return Some(self.take(length, true)),
                Verdict::Unknown { length, .. } => match self.belief(length) {
                    Belief::Yes => return Some(self.take(length, false)),
                    Belief::No => self.skip(1),
                    Belief::NeedsMoreBytes => return None,
                },
                Verdict::Incomplete if !self.is_closed() => return None,
                Verdict::Incomplete | Verdict::Noise => self.skip(1),
                Verdict::Incompatible { .. } => {
                    self.statistics.incompatible += 1;
                    self.skip(1);
                }
                Verdict::Damaged(length) => {
                    self.note_damage(length);
                    self.skip(1);
                }
            }
        }
    }

    /// Whether the frame of an unknown message, `length` bytes from here, is to be believed.
    fn belief(&self, length: usize) -> Belief {
        let limit = self.limit();
        let mut end = self.position + length;
        for _ in 0..UNKNOWN_CHAIN {
            if end == limit && self.is_closed() {
                break;
            }
            match inspect(&self.buffer[end..limit]) {
                Verdict::Verified(_) => break,
                Verdict::Unknown { length, .. } => end += length,
                Verdict::Incomplete if !self.is_closed() => return Belief::NeedsMoreBytes,
                _ => return Belief::No,
            }
        }
        let claimed = &self.buffer[self.position..self.position + length];
        let swallows = (1..length)
            .any(|at| is_marker(claimed[at]) && matches!(inspect(&claimed[at..]), Verdict::Verified(_)));
        if swallows { Belief::No } else { Belief::Yes }
    }

    fn take(&mut self, length: usize, verified: bool) -> Found {
        let found = Found { start: self.position, end: self.position + length, verified };
        self.position = found.end;
        let frame = Frame::new(&self.buffer[found.start..found.end], verified);
        if verified {
            self.statistics.frames += 1;
            self.statistics.sequence_gaps += self.sequences.note(&frame);
        } else {
            self.statistics.unknown_ids += 1;
            self.sequences.note_unverified(&frame);
        }
        found
    }

    fn note_damage(&mut self, length: usize) {
        if self.position >= self.damaged_until {
            self.statistics.crc_errors += 1;
            self.damaged_until = self.position + length;
        }
    }

    fn skip(&mut self, count: usize) {
        self.position += count;
        self.statistics.resynchronised_bytes += count as u64;
    }

    /// Whether the bytes at the search position are all that will ever belong to a frame there.
    fn is_closed(&self) -> bool {
        self.position < self.closed
    }

    /// End of the bytes that may belong to a frame at the search position.
    fn limit(&self) -> usize {
        if self.is_closed() { self.closed } else { self.buffer.len() }
    }

    /// Makes room by dropping the bytes that are done with.
    fn forget_done(&mut self) {
        self.buffer.drain(..self.position);
        self.closed = self.closed.saturating_sub(self.position);
        self.damaged_until = self.damaged_until.saturating_sub(self.position);
        self.position = 0;
        // One huge push must not hold its memory for ever.
        if self.buffer.capacity() > 2 * MAX_PENDING && self.buffer.len() < MAX_FRAME {
            self.buffer.shrink_to(MAX_PENDING);
        }
    }
}

#[cfg(test)]
mod tests;
