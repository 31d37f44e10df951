//! What a link has carried and lost.

use crate::frame::{Frame, Identity};

/// Counters of one link (or log) since it was opened.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LinkStatistics {
    /// Frames with a right checksum.
    pub frames: u64,
    /// All bytes received, good or bad.
    pub bytes: u64,
    /// Frames of known messages with a wrong checksum: damaged, or defined differently by their sender.
    pub crc_errors: u64,
    /// Bytes passed over in search of the next frame, those of damaged frames included.
    pub resynchronised_bytes: u64,
    /// Frames that were sent and never arrived, by the senders' sequence numbers.
    pub sequence_gaps: u64,
    /// Frames whose message id the dialect lacks; their checksums cannot be verified.
    pub unknown_ids: u64,
    /// MAVLink 2 headers refused for incompatibility flags other than "signed" (or noise that looks like it).
    pub incompatible: u64,
}

/// Keeps the statistics of one link or log in step with its search for frames.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tally {
    pub(crate) statistics: LinkStatistics,
    sequences: Sequences,
    /// How far the last damaged frame still reaches from here, so that what lies in it is not counted again.
    damaged_ahead: usize,
}

impl Tally {
    /// The search has moved on behind a frame.
    pub(crate) fn took(&mut self, frame: &Frame<'_>) {
        if frame.is_verified() {
            self.statistics.frames += 1;
            self.statistics.sequence_gaps += self.sequences.note(frame);
        } else {
            self.statistics.unknown_ids += 1;
            self.sequences.note_unverified(frame);
        }
        self.pass(frame.bytes().len());
    }

    /// The search has passed over bytes that belong to no good frame.
    pub(crate) fn skipped(&mut self, count: usize) {
        self.statistics.resynchronised_bytes += count as u64;
        self.pass(count);
    }

    /// A damaged frame of `length` bytes starts here.
    pub(crate) fn found_damage(&mut self, length: usize) {
        if self.damaged_ahead == 0 {
            self.statistics.crc_errors += 1;
            self.damaged_ahead = length;
        }
    }

    fn pass(&mut self, count: usize) {
        self.damaged_ahead = self.damaged_ahead.saturating_sub(count);
    }
}

/// Senders whose sequence numbers are followed on one link; further ones are not checked for gaps.
///
/// A boat has a handful. The bound keeps noise and malice from filling memory.
pub const MAX_SENDERS: usize = 256;

/// How far behind the newest frame of its sender a frame may come and still count as late (or repeated)
/// instead of as following a gap of nearly 256. UDP may swap neighbouring datagrams.
pub const LATE_FRAMES: u8 = 16;

/// Finds lost frames from sequence numbers.
#[derive(Debug, Clone, Default)]
struct Sequences {
    /// Each sender with the newest sequence number heard from it.
    newest: Vec<(Identity, u8)>,
}

impl Sequences {
    /// Notes a verified frame; returns how many frames of its sender went missing before it.
    fn note(&mut self, frame: &Frame<'_>) -> u64 {
        let (identity, sequence) = (frame.identity(), frame.sequence());
        let Some((_, newest)) = self.newest.iter_mut().find(|(sender, _)| *sender == identity) else {
            if self.newest.len() < MAX_SENDERS {
                self.newest.push((identity, sequence));
            }
            return 0;
        };
        let ahead = sequence.wrapping_sub(*newest);
        if ahead == 0 || ahead > u8::MAX - LATE_FRAMES {
            return 0;
        }
        *newest = sequence;
        u64::from(ahead - 1)
    }

    /// Notes a frame that could not be verified: it explains a missing number, but is not proof enough to
    /// make one.
    fn note_unverified(&mut self, frame: &Frame<'_>) {
        let (identity, sequence) = (frame.identity(), frame.sequence());
        if let Some((_, newest)) = self.newest.iter_mut().find(|(sender, _)| *sender == identity)
            && sequence == newest.wrapping_add(1)
        {
            *newest = sequence;
        }
    }
}
