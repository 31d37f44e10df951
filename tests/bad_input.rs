//! What users get wrong: each mistake gets one clear line that names the cause and the fix, and the right exit code.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::io::Write;
use std::net::{TcpListener, UdpSocket};
use std::path::PathBuf;

use helmlink_wire::dialect::HEARTBEAT_DATA;
use helmlink_wire::{Encoder, Identity, Message, enums};
use support::Helmlink;

/// Exit code for wrong usage or input.
const USAGE: i32 = 2;
/// Exit code when there is no link.
const NO_LINK: i32 = 3;
/// Where nobody listens.
const NOWHERE: &str = "tcp:127.0.0.1:9";
/// Head of a mission file, with home.
const HEAD: &str = "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t63.442\t10.395\t0\t1\n";

/// Runs `helmlink`, which has to refuse with this exit code and one line that has all these words in it.
#[track_caller]
fn refused(arguments: &[&str], exit_code: i32, words: &[&str]) {
    let ended = Helmlink::run(arguments);
    let said = &ended.printed;
    assert_eq!(ended.status.code(), Some(exit_code), "{arguments:?}: {said}");
    assert_eq!(said.lines().count(), 1, "one line for {arguments:?}, not: {said}");
    for word in [&["helmlink: "], words].concat() {
        assert!(said.contains(word), "{arguments:?}: no `{word}` in: {said}");
    }
}

/// A file with this text.
fn file(name: &str, text: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("bad-input");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// A mission whose second item is `item`: command, latitude and longitude as they stand in the file.
fn mission(name: &str, (command, latitude, longitude): (u16, &str, &str)) -> String {
    let second = format!("2\t0\t3\t{command}\t0\t2\t0\t0\t{latitude}\t{longitude}\t0\t1\n");
    file(name, &format!("{HEAD}1\t0\t3\t16\t0\t2\t0\t0\t63.4422\t10.3952\t0\t1\n{second}"))
}

#[test]
fn wrong_urls() {
    for (url, words) in [
        ("127.0.0.1", &["has no scheme", "udpin:"][..]),
        ("udp:127.0.0.1:14550", &["udpin:127.0.0.1:14550", "udpout:127.0.0.1:14550"]),
        ("http://127.0.0.1:80", &["`http` is not a transport", "tcpout"]),
        ("tcp:127.0.0.1", &["port is missing", "tcpout:127.0.0.1:PORT"]),
        ("tcp:127.0.0.1:99999", &["`99999` is not a port", "65535"]),
        ("serial:/dev/ttyS0:fast", &["`fast` is not a serial rate", "57600"]),
    ] {
        refused(&["bridge", "--connect", url], USAGE, words);
        refused(&["sitl", "--listen", url], USAGE, words);
    }
    let unknown = "udpin:no.such.host.invalid:14550";
    refused(&["bridge", "--quiet", "--connect", unknown], USAGE, &["no.such.host.invalid", "check the name"]);
}

#[test]
fn a_port_in_use() {
    let tcp = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = tcp.local_addr().unwrap().port().to_string();
    let url = format!("tcpin:127.0.0.1:{port}");
    refused(&["sitl", "--quiet", "--listen", &url], USAGE, &[&port, "already in use", "choose another port"]);
    let udp = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = udp.local_addr().unwrap().port().to_string();
    let url = format!("udpin:127.0.0.1:{port}");
    refused(
        &["bridge", "--quiet", "--connect", &url],
        USAGE,
        &[&port, "already in use", "choose another port"],
    );
}

#[test]
fn no_heartbeat_in_time() {
    for url in [NOWHERE, "udpin:127.0.0.1:0", "serial:/dev/no-such-device:115200"] {
        let arguments = ["bridge", "--quiet", "--connect", url, "--wait", "0.2"];
        let ended = Helmlink::run(&arguments);
        assert_eq!(ended.status.code(), Some(NO_LINK), "{}", ended.printed);
        let last = ended.printed.lines().last().unwrap_or_default();
        for word in
            ["helmlink: no heartbeat of a flight controller", "0.2 s", "check that it is powered", "--wait"]
        {
            assert!(last.contains(word), "no `{word}` in: {}", ended.printed);
        }
    }
    for wait in ["nan", "inf", "1e30"] {
        refused(&["bridge", "--connect", NOWHERE, "--wait", wait], USAGE, &["--wait", "seconds"]);
    }
}

/// A flight controller of another kind.
fn heartbeat(mavtype: u8, autopilot: u8) -> Vec<u8> {
    let (mut encoder, mut bytes) = (Encoder::new(), Vec::new());
    let message = HEARTBEAT_DATA { mavtype, autopilot, mavlink_version: 3, ..HEARTBEAT_DATA::DEFAULT };
    encoder.encode(Identity { system: 1, component: 1 }, &Message::HEARTBEAT(message), &mut bytes);
    bytes
}

#[test]
fn a_vehicle_that_is_no_boat() {
    for (mavtype, autopilot) in [
        (enums::MAV_TYPE_QUADROTOR, enums::MAV_AUTOPILOT_ARDUPILOTMEGA),
        (enums::MAV_TYPE_SURFACE_BOAT, enums::MAV_AUTOPILOT_PX4),
    ] {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("tcp:{}", listener.local_addr().unwrap());
        let bridge = Helmlink::start(&["bridge", "--quiet", "--connect", &url]);
        let (mut stream, _) = listener.accept().unwrap();
        stream.write_all(&heartbeat(mavtype, autopilot)).unwrap();
        let ended = bridge.into_process().wait();
        assert_eq!(ended.status.code(), Some(USAGE), "{}", ended.printed);
        let last = ended.printed.lines().last().unwrap_or_default();
        for word in ["helmlink: system 1 is no boat or rover", &format!("MAV_TYPE {mavtype}"), "FRAME_CLASS"]
        {
            assert!(last.contains(word), "no `{word}` in: {}", ended.printed);
        }
    }
}

#[test]
fn missions_that_cannot_be_read() {
    for (path, words) in [
        ("no-such.waypoints".to_owned(), &["cannot read no-such.waypoints"][..]),
        (env!("CARGO_MANIFEST_DIR").to_owned(), &["cannot read"]),
        (file("empty.waypoints", ""), &["QGC WPL 110", "save the mission again"]),
        (file("text.waypoints", "Dear diary\n"), &["Dear diary", "save the mission again"]),
        (file("cut.plan", "{ \"fileType\": "), &["save the mission again"]),
        (file("no-items.waypoints", "QGC WPL 110\n"), &["no items", "at least one waypoint"]),
        (file("home-only.waypoints", HEAD), &["no items", "at least one waypoint"]),
    ] {
        every_command_refuses(&path, words);
    }
}

#[test]
fn missions_that_cannot_be_driven() {
    for (name, item, words) in [
        ("spline", (82, "63.4423", "10.3953"), &["item 2", "MAV_CMD_NAV_SPLINE_WAYPOINT", "take it out"][..]),
        ("unknown", (60_000, "63.4423", "10.3953"), &["item 2", "60000", "take it out"]),
        (
            "far",
            (16, "18.4", "10.3953"),
            &["item 2", "5002 km from home", "check its latitude and longitude"],
        ),
        ("not-a-number", (16, "nan", "10.3953"), &["line 4", "latitude", "nan"]),
        ("infinite", (16, "63.4423", "inf"), &["line 4", "longitude", "inf"]),
        ("zero", (16, "0", "0"), &["line 4", "both 0", "correct the position"]),
        ("off-the-earth", (16, "95", "10.3953"), &["line 4", "95", "90"]),
    ] {
        every_command_refuses(&mission(&format!("{name}.waypoints"), item), words);
    }
}

/// Whoever reads a mission refuses this one.
#[track_caller]
fn every_command_refuses(path: &str, words: &[&str]) {
    refused(&["simulate", path], USAGE, words);
    refused(&["bridge", "--connect", NOWHERE, "--mission", path], USAGE, words);
    refused(&["sitl", "--listen", "tcpin:127.0.0.1:0", "--mission", path], USAGE, words);
}

#[test]
fn options_that_make_no_sense() {
    let bridge = |option: &'static str, value: &'static str| ["bridge", "--connect", NOWHERE, option, value];
    let sitl =
        |option: &'static str, value: &'static str| ["sitl", "--listen", "tcpin:127.0.0.1:0", option, value];
    for (arguments, words) in [
        (bridge("--rate", "1000"), &["--rate", "1000", "2 to 50 Hz"][..]),
        (bridge("--rate", "nan"), &["--rate", "2 to 50 Hz"]),
        (bridge("--boat", "tanker"), &["tanker", "otter"]),
        (bridge("--speed", "99"), &["--speed", "0.1", "for boat otter"]),
        (bridge("--speed", "nan"), &["--speed", "0.1"]),
        (bridge("--output", "sails"), &["sails", "rc-override"]),
        (bridge("--end-mode", "SLEEP"), &["SLEEP", "HOLD"]),
        (bridge("--record", "/proc/nowhere"), &["--record", "/proc/nowhere"]),
        (sitl("--home", "0,0"), &["--home 0,0", "both 0", "63.4389,10.399"]),
        (sitl("--home", "nan,10"), &["--home nan,10", "LAT,LON"]),
        (sitl("--boat", "tanker"), &["tanker", "otter"]),
        (sitl("--speedup", "0"), &["--speedup", "'0'", "choose 0.01 to 1000", "max"]),
        (sitl("--speedup", "nan"), &["--speedup", "choose"]),
        (sitl("--sea", "hurricane"), &["hurricane", "rough"]),
        (sitl("--current", "fast"), &["fast", "0.3@90"]),
    ] {
        refused(&arguments, USAGE, words);
    }
    let shadow = ["bridge", "--connect", NOWHERE, "--shadow"];
    refused(&shadow, USAGE, &["--shadow sends nothing", "--mission FILE"]);
}

#[test]
fn commands_that_do_not_exist() {
    refused(&["sail"], USAGE, &["sail", "--help"]);
    refused(&["bridge"], USAGE, &["--connect", "--help"]);
    refused(&["simulate"], USAGE, &["MISSION", "--help"]);
    refused(&["sitl", "--spedup", "2"], USAGE, &["--spedup", "--speedup"]);
}

#[test]
fn configuration_files() {
    let config = |name: &str, text: &str| file(name, &format!("[bridge]\nconnect = \"{NOWHERE}\"\n{text}"));
    for (path, words) in [
        (
            config("typing-error.toml", "rate = 20\nspeeed = 1.2\n"),
            &["line 4", "`speeed` is not an option"][..],
        ),
        (config("not-a-number.toml", "rate = \"fast\"\n"), &["fast", "--rate"]),
        (config("table.toml", "[brigde]\n"), &["line 3", "`brigde` is not a subcommand"]),
        (config("cut.toml", "[sitl\n"), &["line 3", "is not TOML"]),
        ("no-such.toml".to_owned(), &["cannot read the configuration no-such.toml"]),
    ] {
        let ended = Helmlink::run(&["bridge", "--config", &path]);
        assert_eq!(ended.status.code(), Some(USAGE), "{}", ended.printed);
        for word in words {
            assert!(ended.printed.contains(word), "no `{word}` in: {}", ended.printed);
        }
    }
}

#[test]
fn a_dry_run_shows_every_setting_and_touches_nothing() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("bad-input/never-made");
    let config = file("good.toml", &format!("[bridge]\nconnect = \"{NOWHERE}\"\nrate = 20\n"));
    let record = folder.to_str().unwrap();
    let ended = Helmlink::run(&["bridge", "--config", &config, "--record", record, "--dry-run"]);
    assert!(ended.status.success(), "{}", ended.printed);
    for (setting, value, origin) in [
        ("connect", NOWHERE, "configuration file"),
        ("rate", "20", "configuration file"),
        ("record", record, "command line"),
        ("output", "rc-override", "default"),
    ] {
        let line = ended.printed.lines().find(|line| line.split_whitespace().next() == Some(setting));
        let line = line.unwrap_or_else(|| panic!("no {setting} in: {}", ended.printed));
        assert!(line.contains(value) && line.contains(origin), "{line}");
    }
    assert!(!folder.exists());
}
