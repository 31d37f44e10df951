//! The plans a vehicle holds.

use super::rules::{Home, normalised};
use crate::plan::Item;
use crate::protocol::MissionType;

/// The three plans and home, which is item 0 of every mission.
#[derive(Debug, Clone, Default)]
pub(super) struct Store {
    /// Items by sequence number. Slot 0 of a mission holds whatever was sent there and is never read.
    slots: [Vec<Item>; 3],
    pub(super) home: Option<Home>,
}

impl Store {
    /// Items by sequence number, item 0 of a mission being a placeholder.
    pub(super) fn slots(&self, mission_type: MissionType) -> &[Item] {
        &self.slots[index(mission_type)]
    }

    /// Replaces a plan.
    pub(super) fn replace(&mut self, mission_type: MissionType, items: Vec<Item>) {
        self.slots[index(mission_type)] = items.into_iter().map(normalised).collect();
    }

    /// The plan without home.
    pub(super) fn items(&self, mission_type: MissionType) -> &[Item] {
        let slots = self.slots(mission_type);
        match mission_type {
            MissionType::Mission => slots.get(1..).unwrap_or_default(),
            MissionType::Fence | MissionType::Rally => slots,
        }
    }

    /// Item `seq` as it is read back.
    pub(super) fn read(&self, mission_type: MissionType, seq: u16) -> Option<Item> {
        let stored = *self.slots(mission_type).get(usize::from(seq))?;
        if mission_type == MissionType::Mission && seq == 0 {
            return Some(self.home_item());
        }
        Some(stored)
    }

    /// Number of items, home included. At most the server's capacity.
    pub(super) fn count(&self, mission_type: MissionType) -> u16 {
        u16::try_from(self.slots(mission_type).len()).unwrap_or(u16::MAX)
    }

    pub(super) fn home_item(&self) -> Item {
        let z = self.home.map_or(0.0, |home| home.altitude_m);
        Item { z, ..Item::home(self.home.map(|home| home.position)) }
    }
}

pub(super) fn index(mission_type: MissionType) -> usize {
    usize::from(mission_type.to_wire())
}
