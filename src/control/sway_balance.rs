//! What turns in a current tell: what the compass is off by, and how much the hull sways against its model.
//!
//! * **Compass.** Course over ground, current and heading belong together: the part of the sway that is current changes
//!   with the heading, the part that is a wrong compass, −b u, does not. So it takes a turn: on one course a compass
//!   offset b and a current across look the same, and the deviation says that nothing is known. It is told, and not
//!   used: guidance steers the course, which the compass does not enter.
//! * **Sway.** A hull that is lighter or smoother than its model skids less or more than that in a turn. The current does
//!   not come and go with the turn, so that the two are told apart.

use helmlink_mission::geodesy::NorthEast;
use nalgebra::{Matrix4, Vector4};

use crate::guidance::{VesselState, unit};

/// Deviation of the sway that the hull model explains from the true one, m/s, as white noise over one second.
const SWAY_NOISE_MPS: f64 = 0.05;
/// How much the current changes in the root of a second, m/s.
const CURRENT_WALK_MPS: f64 = 0.005;
/// How much the compass offset changes in the root of a second, rad.
const OFFSET_WALK_RAD: f64 = 2.0e-5;
/// How much the sway's excess changes in the root of a second, as a part of its spread.
const EXCESS_WALK: f64 = 0.004;
/// Deviations at the start: of each component of the current, m/s, and of the compass, rad.
const START: [f64; 3] = [0.7, 0.7, 0.1];
/// Range in which an excess of the sway is believed.
const EXCESS: (f64, f64) = (-0.6, 1.0);

/// A compass offset as far as it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompassError {
    /// What the heading is too large by, rad.
    pub offset_rad: f64,
    /// Its deviation, rad. On one course alone it stays as large as at the start.
    pub deviation_rad: f64,
}

/// Finds the compass offset b and the sway's excess e from v = (1 + e) v_m + n̂ᵀW − b u: a Kalman filter of the
/// current W, of b and of e.
#[derive(Debug, Clone, Copy)]
pub struct SwayBalance {
    /// Current to north and east, m/s; compass offset, rad; excess of the sway, as a part of the model's.
    known: Vector4<f64>,
    covariance: Matrix4<f64>,
    /// Variances added in a second.
    walk: Vector4<f64>,
}

impl SwayBalance {
    /// Nothing is known yet; `spread` is how far the sway may be from the model's, as a part of it (deviation). With 0
    /// the model is taken as it is.
    #[must_use]
    pub fn new(spread: f64) -> Self {
        let [north, east, compass] = START;
        let start = Vector4::new(north, east, compass, spread);
        let walk = Vector4::new(CURRENT_WALK_MPS, CURRENT_WALK_MPS, OFFSET_WALK_RAD, EXCESS_WALK * spread);
        let squared = |deviation: f64| deviation * deviation;
        Self {
            known: Vector4::zeros(),
            covariance: Matrix4::from_diagonal(&start.map(squared)),
            walk: walk.map(squared),
        }
    }

    /// Learns from one tick; `model_sway_mps` is the sway through the water that the hull model expects.
    pub fn learn(&mut self, dt_s: f64, state: &VesselState, model_sway_mps: f64) {
        for (index, walk) in self.walk.iter().enumerate() {
            self.covariance[(index, index)] += walk * dt_s;
        }
        let bow = unit(state.heading_rad);
        let along_mps = bow.dot(self.current());
        let seen = Vector4::new(-bow.east_m, bow.north_m, along_mps - state.surge_mps, model_sway_mps);
        let surprise = state.sway_mps - model_sway_mps - seen.dot(&self.known);
        let spread = self.covariance * seen;
        let gain = spread / (seen.dot(&spread) + SWAY_NOISE_MPS * SWAY_NOISE_MPS / dt_s);
        self.known += gain * surprise;
        self.known[3] = self.known[3].clamp(EXCESS.0, EXCESS.1);
        self.covariance -= gain * spread.transpose();
    }

    /// The compass offset and how well it is known.
    #[must_use]
    pub fn compass(&self) -> CompassError {
        CompassError { offset_rad: self.known[2], deviation_rad: self.covariance[(2, 2)].max(0.0).sqrt() }
    }

    /// How much more the hull sways than its model, as a part of that: −0.5 is half of it.
    #[must_use]
    pub fn excess(&self) -> f64 {
        self.known[3]
    }

    /// The current that goes with them, m/s.
    #[must_use]
    pub fn current(&self) -> NorthEast {
        NorthEast::new(self.known[0], self.known[1])
    }
}

#[cfg(test)]
mod tests;
