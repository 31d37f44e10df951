//! The curve a boat follows: straight legs joined by turns without a step in heading or curvature.
//!
//! A path is evaluated by arc length `s`, in metres from its first point. Each corner is a clothoid, an arc
//! and a clothoid, as sharp as [`PathLimits`] allow, so that it cuts the corner no more than it must. Where a
//! turn does not fit between its neighbours it is drawn smaller, and says so ([`Corner::scale`]). Hairpins
//! swing out, turn through the waypoint and swing back, so that even an exact reversal stays within about
//! one turning radius of its legs and never goes beyond the waypoint.

mod build;
mod circle;
mod clothoid;
mod corner;
mod limits;
mod project;
mod segment;
mod turn;

pub use circle::Orbit;
pub use corner::{Corner, HAIRPIN_RAD};
pub use limits::{LimitsError, PathLimits};
pub use project::PROJECTION_WINDOW_M;

use crate::geodesy::NorthEast;
use segment::Segment;

/// Legs shorter than this, in metres, have no direction to speak of.
pub const MIN_LEG_M: f64 = 0.05;

/// Points further than this from the origin of the local frame, in metres, are refused: nothing is gained
/// by planning across an ocean in one plane.
pub const MAX_COORDINATE_M: f64 = 1e6;

/// A point of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Position in the local frame.
    pub position: NorthEast,
    /// Course of the path, clockwise from north, *not* wrapped: it starts in (−π, π] and is continuous in
    /// `s`, so that its derivative is the curvature everywhere.
    pub heading_rad: f64,
    /// Unit vector of that course.
    pub tangent: NorthEast,
    /// Curvature, rad/m, positive to starboard.
    pub curvature_radpm: f64,
}

/// Which way a path goes at one of its points; see [`PathPoint`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathDirection {
    /// Course of the path, clockwise from north, not wrapped.
    pub heading_rad: f64,
    /// Curvature, rad/m, positive to starboard.
    pub curvature_radpm: f64,
}

/// Why no path goes through some points.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PathError {
    /// Fewer than two points.
    #[error("a path needs at least two points, got {0}: put the boat's own position or home first")]
    TooFewPoints(usize),
    /// A coordinate is NaN, infinite or absurdly large.
    #[error("point {0} is not within {km} km of the origin of the local frame", km = MAX_COORDINATE_M / 1e3)]
    NotLocal(usize),
    /// Two points in a row at the same place.
    #[error(
        "points {0} and {next} are less than {MIN_LEG_M} m apart: merge them into one",
        next = .0 + 1
    )]
    Coincident(usize),
    /// A place to turn around that is too close to the point before it.
    #[error(
        "point {0} lies within the circle to be run after it: begin the circle from where the boat then is"
    )]
    InCircle(usize),
    /// A circle without a usable radius, in metres.
    #[error("a circle cannot have a radius of {0} m")]
    Orbit(f64),
    /// The limits are unusable.
    #[error(transparent)]
    Limits(#[from] LimitsError),
}

/// A path through points of a local frame. Made once by [`Path::through`]; evaluating it allocates nothing.
#[derive(Debug, Clone)]
pub struct Path {
    points: Vec<NorthEast>,
    segments: Vec<Segment>,
    corners: Vec<Corner>,
    /// Arc length abeam of each point.
    waypoint_s_m: Vec<f64>,
    /// Arc length at which the path leaves the straight leg that leads to each point.
    leaving_s_m: Vec<f64>,
    length_m: f64,
}

impl Path {
    /// The points it was drawn through.
    pub fn points(&self) -> &[NorthEast] {
        &self.points
    }

    /// What became of each corner, in order; one for every point but the first and the last.
    pub fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// Length from the first point to the last.
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// Number of legs, one less than points.
    pub fn leg_count(&self) -> usize {
        self.points.len() - 1
    }

    /// The point at arc length `s_m`. Before the start and beyond the end the path goes straight on.
    #[inline]
    pub fn point(&self, s_m: f64) -> PathPoint {
        let segment = &self.segments[self.segment_index(s_m)];
        segment.point(s_m - segment.start_s_m)
    }

    /// Course and curvature at arc length `s_m`, as [`Path::point`] gives them, without the place: much quicker in
    /// a turn.
    #[inline]
    pub fn direction(&self, s_m: f64) -> PathDirection {
        let segment = &self.segments[self.segment_index(s_m)];
        segment.direction(s_m - segment.start_s_m)
    }

    /// Arc length abeam of point `index`: the middle of its turn. The last point's for a larger index.
    pub fn waypoint_s_m(&self, index: usize) -> f64 {
        self.waypoint_s_m.get(index).copied().unwrap_or(self.length_m)
    }

    /// Arc length at which the path leaves the straight leg that leads to point `index`, to turn into the next
    /// one. The last point's for a larger index.
    pub fn leaving_s_m(&self, index: usize) -> f64 {
        self.leaving_s_m.get(index).copied().unwrap_or(self.length_m)
    }

    /// The leg at arc length `s_m`: `i` for the leg from point `i` to point `i + 1`, changing abeam of the
    /// points; the first leg before the start, the last beyond the end.
    pub fn leg_at(&self, s_m: f64) -> usize {
        let passed = self.waypoint_s_m.partition_point(|waypoint_s_m| *waypoint_s_m <= s_m);
        passed.saturating_sub(1).min(self.leg_count() - 1)
    }

    /// The largest magnitude of the curvature between two arc lengths, in either order, rad/m.
    pub fn max_curvature(&self, from_s_m: f64, to_s_m: f64) -> f64 {
        let (from_s_m, to_s_m) = (from_s_m.min(to_s_m), from_s_m.max(to_s_m));
        // The curvature is linear in each segment, so it peaks at an end of one.
        self.segments[self.segment_index(from_s_m)..=self.segment_index(to_s_m)]
            .iter()
            .flat_map(|segment| {
                let last_m = segment.length_m;
                [from_s_m, to_s_m]
                    .map(|s_m| segment.curvature_radpm((s_m - segment.start_s_m).clamp(0.0, last_m)))
            })
            .fold(0.0, |largest: f64, curvature_radpm| largest.max(curvature_radpm.abs()))
    }

    /// Distance from `position` to the straight line between points `leg` and `leg + 1`, metres; to the
    /// last leg for a larger number.
    pub fn distance_to_leg(&self, position: NorthEast, leg: usize) -> f64 {
        let leg = leg.min(self.leg_count() - 1);
        let (from, to) = (self.points[leg], self.points[leg + 1]);
        let along = to - from;
        let share = ((position - from).dot(along) / along.dot(along)).clamp(0.0, 1.0);
        (position - from - along * share).norm()
    }

    /// Distance of `position` from the path at arc length `s_m`, metres, positive to starboard of the path.
    pub fn cross_track_m(&self, position: NorthEast, s_m: f64) -> f64 {
        let point = self.point(s_m);
        point.tangent.cross(position - point.position)
    }

    /// Index of the segment at arc length `s_m`; the first or the last outside of the path.
    #[inline]
    fn segment_index(&self, s_m: f64) -> usize {
        self.segments.partition_point(|segment| segment.start_s_m <= s_m).saturating_sub(1)
    }
}

#[cfg(test)]
mod tests;
