//! The controller's commands and state as a telemetry log, stamped as the log they were computed from.

use std::io::{self, Write};

use helmlink_wire::tlog::TlogWriter;
use helmlink_wire::{Encoder, Frame};

use super::Export;
use crate::record::RECORDER;
use crate::replay::what_if::Moment;

/// Writes commands and states.
pub struct CommandLog<W: Write> {
    log: TlogWriter<W>,
    encoder: Encoder,
}

impl<W: Write> CommandLog<W> {
    /// Writes to `out`, which should be buffered.
    pub fn new(out: W) -> Self {
        Self { log: TlogWriter::new(out), encoder: Encoder::new() }
    }
}

impl<W: Write> Export for CommandLog<W> {
    fn moment(&mut self, moment: &Moment) -> io::Result<()> {
        let Some(thought) = moment.thought else { return Ok(()) };
        let mut bytes = Vec::new();
        self.encoder.encode(RECORDER, &thought.to_message(), &mut bytes);
        match Frame::parse(&bytes) {
            Ok(frame) => self.log.write(moment.time_us, &frame),
            Err(_) => Ok(()),
        }
    }

    fn command(&mut self, time_us: u64, frame: &[u8]) -> io::Result<()> {
        match Frame::parse(frame) {
            Ok(frame) => self.log.write(time_us, &frame),
            Err(_) => Ok(()),
        }
    }

    fn event(&mut self, _time_us: u64, _text: &str) -> io::Result<()> {
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        self.log.flush()
    }
}
