//! The façade: where the boat is and the path in, throttle and steering out.

use helmlink_mission::path::Path;
use thiserror::Error;

use super::allocation::{Allocator, Situation};
use super::boat::Boat;
use super::command::{Command, Wrench};
use super::controller::{Controller, Equipment};
use super::dead_reckoning::DeadReckoning;
use super::law::{Law, LawDiagnostics, LawInput};
use super::model::{Hull, SwayModel, WaterMotion};
use super::observer::Observer;
use super::predictor::Predictor;
use super::response::{MeasuredDelay, YawResponse};
use super::sway_balance::{CompassError, SwayBalance};
use crate::guidance::drift::DriftEstimator;
use crate::guidance::{EndOfPath, Guidance, GuidanceInput, Reference, StateError, VesselState, Water, unit};

/// Shortest step taken, s.
pub const MIN_STEP_S: f64 = 1.0e-4;
/// Longest step taken, s. After a longer gap the controller's memory is stale: engage again.
pub const MAX_STEP_S: f64 = 1.0;

/// Longest gap in the telemetry that is bridged, s.
pub const LONGEST_GAP_S: f64 = 5.0;

/// Why a step was refused. The controller's state is untouched; send a neutral command.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum HelmError {
    /// The state is not a number or absurd.
    #[error(transparent)]
    State(#[from] StateError),
    /// The time since the last step is out of range.
    #[error("a step of {dt_s} s is outside {MIN_STEP_S} to {MAX_STEP_S} s; after a longer gap engage again")]
    Step {
        /// Step asked for, s.
        dt_s: f64,
    },
    /// The wanted speed is out of range.
    #[error("a wanted speed of {speed_mps} m/s is outside 0 to {most_mps} m/s, the boat's limit")]
    Speed {
        /// Speed asked for, m/s.
        speed_mps: f64,
        /// Largest speed of the boat, m/s.
        most_mps: f64,
    },
    /// The place on the path to start from is not a number.
    #[error("a start at arc length {progress_m} m of the path is not a finite number")]
    Progress {
        /// Arc length asked for, m.
        progress_m: f64,
    },
    /// The result is not a number: the state is plausible by itself but the path or gains are not.
    #[error("the controller's output is not finite; engage again")]
    Output,
}

/// What the helm thought at one tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Diagnostics {
    /// The boat as it is believed to be now, before any prediction: what the measurements are made of by the observer.
    pub observed: VesselState,
    /// Guidance.
    pub reference: Reference,
    /// Control law.
    pub law: LawDiagnostics,
    /// Forces demanded and predicted: surge (N) and yaw (N·m) wanted.
    pub surge_demand_n: f64,
    /// Yaw moment wanted, N·m.
    pub yaw_demand_nm: f64,
    /// Estimate of the water.
    pub water: Water,
    /// Speed over ground over speed through the water, along the bow; 1 where either is too slow to tell.
    pub ground_per_water: f64,
    /// Whether a limit cut surge off.
    pub surge_saturated: bool,
    /// Whether a limit cut yaw off.
    pub yaw_saturated: bool,
}

/// Result of one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Output {
    /// What to send.
    pub command: Command,
    /// Why.
    pub diagnostics: Diagnostics,
}

/// Range of the ratio of ground to water speed that is told: against the current the firmware has rudder enough.
const GROUND_PER_WATER: (f64, f64) = (1.0, 2.5);

fn ground_per_water(ground_mps: f64, water_mps: f64) -> f64 {
    /// Slower than this the ratio says nothing, m/s.
    const LEAST_MPS: f64 = 0.3;
    if ground_mps < LEAST_MPS || water_mps < LEAST_MPS {
        return 1.0;
    }
    (ground_mps / water_mps).clamp(GROUND_PER_WATER.0, GROUND_PER_WATER.1)
}

/// Guidance, law and allocation of one boat.
pub struct Helm {
    hull: Hull,
    speed_max_mps: f64,
    drift_time_s: f64,
    equipment: Equipment,
    guidance: Box<dyn Guidance>,
    law: Box<dyn Law>,
    allocator: Allocator,
    sway: SwayModel,
    drift: DriftEstimator,
    observer: Option<Observer>,
    reckoning: DeadReckoning,
    balance: SwayBalance,
    predictor: Predictor,
    response: YawResponse,
    /// Forces of the last command.
    commanded: Wrench,
}

impl Helm {
    /// The practical guidance with the adaptive PI sliding-mode controller.
    #[must_use]
    pub fn new(boat: &Boat, end: EndOfPath) -> Self {
        Self::with_controller(boat, Controller::PiSmc, end)
    }

    /// A controller by name.
    #[must_use]
    pub fn with_controller(boat: &Boat, controller: Controller, end: EndOfPath) -> Self {
        let equipment = boat.parts.applied(controller.equipment());
        Self {
            equipment,
            guidance: controller.guidance(boat, end),
            law: controller.law(boat),
            hull: boat.hull.clone(),
            speed_max_mps: boat.limits.speed_max_mps,
            drift_time_s: boat.guidance.drift_time_s,
            allocator: Allocator::new(&boat.actuators, &boat.hull),
            sway: SwayModel::default(),
            drift: DriftEstimator::default(),
            observer: equipment.observes_state.then(|| Observer::new(boat.observer)),
            reckoning: DeadReckoning::default(),
            balance: SwayBalance::new(if equipment.adapts { boat.guidance.sway_spread } else { 0.0 }),
            predictor: Predictor::default(),
            response: YawResponse::new(&boat.hull),
            commanded: Wrench::default(),
        }
    }

    /// Takes over the control gains of `boat` and keeps what has been learned; false for a law that cannot.
    pub fn retune(&mut self, boat: &Boat) -> bool {
        self.law.retune(boat)
    }

    /// Tells the delay from the measurement of a state to the effect of the command made from it, s: telemetry's
    /// age, transport and the autopilot's loop, without the actuator's own lag. The state is then predicted across
    /// it with the commands already on their way, and [`Reference`] speaks of the predicted place. Clamped to
    /// 0…[`super::predictor::MAX_DELAY_S`]; zero at first. A controller without prediction stays as it is.
    pub fn set_delay_s(&mut self, delay_s: f64) {
        if self.equipment.predicts {
            self.predictor.set_delay_s(delay_s);
        }
    }

    /// The delay that is predicted across, s.
    #[must_use]
    pub fn delay_s(&self) -> f64 {
        self.predictor.delay_s()
    }

    /// The delay as the boat's answer to its steering shows it, once it has answered clearly enough.
    #[must_use]
    pub fn measured_delay(&self) -> Option<MeasuredDelay> {
        self.response.delay()
    }

    /// What the compass is off by, as far as turns in a current have told.
    #[must_use]
    pub fn compass_error(&self) -> CompassError {
        self.balance.compass()
    }

    /// Takes over from `state`, near arc length `progress_m` of the path, without a jump in speed or turn.
    ///
    /// # Errors
    /// Refuses a state or a place that is not a number or absurd.
    pub fn engage(&mut self, state: &VesselState, progress_m: f64) -> Result<(), HelmError> {
        state.check()?;
        if !progress_m.is_finite() {
            return Err(HelmError::Progress { progress_m });
        }
        self.guidance.engage(state, progress_m);
        self.law.engage(state.surge_mps, state.yaw_rate_radps);
        self.allocator.reset();
        self.sway = SwayModel::default();
        self.drift = if self.equipment.observes_water {
            DriftEstimator::starting_at(state)
        } else {
            DriftEstimator::default()
        };
        self.predictor.reset();
        self.response.interrupt();
        self.reckoning = DeadReckoning::default();
        if let Some(observer) = &mut self.observer {
            observer.reset();
        }
        self.commanded = Wrench::default();
        Ok(())
    }

    /// `dt_s` have passed without telemetry while the last command went on to act: the observer follows the model across
    /// the gap, and nothing is concluded from it. Call it before [`Self::step`], with the rest of the time for that.
    pub fn bridge_gap(&mut self, dt_s: f64) {
        if !(0.0..=LONGEST_GAP_S).contains(&dt_s) {
            return;
        }
        self.reckoning.interrupt();
        self.response.interrupt();
        let current = self.drift.current();
        if let Some(observer) = &mut self.observer {
            observer.coast(dt_s, &self.hull, self.commanded, current);
        }
    }

    /// One tick: `dt_s` is the measured time since the last one, `speed_mps` the speed wanted over ground.
    ///
    /// Allocates nothing. Handles any step from 5 to 50 Hz and beyond.
    ///
    /// # Errors
    /// Refuses a state, step or speed that is not a number or out of range, and then changes nothing.
    pub fn step(
        &mut self,
        dt_s: f64,
        state: &VesselState,
        path: &Path,
        speed_mps: f64,
    ) -> Result<Output, HelmError> {
        state.check()?;
        if !(MIN_STEP_S..=MAX_STEP_S).contains(&dt_s) {
            return Err(HelmError::Step { dt_s });
        }
        if !(0.0..=self.speed_max_mps).contains(&speed_mps) {
            return Err(HelmError::Speed { speed_mps, most_mps: self.speed_max_mps });
        }
        let acted = self.predictor.advance(dt_s);
        let observed = match &mut self.observer {
            Some(observer) => {
                let state = self.reckoning.correct(dt_s, state);
                observer.observe(dt_s, &self.hull, &state, acted, self.drift.current())
            }
            None => *state,
        };
        let state = &observed;
        let measured = self.observe_water(dt_s, state);
        self.response.step(dt_s, &measured, self.commanded.yaw_nm);
        let current = self.drift.current();
        let (state, motion) = self.predictor.predict(dt_s, &self.hull, state, measured, current);
        let state = &state;
        let water = Water { sway_mps: motion.sway_mps, sway_excess: self.balance.excess(), current };
        let mut reference = self.guidance.step(dt_s, &GuidanceInput { state, path, speed_mps, water });
        if !self.equipment.feeds_forward {
            reference.heading_rate_radps = 0.0;
        }
        let predicted_s = self.predictor.delay_s();
        let demand = self.law.demand(dt_s, &LawInput { reference: &reference, state, motion, predicted_s });
        let situation = Situation { motion, heading_error_rad: reference.heading_error_rad };
        let allocation = self.allocator.allocate(dt_s, demand, &situation);
        self.law.settle(dt_s, &allocation);
        self.commanded = allocation.achieved;
        self.predictor.push(allocation.achieved);
        let command = allocation.command;
        if !(command.throttle.is_finite() && command.steering.is_finite()) {
            return Err(HelmError::Output);
        }
        Ok(Output {
            command,
            diagnostics: Diagnostics {
                observed,
                reference,
                law: self.law.diagnostics(),
                surge_demand_n: demand.surge_n,
                yaw_demand_nm: demand.yaw_nm,
                water,
                ground_per_water: ground_per_water(state.surge_mps, motion.surge_mps),
                surge_saturated: allocation.surge_saturated,
                yaw_saturated: allocation.yaw_saturated,
            },
        })
    }

    /// Moves the sway model and the drift estimate; returns the motion through the water.
    fn observe_water(&mut self, dt_s: f64, state: &VesselState) -> WaterMotion {
        if !self.equipment.observes_water {
            return WaterMotion {
                surge_mps: state.surge_mps,
                sway_mps: state.sway_mps,
                yaw_rate_radps: state.yaw_rate_radps,
            };
        }
        let along = unit(state.heading_rad).dot(self.drift.current());
        let surge_mps = state.surge_mps - along;
        let rate = state.yaw_rate_radps;
        let sway_mps = self.sway.step(dt_s, &self.hull, surge_mps, rate, self.commanded.sway_n);
        self.balance.learn(dt_s, state, sway_mps);
        let sway_mps = (1.0 + self.balance.excess()) * sway_mps;
        self.drift.step(dt_s, state, sway_mps, self.drift_time_s);
        WaterMotion { surge_mps, sway_mps, yaw_rate_radps: rate }
    }
}

#[cfg(test)]
mod tests;
