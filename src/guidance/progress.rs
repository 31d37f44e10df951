//! The boat's own place on the path.

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::{Path, PathPoint};

/// The boat's place relative to the path.
#[derive(Debug, Clone, Copy)]
pub struct Projection {
    /// Arc length s_p; below zero before the start, beyond the length past the end, m.
    pub progress_m: f64,
    /// Point of the path there.
    pub foot: PathPoint,
    /// Distance right of the path, m.
    pub cross_track_m: f64,
}

/// Projects `position` on the path, near arc length `near_m`, so that it never jumps to another leg.
#[must_use]
pub fn project(path: &Path, position: NorthEast, near_m: f64) -> Projection {
    let progress_m = path.project(position, near_m);
    let foot = path.point(progress_m);
    let cross_track_m = foot.tangent.cross(position - foot.position);
    Projection { progress_m, foot, cross_track_m }
}

/// Speed of the foot along the path ṡ_p, m/s: `velocity` along the tangent, over 1 − κe.
///
/// Inside a turn (e toward its centre) the foot runs ahead of the boat, outside it lags. At the centre itself
/// the projection is singular; the divisor is kept away from zero there.
#[must_use]
pub fn foot_speed_mps(projection: &Projection, velocity: NorthEast) -> f64 {
    /// Least value of 1 − κe.
    const LEAST_RATIO: f64 = 0.3;
    let ratio = 1.0 - projection.foot.curvature_radpm * projection.cross_track_m;
    projection.foot.tangent.dot(velocity) / ratio.max(LEAST_RATIO)
}
