//! `helmlink mission …`: mission files.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use helmlink_mission::plan::{self, Mission};
use helmlink_mission::route::Route;
use serde::Serialize;

use super::cli::Common;
use super::console;
use super::failure::Failure;

/// `helmlink mission …`.
#[derive(Debug, Subcommand)]
pub enum MissionCommand {
    /// Read a mission file and say whether a boat can drive it
    Check(MissionFileArgs),
}

/// `helmlink mission check`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Example:\n  helmlink mission check mission/plans/harbour-survey.waypoints")]
pub struct MissionFileArgs {
    /// The mission file (.waypoints or .plan)
    pub mission: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

impl MissionCommand {
    /// The options that every subcommand has.
    pub fn common(&self) -> &Common {
        match self {
            Self::Check(args) => &args.common,
        }
    }
}

pub(super) fn run(command: &MissionCommand) -> Result<(), Failure> {
    match command {
        MissionCommand::Check(args) => check(args),
    }
}

/// A mission that can be driven, with what it is called.
pub(super) struct Drivable {
    pub(super) name: String,
    pub(super) mission: Mission,
    pub(super) route: Route,
}

/// Reads a mission file and checks that a boat can drive it.
///
/// # Errors
/// The file cannot be read, or the mission cannot be driven: where, and what to do.
pub(super) fn load(path: &Path) -> Result<Drivable, Failure> {
    let mission = plan::read(path).map_err(Failure::usage)?;
    let name = path
        .file_stem()
        .map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned());
    checked(name, mission)
}

/// The mission that comes with helmlink, for the demonstration.
pub(super) fn sample() -> Result<Drivable, Failure> {
    const SAMPLE: &str = include_str!("../../mission/plans/harbour-survey.waypoints");
    let mission: Mission = SAMPLE.parse().map_err(Failure::usage)?;
    checked("harbour-survey".to_owned(), mission)
}

fn checked(name: String, mission: Mission) -> Result<Drivable, Failure> {
    let route = Route::from_mission(&mission).map_err(|error| Failure::usage(format!("{name}: {error}")))?;
    Ok(Drivable { name, mission, route })
}

/// What `mission check` reports.
#[derive(Debug, Serialize)]
struct Report {
    mission: String,
    items: usize,
    waypoints: usize,
    length_m: f64,
    first: [f64; 2],
}

fn check(args: &MissionFileArgs) -> Result<(), Failure> {
    let drivable = load(&args.mission)?;
    let waypoints = &drivable.route.waypoints;
    let length_m: f64 = waypoints.windows(2).map(|leg| leg[0].position.distance_m(leg[1].position)).sum();
    let first = waypoints
        .first()
        .map_or([0.0; 2], |point| [point.position.latitude_deg, point.position.longitude_deg]);
    let report = Report {
        mission: drivable.name,
        items: drivable.mission.items.len(),
        waypoints: waypoints.len(),
        length_m,
        first,
    };
    if args.common.json {
        console::say(&serde_json::to_string_pretty(&report).map_err(Failure::failed)?);
    } else {
        console::say(&format!(
            "{}: a boat can drive it. {} items, {} waypoints, {:.0} m from the first waypoint to the last.",
            report.mission, report.items, report.waypoints, report.length_m
        ));
    }
    Ok(())
}
