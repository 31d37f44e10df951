//! The search for the next record, without input of its own.

use std::ops::Range;

use super::{MAX_PAUSE_US, STAMP_LENGTH};
use crate::candidate::{Belief, Verdict, believe_unknown, inspect};
use crate::frame::Frame;
use crate::stats::Tally;

/// What a step of the search comes to.
pub(super) enum Step {
    /// A record with a frame, which lies at `frame` in the bytes searched.
    Record { time_us: u64, frame: Range<usize>, is_verified: bool },
    /// The bytes do not reach far enough.
    NeedsMoreBytes,
    /// The log has no more records.
    End,
}

/// Where the search stands in the bytes of a log, and what it has counted.
#[derive(Debug, Clone, Default)]
pub(super) struct Search {
    pub(super) tally: Tally,
    at: usize,
    /// Records of messages that the dialect lacks are found, too, where they stand in a row with others.
    pub(super) with_unknown: bool,
    /// Records no longer follow each other: any byte may be the start of a frame.
    lost: bool,
    /// Bytes passed over since the last record, while lost.
    passed: usize,
    last_time_us: Option<u64>,
}

impl Search {
    /// Looks for the next record in `bytes`, which are the same as in the last call with more at the end;
    /// `is_all` when the log ends with them.
    pub(super) fn step(&mut self, bytes: &[u8], is_all: bool) -> Step {
        loop {
            if is_all && self.at >= bytes.len() {
                return Step::End;
            }
            let found = if self.lost { self.at_any_byte(bytes, is_all) } else { self.in_row(bytes, is_all) };
            if let Some(step) = found {
                return step;
            }
        }
    }

    /// How many of the bytes will not be looked at again.
    pub(super) fn done(&self) -> usize {
        self.at - self.passed.min(STAMP_LENGTH)
    }

    /// The bytes that were [`Search::done`] have been dropped.
    pub(super) fn rebase(&mut self, dropped: usize) {
        self.at -= dropped;
    }

    /// The bytes that come are from another place of the log.
    pub(super) fn restart(&mut self) {
        let tally = std::mem::take(&mut self.tally);
        *self = Self { tally, with_unknown: self.with_unknown, ..Self::default() };
    }

    /// Expects a record right here, as in a sound log.
    fn in_row(&mut self, bytes: &[u8], is_all: bool) -> Option<Step> {
        let start = self.at + STAMP_LENGTH;
        let candidate = bytes.get(start..).unwrap_or_default();
        match inspect(candidate) {
            Verdict::Verified(length) => {
                let time_us = stamp_before(bytes, start);
                return Some(self.take(bytes, start..start + length, time_us));
            }
            Verdict::Incomplete if !is_all => return Some(Step::NeedsMoreBytes),
            Verdict::Unknown { length, .. } => {
                match believe_unknown(candidate, length, STAMP_LENGTH, is_all) {
                    Belief::Yes => {
                        self.tally.took(&Frame::new(&candidate[..length], false));
                        self.at = start + length;
                        return self.with_unknown.then(|| Step::Record {
                            time_us: stamp_before(bytes, start),
                            frame: start..start + length,
                            is_verified: false,
                        });
                    }
                    Belief::NeedsMoreBytes => return Some(Step::NeedsMoreBytes),
                    Belief::No => {}
                }
            }
            _ => {}
        }
        self.lost = true;
        None
    }

    /// Expects anything: the next verified frame, wherever it starts, is the next record's.
    fn at_any_byte(&mut self, bytes: &[u8], is_all: bool) -> Option<Step> {
        match inspect(&bytes[self.at..]) {
            Verdict::Verified(length) => {
                let time_us = self.believable_stamp(bytes);
                return Some(self.take(bytes, self.at..self.at + length, time_us));
            }
            Verdict::Incomplete if !is_all => return Some(Step::NeedsMoreBytes),
            Verdict::Damaged(length) => self.tally.found_damage(length),
            Verdict::Incompatible { .. } => self.tally.statistics.incompatible += 1,
            _ => {}
        }
        self.tally.skipped(1);
        self.at += 1;
        self.passed += 1;
        None
    }

    fn take(&mut self, bytes: &[u8], frame: Range<usize>, time_us: u64) -> Step {
        self.tally.took(&Frame::new(&bytes[frame.clone()], true));
        self.last_time_us = Some(time_us);
        self.at = frame.end;
        self.lost = false;
        self.passed = 0;
        Step::Record { time_us, frame, is_verified: true }
    }

    /// The time of the frame that has been found here after a search.
    fn believable_stamp(&self, bytes: &[u8]) -> u64 {
        let own = (self.passed >= STAMP_LENGTH).then(|| stamp_before(bytes, self.at));
        match (own, self.last_time_us) {
            (Some(own), Some(last)) if own.abs_diff(last) <= MAX_PAUSE_US => own,
            (_, Some(last)) => last,
            (own, None) => own.unwrap_or_default(),
        }
    }
}

/// The time stamp that ends where a frame starts.
fn stamp_before(bytes: &[u8], frame_start: usize) -> u64 {
    bytes[..frame_start].last_chunk().map_or(0, |stamp: &[u8; STAMP_LENGTH]| u64::from_be_bytes(*stamp))
}
