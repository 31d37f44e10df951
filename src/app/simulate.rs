//! `helmlink simulate`: a mission in simulation, as fast as the machine allows.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};

use super::cli::Common;
use super::console;
use super::failure::Failure;
use super::mission::{self, Drivable};
use super::result::{self, RunResult, Subject};
use super::sitl;
use super::world::{World, WorldArgs};
use crate::bridge::{Bridge, BridgeSettings};
use crate::control::Boat;
use crate::simulation::ClosedLoop;
use crate::vehicle::OutputKind;

/// `helmlink simulate`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Example:
  helmlink simulate mission/plans/fossen-otter.waypoints --boat otter --speed 1.38 \\
      --current 0.3@30 --sensors perfect --json")]
pub struct SimulateArgs {
    /// The mission file (.waypoints or .plan)
    pub mission: PathBuf,
    /// Speed over ground, m/s; the mission's own, or the boat's cruising speed, if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<f64>,
    /// The control law
    #[arg(long, value_enum, default_value_t = ControllerName::PiSmc)]
    pub controller: ControllerName,
    /// By which messages the bridge steers
    #[arg(long, default_value = "rc-override", value_name = "rc-override|manual-control|guided")]
    pub output: OutputKind,
    /// The control loop's rate, Hz
    #[arg(long, default_value_t = 25.0, value_name = "HZ")]
    pub rate: f64,
    /// Folder for the report (track picture, result, log)
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Give up after this much simulated time, seconds
    #[arg(long, default_value_t = 14_400.0, value_name = "S")]
    pub limit: f64,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub world: WorldArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// The control laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ControllerName {
    /// The adaptive PI sliding-mode controller with path-tangent guidance
    PiSmc,
}

impl ControllerName {
    /// The name as it is typed.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::PiSmc => "pi-smc",
        }
    }
}

pub(super) fn run(args: &SimulateArgs) -> Result<(), Failure> {
    let world = World::from_args(&args.world)?;
    let drivable = mission::load(&args.mission)?;
    let limit = Duration::try_from_secs_f64(args.limit)
        .map_err(|_| Failure::usage("--limit must be a positive number of seconds"))?;
    let mut run = closed_loop(args, &world, &drivable)?;
    let started = Instant::now();
    let outcome = run.run(limit);
    let wall_s = started.elapsed().as_secs_f64();
    let subject = Subject {
        mission: drivable.name,
        world: &world,
        controller: args.controller.as_str(),
        output: output_name(args.output),
    };
    let result = RunResult::new(&subject, outcome, wall_s);
    let (recorder, log) = run.into_recorder();
    if let Some(folder) = &args.report {
        result::write_report(folder, &result, &world, recorder, &log)?;
        tracing::info!("report in {}", folder.display());
    }
    console::say(&if args.common.json { result.json()? } else { result.text() });
    result.check()
}

/// The boat with the mission on board, and a bridge that may arm and drive it.
fn closed_loop(args: &SimulateArgs, world: &World, drivable: &Drivable) -> Result<ClosedLoop, Failure> {
    let ControllerName::PiSmc = args.controller;
    let boat = Boat::embedded(&world.hull.name).map_err(Failure::usage)?;
    check_speed(args.speed, &boat)?;
    if !(2.0..=50.0).contains(&args.rate) {
        return Err(Failure::usage(format!("--rate {}: choose 2 to 50 Hz", args.rate)));
    }
    let speed_mps = args.speed.or(Some(boat.limits.cruise_mps));
    let settings = BridgeSettings {
        output: args.output,
        speed_mps,
        control_interval_s: 1.0 / args.rate,
        engage: true,
        may_arm: true,
        ..BridgeSettings::new(boat)
    };
    let mut bridge = Bridge::new(settings);
    if args.report.is_some() {
        // Simulated time starts at the Unix epoch: the log must not depend on the day it was made.
        bridge.keep_journal(0);
    }
    let home = sitl::home(world, Some(&drivable.mission));
    let toward = sitl::first_target(home, &drivable.route);
    let mut simulated = sitl::build(world, home, toward, false)?;
    sitl::load(&mut simulated, &drivable.mission)?;
    Ok(ClosedLoop::new(simulated, bridge, home))
}

/// # Errors
/// A speed that the boat cannot run.
pub(super) fn check_speed(speed_mps: Option<f64>, boat: &Boat) -> Result<(), Failure> {
    let range = 0.1..=boat.limits.speed_max_mps;
    match speed_mps {
        Some(speed) if !range.contains(&speed) => Err(Failure::usage(format!(
            "--speed {speed}: boat {} can be asked for {} to {} m/s",
            boat.name,
            range.start(),
            range.end()
        ))),
        _ => Ok(()),
    }
}

pub(super) fn output_name(output: OutputKind) -> &'static str {
    output.name()
}
