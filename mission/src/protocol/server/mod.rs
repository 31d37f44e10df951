//! The vehicle's end of the mission protocol, for any number of ground stations on any number of links.
//!
//! It follows ArduRover 4.6 as measured, save where the protocol page asks for better: an upload replaces
//! the stored plan only once its last item has come (the firmware overwrites item by item), repeated items
//! bring the next request instead of an INVALID_SEQUENCE that some clients take for the end, a client may
//! cancel its upload, and MISSION_CLEAR_ALL may clear every type of plan at once.
//!
//! MISSION_SET_CURRENT and the messages about progress belong to whoever carries out the mission.

use std::collections::VecDeque;
use std::time::Duration;

use helmlink_wire::dialect::{
    MISSION_ACK_DATA, MISSION_COUNT_DATA, MISSION_REQUEST_DATA, MISSION_REQUEST_INT_DATA, Message,
};
use helmlink_wire::enums::*;
use helmlink_wire::{Identity, LinkId};

use super::MissionType;
use super::items::Received;
use crate::geodesy::Geodetic;
use crate::plan::Item;

mod downloads;
mod receiving;
mod rules;
mod store;
mod uploads;

pub use rules::{ItemRule, ardurover};

use receiving::{Receiving, Verdict};
use rules::Home;
use store::{Store, index};

/// How long an item may take before it is asked for again (ArduRover 4.6, measured).
pub const ASK_AGAIN: Duration = Duration::from_secs(1);
/// How long an upload may go without a new item before it is given up (ArduRover 4.6, measured).
pub const GIVE_UP: Duration = Duration::from_secs(8);
/// Items a plan may have, home included (ArduRover 4.6, measured).
pub const CAPACITY: u16 = 655;
/// Replies kept until they are fetched; a flood of questions beyond that goes unanswered.
const OUTBOX_LIMIT: usize = 2000;

/// How a server behaves.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Ask for items with MISSION_REQUEST_INT, as the protocol page wants, instead of MISSION_REQUEST, which
    /// is all ArduRover sends.
    pub ask_with_int: bool,
    /// Wait before an item is asked for again: [`ASK_AGAIN`].
    pub ask_again: Duration,
    /// Wait without a new item before an upload is given up: [`GIVE_UP`].
    pub give_up: Duration,
    /// Items a plan may have, home included: [`CAPACITY`].
    pub capacity: u16,
    /// Which items are accepted: [`ardurover`]. Item 0 of a mission is not asked about, for it is replaced
    /// by home.
    pub rule: ItemRule,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            ask_with_int: false,
            ask_again: ASK_AGAIN,
            give_up: GIVE_UP,
            capacity: CAPACITY,
            rule: ardurover,
        }
    }
}

/// A ground station: the same address on another link is another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Client {
    link: LinkId,
    identity: Identity,
}

/// The plans of one vehicle and everybody's access to them.
#[derive(Debug)]
pub struct MissionServer {
    settings: Settings,
    store: Store,
    receiving: [Option<Receiving>; 3],
    verdicts: [Option<Verdict>; 3],
    changed: [bool; 3],
    in_auto: bool,
    outbox: VecDeque<(LinkId, Message)>,
}

impl MissionServer {
    /// A server without plans and without home.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            store: Store::default(),
            receiving: [None, None, None],
            verdicts: [None; 3],
            changed: [false; 3],
            in_auto: false,
            outbox: VecDeque::new(),
        }
    }

    /// Takes a message that `from` sent over `link` to the vehicle with address `own`.
    ///
    /// Returns whether it was one of the mission protocol for this vehicle; any component of it is meant. A
    /// MISSION_ITEM(_INT) with `current` 2 or 3 is a guided target, not part of a plan, and is left alone.
    pub fn on_message(
        &mut self,
        now: Duration,
        link: LinkId,
        from: Identity,
        own: Identity,
        message: &Message,
    ) -> bool {
        let client = Client { link, identity: from };
        let Some(target_system) = target_system(message) else { return false };
        if target_system != 0 && target_system != own.system {
            return false;
        }
        match message {
            Message::MISSION_REQUEST_LIST(m) => self.on_list(client, m.mission_type),
            Message::MISSION_REQUEST_INT(m) => self.on_item_request(client, m.mission_type, m.seq, true),
            Message::MISSION_REQUEST(m) => self.on_item_request(client, m.mission_type, m.seq, false),
            Message::MISSION_COUNT(m) => self.on_count(now, client, m.mission_type, m.count),
            Message::MISSION_WRITE_PARTIAL_LIST(m) => {
                self.on_write_partial(now, client, m.mission_type, m.start_index, m.end_index);
            }
            Message::MISSION_CLEAR_ALL(m) => self.on_clear(client, m.mission_type),
            Message::MISSION_ACK(m) => self.on_ack(client, m.mission_type, m.mavtype),
            _ => match Received::from_message(message) {
                Some(received) if received.current < 2 => self.on_item(now, client, &received),
                _ => return false,
            },
        }
        true
    }

    /// The next message to send now and the link to send it on, if any. Call until it returns `None`.
    pub fn poll(&mut self, now: Duration) -> Option<(LinkId, Message)> {
        self.keep_uploads_going(now);
        self.outbox.pop_front()
    }

    /// When `poll` is to be called next at the latest; zero means now, `None` that nothing is waited for.
    pub fn next_deadline(&self) -> Option<Duration> {
        if !self.outbox.is_empty() {
            return Some(Duration::ZERO);
        }
        let Settings { ask_again, give_up, .. } = self.settings;
        let deadlines = self.receiving.iter().flatten().map(|r| r.deadlines(ask_again, give_up));
        deadlines.map(|(ask_again, give_up)| ask_again.min(give_up)).min()
    }

    /// A plan that has been replaced or cleared since it was last named here.
    pub fn take_changed(&mut self) -> Option<MissionType> {
        let changed = MissionType::ALL.into_iter().find(|t| self.changed[index(*t)])?;
        self.changed[index(changed)] = false;
        Some(changed)
    }

    /// The stored plan; of a mission the items without home, so that `items[0]` has sequence number 1.
    pub fn items(&self, mission_type: MissionType) -> &[Item] {
        self.store.items(mission_type)
    }

    /// Number of items as MISSION_COUNT states it: home included, and 0 when there is no mission at all.
    pub fn count(&self, mission_type: MissionType) -> u16 {
        self.store.count(mission_type)
    }

    /// Stores a plan without asking the item rule, for example one loaded from a file. Of a mission `items`
    /// are without home. Items beyond the capacity are refused.
    ///
    /// # Errors
    /// The capacity, home included, if `items` are more than that. The stored plan is then left as it was.
    pub fn set_items(&mut self, mission_type: MissionType, items: &[Item]) -> Result<(), u16> {
        let mut slots = Vec::with_capacity(items.len() + 1);
        if mission_type == MissionType::Mission && !items.is_empty() {
            slots.push(self.store.home_item());
        }
        slots.extend_from_slice(items);
        if slots.len() > usize::from(self.settings.capacity) {
            return Err(self.settings.capacity);
        }
        self.replace(mission_type, slots);
        Ok(())
    }

    /// Sets home, which reads back as item 0 of the mission; altitude above mean sea level. `None` reads
    /// back as 0/0.
    pub fn set_home(&mut self, home: Option<(Geodetic, f32)>) {
        self.store.home = home.map(|(position, altitude_m)| Home { position, altitude_m });
    }

    /// Tells whether the vehicle is carrying out its mission: MISSION_CLEAR_ALL is then refused with ERROR
    /// and the mission kept (ArduRover 4.6, measured).
    pub fn set_in_auto(&mut self, in_auto: bool) {
        self.in_auto = in_auto;
    }

    /// Forgets what belongs to a link that is gone: its uploads and the replies not yet sent.
    pub fn link_down(&mut self, link: LinkId) {
        for receiving in &mut self.receiving {
            if receiving.as_ref().is_some_and(|r| r.client.link == link) {
                *receiving = None;
            }
        }
        self.outbox.retain(|(to, _)| *to != link);
    }

    fn replace(&mut self, mission_type: MissionType, slots: Vec<Item>) {
        self.store.replace(mission_type, slots);
        self.changed[index(mission_type)] = true;
    }

    fn send(&mut self, client: Client, message: Message) {
        if self.outbox.len() < OUTBOX_LIMIT {
            self.outbox.push_back((client.link, message));
        }
    }

    fn send_ack(&mut self, client: Client, mission_type: u8, result: u8) {
        let message = MISSION_ACK_DATA {
            target_system: client.identity.system,
            target_component: client.identity.component,
            mavtype: result,
            mission_type,
            ..MISSION_ACK_DATA::DEFAULT
        };
        self.send(client, Message::MISSION_ACK(message));
    }

    fn send_count(&mut self, client: Client, mission_type: MissionType) {
        let message = MISSION_COUNT_DATA {
            target_system: client.identity.system,
            target_component: client.identity.component,
            count: self.store.count(mission_type),
            mission_type: mission_type.to_wire(),
            ..MISSION_COUNT_DATA::DEFAULT
        };
        self.send(client, Message::MISSION_COUNT(message));
    }

    fn send_request(&mut self, client: Client, mission_type: MissionType, seq: u16) {
        let Identity { system: target_system, component: target_component } = client.identity;
        let mission_type = mission_type.to_wire();
        let message = if self.settings.ask_with_int {
            Message::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
                seq,
                target_system,
                target_component,
                mission_type,
            })
        } else {
            Message::MISSION_REQUEST(MISSION_REQUEST_DATA {
                seq,
                target_system,
                target_component,
                mission_type,
            })
        };
        self.send(client, message);
    }
}

/// Whom a message of the mission protocol is meant for; `None` for messages that are not handled here.
fn target_system(message: &Message) -> Option<u8> {
    match message {
        Message::MISSION_REQUEST_LIST(m) => Some(m.target_system),
        Message::MISSION_REQUEST_INT(m) => Some(m.target_system),
        Message::MISSION_REQUEST(m) => Some(m.target_system),
        Message::MISSION_COUNT(m) => Some(m.target_system),
        Message::MISSION_WRITE_PARTIAL_LIST(m) => Some(m.target_system),
        Message::MISSION_CLEAR_ALL(m) => Some(m.target_system),
        Message::MISSION_ACK(m) => Some(m.target_system),
        _ => Received::from_message(message).map(|received| received.target_system),
    }
}
