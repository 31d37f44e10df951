//! Messages in no sensible order, with no sensible content: nothing panics, nothing goes on for ever.

use helmlink_wire::LinkId;
use helmlink_wire::dialect::*;
use proptest::prelude::*;

use super::*;
use crate::protocol::client::{ATTEMPTS, Download, Upload};
use crate::protocol::server::{CAPACITY, GIVE_UP, MissionServer, Settings};

/// Numbers that matter, and any other.
fn small_or_any_u16() -> impl Strategy<Value = u16> {
    prop_oneof![3 => 0u16..6, 1 => any::<u16>()]
}

fn any_float() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0), Just(3.0), Just(f32::NAN), Just(f32::INFINITY), any::<f32>()]
}

fn any_item() -> impl Strategy<Value = Item> {
    let command = prop::sample::select(&[16u16, 16, 178, 177, 5001, 5003, 5100, 42][..]);
    let floats = (any_float(), any_float(), any_float());
    (command, 0u8..12, floats, -2_000_000_000i32..2_000_000_000, any::<bool>()).prop_map(
        |(command, frame, (p1, p4, z), x, autocontinue)| Item {
            command,
            frame,
            params: [p1, 0.0, 0.0, p4],
            x: x / 3,
            y: x,
            z,
            autocontinue,
        },
    )
}

/// Any message of the mission protocol for any of a few targets.
fn any_message() -> impl Strategy<Value = Message> {
    let target = prop_oneof![8 => Just(1u8), 4 => Just(255u8), 1 => Just(0u8), 1 => any::<u8>()];
    let mission_type = prop_oneof![6 => 0u8..3, 1 => any::<u8>()];
    let numbers = (small_or_any_u16(), -2i16..700, -2i16..700, 0u8..17);
    (0u8..9, target, mission_type, numbers, any_item()).prop_map(
        |(kind, target_system, mission_type, (seq, start_index, end_index, mavtype), item)| {
            let target_component = 0;
            match kind {
                0 => Message::MISSION_REQUEST_LIST(MISSION_REQUEST_LIST_DATA {
                    target_system,
                    target_component,
                    mission_type,
                }),
                1 => Message::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
                    seq,
                    target_system,
                    target_component,
                    mission_type,
                }),
                2 => Message::MISSION_REQUEST(MISSION_REQUEST_DATA {
                    seq,
                    target_system,
                    target_component,
                    mission_type,
                }),
                3 => Message::MISSION_COUNT(MISSION_COUNT_DATA {
                    count: seq,
                    target_system,
                    target_component,
                    mission_type,
                    opaque_id: 0,
                }),
                4 => Message::MISSION_ACK(MISSION_ACK_DATA {
                    target_system,
                    target_component,
                    mavtype,
                    mission_type,
                    opaque_id: 0,
                }),
                5 => Message::MISSION_WRITE_PARTIAL_LIST(MISSION_WRITE_PARTIAL_LIST_DATA {
                    start_index,
                    end_index,
                    target_system,
                    target_component,
                    mission_type,
                }),
                6 => Message::MISSION_CLEAR_ALL(MISSION_CLEAR_ALL_DATA {
                    target_system,
                    target_component,
                    mission_type,
                }),
                7 => Message::MISSION_ITEM(item.to_float_message(seq, target_system, 0, mission_type)),
                _ => Message::MISSION_ITEM_INT(item.to_int_message(seq, target_system, 0, mission_type)),
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_server_survives_anything_and_comes_to_rest(
        messages in prop::collection::vec((any_message(), 0u32..3, 0u8..2, 0.0..1.5f64), 0..120),
    ) {
        let mut server = MissionServer::new(Settings::default());
        let mut now = at(0.0);
        for (message, link, component, pause_s) in messages {
            now += at(pause_s);
            let from = Identity { system: 255, component };
            server.on_message(now, LinkId(link), from, BOAT, &message);
            while server.poll(now).is_some() {}
            for mission_type in MissionType::ALL {
                prop_assert!(server.count(mission_type) <= CAPACITY);
            }
        }
        now += GIVE_UP;
        while server.poll(now).is_some() {}
        prop_assert_eq!(server.next_deadline(), None);
    }

    #[test]
    fn clients_survive_anything_and_end(
        messages in prop::collection::vec((any_message(), 0.0..1.0f64), 0..400),
        mission_type in prop::sample::select(&MissionType::ALL[..]),
    ) {
        let mut upload = Upload::new(exchange(mission_type), &plan(mission_type, 4));
        let mut download = Download::new(exchange(mission_type));
        let mut now = at(0.0);
        let mut uploaded = 0;
        let mut talk = |now, message: Option<&Message>| {
            if let Some(message) = message {
                upload.on_message(now, BOAT, message);
                download.on_message(now, BOAT, message);
            }
            uploaded += std::iter::from_fn(|| upload.poll(now)).count();
            while download.poll(now).is_some() {}
            upload.outcome().is_some() && download.outcome().is_some()
        };
        for (message, pause_s) in &messages {
            now += at(*pause_s);
            talk(now, Some(message));
        }
        // Then silence, and both must come to an end.
        let ended = (0..40).any(|_| {
            now += at(0.5);
            talk(now, None)
        });
        prop_assert!(ended);
        prop_assert!(uploaded <= 6 * ATTEMPTS as usize);
    }
}

#[test]
fn a_vehicle_that_never_settles_on_a_count_is_not_followed_for_ever() {
    let mut download = Download::new(exchange(MissionType::Mission));
    let mut now = at(0.0);
    let mut sent = 0;
    while download.outcome().is_none() {
        sent += std::iter::from_fn(|| download.poll(now)).count();
        let count = if sent % 2 == 0 { 3 } else { 4 };
        let count = MISSION_COUNT_DATA { target_system: 255, count, ..MISSION_COUNT_DATA::DEFAULT };
        download.on_message(now, BOAT, &Message::MISSION_COUNT(count));
        now += at(0.1);
        assert!(now < at(60.0));
    }
    assert!(download.outcome().unwrap().is_err());
}
