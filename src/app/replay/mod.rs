//! `helmlink replay`: a recorded log through the controller, or out to a link.

mod compare;
mod drive;
mod engine;
mod log_files;
mod play;
mod proof;
mod what_if;

use std::path::PathBuf;

use clap::{Args, ValueEnum};

pub(super) use self::engine::{Engine, Outcome, Wishes};
pub(super) use self::log_files::LogFiles;
pub(super) use self::what_if::{export, finish as finish_exports, mcap};
use super::cli::Common;
use super::failure::Failure;
use super::ranges::{LogS, SpeedMps, Speedup, SystemId, ToleranceM, WaitS};
use crate::control::Controller;
use crate::link::LinkUrl;
use crate::replay::what_if::Window;
use crate::vehicle::OutputKind;

/// `helmlink replay`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink replay flight.tlog                            what would the controller have commanded?
  helmlink replay flight.tlog --mission plan.waypoints --boat skiff --out commands.csv
  helmlink replay helmlink-report/log.tlog --proof       does it give the same commands again?
  helmlink replay flight.tlog --compare calm.toml lively.toml
  helmlink replay flight.tlog --to udpout:127.0.0.1:14550 --yes-send --speedup 4 --loop

  helmlink replay flight.tlog --drive                    the recorded track again, in the simulator
  helmlink replay flight.tlog --drive --to serial:/dev/ttyAMA0:921600 --yes-send

Whatever the controller says here, the boat goes where it went: the log is an open loop. With --drive it is
driven again: on a boat the track is stored as its mission, and the bridge drives it once the boat is armed.")]
pub struct ReplayArgs {
    /// The log, or all files of one recording in order, or the folder that holds them
    #[arg(required = true, value_name = "LOG")]
    pub log: Vec<PathBuf>,
    /// Make the recorded calls again and compare every frame, byte for byte; only for what helmlink recorded
    #[arg(long, conflicts_with_all = ["compare", "mission", "out"])]
    pub proof: bool,
    /// End with exit code 1 unless this is the SHA-256 of all steering frames, in order
    #[arg(long, value_name = "SHA256")]
    pub expect: Option<String>,
    /// Replay with two boat files (or names) and draw where their commands differ
    #[arg(long, num_args = 2, value_names = ["A", "B"])]
    pub compare: Vec<String>,
    /// The mission; the one transferred or recorded in the log if not given
    #[arg(long, value_name = "FILE")]
    pub mission: Option<PathBuf>,
    /// The boat that the controller is tuned for, a name or a file; the recorded one if not given
    #[arg(long, value_name = "NAME|FILE")]
    pub boat: Option<String>,
    /// The controller; the recorded one if not given
    #[arg(long, value_name = "NAME")]
    pub controller: Option<Controller>,
    /// By which messages the controller would steer; the recorded way if not given
    #[arg(long, value_name = "rc-override|manual-control|guided")]
    pub output: Option<OutputKind>,
    /// Speed over ground where the mission gives none, m/s; as recorded, or the vehicle's WP_SPEED, if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<SpeedMps>,
    /// When the controller is asked
    #[arg(long = "while", value_enum, default_value_t = WindowName::Driven)]
    pub window: WindowName,
    /// The vehicle to follow where the log holds several
    #[arg(long, value_name = "ID")]
    pub system: Option<SystemId>,
    /// Write what the controller commands: .tlog, .csv or .json (one object a line) (repeatable)
    #[arg(long, value_name = "FILE")]
    pub out: Vec<PathBuf>,
    /// Write track, state, errors, commands and parameters for Foxglove
    #[arg(long, value_name = "FILE")]
    pub mcap: Option<PathBuf>,
    /// Drive the recorded track again: in the simulator in calm water, or with --to on a boat
    #[arg(long, conflicts_with_all = ["proof", "compare", "out", "mcap", "mission"])]
    pub drive: bool,
    /// How far the mission that is driven again may be from the recorded track, m
    #[arg(long, default_value = "1", value_name = "M")]
    pub tolerance: ToleranceM,
    /// Play the log to this link instead: udpout:HOST:PORT, tcpin:HOST:PORT, serial:DEVICE:BAUD, …; with --drive,
    /// where the boat's flight controller is
    #[arg(long, value_name = "URL", conflicts_with_all = ["proof", "compare", "out", "mcap"])]
    pub to: Option<LinkUrl>,
    /// Yes, send the recorded frames to --to; with --drive, the mission, and steer
    #[arg(long)]
    pub yes_send: bool,
    /// With --drive --to: arm the motors as well; otherwise the boat waits for somebody to arm it
    #[arg(long, requires_all = ["drive", "to"])]
    pub arm: bool,
    /// Play commands, overrides and mission uploads too, not only what vehicles and others report
    #[arg(long)]
    pub commands: bool,
    /// Play this many times faster than recorded
    #[arg(long, default_value = "1", value_name = "N")]
    pub speedup: Speedup,
    /// Begin playing this many seconds into the log
    #[arg(long, default_value = "0", value_name = "S")]
    pub from: LogS,
    /// End playing this many seconds into the log
    #[arg(long, value_name = "S")]
    pub until: Option<LogS>,
    /// Play again and again
    #[arg(long = "loop")]
    pub looped: bool,
    /// Play only these messages, by name or number (repeatable)
    #[arg(long, value_name = "MESSAGE", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Do not play these messages (repeatable)
    #[arg(long, value_name = "MESSAGE", value_delimiter = ',')]
    pub except: Vec<String>,
    /// Play only what these systems have sent (repeatable)
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    pub systems: Vec<SystemId>,
    /// Shift the wall-clock time that SYSTEM_TIME tells to now; all other frames are played byte for byte
    #[arg(long)]
    pub rebase: bool,
    /// Give up when nobody has come to --to after this many seconds
    #[arg(long, default_value = "60", value_name = "S")]
    pub wait: WaitS,
    /// Folder for the report
    #[arg(long, default_value = "helmlink-replay", value_name = "DIR")]
    pub report: PathBuf,
    /// Write no report
    #[arg(long, conflicts_with = "report")]
    pub no_report: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// When the controller is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum WindowName {
    /// While the boat was armed and in AUTO or GUIDED, or steered by a companion
    Driven,
    /// While it was armed, whoever steered
    Armed,
    /// Always
    Any,
}

impl WindowName {
    pub(super) fn window(self) -> Window {
        match self {
            Self::Driven => Window::Driven,
            Self::Armed => Window::Armed,
            Self::Any => Window::Any,
        }
    }
}

pub(super) fn run(args: &ReplayArgs) -> Result<(), Failure> {
    let files = LogFiles::find(&args.log)?;
    if args.drive {
        drive::run(args, &files)
    } else if let Some(url) = &args.to {
        play::run(args, &files, url)
    } else if args.proof {
        proof::run(args, &files)
    } else if args.compare.is_empty() {
        what_if::run(args, &files)
    } else {
        compare::run(args, &files)
    }
}

/// Compares a digest with the one that the user expects.
fn check_digest(expected: Option<&str>, found: &str) -> Result<(), Failure> {
    match expected {
        Some(expected) if !expected.eq_ignore_ascii_case(found) => Err(Failure::failed(format!(
            "the commands are not those expected: SHA-256 {found} instead of {expected}"
        ))),
        _ => Ok(()),
    }
}
