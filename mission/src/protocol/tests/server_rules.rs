//! What the server does with single messages.

use helmlink_wire::LinkId;
use helmlink_wire::dialect::*;

use super::*;
use crate::protocol::items::Received;
use crate::protocol::server::{MissionServer, Settings};

const LINK: LinkId = LinkId(1);
const OTHER_LINK: LinkId = LinkId(2);

/// A server with a link that loses nothing: what goes in, what comes out.
struct Bench {
    server: MissionServer,
    now: Duration,
}

impl Bench {
    fn new() -> Self {
        Self { server: MissionServer::new(Settings::default()), now: at(10.0) }
    }

    fn with_mission(count: u16) -> Self {
        let mut bench = Self::new();
        bench.server.set_items(MissionType::Mission, &items(MissionType::Mission, count)).unwrap();
        bench.server.take_changed();
        bench
    }

    fn wait(&mut self, seconds: f64) -> Vec<Message> {
        self.now += at(seconds);
        self.replies()
    }

    fn say(&mut self, message: Message) -> Vec<Message> {
        self.say_as(LINK, STATION, message)
    }

    fn say_as(&mut self, link: LinkId, from: Identity, message: Message) -> Vec<Message> {
        assert!(self.server.on_message(self.now, link, from, BOAT, &message));
        let replies: Vec<_> = std::iter::from_fn(|| self.server.poll(self.now)).collect();
        assert!(replies.iter().all(|(to, _)| *to == link), "a reply on another link than the question's");
        replies.into_iter().map(|(_, message)| message).collect()
    }

    fn replies(&mut self) -> Vec<Message> {
        std::iter::from_fn(|| self.server.poll(self.now)).map(|(_, message)| message).collect()
    }

    fn result(&mut self, message: Message) -> u8 {
        let replies = self.say(message);
        assert_eq!(replies.len(), 1, "{replies:?}");
        ack(&replies[0]).unwrap_or_else(|| panic!("no ack: {replies:?}")).0
    }

    /// The result of uploading `item` as item 1 of a plan of two.
    fn verdict_on(&mut self, item: Item) -> u8 {
        self.say(count(2));
        self.say(item_int(0, Item::waypoint(Geodetic::from_e7(0, 0))));
        self.result(item_int(1, item))
    }
}

fn count(count: u16) -> Message {
    count_of(count, 0)
}

fn count_of(count: u16, mission_type: u8) -> Message {
    Message::MISSION_COUNT(MISSION_COUNT_DATA {
        target_system: 1,
        count,
        mission_type,
        ..MISSION_COUNT_DATA::DEFAULT
    })
}

fn list(mission_type: u8) -> Message {
    Message::MISSION_REQUEST_LIST(MISSION_REQUEST_LIST_DATA {
        target_system: 1,
        target_component: 1,
        mission_type,
    })
}

fn clear(mission_type: u8) -> Message {
    Message::MISSION_CLEAR_ALL(MISSION_CLEAR_ALL_DATA { target_system: 1, target_component: 1, mission_type })
}

fn item_int(seq: u16, item: Item) -> Message {
    Message::MISSION_ITEM_INT(item.to_int_message(seq, 1, 1, 0))
}

fn fence_int(seq: u16, item: Item) -> Message {
    Message::MISSION_ITEM_INT(item.to_int_message(seq, 1, 1, 1))
}

fn request_int(seq: u16) -> Message {
    Message::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
        target_system: 1,
        seq,
        ..MISSION_REQUEST_INT_DATA::DEFAULT
    })
}

fn partial(start_index: i16, end_index: i16) -> Message {
    Message::MISSION_WRITE_PARTIAL_LIST(MISSION_WRITE_PARTIAL_LIST_DATA {
        target_system: 1,
        start_index,
        end_index,
        ..MISSION_WRITE_PARTIAL_LIST_DATA::DEFAULT
    })
}

fn waypoint() -> Item {
    Item::waypoint(Geodetic::from_e7(435_350_000, -56_500_000))
}

fn count_in(replies: &[Message]) -> Option<u16> {
    match replies {
        [Message::MISSION_COUNT(m)] => Some(m.count),
        _ => None,
    }
}

#[test]
fn an_upload_asks_with_the_old_request_and_ends_with_one_ack() {
    let mut bench = Bench::new();
    assert_eq!(bench.say(count(3)).iter().map(request).collect::<Vec<_>>(), [Some(0)]);
    for seq in 0..2 {
        let replies = bench.say(item_int(seq, waypoint()));
        assert_eq!(replies.iter().map(request).collect::<Vec<_>>(), [Some(seq + 1)]);
        assert_eq!(bench.server.take_changed(), None, "nothing changes before the last item");
    }
    assert_eq!(bench.result(item_int(2, waypoint())), MAV_MISSION_ACCEPTED);
    assert_eq!(bench.server.take_changed(), Some(MissionType::Mission));
    assert_eq!((bench.server.take_changed(), bench.server.items(MissionType::Mission).len()), (None, 2));
}

#[test]
fn the_newer_request_can_be_chosen() {
    let mut server = MissionServer::new(Settings { ask_with_int: true, ..Settings::default() });
    server.on_message(at(0.0), LINK, STATION, BOAT, &count(1));
    assert!(matches!(server.poll(at(0.0)), Some((LINK, Message::MISSION_REQUEST_INT(_)))));
}

#[test]
fn item_0_reads_back_as_home_whatever_was_sent() {
    let mut bench = Bench::new();
    bench.say(count(2));
    bench.say(item_int(0, Item { command: 9999, z: f32::NAN, ..waypoint() }));
    bench.say(item_int(1, waypoint()));
    for (home, expected) in [(None, (0, 0, 0.0)), (Some((Geodetic::from_e7(10, 20), 7.5)), (10, 20, 7.5))] {
        bench.server.set_home(home);
        let replies = bench.say(request_int(0));
        let item = Received::from_message(&replies[0]).unwrap().item;
        assert_eq!((item.command, item.frame), (MAV_CMD_NAV_WAYPOINT, MAV_FRAME_GLOBAL));
        assert_eq!((item.x, item.y, item.z), expected);
    }
}

#[test]
fn frames_read_back_as_their_older_twins() {
    let mut bench = Bench::new();
    let frames = [(0, 0), (2, 2), (3, 3), (5, 0), (6, 3), (10, 10), (11, 10)];
    bench.say(count(frames.len() as u16 + 1));
    bench.say(item_int(0, waypoint()));
    for (n, (sent, _)) in frames.into_iter().enumerate() {
        bench.say(item_int(n as u16 + 1, Item { frame: sent, ..waypoint() }));
    }
    let kept: Vec<_> = bench.server.items(MissionType::Mission).iter().map(|item| item.frame).collect();
    assert_eq!(kept, frames.map(|(_, kept)| kept));
}

#[test]
fn bad_items_are_refused_as_the_firmware_refuses_them_and_the_old_mission_stays() {
    let mut bench = Bench::with_mission(4);
    let w = waypoint();
    let cases = [
        (Item { frame: 1, ..w }, MAV_MISSION_UNSUPPORTED_FRAME),
        (Item { frame: 99, ..w }, MAV_MISSION_UNSUPPORTED_FRAME),
        (Item { command: 42, ..w }, MAV_MISSION_UNSUPPORTED),
        (Item { command: 5001, ..w }, MAV_MISSION_UNSUPPORTED),
        (Item { command: 30000, ..w }, MAV_MISSION_UNSUPPORTED),
        (Item { command: 177, ..w }, MAV_MISSION_ERROR),
        (Item { x: 950_000_000, ..w }, MAV_MISSION_INVALID_PARAM5_X),
        (Item { x: i32::MIN, ..w }, MAV_MISSION_INVALID_PARAM5_X),
        (Item { y: 1_900_000_000, ..w }, MAV_MISSION_INVALID_PARAM6_Y),
        (Item { z: f32::NAN, ..w }, MAV_MISSION_INVALID_PARAM7),
        (Item { params: [f32::NAN, 0.0, 0.0, 0.0], ..w }, MAV_MISSION_INVALID_PARAM1),
        (Item { params: [0.0, 0.0, 0.0, f32::NAN], ..w }, MAV_MISSION_ACCEPTED),
        (Item { x: 0, y: 0, ..w }, MAV_MISSION_ACCEPTED),
    ];
    for (item, expected) in cases {
        let before = bench.server.items(MissionType::Mission).to_vec();
        assert_eq!(bench.verdict_on(item), expected, "{item:?}");
        let unchanged = bench.server.items(MissionType::Mission) == before;
        assert_eq!(unchanged, expected != MAV_MISSION_ACCEPTED);
    }
}

#[test]
fn silence_is_asked_about_each_second_and_cancelled_after_eight() {
    let mut bench = Bench::with_mission(2);
    bench.say(count(5));
    bench.say(item_int(0, waypoint()));
    for _ in 0..7 {
        assert_eq!(bench.wait(0.9), []);
        assert_eq!(bench.wait(0.1).iter().map(request).collect::<Vec<_>>(), [Some(1)]);
    }
    let replies = bench.wait(1.0);
    assert_eq!(replies.iter().map(ack).collect::<Vec<_>>(), [Some((MAV_MISSION_OPERATION_CANCELLED, 0))]);
    assert_eq!((bench.wait(60.0), bench.server.next_deadline()), (vec![], None));
    assert_eq!(bench.server.items(MissionType::Mission), items(MissionType::Mission, 2));
}

#[test]
fn one_client_at_a_time_replaces_a_plan() {
    let other = Identity { system: 245, component: 190 };
    let mut bench = Bench::with_mission(2);
    bench.say(count(3));
    for message in [count(9), list(0), partial(1, 1)] {
        let replies = bench.say_as(OTHER_LINK, other, message);
        assert_eq!(replies.iter().map(ack).collect::<Vec<_>>(), [Some((MAV_MISSION_DENIED, 0))]);
    }
    // The same address on another link is another client, and items of others are not taken.
    let replies = bench.say_as(OTHER_LINK, STATION, count(9));
    assert_eq!(replies.first().and_then(ack), Some((MAV_MISSION_DENIED, 0)));
    assert_eq!(bench.say_as(OTHER_LINK, STATION, item_int(0, waypoint())), []);
    assert_eq!(bench.result(clear(0)), MAV_MISSION_ERROR);
    // Single items and the other types stay open to all.
    assert_eq!(bench.say_as(OTHER_LINK, other, request_int(1)).len(), 1);
    assert_eq!(count_in(&bench.say_as(OTHER_LINK, other, list(1))), Some(0));
    // Its own count starts the upload over.
    assert_eq!(request(&bench.say(item_int(0, waypoint()))[0]), Some(1));
    assert_eq!(request(&bench.say(count(2))[0]), Some(0));
}

#[test]
fn repeated_items_bring_the_next_request_and_never_invalid_sequence() {
    let mut bench = Bench::new();
    bench.say(count(4));
    bench.say(item_int(0, waypoint()));
    assert_eq!(bench.say(item_int(0, waypoint())), [], "a copy made by the link");
    bench.now += at(0.5);
    for seq in [0, 3] {
        assert_eq!(bench.say(item_int(seq, waypoint())).iter().map(request).collect::<Vec<_>>(), [Some(1)]);
        bench.now += at(0.5);
    }
}

#[test]
fn a_client_that_missed_the_verdict_is_told_again() {
    let mut bench = Bench::new();
    bench.say(count(1));
    bench.say(item_int(0, waypoint()));
    bench.now += at(0.5);
    assert_eq!(bench.result(item_int(0, waypoint())), MAV_MISSION_ACCEPTED);
    bench.now += at(8.0);
    assert_eq!(bench.say(item_int(0, waypoint())), [], "long over");
}

#[test]
fn a_client_may_cancel_its_upload() {
    let mut bench = Bench::with_mission(2);
    bench.say(count(3));
    let cancel = MISSION_ACK_DATA {
        target_system: 1,
        mavtype: MAV_MISSION_OPERATION_CANCELLED,
        ..MISSION_ACK_DATA::DEFAULT
    };
    assert_eq!(bench.say(Message::MISSION_ACK(cancel)), []);
    assert_eq!(bench.wait(20.0), []);
    assert_eq!(bench.server.items(MissionType::Mission).len(), 2);
}

#[test]
fn counts_include_home_and_an_empty_mission_has_none() {
    let mut bench = Bench::with_mission(5);
    assert_eq!(count_in(&bench.say(list(0))), Some(6));
    assert_eq!(bench.result(count(0)), MAV_MISSION_ACCEPTED);
    assert_eq!(count_in(&bench.say(list(0))), Some(0));
    assert_eq!(bench.server.take_changed(), Some(MissionType::Mission));
}

#[test]
fn too_many_items_do_not_fit() {
    let mut bench = Bench::new();
    assert_eq!(bench.result(count(656)), MAV_MISSION_NO_SPACE);
    assert_eq!(request(&bench.say(count(655))[0]), Some(0));
    let route = items(MissionType::Mission, 655);
    assert_eq!(bench.server.set_items(MissionType::Mission, &route), Err(655));
}

#[test]
fn clearing_is_per_type_or_of_all() {
    let mut bench = Bench::with_mission(2);
    for mission_type in MissionType::ALL {
        bench.server.set_items(mission_type, &items(mission_type, 3)).unwrap();
    }
    while bench.server.take_changed().is_some() {}
    assert_eq!(bench.result(clear(1)), MAV_MISSION_ACCEPTED);
    let left = MissionType::ALL.map(|t| bench.server.items(t).len());
    assert_eq!((left, bench.server.take_changed()), ([3, 0, 3], Some(MissionType::Fence)));
    bench.server.set_in_auto(true);
    assert_eq!(bench.result(clear(0)), MAV_MISSION_ERROR);
    assert_eq!(bench.result(clear(MAV_MISSION_TYPE_ALL)), MAV_MISSION_ERROR);
    bench.server.set_in_auto(false);
    let replies = bench.say(clear(MAV_MISSION_TYPE_ALL));
    assert_eq!(ack(&replies[0]), Some((MAV_MISSION_ACCEPTED, MAV_MISSION_TYPE_ALL)));
    assert_eq!(MissionType::ALL.map(|t| bench.server.items(t).len()), [0, 0, 0]);
}

#[test]
fn unknown_types_and_items_are_refused() {
    let mut bench = Bench::with_mission(2);
    for message in [list(255), list(3), count_of(4, 255), clear(7)] {
        assert_eq!(bench.result(message), MAV_MISSION_UNSUPPORTED);
    }
    assert_eq!(bench.result(request_int(3)), MAV_MISSION_ERROR);
}

#[test]
fn other_systems_and_guided_items_are_none_of_its_business() {
    let mut bench = Bench::with_mission(2);
    let to_other = MISSION_REQUEST_LIST_DATA { target_system: 2, ..MISSION_REQUEST_LIST_DATA::DEFAULT };
    let guided = MISSION_ITEM_DATA { target_system: 1, current: 2, ..MISSION_ITEM_DATA::DEFAULT };
    let set_current = MISSION_SET_CURRENT_DATA { target_system: 1, ..MISSION_SET_CURRENT_DATA::DEFAULT };
    for message in [
        Message::MISSION_REQUEST_LIST(to_other),
        Message::MISSION_ITEM(guided),
        Message::MISSION_SET_CURRENT(set_current),
        Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT),
    ] {
        assert!(!bench.server.on_message(bench.now, LINK, STATION, BOAT, &message));
    }
    assert_eq!(bench.replies(), []);
    // Any component of the own system, and system 0, are meant.
    let to_all = MISSION_REQUEST_LIST_DATA { target_component: 77, ..MISSION_REQUEST_LIST_DATA::DEFAULT };
    assert_eq!(count_in(&bench.say(Message::MISSION_REQUEST_LIST(to_all))), Some(3));
}

#[test]
fn part_of_a_plan_is_replaced_all_at_once() {
    let mut bench = Bench::with_mission(4);
    assert_eq!(request(&bench.say(partial(2, 3))[0]), Some(2));
    let moved = Item { z: 99.0, ..waypoint() };
    assert_eq!(request(&bench.say(item_int(2, moved))[0]), Some(3));
    assert_eq!(bench.server.items(MissionType::Mission), items(MissionType::Mission, 4));
    assert_eq!(bench.result(item_int(3, moved)), MAV_MISSION_ACCEPTED);
    let mut expected = items(MissionType::Mission, 4);
    expected[1..3].fill(moved);
    assert_eq!(bench.server.items(MissionType::Mission), expected);
    // One item more than there are lengthens the plan.
    bench.say(partial(5, 5));
    assert_eq!(bench.result(item_int(5, moved)), MAV_MISSION_ACCEPTED);
    assert_eq!(bench.server.count(MissionType::Mission), 6);
    for (start, end) in [(7, 7), (3, 2), (-1, 2)] {
        assert_eq!(bench.result(partial(start, end)), MAV_MISSION_ERROR);
    }
    assert_eq!(bench.result(partial(1, 655)), MAV_MISSION_NO_SPACE);
}

#[test]
fn fence_polygons_are_taken_whole_or_not_at_all() {
    let corner = |n: u16, size: f32| {
        let item = Item { command: MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, ..waypoint() };
        fence_int(n, Item { params: [size, 0.0, 0.0, 0.0], ..item })
    };
    for (size, corners, expected) in [
        (3.0, 3, MAV_MISSION_ACCEPTED),
        (4.0, 3, MAV_MISSION_ERROR),
        (3.0, 6, MAV_MISSION_ACCEPTED),
        (2.0, 2, MAV_MISSION_ERROR),
    ] {
        let mut bench = Bench::new();
        bench.say(count_of(corners, 1));
        let last = (0..corners).map(|n| bench.say(corner(n, size))).last().unwrap();
        assert_eq!(ack(&last[0]), Some((expected, 1)), "{corners} corners of {size}");
    }
}

#[test]
fn a_link_that_goes_takes_its_upload_along() {
    let mut bench = Bench::new();
    bench.say(count(3));
    bench.server.link_down(LINK);
    assert_eq!(bench.wait(5.0), []);
    assert_eq!(request(&bench.say_as(OTHER_LINK, STATION, count(3))[0]), Some(0));
}
