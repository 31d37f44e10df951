//! Scenarios: put on, looked at, ended.

use super::{PlayError, Sitl};
use crate::scenario::{Play, Scenario, Verdict};

impl Sitl {
    /// Puts a scenario on; its clock starts with the next loop, or with arming. An earlier one is over.
    ///
    /// # Errors
    /// [`PlayError`] if the boat lacks the part that is to fail, or a parameter is not known.
    pub fn play(&mut self, scenario: Scenario) -> Result<(), PlayError> {
        for fault in scenario.faults() {
            self.check_fault(fault)?;
        }
        if let Some(name) = scenario.parameters().find(|name| !self.autopilot.has_parameter(name)) {
            return Err(PlayError::NoSuchParameter(name.to_owned()));
        }
        self.play = Some(Box::new(Play::new(scenario)));
        Ok(())
    }

    /// What has become of the scenario's expectations; none without a scenario.
    pub fn verdicts(&self) -> &[Verdict] {
        self.play.as_ref().map_or(&[], |play| play.verdicts())
    }

    /// Whether the scenario is over; false without one.
    pub fn is_scenario_over(&self) -> bool {
        self.play.as_ref().is_some_and(|play| play.is_over())
    }

    /// Ends the scenario now: what is open is decided by how things stand.
    pub fn end_scenario(&mut self) {
        if let Some(mut play) = self.play.take() {
            play.end(self);
            self.play = Some(play);
        }
    }
}
