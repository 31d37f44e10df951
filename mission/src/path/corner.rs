//! How a path gets around a waypoint.

use std::f64::consts::FRAC_PI_2;

use super::PathLimits;
use super::turn::Turn;
use crate::geodesy::NorthEast;

/// Course changes larger than this, 135°, are made through the waypoint instead of inside it: from here on
/// that takes the shorter tangents, and at 180° it is the only way that has any.
pub const HAIRPIN_RAD: f64 = 1.5 * FRAC_PI_2;

/// Course changes smaller than this are no corners: over a leg of ten kilometres they amount to 0.01 mm.
const STRAIGHT_RAD: f64 = 1e-9;

/// Steps of bisection for the angle of a swing; more than the bits of the answer.
const SWING_STEPS: usize = 60;

/// A corner as it was drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Index of the point the corner is at.
    pub waypoint: usize,
    /// Course change, positive to starboard, −π to π.
    pub turn_rad: f64,
    /// Smallest radius of the path here; infinite where it goes straight on.
    pub radius_m: f64,
    /// How much smaller than wanted the turn had to be drawn to fit its legs: 1 when it fits.
    pub scale: f64,
    /// Distance from the waypoint to the path; zero where the turn goes through it.
    pub cut_m: f64,
    /// Length of each adjacent leg that the turn replaces.
    pub tangent_m: f64,
    /// Angle of the swing to the outer side before and after the turn, zero for a plain turn.
    pub swing_rad: f64,
}

/// The turns that make up a corner: an optional swing to the outer side, the main turn, the swing back.
///
/// Every corner is its own mirror image about the bisector of its legs. In the frame of the incoming leg,
/// with the middle of the main turn at (x, y) from the start, the start therefore lies
/// x + y tan(δ/2) before the waypoint, and the waypoint y/cos(δ/2) from the path.
#[derive(Debug, Clone, Copy)]
pub(super) struct CornerShape {
    pub(super) swing: Option<Turn>,
    pub(super) main: Turn,
    pub(super) swing_rad: f64,
    pub(super) tangent_m: f64,
    pub(super) cut_m: f64,
}

impl CornerShape {
    /// The shape for a course change of `turn_rad` (its side does not matter) in at most `available_m` of
    /// both adjacent legs; `None` when the path goes straight on. Also returns the scale it was drawn at.
    pub(super) fn fit(turn_rad: f64, limits: &PathLimits, available_m: f64) -> Option<(Self, f64)> {
        if turn_rad.abs() < STRAIGHT_RAD {
            return None;
        }
        let shape = Self::unlimited(turn_rad.abs(), limits);
        if shape.tangent_m <= available_m {
            return Some((shape, 1.0));
        }
        // A similar figure keeps turn rate and yaw acceleration when the speed is scaled with it.
        let scale = available_m / shape.tangent_m;
        Some((shape.scaled(scale), scale))
    }

    /// Length of the whole corner.
    pub(super) fn length_m(&self) -> f64 {
        self.main.length_m() + 2.0 * self.swing.map_or(0.0, |swing| swing.length_m())
    }

    fn unlimited(angle_rad: f64, limits: &PathLimits) -> Self {
        let swing_share = if angle_rad > HAIRPIN_RAD { 1.0 } else { limits.swing };
        let inside_m = middle(angle_rad, 0.0, limits).east_m;
        let swing_rad = if swing_share > 0.0 {
            swing_for(angle_rad, (1.0 - swing_share) * inside_m, limits)
        } else {
            0.0
        };
        let middle = middle(angle_rad, swing_rad, limits);
        // The tangent of a right angle multiplies a swing that is exact to rounding only.
        let inside_m = if swing_share == 1.0 { 0.0 } else { middle.east_m };
        Self {
            swing: (swing_rad > 0.0).then(|| Turn::new(swing_rad, limits)),
            main: Turn::new(angle_rad + 2.0 * swing_rad, limits),
            swing_rad,
            tangent_m: middle.north_m + inside_m * (0.5 * angle_rad).tan(),
            cut_m: inside_m / (0.5 * angle_rad).cos(),
        }
    }

    fn scaled(self, factor: f64) -> Self {
        Self {
            swing: self.swing.map(|swing| swing.scaled(factor)),
            main: self.main.scaled(factor),
            tangent_m: self.tangent_m * factor,
            cut_m: self.cut_m * factor,
            ..self
        }
    }
}

/// Where the middle of a corner of `angle_rad` that first swings out by `swing_rad` lies from its start:
/// ahead along the incoming leg and towards the inner side.
fn middle(angle_rad: f64, swing_rad: f64, limits: &PathLimits) -> NorthEast {
    let swing = Turn::new(swing_rad, limits).to_end();
    let main = Turn::new(angle_rad + 2.0 * swing_rad, limits).to_middle();
    NorthEast { north_m: swing.north_m, east_m: -swing.east_m } + main.rotated(-swing_rad)
}

/// The swing that brings the middle of the corner to `inside_m` from the line of the incoming leg. More
/// swing brings it further out, and a right angle of it beyond the line for any turn up to a reversal.
fn swing_for(angle_rad: f64, inside_m: f64, limits: &PathLimits) -> f64 {
    let (mut low_rad, mut high_rad) = (0.0, FRAC_PI_2);
    for _ in 0..SWING_STEPS {
        let swing_rad = 0.5 * (low_rad + high_rad);
        if middle(angle_rad, swing_rad, limits).east_m > inside_m {
            low_rad = swing_rad;
        } else {
            high_rad = swing_rad;
        }
    }
    0.5 * (low_rad + high_rad)
}
