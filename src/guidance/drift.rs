//! Slow estimate of the current from the part of the sway that the hull model does not explain.
//!
//! The estimate Ŵ is a velocity in the north-east frame: Ŵ̇ = n̂ (v − v_m − n̂ᵀŴ)/T_b with n̂ = [−sin ψ, cos ψ].
//! Held in that frame it survives turns, and every leg in a new direction completes it; a low-pass of the drift
//! angle itself would have to be learned again after each corner.

use helmlink_mission::geodesy::NorthEast;

use super::{VesselState, unit};

/// Strongest current that is believed, m/s.
const MAX_CURRENT_MPS: f64 = 4.0;

/// Estimator of the current.
#[derive(Debug, Clone, Copy, Default)]
pub struct DriftEstimator {
    current: NorthEast,
}

impl DriftEstimator {
    /// Starts from a boat that runs straight: all of its sway is taken for current.
    #[must_use]
    pub fn starting_at(state: &VesselState) -> Self {
        let normal = unit(state.heading_rad + std::f64::consts::FRAC_PI_2);
        Self { current: limited(normal * state.sway_mps) }
    }

    /// Learns from one tick; `model_sway_mps` is the sway through the water.
    pub fn step(&mut self, dt_s: f64, state: &VesselState, model_sway_mps: f64, time_constant_s: f64) {
        let normal = unit(state.heading_rad + std::f64::consts::FRAC_PI_2);
        let surprise = state.sway_mps - model_sway_mps - normal.dot(self.current);
        let gain = -(-dt_s / time_constant_s).exp_m1();
        self.current = limited(self.current + normal * (gain * surprise));
    }

    /// Velocity of the water over ground, m/s.
    #[must_use]
    pub fn current(&self) -> NorthEast {
        self.current
    }
}

fn limited(current: NorthEast) -> NorthEast {
    let excess = (current.norm() / MAX_CURRENT_MPS).max(1.0);
    current * (1.0 / excess)
}
