//! Logs out.

use std::io::{self, Write};

use super::STAMP_LENGTH;
use crate::frame::Frame;
use crate::layout::MAX_FRAME;

/// Writes a log that every ground station opens.
#[derive(Debug, Clone)]
pub struct TlogWriter<W> {
    sink: W,
}

impl<W: Write> TlogWriter<W> {
    /// Writes to `sink`. Each record is one write, so that an unbuffered file is cut only between records.
    pub fn new(sink: W) -> Self {
        Self { sink }
    }

    /// Appends a record: `frame`, logged at `time_us` microseconds since 1970 UTC.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn write(&mut self, time_us: u64, frame: &Frame<'_>) -> io::Result<()> {
        let mut record = [0; STAMP_LENGTH + MAX_FRAME];
        let end = STAMP_LENGTH + frame.bytes().len();
        record[..STAMP_LENGTH].copy_from_slice(&time_us.to_be_bytes());
        record[STAMP_LENGTH..end].copy_from_slice(frame.bytes());
        self.sink.write_all(&record[..end])
    }

    /// Hands buffered records to the operating system.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }

    /// The sink, with all records written so far.
    pub fn into_inner(self) -> W {
        self.sink
    }
}
