//! Why a mission is not a route.

use super::MAX_DISTANCE_M;
use crate::plan::CommandName;

/// Why a boat cannot carry out a mission. Items are named by their sequence number, 1 for the first after
/// home, as on the flight controller and in the first column of a waypoint file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RouteError {
    /// There is nowhere to go.
    #[error("the mission has no waypoint: add at least one MAV_CMD_NAV_WAYPOINT (16)")]
    NoWaypoint,
    /// More items than MAVLink can number.
    #[error("the mission has {0} items, more than the 65535 that MAVLink can number: split it")]
    TooLong(usize),
    /// A command a boat here cannot carry out.
    #[error(
        "item {item}: {command} cannot be carried out on a boat here; take it out of the mission (what can be is \
         listed in docs/missions.md: waypoints, loiters, speeds, delays, jumps, conditions, servos, relays, cameras)"
    )]
    Unsupported {
        /// Sequence number.
        item: u16,
        /// What it commands.
        command: CommandName,
    },
    /// A waypoint without latitude and longitude.
    #[error(
        "item {item}: {command} has no usable position ({latitude_deg}, {longitude_deg} in frame {frame}): \
         give it a latitude and longitude, in frame 3"
    )]
    NoPosition {
        /// Sequence number.
        item: u16,
        /// What it commands.
        command: CommandName,
        /// MAV_FRAME.
        frame: u8,
        /// Parameter 5.
        latitude_deg: f64,
        /// Parameter 6.
        longitude_deg: f64,
    },
    /// A waypoint far from all others.
    #[error(
        "item {item} is {distance_km:.0} km from {from}, more than the {limit_km:.0} km allowed: check its \
         latitude and longitude",
        limit_km = MAX_DISTANCE_M / 1e3
    )]
    TooFar {
        /// Sequence number.
        item: u16,
        /// How far it is, kilometres.
        distance_km: f64,
        /// From what: home or the first waypoint.
        from: &'static str,
    },
    /// A parameter with a value that means nothing to a boat.
    #[error("item {item}: {parameter} of {command} is {value}, expected {expected}")]
    Parameter {
        /// Sequence number.
        item: u16,
        /// What it commands.
        command: CommandName,
        /// Which parameter.
        parameter: &'static str,
        /// Its value.
        value: f32,
        /// What belongs there.
        expected: &'static str,
    },
    /// A delay that is no length of time.
    #[error("item {item}: the delay of {command} is {value}, expected seconds to wait: {why_not}")]
    Delay {
        /// Sequence number.
        item: u16,
        /// What it commands.
        command: CommandName,
        /// Its value.
        value: f32,
        /// Why not.
        why_not: &'static str,
    },
    /// To stay where the boat is, before it has been anywhere.
    #[error(
        "item {item}: it is to be done where the boat then is, but no waypoint comes before it: give it a position"
    )]
    NowhereYet {
        /// Sequence number.
        item: u16,
    },
    /// Jumps that make the mission longer than can be.
    #[error(
        "item {item}: with all jumps the mission has more than 65535 waypoints: let it jump less often, or for ever (−1)"
    )]
    TooManyVisits {
        /// Sequence number.
        item: u16,
    },
    /// A jump for ever over no waypoint.
    #[error(
        "item {item}: it jumps for ever without going anywhere: put two waypoints between it and its target, or use NAV_LOITER_UNLIM"
    )]
    LoopWithoutWaypoint {
        /// Sequence number.
        item: u16,
    },
    /// Stern first with a boat that cannot steer so.
    #[error(
        "item {item}: the boat is to go stern first there, but only boats with two thrusters can be steered so: take MAV_CMD_DO_SET_REVERSE (194) out"
    )]
    Astern {
        /// Sequence number.
        item: u16,
    },
    /// An item after one that never ends.
    #[error("item {item}: {command} is never reached, because item {last} ends the mission: take it out")]
    AfterTheEnd {
        /// Sequence number.
        item: u16,
        /// What it commands.
        command: CommandName,
        /// Sequence number of the item that ends the mission.
        last: u16,
    },
    /// Return to launch without knowing where that is.
    #[error(
        "item {item}: the mission returns to launch, but home is not known: set home in the plan, or connect \
         when the vehicle has a position"
    )]
    NoHome {
        /// Sequence number.
        item: u16,
    },
}
