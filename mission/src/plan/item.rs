//! One mission item, as MAVLink carries it.

use helmlink_wire::dialect::{MISSION_ITEM_DATA, MISSION_ITEM_INT_DATA};
use helmlink_wire::enums::*;
use serde::{Deserialize, Serialize};

use super::CommandName;
use super::command::needs_position;
use super::error::Fault;
use crate::geodesy::{Geodetic, PositionFault};

/// Scale of the coordinates of local frames in MISSION_ITEM_INT: tenths of a millimetre.
const LOCAL_SCALE: f64 = 1e4;
/// Scale of latitude and longitude in MISSION_ITEM_INT.
const GLOBAL_SCALE: f64 = 1e7;

/// A mission item with the fields and scaling of MISSION_ITEM_INT, less what belongs to its transfer.
///
/// Source: MAVLink common messages, MISSION_ITEM_INT (73).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
pub struct Item {
    /// MAV_CMD.
    pub command: u16,
    /// MAV_FRAME of `x`, `y` and `z`.
    pub frame: u8,
    /// Parameters 1 to 4 of the command; NaN where a parameter is left to the vehicle.
    pub params: [f32; 4],
    /// Latitude, degrees × 10⁷ in the global frames; metres × 10⁴ in local ones; parameter 5 as it is in
    /// MAV_FRAME_MISSION.
    pub x: i32,
    /// Longitude, in the manner of `x`.
    pub y: i32,
    /// Altitude in metres, parameter 7. A boat ignores it.
    pub z: f32,
    /// Whether the vehicle goes on to the next item by itself.
    pub autocontinue: bool,
}

impl Item {
    /// A waypoint (MAV_CMD_NAV_WAYPOINT) in the frame ground stations use, altitude zero above home.
    pub fn waypoint(position: Geodetic) -> Self {
        let (x, y) = position.to_e7();
        Self {
            command: MAV_CMD_NAV_WAYPOINT,
            frame: MAV_FRAME_GLOBAL_RELATIVE_ALT,
            params: [0.0; 4],
            x,
            y,
            z: 0.0,
            autocontinue: true,
        }
    }

    /// Home as ArduPilot keeps it, as item 0 of a mission: an absolute waypoint, zeroes while unknown.
    pub fn home(position: Option<Geodetic>) -> Self {
        Self { frame: MAV_FRAME_GLOBAL, ..Self::waypoint(position.unwrap_or_default()) }
    }

    /// Whether `x` and `y` are latitude and longitude.
    pub fn has_global_frame(&self) -> bool {
        is_global(self.frame)
    }

    /// The position the item holds: `None` when the frame is not global, or when the coordinates are zero
    /// (nothing given) or out of range.
    pub fn position(&self) -> Option<Geodetic> {
        let position = Geodetic::from_e7(self.x, self.y);
        (self.has_global_frame() && position.is_valid()).then_some(position)
    }

    /// The item of a MISSION_ITEM_INT message.
    pub fn from_int_message(message: &MISSION_ITEM_INT_DATA) -> Self {
        Self {
            command: message.command,
            frame: message.frame,
            params: [message.param1, message.param2, message.param3, message.param4],
            x: message.x,
            y: message.y,
            z: message.z,
            autocontinue: message.autocontinue != 0,
        }
    }

    /// The item of a MISSION_ITEM message, whose coordinates are floating-point degrees (good to about a
    /// metre) or metres. Coordinates that do not fit are clamped, NaN becomes 0.
    pub fn from_float_message(message: &MISSION_ITEM_DATA) -> Self {
        let to_integer = |value: f32| (f64::from(value) * coordinate_scale(message.frame)).round() as i32;
        Self {
            command: message.command,
            frame: message.frame,
            params: [message.param1, message.param2, message.param3, message.param4],
            x: to_integer(message.x),
            y: to_integer(message.y),
            z: message.z,
            autocontinue: message.autocontinue != 0,
        }
    }

    /// The MISSION_ITEM_INT message that carries this item as number `seq` of a plan of `mission_type`
    /// (MAV_MISSION_TYPE). `current` is 0.
    pub fn to_int_message(
        &self,
        seq: u16,
        target_system: u8,
        target_component: u8,
        mission_type: u8,
    ) -> MISSION_ITEM_INT_DATA {
        let [param1, param2, param3, param4] = self.params;
        MISSION_ITEM_INT_DATA {
            param1,
            param2,
            param3,
            param4,
            x: self.x,
            y: self.y,
            z: self.z,
            seq,
            command: self.command,
            target_system,
            target_component,
            frame: self.frame,
            current: 0,
            autocontinue: u8::from(self.autocontinue),
            mission_type,
        }
    }

    /// The MISSION_ITEM message that carries this item, for the parties that ask for floating-point items.
    pub fn to_float_message(
        &self,
        seq: u16,
        target_system: u8,
        target_component: u8,
        mission_type: u8,
    ) -> MISSION_ITEM_DATA {
        let [param1, param2, param3, param4] = self.params;
        let [x, y] = self.coordinates().map(|value| value as f32);
        MISSION_ITEM_DATA {
            param1,
            param2,
            param3,
            param4,
            x,
            y,
            z: self.z,
            seq,
            command: self.command,
            target_system,
            target_component,
            frame: self.frame,
            current: 0,
            autocontinue: u8::from(self.autocontinue),
            mission_type,
        }
    }

    /// Parameters 5 and 6 as files and MISSION_ITEM write them: degrees, metres, or plain numbers.
    pub fn coordinates(&self) -> [f64; 2] {
        let scale = coordinate_scale(self.frame);
        [f64::from(self.x) / scale, f64::from(self.y) / scale]
    }
}

/// `x` and `y` of an item whose parameters 5 and 6 a file gives as `coordinates`.
///
/// # Errors
/// A frame that no file of a boat's mission has, a coordinate that is no position or does not fit, a
/// waypoint without a position.
pub(super) fn check_and_scale(command: u16, frame: u8, coordinates: [f64; 2]) -> Result<[i32; 2], Fault> {
    if !is_global(frame) && frame != MAV_FRAME_MISSION {
        return Err(Fault::Frame(frame));
    }
    let [latitude_deg, longitude_deg] = coordinates;
    if needs_position(command) {
        if frame == MAV_FRAME_MISSION {
            return Err(Fault::NoFrame(CommandName(command)));
        }
        Geodetic { latitude_deg, longitude_deg }.check()?;
    }
    let scale = coordinate_scale(frame);
    let to_integer = |value: f64, fault: PositionFault| {
        let scaled = (value * scale).round();
        let fits = scaled >= f64::from(i32::MIN) && scaled <= f64::from(i32::MAX);
        if fits { Ok(scaled as i32) } else { Err(Fault::Position(fault)) }
    };
    Ok([
        to_integer(latitude_deg, PositionFault::Latitude(latitude_deg))?,
        to_integer(longitude_deg, PositionFault::Longitude(longitude_deg))?,
    ])
}

/// Whether a MAV_FRAME is one of latitude and longitude.
pub(super) fn is_global(frame: u8) -> bool {
    matches!(
        frame,
        MAV_FRAME_GLOBAL
            | MAV_FRAME_GLOBAL_RELATIVE_ALT
            | MAV_FRAME_GLOBAL_INT
            | MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
            | MAV_FRAME_GLOBAL_TERRAIN_ALT
            | MAV_FRAME_GLOBAL_TERRAIN_ALT_INT
    )
}

/// What one degree, metre or unit of parameters 5 and 6 is in `x` and `y` of a MAV_FRAME.
pub(super) fn coordinate_scale(frame: u8) -> f64 {
    if is_global(frame) {
        GLOBAL_SCALE
    } else if frame == MAV_FRAME_MISSION {
        1.0
    } else {
        LOCAL_SCALE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_item() -> impl Strategy<Value = Item> {
        (any::<u16>(), any::<u8>(), any::<[f32; 4]>(), any::<(i32, i32)>(), any::<f32>(), any::<bool>())
            .prop_map(|(command, frame, params, (x, y), z, autocontinue)| Item {
                command,
                frame,
                params,
                x,
                y,
                z,
                autocontinue,
            })
    }

    #[test]
    fn positions_only_where_there_is_one() {
        let here = Geodetic::new(43.535, -5.65);
        let item = Item::waypoint(here);
        assert!(item.position().is_some_and(|position| position.distance_m(here) < 0.01));
        assert_eq!(Item { x: 0, y: 0, ..item }.position(), None);
        assert_eq!(Item { x: 950_000_000, ..item }.position(), None);
        assert_eq!(Item { frame: MAV_FRAME_MISSION, ..item }.position(), None);
    }

    #[test]
    fn scales_follow_the_frame() {
        let item = Item { x: 12_345, y: -5, ..Item::waypoint(Geodetic::default()) };
        assert_eq!(Item { frame: MAV_FRAME_LOCAL_NED, ..item }.coordinates(), [1.2345, -0.0005]);
        assert_eq!(Item { frame: MAV_FRAME_MISSION, ..item }.coordinates(), [12_345.0, -5.0]);
        assert_eq!(item.coordinates(), [0.001_234_5, -5e-7]);
    }

    proptest! {
        #[test]
        fn through_the_integer_message_unchanged(item in any_item(), seq in any::<u16>()) {
            let message = item.to_int_message(seq, 1, 2, MAV_MISSION_TYPE_RALLY);
            prop_assert_eq!((message.seq, message.target_system, message.target_component), (seq, 1, 2));
            prop_assert_eq!(message.mission_type, MAV_MISSION_TYPE_RALLY);
            let back = Item::from_int_message(&message);
            prop_assert_eq!(back.params.map(f32::to_bits), item.params.map(f32::to_bits));
            prop_assert_eq!((back.x, back.y, back.z.to_bits()), (item.x, item.y, item.z.to_bits()));
            prop_assert_eq!((back.command, back.frame), (item.command, item.frame));
        }

        #[test]
        fn through_the_float_message_within_its_precision(item in any_item()) {
            let back = Item::from_float_message(&item.to_float_message(3, 1, 1, 0));
            for (after, before) in [(back.x, item.x), (back.y, item.y)] {
                let error = (f64::from(after) - f64::from(before)).abs();
                prop_assert!(error <= f64::from(before).abs() * 2f64.powi(-23) + 1.0);
            }
        }
    }
}
