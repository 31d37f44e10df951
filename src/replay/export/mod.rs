//! Writes what a replay gives into files of other tools' formats.
//!
//! | module | format |
//! |---|---|
//! | [`rows`] | CSV and JSON lines: one row for each control step |
//! | [`commands`] | a telemetry log of the commands and the controller's state |
//! | [`foxglove`] | MCAP with JSON schemas, for Foxglove and other viewers |

pub mod commands;
pub mod foxglove;
pub mod rows;

use std::io;

use super::what_if::{Moment, Sink};

/// A file being written; the first error ends it.
pub trait Export {
    /// A control step was due.
    ///
    /// # Errors
    /// Those of the file.
    fn moment(&mut self, moment: &Moment) -> io::Result<()>;

    /// The controller sends a frame.
    ///
    /// # Errors
    /// Those of the file.
    fn command(&mut self, time_us: u64, frame: &[u8]) -> io::Result<()>;

    /// Something happened.
    ///
    /// # Errors
    /// Those of the file.
    fn event(&mut self, time_us: u64, text: &str) -> io::Result<()>;

    /// Completes the file.
    ///
    /// # Errors
    /// Those of the file.
    fn finish(&mut self) -> io::Result<()>;
}

/// An export behind a sink, with its name and its first error.
pub struct Exporting {
    name: String,
    export: Box<dyn Export>,
    last_us: u64,
    error: Option<io::Error>,
}

impl Exporting {
    /// Writes by `export` into what the user calls `name`.
    pub fn new(name: String, export: Box<dyn Export>) -> Self {
        Self { name, export, last_us: 0, error: None }
    }

    /// Completes the file.
    ///
    /// # Errors
    /// Name of the file and the first error.
    pub fn finish(mut self) -> Result<(), (String, io::Error)> {
        let result = self.error.take().map_or_else(|| self.export.finish(), Err);
        result.map_err(|error| (self.name, error))
    }

    fn attempt(&mut self, write: impl FnOnce(&mut dyn Export) -> io::Result<()>) {
        if self.error.is_none() {
            self.error = write(self.export.as_mut()).err();
        }
    }
}

impl Sink for Exporting {
    fn moment(&mut self, moment: &Moment) {
        self.last_us = moment.time_us;
        self.attempt(|export| export.moment(moment));
    }

    fn command(&mut self, time_us: u64, frame: &[u8]) {
        self.attempt(|export| export.command(time_us, frame));
    }

    fn event(&mut self, _time_s: f64, text: &str) {
        let time_us = self.last_us;
        self.attempt(|export| export.event(time_us, text));
    }
}
