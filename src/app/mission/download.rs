//! `helmlink mission download`: fetches the mission of a flight controller into a file.

use std::path::PathBuf;

use clap::Args;
use helmlink_mission::plan::{Fence, Plan, RallyPoint};
use helmlink_mission::protocol::MissionType;
use serde_json::json;

use super::super::cli::Common;
use super::super::console;
use super::super::failure::Failure;
use super::vehicle::{Task, VehicleArgs, converse};
use super::{checksum, convert};

/// `helmlink mission download`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink mission download --connect tcp:127.0.0.1:5760 -o on-board.waypoints
  helmlink mission download --connect udpin:0.0.0.0:14550 --all -o on-board.plan
  helmlink mission download --connect tcp:127.0.0.1:5760           the mission on standard output

The ending of the file decides its format.")]
pub struct DownloadArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub vehicle: VehicleArgs,
    /// The file to write; standard output (QGC WPL 110) if not given
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// The format of the file, if its ending does not say: wpl, plan, geojson, gpx, kml, kmz or csv
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Fetch the fence and the rally points, too
    #[arg(long)]
    pub all: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

pub(super) fn run(args: &DownloadArgs) -> Result<(), Failure> {
    // Before anything is asked of the vehicle: a format that is unknown is found at once.
    let format = convert::target(args.output.as_deref(), args.format.as_deref())?;
    let plan = fetch(&args.vehicle, &args.common, args.all)?;
    if plan.is_empty() {
        return Err(Failure::failed("there is no mission on board"));
    }
    let sum = checksum(&plan.mission.items);
    let losses = convert::write(&plan, format, args.output.as_deref(), args.common.json)?;
    if args.common.json {
        let items = plan.mission.items.len();
        let losses: Vec<String> = losses.iter().map(ToString::to_string).collect();
        let report = json!({
            "items": items, "fence_areas": plan.fence.areas.len(), "rally_points": plan.rally.len(),
            "checksum_sha256": sum, "output": args.output, "format": format.name(), "losses": losses,
        });
        console::say(&report.to_string());
    } else {
        tracing::info!("{} items; SHA-256 {sum}", plan.mission.items.len());
    }
    Ok(())
}

/// What is on board.
pub(super) fn fetch(vehicle: &VehicleArgs, common: &Common, all: bool) -> Result<Plan, Failure> {
    let kinds: &[MissionType] = if all { &MissionType::ALL } else { &MissionType::ALL[..1] };
    let tasks = kinds.iter().map(|kind| Task::Fetch(*kind)).collect();
    let mut fetched = converse(vehicle, common, |_| Ok(tasks))?.into_iter();
    let mission = fetched.next().unwrap_or_default();
    let fence = fetched.next().unwrap_or_default();
    let rally = fetched.next().unwrap_or_default();
    let rally: Result<Vec<RallyPoint>, _> = rally.items.iter().map(RallyPoint::from_item).collect();
    Ok(Plan {
        mission,
        fence: Fence::from_items(&fence.items).map_err(Failure::failed)?,
        rally: rally.map_err(Failure::failed)?,
    })
}
