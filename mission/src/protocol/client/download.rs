//! Fetching a plan from a vehicle.

use std::time::Duration;

use helmlink_wire::Identity;
use helmlink_wire::dialect::{
    MISSION_ACK_DATA, MISSION_REQUEST_INT_DATA, MISSION_REQUEST_LIST_DATA, Message,
};
use helmlink_wire::enums::MAV_MISSION_ACCEPTED;

use super::attempts::Attempts;
use super::{Exchange, Progress, TransferError};
use crate::plan::{Item, Mission};
use crate::protocol::items::{Received, home_of_item};
use crate::protocol::result::MissionResult;

/// Fetches one plan: MISSION_REQUEST_LIST, then MISSION_REQUEST_INT for each item in turn, then MISSION_ACK.
///
/// Items may come as MISSION_ITEM_INT or MISSION_ITEM.
#[derive(Debug)]
pub struct Download {
    exchange: Exchange,
    attempts: Attempts,
    /// Times the outstanding question has been sent.
    sent: u32,
    /// Times the vehicle has changed its count; bounds the exchange with one that never settles.
    restarts: u32,
    started: Option<Duration>,
    stage: Stage,
    items: Vec<Item>,
}

#[derive(Debug)]
enum Stage {
    Counting,
    Fetching { total: u16, opaque_id: u32 },
    Thanking { total: u16 },
    Finished(Result<Mission, TransferError>),
}

impl Download {
    /// A download that starts with the first `poll`.
    pub fn new(exchange: Exchange) -> Self {
        Self {
            exchange,
            attempts: Attempts::new(exchange.timing),
            sent: 0,
            restarts: 0,
            started: None,
            stage: Stage::Counting,
            items: Vec::new(),
        }
    }

    /// Takes a message of `from`. Returns whether it belonged to this download.
    pub fn on_message(&mut self, _now: Duration, from: Identity, message: &Message) -> bool {
        let concerns =
            |system, component, mission_type| self.exchange.concerns(from, system, component, mission_type);
        match message {
            Message::MISSION_COUNT(m) if concerns(m.target_system, m.target_component, m.mission_type) => {
                self.on_count(m.count, m.opaque_id);
            }
            Message::MISSION_ACK(m) if concerns(m.target_system, m.target_component, m.mission_type) => {
                self.on_ack(m.mavtype);
            }
            _ => match Received::from_message(message) {
                Some(r) if concerns(r.target_system, r.target_component, r.mission_type) => {
                    self.on_item(r.seq, r.item);
                }
                _ => return false,
            },
        }
        true
    }

    /// The message to send now, if any.
    pub fn poll(&mut self, now: Duration) -> Option<Message> {
        if matches!(self.stage, Stage::Finished(_)) || !self.attempts.is_due(now) {
            return None;
        }
        let started = *self.started.get_or_insert(now);
        if let Stage::Thanking { .. } = self.stage {
            self.finish();
            return Some(self.final_ack());
        }
        if !self.attempts.left(self.sent) {
            self.fail(self.silence(now.saturating_sub(started)));
            return None;
        }
        self.sent += 1;
        let first = self.sent == 1 && matches!(self.stage, Stage::Counting);
        if first {
            self.attempts.wait_for_first_reply(now);
        } else {
            self.attempts.wait_for_next_reply(now);
        }
        Some(self.question())
    }

    /// When `poll` is to be called next at the latest: zero means now, `None` that the download is over.
    pub fn next_deadline(&self) -> Option<Duration> {
        (!matches!(self.stage, Stage::Finished(_))).then(|| self.attempts.deadline())
    }

    /// Items received so far.
    pub fn progress(&self) -> Progress {
        let total = match &self.stage {
            Stage::Fetching { total, .. } | Stage::Thanking { total } => Some(*total),
            Stage::Counting | Stage::Finished(Err(_)) => None,
            Stage::Finished(Ok(_)) => Some(self.next_seq()),
        };
        Progress { done: self.next_seq(), total }
    }

    /// The plan or the reason why there is none; `None` while the download goes on.
    ///
    /// Where item 0 is home it is in `home`, not among the items; home at 0/0 is reported as unknown.
    pub fn outcome(&self) -> Option<Result<&Mission, TransferError>> {
        match &self.stage {
            Stage::Finished(outcome) => Some(outcome.as_ref().map_err(|error| *error)),
            _ => None,
        }
    }

    /// A count begins the download, or begins it anew when the plan has changed meanwhile. A copy of the
    /// count already known changes nothing.
    fn on_count(&mut self, count: u16, id: u32) {
        match self.stage {
            Stage::Counting => {}
            Stage::Fetching { total, opaque_id } if (total, opaque_id) != (count, id) => {
                if !self.attempts.left(self.restarts) {
                    return;
                }
                self.restarts += 1;
            }
            _ => return,
        }
        self.items.clear();
        self.stage = match count {
            0 => Stage::Thanking { total: 0 },
            total => Stage::Fetching { total, opaque_id: id },
        };
        self.ask_anew();
    }

    fn on_item(&mut self, seq: u16, item: Item) {
        let Stage::Fetching { total, .. } = self.stage else { return };
        if seq != self.next_seq() {
            return; // A copy of one that has come, or a late answer of an earlier count.
        }
        self.items.push(item);
        if self.next_seq() == total {
            self.stage = Stage::Thanking { total };
        }
        self.ask_anew();
    }

    fn on_ack(&mut self, result: u8) {
        let item = match self.stage {
            Stage::Counting => None,
            Stage::Fetching { .. } => Some(self.next_seq()),
            Stage::Thanking { .. } | Stage::Finished(_) => return,
        };
        if result != MAV_MISSION_ACCEPTED {
            let vehicle = self.exchange.vehicle;
            self.fail(TransferError::Refused { vehicle, item, result: MissionResult(result) });
        }
    }

    fn ask_anew(&mut self) {
        self.sent = 0;
        self.attempts.make_due();
    }

    /// Sequence number of the item that is wanted: at most 65535, for a count is no more.
    fn next_seq(&self) -> u16 {
        u16::try_from(self.items.len()).unwrap_or(u16::MAX)
    }

    fn question(&self) -> Message {
        let Exchange { vehicle, mission_type, .. } = self.exchange;
        let (target_system, target_component) = (vehicle.system, vehicle.component);
        let mission_type = mission_type.to_wire();
        match self.stage {
            Stage::Counting => Message::MISSION_REQUEST_LIST(MISSION_REQUEST_LIST_DATA {
                target_system,
                target_component,
                mission_type,
            }),
            _ => Message::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
                seq: self.next_seq(),
                target_system,
                target_component,
                mission_type,
            }),
        }
    }

    fn final_ack(&self) -> Message {
        Message::MISSION_ACK(MISSION_ACK_DATA {
            target_system: self.exchange.vehicle.system,
            target_component: self.exchange.vehicle.component,
            mavtype: MAV_MISSION_ACCEPTED,
            mission_type: self.exchange.mission_type.to_wire(),
            ..MISSION_ACK_DATA::DEFAULT
        })
    }

    fn silence(&self, waited: Duration) -> TransferError {
        let vehicle = self.exchange.vehicle;
        match self.stage {
            Stage::Fetching { total, .. } => TransferError::Stalled { vehicle, item: self.next_seq(), total },
            _ => TransferError::NoAnswer { vehicle, waited_s: waited.as_secs_f64().round() as u32 },
        }
    }

    fn finish(&mut self) {
        let mut items = self.items.clone();
        let mut home = None;
        if self.exchange.has_home() && !items.is_empty() {
            home = home_of_item(&items.remove(0));
        }
        self.stage = Stage::Finished(Ok(Mission { home, items }));
    }

    fn fail(&mut self, error: TransferError) {
        self.stage = Stage::Finished(Err(error));
    }
}
