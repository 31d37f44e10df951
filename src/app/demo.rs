//! `helmlink demo`: a boat drives a mission before the user's eyes.
//!
//! Three parties, each with its own socket: the simulated boat, a ground station that uploads the mission and
//! arms, and the bridge that drives. The user's own ground station can join them.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use helmlink_sitl::Sitl;

use super::cli::Common;
use super::console::{self, ProgressLine};
use super::edge::Edge;
use super::failure::Failure;
use super::ground_station::GroundStation;
use super::interrupt::interrupted;
use super::log_report::PAGE;
use super::mission::{self, Drivable};
use super::paced_sitl::{self, PacedSitl};
use super::ranges::{SpeedMps, Speedup};
use super::recorder::unix_time_us;
use super::result::{self, RunResult, Subject};
use super::sitl;
use super::trial::check_speed;
use super::world::{World, WorldArgs};
use crate::bridge::{Bridge, BridgeSettings, Status, TICK};
use crate::control::{Boat, Controller};
use crate::link::{Hub, LinkSettings, LinkUrl};
use crate::pilot::supervisor::State;
use crate::simulation::{Outcome, RunRecorder};
use crate::vehicle::OutputKind;

/// `helmlink demo`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Example:
  helmlink demo --sea moderate --speedup 4 --report my-report

While it runs, connect a ground station to the address it prints. The boat exists only in this program.")]
pub struct DemoArgs {
    /// The mission to drive; a harbour survey that comes with helmlink if not given
    #[arg(long, value_name = "FILE")]
    pub mission: Option<PathBuf>,
    /// Speed over ground, m/s; the mission's own, or the boat's cruising speed, if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<SpeedMps>,
    /// How many times faster than real time
    #[arg(long, default_value = "8", value_name = "N")]
    pub speedup: Speedup,
    /// Folder for the report
    #[arg(long, default_value = "helmlink-report", value_name = "DIR")]
    pub report: PathBuf,
    /// The address at which ground stations and the bridge find the boat; any free port if it is taken
    #[arg(long, default_value = "tcpin:127.0.0.1:5760", value_name = "URL")]
    pub listen: LinkUrl,
    /// By which messages the bridge steers
    #[arg(long, default_value = "rc-override", value_name = "rc-override|manual-control|guided")]
    pub output: OutputKind,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub world: WorldArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// Simulated time between two samples of the score.
const SAMPLE: Duration = Duration::from_millis(100);
/// Time between two updates of the progress line.
const PROGRESS: Duration = Duration::from_millis(250);
/// Preparing and finishing may take this long before something must be wrong.
const PREPARATION: Duration = Duration::from_secs(30);

pub(super) fn run(args: &DemoArgs) -> Result<(), Failure> {
    let world = World::from_args(&args.world)?;
    let drivable = match &args.mission {
        Some(path) => mission::load(path)?,
        None => mission::sample()?,
    };
    let boat = Boat::embedded(&world.hull.name).map_err(Failure::usage)?;
    check_speed(args.speed.map(f64::from), &boat)?;
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::failed)?;
    runtime.block_on(Demo::start(args, world, drivable, boat))
}

/// The three parties and what is watched of them.
struct Demo {
    boat: Edge<PacedSitl>,
    station: Edge<GroundStation>,
    bridge: Edge<Bridge>,
    recorder: RunRecorder,
    sampled: Duration,
    log: Vec<u8>,
}

impl Demo {
    async fn start(args: &DemoArgs, world: World, drivable: Drivable, boat: Boat) -> Result<(), Failure> {
        let home = sitl::home(&world, Some(&drivable.mission));
        let sitl = sitl::build(&world, home, sitl::first_target(home, &drivable.route), false)?;
        let (boat_edge, address) = listen(args, sitl).await?;
        tracing::info!("the boat listens at tcp:{address}: connect any ground station there to watch");
        let settings = BridgeSettings {
            output: args.output,
            speed_mps: args.speed.map(f64::from).or(Some(boat.limits.cruise_mps)),
            engage: true,
            ..BridgeSettings::new(boat)
        };
        let mut bridge = Bridge::new(settings);
        bridge.keep_journal(unix_time_us());
        let mut demo = Self {
            boat: boat_edge,
            station: connect(GroundStation::new(drivable.mission.clone(), *args.speedup), &address).await?,
            bridge: connect(bridge, &address).await?,
            recorder: RunRecorder::new(home),
            sampled: Duration::ZERO,
            log: Vec::new(),
        };
        let mut line = ProgressLine::new(&args.common);
        let ending = demo.drive(args, &mut line).await;
        line.clear();
        ending?;
        demo.finish(args, &world, drivable).await
    }

    /// Lets the three talk until the mission is complete.
    async fn drive(&mut self, args: &DemoArgs, line: &mut ProgressLine) -> Result<(), Failure> {
        let mut interrupt = std::pin::pin!(interrupted());
        let mut progress = tokio::time::interval(PROGRESS);
        loop {
            tokio::select! {
                () = &mut interrupt => return Err(Failure::failed("interrupted")),
                _ = self.boat.turn() => {}
                _ = self.station.turn() => {}
                _ = self.bridge.turn() => {}
                _ = progress.tick() => line.show(&progress_text(&self.bridge.party.status(), *args.speedup)),
            }
            self.watch(line);
            if let Some(failure) = self.station.party.failure() {
                return Err(Failure::failed(failure));
            }
            if !self.station.party.is_watching() && self.station.now() > PREPARATION {
                return Err(Failure::failed(
                    "the boat was not ready in time: see the messages above (-v shows more)",
                ));
            }
            match self.bridge.party.status().state {
                State::Finished => return Ok(()),
                State::Ready if self.was_driving() => {
                    return Err(Failure::failed(
                        "somebody else took over the boat: the demonstration is over",
                    ));
                }
                _ => {}
            }
        }
    }

    fn was_driving(&self) -> bool {
        self.bridge.party.status().steps > 0
    }

    /// Takes down what has happened since the last time.
    fn watch(&mut self, line: &mut ProgressLine) {
        let simulated = self.boat.party.sitl.now();
        while let Some(note) = self.station.party.poll_note() {
            line.clear();
            tracing::info!("{note}");
        }
        while let Some(event) = self.bridge.party.poll_event() {
            line.clear();
            self.recorder.on_event(simulated.as_secs_f64(), &event);
            console::log(&event);
        }
        if simulated >= self.sampled + SAMPLE {
            self.sampled = simulated;
            self.recorder.sample(simulated.as_secs_f64(), &self.boat.party.sitl, &self.bridge.party);
        }
        self.log.extend(self.bridge.party.take_journal());
    }

    /// Disarms, then reports.
    async fn finish(mut self, args: &DemoArgs, world: &World, drivable: Drivable) -> Result<(), Failure> {
        self.station.party.disarm();
        let deadline = self.station.now() + PREPARATION;
        while !self.station.party.is_done() && self.station.now() < deadline {
            tokio::select! {
                _ = self.boat.turn() => {}
                _ = self.station.turn() => {}
                _ = self.bridge.turn() => {}
            }
        }
        let simulated = self.boat.party.sitl.now();
        self.log.extend(self.bridge.party.finish_journal());
        let (commands_sha256, commands) = self.bridge.party.commands_digest();
        let outcome = Outcome {
            completed: true,
            simulated_s: simulated.as_secs_f64(),
            score: self.recorder.score(),
            commands_sha256,
            commands,
            complaint: None,
        };
        let subject =
            Subject::of(drivable.name.clone(), world, Controller::default().as_str(), args.output.as_str());
        let result = RunResult::new(&subject, outcome, self.boat.now().as_secs_f64());
        result::write_report(&args.report, &result, world, &drivable, self.recorder, &self.log)?;
        if args.common.json {
            let picture = args.report.join(result::PICTURE);
            console::say(&serde_json::json!({ "result": result, "picture": picture }).to_string());
        } else {
            let folder = args.report.display();
            console::say(&format!(
                "{}\n\nThe report is {folder}/{PAGE}, its picture {folder}/{}, the log {folder}/log.tlog.",
                result.text(),
                result::PICTURE
            ));
        }
        Ok(())
    }
}

/// Opens the boat's address, or another port where that one is taken.
async fn listen(args: &DemoArgs, sitl: Sitl) -> Result<(Edge<PacedSitl>, String), Failure> {
    let mut hub = Hub::new(LinkSettings::default());
    let endpoint = match hub.open(&args.listen).await {
        Ok(endpoint) => endpoint,
        Err(error) => {
            tracing::warn!("{error}; taking a free port instead");
            let any: LinkUrl = "tcpin:127.0.0.1:0".parse().map_err(Failure::failed)?;
            hub.open(&any).await.map_err(Failure::failed)?
        }
    };
    let address = hub.local_address(endpoint).ok_or_else(|| {
        Failure::usage("--listen must be an address to listen on, such as tcpin:127.0.0.1:5760")
    })?;
    let edge = Edge::new(PacedSitl::new(sitl, *args.speedup), hub, paced_sitl::tick(*args.speedup));
    Ok((edge, address.to_string()))
}

async fn connect<P: super::edge::Party>(party: P, address: &str) -> Result<Edge<P>, Failure> {
    let mut hub = Hub::new(LinkSettings::default());
    let url: LinkUrl = format!("tcpout:{address}").parse().map_err(Failure::failed)?;
    hub.open(&url).await.map_err(Failure::no_link)?;
    Ok(Edge::new(party, hub, TICK / 4))
}

fn progress_text(status: &Status, speedup: f64) -> String {
    let (State::Engaged, Some(progress)) = (status.state, status.progress) else {
        return status.state.to_string();
    };
    let left_s = progress.to_go_m / progress.wanted_speed_mps.max(0.1) / speedup;
    format!(
        "waypoint {}/{}   cross-track {:+.2} m   speed {:.2} m/s   {:.0} m to go   {:.0} s left",
        progress.next + 1,
        progress.total,
        progress.cross_track_m,
        progress.speed_mps,
        progress.to_go_m,
        left_s
    )
}
