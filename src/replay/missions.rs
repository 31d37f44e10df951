//! Missions out of the traffic of a log: uploads to the vehicle and downloads from it.

use helmlink_mission::plan::{Item, Mission};
use helmlink_mission::protocol::MissionType;
use helmlink_wire::{Identity, Message, enums};

/// A mission that was transferred while the log was made.
#[derive(Debug, Clone, PartialEq)]
pub struct Transferred {
    /// Time stamp of the end of the transfer, microseconds since 1970 UTC.
    pub time_us: u64,
    /// Who held it before.
    pub from: Identity,
    /// The mission; item 0, where ArduPilot keeps home, is its home.
    pub mission: Mission,
}

/// One transfer under way.
#[derive(Debug)]
struct Transfer {
    from: Identity,
    items: Vec<Option<Item>>,
}

/// Listens to the mission protocol on a link.
#[derive(Debug)]
pub struct MissionListener {
    vehicle_system: u8,
    kind: MissionType,
    transfers: Vec<Transfer>,
}

/// Transfers followed at the same time; whoever starts more is only making noise.
const MOST_TRANSFERS: usize = 16;

impl MissionListener {
    /// Listens to the missions of this vehicle.
    pub fn new(vehicle_system: u8) -> Self {
        Self::of(MissionType::Mission, vehicle_system)
    }

    /// Listens to the plans of one kind of this vehicle; a fence or rally points come as items without home.
    pub fn of(kind: MissionType, vehicle_system: u8) -> Self {
        Self { vehicle_system, kind, transfers: Vec::new() }
    }

    /// Takes one message; the mission whose transfer it completes.
    pub fn on_message(&mut self, time_us: u64, from: Identity, message: &Message) -> Option<Transferred> {
        let kind = self.kind.to_wire();
        let concerns_us = |target: u8| from.system == self.vehicle_system || target == self.vehicle_system;
        match message {
            Message::MISSION_COUNT(data) if data.mission_type == kind && concerns_us(data.target_system) => {
                self.transfers.retain(|transfer| transfer.from != from);
                if self.transfers.len() < MOST_TRANSFERS {
                    self.transfers.push(Transfer { from, items: vec![None; usize::from(data.count)] });
                }
                None
            }
            Message::MISSION_ITEM_INT(data) if data.mission_type == kind => {
                self.take_item(time_us, from, data.seq, Item::from_int_message(data))
            }
            Message::MISSION_ITEM(data) if data.mission_type == kind => {
                self.take_item(time_us, from, data.seq, Item::from_float_message(data))
            }
            Message::MISSION_ACK(data) if from.system == self.vehicle_system && data.mission_type == kind => {
                self.take_answer(time_us, data.mavtype)
            }
            _ => None,
        }
    }

    fn take_item(&mut self, time_us: u64, from: Identity, seq: u16, item: Item) -> Option<Transferred> {
        let at = self.transfers.iter().position(|transfer| transfer.from == from)?;
        *self.transfers[at].items.get_mut(usize::from(seq))? = Some(item);
        // What the vehicle tells is what it has; what it is told it must first accept.
        let is_whole = self.transfers[at].items.iter().all(Option::is_some);
        (is_whole && from.system == self.vehicle_system)
            .then(|| finished(time_us, self.kind, self.transfers.swap_remove(at)))
            .flatten()
    }

    fn take_answer(&mut self, time_us: u64, result: u8) -> Option<Transferred> {
        // A wrong number is asked for again; it does not end the transfer.
        if result == enums::MAV_MISSION_INVALID_SEQUENCE {
            return None;
        }
        let is_upload = |transfer: &Transfer| transfer.from.system != self.vehicle_system;
        let at = self.transfers.iter().position(is_upload)?;
        let transfer = self.transfers.swap_remove(at);
        let is_accepted = result == enums::MAV_MISSION_ACCEPTED;
        (is_accepted && transfer.items.iter().all(Option::is_some))
            .then(|| finished(time_us, self.kind, transfer))
            .flatten()
    }
}

fn finished(time_us: u64, kind: MissionType, transfer: Transfer) -> Option<Transferred> {
    let mut items = transfer.items.into_iter().flatten();
    let home = if kind == MissionType::Mission { items.next()?.position() } else { None };
    let mission = Mission { home, items: items.collect() };
    // An erased mission, or home alone, is nothing to drive.
    (!mission.items.is_empty()).then_some(Transferred { time_us, from: transfer.from, mission })
}
