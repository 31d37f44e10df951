//! Real ground-station programs against `helmlink sitl`: what their users do, from connecting to the last waypoint.

#![cfg(unix)]

#[path = "../support/mod.rs"]
mod support;

use support::{Helmlink, Script};

/// Home of the sample mission `harbour-survey.waypoints`.
const HOME: &str = "63.442,10.395,20";

/// A boat for a ground station that stands `speedup` times real time.
fn boat(scheme: &str, speedup: &str) -> (Helmlink, String) {
    Helmlink::sitl(scheme, &["--home", HOME, "--speedup", speedup])
}

#[test]
fn pymavlink_runs_a_mission_over_tcp() {
    let (_boat, address) = boat("tcpin", "20");
    Script::run("pymavlink_mission.py", &[&format!("tcp:{address}")]);
}

#[test]
fn pymavlink_runs_a_mission_over_udp() {
    let (_boat, address) = boat("udpin", "20");
    Script::run("pymavlink_mission.py", &[&format!("udpout:{address}")]);
}
