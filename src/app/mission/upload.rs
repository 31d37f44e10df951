//! `helmlink mission upload`: sends a mission file to a flight controller.

use std::path::PathBuf;

use clap::Args;
use helmlink_mission::plan::{self, Mission, Plan, differences};
use helmlink_mission::protocol::MissionType;
use helmlink_mission::route::Route;
use serde_json::json;

use super::super::cli::Common;
use super::super::console;
use super::super::failure::Failure;
use super::super::ranges::SpeedMps;
use super::review::{Level, review};
use super::vehicle::{Task, Vehicle, VehicleArgs, converse};
use super::{checksum, say_notes, speed_and_boat};
use crate::vehicle::Mode;

/// `helmlink mission upload`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink mission upload survey.plan --connect tcp:127.0.0.1:5760
  helmlink mission upload survey.waypoints --connect serial:/dev/ttyUSB0:57600 --json

A mission that `helmlink mission check` finds wrong is not sent. Fence and rally points are sent too where the
file has them. Everything is read back and compared. A flight controller overwrites its old mission item by
item: when an upload fails it has neither.")]
pub struct UploadArgs {
    /// The mission file: .waypoints, .plan, .geojson, .gpx, .kml, .kmz or .csv
    pub mission: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub vehicle: VehicleArgs,
    /// Send only the mission, not the fence and the rally points in the file
    #[arg(long)]
    pub mission_only: bool,
    /// The boat that the mission is checked for: a name (otter, monohull38, skiff, motorboat), or a boat file
    #[arg(long, default_value = "otter")]
    pub boat: String,
    /// Speed over ground where the mission gives none, for the check, m/s; the boat's cruising speed if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<SpeedMps>,
    /// Send what a boat cannot drive, too: for a flight controller that knows better
    #[arg(long)]
    pub no_check: bool,
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
    if !args.no_check {
        check(args, &reading.plan)?;
    }
    let stored = send(&args.vehicle, &args.common, &lists, args.force)?;
    report(&args.common, &lists, &stored)
}

/// Sends plans and reads each back; what is stored.
fn send(
    vehicle: &VehicleArgs,
    common: &Common,
    lists: &[(MissionType, Mission)],
    force: bool,
) -> Result<Vec<Mission>, Failure> {
    let tasks: Vec<Task> =
        lists.iter().flat_map(|(kind, list)| [Task::Send(*kind, list.clone()), Task::Fetch(*kind)]).collect();
    converse(vehicle, common, move |vehicle| {
        check_idle(vehicle, force)?;
        Ok(tasks)
    })
}

/// Sends a mission that was made here and can be driven, and makes sure that it is stored.
///
/// # Errors
/// It could not be sent, or something else is stored.
pub(in crate::app) fn send_mission(
    vehicle: &VehicleArgs,
    common: &Common,
    mission: &Mission,
) -> Result<(), Failure> {
    let lists = [(MissionType::Mission, mission.clone())];
    let stored = send(vehicle, common, &lists, false)?;
    match compared(&lists, &stored).into_iter().find_map(|compared| compared.wrong) {
        Some(line) => Err(stored_otherwise(&line)),
        None => Ok(()),
    }
}

/// A mission that no boat drives, or not this one, is not sent.
fn check(args: &UploadArgs, plan: &Plan) -> Result<(), Failure> {
    if plan.mission.items.is_empty() {
        return Ok(());
    }
    let name = args.mission.display();
    let hint = "to send it all the same, add --no-check";
    let (boat, speed_mps) = speed_and_boat(&args.boat, args.speed.map(f64::from))?;
    let route = Route::from_mission(&plan.mission)
        .map_err(|error| Failure::usage(format!("{name}: {error}; {hint}")))?;
    let review = review(&route, &plan.fence, &boat, speed_mps);
    let problems: Vec<_> = review.findings.iter().filter(|finding| finding.level == Level::Problem).collect();
    let Some(first) = problems.first() else { return Ok(()) };
    let item = first.item.map_or_else(String::new, |item| format!("item {item}: "));
    let more = match problems.len() {
        1 => String::new(),
        count => format!(", and {} more (see helmlink mission check)", count - 1),
    };
    Err(Failure::failed(format!("{name}: {item}{}{more}; nothing was sent; {hint}", first.text)))
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

/// What has become of one plan.
struct Compared {
    name: &'static str,
    items: usize,
    checksum: String,
    verified: bool,
    /// What the flight controller does not keep, and nobody needs.
    not_kept: Vec<String>,
    /// The first thing that matters and is not the same.
    wrong: Option<String>,
}

fn compared(lists: &[(MissionType, Mission)], stored: &[Mission]) -> Vec<Compared> {
    let compare = |((kind, list), stored): (&(MissionType, Mission), &Mission)| {
        let name = super::kind_name(*kind);
        let (mut wrong, mut not_kept) = (None, Vec::new());
        for difference in differences(&list.items, &stored.items) {
            let line = format!("item {}: {}", difference.item, difference.text);
            if difference.matters {
                tracing::error!("{name}, {line}");
                wrong.get_or_insert(format!("{name}, {line}"));
            } else {
                tracing::debug!("{name}, {line} (the flight controller does not keep it)");
                not_kept.push(line);
            }
        }
        let checksum = checksum(&stored.items);
        let verified = wrong.is_none() && checksum == super::checksum(&list.items);
        Compared { name, items: list.items.len(), checksum, verified, not_kept, wrong }
    };
    lists.iter().zip(stored).map(compare).collect()
}

fn stored_otherwise(line: &str) -> Failure {
    Failure::failed(format!("the flight controller stored something else: {line}"))
}

fn report(common: &Common, lists: &[(MissionType, Mission)], stored: &[Mission]) -> Result<(), Failure> {
    let compared = compared(lists, stored);
    if let Some(line) = compared.iter().find_map(|plan| plan.wrong.as_deref()) {
        return Err(stored_otherwise(line));
    }
    if common.json {
        let value = |plan: &Compared| {
            json!({
                "items": plan.items, "verified": plan.verified, "checksum_sha256": plan.checksum,
                "not_kept": plan.not_kept,
            })
        };
        let sent: serde_json::Map<_, _> =
            compared.iter().map(|plan| (plan.name.to_owned(), value(plan))).collect();
        console::say(&json!({ "uploaded": sent }).to_string());
    } else {
        let line = |plan: &Compared| {
            let Compared { name, items, checksum, .. } = plan;
            format!("{name}: {items} items on board, read back and compared; SHA-256 {checksum}")
        };
        console::say(&compared.iter().map(line).collect::<Vec<_>>().join("\n"));
    }
    Ok(())
}
