//! ArduRover's flight modes, by number and by name.

use std::fmt;
use std::str::FromStr;

use helmlink_wire::enums;
use serde::{Deserialize, Serialize};

/// A flight mode of ArduRover: `custom_mode` of its HEARTBEAT.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
pub struct Mode(pub u32);

impl Mode {
    /// Throttle and rudder straight from the (overridden) radio channels.
    pub const MANUAL: Self = Self(enums::ROVER_MODE_MANUAL);
    /// Motors stopped.
    pub const HOLD: Self = Self(enums::ROVER_MODE_HOLD);
    /// Holds its position; a boat uses its motors for that.
    pub const LOITER: Self = Self(enums::ROVER_MODE_LOITER);
    /// The firmware's own mission mode.
    pub const AUTO: Self = Self(enums::ROVER_MODE_AUTO);
    /// Returns to where it was armed.
    pub const RTL: Self = Self(enums::ROVER_MODE_RTL);
    /// Follows setpoints that a companion sends.
    pub const GUIDED: Self = Self(enums::ROVER_MODE_GUIDED);
    /// Starting up: the firmware was switched on a moment ago.
    pub const INITIALISING: Self = Self(enums::ROVER_MODE_INITIALIZING);
}

/// Mode numbers with the names that ground stations use for them.
const NAMES: [(u32, &str); 15] = [
    (enums::ROVER_MODE_MANUAL, "MANUAL"),
    (enums::ROVER_MODE_ACRO, "ACRO"),
    (enums::ROVER_MODE_STEERING, "STEERING"),
    (enums::ROVER_MODE_HOLD, "HOLD"),
    (enums::ROVER_MODE_LOITER, "LOITER"),
    (enums::ROVER_MODE_FOLLOW, "FOLLOW"),
    (enums::ROVER_MODE_SIMPLE, "SIMPLE"),
    (enums::ROVER_MODE_DOCK, "DOCK"),
    (enums::ROVER_MODE_CIRCLE, "CIRCLE"),
    (enums::ROVER_MODE_AUTO, "AUTO"),
    (enums::ROVER_MODE_RTL, "RTL"),
    (enums::ROVER_MODE_SMART_RTL, "SMART_RTL"),
    (enums::ROVER_MODE_GUIDED, "GUIDED"),
    (enums::ROVER_MODE_INITIALIZING, "INITIALISING"),
    (enums::ROVER_MODE_INITIALIZING, "INITIALIZING"),
];

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match NAMES.iter().find(|(number, _)| *number == self.0) {
            Some((_, name)) => f.write_str(name),
            None => write!(f, "mode {}", self.0),
        }
    }
}

/// A mode name that ArduRover does not have.
#[derive(Debug, thiserror::Error)]
#[error("`{0}` is not a mode of ArduRover: use MANUAL, HOLD, LOITER, AUTO, GUIDED, RTL or its number")]
pub struct UnknownMode(String);

impl FromStr for Mode {
    type Err = UnknownMode;

    fn from_str(text: &str) -> Result<Self, UnknownMode> {
        let named = NAMES.iter().find(|(_, name)| name.eq_ignore_ascii_case(text)).map(|(number, _)| *number);
        named.or_else(|| text.parse().ok()).map(Self).ok_or_else(|| UnknownMode(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_round_trip() {
        for (number, _) in NAMES {
            assert_eq!(Mode(number).to_string().parse::<Mode>().unwrap(), Mode(number));
        }
        assert_eq!("guided".parse::<Mode>().unwrap(), Mode::GUIDED);
        assert_eq!("15".parse::<Mode>().unwrap(), Mode::GUIDED);
        assert!("FLY".parse::<Mode>().unwrap_err().to_string().contains("FLY"));
    }
}
