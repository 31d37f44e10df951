//! Sending a plan to a vehicle.

use std::time::Duration;

use helmlink_wire::Identity;
use helmlink_wire::dialect::{MISSION_COUNT_DATA, Message};
use helmlink_wire::enums::{MAV_MISSION_ACCEPTED, MAV_MISSION_ERROR, MAV_MISSION_INVALID_SEQUENCE};

use super::attempts::Attempts;
use super::{Exchange, Progress, TransferError};
use crate::plan::{Item, Mission};
use crate::protocol::REPEAT_GUARD;
use crate::protocol::result::MissionResult;

/// Sends one plan: MISSION_COUNT, then whichever item the vehicle asks for, until it sends MISSION_ACK.
///
/// Both MISSION_REQUEST_INT and MISSION_REQUEST (which is all ArduRover sends) are answered with
/// MISSION_ITEM_INT. When the vehicle is silent the last message is sent again: a vehicle that had it
/// already answers with INVALID_SEQUENCE and goes on (ArduRover 4.6, measured), so that result is not final.
///
/// Success says that the vehicle took the plan. To see what it made of it, download it.
#[derive(Debug)]
pub struct Upload {
    exchange: Exchange,
    attempts: Attempts,
    items: Vec<Item>,
    count: u16,
    /// Times each item has been sent; bounds the exchange whatever the vehicle asks for.
    item_sent: Vec<u32>,
    count_sent: u32,
    started: Option<Duration>,
    /// The item last asked for, and when it was last sent.
    current: Option<u16>,
    current_sent_at: Option<Duration>,
    /// One past the highest item sent so far.
    done: u16,
    outcome: Option<Result<(), TransferError>>,
}

impl Upload {
    /// An upload of `plan` that starts with the first `poll`.
    ///
    /// Where item 0 of a mission is home, `plan.home` becomes item 0 (0/0 if there is none; ArduPilot keeps
    /// its own home in any case) and `plan.items[0]` item 1. Elsewhere `plan.home` is not sent.
    pub fn new(exchange: Exchange, plan: &Mission) -> Self {
        let mut items = Vec::with_capacity(plan.items.len() + 1);
        if exchange.has_home() {
            items.push(Item::home(plan.home));
        }
        items.extend_from_slice(&plan.items);
        let (count, outcome) = match u16::try_from(items.len()) {
            Ok(count) => (count, None),
            Err(_) => (0, Some(Err(TransferError::TooLong { count: items.len() }))),
        };
        Self {
            exchange,
            attempts: Attempts::new(exchange.timing),
            item_sent: vec![0; items.len()],
            items,
            count,
            count_sent: 0,
            started: None,
            current: None,
            current_sent_at: None,
            done: 0,
            outcome,
        }
    }

    /// Takes a message of `from`. Returns whether it belonged to this upload.
    pub fn on_message(&mut self, now: Duration, from: Identity, message: &Message) -> bool {
        let concerns =
            |system, component, mission_type| self.exchange.concerns(from, system, component, mission_type);
        match message {
            Message::MISSION_REQUEST(m) if concerns(m.target_system, m.target_component, m.mission_type) => {
                self.on_request(now, m.seq);
            }
            Message::MISSION_REQUEST_INT(m)
                if concerns(m.target_system, m.target_component, m.mission_type) =>
            {
                self.on_request(now, m.seq);
            }
            Message::MISSION_ACK(m) if concerns(m.target_system, m.target_component, m.mission_type) => {
                self.on_ack(m.mavtype);
            }
            _ => return false,
        }
        true
    }

    /// The message to send now, if any.
    pub fn poll(&mut self, now: Duration) -> Option<Message> {
        if self.outcome.is_some() || !self.attempts.is_due(now) {
            return None;
        }
        let started = *self.started.get_or_insert(now);
        if !self.attempts.left(self.times_sent()) {
            self.outcome = Some(Err(self.silence(now.saturating_sub(started))));
            return None;
        }
        match self.current {
            None => Some(self.send_count(now)),
            Some(seq) => self.send_item(now, seq),
        }
    }

    /// When `poll` is to be called next at the latest: zero means now, `None` that the upload is over.
    pub fn next_deadline(&self) -> Option<Duration> {
        self.outcome.is_none().then(|| self.attempts.deadline())
    }

    /// Items sent so far.
    pub fn progress(&self) -> Progress {
        Progress { done: self.done, total: Some(self.count) }
    }

    /// Whether the vehicle took the plan; `None` while the upload goes on.
    pub fn outcome(&self) -> Option<Result<(), TransferError>> {
        self.outcome
    }

    fn on_request(&mut self, now: Duration, seq: u16) {
        if self.outcome.is_some() || seq >= self.count {
            return;
        }
        let copy_of_last = self.current == Some(seq)
            && self.current_sent_at.is_some_and(|sent_at| now.saturating_sub(sent_at) < REPEAT_GUARD);
        // An item that has used up its attempts is not sent again: silence then ends the upload.
        if copy_of_last || !self.attempts.left(self.times_item_sent(seq)) {
            return;
        }
        self.current = Some(seq);
        self.attempts.make_due();
    }

    fn on_ack(&mut self, result: u8) {
        let everything_sent = self.done == self.count && (self.count > 0 || self.count_sent > 0);
        let vehicle = self.exchange.vehicle;
        let outcome = match result {
            MAV_MISSION_INVALID_SEQUENCE => return,
            // Left over from an earlier exchange.
            MAV_MISSION_ACCEPTED if !everything_sent => return,
            MAV_MISSION_ACCEPTED => Ok(()),
            // What ArduRover says to a last item sent again when its acceptance was lost on the way.
            MAV_MISSION_ERROR if everything_sent && self.times_sent() > 1 => {
                Err(TransferError::Unconfirmed { vehicle, total: self.count })
            }
            _ => Err(TransferError::Refused { vehicle, item: self.current, result: MissionResult(result) }),
        };
        self.outcome.get_or_insert(outcome);
    }

    fn send_count(&mut self, now: Duration) -> Message {
        self.count_sent += 1;
        if self.count_sent == 1 {
            self.attempts.wait_for_first_reply(now);
        } else {
            self.attempts.wait_for_next_reply(now);
        }
        Message::MISSION_COUNT(MISSION_COUNT_DATA {
            count: self.count,
            target_system: self.exchange.vehicle.system,
            target_component: self.exchange.vehicle.component,
            mission_type: self.exchange.mission_type.to_wire(),
            ..MISSION_COUNT_DATA::DEFAULT
        })
    }

    fn send_item(&mut self, now: Duration, seq: u16) -> Option<Message> {
        let index = usize::from(seq);
        let item = self.items.get(index)?;
        *self.item_sent.get_mut(index)? += 1;
        self.current_sent_at = Some(now);
        self.done = self.done.max(seq + 1);
        // After the last item the vehicle checks and stores the plan, and a repeat is no use to one that
        // lost its own acceptance: it is given more time.
        if seq + 1 == self.count && self.item_sent[index] == 1 {
            self.attempts.wait_for_first_reply(now);
        } else {
            self.attempts.wait_for_next_reply(now);
        }
        let Exchange { vehicle, mission_type, .. } = self.exchange;
        let message = item.to_int_message(seq, vehicle.system, vehicle.component, mission_type.to_wire());
        Some(Message::MISSION_ITEM_INT(message))
    }

    /// Times the message that is next to be sent has been sent.
    fn times_sent(&self) -> u32 {
        self.current.map_or(self.count_sent, |seq| self.times_item_sent(seq))
    }

    fn times_item_sent(&self, seq: u16) -> u32 {
        self.item_sent.get(usize::from(seq)).copied().unwrap_or(0)
    }

    fn silence(&self, waited: Duration) -> TransferError {
        let vehicle = self.exchange.vehicle;
        match self.current {
            None => TransferError::NoAnswer { vehicle, waited_s: waited.as_secs_f64().round() as u32 },
            Some(_) if self.done == self.count => TransferError::Unconfirmed { vehicle, total: self.count },
            Some(item) => TransferError::Stalled { vehicle, item, total: self.count },
        }
    }
}
