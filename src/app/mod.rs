//! The subcommands: wiring only, one file each.

mod ardupilot_json;
mod boat;
mod bridge;
pub mod cli;
mod client;
mod compare;
mod config;
mod config_command;
mod config_schema;
mod console;
mod demo;
pub mod edge;
mod failure;
mod ground_station;
mod guarded;
mod interrupt;
mod log_report;
mod metrics;
mod mission;
mod paced_sitl;
mod parameter_file;
mod parameter_list;
mod ranges;
mod recorder;
mod replay;
mod report;
mod result;
mod scenario;
mod simulate;
mod sitl;
mod sitl_log;
mod state_dir;
mod trial;
mod tune;
mod world;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches};

use self::cli::{Cli, Command};
use self::failure::Failure;

/// Runs the command line that the process was started with; logs on standard error, results on standard output.
pub fn run() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let cli = match read(&arguments) {
        Ok(Some(cli)) => cli,
        Ok(None) => return ExitCode::SUCCESS,
        Err(failure) => return report(&failure),
    };
    console::start_logging(cli.command.common());
    match dispatch(cli.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => report(&failure),
    }
}

/// The command line, with the configuration file merged in; none when everything has been said already.
fn read(arguments: &[OsString]) -> Result<Option<Cli>, Failure> {
    let command = Cli::command();
    let first = match command.clone().try_get_matches_from(arguments) {
        Ok(matches) => matches,
        Err(error) => return clap_ended(&error),
    };
    let merged = config::merge(arguments, &command, &first)?;
    let matches = match command.try_get_matches_from(&merged) {
        Ok(matches) => matches,
        Err(error) => return clap_ended(&error),
    };
    let cli = Cli::from_arg_matches(&matches).map_err(Failure::usage)?;
    if cli.command.common().dry_run {
        console::say(config::describe(&first, &matches, cli.command.common().json).trim_end());
        return Ok(None);
    }
    Ok(Some(cli))
}

/// Help and version go to standard output and are no failure.
fn clap_ended(error: &clap::Error) -> Result<Option<Cli>, Failure> {
    if error.use_stderr() {
        return Err(Failure::usage(one_line(&error.render().to_string())));
    }
    console::say(error.render().to_string().trim_end());
    Ok(None)
}

/// What clap says in paragraphs, as one line without its usage.
fn one_line(error: &str) -> String {
    let paragraphs = error.trim_start_matches("error: ").split("\n\n");
    let lines = paragraphs.filter(|text| !text.trim_start().starts_with("Usage:"));
    let lines = lines.map(|text| text.split_whitespace().collect::<Vec<_>>().join(" "));
    lines.filter(|text| !text.is_empty()).collect::<Vec<_>>().join("; ")
}

fn dispatch(command: Command) -> Result<(), Failure> {
    match command {
        Command::Demo(args) => demo::run(&args),
        Command::Bridge(args) => bridge::run(&args),
        Command::Sitl(args) => sitl::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Tune(args) => tune::run(&args),
        Command::Boat(args) => boat::run(&args),
        Command::Mission(command) => mission::run(&command),
        Command::Config(command) => config_command::run(&command),
    }
}

fn report(failure: &Failure) -> ExitCode {
    console::complain(&failure.to_string());
    failure.exit_code()
}
