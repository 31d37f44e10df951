//! The bridge's own parameters, set over MAVLink: what outlives the bridge, however it ends.

use std::fs;
use std::path::Path;

use helmlink_wire::dialect::{COMMAND_LONG_DATA, CharArray, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA};
use helmlink_wire::{Message, enums};

use crate::support::correspondent::{BOAT, BRIDGE, STATION, boat_heartbeat};
use crate::support::{Correspondent, Folder, Helmlink, Script};

/// A gain of the controller.
const GAIN: &str = "HL_R_K";

/// A bridge with its state in a folder, and somebody who is boat and ground station at once.
struct Scene {
    bridge: Helmlink,
    station: Correspondent,
}

impl Scene {
    fn new(folder: &Folder) -> Self {
        let state = ["--state-dir", folder.path()];
        let arguments = ["bridge", "--connect", "udpin:127.0.0.1:0", "--wait", "0"];
        let bridge = Helmlink::start(&[&arguments[..], &state].concat());
        let mut station = Correspondent::of(&bridge.wait_for_place());
        station.say(BOAT, &boat_heartbeat());
        bridge.wait_for_line("found the flight controller");
        Self { bridge, station }
    }

    /// What the bridge says the parameter is at.
    fn value(&mut self, name: &str) -> f32 {
        self.station.say(
            STATION,
            &Message::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
                target_system: BRIDGE.system,
                target_component: BRIDGE.component,
                param_id: CharArray::from(name),
                param_index: -1,
            }),
        );
        self.hear_value(name)
    }

    fn hear_value(&mut self, name: &str) -> f32 {
        self.station.hear_bridge(name, |message| match message {
            Message::PARAM_VALUE(data) if data.param_id.to_str() == Ok(name) => Some(data.param_value),
            _ => None,
        })
    }

    fn set(&mut self, name: &str, param_value: f32) {
        self.station.say(
            STATION,
            &Message::PARAM_SET(PARAM_SET_DATA {
                target_system: BRIDGE.system,
                target_component: BRIDGE.component,
                param_id: CharArray::from(name),
                param_value,
                param_type: enums::MAV_PARAM_TYPE_REAL32,
            }),
        );
    }

    /// Everything back to the factory values; returns the answer.
    fn reset(&mut self) -> u8 {
        let command = COMMAND_LONG_DATA {
            target_system: BRIDGE.system,
            target_component: BRIDGE.component,
            command: enums::MAV_CMD_PREFLIGHT_STORAGE,
            param1: 2.0,
            ..COMMAND_LONG_DATA::DEFAULT
        };
        self.station.say(STATION, &Message::COMMAND_LONG(command));
        self.station.hear_bridge("the acknowledgement", |message| match message {
            Message::COMMAND_ACK(data) if data.command == enums::MAV_CMD_PREFLIGHT_STORAGE => {
                Some(data.result)
            }
            _ => None,
        })
    }

    /// Waits until the file says that the parameter is at this value, or at its factory value where it is none.
    fn until_kept(&self, folder: &Folder, value: Option<f32>) {
        let deadline = std::time::Instant::now() + crate::support::process::PATIENCE;
        while parameters(folder) != Some(value) {
            assert!(std::time::Instant::now() < deadline, "not kept: {}", self.bridge.printed());
            std::thread::yield_now();
        }
    }
}

/// What the file says of the gain; none where there is no file yet. The file has to be whole.
fn parameters(folder: &Folder) -> Option<Option<f32>> {
    let mut paths = fs::read_dir(&folder.0).unwrap().map(|entry| entry.unwrap().path());
    let path = paths.find(|path| path.extension().is_some_and(|extension| extension == "parm"))?;
    Some(gain_in(&path))
}

fn gain_in(path: &Path) -> Option<f32> {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.starts_with("# ") && text.ends_with('\n'), "cut off: {text:?}");
    let mut values =
        text.lines().filter_map(|line| line.strip_prefix(GAIN)).map(|value| value.trim().parse());
    values.next().map(|value| value.unwrap())
}

#[test]
fn parameters_are_kept_refused_and_reset_across_restarts() {
    let folder = Folder::new("parameters");
    let mut scene = Scene::new(&folder);
    let factory = scene.value(GAIN);
    let tuned = 1.5 * factory;
    scene.set(GAIN, tuned);
    assert_eq!(scene.hear_value(GAIN), tuned);
    scene.until_kept(&folder, Some(tuned));
    scene.bridge.kill();

    let mut scene = Scene::new(&folder);
    assert_eq!(scene.value(GAIN), tuned, "after a restart");
    scene.set(GAIN, 1e6);
    let refusal = scene.station.hear_bridge("a refusal", |message| match message {
        Message::PARAM_ERROR(data) => Some(data.error),
        _ => None,
    });
    assert_eq!(refusal, enums::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE);
    assert_eq!(scene.hear_value(GAIN), tuned, "refused, and still told");
    scene.bridge.wait_for_line("not set: ");
    assert_eq!(scene.reset(), enums::MAV_RESULT_ACCEPTED);
    assert_eq!(scene.value(GAIN), factory, "reset");
    scene.until_kept(&folder, None);
    scene.bridge.kill();

    assert_eq!(Scene::new(&folder).value(GAIN), factory, "after the reset and a restart");
}

#[test]
fn a_bridge_killed_while_it_writes_leaves_the_old_file_or_the_new_one() {
    let folder = Folder::new("parameters-killed");
    let mut scene = Scene::new(&folder);
    let mut value = scene.value(GAIN);
    for round in 0..8 {
        // So many changes that the kill finds the writer at work.
        let from = value;
        for step in 1..=20 {
            value = from + 0.01 * step as f32;
            scene.set(GAIN, value);
        }
        scene
            .station
            .hear_bridge("an echo", |message| matches!(message, Message::PARAM_VALUE(_)).then_some(()));
        scene.bridge.kill();
        let kept = parameters(&folder);
        scene = Scene::new(&folder);
        value = scene.value(GAIN);
        if let Some(Some(kept)) = kept {
            assert_eq!(value, kept, "round {round}");
        }
        assert!(!scene.bridge.printed().contains("saved parameter left out"), "{}", scene.bridge.printed());
    }
}

#[test]
fn ground_stations_read_ranges_and_meanings() {
    let (_boat, address) = Helmlink::sitl("tcpin", &[]);
    let connect = format!("tcp:{address}");
    let folder = Folder::new("metadata");
    let bridge = Helmlink::start(&[
        "bridge",
        "--connect",
        &connect,
        "--gcs",
        "udpin:127.0.0.1:0",
        "--state-dir",
        folder.path(),
    ]);
    let place = bridge.wait_for_place();
    bridge.wait_for_line("found the flight controller");
    let printed = Script::run("metadata.py", &[&place, folder.path()]);
    assert!(printed.contains("parameters described, to pymavlink and to MAVSDK"), "{printed}");
}
