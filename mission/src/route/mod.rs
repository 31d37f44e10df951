//! What a mission means to a boat: where to go, how fast, how long to wait, what to do at the end.
//!
//! A boat that cannot carry out an item says so before it leaves ([`RouteError`]), rather than leave the
//! item out on the way.

mod error;
mod read;

pub use error::RouteError;

use crate::geodesy::{Geodetic, LocalFrame, NorthEast};

/// Waypoints closer than this to the one before, in metres, are merged with it: nothing that floats can tell
/// them apart, and a leg needs a direction.
pub const MERGE_DISTANCE_M: f64 = 0.1;

/// The furthest a waypoint may lie from home (from the first waypoint, when home is unknown), in metres.
/// Beyond it the plan is a slip of the keyboard more likely than a voyage, and the local plane of
/// [`LocalFrame`] is no longer good to metres.
pub const MAX_DISTANCE_M: f64 = 100e3;

/// A mission, understood.
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    /// Where the boat was launched, when known.
    pub home: Option<Geodetic>,
    /// How long to wait before setting out, seconds.
    pub start_delay_s: f64,
    /// Where to go, in order; at least one, no two in a row within [`MERGE_DISTANCE_M`].
    pub waypoints: Vec<Waypoint>,
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
    /// How long to wait there, seconds; 0 to go on without stopping.
    pub hold_s: f64,
    /// Speed on the way to it, m/s; `None` is the vehicle's own cruising speed.
    pub speed_mps: Option<f64>,
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

    /// Length of the straight legs between the waypoints, metres.
    pub fn length_m(&self) -> f64 {
        self.waypoints.windows(2).map(|pair| pair[0].position.distance_m(pair[1].position)).sum()
    }
}

#[cfg(test)]
mod tests;
