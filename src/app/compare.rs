//! `helmlink compare`: controllers on the same missions in the same seas.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::cli::Common;
use super::console;
use super::failure::Failure;
use super::mission;
use super::ranges::{Count, Threads};
use super::result::{RunResult, Subject};
use super::trial::{self, TrialArgs};
use super::world::{World, WorldArgs};
use crate::control::{Controller, Variant};
use crate::report::{self, ComparedTrack};
use crate::simulation::comparison::{Cell, Metric, Verdict, cells, verdict};
use crate::simulation::{Outcome, Perturbation, Scenario, Trial, parallel};

/// `helmlink compare`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink compare mission/plans/fossen-otter.waypoints --speed 1.38
  helmlink compare mission/plans/fossen-otter.waypoints --perturbations grid --csv runs.csv --svg tracks.svg
  helmlink compare mission/plans/arcs-otter.waypoints --speed 1.5 --turn-radius 13 --scenarios i,ii,iii,iv

  helmlink compare mission/plans/fossen-otter.waypoints --speed 1.38 --seas calm --sensors perfect --seeds 1 \
      --currents 0,0.3,0.5 --perturbations nominal,mass*0.5,mass*1.5 --controllers pi-smc --metric settled
  helmlink compare mission/plans/arcs-otter.waypoints --scenarios iv --controllers pi-smc,pi-smc-predictor,pid+observer

Parts can be taken from a controller or given to it: - or + and observer, predictor, current (its estimate),
feed-forward or adaptation, behind its name. That shows what they are worth.

Every controller meets the same seas: run n of each has the same seed. The mark in front of a row says how the
first controller of the list does there: + strictly better than every other one (95 % confidence, paired by
seed), = no worse than any, - worse than at least one. A run that does not complete its mission counts
with at least five lengths of the boat.")]
pub struct CompareArgs {
    /// The mission file (.waypoints or .plan)
    pub mission: PathBuf,
    /// Controllers, comma separated; the first one is judged against the others. With parts left out or added, such
    /// as pi-smc-predictor or pid+observer
    #[arg(long, default_value = "pi-smc,pi-smc-paper,pid,ilos-pid,alos-pid,sign-smc", value_name = "LIST")]
    pub controllers: String,
    /// Named seas, comma separated; takes the place of --sea
    #[arg(long, default_value = "calm,moderate", value_name = "LIST")]
    pub seas: String,
    /// Steady currents, comma separated, each in every sea: SPEED@TOWARD (m/s, degrees), or SPEED alone for all of
    /// eight directions; takes the place of --current
    #[arg(long, value_name = "LIST", conflicts_with = "scenarios")]
    pub currents: Option<String>,
    /// Named scenarios (i, ii, iii, iv, iv-exact-gps), comma separated: take the place of seas, sensors and delay
    #[arg(long, value_name = "LIST")]
    pub scenarios: Option<String>,
    /// What differs from the model: nominal, grid (all), or a list such as mass*1.5,delay=0.5,rate=5
    #[arg(long, default_value = "nominal", value_name = "LIST")]
    pub perturbations: String,
    /// How many seeds
    #[arg(long, default_value = "10", value_name = "N")]
    pub seeds: Count,
    /// What is compared: the error against the legs (whole, settled, straight) or against the smooth path (path,
    /// path-straight), or how far the flight controller's own position is off, across the path (navigation)
    #[arg(long, default_value = "path", value_name = "METRIC")]
    pub metric: Metric,
    /// Threads; as many as the machine has, if not given. The result does not depend on it
    #[arg(long, value_name = "N")]
    pub threads: Option<Threads>,
    /// Write every run as a row of this file
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw the tracks and errors of the first cell's first seed into this file
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub trial: TrialArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub world: WorldArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// What `compare --json` prints.
#[derive(Debug, Serialize)]
struct Comparison<'a> {
    metric: Metric,
    seeds: u64,
    verdict: Verdict,
    cells: &'a [Cell],
    runs: Vec<Row<'a>>,
}

/// One run of the comparison.
#[derive(Debug, Serialize)]
struct Row<'a> {
    perturbation: String,
    #[serde(flatten)]
    result: &'a RunResult,
}

/// A run to be made, and what it is called.
struct Entry {
    trial: Trial,
    sea: String,
    sensors: String,
    controller: String,
    perturbation: Perturbation,
}

pub(super) fn run(args: &CompareArgs) -> Result<(), Failure> {
    let drivable = mission::load(&args.mission)?;
    let entries = entries(args)?;
    let threads = args.threads.map_or_else(parallel::available_threads, |threads| usize::from(*threads));
    let mut line = console::ProgressLine::new(&args.common);
    let started = Instant::now();
    let outcomes = parallel::map(
        entries.len(),
        threads,
        |index| {
            let begun = Instant::now();
            (entries[index].trial.run(), begun.elapsed().as_secs_f64())
        },
        |done| line.show(&progress(done, entries.len(), started)),
    );
    line.clear();
    let wall_s = started.elapsed().as_secs_f64();
    let mut results = Vec::with_capacity(entries.len());
    for (entry, (outcome, run_s)) in entries.iter().zip(outcomes) {
        let outcome: Outcome = outcome.map_err(Failure::usage)?;
        results.push(RunResult::new(&subject(entry, &drivable.name, args), outcome, run_s));
    }
    let simulated_s: f64 = results.iter().map(|result| result.simulated_s).sum();
    tracing::info!(
        "{} missions, {:.0} s of simulated time in {wall_s:.1} s: {:.0} × real time on {threads} threads",
        results.len(),
        simulated_s,
        simulated_s / wall_s.max(1e-9)
    );
    let cells = summarise(args, &entries, &results);
    let rows = || entries.iter().zip(&results).map(|(entry, result)| row(entry, result));
    if let Some(path) = &args.csv {
        trial::write(path, &csv(rows()), "--csv")?;
    }
    if let Some(path) = &args.svg {
        trial::write(path, &picture(args, &entries, &drivable.name)?, "--svg")?;
    }
    let verdict = verdict(&cells);
    let text = if args.common.json {
        let comparison = Comparison {
            metric: args.metric,
            seeds: (*args.seeds).into(),
            verdict,
            cells: &cells,
            runs: rows().collect(),
        };
        serde_json::to_string_pretty(&comparison).map_err(Failure::failed)?
    } else {
        table(args.metric, &cells, &verdict)
    };
    console::say(&text);
    Ok(())
}

/// Every run, in the order condition, perturbation, controller, seed.
fn entries(args: &CompareArgs) -> Result<Vec<Entry>, Failure> {
    let controllers: Vec<Variant> = trial::list(&args.controllers)?;
    let perturbations: Vec<Perturbation> = match args.perturbations.as_str() {
        "grid" => Perturbation::GRID.to_vec(),
        text => trial::list(text)?,
    };
    let mut entries = Vec::new();
    for (nominal, sea, sensors) in conditions(args)? {
        for &perturbation in &perturbations {
            for variant in &controllers {
                for seed in args.world.seed..args.world.seed + u64::from(*args.seeds) {
                    let mut trial = Trial { controller: variant.controller, seed, ..nominal.clone() };
                    trial.boat.parts = variant.parts;
                    perturbation.apply(&mut trial);
                    let (sea, sensors, controller) = (sea.clone(), sensors.clone(), variant.to_string());
                    entries.push(Entry { trial, sea, sensors, controller, perturbation });
                }
            }
        }
    }
    Ok(entries)
}

/// The seas or scenarios, each as an unperturbed trial with its names.
fn conditions(args: &CompareArgs) -> Result<Vec<(Trial, String, String)>, Failure> {
    let drivable = mission::load(&args.mission)?;
    if let Some(scenarios) = &args.scenarios {
        let world = World::from_args(&args.world)?;
        let nominal = args.trial.trial(Controller::PiSmc, &world, &drivable)?;
        let scenarios: Vec<Scenario> = trial::list(scenarios)?;
        return Ok(scenarios
            .into_iter()
            .map(|scenario| {
                let mut nominal = nominal.clone();
                trial::set_scenario(&mut nominal, scenario);
                (nominal, format!("scenario {}", scenario.as_str()), "of the scenario".to_owned())
            })
            .collect());
    }
    let currents = args.currents.as_deref().map_or(vec![args.world.current.clone()], currents);
    let mut conditions = Vec::new();
    for sea in args.seas.split(',') {
        for current in &currents {
            let (sea, current) = (sea.trim().to_owned(), current.clone());
            let world = World::from_args(&WorldArgs { sea, current, ..args.world.clone() })?;
            let nominal = args.trial.trial(Controller::PiSmc, &world, &drivable)?;
            conditions.push((nominal, world.sea_text, world.sensors_text));
        }
    }
    Ok(conditions)
}

/// The currents of a list; a speed alone stands for that speed toward each of eight directions.
fn currents(text: &str) -> Vec<Option<String>> {
    const DIRECTIONS: usize = 8;
    let every_way = |speed: &str| -> Vec<Option<String>> {
        let turn_deg = 360 / DIRECTIONS;
        (0..DIRECTIONS).map(|number| Some(format!("{speed}@{}", number * turn_deg))).collect()
    };
    text.split(',')
        .map(str::trim)
        .flat_map(|item| match item.parse::<f64>() {
            Ok(0.0) => vec![None],
            Ok(_) => every_way(item),
            Err(_) => vec![Some(item.to_owned())],
        })
        .collect()
}

fn subject<'a>(entry: &'a Entry, mission: &str, args: &CompareArgs) -> Subject<'a> {
    Subject {
        mission: mission.to_owned(),
        boat: &entry.trial.hull.name,
        sea: &entry.sea,
        sensors: &entry.sensors,
        seed: entry.trial.seed,
        controller: entry.controller.clone(),
        output: args.trial.output.as_str(),
    }
}

fn row<'a>(entry: &Entry, result: &'a RunResult) -> Row<'a> {
    Row { perturbation: entry.perturbation.to_string(), result }
}

fn progress(done: usize, total: usize, started: Instant) -> String {
    const WIDTH: usize = 30;
    let filled = done * WIDTH / total.max(1);
    let left_s = started.elapsed().as_secs_f64() * (total - done) as f64 / done.max(1) as f64;
    format!("[{}{}] {done}/{total}, {left_s:.0} s to go", "#".repeat(filled), ".".repeat(WIDTH - filled))
}

fn summarise(args: &CompareArgs, entries: &[Entry], results: &[RunResult]) -> Vec<Cell> {
    let per_controller = *args.seeds as usize;
    let controllers = args.controllers.split(',').count();
    entries
        .chunks(per_controller * controllers)
        .zip(results.chunks(per_controller * controllers))
        .map(|(entries, results)| {
            let first = &entries[0];
            let failed_m = 5.0 * first.trial.hull.length_m;
            let runs: Vec<(String, Vec<&RunResult>)> = entries
                .chunks(per_controller)
                .zip(results.chunks(per_controller))
                .map(|(entries, results)| (entries[0].controller.clone(), results.iter().collect()))
                .collect();
            let figures = runs.into_iter().map(|(controller, results)| {
                let errors = results
                    .iter()
                    .map(|result| args.metric.of(result.score(), result.completed, failed_m))
                    .collect();
                let steering = results
                    .iter()
                    .map(|result| result.score().map_or(0.0, |score| score.steering_variation_per_min))
                    .collect();
                let completed = results.iter().filter(|result| result.completed).count();
                cells::Column { controller, errors, steering, completed }
            });
            Cell::new(first.sea.clone(), first.perturbation.to_string(), figures.collect())
        })
        .collect()
}

fn table(metric: Metric, cells: &[Cell], verdict: &Verdict) -> String {
    let mut lines = Vec::new();
    let names: Vec<&str> =
        cells.first().map_or(Vec::new(), |cell| cell.columns.iter().map(|c| c.controller.as_str()).collect());
    let width = cells.iter().map(|cell| cell.name().chars().count()).max().unwrap_or(0).max(12);
    let column = names.iter().map(|name| name.len()).max().unwrap_or(0).max(16);
    let head = |title: &str| {
        let mut line = format!("  {title:<width$}");
        for name in &names {
            line.push_str(&format!("  {name:>column$}"));
        }
        line
    };
    lines.push(head(&format!("{metric}, m rms")));
    for cell in cells {
        let mut line = format!("{} {:<width$}", cell.mark(), cell.name());
        for figures in &cell.columns {
            let missing = if figures.completed == figures.runs { ' ' } else { '!' };
            let text = format!("{:.3} ± {:.3}{missing}", figures.error_m.mean, figures.error_m.half_width);
            line.push_str(&format!("  {text:>column$}"));
        }
        lines.push(line);
    }
    lines.push(String::new());
    lines.push(head("steering per min"));
    for cell in cells {
        let mut line = format!("  {:<width$}", cell.name());
        for figures in &cell.columns {
            line.push_str(&format!("  {:>column$.1}", figures.steering_per_min.mean));
        }
        lines.push(line);
    }
    lines.push(String::new());
    lines.extend(verdict.lines());
    lines.join("\n")
}

const CSV_HEAD: &str = "mission,boat,controller,sea,sensors,perturbation,seed,completed,duration_s,distance_m,\
    cross_track_rms_m,cross_track_settled_rms_m,cross_track_straight_rms_m,path_error_rms_m,path_error_max_m,\
    path_error_straight_rms_m,navigation_error_rms_m,speed_error_rms_mps,steering_variation_per_min,effort,commands_sha256\n";

fn csv<'a>(rows: impl Iterator<Item = Row<'a>>) -> String {
    let mut text = CSV_HEAD.to_owned();
    for Row { perturbation, result } in rows {
        text.push_str(&result.csv_line(&perturbation));
    }
    text
}

/// The tracks of all controllers in the first cell with its first seed.
fn picture(args: &CompareArgs, entries: &[Entry], mission: &str) -> Result<String, Failure> {
    let first = &entries[0];
    let per_controller = *args.seeds as usize;
    let controllers = args.controllers.split(',').count();
    let mut tracks = Vec::new();
    let mut ground = report::Run::default();
    for entry in entries.iter().step_by(per_controller).take(controllers) {
        let mut run = entry.trial.closed_loop().map_err(Failure::usage)?;
        run.run(entry.trial.limit());
        let (recorder, _) = run.into_recorder();
        let run = recorder.into_run();
        tracks.push(ComparedTrack { name: entry.controller.clone(), track: run.track.clone() });
        if ground.mission.is_empty() {
            ground = run;
        }
    }
    ground.title = format!("{} drives {mission}", first.trial.hull.name);
    ground.subtitle = vec![format!(
        "sea: {}, sensors: {}, {}, seed {}",
        first.sea, first.sensors, first.perturbation, first.trial.seed
    )];
    Ok(report::comparison_svg(&ground, &tracks))
}
