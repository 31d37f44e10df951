//! Where on a path a boat is.

use super::Path;
use crate::geodesy::NorthEast;

/// The furthest that [`Path::project`] moves along the path in one call, metres. A boat covers centimetres
/// between calls; this is for the first call, and for a position that jumped.
pub const PROJECTION_WINDOW_M: f64 = 50.0;

/// The angle a path turns in one stride of the search, radians: small against half a turn, so that no foot
/// point is stepped over.
const STRIDE_RAD: f64 = 0.5;
/// The shortest stride, metres: brings the search over the joint between two segments.
const SHORTEST_STRIDE_M: f64 = 1e-3;
/// The search ends when it moves less than this, metres.
const TOLERANCE_M: f64 = 1e-9;
/// Steps of the final search; bisection alone would reach the tolerance in fewer.
const MAX_STEPS: usize = 60;

impl Path {
    /// Arc length of the foot point of `position` on the path: from `near_s_m`, the last known foot point,
    /// along the path as long as that comes closer, at most [`PROJECTION_WINDOW_M`].
    ///
    /// Because it only ever goes downhill it does not jump to another leg that happens to be closer. The
    /// result may lie before the start or beyond the end. A position that is not finite returns `near_s_m`.
    pub fn project(&self, position: NorthEast, near_s_m: f64) -> f64 {
        self.project_within(position, near_s_m, PROJECTION_WINDOW_M)
    }

    /// As [`Path::project`], moving at most `window_m`.
    pub fn project_within(&self, position: NorthEast, near_s_m: f64, window_m: f64) -> f64 {
        let (mut ahead_m, _) = self.ahead_m(position, near_s_m);
        if !ahead_m.is_finite() || ahead_m == 0.0 {
            return near_s_m;
        }
        let forward = ahead_m.signum();
        let mut from_s_m = near_s_m;
        let mut left_m = window_m.max(0.0);
        while left_m > 0.0 {
            // On a straight leg the foot is exactly `ahead_m` away: twice that keeps the bracket small.
            let stride_m = self.stride_m(from_s_m, forward).min(2.0 * ahead_m.abs()).max(SHORTEST_STRIDE_M);
            let stride_m = stride_m.min(left_m);
            let to_s_m = from_s_m + forward * stride_m;
            (ahead_m, _) = self.ahead_m(position, to_s_m);
            if ahead_m * forward <= 0.0 {
                return self.foot_between(position, from_s_m.min(to_s_m), from_s_m.max(to_s_m));
            }
            from_s_m = to_s_m;
            left_m -= stride_m;
        }
        from_s_m
    }

    /// How far ahead of the point at `s_m` a position lies along the tangent there, and the derivative of
    /// that by `s`: −(1 − κd) at a distance d to starboard.
    fn ahead_m(&self, position: NorthEast, s_m: f64) -> (f64, f64) {
        let point = self.point(s_m);
        let offset = position - point.position;
        (offset.dot(point.tangent), point.curvature_radpm * point.tangent.cross(offset) - 1.0)
    }

    /// How far the path can be followed from `s_m` within one segment and one [`STRIDE_RAD`].
    fn stride_m(&self, s_m: f64, forward: f64) -> f64 {
        let last = self.segments.len() - 1;
        let (index, left_m) = if forward > 0.0 {
            let index = self.segment_index(s_m);
            (index, if index == last { f64::INFINITY } else { self.segments[index].end_s_m() - s_m })
        } else {
            let index = self.segments.partition_point(|segment| segment.start_s_m < s_m).saturating_sub(1);
            (index, if index == 0 { f64::INFINITY } else { s_m - self.segments[index].start_s_m })
        };
        let segment = &self.segments[index];
        let curvature_radpm =
            segment.curvature_radpm(0.0).abs().max(segment.curvature_radpm(segment.length_m).abs());
        left_m.min(STRIDE_RAD / curvature_radpm)
    }

    /// The foot point between two arc lengths, the first of which has the position ahead, the second astern:
    /// Newton's method, kept inside the bracket by bisection.
    fn foot_between(&self, position: NorthEast, mut low_s_m: f64, mut high_s_m: f64) -> f64 {
        let mut s_m = 0.5 * (low_s_m + high_s_m);
        for _ in 0..MAX_STEPS {
            let (ahead_m, slope) = self.ahead_m(position, s_m);
            if ahead_m > 0.0 {
                low_s_m = s_m;
            } else {
                high_s_m = s_m;
            }
            let newton_s_m = s_m - ahead_m / slope;
            let inside = newton_s_m >= low_s_m && newton_s_m <= high_s_m;
            let next_s_m = if inside { newton_s_m } else { 0.5 * (low_s_m + high_s_m) };
            if (next_s_m - s_m).abs() < TOLERANCE_M {
                return next_s_m;
            }
            s_m = next_s_m;
        }
        s_m
    }
}
