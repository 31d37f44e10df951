//! `helmlink sitl`: the simulated boat alone.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use helmlink_mission::geodesy::{Geodetic, LocalFrame};
use helmlink_mission::plan::Mission;
use helmlink_mission::route::Route;
use helmlink_sitl::faults::TimedFault;
use helmlink_sitl::{AutopilotSettings, Sitl, SitlSettings, StartUp};
use helmlink_wire::signing::{SigningKey, Timestamp};

use super::ardupilot_json;
use super::cli::Common;
use super::console;
use super::edge::{Edge, Seen};
use super::failure::Failure;
use super::interrupt::interrupted;
use super::mission;
use super::paced_sitl::{self, PacedSitl};
use super::parameter_file::{self, ParameterFile};
use super::ranges::{Pace, RunS};
use super::recorder::RecordArgs;
use super::scenario::{self, ScenarioFile};
use super::world::{World, WorldArgs};
use crate::link::{Hub, LinkSettings, LinkUrl};

/// `helmlink sitl`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink sitl
  helmlink sitl --listen tcpin:127.0.0.1:5760 --listen udpout:127.0.0.1:14550 --current 0.4@90 --speedup 5

  helmlink sitl --scenario gps-loss --speedup max
  helmlink sitl --boat skiff --fault rudder-stuck@60..90 --fault link-loss=20 --params boat.parm
  helmlink sitl --record logs --speedup 10
  helmlink sitl --boat skiff --ardupilot-json 127.0.0.1:9002

Then, for example: mavproxy.py --master tcp:127.0.0.1:5760")]
pub struct SitlArgs {
    /// Where ground stations find the boat (repeatable)
    #[arg(long, value_name = "URL", default_value = "tcpin:127.0.0.1:5760")]
    pub listen: Vec<LinkUrl>,
    /// How many times faster than real time, or `max` for as fast as the machine goes
    #[arg(long, default_value = "1", value_name = "N|max")]
    pub speedup: Pace,
    /// A scenario: one that comes with helmlink (bad-link, freshening-wind, gps-loss, lost-rudder, rising-sea,
    /// tired-battery) or a file.
    /// Ends with exit code 1 when an expectation does not come true
    #[arg(long, value_name = "NAME|FILE")]
    pub scenario: Option<String>,
    /// Something that fails, such as gps-loss@60..90 or link-loss=30 (repeatable; times in simulated seconds
    /// from the start)
    #[arg(long, value_name = "FAULT[@FROM[..UNTIL]]")]
    pub fault: Vec<TimedFault>,
    /// Parameters are read from this file at the start and written to it when they change
    #[arg(long, value_name = "FILE")]
    pub params: Option<PathBuf>,
    /// A parameter to begin with (repeatable)
    #[arg(long, value_name = "NAME=VALUE", value_parser = parameter_file::parse_assignment)]
    pub param: Vec<(String, f32)>,
    /// Sign frames with the key in this file (32 bytes, 64 hexadecimal digits or a passphrase) and refuse unsigned
    /// ones
    #[arg(long, value_name = "FILE")]
    pub signing_key: Option<PathBuf>,
    /// Arm and start the mission, or keep the place, as soon as possible: for runs without a ground station
    #[arg(long)]
    pub arm: bool,
    /// End after so much simulated time, seconds
    #[arg(long, value_name = "S")]
    pub duration: Option<RunS>,
    /// Start with time stopped; a client lets it pass (see docs/simulator.md)
    #[arg(long)]
    pub paused: bool,
    /// Be the physics behind a real ArduPilot instead (start it with --model JSON:ADDRESS). Faults and scenarios
    /// are then those of hull and sea alone
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "127.0.0.1:9002",
          conflicts_with_all = ["signing_key", "params", "param", "mission", "duration", "paused", "arm", "record"])]
    pub ardupilot_json: Option<std::net::SocketAddr>,
    /// A mission that the boat has on board from the start
    #[arg(long, value_name = "FILE")]
    pub mission: Option<PathBuf>,
    /// Take as long to start as real firmware does (position after 42 s)
    #[arg(long)]
    pub realistic_startup: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub recording: RecordArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub world: WorldArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// Where a boat lies when neither the user nor a mission says: Trondheim harbour, as in Fossen's Otter example.
const DEFAULT_HOME: Geodetic = Geodetic { latitude_deg: 63.4389, longitude_deg: 10.399 };
/// A waypoint closer to the boat than this gives no direction, metres.
const AT_HOME_M: f64 = 1.0;
/// How often a boat that cannot keep its pace is complained of.
const COMPLAINT_INTERVAL: Duration = Duration::from_secs(10);

pub(super) fn run(args: &SitlArgs) -> Result<(), Failure> {
    let scenario = args.scenario.as_deref().map(scenario::load).transpose()?;
    let mut world_args = args.world.clone();
    if let Some(scenario) = &scenario {
        scenario.apply(&mut world_args);
    }
    let world = World::from_args(&world_args)?;
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::failed)?;
    if let Some(address) = args.ardupilot_json {
        let mut physics = ardupilot_json::physics(&world);
        for fault in &args.fault {
            physics.schedule(*fault).map_err(Failure::usage)?;
        }
        if let Some(file) = scenario {
            physics.play(file.scenario).map_err(Failure::usage)?;
        }
        let home = home(&world, None);
        return runtime.block_on(ardupilot_json::serve(address, physics, &world, home, args.common.json));
    }
    let of_scenario = scenario.as_ref().and_then(ScenarioFile::mission);
    let path = args.mission.clone().or(of_scenario);
    let drivable = path.as_deref().map(mission::load).transpose()?;
    let mission = drivable.as_ref().map(|drivable| &drivable.mission);
    let home = home(&world, mission);
    let toward = drivable.as_ref().and_then(|drivable| first_target(home, &drivable.route));
    let mut parameters = args.params.as_deref().map(parameter_file::read).transpose()?.unwrap_or_default();
    parameters.extend(args.param.iter().cloned());
    let autopilot = AutopilotSettings {
        start_up: if args.realistic_startup { StartUp::realistic() } else { StartUp::default() },
        parameters,
        signing: args.signing_key.as_deref().map(signing).transpose()?,
        ..AutopilotSettings::default()
    };
    let mut sitl = build_with(&world, home, toward, autopilot)?;
    if let Some(mission) = mission {
        load(&mut sitl, mission)?;
    }
    for fault in &args.fault {
        sitl.schedule(*fault).map_err(Failure::usage)?;
    }
    if let Some(file) = scenario {
        sitl.play(file.scenario).map_err(Failure::usage)?;
    }
    if args.arm || args.scenario.is_some() {
        sitl.start_when_ready();
    }
    sitl.set_paused(args.paused);
    runtime.block_on(serve(args, sitl))
}

/// The key in a file, and the time from which signatures count.
fn signing(path: &std::path::Path) -> Result<(SigningKey, Timestamp), Failure> {
    let fault = |why: String| Failure::usage(format!("--signing-key {}: {why}", path.display()));
    let contents = std::fs::read(path).map_err(|error| fault(error.to_string()))?;
    let key = SigningKey::from_file_contents(&contents).map_err(|error| fault(error.to_string()))?;
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    Ok((key, Timestamp::from_unix(now)))
}

/// The simulated boat in its world.
///
/// Its bow points where the user says, or `toward` a place, or north.
pub(super) fn build(
    world: &World,
    home: Geodetic,
    toward: Option<Geodetic>,
    realistic_startup: bool,
) -> Result<Sitl, Failure> {
    let start_up = if realistic_startup { StartUp::realistic() } else { StartUp::default() };
    build_with(world, home, toward, AutopilotSettings { start_up, ..AutopilotSettings::default() })
}

/// The same with a certain autopilot.
fn build_with(
    world: &World,
    home: Geodetic,
    toward: Option<Geodetic>,
    autopilot: AutopilotSettings,
) -> Result<Sitl, Failure> {
    let settings = SitlSettings {
        sea: world.sea,
        sensors: world.sensors,
        seed: world.seed,
        home,
        heading_rad: heading_rad(world, home, toward),
        autopilot,
        ..SitlSettings::new(world.hull.clone())
    };
    Sitl::new(settings).map_err(Failure::usage)
}

/// Where the bow points at the start: where the user says, or `toward` a place, or north.
pub(super) fn heading_rad(world: &World, home: Geodetic, toward: Option<Geodetic>) -> f64 {
    let given = world.home.and_then(|(_, heading)| heading);
    let toward = toward.map(|place| LocalFrame::new(home).to_local(place).bearing_rad());
    given.or(toward).unwrap_or(0.0)
}

/// Puts a mission on board, as if it had been uploaded.
pub(super) fn load(sitl: &mut Sitl, mission: &Mission) -> Result<(), Failure> {
    sitl.set_mission(&mission.items).map_err(|most| {
        Failure::usage(format!("the mission is too long: the boat stores {most} items, home included"))
    })
}

/// Where the boat starts: where the user says, at the mission's home, at its first waypoint, or in a default harbour.
pub(super) fn home(world: &World, mission: Option<&Mission>) -> Geodetic {
    let of_mission =
        |mission: &Mission| mission.home.or_else(|| mission.items.iter().find_map(|item| item.position()));
    world.home.map(|(home, _)| home).or_else(|| mission.and_then(of_mission)).unwrap_or(DEFAULT_HOME)
}

/// The first waypoint that is not where the boat already lies: a boat is launched with its bow that way.
pub(super) fn first_target(home: Geodetic, route: &Route) -> Option<Geodetic> {
    route.waypoints.iter().map(|waypoint| waypoint.position).find(|place| home.distance_m(*place) > AT_HOME_M)
}

async fn serve(args: &SitlArgs, sitl: Sitl) -> Result<(), Failure> {
    let mut hub = Hub::new(LinkSettings::default());
    for url in &args.listen {
        let endpoint = hub.open(url).await.map_err(Failure::usage)?;
        match hub.local_address(endpoint) {
            Some(address) => tracing::info!("the boat listens on {url} ({address})"),
            None => tracing::info!("the boat talks to {url}"),
        }
        if args.common.json {
            let address = hub.local_address(endpoint).map(|address| address.to_string());
            console::say(&serde_json::json!({ "listen": url.to_string(), "address": address }).to_string());
        }
    }
    let mut boat = PacedSitl::new(sitl, *args.speedup);
    let ends = args.duration.is_some() || args.scenario.is_some();
    if ends {
        boat.keep_digest();
    }
    if let Some(duration_s) = args.duration {
        boat.end_at(Duration::from_secs_f64(*duration_s));
    }
    let mut recorder = args.recording.start(|start_us| {
        boat.keep_log(start_us);
        Vec::new()
    })?;
    let mut parameters = args.params.clone().map(|path| ParameterFile::new(path, &boat.sitl));
    let mut edge = Edge::new(boat, hub, paced_sitl::tick(*args.speedup));
    let mut interrupt = std::pin::pin!(interrupted());
    let mut complained = (Duration::ZERO, Duration::ZERO);
    while !edge.party.is_over() {
        tokio::select! {
            biased;
            () = &mut interrupt => break,
            seen = edge.turn() => match seen {
                Some(Seen::Up(peer)) => tracing::info!("link up: {peer}"),
                Some(Seen::Down(reason)) => tracing::info!("link down: {reason}"),
                None => {}
            },
        }
        if let Some(recorder) = &mut recorder {
            recorder.write(edge.party.take_log());
        }
        if let Some(file) = &mut parameters {
            file.follow(edge.now(), &edge.party.sitl)?;
        }
        let (now, lost) = (edge.now(), edge.party.lost());
        if lost > complained.1 && now > complained.0 + COMPLAINT_INTERVAL {
            tracing::warn!(
                "this machine is too slow for --speedup {}: {:.1} s left out so far",
                edge.party.speedup(),
                lost.as_secs_f64()
            );
            complained = (now, lost);
        }
    }
    let mut boat = edge.close().await;
    if let Some(mut recorder) = recorder {
        recorder.write(boat.take_log());
        recorder.finish_with_report();
    }
    if let Some(file) = &mut parameters {
        file.save(&boat.sitl)?;
    }
    boat.sitl.end_scenario();
    if ends {
        report(args, &boat);
    }
    scenario::check(boat.sitl.verdicts())
}

/// Says how a run with an end went.
fn report(args: &SitlArgs, boat: &PacedSitl) {
    let (digest, bytes) = boat.digest().unwrap_or_default();
    let verdicts = boat.sitl.verdicts();
    if args.common.json {
        let result = serde_json::json!({
            "simulated_s": boat.sitl.now().as_secs_f64(),
            "output_bytes": bytes,
            "output_sha256": digest,
            "expectations": scenario::json(verdicts),
            "passed": verdicts.iter().all(|verdict| verdict.passed == Some(true)),
        });
        console::say(&result.to_string());
        return;
    }
    console::say(&format!("  {:.2} s simulated, output SHA-256 {digest}", boat.sitl.now().as_secs_f64()));
    if !verdicts.is_empty() {
        console::say(&scenario::text(verdicts));
    }
}
