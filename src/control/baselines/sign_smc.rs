//! Sliding mode as in the textbook: no integral, no adaptation, a sign function.
//!
//! S = β − actual, τ = ζ⁻¹[β̇ − Θ₀ᵀf + k S + η sign(S)] (Utkin; Fossen 2021, §16.4). Above the largest disturbance η
//! brings S to zero in finite time, and the actuators to chatter: that is what it is here to show.

use serde::{Deserialize, Serialize};

use crate::control::allocation::Allocation;
use crate::control::boat::Boat;
use crate::control::command::Wrench;
use crate::control::filter::CommandFilter;
use crate::control::law::{Law, LawDiagnostics, LawInput};
use crate::control::model::{Hull, regressor};

/// Gains of one axis; "unit" is m for surge and rad for yaw.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SignAxisSettings {
    /// Command filter time constant, s.
    pub filter_s: f64,
    /// Largest rate of the filtered command, unit/s².
    pub acceleration_max: f64,
    /// Reaching gain k, 1/s.
    pub reaching_gain: f64,
    /// Switching gain η, unit/s².
    pub switching_gain: f64,
}

/// The controller of both axes.
#[derive(Debug, Clone)]
pub struct SignSmc {
    hull: Hull,
    heading_gain: f64,
    yaw_rate_max_radps: f64,
    surge: SignAxisSettings,
    yaw: SignAxisSettings,
    filters: [CommandFilter; 2],
    diagnostics: LawDiagnostics,
}

impl SignSmc {
    /// The controller of a boat.
    #[must_use]
    pub fn new(boat: &Boat) -> Self {
        let gains = &boat.baselines.sign_smc;
        Self {
            hull: boat.hull.clone(),
            heading_gain: gains.heading_gain,
            yaw_rate_max_radps: boat.limits.yaw_rate_max_radps,
            surge: gains.surge.clone(),
            yaw: gains.yaw.clone(),
            filters: [CommandFilter::default(); 2],
            diagnostics: LawDiagnostics::default(),
        }
    }
}

/// Acceleration wanted, without the hull's own.
fn reach(
    dt_s: f64,
    settings: &SignAxisSettings,
    filter: &mut CommandFilter,
    target: f64,
    actual: f64,
) -> (f64, f64) {
    let rate = filter.step(dt_s, target, settings.filter_s, settings.acceleration_max);
    let surface = filter.value() - actual;
    let sign = if surface == 0.0 { 0.0 } else { surface.signum() };
    (rate + settings.reaching_gain * surface + settings.switching_gain * sign, surface)
}

impl Law for SignSmc {
    fn engage(&mut self, surge_mps: f64, yaw_rate_radps: f64) {
        self.filters = [CommandFilter::starting_at(surge_mps), CommandFilter::starting_at(yaw_rate_radps)];
    }

    fn demand(&mut self, dt_s: f64, input: &LawInput<'_>) -> Wrench {
        let LawInput { reference, state, motion, .. } = *input;
        let limit = self.yaw_rate_max_radps;
        let correction = self.heading_gain * reference.heading_error_rad * reference.yaw_per_course;
        let alpha_r = (correction + reference.heading_rate_radps).clamp(-limit, limit);
        let alpha_u = reference.speed_mps;
        let [surge_filter, yaw_filter] = &mut self.filters;
        let (surge, surface_u) = reach(dt_s, &self.surge, surge_filter, alpha_u, state.surge_mps);
        let (yaw, surface_r) = reach(dt_s, &self.yaw, yaw_filter, alpha_r, state.yaw_rate_radps);
        let surge_felt = regressor(motion.sway_mps * motion.yaw_rate_radps, motion.surge_mps);
        let yaw_felt = regressor(motion.surge_mps * motion.sway_mps, motion.yaw_rate_radps);
        self.diagnostics = LawDiagnostics {
            alpha_u_mps: alpha_u,
            alpha_r_radps: alpha_r,
            surface_u,
            surface_r,
            ..LawDiagnostics::default()
        };
        Wrench {
            surge_n: (surge - self.hull.surge_parameters().dot(&surge_felt)) / self.hull.surge_effect(),
            sway_n: 0.0,
            yaw_nm: (yaw - self.hull.yaw_parameters().dot(&yaw_felt)) / self.hull.yaw_effect(),
        }
    }

    fn settle(&mut self, _dt_s: f64, _allocation: &Allocation) {}

    fn diagnostics(&self) -> LawDiagnostics {
        self.diagnostics
    }
}
