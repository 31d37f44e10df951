use std::time::Duration;

use helmlink_mission::plan::Mission;
use helmlink_sitl::{Sitl, SitlSettings};

use super::proof::{Proof, prove};
use super::recording::{Recording, RecordingError};
use crate::bridge::{Bridge, BridgeSettings};
use crate::control::{Boat, Controller};
use crate::simulation::ClosedLoop;
use crate::vehicle::OutputKind;

/// A simulated boat in a rough sea with poor sensors that drives two short legs, recorded.
fn recorded(controller: Controller, output: OutputKind) -> (String, Vec<u8>) {
    let home = helmlink_mission::geodesy::Geodetic::new(63.4389, 10.399);
    let frame = helmlink_mission::geodesy::LocalFrame::new(home);
    let items = [(25.0, 0.0), (40.0, 20.0)].map(|(north_m, east_m)| {
        let place = helmlink_mission::geodesy::NorthEast { north_m, east_m };
        helmlink_mission::plan::Item::waypoint(frame.to_geodetic(place))
    });
    let mission = Mission { home: Some(home), items: items.to_vec() };
    let hull = helmlink_sitl::physics::Hull::builtin("otter").unwrap();
    let mut settings = SitlSettings { home, ..SitlSettings::new(hull) };
    settings.sensors = "poor".parse().unwrap();
    let mut sitl = Sitl::new(settings).unwrap();
    sitl.set_mission(&mission.items).unwrap();
    let mut bridge = Bridge::new(BridgeSettings {
        controller,
        output,
        engage: true,
        may_arm: true,
        ..BridgeSettings::new(Boat::embedded("otter").unwrap())
    });
    bridge.keep_journal(0);
    let mut run = ClosedLoop::new(sitl, bridge, home);
    let outcome = run.run(Duration::from_secs(200));
    assert!(outcome.completed, "{:?}", outcome.complaint);
    (outcome.commands_sha256, run.into_recorder().1)
}

fn proof(log: &[u8]) -> Result<Proof, RecordingError> {
    prove(Recording::open(log)?)
}

/// A recording of every controller with this output replays byte for byte.
fn replays_with_every_controller(output: OutputKind) {
    for controller in Controller::ALL {
        let (commands_sha256, log) = recorded(controller, output);
        let proof = proof(&log).unwrap();
        assert!(proof.holds(), "{controller} {output}: {}", proof.difference.unwrap().text());
        let digests = (&proof.recorded_sha256, &proof.replayed_sha256);
        assert_eq!(digests, (&commands_sha256, &commands_sha256), "{controller} {output}");
        assert!(
            proof.commands > 200 && proof.steps >= proof.commands / 2,
            "{controller} {output}: {proof:?}"
        );
    }
}

// One test an output, so that they run side by side.

#[test]
fn overrides_of_every_controller_replay_byte_for_byte() {
    replays_with_every_controller(OutputKind::RcOverride);
}

#[test]
fn manual_control_of_every_controller_replays_byte_for_byte() {
    replays_with_every_controller(OutputKind::ManualControl);
}

#[test]
fn guided_attitudes_of_every_controller_replay_byte_for_byte() {
    replays_with_every_controller(OutputKind::Guided);
}

#[test]
fn guided_velocities_of_every_controller_replay_byte_for_byte() {
    replays_with_every_controller(OutputKind::GuidedVelocity);
}

#[test]
fn another_gain_is_found_at_its_first_frame() {
    let (_, log) = recorded(Controller::default(), OutputKind::RcOverride);
    let at = log.windows(13).position(|bytes| bytes == b"heading_gain ").unwrap();
    let digit = at + log[at..].iter().position(u8::is_ascii_digit).unwrap();
    let mut tampered = log.clone();
    // Same length, another value; the checksum of its frame is made right again.
    tampered[digit] = if tampered[digit] == b'1' { b'2' } else { b'1' };
    let tampered = with_right_checksums(&log, tampered);
    let difference = proof(&tampered).unwrap().difference.unwrap();
    assert!(difference.recorded.is_some() && difference.replayed.is_some());
    let text = difference.text();
    assert!(text.contains("RC_CHANNELS_OVERRIDE") && text.contains("ALPHA_R"), "{text}");
}

/// `tampered`, which differs from `log` in payload bytes only, with the checksums of its frames put right.
fn with_right_checksums(log: &[u8], tampered: Vec<u8>) -> Vec<u8> {
    let mut out = Vec::with_capacity(log.len());
    let mut at = 0;
    let mut encoders = helmlink_wire::Encoder::new();
    for record in helmlink_wire::tlog::records(log) {
        let end = at + 8 + record.frame.bytes().len();
        if tampered[at..end] == log[at..end] {
            out.extend_from_slice(&log[at..end]);
        } else {
            let helmlink_wire::Message::TUNNEL(mut data) = record.frame.decode().unwrap() else { panic!() };
            data.payload[..usize::from(data.payload_length)]
                .copy_from_slice(&tampered[at + 23..at + 23 + usize::from(data.payload_length)]);
            out.extend_from_slice(&log[at..at + 8]);
            encoders.encode(record.frame.identity(), &helmlink_wire::Message::TUNNEL(data), &mut out);
        }
        at = end;
    }
    out
}

#[test]
fn a_cut_recording_is_proven_up_to_the_cut_and_a_hole_is_explained() {
    let (_, log) = recorded(Controller::default(), OutputKind::Guided);
    for share in [2, 3, 7] {
        let cut = proof(&log[..log.len() - log.len() / share]).unwrap();
        assert!(cut.holds() && cut.frames > 0, "{:?}", cut.difference.map(|difference| difference.text()));
    }
    let holed = [&log[..log.len() / 2], &log[log.len() / 2 + 3000..]].concat();
    let complaint = proof(&holed).unwrap_err();
    assert!(matches!(complaint, RecordingError::Gap { .. } | RecordingError::Torn(_)), "{complaint}");
}

#[test]
fn other_logs_are_no_recordings() {
    let log: &[u8] = include_bytes!("../../tests/data/ardurover-4.6-motorboat.tlog");
    assert!(matches!(proof(log), Err(RecordingError::NotARecording)));
    assert!(matches!(proof(&[]), Err(RecordingError::NotARecording)));
}
