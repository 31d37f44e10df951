use helmlink_wire::dialect::{COMMAND_LONG_DATA, MessageData, SETUP_SIGNING_DATA};
use helmlink_wire::signing::{SigningKey, Unsigned};
use helmlink_wire::{Encoder, Framer};

use super::*;
use crate::autopilot::testing::{Bench, GCS, LINK, OTHER_LINK};

fn key() -> SigningKey {
    SigningKey::from_passphrase("a passphrase for tests")
}

/// A client's time: later than the simulated boat's own.
fn now() -> Timestamp {
    Timestamp::from_unix(Duration::from_secs(1_800_000_000))
}

fn setup(key: [u8; 32]) -> Message {
    Message::SETUP_SIGNING(SETUP_SIGNING_DATA {
        initial_timestamp: now().units(),
        target_system: 1,
        target_component: 1,
        secret_key: key,
    })
}

fn question() -> Message {
    Message::COMMAND_LONG(COMMAND_LONG_DATA {
        command: 520,
        target_system: 1,
        target_component: 1,
        ..COMMAND_LONG_DATA::DEFAULT
    })
}

/// Sends a message signed by a client with `signing`, and counts the acknowledgements and the frames of the
/// boat that the client does not trust.
fn ask(bench: &mut Bench, signing: &mut Signing, message: &Message) -> (usize, usize) {
    let mut bytes = Vec::new();
    Encoder::new().encode(GCS, message, &mut bytes);
    signing.sign(1, &mut bytes, 0);
    bench.on_bytes(LINK, &bytes);
    let end = bench.now() + LOOP;
    bench.advance(end);
    let (mut acknowledged, mut distrusted) = (0, 0);
    let mut framer = Framer::new();
    while let Some((link, bytes)) = bench.poll_transmit() {
        if link != LINK {
            continue;
        }
        framer.push(&bytes);
        while let Some(frame) = framer.next_frame() {
            distrusted += usize::from(signing.check(&frame, Unsigned::Refused).is_err());
            acknowledged += usize::from(frame.message_id() == helmlink_wire::dialect::COMMAND_ACK_DATA::ID);
        }
    }
    (acknowledged, distrusted)
}

#[test]
fn with_a_key_only_signed_frames_count_and_all_answers_are_signed() {
    let mut bench = Bench::ready();
    bench.send(LINK, GCS, &setup(*key().bytes()));
    let sent = bench.run_loops(1);
    assert!(
        !sent[&OTHER_LINK].iter().any(|each| matches!(each, Message::SETUP_SIGNING(_))),
        "a key stays secret"
    );
    bench.send(LINK, GCS, &question());
    let sent = bench.run_loops(5);
    assert!(!sent[&LINK].iter().any(|each| matches!(each, Message::COMMAND_ACK(_))), "unsigned, unanswered");
    let mut client = Signing::new(key(), now());
    assert_eq!(ask(&mut bench, &mut client, &question()), (1, 0));
    let mut stranger = Signing::new(SigningKey::from_passphrase("another one"), now());
    assert_eq!(ask(&mut bench, &mut stranger, &question()).0, 0);
    // A key of zeroes ends it, if a friend says so.
    ask(&mut bench, &mut client, &setup([0; 32]));
    bench.send(LINK, GCS, &question());
    let sent = bench.run_loops(1);
    assert!(sent[&LINK].iter().any(|each| matches!(each, Message::COMMAND_ACK(_))));
}

#[test]
fn a_boat_may_be_started_with_a_key_and_keeps_it_while_armed() {
    let settings = AutopilotSettings { signing: Some((key(), now())), ..AutopilotSettings::default() };
    let mut bench = Bench::new(settings);
    bench.run_s(3.0);
    let mut client = Signing::new(key(), now().later(Duration::from_secs(3)));
    assert_eq!(ask(&mut bench, &mut client, &question()).0, 1);
    bench.arm();
    ask(&mut bench, &mut client, &setup([0; 32]));
    bench.send(LINK, GCS, &question());
    let sent = bench.run_loops(1);
    assert!(!sent[&LINK].iter().any(|each| matches!(each, Message::COMMAND_ACK(_))));
}
