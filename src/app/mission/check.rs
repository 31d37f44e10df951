//! `helmlink mission check`: says whether and how a boat can drive a mission.

use std::path::PathBuf;

use clap::Args;
use helmlink_mission::plan;
use helmlink_mission::route::Route;
use serde_json::json;

use super::super::cli::Common;
use super::super::console;
use super::super::failure::Failure;
use super::super::ranges::SpeedMps;
use super::review::{Finding, Level, Review, review};
use super::{say_notes, speed_and_boat};

/// `helmlink mission check`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink mission check survey.plan
  helmlink mission check survey.waypoints --boat monohull38 --speed 5 --json

Ends with exit code 0 when the mission can be driven, 1 when something about it should be changed first
(it crosses its fence, or a corner cannot be followed), 2 when it cannot be driven at all.")]
pub struct CheckArgs {
    /// The mission file: .waypoints, .plan, .geojson, .gpx, .kml, .kmz or .csv
    pub mission: PathBuf,
    /// The boat: a name (otter, monohull38, skiff, motorboat), or a boat file
    #[arg(long, default_value = "otter")]
    pub boat: String,
    /// Speed over ground where the mission gives none, m/s; the boat's cruising speed if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<SpeedMps>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

pub(super) fn run(args: &CheckArgs) -> Result<(), Failure> {
    let (boat, speed_mps) = speed_and_boat(&args.boat, args.speed.map(f64::from))?;
    let reading = plan::read_plan(&args.mission).map_err(Failure::usage)?;
    say_notes(&reading.notes);
    let plan = &reading.plan;
    let name = args.mission.display();
    let route =
        Route::from_mission(&plan.mission).map_err(|error| Failure::usage(format!("{name}: {error}")))?;
    let review = review(&route, &plan.fence, &boat, speed_mps);
    let problems = review.findings.iter().filter(|finding| finding.level == Level::Problem).count();
    if args.common.json {
        let first = route.waypoints.first().map(|waypoint| waypoint.position);
        let report = json!({
            "mission": super::stem(&args.mission), "format": reading.format.name(), "boat": boat.name,
            "speed_mps": speed_mps, "items": plan.mission.items.len(), "waypoints": route.waypoints.len(),
            "fence_areas": plan.fence.areas.len(), "rally_points": plan.rally.len(),
            "length_m": review.length_m, "duration_s": review.duration_s, "endless": route.repeat_from.is_some(),
            "first": first.map(|place| [place.latitude_deg, place.longitude_deg]),
            "drivable": problems == 0, "findings": review.findings, "notes": reading.notes,
        });
        console::say(&report.to_string());
    } else {
        console::say(&text(&super::stem(&args.mission), &route, &review, &boat.name, speed_mps));
    }
    match problems {
        0 => Ok(()),
        _ => Err(Failure::failed(format!("{name}: change what is marked as a problem before driving it"))),
    }
}

fn text(name: &str, route: &Route, review: &Review, boat: &str, speed_mps: f64) -> String {
    let can = if review.findings.iter().any(|finding| finding.level == Level::Problem) {
        "there are problems"
    } else {
        "a boat can drive it"
    };
    let mut lines = vec![format!(
        "{name}: {can}. {} waypoints, {:.0} m, about {} with {boat} at {speed_mps:.1} m/s.",
        route.waypoints.len(),
        review.length_m,
        duration(review.duration_s)
    )];
    let mut told: Vec<(Level, &str)> = Vec::new();
    for finding in &review.findings {
        let what = (finding.level, finding.text.as_str());
        if !told.contains(&what) {
            told.push(what);
            lines.push(line(finding, &review.findings));
        }
    }
    lines.join("\n")
}

/// A finding, with all items it is about.
fn line(finding: &Finding, all: &[Finding]) -> String {
    let level = match finding.level {
        Level::Problem => "problem",
        Level::Warning => "warning",
        Level::Note => "note",
    };
    let same = all.iter().filter(|other| other.level == finding.level && other.text == finding.text);
    let items: Vec<String> = same.filter_map(|other| other.item).map(|item| item.to_string()).collect();
    match items.len() {
        0 => format!("  {level}: {}", finding.text),
        1 => format!("  {level}, item {}: {}", items[0], finding.text),
        _ => format!("  {level}, items {}: {}", items.join(", "), finding.text),
    }
}

/// Minutes and seconds, or hours and minutes.
pub(super) fn duration(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {:02} s", seconds / 60, seconds % 60),
        _ => format!("{} h {:02} min", seconds / 3600, seconds / 60 % 60),
    }
}
