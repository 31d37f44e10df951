//! Where the machine can be, and what it then has the bridge do.

use std::fmt;

/// Where the machine is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// No flight controller, no position, or no mission yet.
    Waiting(Lack),
    /// Everything is there, and the bridge only computes: it has been told to send nothing.
    Shadow,
    /// Everything is there; the bridge sends no command.
    Ready,
    /// Told to drive: the mode or the motors are being prepared.
    Engaging,
    /// Driving.
    Engaged,
    /// Motors neutral until the final mode is confirmed, then release.
    HandingBack,
    /// Paused, on request or by a failsafe; the place in the mission is kept.
    Holding,
    /// The mission is complete and the boat has been let go.
    Finished,
    /// Ended on request.
    Stopped,
}

/// What the machine is waiting for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lack {
    /// A heartbeat of a boat's flight controller.
    Vehicle,
    /// The vehicle's parameters.
    Parameters,
    /// A mission.
    Mission,
    /// A valid position and heading.
    Position,
}

/// What the bridge has to do now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Duty {
    /// Send no command at all.
    Nothing,
    /// Send what the controller wants.
    Drive,
    /// Send neutral.
    Neutral,
}

impl State {
    /// One word for programs: status output, metrics.
    pub fn name(self) -> &'static str {
        match self {
            Self::Waiting(Lack::Vehicle) => "waiting-for-link",
            Self::Waiting(Lack::Parameters) => "waiting-for-parameters",
            Self::Waiting(Lack::Mission) => "waiting-for-mission",
            Self::Waiting(Lack::Position) => "waiting-for-position",
            Self::Shadow => "shadow",
            Self::Ready => "ready",
            Self::Engaging => "engaging",
            Self::Engaged => "engaged",
            Self::HandingBack => "handing-back",
            Self::Holding => "holding",
            Self::Finished => "finished",
            Self::Stopped => "stopped",
        }
    }

    /// Every state there is.
    pub const ALL: [Self; 12] = [
        Self::Waiting(Lack::Vehicle),
        Self::Waiting(Lack::Parameters),
        Self::Waiting(Lack::Mission),
        Self::Waiting(Lack::Position),
        Self::Shadow,
        Self::Ready,
        Self::Engaging,
        Self::Engaged,
        Self::HandingBack,
        Self::Holding,
        Self::Finished,
        Self::Stopped,
    ];
}

impl fmt::Display for Lack {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Vehicle => "waiting for a flight controller's heartbeat",
            Self::Parameters => "reading the flight controller's parameters",
            Self::Mission => "waiting for a mission",
            Self::Position => "waiting for a valid position and heading",
        })
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waiting(lack) => lack.fmt(f),
            Self::Shadow => f.write_str("shadow: computing, sending nothing"),
            Self::Ready => f.write_str("ready, not driving"),
            Self::Engaging => f.write_str("engaging"),
            Self::Engaged => f.write_str("driving the mission"),
            Self::HandingBack => f.write_str("stopping the boat"),
            Self::Holding => f.write_str("paused"),
            Self::Finished => f.write_str("mission complete"),
            Self::Stopped => f.write_str("stopped"),
        }
    }
}
