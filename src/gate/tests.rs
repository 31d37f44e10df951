use std::time::Duration;

use helmlink_wire::dialect::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, MISSION_COUNT_DATA, RADIO_STATUS_DATA, SETUP_SIGNING_DATA,
};
use helmlink_wire::signing::SigningKey;
use helmlink_wire::{Encoder, Identity, Message};

use super::*;

const LINK: LinkId = LinkId(4);
const BOAT: Identity = Identity { system: 1, component: 1 };
const STATION: Identity = Identity { system: 255, component: 190 };
const STRANGER: Identity = Identity { system: 7, component: 190 };
const SIGNED: Terms = Terms { signed: true, unsigned: Unsigned::Refused, number: 2 };
const NOON: Duration = Duration::from_secs(1_800_000_000);

fn signing(passphrase: &str) -> Signing {
    Signing::new(SigningKey::from_passphrase(passphrase), Timestamp::from_unix(NOON))
}

fn gate(terms: Terms, allowed_systems: &[u8]) -> Gate {
    let mut gate = Gate::new(Some(signing("a long enough secret")), allowed_systems.to_vec());
    gate.link_up(Duration::ZERO, LINK, terms);
    gate
}

fn frame(from: Identity, message: &Message) -> Vec<u8> {
    let mut bytes = Vec::new();
    Encoder::new().encode(from, message, &mut bytes);
    bytes
}

fn heartbeat(from: Identity) -> Vec<u8> {
    frame(from, &Message::HEARTBEAT(HEARTBEAT_DATA { mavtype: 11, ..HEARTBEAT_DATA::DEFAULT }))
}

fn command(from: Identity) -> Vec<u8> {
    frame(from, &Message::COMMAND_LONG(COMMAND_LONG_DATA { command: 300, ..COMMAND_LONG_DATA::DEFAULT }))
}

fn key_setup(from: Identity) -> Vec<u8> {
    frame(
        from,
        &Message::SETUP_SIGNING(SETUP_SIGNING_DATA { secret_key: [9; 32], ..SETUP_SIGNING_DATA::DEFAULT }),
    )
}

fn signed_by(passphrase: &str, mut bytes: Vec<u8>) -> Vec<u8> {
    signing(passphrase).sign(0, &mut bytes, 0);
    bytes
}

fn inside(gate: &mut Gate, bytes: &[u8]) -> Vec<u8> {
    let mut inside = Vec::new();
    gate.incoming(Duration::ZERO, LINK, bytes, true, &mut inside);
    inside
}

#[test]
fn an_open_link_lets_frames_through_unchanged_and_drops_noise() {
    let mut gate = gate(Terms::OPEN, &[]);
    let (beat, order) = (heartbeat(BOAT), command(STRANGER));
    let arriving = [b"noise", &beat[..], &[0xFD, 9], &order].concat();
    assert_eq!(inside(&mut gate, &arriving), [&beat[..], &order].concat());
    let counted = gate.statistics(LINK).unwrap();
    assert_eq!((counted.frames, counted.resynchronised_bytes), (2, 7));
    let mut leaving = beat.clone();
    assert!(gate.outgoing(LINK, &mut leaving));
    assert_eq!(leaving, beat);
}

#[test]
fn a_signed_link_lets_in_what_its_key_signed_and_the_radios_report() {
    let mut gate = gate(SIGNED, &[]);
    let radio =
        frame(Identity { system: 51, component: 68 }, &Message::RADIO_STATUS(RADIO_STATUS_DATA::DEFAULT));
    let good = signed_by("a long enough secret", command(STATION));
    for (arriving, enters) in [
        (command(STATION), false),
        (signed_by("another secret", command(STATION)), false),
        (radio, true),
        (good.clone(), true),
        (good, false),
    ] {
        let expected = if enters { arriving.clone() } else { Vec::new() };
        assert_eq!(inside(&mut gate, &arriving), expected);
    }
    assert_eq!(gate.refused().signature, 3);
}

#[test]
fn unsigned_frames_come_in_where_that_is_allowed() {
    let mut gate = gate(Terms { unsigned: Unsigned::Accepted, ..SIGNED }, &[]);
    let plain = command(STATION);
    assert_eq!(inside(&mut gate, &plain), plain);
    assert!(
        inside(&mut gate, &signed_by("another secret", command(STATION))).is_empty(),
        "a wrong one is worse"
    );
}

#[test]
fn what_goes_out_on_a_signed_link_satisfies_the_other_side() {
    let mut gate = gate(SIGNED, &[]);
    let mut other = signing("a long enough secret");
    for message in [heartbeat(BOAT), command(STATION)] {
        let mut leaving = message;
        assert!(gate.outgoing(LINK, &mut leaving));
        let frame = Frame::parse(&leaving).unwrap();
        assert_eq!(frame.signature().map(|signature| signature[0]), Some(SIGNED.number));
        assert_eq!(other.check(&frame, Unsigned::Refused), Ok(()));
    }
}

#[test]
fn a_frame_passed_on_keeps_the_signature_it_has() {
    let mut gate = gate(SIGNED, &[]);
    let by_station = signed_by("a long enough secret", command(STATION));
    let mut leaving = by_station.clone();
    assert!(gate.outgoing(LINK, &mut leaving));
    assert_eq!(leaving, by_station);
}

#[test]
fn the_key_leaves_on_signed_links_only_and_never_enters() {
    let mut open = gate(Terms::OPEN, &[]);
    assert!(!open.outgoing(LINK, &mut key_setup(BOAT)));
    assert!(inside(&mut open, &key_setup(STATION)).is_empty());
    let mut signed = gate(SIGNED, &[]);
    assert!(signed.outgoing(LINK, &mut key_setup(BOAT)));
    assert!(inside(&mut signed, &signed_by("a long enough secret", key_setup(STATION))).is_empty());
    let mut without_key = Gate::new(None, Vec::new());
    without_key.link_up(Duration::ZERO, LINK, SIGNED);
    assert!(!without_key.outgoing(LINK, &mut key_setup(BOAT)), "a link is signed only if there is a key");
}

#[test]
fn orders_come_from_allowed_systems_only() {
    let mut gate = gate(Terms::OPEN, &[255]);
    assert_eq!(inside(&mut gate, &command(STATION)), command(STATION));
    assert!(inside(&mut gate, &command(STRANGER)).is_empty());
    assert!(inside(&mut gate, &command(Identity { component: 1, ..STRANGER })).is_empty());
    assert_eq!(inside(&mut gate, &heartbeat(STRANGER)), heartbeat(STRANGER), "a heartbeat is no order");
    let count = frame(BOAT, &Message::MISSION_COUNT(MISSION_COUNT_DATA::DEFAULT));
    assert_eq!(inside(&mut gate, &count), count, "the flight controller answers a question");
    assert!(gate.take_news().unwrap().contains("--allow-system 7"));
    assert_eq!(gate.refused().orders, 2);
}

#[test]
fn refusals_are_told_ever_more_seldom() {
    let mut gate = gate(SIGNED, &[]);
    let told: Vec<usize> = (1..=20)
        .filter(|_| {
            inside(&mut gate, &command(STATION));
            gate.take_news().is_some()
        })
        .collect();
    assert_eq!(told, [1, 2, 4, 8, 16]);
}

#[test]
fn silence_frees_what_a_false_start_holds_up() {
    let mut gate = gate(Terms::OPEN, &[]);
    let beat = heartbeat(BOAT);
    let mut inside = Vec::new();
    gate.incoming(Duration::ZERO, LINK, &[&[0xFD, 200, 0], &beat[..]].concat(), false, &mut inside);
    assert!(inside.is_empty());
    assert_eq!(gate.after_silence(IDLE_FLUSH / 2), []);
    assert_eq!(gate.after_silence(IDLE_FLUSH), [(LINK, beat)]);
}

#[test]
fn the_time_of_day_may_jump() {
    let mut gate = gate(SIGNED, &[]);
    let mut last = gate.timestamp().unwrap();
    for hours in [0, 2, -5, 1, 30] {
        let time = if hours < 0 {
            NOON - Duration::from_secs(5 * 3600)
        } else {
            NOON + Duration::from_secs(hours as u64 * 3600)
        };
        gate.observe_time_of_day(time);
        gate.outgoing(LINK, &mut heartbeat(BOAT));
        assert!(gate.timestamp().unwrap() > last);
        last = gate.timestamp().unwrap();
    }
}

#[test]
fn nothing_passes_for_a_peer_that_is_gone() {
    let mut gate = gate(Terms::OPEN, &[]);
    gate.link_down(LINK);
    assert!(inside(&mut gate, &heartbeat(BOAT)).is_empty());
    assert!(!gate.outgoing(LINK, &mut heartbeat(BOAT)));
}
