//! What the user allows, and what the machine looks at.

use serde::{Deserialize, Serialize};

use super::state::Lack;
use crate::pilot::failsafe::{Failsafe, Trip};
use crate::vehicle::Mode;

/// Waiting times, in seconds of vehicle time. The limits of the failsafes are
/// [`FailsafeSettings`](crate::pilot::failsafe::FailsafeSettings).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
pub struct Limits {
    /// A position or heading older than this must not steer: the motors are neutral until a newer one comes.
    pub stale_s: f64,
    /// A flight controller whose heartbeat is older than this is gone.
    pub heartbeat_s: f64,
    /// How long a requested mode may take before the bridge gives up.
    pub mode_change_s: f64,
    /// How long the bridge waits for the motors to be armed when it was told to arm them.
    pub arming_s: f64,
}

impl Default for Limits {
    fn default() -> Self {
        let heartbeat_s = Failsafe::LinkLost.definition().limit;
        Self { stale_s: 1.0, heartbeat_s, mode_change_s: 3.0, arming_s: 30.0 }
    }
}

/// What the user allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Policy {
    /// The mode in which the chosen output is obeyed.
    pub drive_mode: Mode,
    /// Engage when the pilot changes into this mode.
    pub engage_mode: Option<Mode>,
    /// Arm the motors when engaging; never otherwise.
    pub may_arm: bool,
    /// The mode to leave the boat in when the mission is complete.
    pub end_mode: Mode,
    /// Compute only; never engage.
    pub shadow: bool,
    /// Waiting times.
    pub limits: Limits,
}

/// Everything the machine looks at, at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Age of the last heartbeat, seconds; infinite before the first.
    pub heartbeat_age_s: f64,
    /// Position and heading are fresh, and the flight controller's estimator vouches for them.
    pub steady: bool,
    /// The mode of the last heartbeat.
    pub mode: Option<Mode>,
    /// The motors may turn.
    pub armed: bool,
    /// The flight controller has restarted since the last look.
    pub rebooted: bool,
    /// There is a mission that can be driven.
    pub mission_there: bool,
    /// It is known to be the newest one.
    pub mission_current: bool,
    /// The vehicle's parameters have been read, and the output can be used with them.
    pub output_ready: bool,
    /// The last waypoint has been reached.
    pub mission_complete: bool,
    /// A limit that has been passed and calls for an end of the drive.
    pub trip: Option<Trip>,
}

impl Conditions {
    /// What is missing for a drive to begin.
    pub(super) fn lack(&self, limits: &Limits) -> Option<Lack> {
        if self.heartbeat_age_s > limits.heartbeat_s {
            Some(Lack::Vehicle)
        } else if !self.output_ready {
            Some(Lack::Parameters)
        } else if !(self.mission_there && self.mission_current) {
            Some(Lack::Mission)
        } else {
            (!self.steady).then_some(Lack::Position)
        }
    }

    /// The same for a machine that is ready already: a short gap in the position does not change that.
    pub(super) fn lasting_lack(&self, limits: &Limits) -> Option<Lack> {
        self.lack(limits).filter(|lack| *lack != Lack::Position || self.trip.is_some())
    }
}
