use std::time::Duration;

use mavlink_core::calculate_crc;
use proptest::prelude::*;

use super::*;
use crate::dialect::{COMMAND_LONG_DATA, HEARTBEAT_DATA, Message};
use crate::{Encoder, Framer};

const PASSPHRASE: &str = "correct horse battery staple";
const BOAT: Identity = Identity { system: 1, component: 1 };
const STATION: Identity = Identity { system: 255, component: 190 };
/// Written by pymavlink 2.4.50: key SHA-256 of the passphrase, link 7, time stamps 37992960000000 and the next.
const BY_PYMAVLINK: [&str; 2] = [
    "fd09010000ffbe000000000000000608000403dab0070080e2ec8d224189743e0cc0",
    "fd20010001ffbe4c0000000000000000000000000000000000000000000000000000000000002c0101bf7a4b070180e2ec8d22\
     139fb1d0c89d",
];
const THEIR_TIME: u64 = 37_992_960_000_000;

fn key() -> SigningKey {
    SigningKey::from_passphrase(PASSPHRASE)
}

fn party(units: u64) -> Signing {
    Signing::new(key(), Timestamp::from_units(units))
}

fn bytes_of(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

fn heartbeat(from: Identity) -> Vec<u8> {
    let message = Message::HEARTBEAT(HEARTBEAT_DATA { mavtype: 11, ..HEARTBEAT_DATA::DEFAULT });
    let mut bytes = Vec::new();
    Encoder::new().encode(from, &message, &mut bytes);
    bytes
}

fn signed(signing: &mut Signing, link: u8, from: Identity) -> Vec<u8> {
    let mut bytes = heartbeat(from);
    signing.sign(link, &mut bytes, 0);
    bytes
}

fn check(signing: &mut Signing, bytes: &[u8]) -> Result<(), Refusal> {
    signing.check(&Frame::parse(bytes).unwrap(), Unsigned::Refused)
}

#[test]
fn reads_what_pymavlink_signs() {
    let mut signing = party(0);
    for hex in BY_PYMAVLINK {
        assert_eq!(check(&mut signing, &bytes_of(hex)), Ok(()));
    }
    assert_eq!(signing.timestamp().units(), THEIR_TIME + 1, "time stamps follow the newest heard");
    assert_eq!(signing.statistics().accepted, 2);
}

#[test]
fn writes_what_pymavlink_signs() {
    let mut encoder = Encoder::new();
    let heartbeat = HEARTBEAT_DATA {
        mavtype: 6,
        autopilot: 8,
        system_status: 4,
        mavlink_version: 3,
        ..HEARTBEAT_DATA::DEFAULT
    };
    let command = COMMAND_LONG_DATA {
        target_system: 1,
        target_component: 191,
        command: 300,
        ..COMMAND_LONG_DATA::DEFAULT
    };
    // The first time stamp used is the one after that which the party starts with.
    let mut signing = party(THEIR_TIME - 1);
    let mut bytes = Vec::new();
    for message in [Message::HEARTBEAT(heartbeat), Message::COMMAND_LONG(command)] {
        let start = bytes.len();
        encoder.encode(STATION, &message, &mut bytes);
        signing.sign(7, &mut bytes, start);
    }
    assert_eq!(bytes, bytes_of(&BY_PYMAVLINK.concat()));
}

#[test]
fn another_key_is_refused_and_moves_nothing() {
    let mut stranger =
        Signing::new(SigningKey::from_passphrase("somebody else"), Timestamp::from_units(9_000_000));
    let mut signing = party(1000);
    let bytes = signed(&mut stranger, 0, BOAT);
    assert_eq!(check(&mut signing, &bytes), Err(Refusal::WrongSignature));
    assert_eq!(signing.timestamp().units(), 1000);
    let mut friend = party(2000);
    assert_eq!(check(&mut signing, &signed(&mut friend, 0, BOAT)), Ok(()), "the forgery opened no stream");
    assert_eq!(signing.statistics().wrong, 1);
}

#[test]
fn repeated_and_overtaken_frames_are_refused() {
    let mut boat = party(1000);
    let (first, second) = (signed(&mut boat, 0, BOAT), signed(&mut boat, 0, BOAT));
    let mut station = party(1000);
    assert_eq!(check(&mut station, &second), Ok(()));
    assert_eq!(check(&mut station, &second), Err(Refusal::Replayed));
    assert_eq!(check(&mut station, &first), Err(Refusal::Replayed));
    assert_eq!(station.statistics().replayed, 2);
}

#[test]
fn links_and_components_are_streams_of_their_own() {
    let mut boat = party(1000);
    let older = signed(&mut boat, 0, BOAT);
    let other = signed(&mut boat, 0, Identity { component: 191, ..BOAT });
    let newer = signed(&mut boat, 1, BOAT);
    let mut station = party(1000);
    for bytes in [&newer, &other, &older] {
        assert_eq!(check(&mut station, bytes), Ok(()));
    }
}

#[test]
fn a_new_stream_may_lag_by_a_minute_and_no_more() {
    for (lag, result) in [(NEW_STREAM_LAG, Ok(())), (NEW_STREAM_LAG + 1, Err(Refusal::TooOld))] {
        let now = 10 * NEW_STREAM_LAG;
        let mut boat = party(now - lag - 1);
        assert_eq!(check(&mut party(now), &signed(&mut boat, 0, BOAT)), result);
    }
}

#[test]
fn a_laggard_is_accepted_once_it_has_heard_the_time() {
    let mut station = party(100 * NEW_STREAM_LAG);
    let mut boat = party(0);
    assert_eq!(check(&mut station, &signed(&mut boat, 0, BOAT)), Err(Refusal::TooOld));
    let greeting = signed(&mut station, 0, STATION);
    assert_eq!(check(&mut boat, &greeting), Ok(()));
    assert_eq!(check(&mut station, &signed(&mut boat, 0, BOAT)), Ok(()));
}

#[test]
fn unsigned_frames_are_refused_unless_allowed_or_from_a_radio() {
    let mut signing = party(0);
    let plain = heartbeat(BOAT);
    assert_eq!(check(&mut signing, &plain), Err(Refusal::Unsigned));
    assert_eq!(signing.check(&Frame::parse(&plain).unwrap(), Unsigned::Accepted), Ok(()));
    for version_1 in [false, true] {
        let report = Message::RADIO_STATUS(RADIO_STATUS_DATA::DEFAULT);
        let (radio, mut bytes) = (Identity { system: 51, component: 68 }, Vec::new());
        if version_1 {
            Encoder::new().encode_v1(radio, &report, &mut bytes).unwrap();
        } else {
            Encoder::new().encode(radio, &report, &mut bytes);
        }
        assert_eq!(check(&mut signing, &bytes), Ok(()));
    }
    let counted = signing.statistics();
    assert_eq!((counted.unsigned_refused, counted.unsigned_accepted, counted.accepted), (1, 3, 0));
}

#[test]
fn time_stamps_never_repeat_whatever_the_clock_does() {
    let mut boat = party(5000);
    let mut last = Timestamp::default();
    for clock in [6000, 6000, 10, 6001, 0, 90_000, 7000] {
        boat.observe_time(Timestamp::from_units(clock));
        signed(&mut boat, 0, BOAT);
        assert!(boat.timestamp() > last);
        last = boat.timestamp();
    }
    let mut next_run = Signing::new(key(), last);
    signed(&mut next_run, 0, BOAT);
    assert!(next_run.timestamp() > last);
}

#[test]
fn holders_of_the_key_cannot_fill_memory() {
    let (mut crowd, mut station) = (party(0), party(0));
    for number in 0..=u8::MAX {
        let from = Identity { system: number, component: 1 };
        assert_eq!(check(&mut station, &signed(&mut crowd, 0, from)), Ok(()));
    }
    let one_more = Identity { system: 1, component: 2 };
    assert_eq!(check(&mut station, &signed(&mut crowd, 0, one_more)), Err(Refusal::TooManyStreams));
}

#[test]
fn what_cannot_be_signed_stays_as_it_is() {
    let mut signing = party(0);
    let mut version_1 = Vec::new();
    Encoder::new().encode_v1(BOAT, &Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT), &mut version_1).unwrap();
    let once = signed(&mut signing, 0, BOAT);
    for unfit in [version_1, once, vec![0xFD, 1], vec![], b"no frame at all".to_vec()] {
        let mut bytes = unfit.clone();
        signing.sign(0, &mut bytes, 0);
        assert_eq!(bytes, unfit);
    }
    signing.sign(0, &mut Vec::new(), 10);
}

#[test]
fn unknown_messages_can_be_signed_when_passed_on() {
    // The checksum of id 0x7FFFFF is made up for a definition whose extra byte is 99.
    let mut bytes = vec![0xFD, 3, 0, 0, 1, 1, 1, 0xFF, 0xFF, 0x7F, 1, 2, 3];
    let checksum = calculate_crc(&bytes[1..], 99);
    bytes.extend_from_slice(&checksum.to_le_bytes());
    party(0).sign(0, &mut bytes, 0);
    let end = bytes.len() - SIGNATURE_LENGTH - CHECKSUM_LENGTH;
    assert_eq!(calculate_crc(&bytes[1..end], 99).to_le_bytes(), bytes[end..end + CHECKSUM_LENGTH]);
}

#[test]
fn key_files_hold_bytes_digits_or_a_passphrase() {
    let read = SigningKey::from_file_contents;
    assert_eq!(read(format!("{PASSPHRASE}\r\n").as_bytes()), Ok(key()));
    let raw: [u8; 32] = std::array::from_fn(|index| (index as u8).wrapping_mul(9));
    let hex: String = raw.iter().map(|byte| format!("{byte:02X}")).collect();
    assert_eq!(read(&raw), SigningKey::from_bytes(raw));
    assert_eq!(read(format!("{hex}\n").as_bytes()), SigningKey::from_bytes(raw));
    assert_eq!(read(b" \n"), Err(KeyError::Empty));
    assert_eq!(read(b"boat\n"), Err(KeyError::Short { length: 4 }));
    assert_eq!(read(&raw[..31]), Err(KeyError::NotAKey { length: 31 }));
    assert_eq!(read(&[0; 32]), Err(KeyError::Zero));
    assert_eq!(read("0".repeat(64).as_bytes()), Err(KeyError::Zero));
    assert!(!format!("{:?}", party(0)).contains(&format!("{:?}", &key().bytes()[..3])));
}

#[test]
fn time_stamps_count_from_2015() {
    assert_eq!(Timestamp::from_unix(Duration::from_millis(1_420_070_400_001)).units(), 100);
    assert_eq!(Timestamp::from_unix(Duration::ZERO).units(), 0);
    assert_eq!(Timestamp::from_unix(Duration::MAX).units(), (1 << 48) - 1);
    assert_eq!(Timestamp::from_units(5).later(Duration::from_secs(60)).units(), 5 + NEW_STREAM_LAG);
}

#[test]
fn every_changed_bit_is_noticed() {
    let intact = signed(&mut party(1000), 3, BOAT);
    for bit in 0..8 * intact.len() {
        let mut bytes = intact.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let mut framer = Framer::new();
        framer.push(&bytes);
        framer.end_of_datagram();
        let mut station = party(1000);
        while let Some(frame) = framer.next_frame() {
            assert!(station.check(&frame, Unsigned::Refused).is_err(), "bit {bit}");
        }
    }
}

proptest! {
    /// Framing takes signed frames of any content and position as readily as plain ones.
    #[test]
    fn signed_frames_are_framed(param1 in any::<f32>(), command in any::<u16>(), links in prop::collection::vec(any::<u8>(), 1..9)) {
        let command = COMMAND_LONG_DATA { param1, command, ..COMMAND_LONG_DATA::DEFAULT };
        let (mut boat, mut encoder, mut bytes) = (party(1000), Encoder::new(), Vec::new());
        for &link in &links {
            let start = bytes.len();
            encoder.encode(BOAT, &Message::COMMAND_LONG(command.clone()), &mut bytes);
            boat.sign(link, &mut bytes, start);
        }
        let (mut station, mut framer) = (party(1000), Framer::new());
        framer.push(&bytes);
        let mut count = 0;
        while let Some(frame) = framer.next_frame() {
            prop_assert_eq!(station.check(&frame, Unsigned::Refused), Ok(()));
            count += 1;
        }
        prop_assert_eq!(count, links.len());
    }
}
