//! What a bridge has done in trouble can be proven from its recording.

use super::matrix::{break_it, decision_s, rig};
use super::rig::*;
use crate::pilot::failsafe::DEFINITIONS;
use crate::pilot::supervisor::Request;
use crate::replay::proof::{Proof, prove};
use crate::replay::recording::Recording;
use crate::vehicle::OutputKind;

/// The recording of a rig, replayed: every frame must be the same.
fn proven(mut rig: Rig, what: &str) -> Proof {
    let mut log = rig.bridge().take_journal();
    log.extend(rig.bridge().finish_journal());
    let proof = prove(Recording::open(log.as_slice()).unwrap()).unwrap();
    assert!(proof.holds(), "{what}: {}", proof.difference.unwrap().text());
    assert_eq!(proof.recorded_sha256, rig.bridge().commands_digest().0, "{what}");
    assert!(proof.commands > 20, "{what}: {} commands", proof.commands);
    proof
}

/// Every failsafe trips with every `nth` output, and the recording of it replays byte for byte.
fn every_fault_replays(nth: usize) {
    for (number, definition) in DEFINITIONS.iter().enumerate() {
        let output = OutputKind::ALL[(number + nth) % OutputKind::ALL.len()];
        let mut rig = rig(definition.failsafe, definition.action, Setup::recorded(output));
        break_it(&mut rig, definition.failsafe);
        rig.run(decision_s(definition.failsafe) + 2.0);
        proven(rig, &format!("{}, {output}", definition.key));
    }
}

#[test]
fn a_recording_of_every_fault_replays_byte_for_byte() {
    every_fault_replays(0);
}

#[test]
fn a_recording_of_every_fault_with_another_output_replays_byte_for_byte() {
    every_fault_replays(1);
}

#[test]
fn noise_on_the_line_and_the_user_at_the_console_replay_byte_for_byte() {
    let mut rig = Rig::under_way(Setup::recorded(OutputKind::RcOverride), |_| {});
    let now = rig.now;
    rig.bridge().link_up(now, DIRECT);
    for (length, is_datagram) in [(3, false), (0, false), (700, true), (0, true), (41, false)] {
        let noise: Vec<u8> = (0..length).map(|index| (index * 37 % 251) as u8).chain([0xFD, 9]).collect();
        let now = rig.now;
        rig.bridge().on_bytes(now, DIRECT, &noise, is_datagram);
        rig.run(0.3);
    }
    for request in [Request::Pause, Request::Engage { patient: false }, Request::LetGo] {
        let now = rig.now;
        rig.bridge().request(now, request).ok();
        rig.run(3.0);
    }
    let now = rig.now;
    rig.bridge().set_recording_failed(now, true);
    rig.bridge().link_down(now, DIRECT);
    rig.run(1.0);
    assert!(proven(rig, "noise").calls > 100);
}
