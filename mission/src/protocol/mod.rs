//! The MAVLink mission protocol, both ends, as pure state machines.
//!
//! | module | what it holds |
//! |---|---|
//! | [`client`] | fetch a plan from a vehicle, or send one to it: [`client::Download`], [`client::Upload`] |
//! | [`server`] | the vehicle's end, for any number of clients: [`server::MissionServer`] |
//! | [`result`] | what a MISSION_ACK says, in words |
//!
//! Time and messages come in as arguments, messages come out of `poll`; no machine owns a clock or a link.
//! Source: <https://mavlink.io/en/services/mission.html>; where ArduRover 4.6 was measured to differ from
//! that page, the place says so.

use std::time::Duration;

use helmlink_wire::enums::{MAV_MISSION_TYPE_FENCE, MAV_MISSION_TYPE_MISSION, MAV_MISSION_TYPE_RALLY};

pub mod client;
mod items;
pub mod result;
pub mod server;

#[cfg(test)]
mod tests;

/// A second message about the same item this soon after the first is taken for a copy made by the link,
/// not for a repeated question, and is not answered again.
///
/// Without it every copied packet would be answered by both ends until the end of the exchange. It is far
/// below the shortest repeat time in use (0.25 s on the protocol page).
pub const REPEAT_GUARD: Duration = Duration::from_millis(150);

/// The three kinds of plan a vehicle keeps apart (MAV_MISSION_TYPE).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MissionType {
    /// The route to sail.
    Mission,
    /// The area to stay in or out of.
    Fence,
    /// Places to return to.
    Rally,
}

impl MissionType {
    /// All kinds, in the order of their numbers.
    pub const ALL: [Self; 3] = [Self::Mission, Self::Fence, Self::Rally];

    /// The kind with MAV_MISSION_TYPE `number`; `None` for 255 (all kinds at once) and unknown numbers.
    pub fn from_wire(number: u8) -> Option<Self> {
        match number {
            MAV_MISSION_TYPE_MISSION => Some(Self::Mission),
            MAV_MISSION_TYPE_FENCE => Some(Self::Fence),
            MAV_MISSION_TYPE_RALLY => Some(Self::Rally),
            _ => None,
        }
    }

    /// Its MAV_MISSION_TYPE number.
    pub fn to_wire(self) -> u8 {
        match self {
            Self::Mission => MAV_MISSION_TYPE_MISSION,
            Self::Fence => MAV_MISSION_TYPE_FENCE,
            Self::Rally => MAV_MISSION_TYPE_RALLY,
        }
    }
}
