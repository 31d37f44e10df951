//! Where the boat has got to, by its velocity, where the position wanders.
//!
//! The position of a GPS fix wanders by decimetres over a minute; its velocity, from the carrier's Doppler shift, does not.
//! Integrated, the velocity drifts by less than that in the same time, so that the two together know more than either: a
//! filter that draws the integrated velocity slowly to the position (carrier smoothing; Hatch 1982). It also finds out
//! the velocity's constant error in the boat's own axes, by an accelerometer that is tilted or not calibrated: the
//! position has no such error.
//!
//! ```text
//! led' = R(ψ) (v − b) + K₁ y,   g' = −g/T + K₂ y,   b' = K₃ y,   y = p − led − g
//! ```
//!
//! with the gains of a Kalman filter of the error of `led`, of the wandering g and of b. Both axes behave alike, so that a
//! complex number (north + i east, or bow + i starboard) stands for a vector and the heading for a factor.
//!
//! How much of it is used follows from what the position is worth: the quick part of p − led is its noise. A position
//! without noise is taken as it is.

use helmlink_mission::geodesy::NorthEast;
use nalgebra::{Complex, Matrix3, Vector3};

use crate::guidance::{VesselState, unit};

/// Deviation of the position's wandering, m, and its time constant, s.
const WANDER_M: f64 = 0.3;
const WANDER_TIME_S: f64 = 60.0;
/// Noise of the position as white noise over one second, m²·s: 0.3 m five times a second.
const POSITION_NOISE_M2S: f64 = 0.018;
/// Noise of the velocity as white noise over one second, m²/s: 0.07 m/s five times a second.
const VELOCITY_NOISE_M2PS: f64 = 1.0e-3;
/// Deviation of the velocity's constant error, m/s, and how much it changes in a second, (m/s)²/s.
const OFFSET_MPS: f64 = 0.08;
const OFFSET_WALK: f64 = 1.0e-7;
/// Largest velocity offset that is believed, m/s.
const MOST_OFFSET_MPS: f64 = 0.15;
/// The gains are computed this often, s: the filter is slow.
const CORRECTION_S: f64 = 0.4;
/// A position this far from where the velocity has led is another one: the comparison starts anew, m.
const JUMP_M: f64 = 3.0;
/// Quick part of the position's error (rms) at which position and integrated velocity count half, m.
const NOISE_M: f64 = 0.07;
/// Time constants by which the quick part is told from the slow one, and of its level, s.
const SLOW_S: f64 = 5.0;
const LEVEL_S: f64 = 20.0;

type Plane = Complex<f64>;

fn plane(vector: NorthEast) -> Plane {
    Plane::new(vector.north_m, vector.east_m)
}

/// Where the velocity has led.
#[derive(Debug, Clone, Copy)]
struct Led {
    position: NorthEast,
    velocity: NorthEast,
}

/// Position and velocity put together.
#[derive(Debug, Clone, Copy)]
pub struct DeadReckoning {
    led: Option<Led>,
    /// Error of the velocity toward bow and starboard, m/s.
    offset: Plane,
    /// What the position is off by, m.
    wander: Plane,
    /// Of the errors of where the velocity has led, of the wandering and of the offset.
    covariance: Matrix3<Plane>,
    /// Time since the last correction, s, and its integral turned by the heading.
    since_s: f64,
    turned_s: Plane,
    /// Slow part of what the position says more, m, and variance of the quick one, m².
    slow: Plane,
    variance_m2: f64,
}

impl Default for DeadReckoning {
    fn default() -> Self {
        let mut new = Self {
            led: None,
            offset: Plane::default(),
            wander: Plane::default(),
            covariance: Matrix3::zeros(),
            since_s: 0.0,
            turned_s: Plane::default(),
            slow: Plane::default(),
            variance_m2: 0.0,
        };
        new.covariance[(2, 2)] = Plane::from(OFFSET_MPS * OFFSET_MPS);
        new
    }
}

impl DeadReckoning {
    /// Learns from one tick; returns `state` without the velocity's error, its position put right as far as the velocity
    /// knows better.
    pub fn correct(&mut self, dt_s: f64, state: &VesselState) -> VesselState {
        let surge_mps = state.surge_mps - self.offset.re;
        let sway_mps = state.sway_mps - self.offset.im;
        let better = VesselState { surge_mps, sway_mps, ..*state };
        let bow = unit(state.heading_rad);
        let velocity = better.ground_velocity_with(bow);
        let expected = self.led.map(|led| led.position + (led.velocity + velocity) * (0.5 * dt_s));
        let Some(position) = expected.filter(|led| (*led - state.position).norm() < JUMP_M) else {
            self.start(state.position, velocity);
            return better;
        };
        self.led = Some(Led { position, velocity });
        self.since_s += dt_s;
        self.turned_s += plane(bow) * dt_s;
        if self.since_s >= CORRECTION_S {
            self.draw(state.position);
        }
        let behind = self.led.map_or(NorthEast::ZERO, |led| state.position - led.position);
        let share = self.share(dt_s, plane(behind));
        VesselState { position: state.position - behind * share, ..better }
    }

    /// Time has passed unseen: what the velocity led to in it is not known.
    pub fn interrupt(&mut self) {
        self.led = None;
    }

    /// The velocity's error toward bow and starboard, m/s.
    #[must_use]
    pub fn offset_mps(&self) -> [f64; 2] {
        [self.offset.re, self.offset.im]
    }

    /// Starts anew from a position that is off by its wandering; what is known of the offset stays.
    fn start(&mut self, position: NorthEast, velocity: NorthEast) {
        let offset = self.covariance[(2, 2)];
        *self = Self { led: Some(Led { position, velocity }), offset: self.offset, ..Self::default() };
        let wander_m2 = WANDER_M * WANDER_M;
        self.covariance = Matrix3::zeros();
        self.covariance[(0, 0)] = Plane::from(wander_m2 + 0.5 * POSITION_NOISE_M2S);
        self.covariance[(0, 1)] = Plane::from(wander_m2);
        self.covariance[(1, 0)] = Plane::from(wander_m2);
        self.covariance[(1, 1)] = Plane::from(wander_m2);
        self.covariance[(2, 2)] = offset;
    }

    /// One step of the Kalman filter over the time since the last one.
    fn draw(&mut self, position: NorthEast) {
        let Some(led) = &mut self.led else { return };
        let time_s = std::mem::take(&mut self.since_s);
        let turned_s = std::mem::take(&mut self.turned_s);
        let memory = (-time_s / WANDER_TIME_S).exp();
        let mut ahead = Matrix3::identity();
        ahead[(0, 2)] = turned_s;
        ahead[(1, 1)] = Plane::from(memory);
        let mut covariance = ahead * self.covariance * ahead.adjoint();
        covariance[(0, 0)] += VELOCITY_NOISE_M2PS * time_s;
        covariance[(1, 1)] += WANDER_M * WANDER_M * (1.0 - memory * memory);
        covariance[(2, 2)] += OFFSET_WALK * time_s;
        self.wander *= memory;

        // What is seen is the wandering less the error of where the velocity has led.
        let spread: Vector3<Plane> = covariance.column(1) - covariance.column(0);
        let variance_m2 = (spread[1] - spread[0]).re + POSITION_NOISE_M2S / time_s;
        let gain = spread / Plane::from(variance_m2);
        let surprise = plane(position - led.position) - self.wander;
        let [drawn, wander, offset] = [gain[0] * surprise, gain[1] * surprise, gain[2] * surprise];
        led.position = led.position - NorthEast::new(drawn.re, drawn.im);
        self.wander += wander;
        let limited = |part: f64| part.clamp(-MOST_OFFSET_MPS, MOST_OFFSET_MPS);
        let offset = self.offset + offset;
        self.offset = Plane::new(limited(offset.re), limited(offset.im));
        covariance -= gain * spread.adjoint();
        self.covariance = (covariance + covariance.adjoint()) * Plane::from(0.5);
    }

    /// How much of the way back to where the velocity has led to go, 0 to 1, `behind` being that way.
    fn share(&mut self, dt_s: f64, behind: Plane) -> f64 {
        self.slow += (behind - self.slow) * (dt_s / SLOW_S).min(1.0);
        let quick_m2 = 0.5 * (behind - self.slow).norm_sqr();
        self.variance_m2 += (dt_s / LEVEL_S).min(1.0) * (quick_m2 - self.variance_m2);
        let level = self.variance_m2 / (NOISE_M * NOISE_M);
        level * level / (1.0 + level * level)
    }
}

#[cfg(test)]
mod tests;
