//! What happens to a boat that an ArduPilot drives: faults of its hull, and scenarios.
//!
//! Sensors, links and battery are ArduPilot's own, and so are its modes.

use std::time::Duration;

use super::{ArduPilotPhysics, Run};
use crate::faults::{Fault, FaultError, TimedFault, Turn};
use crate::physics::{Hull, Sea};
use crate::scenario::{Happening, Observation, Play, Scenario, Stage, Verdict};

/// Why something cannot happen to a boat behind a real ArduPilot.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotOfTheHull {
    /// The boat cannot have the fault.
    #[error(transparent)]
    Fault(#[from] FaultError),
    /// A fault of what ArduPilot simulates itself.
    #[error(
        "fault `{0}`: sensors, links and battery are ArduPilot's own here, and its SIM_ parameters make them fail; \
         rudder-stuck, rudder-weak, thruster-stuck and thruster-weak are the hull's"
    )]
    ArduPilots(String),
    /// Something in a scenario.
    #[error("the scenario {0}, and that is ArduPilot's own here: run it with `helmlink sitl` alone")]
    Scenario(String),
}

impl ArduPilotPhysics {
    /// Has something fail at given times, counted from the first packet.
    ///
    /// # Errors
    /// [`NotOfTheHull`] if it is no fault of rudder or thrusters, or the boat lacks them.
    pub fn schedule(&mut self, timed: TimedFault) -> Result<(), NotOfTheHull> {
        self.check_fault(&timed.fault)?;
        self.start.schedule.add(timed);
        self.run = self.start.clone();
        Ok(())
    }

    /// Puts a scenario on. Its clock starts with the first packet; where it waits for arming, with the first use of
    /// the throttle.
    ///
    /// # Errors
    /// [`NotOfTheHull`] if it gives orders to the autopilot or looks at it.
    pub fn play(&mut self, scenario: Scenario) -> Result<(), NotOfTheHull> {
        for fault in scenario.faults() {
            self.check_fault(fault)?;
        }
        if let Some(what) = scenario.of_the_autopilot() {
            return Err(NotOfTheHull::Scenario(what));
        }
        self.start.play = Some(Box::new(Play::new(scenario)));
        self.run = self.start.clone();
        Ok(())
    }

    /// What has become of the scenario's expectations; none without a scenario.
    pub fn verdicts(&self) -> &[Verdict] {
        self.run.play.as_ref().map_or(&[], |play| play.verdicts())
    }

    /// Whether the scenario is over; false without one.
    pub fn is_scenario_over(&self) -> bool {
        self.run.play.as_ref().is_some_and(|play| play.is_over())
    }

    /// Ends the scenario now: what is open is decided by how things stand.
    pub fn end_scenario(&mut self) {
        if let Some(mut play) = self.run.play.take() {
            play.end(&self.run);
            self.run.play = Some(play);
        }
    }

    fn check_fault(&self, fault: &Fault) -> Result<(), NotOfTheHull> {
        fault.check()?;
        let hull = self.run.vessel.hull();
        if let Some(part) = fault.missing_part(hull.has_twin_thrusters()) {
            let (fault, boat) = (fault.to_string(), hull.name.clone());
            return Err(FaultError::NoSuchPart { fault, boat, part }.into());
        }
        if fault.put_on_hull(&mut Default::default(), true) {
            return Ok(());
        }
        Err(NotOfTheHull::ArduPilots(fault.to_string()))
    }
}

impl Run {
    /// Begins and ends what is due.
    pub(super) fn turn(&mut self) {
        while let Some(turn) = self.schedule.due(self.now()) {
            match turn {
                Turn::Begin(fault) => self.put(&fault, true),
                Turn::End(fault) => self.put(&fault, false),
            }
        }
        if let Some(mut play) = self.play.take() {
            play.step(self);
            self.play = Some(play);
        }
    }

    fn put(&mut self, fault: &Fault, begins: bool) {
        let mut faults = *self.vessel.faults();
        fault.put_on_hull(&mut faults, begins);
        self.vessel.set_faults(faults);
    }
}

impl Stage for Run {
    fn now(&self) -> Duration {
        Duration::from_secs_f64(self.vessel.time_s())
    }

    fn is_armed(&self) -> bool {
        !self.moored
    }

    fn hull(&self) -> &Hull {
        self.vessel.hull()
    }

    fn sea(&self) -> &Sea {
        self.vessel.sea()
    }

    fn set_sea(&mut self, sea: Sea) {
        self.vessel.set_sea(&sea);
    }

    fn happen(&mut self, what: &Happening) {
        match what {
            Happening::Fail(fault) => self.put(fault, true),
            Happening::Repair(fault) => self.put(fault, false),
            // A scenario with anything else has been refused.
            _ => {}
        }
    }

    /// The truth; what only an autopilot knows has been refused.
    fn observe(&self) -> Observation {
        let hull = self.vessel.truth().hull;
        let (north_mps, east_mps) = hull.velocity_ned_mps();
        Observation {
            mode: 0,
            armed: self.is_armed(),
            has_position: true,
            mission_complete: false,
            mission_item: 0.0,
            north_m: hull.north_m,
            east_m: hull.east_m,
            distance_home_m: hull.north_m.hypot(hull.east_m),
            speed_mps: north_mps.hypot(east_mps),
            heading_deg: hull.psi_rad.to_degrees().rem_euclid(360.0),
            cross_track_m: 0.0,
            position_error_m: 0.0,
            battery_percent: 100.0,
        }
    }
}
