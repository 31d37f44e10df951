//! `helmlink mission show`: draws a mission, in the terminal and as SVG.

use std::path::PathBuf;

use clap::Args;
use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::plan;
use helmlink_mission::route::Route;
use serde_json::json;

use super::super::cli::Common;
use super::super::console;
use super::super::failure::Failure;
use super::super::ranges::{Columns, SpeedMps};
use super::canvas::Canvas;
use super::check::duration;
use super::review::{Review, review};
use super::{say_notes, speed_and_boat, stem};
use crate::report::{self, FenceArea, Run};

/// `helmlink mission show`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink mission show mission/plans/harbour-survey.waypoints
  helmlink mission show survey.plan --svg survey.svg
  helmlink mission show survey.plan --width 120

In the terminal: the smooth path that the boat is given, numbers at the items, dotted fence, R for rally
points, H for home.")]
pub struct ShowArgs {
    /// The mission file: .waypoints, .plan, .geojson, .gpx, .kml, .kmz or .csv
    pub mission: PathBuf,
    /// Write a picture (SVG) instead of drawing in the terminal
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Columns to draw in
    #[arg(long, default_value = "78", value_name = "N")]
    pub width: Columns,
    /// The boat whose turns are drawn: a name (otter, monohull38, skiff, motorboat), or a boat file
    #[arg(long, default_value = "otter")]
    pub boat: String,
    /// Speed over ground where the mission gives none, m/s; the boat's cruising speed if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<SpeedMps>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

pub(super) fn run(args: &ShowArgs) -> Result<(), Failure> {
    let (boat, speed_mps) = speed_and_boat(&args.boat, args.speed.map(f64::from))?;
    let reading = plan::read_plan(&args.mission).map_err(Failure::usage)?;
    say_notes(&reading.notes);
    let name = stem(&args.mission);
    let mission = &reading.plan.mission;
    let route = Route::from_mission(mission).map_err(|error| Failure::usage(format!("{name}: {error}")))?;
    let review = review(&route, &reading.plan.fence, &boat, speed_mps);
    let summary = format!(
        "{} items, {} waypoints, {:.0} m, about {} with {} at {speed_mps:.1} m/s",
        mission.items.len(),
        route.waypoints.len(),
        review.length_m,
        duration(review.duration_s),
        boat.name
    );
    let run = Run {
        title: name.clone(),
        subtitle: vec![summary.clone()],
        mission: review.waypoints.clone(),
        path: review.path.clone(),
        fence: FenceArea::all_of(&reading.plan.fence, &review.frame),
        rally: reading.plan.rally.iter().map(|rally| review.frame.to_local(rally.position)).collect(),
        figures: vec![
            ("items".to_owned(), mission.items.len().to_string()),
            ("waypoints".to_owned(), route.waypoints.len().to_string()),
            ("length".to_owned(), format!("{:.0} m", review.length_m)),
            ("time, about".to_owned(), duration(review.duration_s)),
        ],
        ..Run::default()
    };
    if let Some(path) = &args.svg {
        std::fs::write(path, report::track_svg(&run))
            .map_err(|error| Failure::failed(format!("cannot write {}: {error}", path.display())))?;
    }
    if args.common.json {
        let local = |places: &[NorthEast]| -> Vec<[f64; 2]> {
            places.iter().map(|place| [place.north_m, place.east_m]).collect()
        };
        let report = json!({
            "mission": name, "svg": args.svg, "length_m": review.length_m, "duration_s": review.duration_s,
            "origin": [review.frame.origin().latitude_deg, review.frame.origin().longitude_deg],
            "waypoints_north_east_m": local(&review.waypoints), "path_north_east_m": local(&review.path),
            "fence_north_east_m": run.fence.iter().map(|area| local(&area.outline)).collect::<Vec<_>>(),
            "rally_north_east_m": local(&run.rally),
        });
        console::say(&report.to_string());
    } else if args.svg.is_none() {
        let home = route.home.map(|home| review.frame.to_local(home));
        console::say(&format!("{name}: {summary}\n{}", drawing(&review, &route, &run, home, *args.width)));
    }
    Ok(())
}

fn drawing(review: &Review, route: &Route, run: &Run, home: Option<NorthEast>, width: u16) -> String {
    let outlines = run.fence.iter().flat_map(|area| &area.outline);
    let everything =
        review.path.iter().chain(&review.waypoints).chain(&home).chain(outlines).chain(&run.rally);
    let mut canvas = Canvas::around(everything.copied(), usize::from(width));
    for area in &run.fence {
        canvas.dots(&area.outline);
    }
    canvas.line(&review.path);
    for (waypoint, place) in route.waypoints.iter().zip(&review.waypoints) {
        canvas.label(*place, &waypoint.item.to_string());
    }
    for (number, place) in (1..).zip(&run.rally) {
        canvas.label(*place, &format!("R{number}"));
    }
    if let Some(home) = home {
        canvas.label(home, "H");
    }
    canvas.finish()
}
