//! However the bridge is asked to end, and whatever it steers with: the boat is stopped and let go first.

use std::path::Path;

use helmlink_wire::tlog::records;
use helmlink_wire::{Message, enums};

use crate::support::process::Process;
use crate::support::{Folder, Helmlink};

const PLAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/short-survey.waypoints");

/// ArduRover's mode in which the sticks count.
const MANUAL: u32 = 0;
/// ArduRover's mode in which the motors are off.
const HOLD: u32 = 4;

/// What a bridge has sent to steer the boat, in order, and the mode that the boat was in at the end.
struct Drive {
    steering: Vec<Message>,
    mode: u32,
}

impl Drive {
    /// Drives with `output`, and is asked to end under way.
    fn ended_by(output: &str, ask: fn(&Process)) -> Self {
        let folder = Folder::new(&format!("exit-{output}"));
        let options = ["--mission", PLAN, "--home", "63.442,10.395,20", "--speedup", "3"];
        let (_boat, address) = Helmlink::sitl("tcpin", &options);
        let connect = format!("tcp:{address}");
        let bridge = ["bridge", "--connect", &connect, "--engage", "--arm", "--state-dir", folder.path()];
        let bridge =
            Helmlink::start(&[&bridge[..], &["--output", output, "--record", folder.path()]].concat());
        bridge.wait_for_line("reached waypoint 1");
        ask(&bridge);
        bridge.into_process().succeed();
        Self::read(&folder.file(".tlog"))
    }

    fn read(log: &Path) -> Self {
        let bytes = std::fs::read(log).unwrap();
        let mut drive = Self { steering: Vec::new(), mode: u32::MAX };
        for message in records(&bytes).filter_map(|record| record.frame.decode().ok()) {
            match message {
                Message::HEARTBEAT(beat) if beat.autopilot == enums::MAV_AUTOPILOT_ARDUPILOTMEGA => {
                    drive.mode = beat.custom_mode;
                }
                Message::RC_CHANNELS_OVERRIDE(_)
                | Message::MANUAL_CONTROL(_)
                | Message::SET_ATTITUDE_TARGET(_)
                | Message::SET_POSITION_TARGET_LOCAL_NED(_) => drive.steering.push(message),
                _ => {}
            }
        }
        drive
    }

    /// Driven, then stopped; the sticks, where they were taken, given back. A mode that the bridge chose does not outlive
    /// it; MANUAL was the boat's own.
    fn assert_let_go(&self, uses_sticks: bool) {
        let (released, driven): (Vec<_>, Vec<_>) =
            self.steering.iter().partition(|message| off_rest(message).is_none());
        assert_eq!(!released.is_empty(), uses_sticks, "{released:?}");
        assert!(driven.iter().any(|message| off_rest(message) != Some(0.0)), "it has not driven");
        assert_eq!(off_rest(driven[driven.len() - 1]), Some(0.0), "the last word was not to stop");
        if uses_sticks {
            let last = &self.steering[self.steering.len() - released.len()..];
            assert!(
                last.iter().all(|message| off_rest(message).is_none()),
                "not released at the end: {last:?}"
            );
        }
        assert_eq!(self.mode, if uses_sticks { MANUAL } else { HOLD });
    }
}

/// How far from rest a frame puts throttle and steering together; none when it gives them back.
fn off_rest(message: &Message) -> Option<f64> {
    match message {
        Message::RC_CHANNELS_OVERRIDE(data) if (data.chan1_raw, data.chan3_raw) == (0, 0) => None,
        Message::RC_CHANNELS_OVERRIDE(data) => Some(
            [data.chan1_raw, data.chan3_raw].iter().map(|pulse| (f64::from(*pulse) - 1500.0).abs()).sum(),
        ),
        Message::MANUAL_CONTROL(data) => Some(f64::from(data.y).abs() + f64::from(data.z).abs()),
        Message::SET_ATTITUDE_TARGET(data) => {
            Some(f64::from(data.thrust).abs() + f64::from(data.body_yaw_rate).abs())
        }
        Message::SET_POSITION_TARGET_LOCAL_NED(data) => {
            Some(f64::from(data.vx).abs() + f64::from(data.vy).abs() + f64::from(data.yaw_rate).abs())
        }
        _ => unreachable!("no steering frame"),
    }
}

#[test]
fn ended_by_the_service_manager_with_overrides() {
    Drive::ended_by("rc-override", Process::terminate).assert_let_go(true);
}

#[test]
fn ended_by_its_terminal_going_away_with_manual_control() {
    Drive::ended_by("manual-control", Process::hang_up).assert_let_go(true);
}

#[test]
fn ended_by_the_service_manager_in_guided() {
    Drive::ended_by("guided", Process::terminate).assert_let_go(false);
}

#[test]
fn ended_by_ctrl_c_in_guided_with_velocities() {
    Drive::ended_by("guided-velocity", Process::interrupt).assert_let_go(false);
}
