//! Recordings as the programs leave them: `bridge` and `sitl` write them while they run, `replay` proves them, and other
//! people's programs read them.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use helmlink_wire::tlog::{Index, records};
use serde_json::Value;
use support::{Helmlink, Script};

/// Two legs of some 20 m.
const PLAN: &str = "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t63.4389\t10.399\t0\t1\n\
    1\t0\t3\t16\t0\t0\t0\t0\t63.4390\t10.399\t0\t1\n2\t0\t3\t16\t0\t0\t0\t0\t63.43912\t10.3992\t0\t1\n";
/// How much faster than real time: a machine that is busy for 0.2 s looks like a lost position.
const SPEEDUP: &str = "4";

/// A folder of its own that is gone afterwards.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("recordings").join(name);
        std::fs::remove_dir_all(&path).ok();
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn at(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    /// The only log in a folder in here.
    fn log(&self, name: &str) -> String {
        let entries = std::fs::read_dir(self.0.join(name)).unwrap().map(|entry| entry.unwrap().path());
        let logs: Vec<PathBuf> =
            entries.filter(|path| path.extension().is_some_and(|extension| extension == "tlog")).collect();
        assert_eq!(logs.len(), 1, "{logs:?}");
        logs[0].display().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            std::fs::remove_dir_all(&self.0).ok();
        }
    }
}

/// A boat with the mission on board, and a bridge that arms and drives it over TCP; both record.
fn under_way(folder: &Folder, output: &str) -> (Helmlink, Helmlink) {
    let (plan, of_boat, of_bridge) = (folder.at("plan.waypoints"), folder.at("boat"), folder.at("bridge"));
    std::fs::write(&plan, PLAN).unwrap();
    let world = ["--mission", &plan, "--speedup", SPEEDUP, "--record", &of_boat];
    let (boat, address) = Helmlink::sitl("tcpin", &world);
    let (url, state) = (format!("tcp:{address}"), folder.at("state"));
    let bridge = Helmlink::start(&[
        "bridge",
        "--connect",
        &url,
        "--output",
        output,
        "--engage",
        "--arm",
        "--once",
        "--record",
        &of_bridge,
        "--state-dir",
        &state,
    ]);
    (boat, bridge)
}

/// The same, driven to the end.
fn driven(name: &str, output: &str) -> Folder {
    let folder = Folder::new(name);
    let (boat, bridge) = under_way(&folder, output);
    bridge.into_process().succeed();
    boat.interrupt();
    boat.into_process().succeed();
    folder
}

/// What `helmlink` prints with `--json`.
fn json(arguments: &[&str]) -> Value {
    let printed = Helmlink::start(&[arguments, &["--json", "-q"]].concat()).into_process().succeed();
    serde_json::from_str(&printed).unwrap_or_else(|error| panic!("{error}: {printed}"))
}

/// Messages by type, as this project's own reader counts them.
fn types(log: &[u8]) -> BTreeMap<String, u64> {
    let mut types = BTreeMap::new();
    for record in records(log) {
        *types.entry(record.frame.name().unwrap().to_owned()).or_default() += 1;
    }
    types
}

/// The same, as another program counts them.
fn types_of(read: &Value) -> BTreeMap<String, u64> {
    let types = read["types"].as_object().unwrap();
    types.iter().map(|(name, count)| (name.clone(), count.as_u64().unwrap())).collect()
}

/// What another program makes of a log.
fn read_by(program: &str, log: &str) -> Value {
    serde_json::from_str(&Script::run("read_log.py", &[program, log])).unwrap()
}

/// Whole records from the first byte to the last.
fn assert_whole(log: &[u8]) {
    let index = Index::build(log).unwrap();
    let length: usize = records(log).map(|record| 8 + record.frame.bytes().len()).sum();
    assert_eq!((length, index.statistics.crc_errors), (log.len(), 0));
}

/// A drive of the bridge over TCP is proven by its recording.
fn is_proven(output: &str) {
    let folder = driven(&format!("proof-{output}"), output);
    let proof = json(&["replay", &folder.at("bridge"), "--proof"]);
    assert_eq!(proof["holds"], true, "{proof}");
    assert!(proof["commands"].as_u64() > Some(200), "{proof}");
    let digest = proof["commands_sha256"].as_str().unwrap();
    json(&["replay", &folder.at("bridge"), "--proof", "--expect", digest]);
    assert!(Path::new(&folder.log("bridge")).with_extension("report").join("report.html").exists());
}

#[test]
fn a_drive_with_overrides_is_proven() {
    is_proven("rc-override");
}

#[test]
fn a_drive_with_manual_control_is_proven() {
    is_proven("manual-control");
}

#[test]
fn a_drive_in_guided_is_proven() {
    is_proven("guided");
}

#[test]
fn a_drive_in_guided_with_velocities_is_proven() {
    is_proven("guided-velocity");
}

#[test]
fn other_programs_read_what_bridge_and_boat_record() {
    let folder = driven("others", "rc-override");
    for side in ["bridge", "boat"] {
        let path = folder.log(side);
        let log = std::fs::read(&path).unwrap();
        assert_whole(&log);
        let read = read_by("pymavlink", &path);
        let own = types(&log);
        assert_eq!(types_of(&read), own, "{side}");
        assert_eq!(types_of(&read_by("mavlogdump", &path)), own, "{side}");
        let stamps: Vec<f64> = records(&log).map(|record| record.time_us as f64 / 1e6).collect();
        let span = [&read["first_s"], &read["last_s"]].map(|stamp| stamp.as_f64().unwrap());
        assert!((span[0] - stamps[0]).abs() < 1e-3 && (span[1] - stamps[stamps.len() - 1]).abs() < 1e-3);
        // The bridge's commands are in both; what it thinks only in its own.
        let steering = own["RC_CHANNELS_OVERRIDE"];
        assert!(steering > 200, "{steering}");
        assert_eq!(read["steering"].as_u64(), Some(steering), "{side}");
        if side == "bridge" {
            assert!(read["states"].as_u64() > Some(200), "{read}");
            let names = read["names"].to_string();
            assert!(names.contains("HL_XTRACK") && names.contains("HL_D_U"), "{names}");
            assert!(read["texts"].to_string().contains("waypoint"), "{read}");
        }
    }
    mavproxy_follows(&folder.log("bridge"));
}

/// MAVProxy takes a recording that is played to it for a boat: it prints its modes and events.
fn mavproxy_follows(log: &str) {
    let to = "tcpin:127.0.0.1:0";
    let player = Helmlink::start(&["replay", log, "--to", to, "--yes-send", "--speedup", "4", "--loop"]);
    let line = player.wait_for_line("listening at ");
    let address = line.rsplit_once("listening at ").unwrap().1;
    let shown = ["AP: Throttle armed", "HOLD>", "DISARMED"];
    Script::run("read_log.py", &[&["mavproxy", &format!("tcp:{address}")], &shown[..]].concat());
    player.interrupt();
    player.into_process().succeed();
}

#[test]
fn what_a_boat_records_goes_through_the_controller() {
    let folder = driven("boat", "rc-override");
    let arguments = ["replay", &folder.at("boat"), "--mission", &folder.at("plan.waypoints"), "--no-report"];
    let result = json(&arguments);
    assert_eq!(result["recorded_rate"], 1.0, "stamped with the boat's own time: {result}");
    assert!(result["steps"].as_u64() > Some(50), "{result}");
    assert!(Path::new(&folder.log("boat")).with_extension("report").join("report.html").exists());
}

#[test]
fn a_recording_whose_program_is_killed_is_whole_up_to_its_end() {
    let folder = Folder::new("killed");
    let (mut boat, mut bridge) = under_way(&folder, "guided");
    bridge.wait_for_line("reached waypoint 1");
    bridge.kill();
    boat.kill();
    for side in ["bridge", "boat"] {
        let path = folder.log(side);
        let log = std::fs::read(&path).unwrap();
        let read = read_by("pymavlink", &path);
        assert_eq!(types_of(&read), types(&log), "{side}");
        let whole: usize = records(&log).map(|record| 8 + record.frame.bytes().len()).sum();
        assert!(log.len() - whole < 300, "{side}: {} of {} bytes", whole, log.len());
    }
    let proof = json(&["replay", &folder.at("bridge"), "--proof"]);
    assert_eq!(proof["holds"], true, "{proof}");
    assert!(proof["commands"].as_u64() > Some(20), "{proof}");
}

#[test]
fn a_recording_that_was_tampered_with_shows_its_first_difference() {
    let folder = Folder::new("tampered");
    let plan = folder.at("plan.waypoints");
    std::fs::write(&plan, PLAN).unwrap();
    json(&["simulate", &plan, "--report", &folder.at("run")]);
    let mut log = std::fs::read(folder.0.join("run/log.tlog")).unwrap();
    let commands: Vec<(usize, usize)> = records(&log)
        .filter(|record| record.frame.name() == Some("RC_CHANNELS_OVERRIDE"))
        .map(|record| (record.offset as usize + 8, record.frame.bytes().len()))
        .collect();
    let (at, length) = commands[100];
    let helmlink_wire::Message::RC_CHANNELS_OVERRIDE(mut command) =
        helmlink_wire::Frame::parse(&log[at..at + length]).unwrap().decode().unwrap()
    else {
        panic!("no override")
    };
    // One microsecond to starboard, in a frame that is right in itself.
    let frame = helmlink_wire::Frame::parse(&log[at..at + length]).unwrap();
    command.chan1_raw += 1;
    let message = helmlink_wire::Message::RC_CHANNELS_OVERRIDE(command);
    let forged = helmlink_wire::encoder::encode_numbered(
        frame.version(),
        frame.identity(),
        frame.sequence(),
        &message,
    );
    assert_eq!(forged.len(), length);
    log[at..at + length].copy_from_slice(&forged);
    std::fs::write(folder.0.join("run/log.tlog"), &log).unwrap();
    let ended = Helmlink::run(&["replay", &folder.at("run/log.tlog"), "--proof", "-q"]);
    assert_eq!(ended.status.code(), Some(1), "{}", ended.printed);
    for words in
        ["NOT the same", "recorded: link", "replayed: link", "RC_CHANNELS_OVERRIDE", "last step", "ALPHA"]
    {
        assert!(ended.printed.contains(words), "no `{words}` in: {}", ended.printed);
    }
}
