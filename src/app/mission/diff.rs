//! `helmlink mission diff`: compares a mission file with another, or with what a flight controller has.

use std::path::PathBuf;

use clap::Args;
use helmlink_mission::plan::{self, differences};
use serde_json::json;

use super::super::cli::Common;
use super::super::console;
use super::super::failure::Failure;
use super::super::ranges::WaitS;
use super::vehicle::VehicleArgs;
use super::{checksum, download};
use crate::link::LinkUrl;

/// `helmlink mission diff`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink mission diff survey.waypoints --connect tcp:127.0.0.1:5760
  helmlink mission diff monday.plan tuesday.waypoints --json

Ends with exit code 0 when both mean the same to a boat, 1 when they differ. What a flight controller
does not keep (the acceptance radius of a waypoint, say) is told, but is no difference.")]
pub struct DiffArgs {
    /// The mission file
    pub mission: PathBuf,
    /// Another mission file to compare it with
    #[arg(required_unless_present = "connect", conflicts_with = "connect")]
    pub other: Option<PathBuf>,
    /// Compare with the mission of this flight controller
    #[arg(long, value_name = "URL")]
    pub connect: Option<LinkUrl>,
    /// Give up when no heartbeat has come for this many seconds
    #[arg(long, default_value = "10", value_name = "S")]
    pub wait: WaitS,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

pub(super) fn run(args: &DiffArgs) -> Result<(), Failure> {
    let one = plan::read(&args.mission).map_err(Failure::usage)?;
    let other = match (&args.other, &args.connect) {
        (Some(path), _) => plan::read(path).map_err(Failure::usage)?,
        (None, Some(connect)) => {
            let vehicle = VehicleArgs { connect: connect.clone(), wait: args.wait };
            download::fetch(&vehicle, &args.common, false)?.mission
        }
        (None, None) => {
            return Err(Failure::usage("say what to compare with: another file, or --connect URL"));
        }
    };
    let found = differences(&one.items, &other.items);
    let matters = found.iter().filter(|difference| difference.matters).count();
    if args.common.json {
        let list: Vec<_> = found
            .iter()
            .map(|difference| json!({ "item": difference.item, "text": difference.text, "matters": difference.matters }))
            .collect();
        let sums = [checksum(&one.items), checksum(&other.items)];
        console::say(
            &json!({ "same": matters == 0, "differences": list, "checksums_sha256": sums }).to_string(),
        );
    } else {
        for difference in &found {
            let less = if difference.matters { "" } else { " (does not matter)" };
            console::say(&format!("item {}: {}{less}", difference.item, difference.text));
        }
        if matters == 0 {
            console::say(&format!(
                "the same to a boat: {} items, SHA-256 {}",
                one.items.len(),
                checksum(&one.items)
            ));
        }
    }
    match matters {
        0 => Ok(()),
        1 => Err(Failure::failed("the missions differ in one place")),
        _ => Err(Failure::failed(format!("the missions differ in {matters} places"))),
    }
}
