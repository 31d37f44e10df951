//! What fails, and what the sea does, at once or at a time to come.

use super::Sitl;
use crate::faults::{Fault, FaultError, TimedFault, Turn};
use crate::physics::Sea;
use crate::physics::sea::{Current, Wind};

impl Sitl {
    /// Makes something fail from the next loop on, in place of an earlier fault of the same kind.
    ///
    /// # Errors
    /// [`FaultError`] if a figure is out of its range, or the boat has no such part.
    pub fn inject(&mut self, fault: Fault) -> Result<(), FaultError> {
        self.check_fault(&fault)?;
        self.autopilot.put_fault(&fault);
        Ok(())
    }

    /// Repairs what a fault of this kind has done; its figures do not matter.
    pub fn lift(&mut self, fault: &Fault) {
        self.autopilot.lift_fault(fault);
    }

    /// Makes something fail at a time to come, and repairs it if the fault has an end.
    ///
    /// # Errors
    /// As [`Sitl::inject`].
    pub fn schedule(&mut self, timed: TimedFault) -> Result<(), FaultError> {
        self.check_fault(&timed.fault)?;
        self.schedule.add(timed);
        Ok(())
    }

    pub(super) fn check_fault(&self, fault: &Fault) -> Result<(), FaultError> {
        fault.check()?;
        match fault.missing_part(self.hull().has_twin_thrusters()) {
            None => Ok(()),
            Some(part) => {
                let boat = self.hull().name.clone();
                Err(FaultError::NoSuchPart { fault: fault.to_string(), boat, part })
            }
        }
    }

    /// The sea as it was asked for.
    pub fn sea(&self) -> &Sea {
        self.vessel.sea()
    }

    /// Changes the sea from now on.
    pub fn set_sea(&mut self, sea: Sea) {
        self.vessel.set_sea(&sea);
        self.autopilot.put_sea(&sea);
        self.sea_parameters = self.autopilot.sea_parameters();
    }

    /// Begins and ends scheduled faults, and puts into force what the parameters say.
    pub(super) fn turn_faults(&mut self) {
        while let Some(turn) = self.schedule.due(self.now) {
            match turn {
                Turn::Begin(fault) => self.autopilot.put_fault(&fault),
                Turn::End(fault) => self.autopilot.lift_fault(&fault),
            }
        }
        let revision = self.autopilot.parameter_revision();
        if self.faults_of != Some(revision) {
            self.faults_of = Some(revision);
            self.vessel.set_faults(self.autopilot.vessel_faults());
            self.vessel.set_gps_rate(self.autopilot.gps_rate_hz());
            self.weather = self.autopilot.link_weather();
            self.turn_sea();
        }
    }

    /// Tide and wind follow their parameters.
    fn turn_sea(&mut self) {
        let wanted = self.autopilot.sea_parameters();
        if wanted == self.sea_parameters {
            return;
        }
        self.sea_parameters = wanted;
        let [tide_mps, tide_from_deg, wind_mps, wind_from_deg] = wanted;
        let mut sea = *self.vessel.sea();
        let current = sea.current.unwrap_or(Current { speed_mps: 0.0, toward_deg: 0.0, variability: 0.0 });
        let wind = sea.wind.unwrap_or(Wind { speed_mps: 0.0, from_deg: 0.0, gustiness: 0.0 });
        let toward_deg = (tide_from_deg + 180.0).rem_euclid(360.0);
        sea.current = (tide_mps > 0.0).then_some(Current { speed_mps: tide_mps, toward_deg, ..current });
        sea.wind = (wind_mps > 0.0).then_some(Wind { speed_mps: wind_mps, from_deg: wind_from_deg, ..wind });
        self.vessel.set_sea(&sea);
    }
}
