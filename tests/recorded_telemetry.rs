//! A recorded run of ArduRover 4.6, frames in and telemetry out. What is expected was read from the same log by
//! pymavlink.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::time::Duration;

use helmlink::vehicle::telemetry::{Sender, Update, classify};
use helmlink::vehicle::{Mode, Telemetry};
use helmlink_mission::plan::{Item, Mission};
use helmlink_mission::route::Route;
use helmlink_wire::tlog::records;
use helmlink_wire::{Framer, Identity, Message};

const LOG: &[u8] = include_bytes!("data/ardurover-4.6-motorboat.tlog");
const BOAT: Identity = Identity { system: 1, component: 1 };

/// What the telemetry layer makes of one message of the boat's.
struct Step {
    now: Duration,
    update: Update,
    message: Message,
}

/// The log's frames as one stream of bytes through the framer, and the boat's messages through the telemetry layer;
/// calls `look` after each. Returns how many messages there were, of everybody.
fn play(mut look: impl FnMut(&Telemetry, &Step)) -> usize {
    let (mut framer, mut telemetry, mut count) = (Framer::new(), Telemetry::default(), 0);
    for record in records(LOG) {
        framer.push(record.frame.bytes());
        let now = Duration::from_micros(record.time_us);
        while let Some(frame) = framer.next_frame() {
            count += 1;
            let message = frame.decode().unwrap();
            if frame.identity() == BOAT {
                let update = telemetry.on_message(now, &message);
                look(&telemetry, &Step { now, update, message });
            }
        }
    }
    count
}

#[test]
fn every_message_gets_through() {
    let mut refused = u64::MAX;
    assert_eq!(play(|telemetry, _| refused = telemetry.refused), 17_732);
    assert_eq!(refused, 0);
}

#[test]
fn the_boat_is_known_for_one_and_the_station_is_not() {
    for record in records(LOG) {
        if let Message::HEARTBEAT(heartbeat) = record.frame.decode().unwrap() {
            let from = record.frame.identity();
            let expected = if from == BOAT { Sender::Boat } else { Sender::NotAVehicle };
            assert_eq!(classify(from, &heartbeat), expected);
        }
    }
}

#[test]
fn modes_and_arming_are_followed() {
    let mut seen = Vec::new();
    play(|telemetry, step| {
        if step.update == Update::Heartbeat {
            let state = (telemetry.mode().unwrap(), telemetry.is_armed());
            if seen.last() != Some(&state) {
                seen.push(state);
            }
        }
    });
    assert_eq!(seen, [(Mode(16), false), (Mode::MANUAL, false), (Mode::AUTO, false), (Mode::AUTO, true)]);
}

#[test]
fn positions_are_the_boats_and_nowhere_at_first() {
    let (mut without, mut positions) = (0, Vec::new());
    play(|telemetry, step| match (&step.message, step.update) {
        (Message::GLOBAL_POSITION_INT(_), Update::Position(boot_s)) => {
            let position = telemetry.position.unwrap().value;
            assert_eq!(position.boot_s, boot_s);
            positions.push(position);
        }
        (Message::GLOBAL_POSITION_INT(_), update) => {
            assert_eq!(update, Update::None);
            without += 1;
        }
        _ => {}
    });
    // ArduRover says 0, 0 until it has a position.
    assert_eq!((without, positions.len()), (32, 1631 - 32));
    let middle = positions.iter().find(|position| position.boot_s == 88.452).unwrap();
    assert!((middle.place.latitude_deg - 43.535_638_9).abs() < 1e-9, "{middle:?}");
    assert!((middle.place.longitude_deg + 5.649_630_1).abs() < 1e-9, "{middle:?}");
    assert_eq!((middle.north_mps, middle.east_mps), (-5.0, -0.05));
    let last = positions.last().unwrap();
    assert_eq!((last.boot_s, last.north_mps, last.east_mps), (169.971, -0.02, -0.02));
    let sailed_m: f64 = positions.windows(2).map(|two| two[0].place.distance_m(two[1].place)).sum();
    // 492.7 m on a sphere, by pymavlink's reading; the ellipsoid differs by up to half a percent.
    assert!((sailed_m - 492.7).abs() < 2.5, "{sailed_m} m");
}

#[test]
fn headings_are_the_boats() {
    let mut headings = Vec::new();
    let mut reboots = 0;
    play(|telemetry, step| match step.update {
        Update::Attitude(_) => headings.push(telemetry.attitude.unwrap().value),
        Update::Rebooted => reboots += 1,
        _ => {}
    });
    assert_eq!((headings.len(), reboots), (3256, 0));
    let (first, last) = (headings[0], headings[3255]);
    assert!((first.heading_rad - 0.013_322_656).abs() < 1e-8 && first.boot_s == 3.052, "{first:?}");
    assert!((last.heading_rad + 3.138_112_307).abs() < 1e-8 && last.boot_s == 169.971, "{last:?}");
    assert!((last.yaw_rate_radps - 6.201_85e-4).abs() < 1e-8, "{last:?}");
}

#[test]
fn the_estimator_is_believed_only_when_it_knows_the_position() {
    let (mut count, mut first_ready) = (0, None);
    let mut armable_before = false;
    play(|telemetry, step| {
        if let Message::EKF_STATUS_REPORT(report) = &step.message {
            count += 1;
            let ready = telemetry.estimator_is_ready(step.now);
            assert_eq!(ready, report.flags == 831, "flags {}", report.flags);
            first_ready = first_ready.or(ready.then_some(count));
            armable_before |= !ready && report.flags == 167;
        }
    });
    assert_eq!(count, 166);
    assert!(first_ready.is_some() && armable_before);
}

#[test]
fn the_mission_and_its_progress_are_recovered() {
    let items: Vec<Item> = records(LOG)
        .filter_map(|record| match record.frame.decode().unwrap() {
            Message::MISSION_ITEM_INT(item) => Some(Item::from_int_message(&item)),
            _ => None,
        })
        .collect();
    assert_eq!(items.len(), 9, "home and eight waypoints");
    let mission = Mission { home: items[0].position(), items: items[1..].to_vec() };
    let route = Route::from_mission(&mission).unwrap();
    // Three lanes of 100 m and three steps of 30 m between them, and the last lane; the first waypoint is 20 m off.
    assert_eq!(route.waypoints.len(), 8);
    assert!((route.length_m() - 490.0).abs() < 1.0, "{} m", route.length_m());

    let (mut current, mut reached) = (Vec::new(), Vec::new());
    let mut nearest_m = vec![f64::INFINITY; 8];
    play(|telemetry, step| {
        if let Some(seq) = telemetry.mission_current.map(|current| current.value)
            && current.last() != Some(&seq)
        {
            current.push(seq);
        }
        if let Message::MISSION_ITEM_REACHED(item) = &step.message {
            reached.push(item.seq);
        }
        if let Some(position) = telemetry.position {
            for (waypoint, nearest_m) in route.waypoints.iter().zip(&mut nearest_m) {
                *nearest_m = nearest_m.min(position.value.place.distance_m(waypoint.position));
            }
        }
    });
    assert_eq!(current, (0..=8).collect::<Vec<u16>>());
    assert_eq!(reached, (1..=8).collect::<Vec<u16>>());
    assert!(nearest_m.iter().all(|&off_m| off_m < 3.0), "{nearest_m:?}");
}
