//! Constant errors of the sensors and of the hull's model in sway, found out by what does not fit together.
//!
//! * **Velocity.** A tilted or uncalibrated accelerometer gives the flight controller's velocity a constant error in the
//!   boat's own axes. The course that is steered is then off by that much to the side, and the boat runs beside its
//!   line by the look-ahead times the angle. The position has no such error: where the boat gets to, against where the
//!   velocity would have taken it, tells.
//! * **Compass.** Course over ground, current and heading belong together: the part of the sway that is current changes
//!   with the heading, the part that is a wrong compass, −b u, does not. So it takes a turn: on one course a compass
//!   offset b and a current across look the same, and the deviation says that nothing is known. It is told, and not
//!   used: guidance steers the course, which the compass does not enter.
//! * **Sway.** A hull that is lighter or smoother than its model skids less or more than that in a turn. The current does
//!   not come and go with the turn, so that the two are told apart.

use helmlink_mission::geodesy::NorthEast;
use nalgebra::{Matrix4, Vector4};

use crate::guidance::{VesselState, unit};

/// Bandwidth of the comparison of position and velocity, rad/s: it settles in a minute and a half, and takes little of the
/// wandering of a GPS fix for motion.
const COMPARISON_RADPS: f64 = 0.06;
/// Its damping.
const DAMPING: f64 = 0.8;
/// Largest velocity offset that is believed, m/s.
const MOST_OFFSET_MPS: f64 = 0.05;
/// A position this far from where the velocity has led is another one: the comparison starts anew, m.
const JUMP_M: f64 = 2.0;

/// Finds the velocity's constant error in the boat's axes.
#[derive(Debug, Clone, Copy, Default)]
pub struct VelocityOffset {
    /// Where the velocity has led, drawn to the measured position.
    led: Option<NorthEast>,
    /// Error toward bow and starboard, m/s.
    offset: [f64; 2],
}

impl VelocityOffset {
    /// Learns from one tick; returns `state` without the error.
    pub fn correct(&mut self, dt_s: f64, state: &VesselState) -> VesselState {
        let [forward, right] = self.offset;
        let better =
            VesselState { surge_mps: state.surge_mps - forward, sway_mps: state.sway_mps - right, ..*state };
        let bow = unit(state.heading_rad);
        let expected = self.led.map(|led| led + better.ground_velocity_with(bow) * dt_s);
        let Some(expected) = expected.filter(|led| (*led - state.position).norm() < JUMP_M) else {
            self.led = Some(state.position);
            return better;
        };
        let behind = state.position - expected;
        // Exact for any step of a loop this slow.
        let pull = 2.0 * DAMPING * COMPARISON_RADPS * dt_s;
        let learn = COMPARISON_RADPS * COMPARISON_RADPS * dt_s;
        self.led = Some(expected + behind * pull.min(1.0));
        let limit = MOST_OFFSET_MPS;
        // Led too little: the velocity says too little.
        self.offset = [
            (forward - learn * bow.dot(behind)).clamp(-limit, limit),
            (right - learn * bow.cross(behind)).clamp(-limit, limit),
        ];
        better
    }

    /// Time has passed unseen: what the velocity led to in it is not known.
    pub fn interrupt(&mut self) {
        self.led = None;
    }

    /// The error toward bow and starboard, m/s.
    #[must_use]
    pub fn offset_mps(&self) -> [f64; 2] {
        self.offset
    }
}

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
        let along_mps = bow.north_m * self.known[0] + bow.east_m * self.known[1];
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
