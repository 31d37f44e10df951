//! `helmlink simulate`: a mission in simulation, as fast as the machine allows.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use helmlink_sitl::faults::TimedFault;

use super::cli::Common;
use super::console;
use super::failure::Failure;
use super::mission;
use super::ranges::RunS;
use super::result::{self, RunResult, Subject};
use super::scenario;
use super::trial::{self, TrialArgs};
use super::world::{World, WorldArgs};
use crate::control::Variant;
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
    /// The controller: pi-smc, pi-smc-paper, pid, ilos-pid, alos-pid or sign-smc; with parts of it left out or added as
    /// for `helmlink compare`
    #[arg(long, default_value = "pi-smc", value_name = "NAME")]
    pub controller: Variant,
    /// What differs from the model, such as mass*1.5, damping*0.5, actuators*0.5 or delay=0.5
    #[arg(long, default_value = "nominal", value_name = "WHAT")]
    pub perturbation: Perturbation,
    /// A named scenario (i, ii, iii, iv, iv-exact-gps) in place of sea, sensors and delay; or a scenario file
    /// as for `helmlink sitl`, whose expectations then decide the exit code
    #[arg(long, value_name = "NAME|FILE")]
    pub scenario: Option<String>,
    /// Something that fails, such as gps-loss@60..90 (repeatable; times in simulated seconds from the start)
    #[arg(long, value_name = "FAULT[@FROM[..UNTIL]]")]
    pub fault: Vec<TimedFault>,
    /// Folder for the report (track picture, result, log)
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Give up after this much simulated time, seconds
    #[arg(long, default_value = "14400", value_name = "S")]
    pub limit: RunS,
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
    let named: Option<Scenario> = args.scenario.as_deref().and_then(|name| name.parse().ok());
    let file = match (&args.scenario, named) {
        (Some(name), None) => Some(scenario::load_without_orders(name)?),
        _ => None,
    };
    let mut world_args = args.world.clone();
    if let Some(file) = &file {
        file.apply(&mut world_args);
    }
    let mut world = World::from_args(&world_args)?;
    let drivable = mission::load(&args.mission)?;
    let limit = Duration::from_secs_f64(*args.limit);
    let mut trial = args.trial.trial(args.controller.controller, &world, &drivable)?;
    if let Some(scenario) = named {
        trial::set_scenario(&mut trial, scenario);
        world.sea = trial.sea;
        world.sea_text = format!("scenario {}", scenario.as_str());
        world.sensors_text = "of the scenario".to_owned();
    }
    trial.boat.parts = args.controller.parts;
    args.perturbation.apply(&mut trial);
    let mut run = trial.closed_loop().map_err(Failure::usage)?;
    for fault in &args.fault {
        run.sitl_mut().schedule(*fault).map_err(Failure::usage)?;
    }
    if let Some(file) = &file {
        run.sitl_mut().play(file.scenario.clone()).map_err(Failure::usage)?;
    }
    if args.report.is_some() {
        run.keep_journal();
    }
    let started = Instant::now();
    let outcome = run.run(limit);
    let wall_s = started.elapsed().as_secs_f64();
    let subject =
        Subject::of(drivable.name.clone(), &world, args.controller.to_string(), args.trial.output.as_str());
    let result = RunResult::new(&subject, outcome, wall_s);
    run.sitl_mut().end_scenario();
    let verdicts = run.sitl().verdicts().to_vec();
    let judged = scenario::check(&verdicts);
    let (recorder, log) = run.into_recorder();
    if let Some(folder) = &args.report {
        result::write_report(folder, &result, &world, &drivable, recorder, &log)?;
        tracing::info!("report in {}", folder.display());
    }
    if args.common.json {
        let mut value: serde_json::Value = serde_json::from_str(&result.json()?).map_err(Failure::failed)?;
        if file.is_some() {
            value["expectations"] = scenario::json(&verdicts);
        }
        console::say(&serde_json::to_string_pretty(&value).map_err(Failure::failed)?);
    } else {
        console::say(&result.text());
        if file.is_some() {
            console::say(&scenario::text(&verdicts));
        }
    }
    if file.is_some() { judged } else { result.check() }
}
