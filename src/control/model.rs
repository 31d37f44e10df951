//! The controller's nominal model of the hull: three degrees of freedom, diagonal inertia.
//!
//! Equation (1) of the paper with the diagonal model of Do and Pan (2009, ch. 5). Forces divide by inertia,
//! so that every unknown of one axis is a vector Θ which multiplies a known regressor f:
//! u̇ = Θ_uᵀf_u + ζ_u τ_u, ṙ = Θ_rᵀf_r + ζ_r τ_r.

use nalgebra::Vector4;
use serde::{Deserialize, Serialize};

use super::command::Wrench;

/// Inertia and damping of a hull, through the water.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Hull {
    /// Mass and added mass in surge m11, kg.
    pub m11_kg: f64,
    /// Mass and added mass in sway m22, kg.
    pub m22_kg: f64,
    /// Moment of inertia and added inertia in yaw m33, kg·m².
    pub m33_kgm2: f64,
    /// Surge damping: N/(m/s), N/(m/s)², N/(m/s)³.
    pub surge_damping: [f64; 3],
    /// Sway damping: N/(m/s), N/(m/s)², N/(m/s)³.
    pub sway_damping: [f64; 3],
    /// Yaw damping: N·m/(rad/s), N·m/(rad/s)², N·m/(rad/s)³.
    pub yaw_damping: [f64; 3],
}

/// Motion through the water: what the hull feels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WaterMotion {
    /// Surge through the water, m/s.
    pub surge_mps: f64,
    /// Sway through the water, m/s.
    pub sway_mps: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate_radps: f64,
}

impl Hull {
    /// Surge parameters Θ_u: `[m22, -d_u1, -d_u2, -d_u3] / m11`.
    #[must_use]
    pub fn surge_parameters(&self) -> Vector4<f64> {
        let [d1, d2, d3] = self.surge_damping;
        Vector4::new(self.m22_kg, -d1, -d2, -d3) / self.m11_kg
    }

    /// Yaw parameters Θ_r: `[m11 - m22, -d_r1, -d_r2, -d_r3] / m33`.
    #[must_use]
    pub fn yaw_parameters(&self) -> Vector4<f64> {
        let [d1, d2, d3] = self.yaw_damping;
        Vector4::new(self.m11_kg - self.m22_kg, -d1, -d2, -d3) / self.m33_kgm2
    }

    /// Surge control coefficient ζ_u, 1/kg.
    #[must_use]
    pub fn surge_effect(&self) -> f64 {
        1.0 / self.m11_kg
    }

    /// Yaw control coefficient ζ_r, 1/(kg·m²).
    #[must_use]
    pub fn yaw_effect(&self) -> f64 {
        1.0 / self.m33_kgm2
    }

    /// Motion after `dt_s` under constant forces and a constant acceleration `bias` in surge (m/s²) and yaw
    /// (rad/s²). Damping is implicit: stable at any step.
    #[must_use]
    pub fn after(&self, dt_s: f64, motion: WaterMotion, wrench: Wrench, bias: [f64; 2]) -> WaterMotion {
        let WaterMotion { surge_mps: u, sway_mps: v, yaw_rate_radps: r } = motion;
        let damping = |[d1, d2, d3]: [f64; 3], rate: f64| d1 + d2 * rate.abs() + d3 * rate * rate;
        let surge = (wrench.surge_n + self.m22_kg * v * r) / self.m11_kg + bias[0];
        let yaw = (wrench.yaw_nm + (self.m11_kg - self.m22_kg) * u * v) / self.m33_kgm2 + bias[1];
        let (sway, sway_damping) = self.sway_terms(motion, wrench.sway_n);
        WaterMotion {
            surge_mps: (u + dt_s * surge) / (1.0 + dt_s * damping(self.surge_damping, u) / self.m11_kg),
            sway_mps: (v + dt_s * sway) / (1.0 + dt_s * sway_damping),
            yaw_rate_radps: (r + dt_s * yaw) / (1.0 + dt_s * damping(self.yaw_damping, r) / self.m33_kgm2),
        }
    }

    /// Acceleration in sway (m/s²) under a side force (N), with the damping split off as a rate (1/s):
    /// v̇ = `.0` − `.1`·v. Integrated implicitly this is stable at any step.
    #[must_use]
    pub fn sway_terms(&self, motion: WaterMotion, side_force_n: f64) -> (f64, f64) {
        let [d1, d2, d3] = self.sway_damping;
        let speed = motion.sway_mps.abs();
        let push = side_force_n - self.m11_kg * motion.surge_mps * motion.yaw_rate_radps;
        (push / self.m22_kg, (d1 + d2 * speed + d3 * speed * speed) / self.m22_kg)
    }
}

/// Force (N) or moment (N·m) of damping at a speed (m/s) or yaw rate (rad/s), with its sign.
#[must_use]
pub fn damping_force([d1, d2, d3]: [f64; 3], rate: f64) -> f64 {
    (d1 + d2 * rate.abs() + d3 * rate * rate) * rate
}

/// Regressor f of either axis: `[coupling, rate, |rate| rate, rate³]`.
///
/// In surge `rate` is u and `coupling` is v r; in yaw `rate` is r and `coupling` is u v. All through the water.
#[must_use]
pub fn regressor(coupling: f64, rate: f64) -> Vector4<f64> {
    Vector4::new(coupling, rate, rate.abs() * rate, rate * rate * rate)
}

/// Sway through the water, predicted from the turn alone.
///
/// The measured sway contains the current, and would put its false Munk moment (m11 − m22)·u·v into the yaw
/// law; this one does not.
#[derive(Debug, Clone, Copy, Default)]
pub struct SwayModel {
    sway_mps: f64,
    rate_mps2: f64,
}

impl SwayModel {
    /// Advances the model by `dt_s` and returns the sway through the water, m/s.
    pub fn step(
        &mut self,
        dt_s: f64,
        hull: &Hull,
        surge_mps: f64,
        yaw_rate_radps: f64,
        side_force_n: f64,
    ) -> f64 {
        let motion = WaterMotion { surge_mps, sway_mps: self.sway_mps, yaw_rate_radps };
        let (push, damping) = hull.sway_terms(motion, side_force_n);
        let next = (self.sway_mps + dt_s * push) / (1.0 + dt_s * damping);
        self.rate_mps2 = (next - self.sway_mps) / dt_s;
        self.sway_mps = next;
        next
    }

    /// Sway through the water, m/s.
    #[must_use]
    pub fn sway_mps(&self) -> f64 {
        self.sway_mps
    }

    /// Rate of change of the last step, m/s².
    #[must_use]
    pub fn rate_mps2(&self) -> f64 {
        self.rate_mps2
    }
}
