//! What the result of a mission operation (MAV_MISSION_RESULT) means, in words.

use helmlink_wire::enums::*;

/// A MAV_MISSION_RESULT as a vehicle reported it. Prints as its name, number and meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MissionResult(pub u8);

impl MissionResult {
    /// MAVLink's name without its prefix, such as `NO_SPACE`.
    pub fn name(self) -> &'static str {
        self.describe().0
    }

    /// One plain sentence without a full stop.
    pub fn meaning(self) -> &'static str {
        self.describe().1
    }

    fn describe(self) -> (&'static str, &'static str) {
        match self.0 {
            MAV_MISSION_ACCEPTED => ("ACCEPTED", "the plan was accepted"),
            MAV_MISSION_ERROR => ("ERROR", "the vehicle gave no reason"),
            MAV_MISSION_UNSUPPORTED_FRAME => {
                ("UNSUPPORTED_FRAME", "it does not know the coordinate frame of an item; use frame 3")
            }
            MAV_MISSION_UNSUPPORTED => ("UNSUPPORTED", "it does not know a command or the type of plan"),
            MAV_MISSION_NO_SPACE => ("NO_SPACE", "the plan has more items than it can store"),
            MAV_MISSION_INVALID => ("INVALID", "a parameter has an impossible value"),
            MAV_MISSION_INVALID_PARAM1 => {
                ("INVALID_PARAM1", "parameter 1 of an item has an impossible value")
            }
            MAV_MISSION_INVALID_PARAM2 => {
                ("INVALID_PARAM2", "parameter 2 of an item has an impossible value")
            }
            MAV_MISSION_INVALID_PARAM3 => {
                ("INVALID_PARAM3", "parameter 3 of an item has an impossible value")
            }
            MAV_MISSION_INVALID_PARAM4 => {
                ("INVALID_PARAM4", "parameter 4 of an item has an impossible value")
            }
            MAV_MISSION_INVALID_PARAM5_X => ("INVALID_PARAM5_X", "the latitude of an item is out of range"),
            MAV_MISSION_INVALID_PARAM6_Y => ("INVALID_PARAM6_Y", "the longitude of an item is out of range"),
            MAV_MISSION_INVALID_PARAM7 => ("INVALID_PARAM7", "the altitude of an item is not a number"),
            MAV_MISSION_INVALID_SEQUENCE => ("INVALID_SEQUENCE", "an item came out of order"),
            MAV_MISSION_DENIED => {
                ("DENIED", "it takes no plan now, perhaps from another ground station already; try again")
            }
            MAV_MISSION_OPERATION_CANCELLED => {
                ("OPERATION_CANCELLED", "the transfer was given up, usually because the link lost too much")
            }
            _ => ("unknown", "a result this program does not know"),
        }
    }
}

impl std::fmt::Display for MissionResult {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({}), {}", self.name(), self.0, self.meaning())
    }
}
