//! What a user does with logs: records a boat, proves the recording, replays it, makes a report of it.

#![allow(clippy::unwrap_used, clippy::panic)] // helpers of tests

mod support;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ARDUROVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/ardurover-4.6-motorboat.tlog");

/// A folder of its own that is gone afterwards.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("helmlink-replay-{name}-{}", std::process::id()));
        std::fs::remove_dir_all(&path).ok();
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

fn helmlink(folder: &Folder, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_helmlink")).current_dir(&folder.0).args(arguments).output().unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    let text = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}\n{}", complaint(output)))
}

fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A mission of two short legs north of Trondheim.
fn short_mission(folder: &Folder) -> String {
    let path = folder.file("short.waypoints");
    let text = "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t63.4389\t10.399\t0\t1\n\
                1\t0\t3\t16\t0\t0\t0\t0\t63.4391\t10.399\t0\t1\n2\t0\t3\t16\t0\t0\t0\t0\t63.4392\t10.3993\t0\t1\n";
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_simulation_is_proven_and_its_digest_is_the_simulations() {
    let folder = Folder::new("simulate");
    let mission = short_mission(&folder);
    let run = helmlink(&folder, &["simulate", &mission, "--report", "run", "--json", "-q"]);
    let digest = json(&run)["commands_sha256"].as_str().unwrap().to_owned();
    let proof = helmlink(&folder, &["replay", "run/log.tlog", "--proof", "--expect", &digest, "--json"]);
    assert!(proof.status.success(), "{}", complaint(&proof));
    let report = json(&proof);
    assert_eq!((report["holds"].as_bool(), report["commands_sha256"].as_str()), (Some(true), Some(&*digest)));
    let wrong = "0".repeat(64);
    let refused = helmlink(&folder, &["replay", "run/log.tlog", "--proof", "--expect", &wrong]);
    assert_eq!(refused.status.code(), Some(1), "{}", complaint(&refused));
    assert!(Path::new(&folder.file("run/report.html")).exists());
}

#[test]
fn a_demonstration_over_real_sockets_is_proven() {
    let folder = Folder::new("demo");
    let mission = short_mission(&folder);
    let arguments = [
        "demo",
        "--mission",
        &mission,
        "--speedup",
        "20",
        "--report",
        "run",
        "--listen",
        "tcpin:127.0.0.1:0",
        "-q",
    ];
    let demo = helmlink(&folder, &arguments);
    assert!(demo.status.success(), "{}", complaint(&demo));
    let proof = helmlink(&folder, &["replay", "run/log.tlog", "--proof", "--json"]);
    assert!(proof.status.success(), "{}", complaint(&proof));
    assert!(json(&proof)["commands"].as_u64() > Some(100));
}

#[test]
fn the_ardurover_log_is_replayed_with_all_its_outputs() {
    let folder = Folder::new("ardurover");
    let arguments = [
        "replay", ARDUROVER, "--out", "c.csv", "--out", "c.tlog", "--out", "c.json", "--mcap", "c.mcap",
        "--json", "-q",
    ];
    let run = helmlink(&folder, &arguments);
    assert!(run.status.success(), "{}", complaint(&run));
    let report = json(&run);
    let of = |key: &str| report[key].as_u64();
    assert_eq!((of("records"), of("reached_recorded"), of("waypoints")), (Some(17_732), Some(8), Some(8)));
    let steps = of("steps").unwrap();
    let csv = std::fs::read_to_string(folder.file("c.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().count() as u64 > steps && csv.lines().all(|line| line.split(',').count() == columns));
    let lines = std::fs::read_to_string(folder.file("c.json")).unwrap();
    assert!(lines.lines().all(|line| serde_json::from_str::<serde_json::Value>(line).is_ok()));
    let log = std::fs::read(folder.file("c.tlog")).unwrap();
    let overrides = helmlink_wire::tlog::records(&log)
        .filter(|record| record.frame.name() == Some("RC_CHANNELS_OVERRIDE"))
        .count() as u64;
    assert_eq!(overrides, steps);
    let mcap = std::fs::read(folder.file("c.mcap")).unwrap();
    let messages = mcap::MessageStream::new(&mcap).unwrap().map(Result::unwrap);
    let mut topics: Vec<String> = messages.map(|message| message.channel.topic.clone()).collect();
    topics.sort();
    topics.dedup();
    assert_eq!(topics, ["/commands", "/errors", "/events", "/mission", "/parameters", "/state", "/track"]);
    let page = std::fs::read_to_string(folder.file("helmlink-replay/report.html")).unwrap();
    assert!(page.contains("cross-track driven") && page.contains("<svg"));
}

#[test]
fn two_boats_are_compared_on_one_log() {
    let folder = Folder::new("compare");
    let run = helmlink(&folder, &["replay", ARDUROVER, "--compare", "motorboat", "skiff", "--json", "-q"]);
    assert!(run.status.success(), "{}", complaint(&run));
    assert!(json(&run)["steering_difference_rms"].as_f64() > Some(0.0));
    assert!(Path::new(&folder.file("helmlink-replay/compared.svg")).exists());
}

#[test]
fn a_recorded_track_is_driven_again() {
    let folder = Folder::new("drive");
    let run = helmlink(&folder, &["replay", ARDUROVER, "--drive", "--json", "-q"]);
    assert!(run.status.success(), "{}", complaint(&run));
    let result = json(&run);
    assert_eq!(result["completed"].as_bool(), Some(true));
    assert!(result["cross_track_straight_m"]["rms"].as_f64() < Some(0.5), "{result}");
}

/// A boat in the simulator that records what it hears and says, and its address.
#[cfg(unix)]
fn recorded_boat(folder: &Folder) -> (support::Helmlink, String) {
    let of_boat = folder.file("boat");
    let (boat, address) = support::Helmlink::sitl(
        "tcpin",
        &["--home", "63.4389,10.399,0", "--speedup", "4", "--record", &of_boat],
    );
    (boat, format!("tcp:{address}"))
}

/// What the boat was told to do with its motors: the first parameters of all commands to arm.
#[cfg(unix)]
fn arm_commands(folder: &Folder) -> Vec<f32> {
    let entries = std::fs::read_dir(folder.file("boat")).unwrap().map(|entry| entry.unwrap().path());
    let mut logs = entries.filter(|path| path.extension().is_some_and(|extension| extension == "tlog"));
    let log = std::fs::read(logs.next().unwrap()).unwrap();
    let arming = helmlink_wire::tlog::records(&log).filter_map(|record| match record.frame.decode() {
        Ok(helmlink_wire::Message::COMMAND_LONG(command)) if command.command == 400 => Some(command.param1),
        _ => None,
    });
    arming.collect()
}

#[cfg(unix)]
#[test]
fn a_recorded_track_is_driven_again_on_a_boat_that_is_armed_only_when_told() {
    let folder = Folder::new("drive-boat");
    let mission = short_mission(&folder);
    let run = helmlink(&folder, &["simulate", &mission, "--report", "run", "--json", "-q"]);
    assert!(run.status.success(), "{}", complaint(&run));
    let (boat, url) = recorded_boat(&folder);
    let log = folder.file("run/log.tlog");
    let drive = ["replay", &log, "--drive", "--to", &url];
    let refused = helmlink(&folder, &drive);
    assert_eq!(refused.status.code(), Some(2), "{}", complaint(&refused));
    assert!(complaint(&refused).contains("replace the mission of the boat"), "{}", complaint(&refused));

    // A boat file of one's own, by a name that no boat of Helmlink has: it is the one that drives.
    let own = include_str!("../src/control/boats/otter.toml").replace("name = \"otter\"", "name = \"ours\"");
    std::fs::write(folder.file("ours.toml"), own).unwrap();
    let boat_file = folder.file("ours.toml");
    let patient = support::Helmlink::start(&[&drive[..], &["--yes-send", "--boat", &boat_file]].concat());
    patient.wait_for_line("on board and compared");
    patient.wait_for_line("arm the boat");
    patient.wait_for_line("ready, not driving");
    patient.interrupt();
    patient.into_process().succeed();
    boat.interrupt();
    boat.into_process().succeed();
    assert_eq!(arm_commands(&folder), [0.0_f32; 0], "nobody has armed it");

    std::fs::remove_dir_all(folder.file("boat")).unwrap();
    let (boat, url) = recorded_boat(&folder);
    let told = ["replay", &log, "--drive", "--to", &url, "--yes-send", "--arm"];
    let printed = support::Helmlink::start(&told).into_process().succeed();
    assert!(printed.contains("mission complete"), "{printed}");
    boat.interrupt();
    boat.into_process().succeed();
    assert_eq!(arm_commands(&folder).first(), Some(&1.0));
    let driven = helmlink(&folder, &["replay", "boat", "--mission", &mission, "--json", "-q", "--no-report"]);
    let result = json(&driven);
    assert!(result["recorded"]["cross_track_m"]["rms"].as_f64() < Some(3.0), "{result}");
}

#[test]
fn what_cannot_be_replayed_is_explained() {
    let folder = Folder::new("faults");
    std::fs::write(folder.file("text.tlog"), "this is no log at all").unwrap();
    for (arguments, code, words) in [
        (vec!["replay", "text.tlog"], 2, "no telemetry log"),
        (vec!["replay", "nowhere.tlog"], 2, "nowhere.tlog"),
        (vec!["replay", ARDUROVER, "--proof"], 2, "not recorded by helmlink"),
        (vec!["replay", ARDUROVER, "--system", "77"], 2, "system 77"),
        (vec!["replay", ARDUROVER, "--boat", "raft"], 2, "no boat called"),
        (vec!["replay", ARDUROVER, "--out", "x.xlsx"], 2, ".csv"),
        (vec!["replay", ARDUROVER, "--to", "udpout:127.0.0.1:9"], 2, "--yes-send"),
        (vec!["replay", ARDUROVER, "--drive", "--to", "udpout:127.0.0.1:9"], 2, "--yes-send"),
        (vec!["replay", ARDUROVER, "--arm"], 2, "--drive"),
    ] {
        let run = helmlink(&folder, &arguments);
        assert_eq!(run.status.code(), Some(code), "{arguments:?}: {}", complaint(&run));
        assert!(complaint(&run).contains(words), "{arguments:?}: {}", complaint(&run));
    }
}

#[test]
fn a_log_is_played_to_a_link() {
    let folder = Folder::new("play");
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(std::time::Duration::from_secs(20))).unwrap();
    let url = format!("udpout:{}", socket.local_addr().unwrap());
    let player = std::thread::spawn(move || {
        let arguments =
            ["replay", ARDUROVER, "--to", &url, "--yes-send", "--speedup", "40", "--only", "ATTITUDE", "-q"];
        helmlink(&folder, &arguments)
    });
    let (mut buffer, mut framer) = (vec![0; 65_536], helmlink_wire::Framer::new());
    let mut attitudes = 0;
    while attitudes < 1000 {
        let length = socket.recv(&mut buffer).unwrap();
        framer.push(&buffer[..length]);
        framer.end_of_datagram();
        while let Some(frame) = framer.next_frame() {
            assert_eq!(frame.name(), Some("ATTITUDE"));
            attitudes += 1;
        }
    }
    let output = player.join().unwrap();
    assert!(output.status.success(), "{}", complaint(&output));
}
