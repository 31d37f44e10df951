//! Path following: from where the boat is to the heading and speed it should have.
//!
//! | module | what it holds |
//! |---|---|
//! | [`state`] | the boat's motion at one instant, and what is refused |
//! | [`progress`] | the path as guidance sees it: never ends, and the boat's own place on it |
//! | [`virtual_ship`] | the virtual ship of the paper, led along the path by arc length |
//! | [`azimuth`] | azimuth to the virtual ship, chord bias, and their exact rates |
//! | [`drift`] | slow estimate of the current from the boat's drift |
//! | [`speed`] | how fast the path ahead may be run |
//! | [`practical`] | the guidance law put together |
//! | [`to_virtual_ship`] | the paper's own guidance law |
//! | [`line_of_sight`] | integral and adaptive line of sight |

pub mod azimuth;
pub mod drift;
pub mod line_of_sight;
pub mod practical;
pub mod progress;
pub mod speed;
pub mod state;
pub mod to_virtual_ship;
pub mod virtual_ship;

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::Path;
use serde::{Deserialize, Serialize};

pub use line_of_sight::LineOfSight;
pub use practical::Practical;
pub use state::{StateError, VesselState};
pub use to_virtual_ship::ToVirtualShip;

/// Guidance gains of a boat.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GuidanceSettings {
    /// Least look-ahead l_d, m.
    pub lead_m: f64,
    /// Look-ahead per speed, s; the longer of the two rules.
    pub lead_time_s: f64,
    /// Lead error l_w that brings the virtual ship to a stop, m.
    pub lead_softness_m: f64,
    /// Time constant T_b of the drift estimate, s.
    pub drift_time_s: f64,
    /// How far the hull's sway may be from its model's, as a part of that (deviation): it is learned within this. 0 takes
    /// the model as it is.
    #[serde(default)]
    pub sway_spread: f64,
    /// How far ahead in time the path's curvature is fed forward: the lag from a demanded yaw rate to a real
    /// one, s.
    pub preview_s: f64,
    /// How far ahead in time the speed profile is read: the lag of the speed loop, s.
    pub speed_preview_s: f64,
    /// Least speed of the final approach, m/s.
    pub creep_mps: f64,
}

impl GuidanceSettings {
    /// Look-ahead wanted at a speed, m.
    #[must_use]
    pub fn lead_at_m(&self, speed_mps: f64) -> f64 {
        self.lead_m.max(self.lead_time_s * speed_mps)
    }
}

/// What to do when the last waypoint comes near.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EndOfPath {
    /// Slow down and stop there.
    #[default]
    Stop,
    /// Run through it at speed, and on along its direction.
    RunThrough,
}

/// What is believed of the water the boat moves in.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Water {
    /// Sway through the water, m/s.
    pub sway_mps: f64,
    /// How much more the hull sways than its model, as a part of that.
    pub sway_excess: f64,
    /// Velocity of the water over ground, north-east, m/s.
    pub current: NorthEast,
}

/// Everything guidance sees at one tick.
#[derive(Debug, Clone, Copy)]
pub struct GuidanceInput<'a> {
    /// The boat.
    pub state: &'a VesselState,
    /// The path to follow.
    pub path: &'a Path,
    /// Speed wanted over ground, m/s.
    pub speed_mps: f64,
    /// The water.
    pub water: Water,
}

/// What guidance asks of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reference {
    /// Heading wanted ψ_ref, rad.
    pub heading_rad: f64,
    /// Heading error ψ_e = ψ_ref − ψ, rad, in (−π, π] save while a turn is held through ±π.
    pub heading_error_rad: f64,
    /// Rate of ψ_ref, rad/s.
    pub heading_rate_radps: f64,
    /// How much yaw rate it takes for one unit of course rate, about 1: more in a following current.
    pub yaw_per_course: f64,
    /// Surge speed wanted α_u, over ground, m/s.
    pub speed_mps: f64,
    /// Boat's place on the path s_p, m.
    pub progress_m: f64,
    /// Distance right of the path, m.
    pub cross_track_m: f64,
    /// Virtual ship's distance ahead along the path, m.
    pub lead_m: f64,
    /// Whether the end of the path has been reached.
    pub finished: bool,
}

/// A guidance law: the seam where another one plugs in.
pub trait Guidance: Send {
    /// Starts on the path near arc length `progress_m`, from any position and heading.
    fn engage(&mut self, state: &VesselState, progress_m: f64);

    /// One tick of `dt_s` seconds.
    fn step(&mut self, dt_s: f64, input: &GuidanceInput<'_>) -> Reference;
}

/// Unit vector of a direction clockwise from north.
#[must_use]
pub(crate) fn unit(bearing_rad: f64) -> NorthEast {
    let (sin, cos) = bearing_rad.sin_cos();
    NorthEast { north_m: cos, east_m: sin }
}

#[cfg(test)]
mod tests;
