//! Where the boat will be when the command chosen now takes effect.
//!
//! Telemetry is old when it arrives and a command takes time to act. Forces already on their way are known, so the
//! nominal hull is run forward under them, and guidance and law work on that state. What the hull does otherwise
//! than its model is watched and carried along as a slow acceleration bias.

use helmlink_mission::geodesy::NorthEast;

use super::command::Wrench;
use super::model::{Hull, WaterMotion};
use crate::guidance::{VesselState, unit};

/// Longest delay that is predicted across, s. Farther ahead a model this simple is guessing.
pub const MAX_DELAY_S: f64 = 1.5;

/// Forces remembered: enough for the longest delay at 80 Hz. When it is full the oldest go unpredicted.
const CAPACITY: usize = 128;
/// Time constant of the acceleration bias, s.
const BIAS_TIME_S: f64 = 2.0;

/// Forces that act for a while.
#[derive(Debug, Clone, Copy, Default)]
struct Pending {
    wrench: Wrench,
    duration_s: f64,
}

/// Runs the state forward across a known delay.
#[derive(Debug, Clone)]
pub struct Predictor {
    delay_s: f64,
    pending: [Pending; CAPACITY],
    first: usize,
    count: usize,
    /// Mean of the forces that acted in the last step.
    acted: Wrench,
    last: Option<WaterMotion>,
    /// Surge (m/s²) and yaw (rad/s²) acceleration that the model does not explain.
    bias: [f64; 2],
}

impl Default for Predictor {
    fn default() -> Self {
        Self {
            delay_s: 0.0,
            pending: [Pending::default(); CAPACITY],
            first: 0,
            count: 0,
            acted: Wrench::default(),
            last: None,
            bias: [0.0; 2],
        }
    }
}

impl Predictor {
    /// Sets the delay from measurement to effect, clamped to 0…[`MAX_DELAY_S`]; NaN means none.
    pub fn set_delay_s(&mut self, delay_s: f64) {
        self.delay_s = if delay_s > 0.0 { delay_s.min(MAX_DELAY_S) } else { 0.0 };
    }

    /// The delay that is predicted across, s.
    #[must_use]
    pub fn delay_s(&self) -> f64 {
        self.delay_s
    }

    /// Forgets forces and bias; keeps the delay.
    pub fn reset(&mut self) {
        *self = Self { delay_s: self.delay_s, ..Self::default() };
    }

    /// Remembers forces just commanded: they will act from one delay after now.
    pub fn push(&mut self, wrench: Wrench) {
        if self.count == CAPACITY {
            self.first = (self.first + 1) % CAPACITY;
            self.count -= 1;
        }
        self.pending[(self.first + self.count) % CAPACITY] = Pending { wrench, duration_s: 0.0 };
        self.count += 1;
    }

    /// Time has passed: returns the mean of the forces that acted in the last `dt_s`.
    pub fn advance(&mut self, dt_s: f64) -> Wrench {
        if let Some(newest) = self.count.checked_sub(1) {
            self.pending[(self.first + newest) % CAPACITY].duration_s = dt_s;
        }
        self.acted = self.retire();
        self.acted
    }

    /// The state and the motion through the water one delay after `state`, which was measured `dt_s` after the
    /// last one; call [`Self::advance`] first. `motion` is the boat's motion through the water and `current` the water's over ground.
    pub fn predict(
        &mut self,
        dt_s: f64,
        hull: &Hull,
        state: &VesselState,
        motion: WaterMotion,
        current: NorthEast,
    ) -> (VesselState, WaterMotion) {
        if self.delay_s == 0.0 {
            self.count = 0;
            return (*state, motion);
        }
        self.learn(dt_s, hull, motion, self.acted);
        self.last = Some(motion);

        let bow = unit(state.heading_rad);
        let mut ahead = Ahead::from(*state, motion, bow);
        let slip_mps = state.sway_mps - motion.sway_mps - bow.cross(current);
        for offset in 0..self.count {
            let Pending { wrench, duration_s } = self.pending[(self.first + offset) % CAPACITY];
            ahead.step(duration_s, hull, wrench, self.bias, current, slip_mps);
        }
        (ahead.state, ahead.motion)
    }

    /// Drops what has acted by now; returns its mean.
    fn retire(&mut self) -> Wrench {
        let total_s: f64 =
            (0..self.count).map(|i| self.pending[(self.first + i) % CAPACITY].duration_s).sum();
        let mut over_s = total_s - self.delay_s;
        let (mut acted, mut acted_s) = (Wrench::default(), 0.0);
        while over_s > 0.0 && self.count > 0 {
            let oldest = &mut self.pending[self.first];
            let part_s = over_s.min(oldest.duration_s);
            acted.surge_n += oldest.wrench.surge_n * part_s;
            acted.sway_n += oldest.wrench.sway_n * part_s;
            acted.yaw_nm += oldest.wrench.yaw_nm * part_s;
            acted_s += part_s;
            oldest.duration_s -= part_s;
            over_s -= part_s;
            if oldest.duration_s <= 0.0 {
                self.first = (self.first + 1) % CAPACITY;
                self.count -= 1;
            }
        }
        if acted_s == 0.0 {
            return Wrench::default();
        }
        let share = 1.0 / acted_s;
        Wrench { surge_n: acted.surge_n * share, sway_n: acted.sway_n * share, yaw_nm: acted.yaw_nm * share }
    }

    /// Compares what the last motion should have become with what it did.
    fn learn(&mut self, dt_s: f64, hull: &Hull, motion: WaterMotion, acted: Wrench) {
        let Some(last) = self.last else { return };
        let expected = hull.after(dt_s, last, acted, self.bias);
        let share = (1.0 / BIAS_TIME_S).min(1.0 / dt_s);
        self.bias[0] += share * (motion.surge_mps - expected.surge_mps);
        self.bias[1] += share * (motion.yaw_rate_radps - expected.yaw_rate_radps);
    }
}

/// A state on its way ahead.
struct Ahead {
    state: VesselState,
    motion: WaterMotion,
    /// Velocity over ground.
    velocity: NorthEast,
}

impl Ahead {
    fn from(state: VesselState, motion: WaterMotion, bow: NorthEast) -> Self {
        Self { state, motion, velocity: state.ground_velocity_with(bow) }
    }

    fn step(
        &mut self,
        dt_s: f64,
        hull: &Hull,
        wrench: Wrench,
        bias: [f64; 2],
        current: NorthEast,
        slip_mps: f64,
    ) {
        self.motion = hull.after(dt_s, self.motion, wrench, bias);
        self.state.heading_rad += 0.5 * dt_s * (self.state.yaw_rate_radps + self.motion.yaw_rate_radps);
        let bow = unit(self.state.heading_rad);
        self.state.surge_mps = self.motion.surge_mps + bow.dot(current);
        self.state.sway_mps = self.motion.sway_mps + bow.cross(current) + slip_mps;
        self.state.yaw_rate_radps = self.motion.yaw_rate_radps;
        let velocity = self.state.ground_velocity_with(bow);
        self.state.position += (self.velocity + velocity) * 0.5 * dt_s;
        self.velocity = velocity;
    }
}

#[cfg(test)]
mod tests;
