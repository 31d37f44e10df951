//! The same mission and seed give the same commands, byte for byte, whichever way the bytes go.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::time::Duration;

use helmlink::bridge::Bridge;
use helmlink::control::{Boat, Controller};
use helmlink::link::memory::{MemoryLink, join};
use helmlink::link::{Hub, LinkEvent, LinkId, LinkSettings};
use helmlink::pilot::supervisor::State;
use helmlink::simulation::Trial;
use helmlink::simulation::closed_loop::LOOP;
use helmlink::vehicle::OutputKind;
use helmlink_mission::plan;
use helmlink_mission::route::Route;
use helmlink_sitl::Sitl;
use helmlink_sitl::physics::{Hull, Sea, SeaState, SensorSettings};
use support::Helmlink;

const PLAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/short-survey.waypoints");

/// A short run on a slight sea with sensors as they are.
fn trial(output: OutputKind) -> Trial {
    let mission = plan::read(PLAN).unwrap();
    let hull = Hull::builtin("otter").unwrap();
    Trial {
        boat: Boat::embedded("otter").unwrap(),
        controller: Controller::PiSmc,
        output,
        speed_mps: None,
        interval_s: 0.04,
        sea: Sea::preset(SeaState::Slight, &hull),
        hull,
        sensors: SensorSettings::typical(),
        seed: 7,
        delay_s: 0.0,
        route: Route::from_mission(&mission).unwrap(),
        home: mission.home.unwrap(),
        mission,
        heading_rad: 0.0,
    }
}

/// Two hubs joined in memory, with the boat at one and the bridge at the other.
struct Joined {
    boat: Hub,
    bridge: Hub,
    link: MemoryLink,
}

impl Joined {
    async fn new() -> Self {
        let (mut boat, mut bridge) = (Hub::new(LinkSettings::default()), Hub::new(LinkSettings::default()));
        let link = join(&mut boat, &mut bridge, false);
        for hub in [&mut boat, &mut bridge] {
            assert!(matches!(hub.next_event().await, LinkEvent::Up { .. }));
        }
        Self { boat, bridge, link }
    }
}

/// Sends every frame by one hub; returns what arrives at the other, write by write.
async fn carry(from: &Hub, by: LinkId, to: &mut Hub, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
    let mut arrived = Vec::new();
    for frame in frames {
        assert!(from.send(by, &frame));
        match to.next_event().await {
            LinkEvent::Bytes { data, .. } => arrived.push(data),
            other => panic!("{other:?}"),
        }
    }
    arrived
}

/// The digest of the run, and how many commands it covers, with hubs and links between the two.
async fn through_links(mut sitl: Sitl, mut bridge: Bridge, limit: Duration) -> (String, u64) {
    let mut joined = Joined::new().await;
    let (boat_link, bridge_link) = (joined.link.first, joined.link.second);
    sitl.link_up(boat_link);
    bridge.link_up(Duration::ZERO, bridge_link);
    let mut now = Duration::ZERO;
    while bridge.status().state != State::Finished {
        assert!(now < limit, "not finished in time");
        now += LOOP;
        sitl.advance(now);
        let frames = std::iter::from_fn(|| sitl.poll_transmit()).map(|(_, frame)| frame).collect();
        for data in carry(&joined.boat, boat_link, &mut joined.bridge, frames).await {
            bridge.on_bytes(now, bridge_link, &data, false);
        }
        bridge.on_tick(now);
        let frames = std::iter::from_fn(|| bridge.poll_transmit()).map(|(_, frame)| frame).collect();
        for data in carry(&joined.bridge, bridge_link, &mut joined.boat, frames).await {
            sitl.on_bytes(boat_link, &data);
        }
    }
    bridge.commands_digest()
}

fn same_by_any_way(output: OutputKind) {
    let trial = trial(output);
    let outcome = trial.run().unwrap();
    assert!(outcome.completed, "{:?}", outcome.complaint);
    let again = trial.run().unwrap();
    assert_eq!(outcome.commands_sha256, again.commands_sha256);

    let (sitl, bridge) = trial.parties().unwrap();
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_time().start_paused(true).build().unwrap();
    let (digest, count) = runtime.block_on(through_links(sitl, bridge, trial.limit()));
    assert_eq!((digest, count), (outcome.commands_sha256, outcome.commands));
    assert!(count > 1000, "{count} commands");
}

#[test]
fn links_in_memory_change_no_override() {
    same_by_any_way(OutputKind::RcOverride);
}

#[test]
fn links_in_memory_change_no_guided_setpoint() {
    same_by_any_way(OutputKind::Guided);
}

#[test]
fn simulate_gives_the_same_commands_twice_and_others_for_another_seed() {
    let digest = |seed: &str| {
        let ended =
            Helmlink::run(&["simulate", PLAN, "--json", "--quiet", "--sea", "slight", "--seed", seed]);
        assert!(ended.status.success(), "{}", ended.printed);
        let result: serde_json::Value = serde_json::from_str(&ended.printed).unwrap();
        assert_eq!(result["completed"], true);
        result["commands_sha256"].as_str().unwrap().to_owned()
    };
    let first = digest("7");
    assert_eq!(first, digest("7"));
    assert_ne!(first, digest("8"));
}

#[test]
fn a_comparison_is_the_same_on_any_number_of_threads() {
    let compared = |threads: &str| {
        let ended = Helmlink::run(&[
            "compare",
            PLAN,
            "--json",
            "--quiet",
            "--controllers",
            "pi-smc,pid",
            "--seas",
            "slight",
            "--perturbations",
            "nominal,delay=0.3",
            "--seeds",
            "2",
            "--threads",
            threads,
        ]);
        assert!(ended.status.success(), "{}", ended.printed);
        let mut result: serde_json::Value = serde_json::from_str(&ended.printed).unwrap();
        for run in result["runs"].as_array_mut().unwrap() {
            // The one figure that is the machine's and not the run's.
            assert!(run.as_object_mut().unwrap().remove("realtime_factor").is_some());
        }
        result
    };
    let (one, three) = (compared("1"), compared("3"));
    assert_eq!(one, three);
    let digests: std::collections::BTreeSet<&str> =
        one["runs"].as_array().unwrap().iter().map(|run| run["commands_sha256"].as_str().unwrap()).collect();
    assert_eq!(digests.len(), 8, "every run is another one: {digests:?}");
}
