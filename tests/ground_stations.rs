//! Real ground-station programs against `helmlink sitl`: what their users do, from connecting to the way home.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use support::{Helmlink, Script};

/// A mission of four waypoints, 60 m long.
const SHORT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/short-survey.waypoints");
/// The sample mission that starts where the short one does.
const LONG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/mission/plans/harbour-survey.waypoints");

/// A boat at the missions' home, for a ground station that stands `speedup` times real time.
fn boat(scheme: &str, speedup: &str) -> (Helmlink, String) {
    Helmlink::sitl(scheme, &["--home", "63.442,10.395,20", "--speedup", speedup])
}

#[test]
fn pymavlink_runs_a_mission_over_tcp() {
    let (_boat, address) = boat("tcpin", "5");
    Script::run("pymavlink_mission.py", &[&format!("tcp:{address}"), LONG]);
}

#[test]
fn pymavlink_runs_a_mission_over_udp() {
    let (_boat, address) = boat("udpin", "5");
    Script::run("pymavlink_mission.py", &[&format!("udpout:{address}"), SHORT]);
}

#[test]
fn mavsdk_runs_a_mission() {
    let (_boat, address) = boat("tcpin", "5");
    // With --nocapture: how long discovery took.
    print!("{}", Script::run("mavsdk_mission.py", &["native", &format!("tcpout://{address}"), LONG]));
}

#[test]
fn mavsdk_by_grpc_runs_a_mission_over_udp() {
    let (_boat, address) = boat("udpin", "5");
    Script::run("mavsdk_mission.py", &["grpc", &format!("udpout://{address}"), SHORT]);
}

#[test]
fn mavproxy_runs_a_mission() {
    let (_boat, address) = boat("tcpin", "2");
    // With --nocapture: how long all parameters took.
    print!("{}", Script::run("mavproxy_mission.py", &[&format!("tcp:{address}"), SHORT]));
}

#[test]
fn several_ground_stations_watch_while_one_drives() {
    let (_boat, address) = boat("tcpin", "2");
    let (tcp, tcpout) = (format!("tcp:{address}"), format!("tcpout://{address}"));
    let watchers = [
        Script::start("pymavlink_mission.py", &[&tcp, SHORT, "watch"]),
        Script::start("mavsdk_mission.py", &["native", &tcpout, SHORT, "watch"]),
        Script::start("mavproxy_mission.py", &[&tcp, SHORT, "watch"]),
    ];
    for watcher in &watchers {
        watcher.wait_for_line("parameters");
    }
    Script::run("pymavlink_mission.py", &[&tcp, SHORT]);
    for watcher in watchers {
        let printed = watcher.succeed();
        assert!(printed.contains("5 items on board"), "{printed}");
    }
}
