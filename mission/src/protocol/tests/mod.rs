//! Both ends against each other over bad links, and the server against the habits of other programs.

use std::time::Duration;

use helmlink_wire::Identity;
use helmlink_wire::dialect::Message;
use helmlink_wire::enums::*;

use super::MissionType;
use super::client::Exchange;
use crate::geodesy::Geodetic;
use crate::plan::{Item, Mission};

mod channel;
mod client_rules;
mod hostile;
mod lossy;
mod other_programs;
mod server_rules;

const BOAT: Identity = Identity { system: 1, component: 1 };
const STATION: Identity = Identity { system: 255, component: 190 };

fn exchange(mission_type: MissionType) -> Exchange {
    Exchange::with_ardupilot(STATION, BOAT, mission_type)
}

fn at(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

/// `count` different items of a type, home left out.
fn items(mission_type: MissionType, count: u16) -> Vec<Item> {
    let command = match mission_type {
        MissionType::Mission => MAV_CMD_NAV_WAYPOINT,
        MissionType::Fence => MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
        MissionType::Rally => MAV_CMD_NAV_RALLY_POINT,
    };
    let item = |n: u16| Item {
        command,
        params: [f32::from(n), 2.0, 0.0, 0.25],
        z: f32::from(n) / 8.0,
        ..Item::waypoint(Geodetic::from_e7(435_350_000 + i32::from(n) * 1000, -56_500_000 - i32::from(n)))
    };
    (1..=count).map(item).collect()
}

fn plan(mission_type: MissionType, count: u16) -> Mission {
    Mission { home: None, items: items(mission_type, count) }
}

/// The result and type of plan of a MISSION_ACK.
fn ack(message: &Message) -> Option<(u8, u8)> {
    match message {
        Message::MISSION_ACK(m) => Some((m.mavtype, m.mission_type)),
        _ => None,
    }
}

/// The item number that a MISSION_REQUEST asks for.
fn request(message: &Message) -> Option<u16> {
    match message {
        Message::MISSION_REQUEST(m) => Some(m.seq),
        _ => None,
    }
}
