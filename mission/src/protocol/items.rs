//! Plan items on their way: the two messages that carry one, and home as item 0 of an ArduPilot mission.

use helmlink_wire::dialect::Message;

use crate::geodesy::Geodetic;
use crate::plan::Item;

/// An item as it arrived, in either MISSION_ITEM_INT or MISSION_ITEM.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Received {
    pub(super) target_system: u8,
    pub(super) target_component: u8,
    pub(super) seq: u16,
    /// MAV_MISSION_TYPE.
    pub(super) mission_type: u8,
    /// 0 or 1 in a plan; 2 and 3 mark the old way to send a single guided target or altitude.
    pub(super) current: u8,
    pub(super) item: Item,
}

impl Received {
    /// Reads either message; `None` for any other.
    ///
    /// A float coordinate that is not a number becomes `i32::MAX`, which passes for no latitude or longitude.
    pub(super) fn from_message(message: &Message) -> Option<Self> {
        match message {
            Message::MISSION_ITEM_INT(m) => Some(Self {
                target_system: m.target_system,
                target_component: m.target_component,
                seq: m.seq,
                mission_type: m.mission_type,
                current: m.current,
                item: Item::from_int_message(m),
            }),
            Message::MISSION_ITEM(m) => {
                let mut item = Item::from_float_message(m);
                if m.x.is_nan() {
                    item.x = i32::MAX;
                }
                if m.y.is_nan() {
                    item.y = i32::MAX;
                }
                Some(Self {
                    target_system: m.target_system,
                    target_component: m.target_component,
                    seq: m.seq,
                    mission_type: m.mission_type,
                    current: m.current,
                    item,
                })
            }
            _ => None,
        }
    }
}

/// Home out of item 0 of an ArduPilot mission; `None` at 0/0.
pub(super) fn home_of_item(item: &Item) -> Option<Geodetic> {
    (item.x != 0 || item.y != 0).then(|| Geodetic::from_e7(item.x, item.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use helmlink_wire::dialect::MISSION_ITEM_DATA;

    #[test]
    fn a_coordinate_that_is_no_number_is_out_of_every_range() {
        let message = MISSION_ITEM_DATA { x: f32::NAN, y: 1.5, ..MISSION_ITEM_DATA::DEFAULT };
        let received = Received::from_message(&Message::MISSION_ITEM(message)).unwrap();
        assert_eq!((received.item.x, received.item.y), (i32::MAX, 15_000_000));
    }

    #[test]
    fn home_at_nought_is_no_home() {
        assert_eq!(home_of_item(&Item::home(None)), None);
        let harbour = Geodetic::from_e7(599_000_000, 107_000_000);
        assert_eq!(home_of_item(&Item::home(Some(harbour))), Some(harbour));
    }
}
