//! `helmlink bridge` on the wire, between a real ground station (pymavlink) and `helmlink sitl`, over UDP, TCP and a
//! pseudo-terminal: the whole mission, the pilot taking over in the middle, Ctrl-C, and its sudden death.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::path::Path;

use helmlink_wire::Message;
use helmlink_wire::tlog::records;
use support::process::Process;
use support::{Helmlink, Script};

/// Where and what is driven.
struct Voyage {
    /// Options of both programs.
    boat: [&'static str; 2],
    home: &'static str,
    plan: &'static str,
    /// How near the boat comes to each waypoint, m: it rounds the corners.
    near_m: &'static str,
}

/// The Otter on a mission of four waypoints, 60 m long.
const SURVEY: Voyage = Voyage {
    boat: ["--boat", "otter"],
    home: "63.442,10.395,20",
    plan: concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/short-survey.waypoints"),
    near_m: "2",
};
/// ArduPilot's motorboat on four lanes of 100 m.
const LAWNMOWER: Voyage = Voyage {
    boat: ["--boat", "motorboat"],
    home: "43.535,-5.65,0",
    plan: concat!(env!("CARGO_MANIFEST_DIR"), "/mission/plans/lawnmower-30m.waypoints"),
    near_m: "6",
};
/// How much faster than real time: a machine that is busy for 0.3 s looks like a lost position.
const SPEEDUP: &str = "3";
/// ArduRover's mode that the pilot changes to.
const STEERING: u32 = 3;
/// The control period, 1/25 s.
const CONTROL_PERIOD_US: u64 = 40_000;

/// A boat, a bridge that drives it over `kind` of link, and the script that looks on.
struct Scene {
    bridge: Helmlink,
    script: Process,
    _boat: Helmlink,
}

impl Scene {
    fn new(voyage: &Voyage, what: &str, kind: &str, options: &[&str]) -> Self {
        let world = ["--home", voyage.home, "--speedup", SPEEDUP];
        let far = if kind == "udp" { "udpin:127.0.0.1:0" } else { "tcpin:127.0.0.1:0" };
        let (boat, station) =
            Helmlink::sitl("tcpin", &[&voyage.boat, &world[..], &["--listen", far]].concat());
        let (address, station) = (boat.wait_for_address(), format!("tcp:{station}"));
        let arguments = [what, kind, &station, &address, voyage.plan, voyage.near_m];
        let script = Script::start("bridge_drives.py", &arguments);
        let line = script.wait_for_line("connect ");
        let url = line.trim_start_matches("connect ");
        let bridge = ["bridge", "--connect", url, "--engage"];
        let bridge = Helmlink::start(&[&bridge[..], &voyage.boat, options].concat());
        Self { bridge, script, _boat: boat }
    }

    /// The script is content, and the bridge ends well.
    fn end(self) {
        self.script.succeed();
        self.bridge.into_process().succeed();
    }
}

/// The whole mission, and the bridge ends by itself.
fn drives_to_the_end(kind: &str) {
    Scene::new(&SURVEY, "finish", kind, &["--once"]).end();
}

#[test]
fn a_mission_is_driven_to_the_end_over_udp() {
    drives_to_the_end("udp");
}

#[test]
fn a_mission_is_driven_to_the_end_over_tcp() {
    drives_to_the_end("tcp");
}

#[test]
fn a_mission_is_driven_to_the_end_over_a_serial_line() {
    drives_to_the_end("pty");
}

/// The pilot changes the mode: the bridge lets go at once, and goes on living.
fn the_pilot_takes_over(kind: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("takeover-{kind}"));
    std::fs::remove_dir_all(&folder).ok();
    let scene = Scene::new(&SURVEY, "takeover", kind, &["--record", folder.to_str().unwrap()]);
    scene.script.succeed();
    scene.bridge.wait_for_line("the pilot took over (STEERING)");
    scene.bridge.interrupt();
    scene.bridge.into_process().succeed();
    let mut paths = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let log = paths.find(|path| path.extension().is_some_and(|extension| extension == "tlog")).unwrap();
    assert_nothing_after_the_heartbeat(&std::fs::read(log).unwrap());
}

/// In the order in which the bridge has heard and sent: once it has heard of the new mode, it steers no more. That is
/// less than the control period that it may take.
fn assert_nothing_after_the_heartbeat(log: &[u8]) {
    let (mut before, mut told_us, mut released_us) = (0, None, None);
    for record in records(log) {
        match record.frame.decode() {
            Ok(Message::HEARTBEAT(beat)) if beat.custom_mode == STEERING => {
                told_us = told_us.or(Some(record.time_us));
            }
            Ok(Message::RC_CHANNELS_OVERRIDE(command)) if told_us.is_none() => {
                assert_ne!((command.chan1_raw, command.chan3_raw), (0, 0), "let go too early");
                before += 1;
            }
            Ok(Message::RC_CHANNELS_OVERRIDE(command)) => {
                assert_eq!((command.chan1_raw, command.chan3_raw), (0, 0), "steered on");
                released_us = released_us.or(Some(record.time_us));
            }
            _ => {}
        }
    }
    assert!(before > 100, "{before} commands");
    let took_us = released_us.unwrap() - told_us.unwrap();
    assert!(took_us <= CONTROL_PERIOD_US, "{took_us} us");
}

#[test]
fn the_pilot_takes_over_udp() {
    the_pilot_takes_over("udp");
}

#[test]
fn the_pilot_takes_over_tcp() {
    the_pilot_takes_over("tcp");
}

#[test]
fn the_pilot_takes_over_a_serial_line() {
    the_pilot_takes_over("pty");
}

#[test]
fn ctrl_c_stops_the_boat_then_lets_go() {
    let scene = Scene::new(&SURVEY, "interrupt", "tcp", &[]);
    scene.script.wait_for_line("now");
    scene.bridge.interrupt();
    scene.end();
}

#[test]
fn the_motorboat_is_driven_too() {
    Scene::new(&LAWNMOWER, "finish", "tcp", &["--once", "--speed", "5"]).end();
}

/// The bridge is killed on the spot: what then is with the boat, the script says.
fn is_killed(what: &str, options: &[&str]) {
    let mut scene = Scene::new(&SURVEY, what, "tcp", options);
    scene.script.wait_for_line("now");
    scene.bridge.kill();
    scene.script.succeed();
}

#[test]
fn a_killed_bridge_leaves_the_boat_to_the_sticks() {
    is_killed("killed", &[]);
}

#[test]
fn a_killed_bridge_leaves_a_boat_without_receiver_to_the_failsafe() {
    is_killed("orphaned", &[]);
}
