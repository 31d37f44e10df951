//! `helmlink report`: a log as a page, and as files for other tools.

use std::path::{Path, PathBuf};

use clap::Args;

use super::cli::Common;
use super::failure::Failure;
use super::log_report::{self, LogReport};
use super::ranges::SystemId;
use super::replay::{Engine, LogFiles, Wishes, export, finish_exports, mcap};
use crate::replay::picture::Side;
use crate::replay::what_if::{Sink, Window};

/// `helmlink report`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink report flight.tlog
  helmlink report recordings/ --report my-report --mcap flight.mcap --csv flight.csv")]
pub struct ReportArgs {
    /// The log, or all files of one recording in order, or the folder that holds them
    #[arg(required = true, value_name = "LOG")]
    pub log: Vec<PathBuf>,
    /// Folder for the report
    #[arg(long, default_value = "helmlink-report", value_name = "DIR")]
    pub report: PathBuf,
    /// Write track, state, errors, commands and parameters for Foxglove
    #[arg(long, value_name = "FILE")]
    pub mcap: Option<PathBuf>,
    /// Write one row for each instant
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// The mission; the one transferred or recorded in the log if not given
    #[arg(long, value_name = "FILE")]
    pub mission: Option<PathBuf>,
    /// The vehicle to follow where the log holds several
    #[arg(long, value_name = "ID")]
    pub system: Option<SystemId>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

pub(super) fn run(args: &ReportArgs) -> Result<(), Failure> {
    let mut engine = Engine::scan(LogFiles::find(&args.log)?, args.system.map(u8::from))?;
    let wishes = Wishes { mission: args.mission.as_deref(), ..Wishes::default() };
    let settings = engine.settings(&wishes, Window::Driven)?;
    let mut exports = Vec::new();
    if let Some(path) = &args.csv {
        exports.push(export(path)?);
    }
    if let Some(path) = &args.mcap {
        exports.push(mcap(path, &engine, &settings)?);
    }
    let mut sinks: Vec<&mut dyn Sink> = exports.iter_mut().map(|export| export as &mut dyn Sink).collect();
    let outcome = engine.run(settings.clone(), Side::Recorded, &mut sinks)?;
    finish_exports(exports)?;
    let report = LogReport::new(&engine, &settings, &outcome);
    log_report::write(&args.report, &report, &outcome.what_if, &[], Side::Recorded)?;
    tracing::info!("the page is {}", args.report.join(log_report::PAGE).display());
    report.say(Side::Recorded, args.common.json)
}

/// Writes the report of a recording into `folder`.
///
/// # Errors
/// A log that cannot be read, or a file that cannot be written.
pub(super) fn make(log: &[PathBuf], folder: &Path) -> Result<(), Failure> {
    let mut engine = Engine::scan(LogFiles::find(log)?, None)?;
    let settings = engine.settings(&Wishes::default(), Window::Driven)?;
    let outcome = engine.run(settings.clone(), Side::Recorded, &mut [])?;
    let report = LogReport::new(&engine, &settings, &outcome);
    log_report::write(folder, &report, &outcome.what_if, &[], Side::Recorded)
}
