//! One axis (surge or yaw) of the adaptive proportional-integral sliding-mode controller.
//!
//! Errors are desired − actual, as in the paper. With the command filter's output β and its exact rate β̇:
//!
//! ```text
//! e = β − actual,  ξ̇ = e,  S = e + λ ξ − χ
//! τ = ζ⁻¹ [ β̇ + λ e − Θ̂ᵀf + k S + δ̂ tanh(S/Φ) + a_c χ ]
//! Θ̂̇ = −Γ S f − σ_T (Θ̂ − Θ₀)      the minus makes S Θ̃ᵀf cancel in the Lyapunov function
//! δ̂̇ = γ ( S tanh(S/Φ) − σ_d δ̂ )   0 ≤ δ̂ ≤ δ_max
//! χ̇ = −a_c χ + ζ (τ − τ_achieved)   a_c = 0.4 k
//! ```

use nalgebra::Vector4;
use serde::{Deserialize, Serialize};

use super::filter::CommandFilter;
use super::model::regressor;

/// Anti-windup rate as a part of k. At a_c = k the χ terms cancel out of τ; above it the law amplifies
/// the demand that was already cut off.
const ANTI_WINDUP_PART: f64 = 0.4;
/// How far a parameter may move from its nominal value, as a part of that value.
const PROJECTION_PART: f64 = 0.6;
/// A parameter whose nominal value is small (or zero) is given this much acceleration at the typical
/// regressor as its scale, m/s² or rad/s².
const PARAMETER_FLOOR: f64 = 0.02;

/// Gains of one axis. "unit" is m for surge and rad for yaw.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct AxisSettings {
    /// Command filter time constant T, s.
    pub filter_s: f64,
    /// Largest rate of the filtered command, unit/s².
    pub acceleration_max: f64,
    /// Reaching gain k, 1/s.
    pub reaching_gain: f64,
    /// Integral slope λ of the surface, 1/s.
    pub integral_slope: f64,
    /// Half width Φ of the boundary layer, unit/s.
    pub boundary: f64,
    /// Largest disturbance bound δ_max, unit/s².
    pub disturbance_max: f64,
    /// Adaptation rate γ of the disturbance bound, 1/s.
    pub disturbance_rate: f64,
    /// Leakage σ_d of the disturbance bound, unit/s.
    pub disturbance_leak: f64,
    /// Relative adaptation rate g_T of the parameters.
    pub parameter_rate: f64,
    /// Leakage σ_T of the parameters toward their nominal values, 1/s.
    pub parameter_leak: f64,
    /// No adaptation while |S| is below this, unit/s. Above the wave and noise level of S.
    pub dead_zone: f64,
    /// Largest magnitude of the surface's integral ξ, unit.
    pub integral_max: f64,
    /// Where damping is evaluated: 0 at the measured rate, which cancels the hull's own damping and leaves the
    /// loop to the gains alone; 1 at the filtered command, which keeps it. The difference is dissipative.
    pub damping_at_command: f64,
    /// Typical speed (m/s) or yaw rate (rad/s): scales the regressors for adaptation.
    pub typical_rate: f64,
}

/// The known side of one axis at one tick.
#[derive(Debug, Clone, Copy)]
pub struct AxisInput {
    /// Virtual control α: the speed (m/s) or yaw rate (rad/s) wanted by guidance.
    pub target: f64,
    /// Measured speed or yaw rate.
    pub actual: f64,
    /// The part of `actual` that the hull does not feel: the current along the bow, m/s; zero in yaw.
    pub drift: f64,
    /// Coupling of the other axes: v r in surge, u v in yaw, through the water.
    pub coupling: f64,
    /// Control coefficient ζ, 1/kg or 1/(kg·m²).
    pub effect: f64,
}

/// What the actuators made of a demand.
#[derive(Debug, Clone, Copy)]
pub struct AxisOutcome {
    /// Force (N) or moment (N·m) predicted to act, after magnitude and rate limits and lag.
    pub achieved: f64,
    /// Whether a magnitude or rate limit cut the demand off.
    pub saturated: bool,
}

/// State of one axis.
#[derive(Debug, Clone)]
pub struct SlidingAxis {
    settings: AxisSettings,
    nominal: Vector4<f64>,
    freedom: Vector4<f64>,
    adaptation: Vector4<f64>,
    parameters: Vector4<f64>,
    filter: CommandFilter,
    integral: f64,
    anti_windup: f64,
    disturbance: f64,
    error: f64,
    surface: f64,
    regressor: Vector4<f64>,
    demand: f64,
    /// Part of the gains in use, 0 to 1.
    gain_part: f64,
}

impl SlidingAxis {
    /// An axis at rest. `nominal` is Θ₀; `typical_coupling` the usual size of the regressor's first entry.
    #[must_use]
    pub fn new(settings: AxisSettings, nominal: Vector4<f64>, typical_coupling: f64) -> Self {
        let rate = settings.typical_rate;
        let typical = Vector4::new(typical_coupling, rate, rate * rate, rate * rate * rate);
        let scale = nominal.zip_map(&typical, |n, f| n.abs().max(PARAMETER_FLOOR / f));
        Self {
            adaptation: scale.map(|s| settings.parameter_rate * s * s),
            freedom: scale * PROJECTION_PART,
            settings,
            nominal,
            parameters: nominal,
            filter: CommandFilter::default(),
            integral: 0.0,
            anti_windup: 0.0,
            disturbance: 0.0,
            error: 0.0,
            surface: 0.0,
            regressor: Vector4::zeros(),
            demand: 0.0,
            gain_part: 1.0,
        }
    }

    /// Takes over the gains of another axis and keeps what this one has learned.
    pub fn take_gains(&mut self, other: Self) {
        self.adaptation = other.adaptation;
        self.freedom = other.freedom;
        self.settings = other.settings;
    }

    /// The largest gain from an error in the rate to the acceleration: k + λ + δ_max/Φ, 1/s.
    #[must_use]
    pub fn total_gain(&self) -> f64 {
        let g = &self.settings;
        g.reaching_gain + g.integral_slope + g.disturbance_max / g.boundary
    }

    /// Uses this part of the gains from now on, 0 to 1: k and λ, and 1/Φ, so that the disturbance bound keeps its limit.
    pub fn use_part_of_gains(&mut self, part: f64) {
        self.gain_part = part;
    }

    /// Forgets everything learned and starts from the measured `actual` rate without a jump.
    pub fn engage(&mut self, actual: f64) {
        self.parameters = self.nominal;
        self.filter = CommandFilter::starting_at(actual);
        self.integral = 0.0;
        self.anti_windup = 0.0;
        self.disturbance = 0.0;
        self.error = 0.0;
        self.surface = 0.0;
        self.demand = 0.0;
    }

    /// Moves the command filter and returns the demanded force (N) or moment (N·m).
    pub fn demand(&mut self, dt_s: f64, input: &AxisInput) -> f64 {
        let g = &self.settings;
        let rate = self.filter.step(dt_s, input.target, g.filter_s, g.acceleration_max);
        self.error = self.filter.value() - input.actual;
        let (reaching_gain, integral_slope) =
            (self.gain_part * g.reaching_gain, self.gain_part * g.integral_slope);
        self.surface = self.error + integral_slope * self.integral - self.anti_windup;
        let felt = input.actual - input.drift + g.damping_at_command * self.error;
        self.regressor = regressor(input.coupling, felt);
        let acceleration = rate + integral_slope * self.error - self.parameters.dot(&self.regressor)
            + reaching_gain * self.surface
            + self.disturbance * (self.gain_part * self.surface / g.boundary).tanh()
            + ANTI_WINDUP_PART * reaching_gain * self.anti_windup;
        self.demand = acceleration / input.effect;
        self.demand
    }

    /// Integrates surface, anti-windup and estimates, given what the actuators made of the last demand.
    pub fn settle(&mut self, dt_s: f64, input: &AxisInput, outcome: AxisOutcome) {
        let missing = self.demand - outcome.achieved;
        let a_c = ANTI_WINDUP_PART * self.gain_part * self.settings.reaching_gain;
        self.anti_windup += dt_s * (-a_c * self.anti_windup + input.effect * missing);
        let pushes_further = outcome.saturated && self.error * missing > 0.0;
        if !pushes_further {
            let limit = self.settings.integral_max;
            self.integral = (self.integral + dt_s * self.error).clamp(-limit, limit);
        }
        if !outcome.saturated {
            self.adapt(dt_s);
        }
    }

    fn adapt(&mut self, dt_s: f64) {
        let g = &self.settings;
        let surface = if self.surface.abs() < g.dead_zone { 0.0 } else { self.surface };
        let learned = self.adaptation.component_mul(&self.regressor) * -surface;
        let leaked = (self.parameters - self.nominal) * g.parameter_leak;
        let moved = self.parameters + (learned - leaked) * dt_s;
        let offset = (moved - self.nominal).zip_map(&self.freedom, |d, limit| d.clamp(-limit, limit));
        self.parameters = self.nominal + offset;
        let growth =
            surface * (self.gain_part * surface / g.boundary).tanh() - g.disturbance_leak * self.disturbance;
        self.disturbance =
            (self.disturbance + dt_s * g.disturbance_rate * growth).clamp(0.0, g.disturbance_max);
    }

    /// Sliding surface S of the last tick, unit/s.
    #[must_use]
    pub fn surface(&self) -> f64 {
        self.surface
    }

    /// Filtered command β, unit/s.
    #[must_use]
    pub fn filtered(&self) -> f64 {
        self.filter.value()
    }

    /// Estimated disturbance bound δ̂, unit/s².
    #[must_use]
    pub fn disturbance(&self) -> f64 {
        self.disturbance
    }

    /// Estimated parameters Θ̂.
    #[must_use]
    pub fn parameters(&self) -> Vector4<f64> {
        self.parameters
    }
}

#[cfg(test)]
mod tests;
