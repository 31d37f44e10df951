//! `helmlink tune`: gains found by search in simulation.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::cli::Common;
use super::console;
use super::failure::Failure;
use super::mission::{self, Drivable};
use super::ranges::{Count, Threads};
use super::trial::{self, TrialArgs};
use super::world::{World, WorldArgs};
use crate::control::gains::{self, Gain};
use crate::control::{Boat, Controller};
use crate::simulation::tuning::{self, Found, Search, cost_m};
use crate::simulation::{Perturbation, Trial, parallel};

/// First step of the search: about this factor either way on every gain.
const FIRST_STEP: f64 = 0.25;

/// `helmlink tune`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink tune mission/plans/harbour-survey.waypoints --controllers pid --out pid.toml
  helmlink compare mission/plans/fossen-otter.waypoints --speed 1.38 --seed 101 --gains pid.toml

Every candidate drives the mission in every sea, with every perturbation and every training seed. Its cost is
the mean over all of them of the error against the smooth path (m, rms), plus 2 mm per metre of boat for every
unit of steering variation per minute. All controllers get the same budget, cost and seeds. Evaluate with
other seeds than these.")]
pub struct TuneArgs {
    /// The mission file (.waypoints or .plan)
    pub mission: PathBuf,
    /// Controllers to tune, comma separated
    #[arg(long, default_value = "pi-smc,pi-smc-paper,pid,ilos-pid,alos-pid,sign-smc", value_name = "LIST")]
    pub controllers: String,
    /// Candidates to try for each controller
    #[arg(long, default_value = "120", value_name = "N")]
    pub budget: Count,
    /// Named seas to train in, comma separated
    #[arg(long, default_value = "calm,moderate", value_name = "LIST")]
    pub seas: String,
    /// What differs from the model in training
    #[arg(long, default_value = "nominal,mass*1.5,delay=0.4", value_name = "LIST")]
    pub perturbations: String,
    /// How many training seeds; the first is --seed
    #[arg(long, default_value = "1", value_name = "N")]
    pub seeds: Count,
    /// Seed of the search itself
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub search_seed: u64,
    /// Threads; as many as the machine has, if not given. The result does not depend on it
    #[arg(long, value_name = "N")]
    pub threads: Option<Threads>,
    /// Write the gains into this file instead of standard output
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
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

/// How one controller was tuned.
#[derive(Debug, Serialize)]
struct Tuned {
    controller: &'static str,
    evaluations: usize,
    start_cost_m: f64,
    cost_m: f64,
    /// Evaluations made and the best cost then.
    history: Vec<(usize, f64)>,
    #[serde(skip)]
    boat: Boat,
}

pub(super) fn run(args: &TuneArgs) -> Result<(), Failure> {
    let drivable = mission::load(&args.mission)?;
    let controllers: Vec<Controller> = trial::list(&args.controllers)?;
    let cases = cases(args, &drivable)?;
    let mut tuned = Vec::new();
    for controller in controllers {
        tuned.push(tune(args, controller, &cases)?);
    }
    let text = gains_file(args, &drivable, &cases, &tuned);
    if let Some(path) = &args.out {
        trial::write(path, &text, "--out")?;
    }
    if args.common.json {
        console::say(&serde_json::to_string_pretty(&tuned).map_err(Failure::failed)?);
    } else if args.out.is_none() {
        console::say(text.trim_end());
    }
    Ok(())
}

/// Everything that a candidate is tried on.
fn cases(args: &TuneArgs, drivable: &Drivable) -> Result<Vec<Trial>, Failure> {
    let perturbations: Vec<Perturbation> = trial::list(&args.perturbations)?;
    let mut cases = Vec::new();
    for sea in args.seas.split(',') {
        let world = World::from_args(&WorldArgs { sea: sea.trim().to_owned(), ..args.world.clone() })?;
        let nominal = args.trial.trial(Controller::PiSmc, &world, drivable)?;
        for &perturbation in &perturbations {
            for seed in args.world.seed..args.world.seed + u64::from(*args.seeds) {
                let mut case = Trial { seed, ..nominal.clone() };
                perturbation.apply(&mut case);
                cases.push(case);
            }
        }
    }
    Ok(cases)
}

fn tune(args: &TuneArgs, controller: Controller, cases: &[Trial]) -> Result<Tuned, Failure> {
    let boat = cases[0].boat.clone();
    let gains: Vec<Gain> = controller.gains().into_iter().filter(|gain| gain.tuned).collect();
    let start = tuning::start(&boat, &gains);
    let mut search = Search::new(start.clone(), FIRST_STEP, args.search_seed);
    let threads = args.threads.map_or_else(parallel::available_threads, |threads| usize::from(*threads));
    let mut line = console::ProgressLine::new(&args.common);
    let budget = *args.budget as usize;
    let (mut evaluations, mut history, mut start_cost_m) = (0, Vec::new(), f64::INFINITY);
    while evaluations < budget {
        let mut candidates = search.ask();
        candidates.truncate(budget - evaluations);
        let costs = costs_m(controller, &boat, &gains, &start, &candidates, cases, threads)?;
        if evaluations == 0 {
            start_cost_m = costs[0];
        }
        evaluations += candidates.len();
        search.tell(candidates.into_iter().zip(costs).map(|(point, cost)| Found { point, cost }).collect());
        let best = search.best().map_or(f64::INFINITY, |found| found.cost);
        history.push((evaluations, best));
        line.show(&format!("{controller}: {evaluations}/{} tried, cost {best:.4} m", args.budget));
    }
    line.clear();
    let found = search.best().ok_or_else(|| Failure::failed("nothing was tried"))?;
    tracing::info!("{controller}: cost {start_cost_m:.4} m before, {:.4} m after", found.cost);
    let boat = tuning::with_gains(&boat, &gains, &start, &found.point)
        .ok_or_else(|| Failure::failed(format!("{controller}: no candidate could be used")))?;
    Ok(Tuned {
        controller: controller.as_str(),
        evaluations,
        start_cost_m,
        cost_m: found.cost,
        history,
        boat,
    })
}

/// Cost of every candidate; infinite where the boat does not allow its gains.
fn costs_m(
    controller: Controller,
    boat: &Boat,
    gains: &[Gain],
    start: &[f64],
    candidates: &[Vec<f64>],
    cases: &[Trial],
    threads: usize,
) -> Result<Vec<f64>, Failure> {
    let boats: Vec<Option<Boat>> =
        candidates.iter().map(|point| tuning::with_gains(boat, gains, start, point)).collect();
    let runs = parallel::map(
        candidates.len() * cases.len(),
        threads,
        |index| {
            let case = &cases[index % cases.len()];
            let Some(boat) = boats[index / cases.len()].clone() else { return Ok(f64::INFINITY) };
            let trial = Trial { boat, controller, ..case.clone() };
            trial.run().map(|outcome| cost_m(&trial, &outcome))
        },
        |_| {},
    );
    let runs = runs.into_iter().collect::<Result<Vec<f64>, _>>().map_err(Failure::usage)?;
    Ok(runs.chunks(cases.len()).map(|costs| costs.iter().sum::<f64>() / costs.len() as f64).collect())
}

fn gains_file(args: &TuneArgs, drivable: &Drivable, cases: &[Trial], tuned: &[Tuned]) -> String {
    let first = &cases[0];
    let mut text = format!("# Written by helmlink tune.\nboat = {:?}\n\n[tuning]\n", first.boat.name);
    text.push_str(&format!("mission = {:?}\nseas = {:?}\n", drivable.name, args.seas));
    text.push_str(&format!("perturbations = {:?}\n", args.perturbations));
    text.push_str(&format!("budget = {}\nfirst_seed = {}\n", args.budget, args.world.seed));
    text.push_str(&format!("seeds = {}\nsearch_seed = {}\n\n[history]\n", args.seeds, args.search_seed));
    text.push_str("# Candidates tried and the least cost (m) then.\n");
    for tuned in tuned {
        let points: Vec<String> =
            tuned.history.iter().map(|(tried, cost)| format!("[{tried}, {cost:.5}]")).collect();
        text.push_str(&format!("{} = [{}]\n", tuned.controller, points.join(", ")));
    }
    for (tuned, controller) in tuned.iter().filter_map(|t| t.controller.parse().ok().map(|c| (t, c))) {
        text.push_str(&format!("\n{}", gains::table(&tuned.boat, controller)));
    }
    text
}
