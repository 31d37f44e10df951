//! A recorded run of ArduRover 4.6: every frame of it, by every way in. The counts are pymavlink's.

use std::collections::BTreeMap;

use helmlink_wire::dialect::Message;
use helmlink_wire::tlog::{TlogReader, TlogWriter, records};
use helmlink_wire::{Encoder, Framer, Identity, Version};

const LOG: &[u8] = include_bytes!("../../tests/data/ardurover-4.6-motorboat.tlog");
const FRAMES: u64 = 17_732;
const FRAME_BYTES: usize = 689_966;

fn frame_bytes() -> Vec<u8> {
    records(LOG).flat_map(|record| record.frame.bytes().to_vec()).collect()
}

#[test]
fn the_reader_yields_every_record() {
    let mut reader = TlogReader::new(LOG);
    let (mut times, mut senders) = (Vec::new(), BTreeMap::new());
    while let Some(record) = reader.next_record().unwrap() {
        assert_eq!(record.frame.version(), Version::V2);
        times.push(record.time_us);
        *senders.entry(record.frame.identity()).or_insert(0) += 1;
    }
    assert_eq!(times.first(), Some(&1_795_422_927_539_027));
    assert_eq!(times.last(), Some(&1_795_422_944_389_562));
    assert!(times.is_sorted());
    let boat = (Identity { system: 1, component: 1 }, 17_682);
    let station = (Identity { system: 255, component: 190 }, 50);
    assert_eq!(senders.into_iter().collect::<Vec<_>>(), [boat, station]);

    let statistics = reader.statistics();
    assert_eq!((statistics.frames, statistics.bytes), (FRAMES, LOG.len() as u64));
    assert_eq!((statistics.crc_errors, statistics.resynchronised_bytes), (0, 0));
    assert_eq!((statistics.sequence_gaps, statistics.unknown_ids), (0, 0));
}

#[test]
fn every_message_decodes() {
    let mut counts = BTreeMap::new();
    for record in records(LOG) {
        record.frame.decode().unwrap();
        *counts.entry((record.frame.message_id(), record.frame.name().unwrap())).or_insert(0) += 1;
    }
    assert_eq!(counts.len(), 40);
    assert_eq!(counts.values().sum::<u64>(), FRAMES);
    for (id, name, count) in [
        (0, "HEARTBEAT", 190),
        (20, "PARAM_REQUEST_READ", 11),
        (22, "PARAM_VALUE", 1282),
        (24, "GPS_RAW_INT", 167),
        (30, "ATTITUDE", 3256),
        (32, "LOCAL_POSITION_NED", 1594),
        (33, "GLOBAL_POSITION_INT", 1631),
        (36, "SERVO_OUTPUT_RAW", 1631),
        (40, "MISSION_REQUEST", 9),
        (46, "MISSION_ITEM_REACHED", 8),
        (47, "MISSION_ACK", 1),
        (73, "MISSION_ITEM_INT", 9),
        (77, "COMMAND_ACK", 11),
        (111, "TIMESYNC", 16),
        (164, "SIMSTATE", 3256),
        (193, "EKF_STATUS_REPORT", 166),
        (242, "HOME_POSITION", 1),
        (253, "STATUSTEXT", 63),
    ] {
        assert_eq!(counts.get(&(id, name)), Some(&count), "{name}");
    }
}

#[test]
fn the_boat_says_what_it_said() {
    let messages = || records(LOG).filter_map(|record| record.frame.decode().ok());
    let reached: Vec<u16> = messages()
        .filter_map(|message| match message {
            Message::MISSION_ITEM_REACHED(reached) => Some(reached.seq),
            _ => None,
        })
        .collect();
    assert_eq!(reached, [1, 2, 3, 4, 5, 6, 7, 8]);
    assert!(messages().any(
        |message| matches!(message, Message::STATUSTEXT(text) if text.text.to_str() == Ok("Mission Complete"))
    ));
}

#[test]
fn the_framer_yields_every_frame_whatever_the_chunks() {
    let bytes = frame_bytes();
    assert_eq!(bytes.len(), FRAME_BYTES);
    for chunk in [1, 7, 293, 1021, 65_521, FRAME_BYTES] {
        let (mut framer, mut received) = (Framer::new(), Vec::new());
        for chunk in bytes.chunks(chunk) {
            framer.push(chunk);
            while let Some(frame) = framer.next_frame() {
                received.extend_from_slice(frame.bytes());
            }
        }
        assert_eq!(received, bytes);
        let statistics = framer.statistics();
        assert_eq!((statistics.frames, statistics.bytes), (FRAMES, FRAME_BYTES as u64));
        assert_eq!((statistics.crc_errors, statistics.sequence_gaps, statistics.unknown_ids), (0, 0, 0));
    }
}

#[test]
fn time_stamps_are_noise_to_the_framer() {
    // More than four hundred of them contain a marker, each the false start of a frame.
    let mut framer = Framer::new();
    framer.push(LOG);
    framer.end_of_datagram();
    while framer.next_frame().is_some() {}
    assert_eq!(framer.statistics().frames, FRAMES);
}

#[test]
fn what_is_encoded_again_is_what_the_boat_sent() {
    // The boat's frames are not signed and its zeroes are left out: our encoder must write the same bytes.
    let mut encoder = Encoder::new();
    let mut first = BTreeMap::new();
    for record in records(LOG) {
        let frame = record.frame;
        let mut bytes = Vec::new();
        encoder.encode(frame.identity(), &frame.decode().unwrap(), &mut bytes);
        let again = helmlink_wire::Frame::parse(&bytes).unwrap();
        assert_eq!((again.message_id(), again.payload()), (frame.message_id(), frame.payload()));
        let offset = frame.sequence().wrapping_sub(again.sequence());
        assert_eq!(*first.entry(frame.identity()).or_insert(offset), offset);
    }
}

#[test]
fn a_log_written_again_is_the_same_file() {
    let mut writer = TlogWriter::new(Vec::with_capacity(LOG.len()));
    for record in records(LOG) {
        writer.write(record.time_us, &record.frame).unwrap();
    }
    assert!(writer.into_inner() == LOG);
}

#[test]
fn damage_costs_only_the_frames_it_hits() {
    let mut log = LOG.to_vec();
    let mut ends = Vec::new();
    let mut end = 0;
    for record in records(LOG) {
        end += 8 + record.frame.bytes().len();
        ends.push(end);
    }
    // One changed byte in the frame of every 50th record, each time at another place.
    let mut hit = 0;
    for number in (49..ends.len()).step_by(50) {
        let start = ends[number - 1] + 8;
        log[start + number % (ends[number] - start)] ^= 0x15;
        hit += 1;
    }
    let times = |log: &[u8]| records(log).map(|record| record.time_us).collect::<Vec<_>>();
    let survivors: Vec<u64> = times(LOG)
        .into_iter()
        .enumerate()
        .filter_map(|(number, time_us)| (number % 50 != 49).then_some(time_us))
        .collect();
    assert_eq!(hit, 354);
    assert_eq!(times(&log), survivors);
}
