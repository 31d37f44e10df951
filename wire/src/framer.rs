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

use crate::candidate::{Belief, Verdict, believe_unknown, inspect};
use crate::frame::Frame;
use crate::layout::{MAX_FRAME, is_marker};
use crate::stats::{LinkStatistics, Tally};

/// Silence after which the owner of a stream calls [`Framer::end_of_datagram`].
///
/// Far longer than the pauses within a frame on a radio or serial line, far shorter than any heartbeat.
pub const IDLE_FLUSH: Duration = Duration::from_millis(100);

/// Bytes that may wait to be taken out, on top of the latest push. Whoever takes out all frames after each
/// push never has more than a few frames' worth waiting.
pub const MAX_PENDING: usize = 256 * 1024;

/// Finds the frames of one link, of either protocol version, in a stream or in datagrams.
#[derive(Debug, Clone, Default)]
pub struct Framer {
    buffer: Vec<u8>,
    /// Where the search stands; all before it is done with.
    position: usize,
    /// No candidate that starts before this may reach beyond it.
    closed: usize,
    tally: Tally,
}

/// A frame's place in the buffer.
struct Found {
    start: usize,
    end: usize,
    verified: bool,
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
        self.tally.statistics.bytes += bytes.len() as u64;
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
        &self.tally.statistics
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
            let closed = self.position < self.closed;
            let limit = if closed { self.closed } else { self.buffer.len() };
            let candidate = &self.buffer[self.position..limit];
            match inspect(candidate) {
                Verdict::Verified(length) => return Some(self.take(length, true)),
                Verdict::Unknown { length, .. } => match believe_unknown(candidate, length, 0, closed) {
                    Belief::Yes => return Some(self.take(length, false)),
                    Belief::NeedsMoreBytes => return None,
                    Belief::No => {}
                },
                Verdict::Incomplete if !closed => return None,
                Verdict::Incomplete | Verdict::Noise => {}
                Verdict::Incompatible { .. } => self.tally.statistics.incompatible += 1,
                Verdict::Damaged(length) => self.tally.found_damage(length),
            }
            self.skip(1);
        }
    }

    fn take(&mut self, length: usize, verified: bool) -> Found {
        let found = Found { start: self.position, end: self.position + length, verified };
        self.position = found.end;
        self.tally.took(&Frame::new(&self.buffer[found.start..found.end], verified));
        found
    }

    fn skip(&mut self, count: usize) {
        self.position += count;
        self.tally.skipped(count);
    }

    /// Makes room by dropping the bytes that are done with.
    fn forget_done(&mut self) {
        self.buffer.drain(..self.position);
        self.closed = self.closed.saturating_sub(self.position);
        self.position = 0;
        // One huge push must not hold its memory for ever.
        if self.buffer.capacity() > 2 * MAX_PENDING && self.buffer.len() < MAX_FRAME {
            self.buffer.shrink_to(MAX_PENDING);
        }
    }
}

#[cfg(test)]
mod tests;
