//! `helmlink bridge` on the wire, between a real ground station (pymavlink) and `helmlink sitl`, over UDP, TCP and a
//! pseudo-terminal: the whole mission, the pilot taking over in the middle, Ctrl-C.

#![cfg(unix)]

mod support;

use support::process::Process;
use support::{Helmlink, Script};

/// A mission of four waypoints, 60 m long.
const PLAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/short-survey.waypoints");
/// How much faster than real time, where nothing depends on when exactly a frame comes.
const FAST: &str = "3";
/// How much faster than real time where the relay keeps frames back for a moment.
const SLOW: &str = "2";

/// A boat, a bridge that drives it over `kind` of link, and the script that looks on.
struct Scene {
    bridge: Helmlink,
    script: Process,
    _boat: Helmlink,
}

impl Scene {
    fn new(what: &str, kind: &str, speedup: &str, options: &[&str]) -> Self {
        let world = ["--home", "63.442,10.395,20", "--speedup", speedup];
        let far = if kind == "udp" { "udpin:127.0.0.1:0" } else { "tcpin:127.0.0.1:0" };
        let (boat, station) = Helmlink::sitl("tcpin", &[&world[..], &["--listen", far]].concat());
        let address = boat.wait_for_address();
        let station = format!("tcp:{station}");
        let script = Script::start("bridge_drives.py", &[what, kind, &station, &address, PLAN]);
        let line = script.wait_for_line("connect ");
        let url = line.trim_start_matches("connect ");
        let bridge = Helmlink::start(&[&["bridge", "--connect", url, "--engage"], options].concat());
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
    Scene::new("finish", kind, FAST, &["--once"]).end();
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

/// The pilot changes the mode: the bridge lets go within one control period, and goes on living.
fn the_pilot_takes_over(kind: &str) {
    let scene = Scene::new("takeover", kind, SLOW, &[]);
    scene.bridge.wait_for_line("the pilot took over (STEERING)");
    scene.script.succeed();
    scene.bridge.interrupt();
    scene.bridge.into_process().succeed();
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
    let scene = Scene::new("interrupt", "tcp", FAST, &[]);
    scene.script.wait_for_line("interrupt");
    scene.bridge.interrupt();
    scene.end();
}
