//! Exchanges as other programs hold them: pymavlink 2.4.50, MAVProxy 1.8.75 and MAVSDK 4.1.0, observed.

use helmlink_wire::LinkId;
use helmlink_wire::dialect::*;

use super::*;
use crate::protocol::server::{MissionServer, Settings};

const MAVPROXY: Identity = Identity { system: 255, component: 230 };
const MAVSDK: Identity = Identity { system: 245, component: 190 };
const FIRST: LinkId = LinkId(1);
const SECOND: LinkId = LinkId(2);

fn server_with(count: u16) -> MissionServer {
    let mut server = MissionServer::new(Settings::default());
    server.set_items(MissionType::Mission, &items(MissionType::Mission, count)).unwrap();
    server
}

fn say(server: &mut MissionServer, link: LinkId, from: Identity, message: Message) -> Vec<(LinkId, Message)> {
    assert!(server.on_message(at(1.0), link, from, BOAT, &message));
    std::iter::from_fn(|| server.poll(at(1.0))).collect()
}

fn count_message(count: u16) -> Message {
    let data =
        MISSION_COUNT_DATA { target_system: 1, target_component: 1, count, ..MISSION_COUNT_DATA::DEFAULT };
    Message::MISSION_COUNT(data)
}

#[test]
fn mavproxy_asks_for_five_items_at_once() {
    let mut server = server_with(6);
    for seq in [1, 2, 3, 4, 5] {
        let data = MISSION_REQUEST_INT_DATA {
            target_system: 1,
            target_component: 1,
            seq,
            ..MISSION_REQUEST_INT_DATA::DEFAULT
        };
        server.on_message(at(1.0), FIRST, MAVPROXY, BOAT, &Message::MISSION_REQUEST_INT(data));
    }
    let served: Vec<_> = std::iter::from_fn(|| server.poll(at(1.0)))
        .map(|(link, message)| match message {
            Message::MISSION_ITEM_INT(m) => (link, m.seq, m.target_system, m.target_component, m.current),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(served, [1, 2, 3, 4, 5].map(|seq| (FIRST, seq, 255, 230, 0)));
}

#[test]
fn mavsdk_clears_a_raw_mission_by_uploading_one_empty_item() {
    let mut server = server_with(6);
    let replies = say(&mut server, FIRST, MAVSDK, count_message(1));
    let [(FIRST, Message::MISSION_REQUEST(asked))] = &replies[..] else { panic!("{replies:?}") };
    assert_eq!((asked.seq, asked.target_system, asked.target_component), (0, 245, 190));
    let empty = MISSION_ITEM_INT_DATA {
        target_system: 1,
        target_component: 1,
        frame: 3,
        command: 16,
        current: 1,
        ..MISSION_ITEM_INT_DATA::DEFAULT
    };
    let replies = say(&mut server, FIRST, MAVSDK, Message::MISSION_ITEM_INT(empty));
    assert_eq!(replies.iter().map(|(_, m)| ack(m)).collect::<Vec<_>>(), [Some((MAV_MISSION_ACCEPTED, 0))]);
    assert!(server.items(MissionType::Mission).is_empty());
    assert_eq!(server.count(MissionType::Mission), 1);
}

#[test]
fn mavsdk_sends_its_mission_items_with_nan_where_it_has_nothing_to_say() {
    let mut server = server_with(0);
    let waypoint = MISSION_ITEM_INT_DATA {
        target_system: 1,
        target_component: 1,
        frame: 3,
        command: 16,
        autocontinue: 1,
        param2: 1.0,
        param4: f32::NAN,
        x: 435_350_000,
        y: -56_500_000,
        ..MISSION_ITEM_INT_DATA::DEFAULT
    };
    let speed = MISSION_ITEM_INT_DATA {
        seq: 1,
        frame: 2,
        command: MAV_CMD_DO_CHANGE_SPEED,
        param1: 1.0,
        param2: 2.5,
        param3: -1.0,
        z: f32::NAN,
        x: 0,
        y: 0,
        ..waypoint.clone()
    };
    let last = MISSION_ITEM_INT_DATA { seq: 2, ..waypoint.clone() };
    say(&mut server, FIRST, MAVSDK, count_message(3));
    let replies: Vec<_> = [waypoint, speed, last]
        .into_iter()
        .flat_map(|item| say(&mut server, FIRST, MAVSDK, Message::MISSION_ITEM_INT(item)))
        .collect();
    assert_eq!(replies.last().and_then(|(_, m)| ack(m)), Some((MAV_MISSION_ACCEPTED, 0)));
    assert_eq!(server.items(MissionType::Mission).len(), 2);
}

#[test]
fn two_stations_on_two_links_each_get_their_own_answers() {
    // MAVSDK takes any MISSION_ACK it sees for its own, whomever it is addressed to.
    let mut server = server_with(2);
    let clear_fence = MISSION_CLEAR_ALL_DATA {
        target_system: 1,
        target_component: 1,
        mission_type: MAV_MISSION_TYPE_FENCE,
    };
    server.on_message(at(1.0), FIRST, MAVSDK, BOAT, &count_message(2));
    server.on_message(at(1.0), SECOND, MAVPROXY, BOAT, &Message::MISSION_CLEAR_ALL(clear_fence));
    let replies: Vec<_> = std::iter::from_fn(|| server.poll(at(1.0))).collect();
    assert_eq!(replies.len(), 2);
    assert!(replies[0].0 == FIRST && request(&replies[0].1) == Some(0));
    assert!(replies[1].0 == SECOND && ack(&replies[1].1) == Some((MAV_MISSION_ACCEPTED, 1)));
}

#[test]
fn pymavlink_in_mavlink_1_speaks_floats_both_ways() {
    let mut server = server_with(0);
    // MAVLink 1 has no type of plan on the wire: it arrives as 0.
    say(&mut server, FIRST, STATION, count_message(2));
    for seq in 0..2 {
        let item = MISSION_ITEM_DATA {
            target_system: 1,
            target_component: 1,
            seq,
            frame: 3,
            command: 16,
            autocontinue: 1,
            x: 43.5,
            y: -5.75,
            ..MISSION_ITEM_DATA::DEFAULT
        };
        say(&mut server, FIRST, STATION, Message::MISSION_ITEM(item));
    }
    let stored = server.items(MissionType::Mission)[0];
    assert_eq!((stored.x, stored.y), (435_000_000, -57_500_000));
    let ask = MISSION_REQUEST_DATA {
        target_system: 1,
        target_component: 1,
        seq: 1,
        ..MISSION_REQUEST_DATA::DEFAULT
    };
    let replies = say(&mut server, FIRST, STATION, Message::MISSION_REQUEST(ask));
    assert!(matches!(&replies[..], [(FIRST, Message::MISSION_ITEM(m))] if m.x == 43.5 && m.y == -5.75));
}

#[test]
fn mavproxy_moves_one_waypoint() {
    let mut server = server_with(4);
    let write = MISSION_WRITE_PARTIAL_LIST_DATA {
        target_system: 1,
        target_component: 1,
        start_index: 2,
        end_index: 2,
        mission_type: 0,
    };
    let replies = say(&mut server, FIRST, MAVPROXY, Message::MISSION_WRITE_PARTIAL_LIST(write));
    assert_eq!(replies.iter().map(|(_, m)| request(m)).collect::<Vec<_>>(), [Some(2)]);
    let moved = Item::waypoint(Geodetic::from_e7(1, 2)).to_int_message(2, 1, 1, 0);
    let replies = say(&mut server, FIRST, MAVPROXY, Message::MISSION_ITEM_INT(moved));
    assert_eq!(ack(&replies[0].1), Some((MAV_MISSION_ACCEPTED, 0)));
    let places: Vec<_> = server.items(MissionType::Mission).iter().map(|item| item.x).collect();
    assert_eq!(places, [435_351_000, 1, 435_353_000, 435_354_000]);
}
