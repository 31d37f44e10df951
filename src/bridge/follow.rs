//! Keeps the flight controller's current mission item and the bridge's waypoint the same.
//!
//! The bridge steers in a mode in which the firmware does not advance its mission, so it tells the firmware
//! which item is being driven; every ground station then shows the right one. A change that the bridge did not
//! make is a ground station's MISSION_SET_CURRENT, and is followed.

use std::time::Duration;

use helmlink_wire::dialect::MISSION_SET_CURRENT_DATA;
use helmlink_wire::{Identity, Message};

/// How long an answer to MISSION_SET_CURRENT may take before it is sent again.
const TIMEOUT: Duration = Duration::from_secs(1);
/// How often it is sent before the bridge goes on without.
const ATTEMPTS: u32 = 4;

/// One side's view of the current item.
#[derive(Debug, Clone, Default)]
pub(super) struct CurrentItem {
    seen: Option<u16>,
    wanted: Option<u16>,
    confirmed: bool,
    attempts: u32,
    last_sent: Option<Duration>,
}

impl CurrentItem {
    /// The bridge is under way to this item.
    pub(super) fn set(&mut self, item: u16) {
        if self.wanted != Some(item) {
            *self = Self { seen: self.seen, wanted: Some(item), ..Self::default() };
        }
    }

    /// The bridge is not driving: it only watches what others choose.
    pub(super) fn clear(&mut self) {
        *self = Self { seen: self.seen, ..Self::default() };
    }

    /// The flight controller says which item is current; returns it when somebody else has chosen it.
    pub(super) fn on_current(&mut self, item: u16) -> Option<u16> {
        let before = self.seen.replace(item);
        match self.wanted {
            Some(wanted) if item == wanted => {
                self.confirmed = true;
                None
            }
            Some(_) if self.confirmed => {
                self.wanted = Some(item);
                Some(item)
            }
            Some(_) => None,
            None => before.is_some_and(|before| before != item).then_some(item),
        }
    }

    /// The message that tells the flight controller, when it is due.
    pub(super) fn poll(&mut self, now: Duration, vehicle: Identity) -> Option<Message> {
        let waiting = self.last_sent.is_some_and(|then| now.saturating_sub(then) < TIMEOUT);
        let seq = self.wanted.filter(|_| !self.confirmed && !waiting && self.attempts < ATTEMPTS)?;
        self.attempts += 1;
        self.last_sent = Some(now);
        Some(Message::MISSION_SET_CURRENT(MISSION_SET_CURRENT_DATA {
            seq,
            target_system: vehicle.system,
            target_component: vehicle.component,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VEHICLE: Identity = Identity { system: 1, component: 1 };

    #[test]
    fn follows_others_but_not_its_own_echo() {
        let mut current = CurrentItem::default();
        current.set(2);
        assert!(current.poll(Duration::ZERO, VEHICLE).is_some());
        assert!(current.poll(Duration::ZERO, VEHICLE).is_none(), "an answer is awaited");
        assert_eq!(current.on_current(1), None, "not yet heard");
        assert_eq!(current.on_current(2), None, "its own");
        assert_eq!(current.on_current(5), Some(5), "somebody else's");
        assert_eq!(current.on_current(5), None);
    }

    #[test]
    fn a_choice_made_before_engaging_counts_but_what_is_found_does_not() {
        let mut current = CurrentItem::default();
        assert_eq!(current.on_current(7), None, "found so");
        assert_eq!(current.on_current(4), Some(4), "chosen");
    }

    #[test]
    fn does_not_ask_for_ever() {
        let mut current = CurrentItem::default();
        current.set(2);
        let sent =
            (0..100).filter(|&second| current.poll(Duration::from_secs(second), VEHICLE).is_some()).count();
        assert_eq!(sent, ATTEMPTS as usize);
    }
}
