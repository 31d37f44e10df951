//! One piece of a path: straight, circular, or a clothoid into or out of a turn.

use super::{PathDirection, PathPoint, clothoid};
use crate::geodesy::NorthEast;

/// The shape of a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// No curvature.
    Line,
    /// Constant curvature, rad/m, positive to starboard.
    Arc { curvature_radpm: f64 },
    /// Curvature from zero at the start, changing by `sharpness_radpm2` per metre.
    Entry { sharpness_radpm2: f64 },
    /// Curvature to zero at the end; `sharpness_radpm2` is its change per metre *counted back from the end*.
    Exit { sharpness_radpm2: f64 },
}

/// A piece of a path between two arc lengths. The clothoid out of a turn is drawn from its end, where its
/// curvature is zero, so that one series serves both clothoids: the anchor is the end for that one, the
/// start for all others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub(super) start_s_m: f64,
    pub(super) length_m: f64,
    shape: Shape,
    anchor: NorthEast,
    anchor_heading_rad: f64,
    /// Unit vector of the heading at the anchor; the third of the trigonometry that need not be repeated.
    tangent: NorthEast,
}

impl Segment {
    /// The segment of `shape` that starts at arc length `start_s_m`, at `position`, on `heading_rad`.
    pub(super) fn new(
        start_s_m: f64,
        position: NorthEast,
        heading_rad: f64,
        length_m: f64,
        shape: Shape,
    ) -> Self {
        let at = |anchor, anchor_heading_rad| Self {
            start_s_m,
            length_m,
            shape,
            anchor,
            anchor_heading_rad,
            tangent: NorthEast::from_polar(1.0, anchor_heading_rad),
        };
        let Shape::Exit { sharpness_radpm2 } = shape else {
            return at(position, heading_rad);
        };
        let end_heading_rad = heading_rad + 0.5 * sharpness_radpm2 * length_m * length_m;
        let drawn_from_origin = at(NorthEast::ZERO, end_heading_rad);
        at(position - drawn_from_origin.point(0.0).position, end_heading_rad)
    }

    /// The point `along_m` after the start. Lines go on beyond their ends.
    #[inline]
    pub(super) fn point(&self, along_m: f64) -> PathPoint {
        let position = self.anchor + self.displacement(along_m);
        let PathDirection { heading_rad, curvature_radpm } = self.direction(along_m);
        // On a line the same as at its anchor, to the last bit.
        let tangent = match self.shape {
            Shape::Line => self.tangent,
            _ => NorthEast::from_polar(1.0, heading_rad),
        };
        PathPoint { position, heading_rad, tangent, curvature_radpm }
    }

    /// From the anchor to the point `along_m` after the start.
    #[inline]
    fn displacement(&self, along_m: f64) -> NorthEast {
        match self.shape {
            Shape::Line => self.tangent * along_m,
            Shape::Arc { curvature_radpm } => {
                // The chord: as long as the arc times sin(x)/x of half the angle, halfway between headings.
                let half_rad = 0.5 * curvature_radpm * along_m;
                let (sin, cos) = half_rad.sin_cos();
                let chord_m = if half_rad == 0.0 { along_m } else { along_m * sin / half_rad };
                self.turned(NorthEast { north_m: cos, east_m: sin } * chord_m)
            }
            Shape::Entry { sharpness_radpm2 } => {
                self.turned(clothoid::displacement(along_m, sharpness_radpm2))
            }
            // Looking back from the end, ahead is astern and a turn to starboard is one to port.
            Shape::Exit { sharpness_radpm2 } => {
                -self.turned(clothoid::displacement(self.length_m - along_m, -sharpness_radpm2))
            }
        }
    }

    /// Course and curvature `along_m` after the start.
    #[inline]
    pub(super) fn direction(&self, along_m: f64) -> PathDirection {
        let turned_rad = match self.shape {
            Shape::Line => 0.0,
            Shape::Arc { curvature_radpm } => 2.0 * (0.5 * curvature_radpm * along_m),
            Shape::Entry { sharpness_radpm2 } => 0.5 * sharpness_radpm2 * along_m * along_m,
            Shape::Exit { sharpness_radpm2 } => {
                let back_m = self.length_m - along_m;
                -(0.5 * sharpness_radpm2 * back_m * back_m)
            }
        };
        PathDirection {
            heading_rad: self.anchor_heading_rad + turned_rad,
            curvature_radpm: self.curvature_radpm(along_m),
        }
    }

    /// Curvature `along_m` after the start, rad/m.
    pub(super) fn curvature_radpm(&self, along_m: f64) -> f64 {
        match self.shape {
            Shape::Line => 0.0,
            Shape::Arc { curvature_radpm } => curvature_radpm,
            Shape::Entry { sharpness_radpm2 } => sharpness_radpm2 * along_m,
            Shape::Exit { sharpness_radpm2 } => sharpness_radpm2 * (self.length_m - along_m),
        }
    }

    /// Arc length at the end.
    pub(super) fn end_s_m(&self) -> f64 {
        self.start_s_m + self.length_m
    }

    /// A displacement ahead and to starboard of the anchor, turned into the local frame.
    #[inline]
    fn turned(&self, ahead_and_starboard: NorthEast) -> NorthEast {
        self.tangent * ahead_and_starboard.north_m + self.tangent.starboard() * ahead_and_starboard.east_m
    }
}
