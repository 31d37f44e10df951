//! What a log holds and where, from one pass over it.

use std::io::{self, Read};

use super::TlogReader;
use crate::frame::Identity;
use crate::stats::LinkStatistics;

/// Marks kept at most; where a log is longer, every other one is dropped and the distance between them doubled.
const MOST_MARKS: usize = 16_384;
/// Distance of the first marks, bytes.
const FIRST_DISTANCE: u64 = 16 * 1024;
/// Kinds of frame counted at most, so that noise does not fill memory; further ones are only counted together.
const MOST_KINDS: usize = 4096;

/// A place in a log from which it can be read on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark {
    /// Where a record starts, bytes from the beginning of the log.
    pub offset: u64,
    /// The latest time stamp before that place, microseconds since 1970 UTC; its own for the first record.
    pub time_us: u64,
}

/// Frames of one message from one sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    /// Who sent them.
    pub from: Identity,
    /// The message id.
    pub message_id: u32,
    /// How many.
    pub count: u64,
}

/// How far the time stamps of a log are from being in order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Disorder {
    /// Records stamped earlier than the one before.
    pub records: u64,
    /// The farthest that a stamp lies behind the latest one before it, microseconds.
    pub farthest_us: u64,
}

/// What a log holds and where. Its size does not depend on that of the log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Index {
    /// Records with a verified frame.
    pub records: u64,
    /// Earliest and latest time stamp, microseconds since 1970 UTC; none where there is no record.
    pub span_us: Option<(u64, u64)>,
    /// How far from in order the stamps are.
    pub disorder: Disorder,
    /// What it holds, in the order of first appearance.
    pub kinds: Vec<Kind>,
    /// What the log holds and lacks.
    pub statistics: LinkStatistics,
    marks: Vec<Mark>,
    distance: u64,
}

impl Index {
    /// Reads a whole log.
    ///
    /// # Errors
    /// Those of the source.
    pub fn build(source: impl Read) -> io::Result<Self> {
        let mut reader = TlogReader::new(source);
        let mut index = Self {
            records: 0,
            span_us: None,
            disorder: Disorder::default(),
            kinds: Vec::new(),
            statistics: LinkStatistics::default(),
            marks: Vec::new(),
            distance: FIRST_DISTANCE,
        };
        let (mut previous_us, mut next_mark, mut last_kind) = (0, 0, 0);
        while let Some(record) = reader.next_record()? {
            let (offset, time_us) = (record.offset, record.time_us);
            let (from, message_id) = (record.frame.identity(), record.frame.message_id());
            index.records += 1;
            last_kind = index.count(last_kind, from, message_id);
            let (first_us, latest_us) = index.span_us.unwrap_or((time_us, time_us));
            if offset >= next_mark {
                next_mark = index.mark(Mark { offset, time_us: latest_us });
            }
            if time_us < previous_us {
                index.disorder.records += 1;
                index.disorder.farthest_us =
                    index.disorder.farthest_us.max(latest_us.saturating_sub(time_us));
            }
            previous_us = time_us;
            index.span_us = Some((first_us.min(time_us), latest_us.max(time_us)));
        }
        index.statistics = *reader.statistics();
        Ok(index)
    }

    /// Where to start reading so that no record stamped `time_us` or later is missed.
    pub fn offset_before(&self, time_us: u64) -> u64 {
        let after = self.marks.partition_point(|mark| mark.time_us < time_us);
        after.checked_sub(1).map_or(0, |at| self.marks[at].offset)
    }

    /// Places from which the log can be read on, in order.
    pub fn marks(&self) -> &[Mark] {
        &self.marks
    }

    /// Frames of one message, whoever sent them.
    pub fn count_of(&self, message_id: u32) -> u64 {
        self.kinds.iter().filter(|kind| kind.message_id == message_id).map(|kind| kind.count).sum()
    }

    /// Counts one frame; messages come in the same order again and again, so the search begins behind the last.
    fn count(&mut self, last: usize, from: Identity, message_id: u32) -> usize {
        let is_it = |kind: &Kind| kind.message_id == message_id && kind.from == from;
        let (before, behind) = self.kinds.split_at((last + 1).min(self.kinds.len()));
        let place = behind.iter().position(is_it).map(|at| before.len() + at);
        let place = place.or_else(|| before.iter().position(is_it)).unwrap_or_else(|| {
            if self.kinds.len() < MOST_KINDS {
                self.kinds.push(Kind { from, message_id, count: 0 });
            }
            self.kinds.len() - 1
        });
        self.kinds[place].count += 1;
        place
    }

    /// Keeps a mark; returns where the next one is due.
    fn mark(&mut self, mark: Mark) -> u64 {
        if self.marks.len() == MOST_MARKS {
            let mut keep = false;
            self.marks.retain(|_| {
                keep = !keep;
                keep
            });
            self.distance *= 2;
        }
        self.marks.push(mark);
        mark.offset + self.distance
    }
}
