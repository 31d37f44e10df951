//! Which items an ArduRover takes (4.6, measured), and how it keeps them.

use helmlink_wire::enums::*;

use crate::geodesy::Geodetic;
use crate::plan::Item;
use crate::protocol::MissionType;

/// Judges one item of a plan: `Err` holds the MAV_MISSION_RESULT to refuse it with.
pub type ItemRule = fn(&Item, MissionType) -> Result<(), u8>;

/// Largest latitude of a plan, 1e-7 degrees.
const LATITUDE_LIMIT_E7: i32 = 900_000_000;
/// Largest longitude of a plan, 1e-7 degrees.
const LONGITUDE_LIMIT_E7: i32 = 1_800_000_000;
/// Corners a fence polygon needs.
const LEAST_CORNERS: usize = 3;

/// Mission commands ArduRover stores. That it stores one is no promise to carry it out.
const MISSION_COMMANDS: &[u16] = &[
    MAV_CMD_NAV_WAYPOINT,
    MAV_CMD_NAV_LOITER_UNLIM,
    MAV_CMD_NAV_LOITER_TURNS,
    MAV_CMD_NAV_LOITER_TIME,
    MAV_CMD_NAV_RETURN_TO_LAUNCH,
    MAV_CMD_NAV_LAND,
    MAV_CMD_NAV_TAKEOFF,
    MAV_CMD_NAV_SPLINE_WAYPOINT,
    MAV_CMD_NAV_ALTITUDE_WAIT,
    MAV_CMD_NAV_VTOL_TAKEOFF,
    MAV_CMD_NAV_GUIDED_ENABLE,
    MAV_CMD_NAV_DELAY,
    MAV_CMD_NAV_PAYLOAD_PLACE,
    MAV_CMD_CONDITION_DELAY,
    MAV_CMD_CONDITION_DISTANCE,
    MAV_CMD_CONDITION_YAW,
    MAV_CMD_DO_JUMP,
    MAV_CMD_DO_CHANGE_SPEED,
    MAV_CMD_DO_SET_HOME,
    MAV_CMD_DO_SET_RELAY,
    MAV_CMD_DO_SET_SERVO,
    MAV_CMD_DO_RETURN_PATH_START,
    MAV_CMD_DO_LAND_START,
    MAV_CMD_DO_SET_ROI,
    MAV_CMD_DO_DIGICAM_CONTROL,
    MAV_CMD_DO_SET_CAM_TRIGG_DIST,
    MAV_CMD_DO_GRIPPER,
    MAV_CMD_NAV_SET_YAW_SPEED,
    MAV_CMD_DO_SPRAYER,
    MAV_CMD_DO_GUIDED_LIMITS,
    MAV_CMD_DO_ENGINE_CONTROL,
    MAV_CMD_JUMP_TAG,
    MAV_CMD_IMAGE_START_CAPTURE,
    MAV_CMD_DO_WINCH,
];

/// The rule of ArduRover 4.6.
///
/// # Errors
/// The MAV_MISSION_RESULT it answers with, as measured.
pub fn ardurover(item: &Item, mission_type: MissionType) -> Result<(), u8> {
    if !is_known(item.command, mission_type) {
        return Err(MAV_MISSION_UNSUPPORTED);
    }
    if !item.has_global_frame() && item.frame != MAV_FRAME_MISSION {
        return Err(MAV_MISSION_UNSUPPORTED_FRAME);
    }
    for (parameter, refusal) in item.params.iter().zip([
        MAV_MISSION_INVALID_PARAM1,
        MAV_MISSION_INVALID_PARAM2,
        MAV_MISSION_INVALID_PARAM3,
    ]) {
        // Parameter 4, the heading at the point, may be NaN: "as you like".
        if !parameter.is_finite() {
            return Err(refusal);
        }
    }
    if item.has_global_frame() && item.x.unsigned_abs() > LATITUDE_LIMIT_E7.unsigned_abs() {
        return Err(MAV_MISSION_INVALID_PARAM5_X);
    }
    if item.has_global_frame() && item.y.unsigned_abs() > LONGITUDE_LIMIT_E7.unsigned_abs() {
        return Err(MAV_MISSION_INVALID_PARAM6_Y);
    }
    // In frame 2 nobody reads the altitude, and MAVSDK sends it as NaN there.
    if item.has_global_frame() && !item.z.is_finite() {
        return Err(MAV_MISSION_INVALID_PARAM7);
    }
    if item.command == MAV_CMD_DO_JUMP && item.params[0] < 1.0 {
        return Err(MAV_MISSION_ERROR);
    }
    Ok(())
}

fn is_known(command: u16, mission_type: MissionType) -> bool {
    match mission_type {
        MissionType::Mission => MISSION_COMMANDS.contains(&command),
        MissionType::Fence => {
            (MAV_CMD_NAV_FENCE_RETURN_POINT..=MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION).contains(&command)
        }
        MissionType::Rally => command == MAV_CMD_NAV_RALLY_POINT,
    }
}

/// Whether the polygons of a fence are whole: each corner names the number of corners of its polygon in
/// parameter 1, and that many of its kind follow one another.
pub(super) fn polygons_are_whole(fence: &[Item]) -> bool {
    let is_corner = |item: &Item| {
        matches!(
            item.command,
            MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION | MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION
        )
    };
    let mut rest = fence;
    while let Some(first) = rest.first() {
        let size = if is_corner(first) { first.params[0] as usize } else { 1 };
        let (true, Some(group)) = (!is_corner(first) || size >= LEAST_CORNERS, rest.get(..size)) else {
            return false;
        };
        if group.iter().any(|item| item.command != first.command || item.params[0] != first.params[0]) {
            return false;
        }
        rest = &rest[size..];
    }
    true
}

/// The item as ArduRover reads it back: the frames whose names end in INT are kept as their older twins,
/// which mean the same.
pub(super) fn normalised(mut item: Item) -> Item {
    item.frame = match item.frame {
        MAV_FRAME_GLOBAL_INT => MAV_FRAME_GLOBAL,
        MAV_FRAME_GLOBAL_RELATIVE_ALT_INT => MAV_FRAME_GLOBAL_RELATIVE_ALT,
        MAV_FRAME_GLOBAL_TERRAIN_ALT_INT => MAV_FRAME_GLOBAL_TERRAIN_ALT,
        other => other,
    };
    item
}

/// Home as the vehicle knows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Home {
    pub(super) position: Geodetic,
    pub(super) altitude_m: f32,
}
