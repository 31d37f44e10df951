//! The names of mission commands, for people.

use helmlink_wire::enums::*;

/// What is known of a MAV_CMD: `MAV_CMD_NAV_LAND (21)`, or `command 9999` for one without a name here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CommandName(pub u16);

impl std::fmt::Display for CommandName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match name(self.0) {
            Some(name) => write!(f, "{name} ({})", self.0),
            None => write!(f, "command {}", self.0),
        }
    }
}

/// Whether a command makes no sense without a latitude and longitude of its own.
pub(super) fn needs_position(command: u16) -> bool {
    matches!(command, MAV_CMD_NAV_WAYPOINT | MAV_CMD_NAV_SPLINE_WAYPOINT)
}

macro_rules! names {
    ($($command:ident)*) => {
        /// MAVLink's name of a command met in missions.
        fn name(command: u16) -> Option<&'static str> {
            match command {
                $($command => Some(stringify!($command)),)*
                _ => None,
            }
        }
    };
}

names! {
    MAV_CMD_NAV_WAYPOINT
    MAV_CMD_NAV_LOITER_UNLIM
    MAV_CMD_NAV_LOITER_TURNS
    MAV_CMD_NAV_LOITER_TIME
    MAV_CMD_NAV_RETURN_TO_LAUNCH
    MAV_CMD_NAV_LAND
    MAV_CMD_NAV_TAKEOFF
    MAV_CMD_NAV_FOLLOW
    MAV_CMD_NAV_CONTINUE_AND_CHANGE_ALT
    MAV_CMD_NAV_LOITER_TO_ALT
    MAV_CMD_DO_FOLLOW
    MAV_CMD_DO_ORBIT
    MAV_CMD_DO_FIGURE_EIGHT
    MAV_CMD_NAV_ARC_WAYPOINT
    MAV_CMD_NAV_ROI
    MAV_CMD_NAV_SPLINE_WAYPOINT
    MAV_CMD_NAV_ALTITUDE_WAIT
    MAV_CMD_NAV_VTOL_TAKEOFF
    MAV_CMD_NAV_VTOL_LAND
    MAV_CMD_NAV_GUIDED_ENABLE
    MAV_CMD_NAV_DELAY
    MAV_CMD_NAV_PAYLOAD_PLACE
    MAV_CMD_CONDITION_DELAY
    MAV_CMD_CONDITION_CHANGE_ALT
    MAV_CMD_CONDITION_DISTANCE
    MAV_CMD_CONDITION_YAW
    MAV_CMD_CONDITION_GATE
    MAV_CMD_DO_SET_MODE
    MAV_CMD_DO_JUMP
    MAV_CMD_DO_CHANGE_SPEED
    MAV_CMD_DO_SET_HOME
    MAV_CMD_DO_SET_RELAY
    MAV_CMD_DO_REPEAT_RELAY
    MAV_CMD_DO_SET_SERVO
    MAV_CMD_DO_REPEAT_SERVO
    MAV_CMD_DO_FLIGHTTERMINATION
    MAV_CMD_DO_RETURN_PATH_START
    MAV_CMD_DO_LAND_START
    MAV_CMD_DO_GO_AROUND
    MAV_CMD_DO_REPOSITION
    MAV_CMD_DO_PAUSE_CONTINUE
    MAV_CMD_DO_SET_REVERSE
    MAV_CMD_DO_SET_ROI_LOCATION
    MAV_CMD_DO_SET_ROI_NONE
    MAV_CMD_DO_SET_ROI
    MAV_CMD_DO_DIGICAM_CONFIGURE
    MAV_CMD_DO_DIGICAM_CONTROL
    MAV_CMD_DO_MOUNT_CONTROL
    MAV_CMD_DO_SET_CAM_TRIGG_DIST
    MAV_CMD_DO_FENCE_ENABLE
    MAV_CMD_DO_GRIPPER
    MAV_CMD_DO_AUTOTUNE_ENABLE
    MAV_CMD_NAV_SET_YAW_SPEED
    MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL
    MAV_CMD_DO_SET_RESUME_REPEAT_DIST
    MAV_CMD_DO_SPRAYER
    MAV_CMD_DO_SEND_SCRIPT_MESSAGE
    MAV_CMD_DO_AUX_FUNCTION
    MAV_CMD_DO_GUIDED_LIMITS
    MAV_CMD_DO_ENGINE_CONTROL
    MAV_CMD_DO_SET_MISSION_CURRENT
    MAV_CMD_JUMP_TAG
    MAV_CMD_DO_JUMP_TAG
    MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW
    MAV_CMD_IMAGE_START_CAPTURE
    MAV_CMD_IMAGE_STOP_CAPTURE
    MAV_CMD_VIDEO_START_CAPTURE
    MAV_CMD_VIDEO_STOP_CAPTURE
    MAV_CMD_DO_VTOL_TRANSITION
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
    MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION
    MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION
    MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION
    MAV_CMD_NAV_RALLY_POINT
    MAV_CMD_DO_WINCH
    MAV_CMD_NAV_SCRIPT_TIME
    MAV_CMD_NAV_ATTITUDE_TIME
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_what_it_knows() {
        assert_eq!(CommandName(MAV_CMD_NAV_LAND).to_string(), "MAV_CMD_NAV_LAND (21)");
        assert_eq!(CommandName(9999).to_string(), "command 9999");
    }
}
