//! Line-of-sight guidance with an estimate of the drift: integral (ILOS) and adaptive (ALOS).
//!
//! On the path's tangent at the boat's foot, with look-ahead Δ and cross-track error y_e (right of the path):
//!
//! * ILOS (Børhaug, Pavlov and Pettersen 2008; Fossen 2021, Eq. 12.108):
//!   ψ_ref = π_h − atan((y_e + κ y_int)/Δ), ẏ_int = Δ y_e / (Δ² + (y_e + κ y_int)²);
//! * ALOS (Fossen 2023, "An adaptive line-of-sight guidance law for path following of vehicles"):
//!   ψ_ref = π_h − β̂ − atan(y_e/Δ), β̂̇ = γ Δ y_e / √(Δ² + y_e²).
//!
//! Both hand the angle through a reference model of second order, whose rate is the feed-forward of the heading
//! autopilot, as in Fossen's programs.

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::NorthEast;
use serde::{Deserialize, Serialize};

use super::progress::project;
use super::speed::SpeedLimits;
use super::{EndOfPath, Guidance, GuidanceInput, Reference, VesselState};
use crate::control::Limits;

/// Below this cosine of the heading error speed gives way to turning.
const TURN_FIRST_COSINE: f64 = 0.5;
/// Largest drift angle that is believed, rad.
const MAX_DRIFT_RAD: f64 = 1.0;

/// Which law estimates the drift.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LineOfSightKind {
    /// Integral of the cross-track error.
    Integral,
    /// Adaptive crab angle.
    Adaptive,
}

/// Gains of a line-of-sight guidance.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LineOfSightSettings {
    /// Which law.
    pub kind: LineOfSightKind,
    /// Least look-ahead Δ, m.
    pub look_ahead_m: f64,
    /// Look-ahead per speed, s; the longer of the two rules.
    pub look_ahead_s: f64,
    /// Speed of the estimate relative to Δ/U: κ = this · U, γ = this · U / Δ².
    pub adaptation: f64,
    /// Natural frequency of the reference model, rad/s.
    pub reference_radps: f64,
    /// Least speed of the final approach, m/s.
    pub creep_mps: f64,
}

/// A line-of-sight guidance law.
#[derive(Debug, Clone)]
pub struct LineOfSight {
    settings: LineOfSightSettings,
    limits: Limits,
    end: EndOfPath,
    progress_m: f64,
    /// y_int (m) or β̂ (rad).
    estimate: f64,
    heading_rad: f64,
    rate_radps: f64,
}

impl LineOfSight {
    /// Guidance of a boat.
    #[must_use]
    pub fn new(settings: LineOfSightSettings, limits: Limits, end: EndOfPath) -> Self {
        Self { settings, limits, end, progress_m: 0.0, estimate: 0.0, heading_rad: 0.0, rate_radps: 0.0 }
    }

    /// The line-of-sight angle; moves the estimate.
    fn angle_rad(&mut self, dt_s: f64, tangent_rad: f64, right_m: f64, speed_mps: f64) -> f64 {
        let g = &self.settings;
        let ahead_m = g.look_ahead_m.max(g.look_ahead_s * speed_mps);
        match g.kind {
            LineOfSightKind::Integral => {
                let kappa = g.adaptation * speed_mps;
                let aim_m = right_m + kappa * self.estimate;
                self.estimate += dt_s * ahead_m * right_m / (ahead_m * ahead_m + aim_m * aim_m);
                tangent_rad - (aim_m / ahead_m).atan()
            }
            LineOfSightKind::Adaptive => {
                let gamma = g.adaptation * speed_mps / (ahead_m * ahead_m);
                let growth = gamma * ahead_m * right_m / ahead_m.hypot(right_m);
                self.estimate = (self.estimate + dt_s * growth).clamp(-MAX_DRIFT_RAD, MAX_DRIFT_RAD);
                tangent_rad - self.estimate - (right_m / ahead_m).atan()
            }
        }
    }

    /// Reference model: critically damped, its rate limited.
    fn refer(&mut self, dt_s: f64, wanted_rad: f64) {
        let w = self.settings.reference_radps;
        let limit = self.limits.yaw_rate_max_radps;
        let rate = self.rate_radps + dt_s * w * w * ssa(wanted_rad - self.heading_rad);
        self.rate_radps = (rate / (1.0 + 2.0 * w * dt_s)).clamp(-limit, limit);
        self.heading_rad = ssa(self.heading_rad + dt_s * self.rate_radps);
    }
}

impl Guidance for LineOfSight {
    fn engage(&mut self, state: &VesselState, progress_m: f64) {
        self.progress_m = progress_m;
        self.estimate = 0.0;
        self.heading_rad = ssa(state.heading_rad);
        self.rate_radps = state.yaw_rate_radps;
    }

    fn step(&mut self, dt_s: f64, input: &GuidanceInput<'_>) -> Reference {
        let GuidanceInput { state, path, .. } = *input;
        let here = project(path, state.position, self.progress_m);
        self.progress_m = here.progress_m;
        let limits = SpeedLimits::new(&self.limits, self.settings.creep_mps);
        let speed_mps = limits.speed_mps(path, here.progress_m, input.speed_mps, NorthEast::ZERO, self.end);
        let speed_over_ground = state.surge_mps.hypot(state.sway_mps);
        let wanted_rad = self.angle_rad(dt_s, here.foot.heading_rad, here.cross_track_m, speed_over_ground);
        self.refer(dt_s, wanted_rad);
        let heading_error_rad = ssa(self.heading_rad - state.heading_rad);
        let forward = (heading_error_rad.cos() / TURN_FIRST_COSINE).clamp(0.0, 1.0);
        let least = self.limits.steerage_mps;
        Reference {
            heading_rad: self.heading_rad,
            heading_error_rad,
            heading_rate_radps: self.rate_radps,
            yaw_per_course: 1.0,
            speed_mps: (least + forward * (speed_mps - least)).max(0.0),
            progress_m: here.progress_m,
            cross_track_m: here.cross_track_m,
            lead_m: self.settings.look_ahead_m,
            finished: here.progress_m >= path.length_m(),
        }
    }
}

#[cfg(test)]
mod tests;
