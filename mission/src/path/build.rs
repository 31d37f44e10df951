//! Drawing a path through points.

use super::corner::{Corner, CornerShape};
use super::segment::{Segment, Shape};
use super::turn::Turn;
use super::{MAX_COORDINATE_M, MIN_LEG_M, Path, PathError, PathLimits};
use crate::angle::ssa;
use crate::geodesy::NorthEast;

/// Straight pieces shorter than this are left out, metres: two turns meet there.
const SHORTEST_LINE_M: f64 = 1e-9;

impl Path {
    /// The path through `points` (local frame, at least two, no two in a row at one place) that turns
    /// within `limits`. A turn takes at most half of each leg at its corner.
    ///
    /// # Errors
    /// Too few points, a point that is not finite or too far away, two points in a row closer than
    /// [`MIN_LEG_M`], or unusable limits.
    pub fn through(points: &[NorthEast], limits: &PathLimits) -> Result<Self, PathError> {
        limits.check()?;
        check_points(points)?;
        let legs: Vec<NorthEast> = points.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut pen = Pen::at(points[0], legs[0].bearing_rad());
        let mut corners = Vec::with_capacity(legs.len() - 1);
        let mut waypoint_s_m = vec![0.0];
        let mut leaving_s_m = vec![0.0];

        for (waypoint, pair) in (1..).zip(legs.windows(2)) {
            let leg_m = [pair[0].norm(), pair[1].norm()];
            let turn_rad = ssa(pair[1].bearing_rad() - pair[0].bearing_rad());
            let shape = CornerShape::fit(turn_rad, limits, 0.5 * leg_m[0].min(leg_m[1]));
            let tangent_m = shape.map_or(0.0, |(shape, _)| shape.tangent_m);
            let (inwards, outwards) = (pair[0] / leg_m[0], pair[1] / leg_m[1]);

            pen.line_to(points[waypoint] - inwards * tangent_m);
            let half_m = shape.map_or(0.0, |(shape, _)| 0.5 * shape.length_m());
            leaving_s_m.push(pen.s_m);
            waypoint_s_m.push(pen.s_m + half_m);
            let heading_rad = pen.heading_rad + turn_rad;
            if let Some((shape, _)) = shape {
                pen.corner(&shape, turn_rad.signum());
            }
            // Back on the exact line of the next leg, so that rounding does not add up.
            pen.position = points[waypoint] + outwards * tangent_m;
            pen.heading_rad = heading_rad;
            corners.push(describe(waypoint, turn_rad, shape));
        }
        pen.last_line_to(points[points.len() - 1]);
        leaving_s_m.push(pen.s_m);
        waypoint_s_m.push(pen.s_m);
        let (points, segments, length_m) = (points.to_vec(), pen.segments, pen.s_m);
        Ok(Self { points, segments, corners, waypoint_s_m, leaving_s_m, length_m })
    }
}

fn check_points(points: &[NorthEast]) -> Result<(), PathError> {
    if points.len() < 2 {
        return Err(PathError::TooFewPoints(points.len()));
    }
    let is_local = |point: &NorthEast| point.norm() <= MAX_COORDINATE_M;
    if let Some(index) = points.iter().position(|point| !is_local(point)) {
        return Err(PathError::NotLocal(index));
    }
    match points.windows(2).position(|pair| (pair[1] - pair[0]).norm() < MIN_LEG_M) {
        Some(index) => Err(PathError::Coincident(index)),
        None => Ok(()),
    }
}

fn describe(waypoint: usize, turn_rad: f64, shape: Option<(CornerShape, f64)>) -> Corner {
    let straight_on = Corner {
        waypoint,
        turn_rad,
        radius_m: f64::INFINITY,
        scale: 1.0,
        cut_m: 0.0,
        tangent_m: 0.0,
        swing_rad: 0.0,
    };
    shape.map_or(straight_on, |(shape, scale)| Corner {
        radius_m: 1.0 / shape.main.peak_radpm,
        scale,
        cut_m: shape.cut_m,
        tangent_m: shape.tangent_m,
        swing_rad: shape.swing_rad,
        ..straight_on
    })
}

/// Draws segment after segment.
pub(super) struct Pen {
    pub(super) segments: Vec<Segment>,
    pub(super) position: NorthEast,
    pub(super) heading_rad: f64,
    pub(super) s_m: f64,
}

impl Pen {
    pub(super) fn at(position: NorthEast, heading_rad: f64) -> Self {
        Self { segments: Vec::new(), position, heading_rad, s_m: 0.0 }
    }

    /// A straight piece to a point ahead, unless it is too short to matter.
    fn line_to(&mut self, end: NorthEast) {
        if (end - self.position).norm() > SHORTEST_LINE_M {
            self.last_line_to(end);
        }
    }

    /// A straight piece, whatever its length: a path ends in one, and goes on along it.
    pub(super) fn last_line_to(&mut self, end: NorthEast) {
        self.draw((end - self.position).norm(), Shape::Line);
        self.position = end;
    }

    /// A whole corner to starboard (`side` = 1) or port (−1).
    fn corner(&mut self, shape: &CornerShape, side: f64) {
        if let Some(swing) = &shape.swing {
            self.turn(swing, -side);
        }
        self.turn(&shape.main, side);
        if let Some(swing) = &shape.swing {
            self.turn(swing, -side);
        }
    }

    fn turn(&mut self, turn: &Turn, side: f64) {
        let sharpness_radpm2 = side * turn.sharpness_radpm2();
        self.draw(turn.clothoid_m, Shape::Entry { sharpness_radpm2 });
        if turn.arc_m > 0.0 {
            self.draw(turn.arc_m, Shape::Arc { curvature_radpm: side * turn.peak_radpm });
        }
        self.draw(turn.clothoid_m, Shape::Exit { sharpness_radpm2 });
    }

    pub(super) fn draw(&mut self, length_m: f64, shape: Shape) {
        let segment = Segment::new(self.s_m, self.position, self.heading_rad, length_m, shape);
        let end = segment.point(length_m);
        self.segments.push(segment);
        self.position = end.position;
        self.heading_rad = end.heading_rad;
        self.s_m += length_m;
    }
}
