//! `helmlink replay --drive`: the recorded track, driven again in the simulator or on a boat.

use std::time::Instant;

use clap::Parser;
use helmlink_mission::route::Route;
use helmlink_mission::track::{Fix, TrackSettings, mission_of_track};

use super::engine::Engine;
use super::what_if::wishes;
use super::{LogFiles, ReplayArgs};
use crate::app::bridge::{self, BridgeArgs};
use crate::app::console;
use crate::app::failure::Failure;
use crate::app::mission::{self, Drivable, VehicleArgs};
use crate::app::result::{self, RunResult, Subject};
use crate::app::sitl;
use crate::app::world::{World, WorldArgs};
use crate::link::LinkUrl;
use crate::replay::picture::Side;
use crate::replay::what_if::{Moment, Sink, WhatIfSettings, Window};
use crate::simulation::Trial;

/// The bridge as it is where nothing is said.
#[derive(Debug, Parser)]
struct Driving {
    #[command(flatten)]
    bridge: BridgeArgs,
}

/// Standing still at least so long becomes a hold, seconds.
const STOP_S: f64 = 10.0;

/// The simulated world as it is where nothing is said.
#[derive(Debug, Parser)]
struct Defaults {
    #[command(flatten)]
    world: WorldArgs,
}

pub(super) fn run(args: &ReplayArgs, files: &LogFiles) -> Result<(), Failure> {
    let mut engine = Engine::scan(files.clone(), args.system.map(u8::from))?;
    let settings = engine.settings(&wishes(args), Window::Any)?;
    let mut track = Track::default();
    engine.run(settings.clone(), Side::Recorded, &mut [&mut track])?;
    let track_settings = TrackSettings { tolerance_m: *args.tolerance, stop_s: Some(STOP_S) };
    let made = mission_of_track(&track.0, &track_settings)
        .ok_or_else(|| Failure::failed(format!("{} shows no boat that moves", files.shown())))?;
    let route = Route::from_mission(&made.mission).map_err(Failure::failed)?;
    let what = format!(
        "{:.0} m again: {} items, nothing of the track is farther than {:.2} m from them",
        made.length_m,
        made.mission.items.len(),
        made.deviation_m
    );
    let drivable = Drivable {
        name: format!("{}, driven again", files.name()),
        mission: made.mission,
        route,
        fence: engine.scan.fence.clone(),
        rally: engine.scan.rally.clone(),
    };
    match &args.to {
        Some(url) => on_a_boat(args, url, &settings, &drivable, &what),
        None => {
            tracing::info!("driving {what}");
            in_the_simulator(args, settings, drivable)
        }
    }
}

/// Stores the mission on the flight controller, then drives it as `helmlink bridge` does.
fn on_a_boat(
    args: &ReplayArgs,
    url: &LinkUrl,
    settings: &WhatIfSettings,
    drivable: &Drivable,
    what: &str,
) -> Result<(), Failure> {
    if !args.yes_send {
        let when = if args.arm { "at once" } else { "as soon as it is armed" };
        return Err(Failure::usage(format!(
            "this would replace the mission of the boat at {url} and drive it {when}: {what}; if that is what you want, \
             and the water there is clear, add --yes-send"
        )));
    }
    let vehicle = VehicleArgs { connect: url.clone(), wait: args.wait };
    mission::send_mission(&vehicle, &args.common, &drivable.mission)?;
    tracing::info!("on board and compared: {} items; driving {what}", drivable.mission.items.len());
    let (url, wait, gcs) =
        (url.to_string(), args.wait.to_string(), settings.ground_station_system.to_string());
    let mut arguments = vec!["replay", "--connect", &url, "--wait", &wait, "--gcs-system", &gcs];
    arguments.extend(["--output", settings.output.as_str(), "--engage", "--once"]);
    if args.arm {
        arguments.push("--arm");
    } else {
        tracing::info!("arm the boat when it may drive; Ctrl-C lets go of it");
    }
    let mut driving = Driving::try_parse_from(arguments).map_err(Failure::failed)?.bridge;
    driving.common = args.common.clone();
    // The boat itself: by its name alone, the gains of a file or of the recording would be lost.
    bridge::run_for(&driving, settings.boat.clone())
}

fn in_the_simulator(args: &ReplayArgs, settings: WhatIfSettings, drivable: Drivable) -> Result<(), Failure> {
    let hull = settings.boat.name.clone();
    let defaults = Defaults::try_parse_from(["replay", "--boat", &hull]).map_err(Failure::failed)?;
    let world = World::from_args(&defaults.world).map_err(|error| {
        Failure::usage(format!(
            "{error}; --drive needs a boat that the simulator has: choose one with --boat"
        ))
    })?;
    let home = sitl::home(&world, Some(&drivable.mission));
    let toward = sitl::first_target(home, &drivable.route);
    let trial = Trial {
        boat: settings.boat,
        controller: settings.controller,
        output: settings.output,
        speed_mps: settings.speed_mps,
        interval_s: 0.04,
        hull: world.hull.clone(),
        sea: world.sea,
        sensors: world.sensors,
        seed: world.seed,
        delay_s: 0.0,
        mission: drivable.mission.clone(),
        route: drivable.route.clone(),
        home,
        heading_rad: sitl::heading_rad(&world, home, toward),
    };
    let mut run = trial.closed_loop().map_err(Failure::usage)?;
    run.keep_journal();
    let started = Instant::now();
    let outcome = run.run(trial.limit());
    let wall_s = started.elapsed().as_secs_f64();
    let subject =
        Subject::of(drivable.name.clone(), &world, trial.controller.as_str(), trial.output.as_str());
    let result = RunResult::new(&subject, outcome, wall_s);
    let (recorder, log) = run.into_recorder();
    if !args.no_report {
        result::write_report(&args.report, &result, &world, &drivable, recorder, &log)?;
        tracing::info!("report in {}", args.report.display());
    }
    console::say(&if args.common.json { result.json()? } else { result.text() });
    result.check()
}

/// Where the boat was.
#[derive(Default)]
struct Track(Vec<Fix>);

impl Sink for Track {
    fn moment(&mut self, moment: &Moment) {
        let speed_mps = moment.state.surge_mps.hypot(moment.state.sway_mps);
        self.0.push(Fix { time_s: moment.time_s, position: moment.place, speed_mps });
    }

    fn command(&mut self, _time_us: u64, _frame: &[u8]) {}

    fn event(&mut self, _time_s: f64, _text: &str) {}
}
