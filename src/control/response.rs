//! The loop's delay, measured on how the boat answers its own steering.
//!
//! TIMESYNC tells how long messages are under way. What the autopilot, its outputs and the steering gear add, or a
//! link that answers no TIMESYNC, shows in the yaw rate alone: it follows the moment commanded one delay earlier. For
//! every delay D of a grid the yaw equation
//!
//! ```text
//! ṙ(t) = a N(t − D)/m33 + b d(r)/m33 + c (m11 − m22) u v/m33 + e
//! ```
//!
//! is fitted by least squares with forgetting, both sides through the same low-pass; the D that leaves the least is the
//! delay. Inertia, damping and a constant push are fitted along with it, so that a wrong hull model does not pass for
//! delay. The actuators' own lag is in N already: see [`crate::control::allocation`].

use nalgebra::{Matrix3, Vector3, Vector4};

use super::model::{Hull, WaterMotion, damping_force};

/// Spacing of the grid, s.
const BIN_S: f64 = 0.05;
/// Longest delay looked for, in bins: as far as is predicted across.
const LAGS: usize = 31;
/// Time constant of the low-pass, as a part of the hull's own in yaw, and its range, s.
const FILTER_PART: f64 = 0.3;
const FILTER_RANGE_S: (f64, f64) = (0.1, 2.0);
/// Time over which old samples lose their weight, in yaw time constants of the hull, and the least, s.
const MEMORY_PART: f64 = 30.0;
const LEAST_MEMORY_S: f64 = 60.0;
/// The fit is made again after so many bins.
const BINS_PER_FIT: u32 = 20;
/// Least time looked at before anything is said, as a part of the memory.
const LEAST_SEEN_PART: f64 = 0.3;
/// The delayed moment has to explain this part of what else stays unexplained.
const LEAST_EXPLAINED: f64 = 0.6;
/// A moment that works so differently from the model is not what moves the boat: a boat that rings answers every delay a
/// little.
const EFFECT_RANGE: (f64, f64) = (0.45, 2.2);

/// A delay as it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredDelay {
    /// From the measurement of a state to the effect of the command made from it, s.
    pub delay_s: f64,
    /// Standard error of that, s.
    pub deviation_s: f64,
    /// Part of the yaw acceleration that the delayed moment explains, 0 to 1.
    pub explained: f64,
}

/// A measured delay that is longer than the known one by more than this is believed, s…
const BELIEVED_BEYOND_S: f64 = 0.15;
/// …until it is longer by less than this, s.
const FORGOTTEN_WITHIN_S: f64 = 0.05;
/// A measurement with a larger standard error is not used, s.
const MOST_DEVIATION_S: f64 = 0.03;

/// Which delay the predictor is told.
#[derive(Debug, Clone, Copy, Default)]
pub struct DelayChoice {
    believes_response: bool,
}

impl DelayChoice {
    /// The delay to steer by, s, of what messages take on their way and what the boat's answer shows.
    ///
    /// The messages' way is exact as far as it goes, and is used unless the boat answers later by so much that
    /// something else delays it: outputs, a slow steering gear, or a link that answers no TIMESYNC. A boat that
    /// answers sooner than its model contradicts the model, not the clock.
    pub fn choose(&mut self, transport_s: Option<f64>, measured: Option<MeasuredDelay>) -> Option<f64> {
        let known_s = transport_s.unwrap_or(0.0);
        let clear = measured.filter(|measured| measured.deviation_s <= MOST_DEVIATION_S);
        let excess_s = clear.map_or(0.0, |measured| measured.delay_s - known_s);
        self.believes_response =
            excess_s > if self.believes_response { FORGOTTEN_WITHIN_S } else { BELIEVED_BEYOND_S };
        if self.believes_response { Some(known_s + excess_s) } else { transport_s }
    }
}

/// The sums that depend on the delay, one of each for every delay: of the delayed moment's products. Sum by sum, so that
/// several delays are learned at once.
#[derive(Debug, Clone, Copy)]
struct MomentSums {
    /// With the moment itself.
    itself: [f64; LAGS],
    /// With damping, coupling and a constant.
    damping: [f64; LAGS],
    coupling: [f64; LAGS],
    constant: [f64; LAGS],
    /// With the acceleration.
    acceleration: [f64; LAGS],
}

impl MomentSums {
    const NONE: Self = Self {
        itself: [0.0; LAGS],
        damping: [0.0; LAGS],
        coupling: [0.0; LAGS],
        constant: [0.0; LAGS],
        acceleration: [0.0; LAGS],
    };

    /// Takes the moments of all delays, the newest first, and what was seen with them.
    fn learn(&mut self, keep: f64, moments: &[f64; LAGS], seen: &Vector3<f64>, acceleration: f64) {
        let add = |sums: &mut [f64; LAGS], factor: f64| {
            for (sum, moment) in sums.iter_mut().zip(moments) {
                *sum = *sum * keep + factor * moment;
            }
        };
        for (sum, moment) in self.itself.iter_mut().zip(moments) {
            *sum = *sum * keep + moment * moment;
        }
        add(&mut self.damping, seen[0]);
        add(&mut self.coupling, seen[1]);
        add(&mut self.constant, seen[2]);
        add(&mut self.acceleration, acceleration);
    }

    /// The moment's products with damping, coupling and a constant, at one delay.
    fn with_seen(&self, lag: usize) -> Vector3<f64> {
        Vector3::new(self.damping[lag], self.coupling[lag], self.constant[lag])
    }
}

/// Watches commanded moments and the yaw rate that follows.
#[derive(Debug, Clone)]
pub struct YawResponse {
    inertia_kgm2: f64,
    munk_kg: f64,
    damping: [f64; 3],
    filter_s: f64,
    memory_s: f64,
    /// What one bin moves the low-pass by, and what it leaves of the old samples' weight.
    filter_gain: f64,
    keep: f64,
    last: Option<WaterMotion>,
    /// The bin being filled: time, and the sums of moment, yaw rate, damping and coupling over it.
    filled_s: f64,
    sums: Vector4<f64>,
    /// Low-passed moment, yaw rate, damping and coupling, as accelerations.
    slow: Vector4<f64>,
    /// Low-passed moments, the newest at `newest` and the older ones behind it: a ring that is written twice, so that all
    /// delays lie in a row wherever it begins.
    moments: [f64; 2 * LAGS],
    newest: usize,
    bins: u32,
    weight: f64,
    square: f64,
    /// Sums that no delay enters: products of damping, coupling and a constant with one another, and with the
    /// acceleration.
    squares: Matrix3<f64>,
    products: Vector3<f64>,
    moment_sums: MomentSums,
    measured: Option<MeasuredDelay>,
}

impl YawResponse {
    /// A watch over a boat with this nominal hull that has not seen anything.
    #[must_use]
    pub fn new(hull: &Hull) -> Self {
        let yaw_s = hull.m33_kgm2 / hull.yaw_damping[0].max(f64::MIN_POSITIVE);
        let (least_s, most_s) = FILTER_RANGE_S;
        let memory_s = (MEMORY_PART * yaw_s).clamp(LEAST_MEMORY_S, 10.0 * LEAST_MEMORY_S);
        let filter_s = (FILTER_PART * yaw_s).clamp(least_s, most_s);
        Self {
            inertia_kgm2: hull.m33_kgm2,
            munk_kg: hull.m11_kg - hull.m22_kg,
            damping: hull.yaw_damping,
            filter_s,
            memory_s,
            filter_gain: -(-BIN_S / filter_s).exp_m1(),
            keep: (-BIN_S / memory_s).exp(),
            last: None,
            filled_s: 0.0,
            sums: Vector4::zeros(),
            slow: Vector4::zeros(),
            moments: [0.0; 2 * LAGS],
            newest: 0,
            bins: 0,
            weight: 0.0,
            square: 0.0,
            squares: Matrix3::zeros(),
            products: Vector3::zeros(),
            moment_sums: MomentSums::NONE,
            measured: None,
        }
    }

    /// The boat has been interrupted: what comes next does not follow from what was commanded. What has been learned
    /// of the delay is kept.
    pub fn interrupt(&mut self) {
        self.last = None;
        self.filled_s = 0.0;
        self.sums = Vector4::zeros();
        self.bins = 0;
    }

    /// The delay, when the boat has answered clearly enough to tell.
    #[must_use]
    pub fn delay(&self) -> Option<MeasuredDelay> {
        self.measured
    }

    /// Takes the `motion` measured now, `dt_s` after the last one, and the moment commanded since then.
    pub fn step(&mut self, dt_s: f64, motion: &WaterMotion, commanded_nm: f64) {
        let Some(last) = self.last.replace(*motion) else { return };
        let mut done_s = 0.0;
        while done_s < dt_s {
            let part_s = (BIN_S - self.filled_s).min(dt_s - done_s);
            let share = (done_s + 0.5 * part_s) / dt_s;
            let between = |from: f64, to: f64| from + share * (to - from);
            let rate = between(last.yaw_rate_radps, motion.yaw_rate_radps);
            let coupling = between(last.surge_mps * last.sway_mps, motion.surge_mps * motion.sway_mps);
            let damping = damping_force(self.damping, rate);
            self.sums += Vector4::new(commanded_nm, rate, damping, self.munk_kg * coupling) * part_s;
            self.filled_s += part_s;
            done_s += part_s;
            if self.filled_s >= BIN_S * (1.0 - 1.0e-9) {
                self.close_bin();
            }
        }
    }

    fn close_bin(&mut self) {
        let mean = self.sums / self.filled_s;
        (self.filled_s, self.sums) = (0.0, Vector4::zeros());
        let scale = 1.0 / self.inertia_kgm2;
        let mean = Vector4::new(mean[0] * scale, mean[1], mean[2] * scale, mean[3] * scale);
        let before = self.slow;
        self.slow += (mean - before) * self.filter_gain;
        let middle = (before + self.slow) * 0.5;
        let acceleration = (self.slow[1] - before[1]) / BIN_S;

        self.newest = self.newest.checked_sub(1).unwrap_or(LAGS - 1);
        self.moments[self.newest] = middle[0];
        self.moments[self.newest + LAGS] = middle[0];
        self.bins = self.bins.saturating_add(1);
        // The first moments of the store and of the low-pass are not real.
        let settling = LAGS as f64 + 5.0 * self.filter_s / BIN_S;
        if f64::from(self.bins) < settling {
            return;
        }
        self.learn(acceleration, &middle);
        if self.bins.is_multiple_of(BINS_PER_FIT) {
            self.measured = self.measure();
        }
    }

    fn learn(&mut self, acceleration: f64, middle: &Vector4<f64>) {
        let keep = self.keep;
        self.weight = keep * self.weight + 1.0;
        self.square = keep * self.square + acceleration * acceleration;
        let seen = Vector3::new(middle[2], middle[3], 1.0);
        self.squares = self.squares * keep + seen * seen.transpose();
        self.products = self.products * keep + seen * acceleration;
        if let Some(newest_first) = self.moments[self.newest..].first_chunk() {
            self.moment_sums.learn(keep, newest_first, &seen, acceleration);
        }
    }

    fn measure(&self) -> Option<MeasuredDelay> {
        if self.weight * BIN_S < LEAST_SEEN_PART * self.memory_s {
            return None;
        }
        let (least, most) = EFFECT_RANGE;
        // What the equation leaves without any moment; what a moment changes in it is a division by the part of its
        // square that the others do not explain (the Schur complement).
        let common = ridged(self.squares).cholesky()?;
        let without = common.solve(&self.products);
        let idle = (self.square - without.dot(&self.products)).max(0.0);
        let mut left = [f64::INFINITY; LAGS];
        let mut makes_sense = [false; LAGS];
        for lag in 0..LAGS {
            let seen = self.moment_sums.with_seen(lag);
            let shared = common.solve(&seen);
            let own = ridge(self.moment_sums.itself[lag]) - seen.dot(&shared);
            if own <= 0.0 {
                return None;
            }
            let unexplained = self.moment_sums.acceleration[lag] - seen.dot(&without);
            let effect = unexplained / own;
            // A moment that turns the boat its own way, against damping that holds it back.
            makes_sense[lag] = (least..=most).contains(&effect) && without[0] - effect * shared[0] < 0.0;
            left[lag] = (idle - effect * unexplained).max(0.0);
        }
        let best = (0..LAGS).filter(|lag| makes_sense[*lag]).min_by(|a, b| left[*a].total_cmp(&left[*b]))?;
        if best + 1 >= LAGS {
            return None;
        }
        let explained = 1.0 - left[best] / idle.max(f64::MIN_POSITIVE);
        if explained < LEAST_EXPLAINED {
            return None;
        }
        // A parabola through the least residual and its neighbours; no delay is shorter than none.
        let (here, after) = (left[best], left[best + 1]);
        let before = if best == 0 { after } else { left[best - 1] };
        let bend = before - 2.0 * here + after;
        if bend <= 0.0 {
            return None;
        }
        let offset = 0.5 * (before - after) / bend;
        let curvature = bend / (self.weight * BIN_S * BIN_S);
        let independent = self.weight * BIN_S / (2.0 * self.filter_s);
        let variance = left[best] / self.weight;
        Some(MeasuredDelay {
            delay_s: (best as f64 + offset) * BIN_S,
            deviation_s: (2.0 * variance / (independent * curvature)).sqrt(),
            explained,
        })
    }
}

/// Share of the diagonal that is added to it: a boat that never turned tells nothing of its damping.
const RIDGE: f64 = 1.0e-6;

fn ridge(square: f64) -> f64 {
    square + RIDGE * square + f64::MIN_POSITIVE
}

fn ridged(mut squares: Matrix3<f64>) -> Matrix3<f64> {
    for index in 0..3 {
        squares[(index, index)] = ridge(squares[(index, index)]);
    }
    squares
}

#[cfg(test)]
mod tests;
