//! The report of a log: JSON for programs, a few lines for people, a folder to keep.

use std::fs;
use std::path::Path;

use serde::Serialize;

use super::console;
use super::failure::Failure;
use super::replay::{Engine, Outcome};
use crate::replay::picture::Side;
use crate::replay::what_if::{WhatIfResult, WhatIfSettings};
use crate::report::{self, Panel, Run};
use crate::simulation::score::{Score, Spread};

/// What is known of a log and its replay, as `--json` prints it.
#[derive(Debug, Clone, Serialize)]
pub(super) struct LogReport {
    log: String,
    bytes: u64,
    records: u64,
    vehicle_system: u8,
    boat: String,
    output: crate::vehicle::OutputKind,
    recorded_rate: f64,
    damaged_frames: u64,
    skipped_bytes: u64,
    out_of_order: u64,
    #[serde(flatten)]
    result: WhatIfResult,
    realtime_factor: f64,
    notes: Vec<String>,
}

impl LogReport {
    pub(super) fn new(engine: &Engine, settings: &WhatIfSettings, outcome: &Outcome) -> Self {
        let scan = &engine.scan;
        Self {
            log: engine.files().name(),
            bytes: engine.files().bytes(),
            records: scan.records,
            vehicle_system: engine.vehicle.system,
            boat: settings.boat.name.clone(),
            output: settings.output,
            recorded_rate: scan.vehicles.get(&engine.vehicle).map_or(1.0, |vehicle| vehicle.rate()),
            damaged_frames: scan.statistics.crc_errors,
            skipped_bytes: scan.statistics.resynchronised_bytes,
            out_of_order: scan.disordered,
            result: outcome.result.clone(),
            realtime_factor: outcome.result.vehicle_s / outcome.wall_s.max(1e-9),
            notes: outcome.notes.clone(),
        }
    }

    /// Label and value of each figure, of the side that is shown.
    fn figures(&self, side: Side) -> Vec<(String, String)> {
        let result = &self.result;
        let mut rows = vec![
            ("log".to_owned(), format!("{}, {} records", self.log, self.records)),
            (
                "vehicle time".to_owned(),
                format!("{:.1} s, {:.1} s of them driven", result.vehicle_s, result.driven_s),
            ),
            ("waypoints reached".to_owned(), format!("{} of {}", result.reached_recorded, result.waypoints)),
        ];
        if let Some(score) = result.recorded.as_ref().or(result.replayed.as_ref()) {
            rows.extend(driven_figures(score));
        }
        let effort = |score: &Option<Score>| {
            score.as_ref().map_or_else(
                || "not known".to_owned(),
                |score| {
                    format!("{:.2} per minute, effort {:.3}", score.steering_variation_per_min, score.effort)
                },
            )
        };
        rows.push(("steering, recorded".to_owned(), effort(&result.recorded)));
        if side == Side::Replayed {
            rows.push(("steering, replayed".to_owned(), effort(&result.replayed)));
            rows.extend(self.comparison_figures());
            rows.push(("boat, commands".to_owned(), format!("{}, {} frames", self.boat, result.commands)));
            rows.push(("commands SHA-256".to_owned(), result.commands_sha256.clone()));
            rows.push(("speed of replay".to_owned(), format!("{:.0} × real time", self.realtime_factor)));
        }
        rows
    }

    fn comparison_figures(&self) -> Vec<(String, String)> {
        let Some(difference) = &self.result.difference else { return Vec::new() };
        let correlation = difference
            .steering_correlation
            .map_or_else(String::new, |correlation| format!(", correlation {correlation:.2}"));
        vec![
            (
                "steering, difference".to_owned(),
                format!("{:.3} rms of full{correlation}", difference.steering_rms),
            ),
            ("throttle, difference".to_owned(), format!("{:.3} rms of full", difference.throttle_rms)),
        ]
    }

    /// Prints the figures of one side.
    ///
    /// # Errors
    /// It cannot be written as JSON.
    pub(super) fn say(&self, side: Side, json: bool) -> Result<(), Failure> {
        if json {
            console::say(&serde_json::to_string_pretty(self).map_err(Failure::failed)?);
            return Ok(());
        }
        for note in &self.notes {
            tracing::warn!("{note}");
        }
        let figures = self.figures(side);
        let width = figures.iter().map(|(label, _)| label.chars().count()).max().unwrap_or(0);
        let lines: Vec<String> =
            figures.into_iter().map(|(label, value)| format!("  {label:<width$}  {value}")).collect();
        console::say(&lines.join("\n"));
        Ok(())
    }
}

fn driven_figures(score: &Score) -> Vec<(String, String)> {
    let spread = |spread: &Option<Spread>| match spread {
        Some(spread) => format!("{:.2} m rms, {:.2} m max", spread.rms, spread.max),
        None => "no samples".to_owned(),
    };
    vec![
        ("distance".to_owned(), format!("{:.0} m in {:.0} s", score.distance_m, score.duration_s)),
        ("cross-track driven, whole".to_owned(), spread(&score.cross_track_m)),
        ("cross-track driven, straight".to_owned(), spread(&score.cross_track_straight_m)),
    ]
}

/// Name of the page in a report folder.
pub(super) const PAGE: &str = "report.html";
/// Name of the comparison in the report folder of a replay.
const COMMANDS: &str = "commands.svg";

/// Writes page, pictures and result into `folder`. The log stays where it is.
///
/// # Errors
/// A file cannot be written: which, and why.
pub(super) fn write(
    folder: &Path,
    report: &LogReport,
    run: &Run,
    panels: &[Panel],
    side: Side,
) -> Result<(), Failure> {
    let title = match side {
        Side::Recorded => format!("{} as it was driven", report.log),
        Side::Replayed => format!("{} through the controller", report.log),
    };
    let shown = match side {
        Side::Recorded => "Commands are those that went to motors and rudder.",
        Side::Replayed => {
            "Commands, bounds and surfaces are the controller's; the boat went where the log says."
        }
    };
    let subtitle = std::iter::once(shown.to_owned()).chain(report.notes.iter().cloned()).collect();
    let run = Run { title: title.clone(), subtitle, figures: report.figures(side), ..run.clone() };
    let mut files = vec![("track.svg", "the picture alone"), ("result.json", "the figures, for programs")];
    let mut contents = vec![
        ("track.svg", report::track_svg(&run)),
        ("result.json", serde_json::to_string_pretty(report).map_err(Failure::failed)?),
    ];
    if side == Side::Replayed {
        files.push((COMMANDS, "recorded and replayed commands over time"));
        contents.push((COMMANDS, report::curves_svg(&title, "recorded and replayed commands", panels)));
    }
    contents.push((PAGE, report::report_html(&run, &files)));
    write_files(folder, contents.iter().map(|(name, content)| (*name, content.as_bytes())))
}

/// Writes files into a folder, which is made where it is missing.
///
/// # Errors
/// A file cannot be written: which, and why.
pub(super) fn write_files<'a>(
    folder: &Path,
    files: impl Iterator<Item = (&'a str, &'a [u8])>,
) -> Result<(), Failure> {
    let fault = |path: &Path, error: std::io::Error| {
        Failure::failed(format!(
            "cannot write {}: {error}; choose another folder with --report",
            path.display()
        ))
    };
    fs::create_dir_all(folder).map_err(|error| fault(folder, error))?;
    for (name, content) in files {
        let path = folder.join(name);
        fs::write(&path, content).map_err(|error| fault(&path, error))?;
    }
    Ok(())
}
