//! The firmware's turn-rate loop, as far as a boat in a current has to know it.
//!
//! In GUIDED the firmware steers by (FF·w + P·(w − r) + I·∫(w − r)) / speed over ground for a turn rate w that it is told and
//! r that it makes. A rudder acts by the speed through the water: in a following current the firmware steers too little
//! at first, and its integral makes up for that later. Both are known here, so w is chosen such that r is what is wanted
//! from the beginning: what is needed is FF·r·ratio, with the ratio of ground to water speed.

use crate::vehicle::parameters::ParameterReader;

/// Names of FF, P and I.
pub(super) const NAMES: [&str; 3] = ["ATC_STR_RAT_FF", "ATC_STR_RAT_P", "ATC_STR_RAT_I"];
/// ArduRover's value of all three, where the vehicle does not say.
const USUAL: f64 = 0.2;
/// Less than this, together, is no loop that could be told anything.
const LEAST_GAIN: f64 = 1e-3;
/// A loop that has not been told anything for so long starts afresh, seconds.
const LONGEST_GAP_S: f64 = 0.5;
/// The firmware's integral gives this much steering at the most.
const INTEGRAL_MAX: f64 = 1.0;

/// What the firmware's loop is thought to be at.
#[derive(Debug, Clone, Copy)]
pub(super) struct RateLoop {
    feed_forward: f64,
    proportional: f64,
    integral: f64,
    /// ∫(w − r), rad.
    sum_rad: f64,
    /// When it was told something last, and by how much that was more than wanted: w − r, rad/s.
    last: Option<(f64, f64)>,
}

impl Default for RateLoop {
    fn default() -> Self {
        Self { feed_forward: USUAL, proportional: USUAL, integral: USUAL, sum_rad: 0.0, last: None }
    }
}

impl RateLoop {
    /// Takes over the vehicle's gains, as far as they are known and make sense.
    pub(super) fn configure(&mut self, parameters: &ParameterReader) {
        let gain = |name| parameters.value(name).filter(|gain| (0.0..=1000.0).contains(gain));
        let [feed_forward, proportional, integral] = NAMES.map(|name| gain(name).unwrap_or(USUAL));
        *self = Self { feed_forward, proportional, integral, ..*self };
    }

    /// The boat is not driven: the firmware begins anew too.
    pub(super) fn reset(&mut self) {
        (self.sum_rad, self.last) = (0.0, None);
    }

    /// The turn rate to tell, so that the boat turns at `wanted_radps`; `ground_per_water` is 1 where there is no
    /// current, or where the steering does not need the water's flow.
    pub(super) fn told_radps(&mut self, now_s: f64, wanted_radps: f64, ground_per_water: f64) -> f64 {
        let gain = self.feed_forward + self.proportional;
        if gain < LEAST_GAIN {
            return wanted_radps;
        }
        let most_rad = INTEGRAL_MAX / self.integral.max(LEAST_GAIN);
        self.sum_rad = match self.last {
            Some((last_s, more_radps)) if (0.0..=LONGEST_GAP_S).contains(&(now_s - last_s)) => {
                (self.sum_rad + more_radps * (now_s - last_s)).clamp(-most_rad, most_rad)
            }
            _ => 0.0,
        };
        let needed = (self.feed_forward * ground_per_water + self.proportional) * wanted_radps;
        let told_radps = (needed - self.integral * self.sum_rad) / gain;
        self.last = Some((now_s, told_radps - wanted_radps));
        told_radps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A boat without inertia in a current, behind the firmware's loop; the rates that it makes, told by `told`.
    fn rates(gains: RateLoop, ratio: f64, mut told: impl FnMut(f64) -> f64) -> Vec<f64> {
        const DT_S: f64 = 0.04;
        let (mut sum_rad, mut rates) = (0.0, Vec::new());
        for step in 0..100 {
            let told_radps = told(f64::from(step) * DT_S);
            // FF·r·ratio = FF·w + P·(w − r) + I·sum, solved for r.
            let gain = gains.feed_forward + gains.proportional;
            let rate = (gain * told_radps + gains.integral * sum_rad)
                / (gains.feed_forward * ratio + gains.proportional);
            sum_rad += (told_radps - rate) * DT_S;
            rates.push(rate);
        }
        rates
    }

    proptest! {
        #[test]
        fn the_boat_turns_as_wanted_from_the_beginning(
            feed_forward in 0.05..2.0_f64, proportional in 0.0..2.0_f64, part in 0.2..3.0_f64,
            ratio in 1.0..2.5_f64, wanted in -1.5..1.5_f64,
        ) {
            let integral = part * (feed_forward + proportional);
            let gains = RateLoop { feed_forward, proportional, integral, ..RateLoop::default() };
            // What is more than that needs more than the firmware's integral may give.
            prop_assume!(feed_forward * (ratio - 1.0) * wanted.abs() < INTEGRAL_MAX);
            let mut outer = gains;
            for rate in rates(gains, ratio, |now_s| outer.told_radps(now_s, wanted, ratio)) {
                prop_assert!((rate - wanted).abs() <= 1e-6, "{rate} for {wanted}");
            }
            // The wanted rate alone would not do that.
            let plain = rates(gains, ratio, |_| wanted);
            let off = (ratio - 1.0) * feed_forward / (feed_forward * ratio + proportional);
            prop_assert!(((wanted - plain[0]) - off * wanted).abs() < 1e-9);
        }

        #[test]
        fn without_a_current_the_firmware_is_told_what_is_wanted(wanted in -1.5..1.5_f64, gap_s in 0.0..2.0_f64) {
            let mut outer = RateLoop::default();
            for step in 0..10 {
                prop_assert!((outer.told_radps(f64::from(step) * gap_s, wanted, 1.0) - wanted).abs() < 1e-12);
            }
        }

        #[test]
        fn whatever_the_gains_what_is_told_stays_finite_and_ends(
            gains in prop::array::uniform3(0.0..1000.0_f64), ratio in 1.0..2.5_f64, step_s in -1.0..2.0_f64,
        ) {
            let [feed_forward, proportional, integral] = gains;
            let mut outer = RateLoop { feed_forward, proportional, integral, ..RateLoop::default() };
            for step in 0..100 {
                let told = outer.told_radps(f64::from(step) * step_s, 1.0, ratio);
                prop_assert!(told.is_finite());
            }
            outer.reset();
            prop_assert_eq!(outer.sum_rad, 0.0);
        }
    }
}
