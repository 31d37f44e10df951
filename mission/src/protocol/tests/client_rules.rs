//! What the two client machines do with single messages.

use helmlink_wire::dialect::*;

use super::*;
use crate::protocol::client::{Download, TransferError, Upload};
use crate::protocol::result::MissionResult;

fn count(count: u16, mission_type: u8) -> Message {
    Message::MISSION_COUNT(MISSION_COUNT_DATA {
        target_system: 255,
        target_component: 190,
        count,
        mission_type,
        opaque_id: 0,
    })
}

fn request_40(seq: u16) -> Message {
    let data = MISSION_REQUEST_DATA {
        target_system: 255,
        target_component: 190,
        seq,
        ..MISSION_REQUEST_DATA::DEFAULT
    };
    Message::MISSION_REQUEST(data)
}

fn ack_of(result: u8) -> Message {
    let data = MISSION_ACK_DATA {
        target_system: 255,
        target_component: 190,
        mavtype: result,
        ..MISSION_ACK_DATA::DEFAULT
    };
    Message::MISSION_ACK(data)
}

fn seq_of_item(message: Option<Message>) -> Option<u16> {
    match message {
        Some(Message::MISSION_ITEM_INT(m)) => Some(m.seq),
        _ => None,
    }
}

fn seq_of_request(message: Option<Message>) -> Option<u16> {
    match message {
        Some(Message::MISSION_REQUEST_INT(m)) => Some(m.seq),
        _ => None,
    }
}

#[test]
fn an_upload_to_ardupilot_begins_with_home() {
    let home = Geodetic::from_e7(599_000_000, 107_000_000);
    let plan = Mission { home: Some(home), items: items(MissionType::Mission, 2) };
    let mut upload = Upload::new(exchange(MissionType::Mission), &plan);
    let Some(Message::MISSION_COUNT(m)) = upload.poll(at(0.0)) else { panic!() };
    assert_eq!((m.count, m.target_system, m.target_component), (3, 1, 1));
    upload.on_message(at(0.1), BOAT, &request_40(0));
    let Some(Message::MISSION_ITEM_INT(m)) = upload.poll(at(0.1)) else { panic!() };
    assert_eq!((m.seq, m.command, m.frame, m.x, m.y), (0, MAV_CMD_NAV_WAYPOINT, 0, 599_000_000, 107_000_000));
}

#[test]
fn other_autopilots_get_the_items_alone() {
    let exchange = Exchange { home_is_item_0: false, ..exchange(MissionType::Mission) };
    let mut upload = Upload::new(exchange, &plan(MissionType::Mission, 2));
    assert!(matches!(upload.poll(at(0.0)), Some(Message::MISSION_COUNT(m)) if m.count == 2));
}

#[test]
fn accepted_ends_an_upload_only_after_the_last_item() {
    let mut upload = Upload::new(exchange(MissionType::Mission), &plan(MissionType::Mission, 1));
    upload.poll(at(0.0));
    upload.on_message(at(0.1), BOAT, &ack_of(MAV_MISSION_ACCEPTED));
    assert_eq!(upload.outcome(), None);
    for seq in 0..2 {
        upload.on_message(at(0.2), BOAT, &request_40(seq));
        assert_eq!(seq_of_item(upload.poll(at(0.2))), Some(seq));
    }
    assert_eq!(upload.progress().done, 2);
    upload.on_message(at(0.3), BOAT, &ack_of(MAV_MISSION_ACCEPTED));
    assert_eq!(upload.outcome(), Some(Ok(())));
    assert_eq!((upload.poll(at(9.0)), upload.next_deadline()), (None, None));
}

#[test]
fn invalid_sequence_is_not_the_end_but_other_results_are() {
    let mut upload = Upload::new(exchange(MissionType::Mission), &plan(MissionType::Mission, 2));
    upload.poll(at(0.0));
    upload.on_message(at(0.1), BOAT, &request_40(0));
    upload.poll(at(0.1));
    upload.on_message(at(0.2), BOAT, &ack_of(MAV_MISSION_INVALID_SEQUENCE));
    assert_eq!(upload.outcome(), None);
    upload.on_message(at(0.3), BOAT, &ack_of(MAV_MISSION_UNSUPPORTED));
    let error = upload.outcome().unwrap().unwrap_err();
    assert_eq!(
        error,
        TransferError::Refused {
            vehicle: BOAT,
            item: Some(0),
            result: MissionResult(MAV_MISSION_UNSUPPORTED)
        }
    );
    assert_eq!(
        error.to_string(),
        "vehicle 1/1 refused the plan at item 0: UNSUPPORTED (3), it does not know a command or the type of plan"
    );
}

#[test]
fn one_request_copied_on_the_way_is_answered_once() {
    let mut upload = Upload::new(exchange(MissionType::Mission), &plan(MissionType::Mission, 2));
    upload.poll(at(0.0));
    upload.on_message(at(1.0), BOAT, &request_40(0));
    assert_eq!(seq_of_item(upload.poll(at(1.0))), Some(0));
    upload.on_message(at(1.05), BOAT, &request_40(0));
    assert_eq!(upload.poll(at(1.05)), None);
    // A second later it is a question asked again.
    upload.on_message(at(1.45), BOAT, &request_40(0));
    assert_eq!(seq_of_item(upload.poll(at(1.45))), Some(0));
}

#[test]
fn a_silent_vehicle_is_asked_sixteen_times() {
    let mut upload = Upload::new(exchange(MissionType::Mission), &plan(MissionType::Mission, 2));
    let mut sent = Vec::new();
    while let Some(deadline) = upload.next_deadline() {
        if upload.poll(deadline).is_some() {
            sent.push(deadline.as_secs_f64());
        }
    }
    assert_eq!((sent.len(), sent[1], sent[2], sent[15]), (16, 1.5, 2.0, 8.5));
    assert_eq!(upload.outcome(), Some(Err(TransferError::NoAnswer { vehicle: BOAT, waited_s: 9 })));
}

#[test]
fn a_vehicle_that_keeps_asking_for_one_item_does_not_hold_an_upload_for_ever() {
    let mut upload = Upload::new(exchange(MissionType::Mission), &plan(MissionType::Mission, 5));
    upload.poll(at(0.0));
    let mut answers = 0;
    for n in 1..200 {
        let now = at(f64::from(n) * 0.3);
        upload.on_message(now, BOAT, &request_40(2));
        answers += usize::from(upload.poll(now).is_some());
    }
    assert_eq!(answers, 16);
    assert_eq!(upload.outcome(), Some(Err(TransferError::Stalled { vehicle: BOAT, item: 2, total: 6 })));
}

#[test]
fn a_lost_acceptance_is_not_called_a_refusal() {
    let mut upload = Upload::new(exchange(MissionType::Mission), &plan(MissionType::Mission, 0));
    upload.poll(at(0.0));
    upload.on_message(at(0.1), BOAT, &request_40(0));
    upload.poll(at(0.1));
    assert_eq!(seq_of_item(upload.poll(at(1.6))), Some(0), "after the longer wait");
    upload.on_message(at(1.7), BOAT, &ack_of(MAV_MISSION_ERROR));
    assert_eq!(upload.outcome(), Some(Err(TransferError::Unconfirmed { vehicle: BOAT, total: 1 })));
}

#[test]
fn strangers_and_messages_for_strangers_are_ignored() {
    let mut upload = Upload::new(exchange(MissionType::Mission), &plan(MissionType::Mission, 2));
    upload.poll(at(0.0));
    let other_boat = Identity { system: 2, component: 1 };
    assert!(!upload.on_message(at(0.1), other_boat, &request_40(0)));
    let to_other =
        MISSION_REQUEST_DATA { target_system: 245, target_component: 190, ..MISSION_REQUEST_DATA::DEFAULT };
    assert!(!upload.on_message(at(0.1), BOAT, &Message::MISSION_REQUEST(to_other)));
    let of_fence =
        MISSION_REQUEST_DATA { target_system: 255, mission_type: 1, ..MISSION_REQUEST_DATA::DEFAULT };
    assert!(!upload.on_message(at(0.1), BOAT, &Message::MISSION_REQUEST(of_fence)));
    assert_eq!(upload.poll(at(0.1)), None);
}

#[test]
fn a_plan_without_items_is_downloaded_too() {
    for (total, home_is_item_0) in [(0, true), (0, false), (1, true)] {
        let mut download = Download::new(Exchange { home_is_item_0, ..exchange(MissionType::Mission) });
        assert!(matches!(download.poll(at(0.0)), Some(Message::MISSION_REQUEST_LIST(_))));
        download.on_message(at(0.1), BOAT, &count(total, 0));
        if total == 1 {
            assert_eq!(seq_of_request(download.poll(at(0.1))), Some(0));
            let home =
                MISSION_ITEM_INT_DATA { target_system: 255, command: 16, ..MISSION_ITEM_INT_DATA::DEFAULT };
            download.on_message(at(0.2), BOAT, &Message::MISSION_ITEM_INT(home));
        }
        assert_eq!(download.outcome(), None, "the thanks are still to be sent");
        assert_eq!(download.poll(at(0.3)).as_ref().and_then(ack), Some((MAV_MISSION_ACCEPTED, 0)));
        assert_eq!(download.outcome(), Some(Ok(&Mission::default())));
    }
}

#[test]
fn float_items_are_taken_and_home_is_kept_apart() {
    let mut download = Download::new(exchange(MissionType::Mission));
    download.poll(at(0.0));
    download.on_message(at(0.1), BOAT, &count(2, 0));
    for (seq, x, y) in [(0, 59.5, 10.5), (1, 59.75, 10.25)] {
        assert_eq!(seq_of_request(download.poll(at(0.2))), Some(seq));
        let item = MISSION_ITEM_DATA {
            target_system: 255,
            target_component: 190,
            seq,
            command: 16,
            frame: 3,
            x,
            y,
            ..MISSION_ITEM_DATA::DEFAULT
        };
        download.on_message(at(0.2), BOAT, &Message::MISSION_ITEM(item));
    }
    download.poll(at(0.3));
    let mission = download.outcome().unwrap().unwrap();
    assert_eq!(mission.home, Some(Geodetic::from_e7(595_000_000, 105_000_000)));
    assert_eq!((mission.items.len(), mission.items[0].x, mission.items[0].y), (1, 597_500_000, 102_500_000));
}

#[test]
fn a_new_count_starts_a_download_over_and_a_copy_does_not() {
    let mut download = Download::new(exchange(MissionType::Rally));
    download.poll(at(0.0));
    download.on_message(at(0.1), BOAT, &count(3, 2));
    download.poll(at(0.1));
    let item =
        MISSION_ITEM_INT_DATA { target_system: 255, mission_type: 2, ..MISSION_ITEM_INT_DATA::DEFAULT };
    download.on_message(at(0.2), BOAT, &Message::MISSION_ITEM_INT(item));
    download.on_message(at(0.2), BOAT, &count(3, 2));
    assert_eq!(seq_of_request(download.poll(at(0.2))), Some(1));
    download.on_message(at(0.3), BOAT, &count(2, 2));
    assert_eq!(seq_of_request(download.poll(at(0.3))), Some(0));
}

#[test]
fn a_refused_download_says_why() {
    let mut download = Download::new(exchange(MissionType::Mission));
    download.poll(at(0.0));
    download.on_message(at(0.1), BOAT, &ack_of(MAV_MISSION_DENIED));
    let text = download.outcome().unwrap().unwrap_err().to_string();
    assert!(text.starts_with("vehicle 1/1 refused the plan: DENIED (14), it takes no plan now"), "{text}");
}
