//! `helmlink mission …` as its users type it: files, and the missions of a boat over TCP and UDP.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::path::{Path, PathBuf};

use serde_json::Value;
use support::Helmlink;
use support::process::Ended;

/// A survey of thirteen waypoints, 219 m long.
const SURVEY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/mission/plans/harbour-survey.plan");
/// A waypoint, a fence of two areas, and two rally points.
const FENCED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/mission/tests/corpus/qgc-fence-rally.plan");
const ARDUROVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/ardurover-4.6-motorboat.tlog");
const HEAD: &str = "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t59.9\t10.7\t0\t1\n";
/// Nobody listens there.
const NOWHERE: &str = "tcp:127.0.0.1:9";

/// A folder of its own that is gone afterwards.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("missions").join(name);
        std::fs::remove_dir_all(&path).ok();
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn at(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    /// A mission file with these lines after home.
    fn wpl(&self, name: &str, items: &str) -> String {
        std::fs::write(self.0.join(name), format!("{HEAD}{items}")).unwrap();
        self.at(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

/// `helmlink mission …`, which has to end with this exit code.
#[track_caller]
fn mission(arguments: &[&str], exit_code: i32) -> Ended {
    let ended = Helmlink::run(&[&["mission"], arguments].concat());
    assert_eq!(ended.status.code(), Some(exit_code), "{arguments:?}: {}", ended.printed);
    ended
}

/// The same, which has to say all these words.
#[track_caller]
fn says(arguments: &[&str], exit_code: i32, words: &[&str]) {
    let printed = mission(arguments, exit_code).printed;
    for word in words {
        assert!(printed.contains(word), "{arguments:?}: no `{word}` in: {printed}");
    }
}

/// What it prints with `--json`.
#[track_caller]
fn json(arguments: &[&str]) -> Value {
    let printed = mission(&[arguments, &["--json", "-q"]].concat(), 0).printed;
    serde_json::from_str(&printed).unwrap_or_else(|error| panic!("{error}: {printed}"))
}

/// Everything goes up, comes down the same, and is compared; a boat's quirks (item 0 is home, items asked for one by
/// one with floating-point requests) are the simulator's as they are ArduRover's.
fn up_and_down(scheme: &str, client: &str) {
    let folder = Folder::new(client);
    let (_boat, address) = Helmlink::sitl(scheme, &["--home", "59.9,10.7,0", "--speedup", "10"]);
    let url = format!("{client}:{address}");
    let sent = json(&["upload", FENCED, "--connect", &url]);
    for (kind, items) in [("mission", 1), ("fence", 6), ("rally points", 2)] {
        let plan = &sent["uploaded"][kind];
        assert_eq!((plan["items"].as_u64(), plan["verified"].as_bool()), (Some(items), Some(true)), "{sent}");
    }
    let got = folder.at("got.plan");
    let fetched = json(&["download", "--connect", &url, "--all", "-o", &got]);
    assert_eq!(fetched["checksum_sha256"], sent["uploaded"]["mission"]["checksum_sha256"]);
    assert_eq!((fetched["fence_areas"].as_u64(), fetched["rally_points"].as_u64()), (Some(2), Some(2)));
    says(&["diff", FENCED, &got], 0, &["the same to a boat"]);
    says(&["diff", FENCED, "--connect", &url], 0, &["the same to a boat"]);
    says(
        &["diff", SURVEY, "--connect", &url],
        1,
        &["item 1: it moved", "only in the first", "differ in 13 places"],
    );
    json(&["upload", SURVEY, "--connect", &url, "--mission-only"]);
    says(&["diff", SURVEY, "--connect", &url], 0, &["13 items"]);
    let printed = mission(&["download", "--connect", &url, "-q"], 0).printed;
    assert!(printed.starts_with("QGC WPL 110\n0\t1\t0\t16\t"), "item 0 is home: {printed}");
    assert_eq!(printed.lines().count(), 15, "{printed}");
}

#[test]
fn plans_go_up_and_come_down_over_tcp() {
    up_and_down("tcpin", "tcp");
}

#[test]
fn plans_go_up_and_come_down_over_udp() {
    up_and_down("udpin", "udpout");
}

#[test]
fn what_a_boat_cannot_do_is_not_sent() {
    let folder = Folder::new("refused");
    let (_boat, address) = Helmlink::sitl("tcpin", &["--home", "59.9,10.7,0", "--speedup", "10"]);
    let url = format!("tcp:{address}");
    let near = "1\t0\t3\t16\t0\t0\t0\t0\t59.9003\t10.7\t0\t1\n";
    let takeoff =
        folder.wpl("takeoff.waypoints", &format!("{near}2\t0\t3\t22\t0\t0\t0\t0\t59.901\t10.7\t9\t1\n"));
    says(
        &["upload", &takeoff, "--connect", &url, "-q"],
        2,
        &["item 2", "MAV_CMD_NAV_TAKEOFF (22)", "--no-check"],
    );
    // Out of the fence of 400 m around home.
    let far = folder.at("far.plan");
    let text = std::fs::read_to_string(FENCED).unwrap().replace("47.398,", "47.408,");
    std::fs::write(&far, text).unwrap();
    says(&["check", &far], 1, &["problem", "fence"]);
    says(&["upload", &far, "--connect", &url, "-q"], 1, &["fence", "nothing was sent", "--no-check"]);
    says(&["download", "--connect", &url, "-q"], 1, &["there is no mission on board"]);
    let sent = json(&["upload", &takeoff, "--connect", &url, "--no-check"]);
    assert_eq!(sent["uploaded"]["mission"]["verified"].as_bool(), Some(true), "{sent}");
}

#[test]
fn a_boat_that_drives_its_mission_is_sent_nothing() {
    let world = ["--mission", SURVEY, "--arm", "--speedup", "2"];
    let (_boat, address) = Helmlink::sitl("tcpin", &world);
    let url = format!("tcp:{address}");
    let upload = ["upload", SURVEY, "--connect", &url, "-q"];
    // It takes a moment to get ready; until then it may be sent a mission.
    let ended = loop {
        let ended = Helmlink::run(&[&["mission"], &upload[..]].concat());
        if !ended.status.success() {
            break ended;
        }
    };
    assert_eq!(ended.status.code(), Some(1), "{}", ended.printed);
    assert!(ended.printed.contains("armed and drives its mission"), "{}", ended.printed);
    says(&[&upload[..], &["--force"]].concat(), 0, &["13 items on board"]);
}

#[test]
fn nobody_there_is_no_link() {
    let wait = ["--connect", NOWHERE, "--wait", "0.3", "-q"];
    for verb in [&["upload", SURVEY][..], &["download"], &["diff", SURVEY]] {
        says(&[verb, &wait].concat(), 3, &["no heartbeat of a flight controller", "0.3 s"]);
    }
}

#[test]
fn missions_are_checked_and_shown() {
    says(&["check", SURVEY], 0, &["a boat can drive it", "13 waypoints", "warning, items"]);
    let checked = json(&["check", SURVEY, "--speed", "1"]);
    assert_eq!((checked["drivable"].as_bool(), checked["waypoints"].as_u64()), (Some(true), Some(13)));
    let wide = ["check", SURVEY, "--boat", "monohull38", "--speed", "5"];
    says(&wide, 1, &["problem, items 2, 3", "cannot follow this corner", "before driving it"]);
    says(&["check", "nowhere.plan"], 2, &["nowhere.plan"]);
    says(&["check", SURVEY, "--boat", "raft"], 2, &["no boat called"]);
    says(&["show", FENCED], 0, &["R1", "R2", "H", "north is up"]);
    let folder = Folder::new("shown");
    let picture = folder.at("fenced.svg");
    mission(&["show", FENCED, "--svg", &picture], 0);
    let picture = std::fs::read_to_string(picture).unwrap();
    for word in ["<svg", "keep inside", "keep outside", ">R2<"] {
        assert!(picture.contains(word), "no `{word}`");
    }
    let shown = json(&["show", FENCED]);
    assert_eq!(shown["fence_north_east_m"].as_array().unwrap().len(), 2, "{shown}");
    // The same of a run.
    let report = folder.at("run");
    let run = Helmlink::run(&["simulate", FENCED, "--sensors", "perfect", "--report", &report, "-q"]);
    assert!(run.status.success(), "{}", run.printed);
    let drawn = std::fs::read_to_string(Path::new(&report).join("track.svg")).unwrap();
    for word in ["driven track", "keep inside", "keep outside", ">R2<"] {
        assert!(drawn.contains(word), "{word}");
    }
}

#[test]
fn missions_go_through_every_format_and_back() {
    let folder = Folder::new("formats");
    let mut before = SURVEY.to_owned();
    for ending in ["waypoints", "geojson", "csv", "plan", "kml", "kmz", "gpx"] {
        let after = folder.at(&format!("survey.{ending}"));
        mission(&["convert", &before, &after], 0);
        before = after;
    }
    let checked = json(&["check", &before]);
    assert_eq!((checked["format"].as_str(), checked["waypoints"].as_u64()), (Some("gpx"), Some(13)));
    let lossy = folder.at("fence.gpx");
    says(&["convert", FENCED, &lossy], 0, &["fence"]);
    says(&["convert", FENCED, &lossy, "--strict"], 1, &["fence"]);
}

#[test]
fn a_track_becomes_a_mission_that_a_boat_can_drive() {
    let folder = Folder::new("track");
    let again = folder.at("again.waypoints");
    let made = json(&["from-track", ARDUROVER, "-o", &again, "--tolerance", "0.5"]);
    assert!(made["deviation_m"].as_f64() <= Some(0.5) && made["items"].as_u64() > Some(8), "{made}");
    says(&["check", &again, "--boat", "motorboat", "--speed", "5"], 0, &["a boat can drive it"]);
    says(&["from-track", ARDUROVER, "--system", "99"], 1, &["no position of a vehicle"]);
}
