//! How two lists of items differ, as far as it matters to a boat.

use helmlink_wire::enums::*;

use super::item::is_global;
use super::{CommandName, Item};

/// Altitudes closer than this are the same: flight controllers store centimetres.
const ALTITUDE_M: f32 = 0.011;
/// Parameters are the same within this part of themselves: flight controllers store some as small integers.
const PARAMETER_PART: f32 = 1e-3;

/// A difference between two missions.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Number of the item, from 1.
    pub item: usize,
    /// What is different, in words.
    pub text: String,
    /// It changes what a boat does; otherwise one side only keeps less.
    pub matters: bool,
}

/// The differences between the items of one mission and of `other`, in order.
///
/// Frames that mean the same, NaN and 0, and what an ArduPilot boat does not store of a waypoint (its parameters
/// 2 to 4) do not matter.
pub fn differences(one: &[Item], other: &[Item]) -> Vec<Difference> {
    let mut differences = Vec::new();
    for index in 0..one.len().max(other.len()) {
        let item = index + 1;
        let difference = |text: String, matters: bool| Difference { item, text, matters };
        match (one.get(index), other.get(index)) {
            (Some(left), Some(right)) => compare(left, right, &mut |text, matters| {
                differences.push(difference(text, matters));
            }),
            (Some(left), None) => {
                differences
                    .push(difference(format!("{} is only in the first", CommandName(left.command)), true));
            }
            (None, Some(right)) => {
                differences
                    .push(difference(format!("{} is only in the second", CommandName(right.command)), true));
            }
            (None, None) => {}
        }
    }
    differences
}

fn compare(one: &Item, other: &Item, say: &mut impl FnMut(String, bool)) {
    if one.command != other.command {
        return say(format!("{} became {}", CommandName(one.command), CommandName(other.command)), true);
    }
    match (one.position(), other.position()) {
        (Some(left), Some(right)) => {
            if (one.x, one.y) != (other.x, other.y) {
                say(format!("it moved by {:.2} m, to {right}", left.distance_m(right)), true);
            }
            if datum(one.frame) != datum(other.frame) {
                say(format!("frame {} became {}", one.frame, other.frame), false);
            }
            let (left_m, right_m) = (tidy(one.z), tidy(other.z));
            if (left_m - right_m).abs() > ALTITUDE_M {
                say(format!("altitude {left_m} m became {right_m} m"), false);
            }
        }
        (None, None) => {}
        (left, _) => say(
            format!("its position is only in the {}", if left.is_some() { "first" } else { "second" }),
            true,
        ),
    }
    for (number, (left, right)) in (1..).zip(one.params.iter().zip(&other.params)) {
        let (left, right) = (tidy(*left), tidy(*right));
        if (left - right).abs() > PARAMETER_PART * left.abs().max(right.abs()) {
            let matters = !(one.command == MAV_CMD_NAV_WAYPOINT && number > 1);
            say(
                format!("parameter {number} of {}: {left} became {right}", CommandName(one.command)),
                matters,
            );
        }
    }
}

/// One line an item with everything in it that matters to a boat: the same for missions without a difference
/// that matters, whatever else a flight controller has made of them. For checksums.
pub fn canonical(items: &[Item]) -> String {
    let mut text = String::new();
    for item in items {
        let kept = if item.command == MAV_CMD_NAV_WAYPOINT { 1 } else { 4 };
        let params: Vec<String> =
            item.params[..kept].iter().map(|value| format!("{:.3}", tidy(*value))).collect();
        let [x, y] = if item.position().is_some() { [item.x, item.y] } else { [0, 0] };
        text.push_str(&format!("{} {} {x} {y}\n", item.command, params.join(" ")));
    }
    text
}

/// NaN leaves a parameter to the vehicle, which 0 does too wherever it matters; there is one zero.
fn tidy(value: f32) -> f32 {
    if value.is_nan() || value == 0.0 { 0.0 } else { value }
}

/// What an altitude is measured from: frames that mean the same give the same number.
fn datum(frame: u8) -> u8 {
    match frame {
        MAV_FRAME_GLOBAL_INT => MAV_FRAME_GLOBAL,
        MAV_FRAME_GLOBAL_RELATIVE_ALT_INT => MAV_FRAME_GLOBAL_RELATIVE_ALT,
        MAV_FRAME_GLOBAL_TERRAIN_ALT_INT => MAV_FRAME_GLOBAL_TERRAIN_ALT,
        other if is_global(other) => other,
        _ => MAV_FRAME_MISSION,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy::Geodetic;

    fn waypoint() -> Item {
        Item { params: [5.0, 2.0, 0.0, f32::NAN], z: 1.0, ..Item::waypoint(Geodetic::new(59.9, 10.7)) }
    }

    #[test]
    fn what_a_flight_controller_makes_of_a_mission_does_not_matter() {
        let stored = Item {
            params: [5.0, 0.0, 0.0, 0.0],
            frame: MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
            z: 1.005,
            autocontinue: false,
            ..waypoint()
        };
        let found = differences(&[waypoint()], &[stored]);
        assert_eq!(found.len(), 1);
        assert!(!found[0].matters && found[0].text.contains("parameter 2"), "{found:?}");
        assert_eq!(canonical(&[waypoint()]), canonical(&[stored]));
    }

    #[test]
    fn what_changes_the_voyage_does() {
        let matters = |one: &[Item], other: &[Item]| {
            let found = differences(one, other);
            assert!(found.iter().any(|difference| difference.matters), "{found:?}");
            assert_ne!(canonical(one), canonical(other));
        };
        let item = waypoint();
        matters(&[item], &[Item { x: item.x + 1, ..item }]);
        matters(&[item], &[Item { params: [6.0, 2.0, 0.0, 0.0], ..item }]);
        matters(&[item], &[Item { command: MAV_CMD_NAV_LOITER_TURNS, ..item }]);
        matters(&[item], &[item, item]);
        matters(&[item], &[Item { frame: MAV_FRAME_MISSION, ..item }]);
        matters(&[Item::change_speed(1.0)], &[Item::change_speed(1.1)]);
        assert!(differences(&[item], &[item]).is_empty());
    }
}
