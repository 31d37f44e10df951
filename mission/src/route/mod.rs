//! What a mission means to a boat: where to go, how fast, how long to wait, what to do on the way and at the end.
//!
//! A boat that cannot carry out an item says so before it leaves ([`RouteError`]), rather than leave the
//! item out on the way. Jumps are carried out beforehand: a route is the list of all visits in their order.

mod error;
mod read;
mod walk;

pub use error::RouteError;

use crate::geodesy::{Geodetic, LocalFrame, NorthEast};
use crate::plan::Item;

/// Waypoints closer than this to the one before, in metres, are merged with it: nothing that floats can tell
/// them apart, and a leg needs a direction.
pub const MERGE_DISTANCE_M: f64 = 0.1;

/// The furthest a waypoint may lie from home (from the first waypoint, when home is unknown), in metres.
/// Beyond it the plan is a slip of the keyboard more likely than a voyage, and the local plane of
/// [`LocalFrame`] is no longer good to metres.
pub const MAX_DISTANCE_M: f64 = 100e3;

/// Radius of a circle for which the mission gives none, metres: ArduRover's CIRC_RADIUS as delivered.
pub const DEFAULT_CIRCLE_RADIUS_M: f64 = 20.0;

/// A mission, understood.
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    /// Where the boat was launched, when known.
    pub home: Option<Geodetic>,
    /// How long to wait before setting out, seconds.
    pub start_delay_s: f64,
    /// Where to go, in order, once for every visit; at least one. Two in a row within [`MERGE_DISTANCE_M`] only
    /// where the boat stops at the former or turns around one of them.
    pub waypoints: Vec<Waypoint>,
    /// What to do on the way, by leg and order.
    pub tasks: Vec<Task>,
    /// After the last waypoint go on with this one, for ever.
    pub repeat_from: Option<usize>,
    /// Sequence numbers of the items that are never carried out.
    pub unreached: Vec<u16>,
    /// What to do at the last waypoint.
    pub ending: Ending,
}

/// A place to go to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// Sequence number of its mission item, 1 for the first after home; the last of them when several items
    /// at one place were merged.
    pub item: u16,
    /// Where it is.
    pub position: Geodetic,
    /// Within what distance it counts as reached, metres; `None` leaves it to the vehicle's setting.
    pub acceptance_radius_m: Option<f64>,
    /// How long to wait there, seconds; 0 to go on without waiting.
    pub hold_s: f64,
    /// The boat has to stop there, even if it does not wait.
    pub stop: bool,
    /// Speed on the way to it, m/s; `None` is the vehicle's own cruising speed.
    pub speed_mps: Option<f64>,
    /// Stern first on the way to it.
    pub reverse: bool,
    /// Turns around it, instead of going there.
    pub circle: Option<Circle>,
}

impl Waypoint {
    /// Whether the boat stops there.
    pub fn is_stop(&self) -> bool {
        self.stop || self.hold_s > 0.0
    }
}

/// Turns around a place (MAV_CMD_NAV_LOITER_TURNS).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Distance from the place, metres.
    pub radius_m: f64,
    /// How many turns.
    pub turns: f64,
    /// To starboard.
    pub clockwise: bool,
}

/// Something to be done on the way to a waypoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Task {
    /// Index of the waypoint that the boat is then under way to; the number of waypoints for what is done after
    /// the last.
    pub leg: usize,
    /// Sequence number of its mission item.
    pub item: u16,
    /// What it is.
    pub action: Action,
}

/// What a task asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// The tasks after this one wait so many seconds (MAV_CMD_CONDITION_DELAY).
    Delay(f64),
    /// The tasks after this one wait until the waypoint is this near, metres (MAV_CMD_CONDITION_DISTANCE).
    Distance(f64),
    /// This speed for the rest of the leg, m/s; none for the vehicle's own.
    Speed(Option<f64>),
    /// Passed on to the flight controller as a command.
    Command(Item),
}

/// What a boat does when it has been everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Stop and stay passive.
    Hold,
    /// Keep the position (MAV_CMD_NAV_LOITER_UNLIM).
    Loiter,
    /// Be back home, the last waypoint (MAV_CMD_NAV_RETURN_TO_LAUNCH).
    ReturnToLaunch,
}

impl Route {
    /// The waypoints in a local frame, for [`Path::through`](crate::path::Path::through). Put the place the
    /// boat starts from before them, unless that is within [`MERGE_DISTANCE_M`] of the first.
    pub fn local_points(&self, frame: &LocalFrame) -> Vec<NorthEast> {
        self.waypoints.iter().map(|waypoint| frame.to_local(waypoint.position)).collect()
    }

    /// Length of the straight legs between the waypoints, metres, with the turns around places; one round of a
    /// mission that never ends.
    pub fn length_m(&self) -> f64 {
        let legs_m: f64 =
            self.waypoints.windows(2).map(|pair| pair[0].position.distance_m(pair[1].position)).sum();
        legs_m + self.circles_m()
    }

    /// Length of the turns around places, metres.
    pub fn circles_m(&self) -> f64 {
        let circles = self.waypoints.iter().filter_map(|waypoint| waypoint.circle);
        circles.map(|circle| circle.turns * std::f64::consts::TAU * circle.radius_m).sum()
    }
}

#[cfg(test)]
mod tests;
