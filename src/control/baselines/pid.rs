//! Heading PID by pole placement, with feed-forward of the wanted turn, and a speed PI.
//!
//! Fossen 2021, §15.3.4 (PID pole placement with reference feed-forward), as his Otter programs do it:
//! K_p = m33 ω_n², K_d = 2 ζ ω_n m33 − d_r1, K_i = K_p ω_n·share, feed-forward m33 ṙ_d + d_r(r_d).

use serde::{Deserialize, Serialize};

use crate::control::allocation::Allocation;
use crate::control::boat::Boat;
use crate::control::command::Wrench;
use crate::control::filter::CommandFilter;
use crate::control::law::{Law, LawDiagnostics, LawInput};
use crate::control::model::{Hull, damping_force};

/// Gains of the heading PID.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct HeadingPidSettings {
    /// Natural frequency ω_n of the closed heading loop, rad/s.
    pub frequency_radps: f64,
    /// Relative damping ζ.
    pub damping_ratio: f64,
    /// K_i / (K_p ω_n); Fossen takes a tenth.
    pub integral_share: f64,
    /// Time constant of the filter that turns the wanted yaw rate into r_d and ṙ_d, s.
    pub filter_s: f64,
    /// Largest ṙ_d, rad/s².
    pub acceleration_max_radps2: f64,
}

/// Gains of the speed PI.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedPiSettings {
    /// Bandwidth: K_p = m11 times this, rad/s.
    pub bandwidth_radps: f64,
    /// K_i / (K_p · bandwidth).
    pub integral_share: f64,
}

/// Speed PI with feed-forward of the drag at the wanted speed.
#[derive(Debug, Clone)]
pub struct SpeedPi {
    settings: SpeedPiSettings,
    integral_m: f64,
    error_mps: f64,
}

impl SpeedPi {
    /// A controller at rest.
    #[must_use]
    pub fn new(settings: SpeedPiSettings) -> Self {
        Self { settings, integral_m: 0.0, error_mps: 0.0 }
    }

    fn demand_n(&mut self, hull: &Hull, wanted_mps: f64, actual_mps: f64) -> f64 {
        let gain = hull.m11_kg * self.settings.bandwidth_radps;
        let integral_gain = gain * self.settings.bandwidth_radps * self.settings.integral_share;
        self.error_mps = wanted_mps - actual_mps;
        gain * self.error_mps
            + integral_gain * self.integral_m
            + damping_force(hull.surge_damping, wanted_mps)
    }

    fn settle(&mut self, dt_s: f64, missing_n: f64, saturated: bool) {
        if !(saturated && self.error_mps * missing_n > 0.0) {
            self.integral_m += dt_s * self.error_mps;
        }
    }
}

/// Heading PID and speed PI together.
#[derive(Debug, Clone)]
pub struct Pid {
    hull: Hull,
    yaw_rate_max_radps: f64,
    settings: HeadingPidSettings,
    speed: SpeedPi,
    rate: CommandFilter,
    integral_rads: f64,
    error_rad: f64,
    demand: Wrench,
    diagnostics: LawDiagnostics,
}

impl Pid {
    /// The controller of a boat.
    #[must_use]
    pub fn new(boat: &Boat, settings: HeadingPidSettings, speed: SpeedPi) -> Self {
        Self {
            hull: boat.hull.clone(),
            yaw_rate_max_radps: boat.limits.yaw_rate_max_radps,
            settings,
            speed,
            rate: CommandFilter::default(),
            integral_rads: 0.0,
            error_rad: 0.0,
            demand: Wrench::default(),
            diagnostics: LawDiagnostics::default(),
        }
    }
}

impl Law for Pid {
    fn engage(&mut self, _surge_mps: f64, yaw_rate_radps: f64) {
        self.speed = SpeedPi::new(self.speed.settings.clone());
        self.rate = CommandFilter::starting_at(yaw_rate_radps);
        self.integral_rads = 0.0;
        self.error_rad = 0.0;
    }

    fn demand(&mut self, dt_s: f64, input: &LawInput<'_>) -> Wrench {
        let LawInput { reference, state, .. } = *input;
        let g = &self.settings;
        let limit = self.yaw_rate_max_radps;
        let wanted = reference.heading_rate_radps.clamp(-limit, limit);
        let acceleration = self.rate.step(dt_s, wanted, g.filter_s, g.acceleration_max_radps2);
        let wanted_rate = self.rate.value();
        let inertia = self.hull.m33_kgm2;
        let proportional = inertia * g.frequency_radps * g.frequency_radps;
        let derivative =
            (2.0 * g.damping_ratio * g.frequency_radps * inertia - self.hull.yaw_damping[0]).max(0.0);
        let integral = proportional * g.frequency_radps * g.integral_share;
        self.error_rad = reference.heading_error_rad;
        let yaw_nm = inertia * acceleration
            + damping_force(self.hull.yaw_damping, wanted_rate)
            + proportional * self.error_rad
            + derivative * (wanted_rate - state.yaw_rate_radps)
            + integral * self.integral_rads;
        let surge_n = self.speed.demand_n(&self.hull, reference.speed_mps, state.surge_mps);
        self.demand = Wrench { surge_n, sway_n: 0.0, yaw_nm };
        self.diagnostics.alpha_u_mps = reference.speed_mps;
        // A firmware that closes the rate loop itself is told the rate that the proportional part stands for.
        self.diagnostics.alpha_r_radps =
            (wanted + 0.5 * g.frequency_radps / g.damping_ratio * self.error_rad).clamp(-limit, limit);
        self.demand
    }

    fn settle(&mut self, dt_s: f64, allocation: &Allocation) {
        let missing = self.demand.yaw_nm - allocation.achieved.yaw_nm;
        if !(allocation.yaw_saturated && self.error_rad * missing > 0.0) {
            self.integral_rads += dt_s * self.error_rad;
        }
        let missing_n = self.demand.surge_n - allocation.achieved.surge_n;
        self.speed.settle(dt_s, missing_n, allocation.surge_saturated);
    }

    fn diagnostics(&self) -> LawDiagnostics {
        self.diagnostics
    }
}
