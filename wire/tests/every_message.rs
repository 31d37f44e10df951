//! Every message of the dialect through encoder, framer and decoder; frames of other implementations.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use helmlink_wire::dialect::{
    COMMAND_ACK_DATA, COMMAND_LONG_DATA, CharArray, HEARTBEAT_DATA, Message, MessageSet, STATUSTEXT_DATA,
};
use helmlink_wire::{DecodeError, EncodeError, Encoder, Frame, FrameError, Framer, Identity, Version};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const BOAT: Identity = Identity { system: 1, component: 1 };
const STATION: Identity = Identity { system: 255, component: 190 };

fn heartbeat() -> Message {
    Message::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode: 15,
        mavtype: 11,
        autopilot: 3,
        base_mode: 81,
        system_status: 4,
        mavlink_version: 3,
    })
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

/// The encoder with `sequence` as its next number for `from`.
fn encoder_at(from: Identity, sequence: u8) -> Encoder {
    let mut encoder = Encoder::new();
    (0..sequence).for_each(|_| encoder.encode(from, &heartbeat(), &mut Vec::new()));
    encoder
}

fn framed(bytes: &[u8]) -> Message {
    let mut framer = Framer::new();
    framer.push(bytes);
    let message = framer.next_frame().expect("a whole frame").decode().expect("a known message");
    assert_eq!(framer.next_frame(), None);
    message
}

// Made with pymavlink 2.4.50.
const HEARTBEAT_V2: &str = "fd0900000701010000000f0000000b035104030b24";
const HEARTBEAT_V1: &str = "fe09070101000f0000000b035104035525";
const COMMAND_LONG: &str =
    "fd200000c8ffbe4c00000000803f000000000000000000000000000000000000000000000000900101011a76";
const COMMAND_ACK: &str = "fd0a0000c8ffbe4d000090010409fbffffffffbefd4d";
const COMMAND_ACK_V1_WITH_EXTENSIONS: &str = "fe0ac8ffbe4d90010400000000000000b380";
const STATUSTEXT: &str = "fd360000c8ffbefd0000064d697373696f6e20436f6d706c6574650000000000000000000000000000\
                          00000000000000000000000000000000000000000300018670";
const SIGNED_HEARTBEAT: &str = "fd090100c8ffbe00000000000000060800040309520315cd5b0700004dc26505fd47";

#[test]
fn frames_are_those_of_pymavlink() {
    let command = Message::COMMAND_LONG(COMMAND_LONG_DATA {
        param1: 1.0,
        command: 400,
        target_system: 1,
        target_component: 1,
        ..COMMAND_LONG_DATA::DEFAULT
    });
    let acknowledgement = Message::COMMAND_ACK(COMMAND_ACK_DATA {
        command: 400,
        result: 4,
        progress: 9,
        result_param2: -5,
        target_system: 255,
        target_component: 190,
    });
    let text = Message::STATUSTEXT(STATUSTEXT_DATA {
        severity: 6,
        text: CharArray::from("Mission Complete"),
        id: 3,
        chunk_seq: 1,
    });
    for (from, sequence, message, hex) in [
        (BOAT, 7, heartbeat(), HEARTBEAT_V2),
        (STATION, 200, command, COMMAND_LONG),
        (STATION, 200, acknowledgement, COMMAND_ACK),
        (STATION, 200, text, STATUSTEXT),
    ] {
        let mut out = Vec::new();
        encoder_at(from, sequence).encode(from, &message, &mut out);
        assert_eq!(out, bytes(hex));
        assert_eq!(framed(&out), message);
    }
    let mut out = Vec::new();
    encoder_at(BOAT, 7).encode_v1(BOAT, &heartbeat(), &mut out).unwrap();
    assert_eq!(out, bytes(HEARTBEAT_V1));
}

#[test]
fn a_header_says_who_and_what() {
    let frame = bytes(COMMAND_ACK);
    let frame = Frame::parse(&frame).unwrap();
    assert_eq!((frame.version(), frame.sequence(), frame.identity()), (Version::V2, 200, STATION));
    assert_eq!((frame.message_id(), frame.name(), frame.payload().len()), (77, Some("COMMAND_ACK"), 10));
    assert!(frame.is_verified() && !frame.is_signed());

    let frame = bytes(HEARTBEAT_V1);
    let frame = Frame::parse(&frame).unwrap();
    assert_eq!((frame.version(), frame.sequence(), frame.identity()), (Version::V1, 7, BOAT));
    assert_eq!((frame.message_id(), frame.name(), frame.payload().len()), (0, Some("HEARTBEAT"), 9));
    assert_eq!(frame.decode(), Ok(heartbeat()));
}

#[test]
fn a_signed_frame_keeps_its_signature() {
    let stream = [bytes(SIGNED_HEARTBEAT), bytes(COMMAND_ACK)].concat();
    let mut framer = Framer::new();
    framer.push(&stream);
    let frame = framer.next_frame().unwrap();
    assert_eq!(frame.bytes(), bytes(SIGNED_HEARTBEAT));
    let signature = bytes("0315cd5b0700004dc26505fd47");
    assert_eq!(frame.signature().map(|found| found.to_vec()), Some(signature));
    assert!(matches!(frame.decode(), Ok(Message::HEARTBEAT(heartbeat)) if heartbeat.mavtype == 6));
    assert_eq!(framer.next_frame().map(|frame| frame.is_signed()), Some(false));
}

#[test]
fn extensions_in_mavlink_1_are_read_and_never_written() {
    let message = framed(&bytes(COMMAND_ACK_V1_WITH_EXTENSIONS));
    let Message::COMMAND_ACK(ack) = &message else { panic!("{message:?}") };
    assert_eq!((ack.command, ack.result, ack.progress), (400, 4, 0));
    let mut out = Vec::new();
    Encoder::new().encode_v1(STATION, &message, &mut out).unwrap();
    assert_eq!(Frame::parse(&out).unwrap().payload(), [0x90, 0x01, 4]);
}

#[test]
fn numbers_without_a_name_survive() {
    for message in [
        Message::HEARTBEAT(HEARTBEAT_DATA { mavtype: 250, autopilot: 99, ..HEARTBEAT_DATA::DEFAULT }),
        Message::COMMAND_ACK(COMMAND_ACK_DATA { command: 65_000, result: 200, ..COMMAND_ACK_DATA::DEFAULT }),
        Message::COMMAND_LONG(COMMAND_LONG_DATA { command: 59_999, ..COMMAND_LONG_DATA::DEFAULT }),
        Message::STATUSTEXT(STATUSTEXT_DATA { severity: 77, ..STATUSTEXT_DATA::DEFAULT }),
    ] {
        let mut out = Vec::new();
        Encoder::new().encode(BOAT, &message, &mut out);
        assert_eq!(framed(&out), message);
    }
}

#[test]
fn every_message_survives_all_zero() {
    let (mut encoder, mut stream) = (Encoder::new(), Vec::new());
    for &id in Message::all_ids() {
        encoder.encode(BOAT, &Message::default_message_from_id(id).unwrap(), &mut stream);
    }
    let mut framer = Framer::new();
    framer.push(&stream);
    for &id in Message::all_ids() {
        let frame = framer.next_frame().unwrap();
        assert_eq!((frame.message_id(), frame.payload()), (id, &[0][..]), "zeroes are left out, all but one");
        let message = frame.decode().unwrap();
        assert_eq!(frame.name(), Some(message.message_name()));
        assert_eq!(message.message_id(), id);
    }
    assert_eq!(framer.next_frame(), None);
    assert_eq!(framer.statistics().frames, Message::all_ids().len() as u64);
}

#[test]
fn ids_that_mavlink_1_cannot_say_are_refused() {
    let (mut encoder, mut out) = (Encoder::new(), Vec::new());
    for &id in Message::all_ids() {
        let message = Message::default_message_from_id(id).unwrap();
        let result = encoder.encode_v1(BOAT, &message, &mut out);
        let refusal = EncodeError::NeedsMavlink2 { id, name: message.message_name() };
        assert_eq!(result, if id > 255 { Err(refusal) } else { Ok(()) });
    }
    let mut framer = Framer::new();
    framer.push(&out);
    let known = Message::all_ids().iter().filter(|&&id| id <= 255).count();
    assert_eq!(std::iter::from_fn(|| framer.next_frame().map(|_| ())).count(), known);
    assert_eq!(framer.statistics().sequence_gaps, 0, "a refused message takes no sequence number");
}

/// A frame with any payload for a message, with a right checksum: shorter or longer than is right.
fn frame_with_payload(version: Version, id: u32, payload: &[u8]) -> Vec<u8> {
    let [low, middle, high, _] = id.to_le_bytes();
    let length = payload.len() as u8;
    let mut frame = match version {
        Version::V1 => vec![0xFE, length, 0, 1, 1, low],
        Version::V2 => vec![0xFD, length, 0, 0, 0, 1, 1, low, middle, high],
    };
    frame.extend_from_slice(payload);
    let checksum = mavlink_core::calculate_crc(&frame[1..], Message::extra_crc(id));
    frame.extend_from_slice(&checksum.to_le_bytes());
    frame
}

#[test]
fn a_payload_longer_than_known_decodes() {
    let payload: Vec<u8> = [15, 0, 0, 0, 11, 3, 81, 4, 3].into_iter().chain(1..=246).collect();
    for version in [Version::V1, Version::V2] {
        for length in [9, 10, 20, 255] {
            assert_eq!(framed(&frame_with_payload(version, 0, &payload[..length])), heartbeat());
        }
    }
}

#[test]
fn a_short_payload_means_zeroes_only_in_mavlink_2() {
    let frame = frame_with_payload(Version::V2, 77, &[0x90]);
    assert!(matches!(framed(&frame), Message::COMMAND_ACK(ack) if ack.command == 0x90 && ack.result == 0));
    assert!(matches!(framed(&frame_with_payload(Version::V2, 77, &[])), Message::COMMAND_ACK(_)));
    let frame = frame_with_payload(Version::V1, 77, &[0x90, 1]);
    let too_short = DecodeError::TooShort { name: "COMMAND_ACK", needed: 3, found: 2 };
    assert_eq!(Frame::parse(&frame).unwrap().decode(), Err(too_short));
}

#[test]
fn what_is_not_one_frame_is_refused_with_the_reason() {
    let frame = bytes(HEARTBEAT_V2);
    let changed = |at: usize, value: u8| {
        let mut frame = frame.clone();
        frame[at] = value;
        frame
    };
    for (bytes, reason) in [
        (vec![], FrameError::Incomplete { found: 0 }),
        (frame[..20].to_vec(), FrameError::Incomplete { found: 20 }),
        ([&frame[..], &[0]].concat(), FrameError::TrailingBytes { length: 21, found: 22 }),
        (changed(0, 0x55), FrameError::NoMarker),
        (changed(2, 0x83), FrameError::Incompatible { flags: 0x83 }),
        (changed(10, 0), FrameError::Checksum),
        (changed(20, 0), FrameError::Checksum),
        (changed(9, 0x7F), FrameError::UnknownMessage { id: 0x7F_0000 }),
    ] {
        assert_eq!(Frame::parse(&bytes), Err(reason));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() })]

    /// Any content of any message comes back: compared as bytes, since NaN is not equal to itself.
    #[test]
    fn every_message_survives_with_any_content(content in prop::collection::vec(any::<u8>(), 255)) {
        let mut encoder = Encoder::new();
        for &id in Message::all_ids() {
            let message = Message::parse(mavlink_core::MavlinkVersion::V2, id, &content).unwrap();
            let mut sent = Vec::new();
            encoder.encode(BOAT, &message, &mut sent);
            let received = framed(&sent);
            let payload = Frame::parse(&sent).unwrap().payload().len();
            prop_assert_eq!(&sent[10..10 + payload], &content[..payload]);
            prop_assert_eq!(plain(&received), plain(&message));

            if id <= 255 {
                sent.clear();
                encoder.encode_v1(BOAT, &message, &mut sent).unwrap();
                let received = framed(&sent);
                prop_assert_eq!(received.message_id(), id);
                let frame = Frame::parse(&sent).unwrap();
                prop_assert_eq!(frame.payload(), &content[..frame.payload().len()]);
            }
        }
    }

    #[test]
    fn any_bytes_are_refused_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = Frame::parse(&bytes);
    }
}

/// All fields, the payload as it would be sent in full.
fn plain(message: &Message) -> [u8; 255] {
    let mut payload = [0; 255];
    message.ser(mavlink_core::MavlinkVersion::V2, &mut payload);
    payload
}
