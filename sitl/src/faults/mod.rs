//! Faults on purpose: what can be made to fail, in words, and when.
//!
//! ```text
//!  text or code ─► Fault ─► parameters SIM_... ─► vessel, autopilot, links
//! ```
//!
//! The `SIM_` parameters are the one place where faults are kept, so a ground station sees and changes the
//! same faults that a test or a scenario injects.

mod line;
mod schedule;
mod text;

pub(crate) use line::{Lines, LinkWeather};
pub(crate) use schedule::{Schedule, Turn};
pub use schedule::{ScheduleError, TimedFault};
pub use text::FaultTextError;

use crate::physics::faults::{ActuatorFault, Stuck, VesselFaults};

/// Something that fails. Shares are in [0, 1].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// So many frames are lost, in both directions: 1 is a dead link.
    LinkLoss {
        /// Share of the frames.
        share: f64,
    },
    /// Every frame arrives late, in both directions.
    LinkDelay {
        /// By this much, s, at most 60.
        delay_s: f64,
        /// And by up to this much more at random, s, at most 60: frames overtake one another.
        jitter_s: f64,
    },
    /// So many frames arrive twice.
    LinkDuplication {
        /// Share of the frames.
        share: f64,
    },
    /// So many frames arrive after later ones.
    LinkReordering {
        /// Share of the frames.
        share: f64,
    },
    /// So many frames have a wrong byte.
    LinkCorruption {
        /// Share of the frames.
        share: f64,
    },
    /// The GPS has no fix.
    GpsLoss,
    /// The GPS repeats its last fix.
    GpsFreeze,
    /// The GPS is off by so much, m, at most 50 km.
    GpsJump {
        /// To the north.
        north_m: f64,
        /// To the east.
        east_m: f64,
    },
    /// The position of the GPS runs away, m/s, at most 100.
    GpsDrift {
        /// To the north.
        north_mps: f64,
        /// To the east.
        east_mps: f64,
    },
    /// The compass is off by so much, positive to starboard, rad, within ±π.
    CompassOffset {
        /// By this.
        offset_rad: f64,
    },
    /// The rudder (or outboard leg) no longer moves.
    RudderStuck {
        /// The command at which it is stuck, [−1, 1]; `None` where it is.
        at: Option<f64>,
    },
    /// The rudder moves only so far.
    RudderWeak {
        /// Share of the way.
        share: f64,
    },
    /// Thrusters keep the revolutions that they have.
    ThrusterStuck {
        /// Which ones.
        which: Thrusters,
    },
    /// Thrusters have only so much of their thrust: 0 is a dead engine.
    ThrusterWeak {
        /// Which ones.
        which: Thrusters,
        /// Share of the thrust that is left.
        share: f64,
    },
    /// The battery has so much left from now on, per cent of its capacity.
    LowBattery {
        /// What is left, 0 to 100.
        percent: f64,
    },
    /// The autopilot starts anew, armed or not. Over at once.
    Reboot,
    /// The estimator gives up: no position, no velocity.
    EkfFailure,
}

/// Which thrusters a fault concerns. A boat with a single propeller has only a left one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Thrusters {
    /// The left one, or the only one.
    Left,
    /// The right one.
    Right,
    /// All.
    All,
}

/// Why a fault cannot be injected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FaultError {
    /// A figure outside its range.
    #[error("fault `{fault}`: {what} must be {allowed}")]
    OutOfRange {
        /// The fault.
        fault: String,
        /// Which figure.
        what: &'static str,
        /// What it may be.
        allowed: &'static str,
    },
    /// The boat does not have the part that is to fail.
    #[error("fault `{fault}`: the boat {boat} has no {part}")]
    NoSuchPart {
        /// The fault.
        fault: String,
        /// The boat.
        boat: String,
        /// What it lacks.
        part: &'static str,
    },
}

impl Fault {
    /// Whether every figure is in its range.
    ///
    /// # Errors
    /// [`FaultError::OutOfRange`] with the first that is not.
    pub fn check(&self) -> Result<(), FaultError> {
        let within = |value: f64, range: std::ops::RangeInclusive<f64>, what, allowed| {
            if range.contains(&value) {
                return Ok(());
            }
            Err(FaultError::OutOfRange { fault: self.to_string(), what, allowed })
        };
        let share = |share: f64| within(share, 0.0..=1.0, "the share", "between 0 and 1");
        match *self {
            Self::LinkLoss { share: value }
            | Self::LinkDuplication { share: value }
            | Self::LinkReordering { share: value }
            | Self::LinkCorruption { share: value }
            | Self::RudderWeak { share: value }
            | Self::ThrusterWeak { share: value, .. } => share(value),
            Self::LinkDelay { delay_s, jitter_s } => {
                within(delay_s, 0.0..=60.0, "the delay", "between 0 and 60 s")?;
                within(jitter_s, 0.0..=60.0, "the jitter", "between 0 and 60 s")
            }
            Self::GpsJump { north_m, east_m } => {
                within(north_m.hypot(east_m), 0.0..=50_000.0, "the distance", "at most 50 km")
            }
            Self::GpsDrift { north_mps, east_mps } => {
                within(north_mps.hypot(east_mps), 0.0..=100.0, "the speed", "at most 100 m/s")
            }
            Self::CompassOffset { offset_rad } => {
                let range = -std::f64::consts::PI..=std::f64::consts::PI;
                within(offset_rad, range, "the angle", "between -180 and 180 degrees")
            }
            Self::RudderStuck { at: Some(at) } => within(at, -1.0..=1.0, "the position", "between -1 and 1"),
            Self::LowBattery { percent } => {
                within(percent, 0.0..=100.0, "the charge", "between 0 and 100 per cent")
            }
            Self::RudderStuck { at: None }
            | Self::ThrusterStuck { .. }
            | Self::GpsLoss
            | Self::GpsFreeze
            | Self::Reboot
            | Self::EkfFailure => Ok(()),
        }
    }

    /// Begins or ends the fault on the hull itself; false for one of sensors, links, battery or computer.
    pub(crate) fn put_on_hull(&self, faults: &mut VesselFaults, begins: bool) -> bool {
        let mut thrusters = |which: Thrusters, put: &dyn Fn(&mut ActuatorFault)| {
            let [left, right] = &mut faults.thrusters;
            match which {
                Thrusters::Left => put(left),
                Thrusters::Right => put(right),
                Thrusters::All => [left, right].into_iter().for_each(put),
            }
        };
        let stuck = |at: Option<f64>| begins.then_some(at.map_or(Stuck::WhereItIs, Stuck::At));
        let left_over = |share: f64| if begins { share } else { 1.0 };
        match *self {
            Self::RudderStuck { at } => faults.rudder.stuck = stuck(at),
            Self::RudderWeak { share } => faults.rudder.share = left_over(share),
            Self::ThrusterStuck { which } => thrusters(which, &|thruster| thruster.stuck = stuck(None)),
            Self::ThrusterWeak { which, share } => {
                thrusters(which, &|thruster| thruster.share = left_over(share));
            }
            _ => return false,
        }
        true
    }

    /// What of a boat with or without twin thrusters the fault needs and the boat lacks.
    pub(crate) fn missing_part(&self, has_twin_thrusters: bool) -> Option<&'static str> {
        match self {
            Self::RudderStuck { .. } | Self::RudderWeak { .. } if has_twin_thrusters => {
                Some("rudder: it steers with its thrusters")
            }
            Self::ThrusterStuck { which: Thrusters::Right }
            | Self::ThrusterWeak { which: Thrusters::Right, .. }
                if !has_twin_thrusters =>
            {
                Some("right thruster")
            }
            _ => None,
        }
    }
}
