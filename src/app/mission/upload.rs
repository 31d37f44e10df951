//! `helmlink mission upload`: sends a mission file to a flight controller.

use std::path::PathBuf;

use clap::Args;
use helmlink_mission::plan::{self, Mission, Plan, differences};
use helmlink_mission::protocol::MissionType;
use serde_json::json;

use super::super::cli::Common;
use super::super::console;
use super::super::failure::Failure;
use super::vehicle::{Task, Vehicle, VehicleArgs, converse};
use super::{checksum, say_notes};
use crate::vehicle::Mode;

/// `helmlink mission upload`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink mission upload survey.plan --connect tcp:127.0.0.1:5760
  helmlink mission upload survey.waypoints --connect serial:/dev/ttyUSB0:57600 --json

Fence and rally points are sent too where the file has them. Everything is read back and compared. A
flight controller overwrites its old mission item by item: when an upload fails it has neither.")]
pub struct UploadArgs {
    /// The mission file: .waypoints, .plan, .geojson, .gpx, .kml, .kmz or .csv
    pub mission: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub vehicle: VehicleArgs,
    /// Send only the mission, not the fence and the rally points in the file
    #[arg(long)]
    pub mission_only: bool,
    /// Send even to a boat that is armed and driving its mission: it follows the half-sent one meanwhile
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

pub(super) fn run(args: &UploadArgs) -> Result<(), Failure> {
    let reading = plan::read_plan(&args.mission).map_err(Failure::usage)?;
    say_notes(&reading.notes);
    let lists = lists(&reading.plan, args.mission_only);
    if lists.is_empty() {
        return Err(Failure::usage(format!("{}: there is no mission in it", args.mission.display())));
    }
    let tasks: Vec<Task> =
        lists.iter().flat_map(|(kind, list)| [Task::Send(*kind, list.clone()), Task::Fetch(*kind)]).collect();
    let force = args.force;
    let stored = converse(&args.vehicle, &args.common, move |vehicle| {
        check_idle(vehicle, force)?;
        Ok(tasks)
    })?;
    report(args, &lists, &stored)
}

/// The plans of a file, by kind.
fn lists(plan: &Plan, mission_only: bool) -> Vec<(MissionType, Mission)> {
    let of = |items| Mission { home: None, items };
    let rally = plan.rally.iter().map(|rally| rally.to_item()).collect();
    let all = [
        (MissionType::Mission, plan.mission.clone()),
        (MissionType::Fence, of(plan.fence.to_items())),
        (MissionType::Rally, of(rally)),
    ];
    all.into_iter()
        .filter(|(kind, list)| !list.items.is_empty() && (*kind == MissionType::Mission || !mission_only))
        .collect()
}

fn check_idle(vehicle: Vehicle, force: bool) -> Result<(), Failure> {
    if vehicle.armed && vehicle.mode == Mode::AUTO && !force {
        return Err(Failure::failed(
            "the boat is armed and drives its mission (AUTO): it would follow the half-sent one; change to HOLD \
             first, or give --force",
        ));
    }
    Ok(())
}

fn report(args: &UploadArgs, lists: &[(MissionType, Mission)], stored: &[Mission]) -> Result<(), Failure> {
    let mut sent = serde_json::Map::new();
    let mut text = Vec::new();
    let mut wrong = None;
    for ((kind, list), stored) in lists.iter().zip(stored) {
        let found = differences(&list.items, &stored.items);
        let name = super::kind_name(*kind);
        let matching = checksum(&list.items) == checksum(&stored.items);
        for difference in &found {
            let line = format!("{name}, item {}: {}", difference.item, difference.text);
            if difference.matters {
                tracing::error!("{line}");
                wrong.get_or_insert(line);
            } else {
                tracing::debug!("{line} (the flight controller does not keep it)");
            }
        }
        let sum = checksum(&stored.items);
        text.push(format!(
            "{name}: {} items on board, read back and compared; SHA-256 {sum}",
            list.items.len()
        ));
        let value = json!({
            "items": list.items.len(),
            "verified": matching && !found.iter().any(|difference| difference.matters),
            "checksum_sha256": sum,
            "not_kept": found.iter().filter(|d| !d.matters).map(|d| format!("item {}: {}", d.item, d.text)).collect::<Vec<_>>(),
        });
        sent.insert(name.to_owned(), value);
    }
    if let Some(line) = wrong {
        return Err(Failure::failed(format!("the flight controller stored something else: {line}")));
    }
    if args.common.json {
        console::say(&json!({ "uploaded": sent }).to_string());
    } else {
        console::say(&text.join("\n"));
    }
    Ok(())
}
