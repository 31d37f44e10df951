//! The boat's slow motion without the waves and the noise on it.
//!
//! A rudder cannot hold a boat against single waves; answering them only wears the gear. A notch or a low-pass would
//! take them out at the cost of phase. Here the nominal hull is run along under the forces that are known to act, and
//! corrected by the measurements (Fossen 2021, ch. 13: passive observer). What the known forces do to the hull is
//! then seen at once, what the model does not know with the bandwidth of the correction.
//!
//! How much of that estimate is used follows from what the measurements are worth: the quick part of their
//! disagreement with it is noise or waves. In calm water with good sensors there is none, and the measurement is
//! taken as it is.

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::NorthEast;
use serde::{Deserialize, Serialize};

use super::command::Wrench;
use super::model::{Hull, WaterMotion};
use crate::guidance::{VesselState, unit};

/// What the measurements may disagree with the model before they are trusted less.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ObserverSettings {
    /// Quick disagreement in yaw rate (rms) at which measurement and estimate count half, rad/s; half a second of it
    /// counts in heading.
    pub noise_radps: f64,
    /// The same in speed, m/s; half a second of it counts in position.
    pub noise_mps: f64,
    /// Bandwidth of the correction in heading and yaw rate, rad/s.
    pub turn_bandwidth_radps: f64,
    /// Bandwidth of the correction in position and speed, rad/s.
    pub move_bandwidth_radps: f64,
}

/// Time constant of the noise level, in units of one over the bandwidth. Slow disagreement, the model's error, is told
/// from quick one with the bandwidth itself.
const LEVEL_PART: f64 = 8.0;
/// Damping of the pair of correction and bias: k = w²/this.
const BIAS_DAMPING: f64 = 6.0;
/// Steps in which a gap is bridged, s.
const COAST_STEP_S: f64 = 0.1;
/// Disagreements beyond these are no noise: the estimate starts anew.
const JUMP_M: f64 = 10.0;
const JUMP_RAD: f64 = 0.5;

/// One measured quantity.
#[derive(Debug, Clone, Copy, Default)]
struct Channel {
    slow: f64,
    variance: f64,
}

impl Channel {
    /// How much of the measurement to use, 0 to 1, given its newest disagreement with the estimate.
    fn trust(&mut self, disagreement: f64, noise: f64, shares: Shares) -> f64 {
        self.slow += shares.now * (disagreement - self.slow);
        let quick = disagreement - self.slow;
        self.variance += shares.level * (quick * quick - self.variance);
        let level = self.variance / (noise * noise);
        1.0 / (1.0 + level * level)
    }
}

/// Shares of a disagreement that are taken over in one step: by the estimate and by the slow part of the disagreement,
/// and by the noise level.
#[derive(Debug, Clone, Copy)]
struct Shares {
    now: f64,
    level: f64,
}

impl Shares {
    fn of(dt_s: f64, bandwidth_radps: f64) -> Self {
        let share = |bandwidth_radps: f64| -(-dt_s * bandwidth_radps).exp_m1();
        Self { now: share(bandwidth_radps), level: share(bandwidth_radps / LEVEL_PART) }
    }
}

/// Estimates the slow motion of one boat.
#[derive(Debug, Clone)]
pub struct Observer {
    settings: ObserverSettings,
    estimate: Option<VesselState>,
    /// Surge (m/s²) and yaw (rad/s²) acceleration that the model does not explain.
    bias: [f64; 2],
    channels: [Channel; 4],
}

impl Observer {
    /// An observer that has not seen anything.
    #[must_use]
    pub fn new(settings: ObserverSettings) -> Self {
        Self { settings, estimate: None, bias: [0.0; 2], channels: [Channel::default(); 4] }
    }

    /// Starts anew from the next measurement.
    pub fn reset(&mut self) {
        *self = Self::new(self.settings);
    }

    /// The slow motion now, `dt_s` after the last call, with `acted` the mean force since then.
    pub fn observe(
        &mut self,
        dt_s: f64,
        hull: &Hull,
        measured: &VesselState,
        acted: Wrench,
        current: NorthEast,
    ) -> VesselState {
        let expected = self.estimate.map(|last| self.expected(dt_s, hull, &last, acted, current));
        match expected.filter(|expected| is_near(expected, measured)) {
            Some(expected) => self.correct(dt_s, &expected, measured),
            None => {
                self.reset();
                self.estimate = Some(*measured);
                *measured
            }
        }
    }

    /// Time has passed unseen under forces that are known: the estimate goes where the model goes.
    pub fn coast(&mut self, dt_s: f64, hull: &Hull, acted: Wrench, current: NorthEast) {
        let steps = (dt_s / COAST_STEP_S).ceil().max(1.0);
        for _ in 0..steps as u32 {
            self.estimate =
                self.estimate.map(|last| self.expected(dt_s / steps, hull, &last, acted, current));
        }
    }

    /// Where the model says that the boat has got to.
    fn expected(
        &self,
        dt_s: f64,
        hull: &Hull,
        last: &VesselState,
        acted: Wrench,
        current: NorthEast,
    ) -> VesselState {
        let bow = unit(last.heading_rad);
        let before = last.ground_velocity_with(bow);
        let motion = WaterMotion {
            surge_mps: last.surge_mps - bow.dot(current),
            sway_mps: last.sway_mps - bow.cross(current),
            yaw_rate_radps: last.yaw_rate_radps,
        };
        let next = hull.after(dt_s, motion, acted, self.bias);
        let heading_rad = last.heading_rad + 0.5 * dt_s * (last.yaw_rate_radps + next.yaw_rate_radps);
        let bow = unit(heading_rad);
        let state = VesselState {
            position: last.position,
            heading_rad,
            surge_mps: next.surge_mps + bow.dot(current),
            sway_mps: next.sway_mps + bow.cross(current),
            yaw_rate_radps: next.yaw_rate_radps,
        };
        let mean = (before + state.ground_velocity_with(bow)) * 0.5;
        VesselState { position: last.position + mean * dt_s, ..state }
    }

    /// Moves the estimate; returns it, with as much of the measurement as that is worth.
    fn correct(&mut self, dt_s: f64, expected: &VesselState, measured: &VesselState) -> VesselState {
        let ObserverSettings { noise_radps, noise_mps, turn_bandwidth_radps, move_bandwidth_radps } =
            self.settings;
        let (turn, moving) = (turn_bandwidth_radps, move_bandwidth_radps);
        let off = Difference::between(measured, expected);
        let (in_turn, in_moving) = (Shares::of(dt_s, turn), Shares::of(dt_s, moving));
        let learned = [(off.surge_mps, moving), (off.yaw_rate_radps, turn)];
        for (bias, (off, bandwidth)) in self.bias.iter_mut().zip(learned) {
            *bias += dt_s * bandwidth * bandwidth / BIAS_DAMPING * off;
        }
        let estimate = off.added(expected, [in_moving.now, in_turn.now, in_moving.now, in_turn.now]);
        self.estimate = Some(estimate);

        let left = Difference::between(measured, &estimate);
        let right_m = unit(estimate.heading_rad).cross(left.position);
        let [position, heading, speed, rate] = &mut self.channels;
        let trust = [
            position.trust(right_m, 0.5 * noise_mps, in_moving),
            heading.trust(left.heading_rad, 0.5 * noise_radps, in_turn),
            speed.trust(left.sway_mps, noise_mps, in_moving),
            rate.trust(left.yaw_rate_radps, noise_radps, in_turn),
        ];
        left.added(&estimate, trust)
    }
}

fn is_near(expected: &VesselState, measured: &VesselState) -> bool {
    let off = Difference::between(measured, expected);
    off.position.norm() < JUMP_M && off.heading_rad.abs() < JUMP_RAD
}

/// What two states differ by.
#[derive(Debug, Clone, Copy)]
struct Difference {
    position: NorthEast,
    heading_rad: f64,
    surge_mps: f64,
    sway_mps: f64,
    yaw_rate_radps: f64,
}

impl Difference {
    fn between(a: &VesselState, b: &VesselState) -> Self {
        Self {
            position: a.position - b.position,
            heading_rad: ssa(a.heading_rad - b.heading_rad),
            surge_mps: a.surge_mps - b.surge_mps,
            sway_mps: a.sway_mps - b.sway_mps,
            yaw_rate_radps: a.yaw_rate_radps - b.yaw_rate_radps,
        }
    }

    /// `state` with these shares of the difference in position, heading, speeds and yaw rate added.
    fn added(&self, state: &VesselState, [position, heading, speed, rate]: [f64; 4]) -> VesselState {
        VesselState {
            position: state.position + self.position * position,
            heading_rad: state.heading_rad + self.heading_rad * heading,
            surge_mps: state.surge_mps + self.surge_mps * speed,
            sway_mps: state.sway_mps + self.sway_mps * speed,
            yaw_rate_radps: state.yaw_rate_radps + self.yaw_rate_radps * rate,
        }
    }
}

#[cfg(test)]
mod tests;
