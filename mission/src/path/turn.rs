//! The elementary turn: clothoid, arc, clothoid.

use super::PathLimits;
use super::clothoid;
use crate::geodesy::NorthEast;

/// A turn of a given angle with the sharpest entry the limits allow: curvature rises linearly to its peak,
/// is held, and falls as it rose. A turn too small to reach the peak is two clothoids back to back
/// (Scheuer & Fraichard 1997, "elementary" and "CC" turns).
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    /// The angle turned, not negative; the side is given when it is drawn.
    angle_rad: f64,
    /// Length of each clothoid.
    pub(super) clothoid_m: f64,
    /// Length of the arc, zero for a small turn.
    pub(super) arc_m: f64,
    /// Largest curvature.
    pub(super) peak_radpm: f64,
}

impl Turn {
    /// The turn of `angle_rad` (≥ 0) within `limits`.
    pub(super) fn new(angle_rad: f64, limits: &PathLimits) -> Self {
        let sharpness_radpm2 = 1.0 / (limits.min_radius_m * limits.transition_m);
        let clothoids_turn_rad = limits.transition_m / limits.min_radius_m;
        if angle_rad > clothoids_turn_rad {
            Self {
                angle_rad,
                clothoid_m: limits.transition_m,
                arc_m: (angle_rad - clothoids_turn_rad) * limits.min_radius_m,
                peak_radpm: 1.0 / limits.min_radius_m,
            }
        } else {
            Self {
                angle_rad,
                clothoid_m: (angle_rad / sharpness_radpm2).sqrt(),
                arc_m: 0.0,
                peak_radpm: (angle_rad * sharpness_radpm2).sqrt(),
            }
        }
    }

    /// The same turn drawn `factor` times as large.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self {
            clothoid_m: self.clothoid_m * factor,
            arc_m: self.arc_m * factor,
            peak_radpm: self.peak_radpm / factor,
            ..self
        }
    }

    /// Length of the whole turn.
    pub(super) fn length_m(&self) -> f64 {
        2.0 * self.clothoid_m + self.arc_m
    }

    /// Rate at which the curvature rises and falls, rad/m².
    pub(super) fn sharpness_radpm2(&self) -> f64 {
        if self.clothoid_m > 0.0 { self.peak_radpm / self.clothoid_m } else { 0.0 }
    }

    /// Displacement from the start to the middle of the turn, ahead and to the side turned to.
    pub(super) fn to_middle(self) -> NorthEast {
        let entry = clothoid::displacement(self.clothoid_m, self.sharpness_radpm2());
        let entry_rad = 0.5 * self.peak_radpm * self.clothoid_m;
        let half_arc_rad = 0.5 * self.angle_rad - entry_rad;
        if self.arc_m == 0.0 {
            return entry;
        }
        let chord_m = 2.0 * (0.5 * half_arc_rad).sin() / self.peak_radpm;
        entry + NorthEast::from_polar(chord_m, entry_rad + 0.5 * half_arc_rad)
    }

    /// Displacement from the start to the end of the turn. The turn is its own mirror image about its
    /// middle, so its chord lies halfway between the two headings.
    pub(super) fn to_end(self) -> NorthEast {
        let chord = NorthEast::from_polar(1.0, 0.5 * self.angle_rad);
        chord * (2.0 * self.to_middle().dot(chord))
    }
}
