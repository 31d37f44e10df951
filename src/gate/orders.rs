//! Which messages order somebody to do something.

use helmlink_wire::Frame;
use helmlink_wire::dialect::{
    COMMAND_INT_DATA, COMMAND_LONG_DATA, FILE_TRANSFER_PROTOCOL_DATA, MANUAL_CONTROL_DATA,
    MISSION_CLEAR_ALL_DATA, MISSION_COUNT_DATA, MISSION_SET_CURRENT_DATA, MISSION_WRITE_PARTIAL_LIST_DATA,
    MessageData, PARAM_SET_DATA, RC_CHANNELS_OVERRIDE_DATA, SERIAL_CONTROL_DATA, SET_ATTITUDE_TARGET_DATA,
    SET_GPS_GLOBAL_ORIGIN_DATA, SET_HOME_POSITION_DATA, SET_MODE_DATA, SET_POSITION_TARGET_GLOBAL_INT_DATA,
    SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use helmlink_wire::enums::MAV_COMP_ID_AUTOPILOT1;

/// Messages that change what a boat does or how it is set up. Questions are no orders, nor are answers.
const ORDERS: [u32; 17] = [
    COMMAND_INT_DATA::ID,
    COMMAND_LONG_DATA::ID,
    FILE_TRANSFER_PROTOCOL_DATA::ID,
    MANUAL_CONTROL_DATA::ID,
    MISSION_CLEAR_ALL_DATA::ID,
    MISSION_COUNT_DATA::ID,
    MISSION_SET_CURRENT_DATA::ID,
    MISSION_WRITE_PARTIAL_LIST_DATA::ID,
    PARAM_SET_DATA::ID,
    RC_CHANNELS_OVERRIDE_DATA::ID,
    SERIAL_CONTROL_DATA::ID,
    SET_ATTITUDE_TARGET_DATA::ID,
    SET_GPS_GLOBAL_ORIGIN_DATA::ID,
    SET_HOME_POSITION_DATA::ID,
    SET_MODE_DATA::ID,
    SET_POSITION_TARGET_GLOBAL_INT_DATA::ID,
    SET_POSITION_TARGET_LOCAL_NED_DATA::ID,
];

/// Of these, the ones that a flight controller sends as answers: how many items there are, pieces of files.
const ANSWERS: [u32; 2] = [FILE_TRANSFER_PROTOCOL_DATA::ID, MISSION_COUNT_DATA::ID];

/// Whether `frame` orders somebody to do something.
pub fn is_order(frame: &Frame<'_>) -> bool {
    let id = frame.message_id();
    let is_answer = frame.identity().component == MAV_COMP_ID_AUTOPILOT1 && ANSWERS.contains(&id);
    ORDERS.contains(&id) && !is_answer
}
