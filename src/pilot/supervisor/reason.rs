//! Why a state is left, for the log and the ground station.

use serde::{Deserialize, Serialize};

use std::fmt;

use super::state::{Lack, State};
use crate::pilot::failsafe::{Failsafe, Trip};
use crate::vehicle::Mode;

/// What somebody asks of the bridge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
pub enum Request {
    /// Drive the mission; waits for readiness and arming where `patient`.
    Engage {
        /// Keep the request until it can be carried out.
        patient: bool,
    },
    /// Stop the boat and keep the place in the mission.
    Pause,
    /// Stop the boat and let go; it can be engaged again.
    LetGo,
    /// Stop the boat, let go, and end for good.
    Stop,
}

/// Why a state was left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reason {
    /// Something that was missing is still missing, or is missing again.
    Lacking(Lack),
    /// Everything needed is there.
    AllThere,
    /// Everything needed is there, and the bridge was told to drive, but somebody else has to arm the boat.
    UntilArmed,
    /// A command, a mode or the user's flag said so.
    ToldTo,
    /// Mode and motors are as they must be.
    InControl,
    /// The mode was changed by somebody else.
    PilotTookOver(Mode),
    /// The motors were disarmed.
    Disarmed,
    /// The flight controller has restarted.
    Rebooted,
    /// The flight controller's heartbeat stopped.
    LinkLost,
    /// A limit was passed.
    Failsafe(Trip),
    /// The mission that is now on the flight controller cannot be driven.
    MissionGone,
    /// The mode was not changed in time.
    ModeRefused(Mode),
    /// The motors were not armed in time.
    ArmingRefused,
    /// The last waypoint was reached.
    MissionComplete,
    /// Asked to pause.
    Paused,
    /// Asked to stop.
    StopRequested,
    /// The boat has been let go.
    LetGo,
}

impl Reason {
    /// The failsafe that is behind it, if one is.
    pub fn failsafe(&self) -> Option<Failsafe> {
        match self {
            Self::PilotTookOver(_) => Some(Failsafe::ModeChanged),
            Self::Disarmed => Some(Failsafe::Disarmed),
            Self::Rebooted => Some(Failsafe::Rebooted),
            Self::LinkLost => Some(Failsafe::LinkLost),
            Self::Failsafe(trip) => Some(trip.failsafe),
            _ => None,
        }
    }
}

/// One change of state, for the log and the ground station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transition {
    /// The state that was left.
    pub from: State,
    /// The state that was entered.
    pub to: State,
    /// Why.
    pub reason: Reason,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lacking(lack) => lack.fmt(f),
            Self::AllThere => f.write_str("vehicle, mission and position are there"),
            Self::UntilArmed => f.write_str("drives as soon as the boat is armed: arm it, or allow --arm"),
            Self::ToldTo => f.write_str("told to engage"),
            Self::InControl => f.write_str("mode and motors are ready"),
            Self::PilotTookOver(mode) => write!(f, "the pilot took over ({mode})"),
            Self::Disarmed => f.write_str("the motors are disarmed"),
            Self::Rebooted => f.write_str("the flight controller has restarted"),
            Self::LinkLost => f.write_str("the flight controller's heartbeat stopped"),
            Self::Failsafe(trip) => write!(f, "{trip}: {}", trip.action),
            Self::MissionGone => f.write_str("the mission is gone or cannot be driven"),
            Self::ModeRefused(mode) => write!(f, "the flight controller did not change to {mode}"),
            Self::ArmingRefused => {
                f.write_str("the motors were not armed: see the flight controller's messages")
            }
            Self::MissionComplete => f.write_str("the last waypoint was reached"),
            Self::Paused => f.write_str("asked to pause"),
            Self::StopRequested => f.write_str("asked to stop"),
            Self::LetGo => f.write_str("the boat has been let go"),
        }
    }
}

impl Transition {
    /// The change as one line: where to, and why.
    pub fn describe(&self) -> String {
        match self.reason {
            Reason::Lacking(lack) => lack.to_string(),
            reason => format!("{}: {reason}", self.to),
        }
    }
}
