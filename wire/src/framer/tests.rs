use super::*;
use crate::dialect::{HEARTBEAT_DATA, Message, MessageSet};
use crate::{Encoder, Identity, Version};

const BOAT: Identity = Identity { system: 1, component: 1 };
const STATION: Identity = Identity { system: 255, component: 190 };

/// A MAVLink 2 frame with an id that no dialect defines, whose payload is full of false markers.
const UNKNOWN: [u8; 15] = [0xFD, 3, 0, 0, 1, 1, 1, 0xFF, 0xFF, 0x7F, 0xFD, 0xFE, 0xFD, 0x12, 0x34];

/// `count` heartbeats; none of their bytes is a marker within the frame.
fn heartbeats(from: Identity, count: usize) -> Vec<Vec<u8>> {
    let message = Message::HEARTBEAT(HEARTBEAT_DATA { mavtype: 11, ..HEARTBEAT_DATA::DEFAULT });
    let mut encoder = Encoder::new();
    let mut frames = vec![Vec::new(); count];
    frames.iter_mut().for_each(|frame| encoder.encode(from, &message, frame));
    frames
}

fn sequences(framer: &mut Framer) -> Vec<u8> {
    std::iter::from_fn(|| framer.next_frame().map(|frame| frame.sequence())).collect()
}

/// The frames of one datagram and the statistics it leaves.
fn datagram(bytes: &[u8]) -> (Vec<u8>, LinkStatistics) {
    let mut framer = Framer::new();
    framer.push(bytes);
    framer.end_of_datagram();
    (sequences(&mut framer), *framer.statistics())
}

#[test]
fn a_frame_is_delivered_with_its_last_byte() {
    let frame = &heartbeats(BOAT, 1)[0];
    let mut framer = Framer::new();
    for &byte in &frame[..frame.len() - 1] {
        framer.push(&[byte]);
        assert_eq!(framer.next_frame(), None);
    }
    framer.push(&frame[frame.len() - 1..]);
    assert_eq!(framer.next_frame().map(|frame| frame.bytes().to_vec()).as_ref(), Some(frame));
    assert_eq!(framer.next_frame(), None);
}

#[test]
fn a_false_start_holds_frames_up_only_until_the_flush() {
    for false_start in [&[0xFE, 0xFF][..], &[0xFD, 0xFF, 0x00], &[0xFD, 0xFF, 0x01, 0xFE]] {
        let frames = heartbeats(BOAT, 5);
        let mut framer = Framer::new();
        framer.push(false_start);
        framer.push(&frames.concat());
        assert_eq!(sequences(&mut framer), [] as [u8; 0], "the claimed frame may still come");
        framer.end_of_datagram();
        assert_eq!(sequences(&mut framer), [0, 1, 2, 3, 4]);
        assert_eq!(framer.statistics().resynchronised_bytes, false_start.len() as u64);
    }
}

#[test]
fn a_false_start_holds_frames_up_only_until_its_length_has_passed() {
    let frames = heartbeats(BOAT, 40);
    let mut framer = Framer::new();
    framer.push(&[0xFE, 0xFF]);
    framer.push(&frames.concat());
    assert_eq!(sequences(&mut framer), (0..40).collect::<Vec<u8>>());
}

#[test]
fn no_frame_goes_on_from_one_datagram_to_the_next() {
    let frames = heartbeats(BOAT, 3);
    let mut framer = Framer::new();
    framer.push(&[&frames[0][..], &frames[1][..8]].concat());
    framer.end_of_datagram();
    framer.push(&[&frames[1][8..], &frames[2][..]].concat());
    assert_eq!(sequences(&mut framer), [0, 2]);
    assert_eq!(framer.statistics().sequence_gaps, 1);
}

#[test]
fn a_flush_without_bytes_changes_nothing() {
    let frame = &heartbeats(BOAT, 1)[0];
    let mut framer = Framer::new();
    framer.end_of_datagram();
    framer.push(frame);
    assert_eq!(sequences(&mut framer), [0]);
    framer.end_of_datagram();
    assert_eq!(framer.next_frame(), None);
    assert_eq!(framer.statistics().resynchronised_bytes, 0);
}

#[test]
fn a_damaged_frame_counts_once() {
    let mut frames = heartbeats(BOAT, 3);
    frames[1][12] ^= 1;
    let (received, statistics) = datagram(&frames.concat());
    assert_eq!(received, [0, 2]);
    let expected = LinkStatistics {
        frames: 2,
        bytes: frames.concat().len() as u64,
        crc_errors: 1,
        resynchronised_bytes: frames[1].len() as u64,
        sequence_gaps: 1,
        ..LinkStatistics::default()
    };
    assert_eq!(statistics, expected);
}

#[test]
fn flags_that_nobody_understands_are_refused() {
    let mut frames = heartbeats(BOAT, 3);
    frames[1][2] = 0x02;
    let (received, statistics) = datagram(&frames.concat());
    assert_eq!(received, [0, 2]);
    assert_eq!((statistics.incompatible, statistics.crc_errors), (1, 0));
}

#[test]
fn unknown_messages_are_shown_only_on_request() {
    let frames = heartbeats(BOAT, 2);
    let bytes = [&frames[0][..], &UNKNOWN, &UNKNOWN, &frames[1], &UNKNOWN].concat();
    let (received, statistics) = datagram(&bytes);
    assert_eq!(received, [0, 1]);
    assert_eq!((statistics.unknown_ids, statistics.frames, statistics.resynchronised_bytes), (3, 2, 0));

    let mut framer = Framer::new();
    framer.push(&bytes);
    framer.end_of_datagram();
    let mut verified = Vec::new();
    while let Some(frame) = framer.next_any() {
        assert_eq!(frame.decode().is_ok(), frame.is_verified());
        assert_eq!(frame.name().is_some(), frame.is_verified());
        verified.push(frame.is_verified());
    }
    assert_eq!(verified, [true, false, false, true, false]);
}

#[test]
fn an_unknown_message_that_carries_its_number_is_no_gap() {
    let frames = heartbeats(BOAT, 3);
    let mut unknown = UNKNOWN;
    unknown[4] = 1;
    let (_, statistics) = datagram(&[&frames[0][..], &unknown, &frames[2]].concat());
    assert_eq!(statistics.sequence_gaps, 0);
}

#[test]
fn noise_that_claims_an_unknown_id_swallows_nothing() {
    let frames = heartbeats(BOAT, 4).concat();
    let length = frames.len() as u8;
    // Claims all frames as its payload, ends exactly with the datagram.
    let claim = [0xFD, length - 2, 0, 0, 0, 9, 9, 0xFF, 0xFF, 0x7F];
    let (received, statistics) = datagram(&[&claim[..], &frames].concat());
    assert_eq!(received, [0, 1, 2, 3]);
    assert_eq!(statistics.unknown_ids, 0);
    // Claims two frames and half of the third.
    let claim = [0xFE, length / 8 * 5, 0, 9, 9, 0xFF];
    assert_eq!(datagram(&[&claim[..], &frames].concat()).0, [0, 1, 2, 3]);
}

#[test]
fn a_stream_of_unknown_messages_does_not_fill_the_memory() {
    let mut framer = Framer::new();
    for _ in 0..100_000 {
        framer.push(&UNKNOWN);
        while framer.next_any().is_some() {}
    }
    assert!(framer.buffer.capacity() < 8 * MAX_FRAME, "{}", framer.buffer.capacity());
    assert!(framer.statistics().unknown_ids > 99_990);
}

#[test]
fn bytes_that_nobody_takes_out_are_given_up() {
    let mut framer = Framer::new();
    let frames = heartbeats(BOAT, 1000).concat();
    for _ in 0..1000 {
        framer.push(&frames);
    }
    assert!(framer.buffer.len() <= MAX_PENDING + frames.len());
    let received = sequences(&mut framer).len();
    assert!(received * 21 > MAX_PENDING, "the newest frames are kept: {received}");
    framer.push(&[]);
    assert!(framer.buffer.capacity() <= 2 * MAX_PENDING);
}

#[test]
fn gaps_are_counted_for_each_sender_and_across_the_wrap() {
    let boat = heartbeats(BOAT, 600);
    let station = heartbeats(STATION, 600);
    let mut framer = Framer::new();
    for number in 250..600 {
        framer.push(&boat[number]);
        if number % 3 != 0 {
            framer.push(&station[number]);
        }
    }
    assert_eq!(sequences(&mut framer).len(), 350 + 234);
    assert_eq!(framer.statistics().sequence_gaps, 116);
}

#[test]
fn repeated_and_late_frames_are_no_gaps() {
    let frames = heartbeats(BOAT, 300);
    let mut framer = Framer::new();
    for number in [254, 255, 255, 257, 256, 258, 254, 259] {
        framer.push(&frames[number]);
    }
    assert_eq!(sequences(&mut framer).len(), 8);
    assert_eq!(framer.statistics().sequence_gaps, 1); // 256 came late, after 257 had shown that it was missing
}

#[test]
fn more_senders_than_are_followed_do_no_harm() {
    let mut framer = Framer::new();
    for number in 0..2000 {
        let sender = Identity { system: (number % 250) as u8 + 1, component: (number / 250) as u8 + 1 };
        framer.push(&heartbeats(sender, 1)[0]);
        assert_eq!(sequences(&mut framer), [0]);
    }
    assert_eq!(framer.statistics().sequence_gaps, 0);
}

#[test]
fn both_versions_share_a_stream() {
    let mut encoder = Encoder::new();
    let mut bytes = Vec::new();
    let message = Message::default_message_from_id(30).unwrap();
    encoder.encode_v1(BOAT, &message, &mut bytes).unwrap();
    encoder.encode(BOAT, &message, &mut bytes);
    let mut framer = Framer::new();
    framer.push(&bytes);
    assert_eq!(framer.next_frame().map(|frame| frame.version()), Some(Version::V1));
    assert_eq!(framer.next_frame().map(|frame| frame.version()), Some(Version::V2));
    assert_eq!(framer.statistics().sequence_gaps, 0);
}
