//! `helmlink simulate`: a mission in simulation, as fast as the machine allows.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;

use super::cli::Common;
use super::console;
use super::failure::Failure;
use super::mission;
use super::result::{self, RunResult, Subject};
use super::trial::{self, TrialArgs};
use super::world::{World, WorldArgs};
use crate::control::Controller;
use crate::simulation::{Perturbation, Scenario};

/// `helmlink simulate`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Example:
  helmlink simulate mission/plans/fossen-otter.waypoints --boat otter --speed 1.38 \\
      --current 0.3@30 --sensors perfect --json")]
pub struct SimulateArgs {
    /// The mission file (.waypoints or .plan)
    pub mission: PathBuf,
    /// The controller: pi-smc, pi-smc-paper, pid, ilos-pid, alos-pid or sign-smc
    #[arg(long, default_value = "pi-smc", value_name = "NAME")]
    pub controller: Controller,
    /// What differs from the model, such as mass*1.5, damping*0.5, actuators*0.5 or delay=0.5
    #[arg(long, default_value = "nominal", value_name = "WHAT")]
    pub perturbation: Perturbation,
    /// A named scenario (i, ii, iii, iv, iv-exact-gps) in place of sea, sensors and delay
    #[arg(long, value_name = "NAME")]
    pub scenario: Option<Scenario>,
    /// Folder for the report (track picture, result, log)
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Give up after this much simulated time, seconds
    #[arg(long, default_value_t = 14_400.0, value_name = "S")]
    pub limit: f64,
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

pub(super) fn run(args: &SimulateArgs) -> Result<(), Failure> {
    let mut world = World::from_args(&args.world)?;
    let drivable = mission::load(&args.mission)?;
    let limit = Duration::try_from_secs_f64(args.limit)
        .map_err(|_| Failure::usage("--limit must be a positive number of seconds"))?;
    let mut trial = args.trial.trial(args.controller, &world, &drivable)?;
    if let Some(scenario) = args.scenario {
        trial::set_scenario(&mut trial, scenario);
        world.sea = trial.sea;
        world.sea_text = format!("scenario {}", scenario.as_str());
        world.sensors_text = "of the scenario".to_owned();
    }
    args.perturbation.apply(&mut trial);
    let mut run = trial.closed_loop().map_err(Failure::usage)?;
    if args.report.is_some() {
        run.keep_journal();
    }
    let started = Instant::now();
    let outcome = run.run(limit);
    let wall_s = started.elapsed().as_secs_f64();
    let subject = Subject::of(drivable.name, &world, args.controller.as_str(), args.trial.output.as_str());
    let result = RunResult::new(&subject, outcome, wall_s);
    let (recorder, log) = run.into_recorder();
    if let Some(folder) = &args.report {
        result::write_report(folder, &result, &world, recorder, &log)?;
        tracing::info!("report in {}", folder.display());
    }
    console::say(&if args.common.json { result.json()? } else { result.text() });
    result.check()
}
