//! Standard output and standard error: results on the one, messages on the other.

use std::io::{IsTerminal, Write};
use std::str::FromStr;

use tracing_subscriber::EnvFilter;

use super::cli::Common;
use crate::bridge::Event;

/// How messages are written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum LogFormat {
    /// For people.
    #[default]
    Text,
    /// One JSON object a line.
    Json,
}

impl FromStr for LogFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "text" => Ok(Self::Text),
            "json" => Ok(Self::Json),
            other => Err(format!("`{other}` is neither text nor json")),
        }
    }
}

/// Messages of the program go to standard error, as many as the user asked for; `RUST_LOG` overrides.
pub(super) fn start_logging(common: &Common) {
    let level = match (common.quiet, common.verbose) {
        (true, _) => "error",
        (false, 0) => "info",
        (false, 1) => "debug",
        (false, _) => "trace",
    };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(level));
    let builder =
        tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_target(false);
    let started = match common.log_format {
        LogFormat::Text => builder.with_ansi(std::io::stderr().is_terminal()).try_init(),
        LogFormat::Json => {
            builder.json().flatten_event(true).with_current_span(false).with_span_list(false).try_init()
        }
    };
    // Only a second start in one process can fail, and then logging is running already.
    drop(started);
}

/// One text on standard output.
pub(super) fn say(text: &str) {
    // A reader that has gone away is not our failure.
    writeln!(std::io::stdout(), "{text}").ok();
}

/// One text on standard error, as the reason for ending.
pub(super) fn complain(text: &str) {
    writeln!(std::io::stderr(), "helmlink: {text}").ok();
}

/// An event of the bridge as a line of the log.
pub(super) fn log(event: &Event) {
    match event.severity {
        0..=3 => tracing::error!("{}", event.text),
        4 => tracing::warn!("{}", event.text),
        5..=6 => tracing::info!("{}", event.text),
        _ => tracing::debug!("{}", event.text),
    }
}

/// A line that is written over again and again on a terminal, and now and then elsewhere.
pub(super) struct ProgressLine {
    enabled: bool,
    is_terminal: bool,
    shown: bool,
    calls: u32,
}

/// Where standard error is no terminal, only every so many progress lines are printed.
const LINES_BETWEEN: u32 = 20;

impl ProgressLine {
    /// Shows nothing when the user wants quiet.
    pub(super) fn new(common: &Common) -> Self {
        Self { enabled: !common.quiet, is_terminal: std::io::stderr().is_terminal(), shown: false, calls: 0 }
    }

    /// Shows `text` in place of the last one.
    pub(super) fn show(&mut self, text: &str) {
        self.calls += 1;
        if !self.enabled {
            return;
        }
        if self.is_terminal {
            write!(std::io::stderr(), "\r\x1b[2K{text}").ok();
            self.shown = true;
        } else if self.calls % LINES_BETWEEN == 1 {
            writeln!(std::io::stderr(), "{text}").ok();
        }
    }

    /// Makes room for other lines.
    pub(super) fn clear(&mut self) {
        if self.shown {
            write!(std::io::stderr(), "\r\x1b[2K").ok();
            self.shown = false;
        }
    }
}
