//! Telemetry logs (`.tlog`), as ground stations write them.
//!
//! A log is a row of records: 8 bytes of time, microseconds since 1970 UTC, big endian, and one raw frame of
//! either protocol version. It has no header, no index and no lengths of its own, so a reader finds its way by
//! the frames alone. Here a damaged or cut log yields every frame whose checksum is right.

mod index;
mod reader;
mod search;
mod writer;

use crate::frame::Frame;

pub use index::{Disorder, Index, Kind, Mark};
pub use reader::{Records, TlogReader, records};
pub use writer::TlogWriter;

/// Length of a record's time stamp, bytes.
const STAMP_LENGTH: usize = 8;

/// One frame of a log and when it was logged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record<'a> {
    /// Time stamp: microseconds since 1970 UTC by the clock of whoever logged.
    ///
    /// A stamp carries no checksum. A record behind damage whose own stamp is incomplete or absurd (see
    /// [`MAX_PAUSE_US`]) has the time of the record before it, 0 if there is none.
    pub time_us: u64,
    /// Where the record starts, bytes from where reading began; its frame's own start where its stamp is incomplete.
    pub offset: u64,
    /// The frame, verified unless the reader was asked for unknown ones ([`TlogReader::with_unknown`]).
    pub frame: Frame<'a>,
}

/// Longest pause, microseconds, that a time stamp next to damaged bytes is believed to show: one day.
pub const MAX_PAUSE_US: u64 = 24 * 3600 * 1_000_000;

#[cfg(test)]
mod tests;
