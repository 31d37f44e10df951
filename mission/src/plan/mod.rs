//! Missions as a navigator writes them: items, and the files they are kept in.

mod item;

pub use item::Item;

use crate::geodesy::Geodetic;

/// A mission: what to do, in order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mission {
    /// Where the boat was launched, when the source says so.
    pub home: Option<Geodetic>,
    /// The items without home. On ArduPilot, where home is item 0, `items[0]` has sequence number 1.
    pub items: Vec<Item>,
}
