//! Measurement noise for closed loops: small, but of every kind.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::guidance::VesselState;

/// Standard deviation of the slow position error, m, and its time constant, s.
const SLOW_POSITION: (f64, f64) = (0.05, 2.0);
const POSITION_M: f64 = 0.01;
const HEADING_RAD: f64 = 0.006;
const YAW_RATE_RADPS: f64 = 0.005;
const SPEED_MPS: f64 = 0.03;

pub(crate) struct Noise {
    rng: ChaCha8Rng,
    /// Noise of heading and yaw rate, and of the velocity, relative to the usual.
    pub(crate) turn: f64,
    pub(crate) speed: f64,
    slow_m: [f64; 2],
}

impl Noise {
    pub(crate) fn seeded(seed: u64) -> Self {
        Self { rng: ChaCha8Rng::seed_from_u64(seed), turn: 1.0, speed: 1.0, slow_m: [0.0; 2] }
    }

    /// Nearly normal with unit variance: twelve uniform numbers.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| f64::from(self.rng.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0
    }

    pub(crate) fn disturb(&mut self, dt_s: f64, mut state: VesselState) -> VesselState {
        let (size_m, time_s) = SLOW_POSITION;
        for axis in 0..2 {
            let kick = size_m * (2.0 * dt_s / time_s).sqrt() * self.normal();
            self.slow_m[axis] += kick - self.slow_m[axis] * dt_s / time_s;
        }
        state.position.north_m += self.slow_m[0] + POSITION_M * self.normal();
        state.position.east_m += self.slow_m[1] + POSITION_M * self.normal();
        state.heading_rad += self.turn * HEADING_RAD * self.normal();
        state.yaw_rate_radps += self.turn * YAW_RATE_RADPS * self.normal();
        state.surge_mps += self.speed * SPEED_MPS * self.normal();
        state.sway_mps += self.speed * SPEED_MPS * self.normal();
        state
    }
}
