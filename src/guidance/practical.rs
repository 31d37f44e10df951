//! The practical guidance law: the paper's virtual ship with its three geometric defects mended.
//!
//! The paper steers the bow at the virtual ship, ψ_ref = ψ_r. Under a cross current that leaves a steady offset,
//! in a bend it cuts the corner, and close to the ship it amplifies noise. Here the *course* is aligned, the bias
//! of the chord is taken out, and the lead is kept: ψ_ref = ψ_r − γ_c − β̂. On a straight leg this is
//! line-of-sight guidance with the lead as look-ahead: ψ_ref = ψ_p − atan(e/lead) − β̂.

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::NorthEast;

use super::azimuth::{azimuth, chord_bias};
use super::progress::{Projection, foot_speed_mps, project};
use super::speed::SpeedLimits;
use super::virtual_ship::VirtualShip;
use super::{EndOfPath, Guidance, GuidanceInput, GuidanceSettings, Reference, VesselState, unit};
use crate::control::{Hull, Limits, SwayModel};

/// The azimuth is blended with the virtual ship's direction closer than this part of the lead.
const NEAR_PART: f64 = 0.3;
/// Below this cosine of the heading error speed gives way to turning.
const TURN_FIRST_COSINE: f64 = 0.5;
/// Least cosine that the speed along the path is divided by.
const LEAST_COSINE: f64 = 0.7;
/// Beyond this heading error a turn keeps its direction when the error flips through ±π, rad.
const HOLD_TURN_RAD: f64 = 2.6;
/// Least surge speed in the drift angle: slower, the angle means nothing, m/s.
const LEAST_DRIFT_SPEED_MPS: f64 = 0.3;
/// Largest drift angle aligned, rad.
const MAX_DRIFT_RAD: f64 = 1.0;
/// Time constant of the surge rate, as a part of that of the drift estimate.
const SURGE_RATE_PART: f64 = 0.5;
/// Range of the yaw rate per course rate.
const YAW_PER_COURSE: (f64, f64) = (0.6, 2.5);
/// Surge speed never exceeds this part of the speed wanted along the path.
const MOST_SPEED_PART: f64 = 1.1;

/// The practical guidance law.
#[derive(Debug, Clone)]
pub struct Practical {
    settings: GuidanceSettings,
    limits: Limits,
    hull: Hull,
    end: EndOfPath,
    ship: VirtualShip,
    progress_m: f64,
    planned_sway: SwayModel,
    /// Surge speed over ground, low-passed: what it lags behind by is its rate, m/s.
    slow_surge_mps: f64,
    last_error_rad: f64,
}

impl Practical {
    /// Guidance of a boat.
    #[must_use]
    pub fn new(settings: GuidanceSettings, limits: Limits, hull: Hull, end: EndOfPath) -> Self {
        Self {
            settings,
            limits,
            hull,
            end,
            ship: VirtualShip::default(),
            progress_m: 0.0,
            planned_sway: SwayModel::default(),
            slow_surge_mps: 0.0,
            last_error_rad: 0.0,
        }
    }

    /// Heading error, kept on its side of ±π while the boat turns through a large angle.
    fn heading_error(&mut self, wanted_rad: f64, heading_rad: f64) -> f64 {
        let mut error = ssa(wanted_rad - heading_rad);
        if error.abs() > HOLD_TURN_RAD
            && error * self.last_error_rad < 0.0
            && self.last_error_rad.abs() > HOLD_TURN_RAD
        {
            error += std::f64::consts::TAU.copysign(self.last_error_rad);
        }
        self.last_error_rad = error;
        error
    }
}

impl Guidance for Practical {
    fn engage(&mut self, state: &VesselState, progress_m: f64) {
        self.ship = VirtualShip::at(progress_m + self.settings.lead_at_m(state.surge_mps));
        self.progress_m = progress_m;
        self.planned_sway = SwayModel::default();
        self.slow_surge_mps = state.surge_mps;
        self.last_error_rad = 0.0;
    }

    fn step(&mut self, dt_s: f64, input: &GuidanceInput<'_>) -> Reference {
        let GuidanceInput { state, path, .. } = *input;
        let bow = unit(state.heading_rad);
        let velocity = state.ground_velocity_with(bow);
        let here = project(path, state.position, self.progress_m);
        self.progress_m = here.progress_m;
        let foot_mps = foot_speed_mps(&here, velocity);

        let previewed_m = here.progress_m + foot_mps.max(0.0) * self.settings.speed_preview_s;
        let speed_mps = SpeedLimits::new(&self.limits, self.settings.creep_mps).speed_mps(
            path,
            previewed_m,
            input.speed_mps,
            input.water.current,
            self.end,
        );
        let lead_m = self.settings.lead_at_m(speed_mps);
        self.ship.step(dt_s, here.progress_m, foot_mps, speed_mps, lead_m, self.settings.lead_softness_m);

        let ship = path.point(self.ship.progress_m());
        let ship_mps = self.ship.speed_mps();
        let aim = azimuth(state.position, velocity, &ship, ship_mps, NEAR_PART * lead_m);
        let bias = chord_bias(&here.foot, foot_mps, &ship, ship_mps);

        let drift = self.drift(dt_s, input, bow);
        let heading_rad = aim.rad - bias.rad - drift.angle_rad;
        let heading_error_rad = self.heading_error(heading_rad, state.heading_rad);
        let preview_radps = self.preview_radps(path, &here, foot_mps);
        let planned_radps = here.foot.curvature_radpm * foot_mps + preview_radps;
        let planned_drift_radps = self.planned_drift_radps(dt_s, input, planned_radps);
        let course_radps = aim.radps - bias.radps + preview_radps;
        Reference {
            heading_rad: ssa(heading_rad),
            heading_error_rad,
            heading_rate_radps: (course_radps - planned_drift_radps - drift.slowing_radps)
                * drift.yaw_per_course,
            yaw_per_course: drift.yaw_per_course,
            speed_mps: self.surge_speed(input, bow, &here, Pace { speed_mps, lead_m }, heading_error_rad),
            progress_m: here.progress_m,
            cross_track_m: here.cross_track_m,
            lead_m: self.ship.progress_m() - here.progress_m,
            finished: here.progress_m >= path.length_m(),
        }
    }
}

/// What is wanted along the path: speed over ground and the virtual ship's lead.
#[derive(Clone, Copy)]
struct Pace {
    speed_mps: f64,
    lead_m: f64,
}

/// Drift angle and what it does to the course.
struct Drift {
    angle_rad: f64,
    /// Part of the drift angle's rate that comes from speeding up or slowing down, rad/s.
    slowing_radps: f64,
    yaw_per_course: f64,
}

impl Practical {
    /// Drift angle β̂ = atan2(v_p + n̂ᵀŴ, u). Yawing turns the boat within the current, so the course turns by
    /// χ̇ = r (1 − VᵀŴ/U²), V = [u, v_p + n̂ᵀŴ] in the boat's axes: faster than the bow against the current, slower
    /// with it.
    fn drift(&mut self, dt_s: f64, input: &GuidanceInput<'_>, bow: NorthEast) -> Drift {
        let along = bow.dot(input.water.current);
        let current_across = bow.cross(input.water.current);
        let across = (1.0 + input.water.sway_excess) * self.planned_sway.sway_mps() + current_across;
        let surge = input.state.surge_mps.max(LEAST_DRIFT_SPEED_MPS);
        let squared = surge * surge + across * across;
        let course_per_yaw = 1.0 - (surge * along + across * current_across) / squared;
        let rate_mps2 = self.surge_rate_mps2(dt_s, input.state.surge_mps);
        let (least, most) = YAW_PER_COURSE;
        Drift {
            slowing_radps: -across * rate_mps2 / squared,
            angle_rad: across.atan2(surge).clamp(-MAX_DRIFT_RAD, MAX_DRIFT_RAD),
            yaw_per_course: if course_per_yaw > 0.0 {
                (1.0 / course_per_yaw).clamp(least, most)
            } else {
                most
            },
        }
    }

    fn surge_rate_mps2(&mut self, dt_s: f64, surge_mps: f64) -> f64 {
        let time_constant_s = SURGE_RATE_PART * self.settings.drift_time_s;
        let gain = -(-dt_s / time_constant_s).exp_m1();
        self.slow_surge_mps += gain * (surge_mps - self.slow_surge_mps);
        (surge_mps - self.slow_surge_mps) / time_constant_s
    }

    /// What the path's curvature will add to the turn rate within the preview time, rad/s.
    fn preview_radps(&self, path: &helmlink_mission::path::Path, here: &Projection, foot_mps: f64) -> f64 {
        let ahead_m = foot_mps.max(0.0) * self.settings.preview_s;
        let ahead = path.direction(here.progress_m + ahead_m).curvature_radpm;
        (ahead - here.foot.curvature_radpm) * foot_mps
    }

    /// Rate of the drift angle that the planned turn brings, rad/s. Planned, not measured: fed back, the measured
    /// one would raise the gain of the yaw loop.
    fn planned_drift_radps(&mut self, dt_s: f64, input: &GuidanceInput<'_>, planned_radps: f64) -> f64 {
        let surge = input.state.surge_mps.max(LEAST_DRIFT_SPEED_MPS);
        self.planned_sway.step(dt_s, &self.hull, surge, planned_radps, 0.0);
        let part = 1.0 + input.water.sway_excess;
        let sway = part * self.planned_sway.sway_mps();
        part * self.planned_sway.rate_mps2() * surge / (surge * surge + sway * sway)
    }

    /// Virtual control α_u: the paper's law projected on the path's tangent.
    fn surge_speed(
        &self,
        input: &GuidanceInput<'_>,
        bow: NorthEast,
        here: &Projection,
        Pace { speed_mps, lead_m }: Pace,
        heading_error_rad: f64,
    ) -> f64 {
        let state = input.state;
        let along_current = bow.dot(input.water.current);
        let slope = speed_mps / self.settings.lead_softness_m;
        let lead_error = (self.ship.progress_m() - here.progress_m) - lead_m;
        let (sin, cos) = ssa(here.foot.heading_rad - state.heading_rad).sin_cos();
        let sway = input.water.sway_mps + bow.cross(input.water.current);
        let along = slope * lead_error + self.ship.speed_mps() - sway * sin;
        let wanted = (along / cos.max(LEAST_COSINE)).min(MOST_SPEED_PART * speed_mps);

        // Keep steerage way through the water; turn first when far off the heading.
        let least = self.limits.steerage_mps + along_current;
        let most = (self.limits.speed_max_mps + along_current).max(least);
        let forward = (heading_error_rad.cos() / TURN_FIRST_COSINE).clamp(0.0, 1.0);
        let slow = least.max(0.0);
        (slow + forward * (wanted - slow)).clamp(least.max(0.0), most.max(0.0))
    }
}

#[cfg(test)]
mod tests;
