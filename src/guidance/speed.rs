//! How fast the path ahead may be run.
//!
//! A bend is run no faster than its yaw rate and its lateral acceleration allow; the end, when the boat is to
//! stop there, at the creeping speed. Between here and there the boat slows down at a fixed deceleration:
//! v² ≤ v_there² + 2 a·distance.

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::{Path, PathDirection};

use super::{EndOfPath, unit};
use crate::control::Limits;

/// Points of the path looked at, from the boat to where it could still stop.
const SAMPLES: usize = 14;

/// The final approach is never slower than this many times the current: slower, no heading holds the line.
const CREEP_PER_CURRENT: f64 = 1.3;

/// What limits the speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedLimits {
    /// Yaw rate planned for a bend, rad/s.
    pub turn_rate_radps: f64,
    /// Lateral acceleration planned for a bend, m/s².
    pub lateral_acceleration_mps2: f64,
    /// Deceleration planned before a bend or the end, m/s².
    pub deceleration_mps2: f64,
    /// Least speed of the final approach, m/s.
    pub creep_mps: f64,
}

impl SpeedLimits {
    /// The limits of a boat.
    #[must_use]
    pub fn new(limits: &Limits, creep_mps: f64) -> Self {
        Self {
            turn_rate_radps: limits.turn_rate_radps,
            lateral_acceleration_mps2: limits.lateral_acceleration_mps2,
            deceleration_mps2: limits.deceleration_mps2,
            creep_mps,
        }
    }

    /// Largest speed over ground (m/s) at arc length `progress_m`, for a wanted `speed_mps`, in a `current`.
    #[must_use]
    pub fn speed_mps(
        &self,
        path: &Path,
        progress_m: f64,
        speed_mps: f64,
        current: NorthEast,
        end: EndOfPath,
    ) -> f64 {
        let horizon_m = 0.5 * speed_mps * speed_mps / self.deceleration_mps2;
        let step_m = horizon_m / (SAMPLES - 1) as f64;
        let mut allowed_squared = speed_mps * speed_mps;
        let current_mps = current.norm();
        let (mut last_curvature, mut least_squared) = (0.0, f64::INFINITY);
        for sample in 0..SAMPLES {
            let ahead_m = sample as f64 * step_m;
            let place = path.direction(progress_m + ahead_m);
            let curvature = place.curvature_radpm.abs();
            if curvature != last_curvature {
                (last_curvature, least_squared) = (curvature, self.least_squared(curvature, current_mps));
            }
            let gained = 2.0 * self.deceleration_mps2 * ahead_m;
            // Most places slow the boat down in no current of that strength: no need to look at their direction.
            if least_squared + gained > allowed_squared {
                continue;
            }
            let there = self.bend_speed_mps(place, current).min(speed_mps);
            allowed_squared = allowed_squared.min(there * there + gained);
        }
        if end == EndOfPath::Stop {
            let left_m = (path.length_m() - progress_m).max(0.0);
            allowed_squared = allowed_squared.min(2.0 * self.deceleration_mps2 * left_m);
        }
        let creep_mps = self.creep_mps.max(CREEP_PER_CURRENT * current_mps);
        allowed_squared.sqrt().max(creep_mps.min(speed_mps))
    }

    /// Square of a speed (m²/s²) that a bend allows in a current of this strength from anywhere.
    fn least_squared(&self, curvature_radpm: f64, current_mps: f64) -> f64 {
        /// What rounding may make of it.
        const SLACK: f64 = 1.0e-9;
        if curvature_radpm <= 0.0 {
            return f64::INFINITY;
        }
        let still_water = self.turn_rate_radps / curvature_radpm;
        let discriminant = (1.0 - 4.0 * current_mps / still_water).max(0.0);
        let by_rate = 0.5 * still_water * (1.0 + discriminant.sqrt());
        (by_rate * by_rate).min(self.lateral_acceleration_mps2 / curvature_radpm) * (1.0 - SLACK)
    }

    /// Largest speed over ground (m/s) at one point of the path.
    ///
    /// A bend of curvature κ run at v turns the course at κ v. In a current w along the path the bow has to turn
    /// faster, at κ v²/(v − w): the current does not turn with the boat. Solved for the planned yaw rate; where a
    /// following current leaves no solution, 2w needs the least yaw rate.
    fn bend_speed_mps(&self, place: PathDirection, current: NorthEast) -> f64 {
        let curvature = place.curvature_radpm.abs();
        if curvature <= 0.0 {
            return f64::INFINITY;
        }
        let along = unit(place.heading_rad).dot(current);
        let still_water = self.turn_rate_radps / curvature;
        let discriminant = 1.0 - 4.0 * along / still_water;
        let by_rate =
            if discriminant > 0.0 { 0.5 * still_water * (1.0 + discriminant.sqrt()) } else { 2.0 * along };
        // Slower than 2w in a following current the bow would have to turn faster again.
        by_rate.min((self.lateral_acceleration_mps2 / curvature).sqrt().max(2.0 * along))
    }
}

#[cfg(test)]
mod tests;
