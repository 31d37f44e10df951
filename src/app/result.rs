//! The result of a run: JSON for programs, a few lines for people, a folder to keep.

use std::fs;
use std::path::Path;

use serde::Serialize;

use super::failure::Failure;
use super::log_report::PAGE;
use super::mission::Drivable;
use super::world::World;
use crate::report::{self, Run};
use crate::simulation::score::{Score, Spread};
use crate::simulation::{Outcome, RunRecorder};

/// One run, as `--json` prints it.
#[derive(Debug, Clone, Serialize)]
pub(super) struct RunResult {
    mission: String,
    boat: String,
    controller: String,
    output: &'static str,
    sea: String,
    sensors: String,
    seed: u64,
    pub(super) completed: bool,
    pub(super) simulated_s: f64,
    #[serde(flatten)]
    score: Option<Score>,
    realtime_factor: f64,
    commands: u64,
    commands_sha256: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    complaint: Option<String>,
}

/// What was run, for the result.
pub(super) struct Subject<'a> {
    pub(super) mission: String,
    pub(super) boat: &'a str,
    pub(super) sea: &'a str,
    pub(super) sensors: &'a str,
    pub(super) seed: u64,
    pub(super) controller: String,
    pub(super) output: &'static str,
}

impl<'a> Subject<'a> {
    /// A run in this world.
    pub(super) fn of(
        mission: String,
        world: &'a World,
        controller: impl Into<String>,
        output: &'static str,
    ) -> Self {
        Self {
            mission,
            boat: &world.hull.name,
            sea: &world.sea_text,
            sensors: &world.sensors_text,
            seed: world.seed,
            controller: controller.into(),
            output,
        }
    }
}

impl RunResult {
    pub(super) fn new(subject: &Subject<'_>, outcome: Outcome, wall_s: f64) -> Self {
        Self {
            mission: subject.mission.clone(),
            boat: subject.boat.to_owned(),
            controller: subject.controller.clone(),
            output: subject.output,
            sea: subject.sea.to_owned(),
            sensors: subject.sensors.to_owned(),
            seed: subject.seed,
            completed: outcome.completed,
            simulated_s: outcome.simulated_s,
            score: outcome.score,
            realtime_factor: outcome.simulated_s / wall_s.max(1e-9),
            commands: outcome.commands,
            commands_sha256: outcome.commands_sha256,
            complaint: outcome.complaint,
        }
    }

    /// The figures; none when the first waypoint was never reached.
    pub(super) fn score(&self) -> Option<&Score> {
        self.score.as_ref()
    }

    /// One line of a table of runs, in the order of [`super::compare`]'s heading.
    pub(super) fn csv_line(&self, perturbation: &str) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let names = [&self.mission, &self.boat, &self.controller, &self.sea, &self.sensors, perturbation]
            .map(quoted)
            .join(",");
        let rms = |spread: Option<Spread>| spread.map_or(String::new(), |spread| spread.rms.to_string());
        let figures = self.score.as_ref().map_or(",".repeat(12), |score| {
            [
                score.duration_s.to_string(),
                score.distance_m.to_string(),
                rms(score.cross_track_m),
                rms(score.cross_track_settled_m),
                rms(score.cross_track_straight_m),
                rms(score.path_error_m),
                score.path_error_m.map_or(String::new(), |spread| spread.max.to_string()),
                rms(score.path_error_straight_m),
                rms(score.navigation_error_m),
                score.speed_error_mps.rms.to_string(),
                score.steering_variation_per_min.to_string(),
                score.effort.to_string(),
                String::new(),
            ]
            .join(",")
        });
        format!("{names},{},{},{figures}{}\n", self.seed, self.completed, self.commands_sha256)
    }

    /// The mission was driven to its end.
    ///
    /// # Errors
    /// It was not: why, as far as is known.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if self.completed {
            return Ok(());
        }
        let why = self.complaint.as_deref().unwrap_or("the time limit was reached (see --limit)");
        Err(Failure::failed(format!("the mission was not completed: {why}")))
    }

    /// One JSON object.
    pub(super) fn json(&self) -> Result<String, Failure> {
        serde_json::to_string_pretty(self).map_err(Failure::failed)
    }

    /// Label and value of each figure.
    pub(super) fn figures(&self) -> Vec<(String, String)> {
        let mut rows = vec![
            ("mission".to_owned(), self.mission.clone()),
            ("boat, controller".to_owned(), format!("{}, {}", self.boat, self.controller)),
            ("sea, sensors".to_owned(), format!("{}; {}", self.sea, self.sensors)),
            ("completed".to_owned(), if self.completed { "yes" } else { "no" }.to_owned()),
        ];
        if let Some(score) = &self.score {
            let spread = |spread: &Option<Spread>| match spread {
                Some(spread) => format!("{:.3} m rms, {:.3} m max", spread.rms, spread.max),
                None => "no samples".to_owned(),
            };
            let distance = format!("{:.0} m in {:.0} s", score.distance_m, score.duration_s);
            rows.push(("distance".to_owned(), distance));
            rows.push(("cross-track, whole".to_owned(), spread(&score.cross_track_m)));
            rows.push(("cross-track, straight".to_owned(), spread(&score.cross_track_straight_m)));
            rows.push(("cross-track, settled".to_owned(), spread(&score.cross_track_settled_m)));
            rows.push(("off the smooth path".to_owned(), spread(&score.path_error_m)));
            rows.push(("  where it is straight".to_owned(), spread(&score.path_error_straight_m)));
            rows.push(("navigation error, across".to_owned(), spread(&score.navigation_error_m)));
            rows.push((
                "steering variation".to_owned(),
                format!("{:.2} per minute", score.steering_variation_per_min),
            ));
        }
        rows.push(("speed of simulation".to_owned(), format!("{:.0} × real time", self.realtime_factor)));
        rows
    }

    /// The figures as lines of text.
    pub(super) fn text(&self) -> String {
        let width = self.figures().iter().map(|(label, _)| label.chars().count()).max().unwrap_or(0);
        let lines: Vec<String> =
            self.figures().into_iter().map(|(label, value)| format!("  {label:<width$}  {value}")).collect();
        lines.join("\n")
    }
}

/// Name of the picture in a report folder.
pub(super) const PICTURE: &str = "track.svg";

/// What lies beside the page.
const FILES: [(&str, &str); 3] = [
    (PICTURE, "the picture alone"),
    ("result.json", "the figures, for programs"),
    ("log.tlog", "everything sent and received: try helmlink replay log.tlog --proof"),
];

/// Writes page, picture, result and log into `folder`.
///
/// # Errors
/// A file cannot be written: which, and why.
pub(super) fn write_report(
    folder: &Path,
    result: &RunResult,
    world: &World,
    drivable: &Drivable,
    recorder: RunRecorder,
    log: &[u8],
) -> Result<(), Failure> {
    let at = |name: &str| folder.join(name);
    let fault = |path: &Path, error: std::io::Error| {
        Failure::failed(format!(
            "cannot write {}: {error}; choose another folder with --report",
            path.display()
        ))
    };
    fs::create_dir_all(folder).map_err(|error| fault(folder, error))?;
    let run = drivable.chart(picture(result, world, recorder));
    for (name, content) in [
        (PICTURE, report::track_svg(&run).into_bytes()),
        (PAGE, report::report_html(&run, &FILES).into_bytes()),
        ("result.json", result.json()?.into_bytes()),
        ("log.tlog", log.to_vec()),
    ] {
        fs::write(at(name), content).map_err(|error| fault(&at(name), error))?;
    }
    Ok(())
}

fn picture(result: &RunResult, world: &World, recorder: RunRecorder) -> Run {
    let current = world.sea.current.map(|current| {
        helmlink_mission::geodesy::NorthEast::from_polar(current.speed_mps, current.toward_deg.to_radians())
    });
    Run {
        title: format!("{} drives {}", result.boat, result.mission),
        subtitle: vec![format!("{}, sea: {}, sensors: {}", result.controller, result.sea, result.sensors)],
        figures: result.figures(),
        current,
        ..recorder.into_run()
    }
}
