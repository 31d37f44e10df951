//! The command line. Each subcommand defines its options once, in its own file; help, configuration files and
//! defaults follow from them.

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand};

use super::boat::BoatArgs;
use super::bridge::BridgeArgs;
use super::compare::CompareArgs;
use super::config_command::ConfigCommand;
use super::console::LogFormat;
use super::demo::DemoArgs;
use super::mission::MissionCommand;
use super::replay::ReplayArgs;
use super::report::ReportArgs;
use super::simulate::SimulateArgs;
use super::sitl::SitlArgs;
use super::tune::TuneArgs;

/// Steers an uncrewed boat along its mission, or simulates one.
#[derive(Debug, Parser)]
#[command(name = "helmlink", version, about, max_term_width = 100, after_help = TOP_EXAMPLES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const TOP_EXAMPLES: &str = "\
Examples:
  helmlink demo                                     a boat drives a mission before your eyes
  helmlink sitl                                     the simulated boat, for any ground station
  helmlink bridge --connect tcp:127.0.0.1:5760      the bridge, on a simulated or a real boat
  helmlink simulate mission/plans/fossen-otter.waypoints --json

Exit codes: 0 done, 1 the job did not succeed, 2 wrong usage or input, 3 no link.";

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Start the built-in boat and the bridge, and drive a sample mission in sight
    Demo(Box<DemoArgs>),
    /// Steer a boat along its mission, through its flight controller
    Bridge(Box<BridgeArgs>),
    /// Run the simulated boat alone
    Sitl(Box<SitlArgs>),
    /// Drive a mission in simulation as fast as the machine allows, and report how well
    Simulate(Box<SimulateArgs>),
    /// Drive a mission with every controller in many seas, and compare them
    Compare(Box<CompareArgs>),
    /// Put a recorded log through the controller, prove a recording, or play it to a link
    Replay(Box<ReplayArgs>),
    /// Make a page, tables and Foxglove files of a log
    Report(Box<ReportArgs>),
    /// Find gains by search in simulation
    Tune(Box<TuneArgs>),
    /// Write a boat file by rule, from length, top speed and turning circle
    Boat(Box<BoatArgs>),
    /// Check, draw, convert, send and fetch missions
    #[command(subcommand)]
    Mission(MissionCommand),
    /// Show, check and describe configuration files
    #[command(subcommand)]
    Config(ConfigCommand),
}

/// Options that every subcommand has.
#[derive(Debug, Clone, Default, Args)]
pub struct Common {
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// Say more (repeat for still more); messages go to standard error
    #[arg(short, long, action = ArgAction::Count)]
    pub verbose: u8,
    /// Say only what went wrong
    #[arg(short, long)]
    pub quiet: bool,
    /// How messages are written: as text, or as one JSON object a line
    #[arg(long, default_value = "text", value_name = "text|json")]
    pub log_format: LogFormat,
    /// Read options from a TOML file; its tables are named after the subcommands
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Print the merged settings and where each came from, then end without touching anything
    #[arg(long)]
    pub dry_run: bool,
}

impl Command {
    /// The options that every subcommand has.
    pub fn common(&self) -> &Common {
        match self {
            Self::Demo(args) => &args.common,
            Self::Bridge(args) => &args.common,
            Self::Sitl(args) => &args.common,
            Self::Simulate(args) => &args.common,
            Self::Compare(args) => &args.common,
            Self::Replay(args) => &args.common,
            Self::Report(args) => &args.common,
            Self::Tune(args) => &args.common,
            Self::Boat(args) => &args.common,
            Self::Mission(command) => command.common(),
            Self::Config(command) => command.common(),
        }
    }
}
