use std::time::Duration;

use helmlink_wire::dialect::HEARTBEAT_DATA;
use helmlink_wire::tlog::records;
use helmlink_wire::{Encoder, LinkId, Message};
use proptest::prelude::*;

use super::settings::HeaderParts;
use super::splitter::{Piece, Splitter};
use super::tape::{Call, Entry};
use super::*;
use crate::bridge::{BridgeSettings, MissionSource};
use crate::control::Boat;
use crate::vehicle::OutputKind;

fn heartbeat(encoder: &mut Encoder) -> Vec<u8> {
    let mut bytes = Vec::new();
    let identity = Identity { system: 1, component: 1 };
    encoder.encode(identity, &Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT), &mut bytes);
    bytes
}

fn any_entry() -> impl Strategy<Value = Entry> {
    let link = any::<u32>().prop_map(LinkId);
    let text = proptest::collection::vec(any::<u8>(), 0..tape::MAX_TEXT);
    let call = prop_oneof![
        link.clone().prop_map(Call::LinkUp),
        link.clone().prop_map(Call::StationUp),
        link.clone().prop_map(Call::LinkDown),
        (link.clone(), any::<u64>()).prop_map(|(link, count)| Call::Bytes(link, count)),
        (link.clone(), any::<u64>()).prop_map(|(link, count)| Call::Datagram(link, count)),
        Just(Call::Tick),
        text.clone().prop_map(Call::Request),
        text.clone().prop_map(Call::Health),
        any::<u64>().prop_map(Call::RecordingFailed),
    ];
    prop_oneof![
        (any::<u64>(), call).prop_map(|(since_ns, call)| Entry::Call(since_ns, call)),
        (link.clone(), any::<u64>()).prop_map(|(link, count)| Entry::Received(link, count)),
        (link.clone(), any::<u64>()).prop_map(|(link, count)| Entry::Sent(link, count)),
        (link.clone(), any::<u64>()).prop_map(|(link, count)| Entry::Steered(link, count)),
        any::<u64>().prop_map(Entry::Noted),
        (link, text).prop_map(|(link, bytes)| Entry::Noise(link, bytes)),
    ]
}

proptest! {
    #[test]
    fn what_is_put_on_a_tape_comes_off_it(entries in proptest::collection::vec(any_entry(), 0..20)) {
        let mut bytes = Vec::new();
        entries.iter().for_each(|entry| entry.write(&mut bytes));
        let mut tape = bytes.as_slice();
        let mut read = Vec::new();
        while let Some(entry) = Entry::read(&mut tape) {
            read.push(entry);
        }
        prop_assert_eq!(read, entries);
        prop_assert!(tape.is_empty());
    }

    #[test]
    fn no_tape_makes_the_reader_fail(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let mut tape = bytes.as_slice();
        while Entry::read(&mut tape).is_some() {}
    }

    #[test]
    fn pieces_put_together_are_the_stream(
        parts in proptest::collection::vec(
            prop_oneof![Just(None), proptest::collection::vec(any::<u8>(), 1..40).prop_map(Some)], 0..12),
        chunk in 1_usize..60,
    ) {
        let mut encoder = Encoder::new();
        let stream: Vec<u8> =
            parts.iter().flat_map(|part| part.clone().unwrap_or_else(|| heartbeat(&mut encoder))).collect();
        let (mut splitter, mut together) = (Splitter::default(), Vec::new());
        let mut put = |piece: Piece<'_>| match piece {
            Piece::Frame(frame) => together.extend_from_slice(frame.bytes()),
            Piece::Noise(bytes) => together.extend_from_slice(bytes),
        };
        for bytes in stream.chunks(chunk) {
            splitter.push(bytes, false, &mut put);
        }
        splitter.push(&[], true, &mut put);
        prop_assert_eq!(together, stream);
    }
}

#[test]
fn settings_come_back_as_they_were() {
    let mission: helmlink_mission::plan::Mission =
        include_str!("../../mission/plans/harbour-survey.waypoints").parse().unwrap();
    for name in Boat::names() {
        let settings = BridgeSettings {
            mission: MissionSource::Given(mission.clone()),
            output: OutputKind::ManualControl,
            speed_mps: Some(0.1 + 0.2),
            control_interval_s: 1.0 / 30.0,
            ..BridgeSettings::new(Boat::embedded(name).unwrap())
        };
        let header = Header::new(1_795_422_927_539_027, &settings);
        let mut parts = HeaderParts::default();
        let messages = header.to_messages().unwrap();
        let mut texts = messages.iter().filter_map(|message| match message {
            Message::TUNNEL(data) => parts.push(&data.payload[..usize::from(data.payload_length)]),
            _ => None,
        });
        assert_eq!(Header::from_text(&texts.next().unwrap()).unwrap(), header);
    }
}

#[test]
fn every_state_comes_back_from_its_message() {
    let state = ControlState { boot_s: 12.5, cross_track_m: -0.25, lead_m: 3.0, ..ControlState::default() };
    assert_eq!(ControlState::from_message(&state.to_message()), Some(state));
    assert!(state.values().len() <= 58 && state::VALUES.iter().all(|(name, ..)| name.len() <= 10));
}

#[test]
fn a_recording_is_a_sound_log_whatever_comes_in() {
    let settings = BridgeSettings::new(Boat::embedded("otter").unwrap());
    let mut journal = Journal::new(&Header::new(1_795_422_927_000_000, &settings));
    let mut encoder = Encoder::new();
    let link = LinkId(7);
    journal.link_up(Duration::ZERO, link);
    for number in 0..200_u64 {
        let now = Duration::from_millis(number * 20);
        let mut bytes = heartbeat(&mut encoder);
        bytes.extend(std::iter::repeat_n(0xFD, number as usize % 5));
        let (first, second) = bytes.split_at(bytes.len() / 2);
        journal.bytes(now, link, first, false);
        journal.bytes(now, link, second, false);
        journal.tick(now);
        journal
            .event(4, "a line of more than fifty letters, so that it takes two messages, or even three: ©");
    }
    let mut log = journal.take();
    log.extend(journal.finish());
    let mut reader = records(&log);
    let heartbeats = reader.by_ref().filter(|record| record.frame.name() == Some("HEARTBEAT")).count();
    assert_eq!(heartbeats, 200);
    let statistics = reader.statistics();
    assert_eq!((statistics.crc_errors, statistics.resynchronised_bytes, statistics.sequence_gaps), (0, 0, 0));
}
