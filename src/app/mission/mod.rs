//! `helmlink mission …`: mission files, and the missions of flight controllers.

mod canvas;
mod check;
mod convert;
mod diff;
mod download;
mod from_track;
mod review;
mod show;
mod upload;
mod vehicle;

#[cfg(test)]
mod tests;

use std::path::Path;

use clap::Subcommand;
use helmlink_mission::geodesy::LocalFrame;
use helmlink_mission::plan::{self, Fence, Item, Mission, Plan, RallyPoint, canonical};
use helmlink_mission::protocol::MissionType;
use helmlink_mission::route::Route;
use sha2::{Digest, Sha256};

use self::check::CheckArgs;
use self::convert::ConvertArgs;
use self::diff::DiffArgs;
use self::download::DownloadArgs;
use self::from_track::FromTrackArgs;
use self::show::ShowArgs;
use self::upload::UploadArgs;
pub(super) use self::upload::send_mission;
pub(super) use self::vehicle::VehicleArgs;
use super::cli::Common;
use super::failure::Failure;
use crate::control::Boat;
use crate::report::{FenceArea, Run};

/// `helmlink mission …`.
#[derive(Debug, Subcommand)]
pub enum MissionCommand {
    /// Say whether and how a boat can drive a mission: corners, fence, length, time
    Check(CheckArgs),
    /// Draw a mission, in the terminal or as a picture
    Show(ShowArgs),
    /// Convert between mission file formats, and say what gets lost
    Convert(ConvertArgs),
    /// Send a mission file to a flight controller
    Upload(UploadArgs),
    /// Fetch the mission of a flight controller
    Download(DownloadArgs),
    /// Compare a mission file with another or with a flight controller's
    Diff(DiffArgs),
    /// Make a mission from the track in a telemetry log
    FromTrack(FromTrackArgs),
}

impl MissionCommand {
    /// The options that every subcommand has.
    pub fn common(&self) -> &Common {
        match self {
            Self::Check(args) => &args.common,
            Self::Show(args) => &args.common,
            Self::Convert(args) => &args.common,
            Self::Upload(args) => &args.common,
            Self::Download(args) => &args.common,
            Self::Diff(args) => &args.common,
            Self::FromTrack(args) => &args.common,
        }
    }
}

pub(super) fn run(command: &MissionCommand) -> Result<(), Failure> {
    match command {
        MissionCommand::Check(args) => check::run(args),
        MissionCommand::Show(args) => show::run(args),
        MissionCommand::Convert(args) => convert::run(args),
        MissionCommand::Upload(args) => upload::run(args),
        MissionCommand::Download(args) => download::run(args),
        MissionCommand::Diff(args) => diff::run(args),
        MissionCommand::FromTrack(args) => from_track::run(args),
    }
}

/// A mission that can be driven, with what it is called.
pub(super) struct Drivable {
    pub(super) name: String,
    pub(super) mission: Mission,
    pub(super) route: Route,
    pub(super) fence: Fence,
    pub(super) rally: Vec<RallyPoint>,
}

impl Drivable {
    /// Draws where the boat may not go and where it may return to; `run` counts from the first waypoint.
    pub(super) fn chart(&self, run: Run) -> Run {
        let Some(first) = self.route.waypoints.first() else { return run };
        let frame = LocalFrame::new(first.position);
        Run {
            fence: FenceArea::all_of(&self.fence, &frame),
            rally: self.rally.iter().map(|rally| frame.to_local(rally.position)).collect(),
            ..run
        }
    }
}

/// Reads a mission file and checks that a boat can drive it.
///
/// # Errors
/// The file cannot be read, or the mission cannot be driven: where, and what to do.
pub(super) fn load(path: &Path) -> Result<Drivable, Failure> {
    let reading = plan::read_plan(path).map_err(Failure::usage)?;
    say_notes(&reading.notes);
    checked(stem(path), reading.plan)
}

/// The mission that comes with helmlink, for the demonstration.
pub(super) fn sample() -> Result<Drivable, Failure> {
    const SAMPLE: &str = include_str!("../../../mission/plans/harbour-survey.waypoints");
    let mission: Mission = SAMPLE.parse().map_err(Failure::usage)?;
    checked("harbour-survey".to_owned(), Plan { mission, ..Plan::default() })
}

fn checked(name: String, plan: Plan) -> Result<Drivable, Failure> {
    let Plan { mission, fence, rally } = plan;
    let route = Route::from_mission(&mission).map_err(|error| Failure::usage(format!("{name}: {error}")))?;
    Ok(Drivable { name, mission, route, fence, rally })
}

/// What a mission is called: its file without folder and ending.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned())
}

/// What a file's reader has left out or guessed.
fn say_notes(notes: &[String]) {
    for note in notes {
        tracing::warn!("{note}");
    }
}

/// The boat, and the speed to drive at where the mission gives none.
fn speed_and_boat(name: &str, speed_mps: Option<f64>) -> Result<(Boat, f64), Failure> {
    let boat = super::boat::load(name)?;
    super::trial::check_speed(speed_mps, &boat)?;
    let speed_mps = speed_mps.unwrap_or(boat.limits.cruise_mps);
    Ok((boat, speed_mps))
}

/// SHA-256 of what matters to a boat of these items: the same on both sides of a good transfer.
fn checksum(items: &[Item]) -> String {
    let digest = Sha256::digest(canonical(items).as_bytes());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn kind_name(kind: MissionType) -> &'static str {
    match kind {
        MissionType::Mission => "mission",
        MissionType::Fence => "fence",
        MissionType::Rally => "rally points",
    }
}
