//! Adaptive proportional-integral sliding-mode control of surge and yaw.

use super::allocation::Allocation;
use super::axis::{AxisInput, AxisOutcome, SlidingAxis};
use super::boat::{Boat, ControlSettings};
use super::command::Wrench;
use super::law::{Law, LawDiagnostics, LawInput};
use super::model::Hull;

/// The total yaw gain times the time in which the law steers blindly is kept below this. Below a half a loop is at ease,
/// above one it rings.
const MOST_GAIN_BY_TIME: f64 = 0.7;
/// Part of a predicted delay that is blind nevertheless: what a model does not know of the boat.
const BLIND_PART: f64 = 0.2;
/// Time constant of the mean step, s.
const STEP_TIME_S: f64 = 5.0;

/// The controller of both axes.
///
/// The yaw gains, those of the heading included, are lowered together where steps are so long or a delay so large that
/// the boat would ring.
#[derive(Debug, Clone)]
pub struct PiSmc {
    hull: Hull,
    heading_gain: f64,
    yaw_rate_max_radps: f64,
    surge: SlidingAxis,
    yaw: SlidingAxis,
    last: Option<(AxisInput, AxisInput)>,
    /// Mean length of the last steps, s.
    step_s: Option<f64>,
}

impl PiSmc {
    /// The controller of a boat.
    #[must_use]
    pub fn new(boat: &Boat) -> Self {
        Self::with_gains(boat, &boat.control)
    }

    /// The controller of a boat with gains of its own.
    #[must_use]
    pub fn with_gains(boat: &Boat, control: &ControlSettings) -> Self {
        // A tenth of the speed goes sideways in an ordinary turn.
        let sway = 0.1 * control.surge.typical_rate;
        let surge_coupling = sway * control.yaw.typical_rate;
        let yaw_coupling = sway * control.surge.typical_rate;
        Self {
            surge: SlidingAxis::new(control.surge.clone(), boat.hull.surge_parameters(), surge_coupling),
            yaw: SlidingAxis::new(control.yaw.clone(), boat.hull.yaw_parameters(), yaw_coupling),
            hull: boat.hull.clone(),
            heading_gain: control.heading_gain,
            yaw_rate_max_radps: boat.limits.yaw_rate_max_radps,
            last: None,
            step_s: None,
        }
    }

    /// Part of the yaw gains that steps of `dt_s` and a prediction over `predicted_s` leave stable.
    fn gain_part(&mut self, dt_s: f64, predicted_s: f64) -> f64 {
        let mean_s = self.step_s.unwrap_or(dt_s);
        let step_s = mean_s + dt_s / (STEP_TIME_S + dt_s) * (dt_s - mean_s);
        self.step_s = Some(step_s);
        let blind_s = step_s + BLIND_PART * predicted_s;
        (MOST_GAIN_BY_TIME / (self.yaw.total_gain() * blind_s)).min(1.0)
    }
}

impl Law for PiSmc {
    fn engage(&mut self, surge_mps: f64, yaw_rate_radps: f64) {
        self.surge.engage(surge_mps);
        self.yaw.engage(yaw_rate_radps);
        self.last = None;
        self.step_s = None;
    }

    fn demand(&mut self, dt_s: f64, input: &LawInput<'_>) -> Wrench {
        let limit = self.yaw_rate_max_radps;
        let LawInput { reference, motion, predicted_s, .. } = *input;
        let gain_part = self.gain_part(dt_s, predicted_s);
        self.yaw.use_part_of_gains(gain_part);
        let correction =
            gain_part * self.heading_gain * reference.heading_error_rad * reference.yaw_per_course;
        let alpha_r = (correction + reference.heading_rate_radps).clamp(-limit, limit);
        let surge = AxisInput {
            target: reference.speed_mps,
            actual: input.state.surge_mps,
            drift: input.state.surge_mps - motion.surge_mps,
            coupling: motion.sway_mps * motion.yaw_rate_radps,
            effect: self.hull.surge_effect(),
        };
        let yaw = AxisInput {
            target: alpha_r,
            actual: input.state.yaw_rate_radps,
            drift: 0.0,
            coupling: motion.surge_mps * motion.sway_mps,
            effect: self.hull.yaw_effect(),
        };
        self.last = Some((surge, yaw));
        Wrench { surge_n: self.surge.demand(dt_s, &surge), sway_n: 0.0, yaw_nm: self.yaw.demand(dt_s, &yaw) }
    }

    fn settle(&mut self, dt_s: f64, allocation: &Allocation) {
        let Some((surge, yaw)) = &self.last else { return };
        let achieved = allocation.achieved;
        let surge_outcome = AxisOutcome { achieved: achieved.surge_n, saturated: allocation.surge_saturated };
        let yaw_outcome = AxisOutcome { achieved: achieved.yaw_nm, saturated: allocation.yaw_saturated };
        self.surge.settle(dt_s, surge, surge_outcome);
        self.yaw.settle(dt_s, yaw, yaw_outcome);
    }

    fn retune(&mut self, boat: &Boat) -> bool {
        let fresh = Self::new(boat);
        self.heading_gain = fresh.heading_gain;
        self.surge.take_gains(fresh.surge);
        self.yaw.take_gains(fresh.yaw);
        true
    }

    fn diagnostics(&self) -> LawDiagnostics {
        let (alpha_u_mps, alpha_r_radps) =
            self.last.as_ref().map_or((0.0, 0.0), |(surge, yaw)| (surge.target, yaw.target));
        LawDiagnostics {
            alpha_u_mps,
            alpha_r_radps,
            surface_u: self.surge.surface(),
            surface_r: self.yaw.surface(),
            disturbance_u: self.surge.disturbance(),
            disturbance_r: self.yaw.disturbance(),
        }
    }
}

#[cfg(test)]
mod tests;
