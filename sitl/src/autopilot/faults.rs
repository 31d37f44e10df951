//! Faults as parameters: the autopilot's parameters are where they are kept, so that every ground station
//! sees what is wrong and can change it.

use std::time::Duration;

use helmlink_mission::geodesy::{Geodetic, NorthEast};
use helmlink_wire::LinkId;

use super::Autopilot;
use super::parameters::*;
use crate::faults::{Fault, LinkWeather, Thrusters};
use crate::physics::faults::{ActuatorFault, GpsFaults, Stuck, VesselFaults};
use crate::physics::{NedVector, Sea};

/// SIM_RUD_STUCK: stuck where it is, or at SIM_RUD_AT.
const STUCK_WHERE_IT_IS: f32 = 1.0;
const STUCK_AT: f32 = 2.0;

/// What of the faults runs by the clock.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FaultClock {
    /// When the outage of SIM_LNK_OUTAGE ends.
    outage_until: Option<Duration>,
}

impl Autopilot {
    /// Puts a fault into the parameters.
    pub(crate) fn put_fault(&mut self, fault: &Fault) {
        for (param, value) in self.fault_parameters(fault) {
            self.parameters.put(param, value as f32);
        }
    }

    /// Puts the parameters of a kind of fault back to their defaults.
    pub(crate) fn lift_fault(&mut self, fault: &Fault) {
        for (param, _) in self.fault_parameters(fault) {
            self.parameters.reset(param);
        }
    }

    fn fault_parameters(&self, fault: &Fault) -> Vec<(Param, f64)> {
        match *fault {
            Fault::LinkLoss { share } => vec![(SIM_LNK_LOSS, 100.0 * share)],
            Fault::LinkDelay { delay_s, jitter_s } => {
                vec![(SIM_LNK_DELAY, 1000.0 * delay_s), (SIM_LNK_JITTER, 1000.0 * jitter_s)]
            }
            Fault::LinkDuplication { share } => vec![(SIM_LNK_DUP, 100.0 * share)],
            Fault::LinkReordering { share } => vec![(SIM_LNK_REORDER, 100.0 * share)],
            Fault::LinkCorruption { share } => vec![(SIM_LNK_CORRUPT, 100.0 * share)],
            Fault::GpsLoss => vec![(SIM_GPS_DISABLE, 1.0)],
            Fault::GpsFreeze => vec![(SIM_GPS_FREEZE, 1.0)],
            Fault::GpsJump { north_m, east_m } => {
                let origin = self.frame.origin();
                let place = self.frame.to_geodetic(NorthEast::new(north_m, east_m));
                vec![
                    (SIM_GPS_GLITCH_X, place.latitude_deg - origin.latitude_deg),
                    (SIM_GPS_GLITCH_Y, place.longitude_deg - origin.longitude_deg),
                ]
            }
            Fault::GpsDrift { north_mps, east_mps } => {
                vec![(SIM_GPS_DRIFT_N, north_mps), (SIM_GPS_DRIFT_E, east_mps)]
            }
            Fault::CompassOffset { offset_rad } => vec![(SIM_MAG_YAW, offset_rad.to_degrees())],
            Fault::RudderStuck { at: None } => vec![(SIM_RUD_STUCK, f64::from(STUCK_WHERE_IT_IS))],
            Fault::RudderStuck { at: Some(at) } => {
                vec![(SIM_RUD_STUCK, f64::from(STUCK_AT)), (SIM_RUD_AT, at)]
            }
            Fault::RudderWeak { share } => vec![(SIM_RUD_MUL, share)],
            Fault::ThrusterStuck { which } => vec![(SIM_ENG_STUCK, mask(which))],
            Fault::ThrusterWeak { which, share } => {
                vec![(SIM_ENGINE_FAIL, mask(which)), (SIM_ENGINE_MUL, share)]
            }
            Fault::LowBattery { percent } => vec![(SIM_BATT_LEFT, percent)],
            Fault::Reboot => vec![(SIM_REBOOT, 1.0)],
            Fault::EkfFailure => vec![(SIM_EKF_FAIL, 1.0)],
        }
    }

    /// Number that changes whenever a parameter does.
    pub(crate) fn parameter_revision(&self) -> u64 {
        self.parameters.revision()
    }

    /// Faults of sensors and actuators as the parameters have them.
    pub(crate) fn vessel_faults(&self) -> VesselFaults {
        let get = |param| self.parameters.get(param);
        let origin = self.frame.origin();
        let glitch = Geodetic::new(
            origin.latitude_deg + get(SIM_GPS_GLITCH_X),
            origin.longitude_deg + get(SIM_GPS_GLITCH_Y),
        );
        let jump = if glitch == origin { NorthEast::ZERO } else { self.frame.to_local(glitch) };
        let rudder_stuck = match self.parameters.int(SIM_RUD_STUCK) {
            0 => None,
            2 => Some(Stuck::At(get(SIM_RUD_AT))),
            _ => Some(Stuck::WhereItIs),
        };
        let thruster = |bit: i32| {
            let has = |param| self.parameters.int(param) & bit != 0;
            ActuatorFault {
                stuck: has(SIM_ENG_STUCK).then_some(Stuck::WhereItIs),
                share: if has(SIM_ENGINE_FAIL) { get(SIM_ENGINE_MUL) } else { 1.0 },
            }
        };
        VesselFaults {
            gps: GpsFaults {
                lost: self.parameters.int(SIM_GPS_DISABLE) != 0,
                frozen: self.parameters.int(SIM_GPS_FREEZE) != 0,
                jump_m: NedVector { north: jump.north_m, east: jump.east_m },
                drift_mps: NedVector { north: get(SIM_GPS_DRIFT_N), east: get(SIM_GPS_DRIFT_E) },
            },
            compass_offset_rad: get(SIM_MAG_YAW).to_radians(),
            rudder: ActuatorFault { stuck: rudder_stuck, share: get(SIM_RUD_MUL) },
            thrusters: [thruster(1), thruster(2)],
        }
    }

    /// Tide and wind as the parameters have them: speed, m/s, and the direction they come from, degrees.
    pub(crate) fn sea_parameters(&self) -> [f64; 4] {
        [SIM_TIDE_SPEED, SIM_TIDE_DIR, SIM_WIND_SPD, SIM_WIND_DIR].map(|param| self.parameters.get(param))
    }

    /// Puts tide and wind into the parameters.
    pub(crate) fn put_sea(&mut self, sea: &Sea) {
        let tide = sea.current.map_or((0.0, 0.0), |current| (current.speed_mps, current.toward_deg + 180.0));
        let wind = sea.wind.map_or((0.0, 180.0), |wind| (wind.speed_mps, wind.from_deg));
        let directions = (tide.1.rem_euclid(360.0), wind.1.rem_euclid(360.0));
        for (param, value) in [
            (SIM_TIDE_SPEED, tide.0),
            (SIM_TIDE_DIR, directions.0),
            (SIM_WIND_SPD, wind.0),
            (SIM_WIND_DIR, directions.1),
        ] {
            self.parameters.put(param, value as f32);
        }
    }

    /// Fixes per second of the GPS.
    pub(crate) fn gps_rate_hz(&self) -> f64 {
        self.parameters.get(SIM_GPS_HZ)
    }

    /// SIM_SPEEDUP: multiple of real time; 0 is as fast as it goes.
    pub(crate) fn speedup(&self) -> f64 {
        self.parameters.get(SIM_SPEEDUP)
    }

    pub(crate) fn put_speedup(&mut self, speedup: f64) {
        self.parameters.put(SIM_SPEEDUP, speedup as f32);
    }

    pub(crate) fn put_gps_rate(&mut self, rate_hz: f64) {
        self.parameters.put(SIM_GPS_HZ, rate_hz as f32);
    }

    /// What the lines do to frames.
    pub(crate) fn link_weather(&self) -> LinkWeather {
        let share = |param| self.parameters.get(param) / 100.0;
        let seconds = |param| self.parameters.get(param) / 1000.0;
        LinkWeather {
            loss: if self.faults.outage_until.is_some() { 1.0 } else { share(SIM_LNK_LOSS) },
            delay_s: seconds(SIM_LNK_DELAY),
            jitter_s: seconds(SIM_LNK_JITTER),
            duplication: share(SIM_LNK_DUP),
            reordering: share(SIM_LNK_REORDER),
            corruption: share(SIM_LNK_CORRUPT),
            only: u32::try_from(self.parameters.int(SIM_LNK_NUMBER)).ok().map(LinkId),
        }
    }

    /// Faults that are over once they have happened, and outages with an end.
    pub(super) fn take_passing_faults(&mut self) {
        if self.parameters.int(SIM_REBOOT) != 0 {
            self.parameters.reset(SIM_REBOOT);
            self.reboot();
        }
        let left_percent = self.parameters.get(SIM_BATT_LEFT);
        if left_percent >= 0.0 {
            self.parameters.reset(SIM_BATT_LEFT);
            self.battery.set_left(left_percent / 100.0, self.parameters.get(BATT_CAPACITY));
        }
        let outage_s = self.parameters.get(SIM_LNK_OUTAGE);
        match self.faults.outage_until {
            None if outage_s > 0.0 => {
                self.faults.outage_until = Some(self.now + Duration::from_secs_f64(outage_s));
                // Nobody can lift it meanwhile, so it ends by itself; the change puts the weather in force.
                self.parameters.touch();
            }
            Some(until) if self.now >= until => {
                self.faults.outage_until = None;
                self.parameters.reset(SIM_LNK_OUTAGE);
            }
            _ => {}
        }
    }

    /// Whether the estimator has been made to give up.
    pub(super) fn has_failed_estimator(&self) -> bool {
        self.parameters.int(SIM_EKF_FAIL) != 0
    }

    /// Every link.
    pub(crate) fn links(&self) -> Vec<LinkId> {
        self.links.ids()
    }

    /// The next packet for one link.
    pub(crate) fn poll_transmit_on(&mut self, link: LinkId) -> Option<Vec<u8>> {
        self.links.poll_on(link)
    }
}

/// Bits of the thrusters: 1 the left or only one, 2 the right one.
fn mask(which: Thrusters) -> f64 {
    match which {
        Thrusters::Left => 1.0,
        Thrusters::Right => 2.0,
        Thrusters::All => 3.0,
    }
}

#[cfg(test)]
mod tests;
