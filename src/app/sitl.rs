//! `helmlink sitl`: the simulated boat alone.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use helmlink_mission::geodesy::{Geodetic, LocalFrame};
use helmlink_mission::plan::Mission;
use helmlink_mission::route::Route;
use helmlink_sitl::{Sitl, SitlSettings, StartUp};

use super::bridge::interrupted;
use super::cli::Common;
use super::console;
use super::edge::{Edge, Seen};
use super::failure::Failure;
use super::mission;
use super::paced_sitl::{self, PacedSitl};
use super::world::{World, WorldArgs};
use crate::link::{Hub, LinkSettings, LinkUrl};

/// `helmlink sitl`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink sitl
  helmlink sitl --listen tcpin:127.0.0.1:5760 --listen udpout:127.0.0.1:14550 --current 0.4@90 --speedup 5

Then, for example: mavproxy.py --master tcp:127.0.0.1:5760")]
pub struct SitlArgs {
    /// Where ground stations find the boat (repeatable)
    #[arg(long, value_name = "URL", default_value = "tcpin:127.0.0.1:5760")]
    pub listen: Vec<LinkUrl>,
    /// How many times faster than real time
    #[arg(long, default_value_t = 1.0, value_name = "N")]
    pub speedup: f64,
    /// A mission that the boat has on board from the start
    #[arg(long, value_name = "FILE")]
    pub mission: Option<PathBuf>,
    /// Take as long to start as real firmware does (position after 42 s)
    #[arg(long)]
    pub realistic_startup: bool,
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
/// Multiples of real time that make sense.
const SPEEDUPS: std::ops::RangeInclusive<f64> = 0.01..=1000.0;
/// How often a boat that cannot keep its pace is complained of.
const COMPLAINT_INTERVAL: Duration = Duration::from_secs(10);

pub(super) fn run(args: &SitlArgs) -> Result<(), Failure> {
    let world = World::from_args(&args.world)?;
    check_speedup(args.speedup)?;
    let mission = args.mission.as_deref().map(mission::load).transpose()?.map(|drivable| drivable.mission);
    let home = home(&world, mission.as_ref());
    let mut sitl = build(&world, home, None, args.realistic_startup)?;
    if let Some(mission) = &mission {
        load(&mut sitl, mission)?;
    }
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::failed)?;
    runtime.block_on(serve(args, sitl))
}

pub(super) fn check_speedup(speedup: f64) -> Result<(), Failure> {
    if SPEEDUPS.contains(&speedup) {
        return Ok(());
    }
    Err(Failure::usage(format!("--speedup {speedup}: choose {} to {}", SPEEDUPS.start(), SPEEDUPS.end())))
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
    let mut settings = SitlSettings {
        sea: world.sea,
        sensors: world.sensors,
        seed: world.seed,
        home,
        heading_rad: heading_rad(world, home, toward),
        ..SitlSettings::new(world.hull.clone())
    };
    if realistic_startup {
        settings.autopilot.start_up = StartUp::realistic();
    }
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
    let mut edge = Edge::new(PacedSitl::new(sitl, args.speedup), hub, paced_sitl::tick(args.speedup));
    let mut interrupt = std::pin::pin!(interrupted());
    let mut complained = (Duration::ZERO, Duration::ZERO);
    loop {
        tokio::select! {
            biased;
            () = &mut interrupt => break,
            seen = edge.turn() => match seen {
                Some(Seen::Up(peer)) => tracing::info!("link up: {peer}"),
                Some(Seen::Down(reason)) => tracing::info!("link down: {reason}"),
                None => {}
            },
        }
        let (now, lost) = (edge.now(), edge.party.lost());
        if lost > complained.1 && now > complained.0 + COMPLAINT_INTERVAL {
            tracing::warn!(
                "this machine is too slow for --speedup {}: {:.1} s left out so far",
                args.speedup,
                lost.as_secs_f64()
            );
            complained = (now, lost);
        }
    }
    edge.close().await;
    Ok(())
}
