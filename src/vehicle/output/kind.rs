//! By which messages the boat is steered.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::vehicle::modes::Mode;

/// By which messages the boat is steered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputKind {
    /// RC_CHANNELS_OVERRIDE of the steering and the throttle channel, in MANUAL: the quickest and most exact path.
    RcOverride,
    /// MANUAL_CONTROL, in MANUAL.
    ManualControl,
    /// SET_ATTITUDE_TARGET with turn rate and speed, in GUIDED: the firmware's own loops drive the motors.
    Guided,
    /// SET_POSITION_TARGET_LOCAL_NED with velocity along the bow and turn rate, in GUIDED.
    GuidedVelocity,
}

impl OutputKind {
    /// Every output.
    pub const ALL: [Self; 4] = [Self::RcOverride, Self::ManualControl, Self::Guided, Self::GuidedVelocity];

    /// The name on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::RcOverride => "rc-override",
            Self::ManualControl => "manual-control",
            Self::Guided => "guided",
            Self::GuidedVelocity => "guided-velocity",
        }
    }

    /// The flight mode in which the firmware obeys these messages.
    pub fn mode(self) -> Mode {
        if self.uses_sticks() { Mode::MANUAL } else { Mode::GUIDED }
    }

    /// The messages stand for a radio's sticks.
    pub fn uses_sticks(self) -> bool {
        matches!(self, Self::RcOverride | Self::ManualControl)
    }

    /// The firmware obeys these messages only from the system id in its SYSID_MYGCS.
    pub fn needs_ground_station_id(self) -> bool {
        self.uses_sticks()
    }
}

impl fmt::Display for OutputKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A name that is none of the outputs.
#[derive(Debug, thiserror::Error)]
#[error("`{0}` is not an output: use rc-override, manual-control, guided or guided-velocity")]
pub struct UnknownOutput(String);

impl FromStr for OutputKind {
    type Err = UnknownOutput;

    fn from_str(text: &str) -> Result<Self, UnknownOutput> {
        let named = Self::ALL.into_iter().find(|kind| kind.as_str() == text);
        named.ok_or_else(|| UnknownOutput(text.to_owned()))
    }
}
