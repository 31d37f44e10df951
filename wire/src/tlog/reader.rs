//! Logs in.

use std::io::{self, ErrorKind, Read};

use super::search::{Search, Step};
use super::{Record, STAMP_LENGTH};
use crate::frame::Frame;
use crate::stats::LinkStatistics;

/// Bytes asked of the source at a time.
const BLOCK: usize = 64 * 1024;

/// Reads a log of any length in constant memory.
///
/// A record borrows the reader's buffer, so this is not an [`Iterator`]: use
/// `while let Some(record) = reader.next_record()? { ... }`, or [`records`] on bytes that are in memory.
#[derive(Debug, Clone)]
pub struct TlogReader<R> {
    source: R,
    buffer: Vec<u8>,
    /// Where the buffer lies, bytes from where reading began.
    buffer_at: u64,
    ended: bool,
    search: Search,
}

impl<R: Read> TlogReader<R> {
    /// Reads from `source`, which need not be buffered.
    pub fn new(source: R) -> Self {
        Self {
            source,
            buffer: Vec::with_capacity(2 * BLOCK),
            buffer_at: 0,
            ended: false,
            search: Search::default(),
        }
    }

    /// Finds records of messages that the dialect lacks, too: their frames are not verified, since nobody can.
    #[must_use]
    pub fn with_unknown(mut self) -> Self {
        self.search.with_unknown = true;
        self
    }

    /// The next record, its frame verified unless [`Self::with_unknown`] was called; `None` at the end of the log.
    ///
    /// # Errors
    /// Those of the source. Nothing is lost by one: call again to go on.
    pub fn next_record(&mut self) -> io::Result<Option<Record<'_>>> {
        loop {
            match self.search.step(&self.buffer, self.ended) {
                Step::Record { time_us, frame, is_verified } => {
                    let offset = self.buffer_at + frame.start.saturating_sub(STAMP_LENGTH) as u64;
                    return Ok(Some(Record {
                        time_us,
                        offset,
                        frame: Frame::new(&self.buffer[frame], is_verified),
                    }));
                }
                Step::NeedsMoreBytes => self.fill()?,
                Step::End => return Ok(None),
            }
        }
    }

    /// What the log holds and lacks so far; `bytes` and `resynchronised_bytes` include time stamps.
    pub fn statistics(&self) -> &LinkStatistics {
        &self.search.tally.statistics
    }

    /// Reads on from another place of the source, to which `go` has to move it; what it counts goes on.
    ///
    /// # Errors
    /// Those of `go`.
    pub fn restart(&mut self, go: impl FnOnce(&mut R) -> io::Result<()>) -> io::Result<()> {
        go(&mut self.source)?;
        self.buffer.clear();
        self.buffer_at = 0;
        self.ended = false;
        self.search.restart();
        Ok(())
    }

    fn fill(&mut self) -> io::Result<()> {
        let done = self.search.done();
        self.buffer.drain(..done);
        self.buffer_at += done as u64;
        self.search.rebase(done);
        let held = self.buffer.len();
        self.buffer.resize(held + BLOCK, 0);
        let result = read_some(&mut self.source, &mut self.buffer[held..]);
        let count = *result.as_ref().unwrap_or(&0);
        self.buffer.truncate(held + count);
        self.search.tally.statistics.bytes += count as u64;
        self.ended = result? == 0;
        Ok(())
    }
}

fn read_some(source: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match source.read(buffer) {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            result => return result,
        }
    }
}

/// The records of a log that is in memory.
pub fn records(log: &[u8]) -> Records<'_> {
    let mut search = Search::default();
    search.tally.statistics.bytes = log.len() as u64;
    Records { log, search }
}

/// Iterator over the records of a log in memory, see [`records`].
#[derive(Debug, Clone)]
pub struct Records<'a> {
    log: &'a [u8],
    search: Search,
}

impl Records<'_> {
    /// What the log holds and lacks so far; `bytes` is its whole length.
    pub fn statistics(&self) -> &LinkStatistics {
        &self.search.tally.statistics
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = Record<'a>;

    fn next(&mut self) -> Option<Record<'a>> {
        match self.search.step(self.log, true) {
            Step::Record { time_us, frame, is_verified } => {
                let offset = frame.start.saturating_sub(STAMP_LENGTH) as u64;
                Some(Record { time_us, offset, frame: Frame::new(&self.log[frame], is_verified) })
            }
            Step::NeedsMoreBytes | Step::End => None,
        }
    }
}
