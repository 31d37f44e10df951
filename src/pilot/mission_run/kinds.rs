//! What a run is told, and what it tells.

use helmlink_mission::path::PathError;

use crate::control::{Controller, Diagnostics, HelmError};
use crate::vehicle::output::Demand;

/// What the user or the vehicle has set for a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunSettings {
    /// Speed over ground on legs for which the mission gives none, m/s.
    pub speed_mps: f64,
    /// The controller.
    pub controller: Controller,
}

/// Where the boat is on its mission.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Index of the waypoint that the boat is under way to.
    pub next: usize,
    /// Number of waypoints.
    pub total: usize,
    /// The leg that the boat is on: i for the one from waypoint i to waypoint i + 1; none on the way to the first.
    /// It changes where the path begins its turn into the next leg.
    pub leg: Option<usize>,
    /// Distance to the right of the smooth path, metres.
    pub cross_track_m: f64,
    /// Distance still to go along this stretch and the straight legs after it, metres.
    pub to_go_m: f64,
    /// Speed over ground, m/s.
    pub speed_mps: f64,
    /// The speed that the mission wants on this leg, m/s.
    pub wanted_speed_mps: f64,
    /// The last waypoint has been reached.
    pub complete: bool,
}

/// What one step gave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// What to send.
    pub demand: Demand,
    /// The waypoints reached with this step: indices from the first up to, not including, the second.
    pub reached: (usize, usize),
    /// What the controller thought.
    pub diagnostics: Diagnostics,
}

/// Why a step could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The controller refused.
    #[error(transparent)]
    Helm(#[from] HelmError),
    /// No path could be laid.
    #[error(transparent)]
    Path(#[from] PathError),
}
