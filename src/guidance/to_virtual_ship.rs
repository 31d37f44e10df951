//! The paper's own guidance: the bow at the virtual ship, ψ_ref = ψ_r, and the distance to it kept at δ.
//!
//! Eq. (3) with its errors on the axes mended ([`azimuth`]), and
//! α_u = [k_z (z_e − δ) + u_d cos(ψ_r − ψ_d) − v sin ψ_e] / cos ψ_e. The virtual ship's speed follows its lead, as
//! in the practical guidance: left to run on time alone it runs away from a boat that cannot keep up.

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::NorthEast;

use super::azimuth::azimuth;
use super::progress::{foot_speed_mps, project};
use super::speed::SpeedLimits;
use super::virtual_ship::{MOST_SPEED_PART, VirtualShip};
use super::{EndOfPath, Guidance, GuidanceInput, GuidanceSettings, Reference, VesselState};
use crate::control::Limits;

/// The azimuth is blended with the virtual ship's direction closer than this part of the lead.
const NEAR_PART: f64 = 0.3;
/// Least cosine of the heading error that is divided by; below it speed gives way to turning.
const LEAST_COSINE: f64 = 0.5;

/// The paper's guidance law.
#[derive(Debug, Clone)]
pub struct ToVirtualShip {
    settings: GuidanceSettings,
    limits: Limits,
    end: EndOfPath,
    ship: VirtualShip,
    progress_m: f64,
}

impl ToVirtualShip {
    /// Guidance of a boat.
    #[must_use]
    pub fn new(settings: GuidanceSettings, limits: Limits, end: EndOfPath) -> Self {
        Self { settings, limits, end, ship: VirtualShip::default(), progress_m: 0.0 }
    }
}

impl Guidance for ToVirtualShip {
    fn engage(&mut self, state: &VesselState, progress_m: f64) {
        self.ship = VirtualShip::at(progress_m + self.settings.lead_at_m(state.surge_mps));
        self.progress_m = progress_m;
    }

    fn step(&mut self, dt_s: f64, input: &GuidanceInput<'_>) -> Reference {
        let GuidanceInput { state, path, .. } = *input;
        let velocity = state.ground_velocity();
        let here = project(path, state.position, self.progress_m);
        self.progress_m = here.progress_m;
        let foot_mps = foot_speed_mps(&here, velocity);
        let limits = SpeedLimits::new(&self.limits, self.settings.creep_mps);
        let speed_mps = limits.speed_mps(path, here.progress_m, input.speed_mps, NorthEast::ZERO, self.end);
        let lead_m = self.settings.lead_at_m(speed_mps);
        self.ship.step(dt_s, here.progress_m, foot_mps, speed_mps, lead_m, self.settings.lead_softness_m);

        let ship = path.point(self.ship.progress_m());
        let ship_mps = self.ship.speed_mps();
        let aim = azimuth(state.position, velocity, &ship, ship_mps, NEAR_PART * lead_m);
        let distance_m = (ship.position - state.position).norm();
        let heading_error_rad = ssa(aim.rad - state.heading_rad);
        let (sin, cos) = heading_error_rad.sin_cos();
        let slope = speed_mps / self.settings.lead_softness_m;
        // A virtual ship that is pushed along by the boat must not ask the boat to go on.
        let ship_most_mps = ship_mps.min(MOST_SPEED_PART * speed_mps);
        let along = slope * (distance_m - lead_m) + ship_most_mps * (aim.rad - ship.heading_rad).cos()
            - state.sway_mps * sin;
        let wanted = along / cos.max(LEAST_COSINE);
        let forward = (cos / LEAST_COSINE).clamp(0.0, 1.0);
        let least = self.limits.steerage_mps;
        Reference {
            heading_rad: ssa(aim.rad),
            heading_error_rad,
            heading_rate_radps: aim.radps,
            yaw_per_course: 1.0,
            speed_mps: (least + forward * (wanted - least)).clamp(least, self.limits.speed_max_mps),
            progress_m: here.progress_m,
            cross_track_m: here.cross_track_m,
            lead_m: self.ship.progress_m() - here.progress_m,
            finished: here.progress_m >= path.length_m(),
        }
    }
}

#[cfg(test)]
mod tests;
