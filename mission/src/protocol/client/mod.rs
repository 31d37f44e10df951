//! The ground station's end: one machine fetches a plan, the other sends one.
//!
//! Both are driven alike. Call `poll` until it returns `None` and send what it gives; hand every arriving
//! message to `on_message`; call `poll` again after each and at `next_deadline` at the latest; stop when
//! `outcome` has something to say. A machine serves one transfer.

use std::time::Duration;

use helmlink_wire::Identity;
use thiserror::Error;

use super::MissionType;
use super::result::MissionResult;

mod attempts;
mod download;
mod upload;

pub use download::Download;
pub use upload::Upload;

/// How long the answer to the first message of a transfer may take, as the protocol page advises.
pub const FIRST_REPLY: Duration = Duration::from_millis(1500);
/// How long the answer to any later message may take. The page advises 0.25 s; half a second, as MAVSDK
/// waits, spares a slow radio.
pub const NEXT_REPLY: Duration = Duration::from_millis(500);
/// How often one and the same message is sent before the transfer is given up.
///
/// The page advises 6 (5 retries). At 20 % loss in both directions one question in 460 would then stay
/// unanswered, and a third of all transfers of 200 items would fail; with 16 it is one in twelve million.
/// 16 half seconds are also the 8 s after which ArduRover gives up an upload.
pub const ATTEMPTS: u32 = 16;

/// Waiting and repeating.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Wait for the answer to the first message: [`FIRST_REPLY`].
    pub first_reply: Duration,
    /// Wait for the answer to every other message: [`NEXT_REPLY`].
    pub next_reply: Duration,
    /// Times one message is sent, at least 1: [`ATTEMPTS`].
    pub attempts: u32,
}

impl Default for Timing {
    fn default() -> Self {
        Self { first_reply: FIRST_REPLY, next_reply: NEXT_REPLY, attempts: ATTEMPTS }
    }
}

/// Who talks to whom about which plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exchange {
    /// This end; the vehicle addresses its answers to it.
    pub own: Identity,
    /// The vehicle. Messages of others are ignored.
    pub vehicle: Identity,
    /// Which of its plans.
    pub mission_type: MissionType,
    /// Whether item 0 of a mission is home, as on ArduPilot. Fences and rally points have no home.
    pub home_is_item_0: bool,
    /// Waiting and repeating.
    pub timing: Timing,
}

impl Exchange {
    /// An exchange with an ArduPilot vehicle, with the usual timing.
    pub fn with_ardupilot(own: Identity, vehicle: Identity, mission_type: MissionType) -> Self {
        Self { own, vehicle, mission_type, home_is_item_0: true, timing: Timing::default() }
    }

    fn has_home(&self) -> bool {
        self.home_is_item_0 && self.mission_type == MissionType::Mission
    }

    /// Whether a message of this sender, target and type of plan belongs to the exchange. Targets of 0 mean
    /// everyone.
    fn concerns(&self, from: Identity, system: u8, component: u8, mission_type: u8) -> bool {
        from == self.vehicle
            && (system == 0 || system == self.own.system)
            && (component == 0 || component == self.own.component)
            && mission_type == self.mission_type.to_wire()
    }
}

/// How far a transfer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Items that have crossed the link, home included.
    pub done: u16,
    /// Items in all; `None` while the vehicle has not said.
    pub total: Option<u16>,
}

/// Why a transfer failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum TransferError {
    /// Not one answer.
    #[error(
        "vehicle {vehicle} did not answer within {waited_s} s; check that it is on this link and that no other program uses its address"
    )]
    NoAnswer {
        /// The vehicle asked.
        vehicle: Identity,
        /// Time since the first question, rounded, seconds.
        waited_s: u32,
    },
    /// The exchange began and then stopped.
    #[error(
        "vehicle {vehicle} fell silent at item {item} of {total}; the link may lose too much: move closer, or try again"
    )]
    Stalled {
        /// The vehicle asked.
        vehicle: Identity,
        /// Sequence number of the item that did not get through.
        item: u16,
        /// Items in all, home included.
        total: u16,
    },
    /// Everything was sent, but the vehicle's last word is missing.
    #[error(
        "vehicle {vehicle} was sent all {total} items but did not confirm them; download the plan to see which one it has"
    )]
    Unconfirmed {
        /// The vehicle sent to.
        vehicle: Identity,
        /// Items in all, home included.
        total: u16,
    },
    /// The vehicle said no.
    #[error("vehicle {vehicle} refused the plan{}: {result}", at_item(.item))]
    Refused {
        /// The vehicle that refused.
        vehicle: Identity,
        /// Sequence number of the item last sent or asked for, if any.
        item: Option<u16>,
        /// Its reason.
        result: MissionResult,
    },
    /// More items than a sequence number can count.
    #[error("the plan has {count} items, but MAVLink can count only 65535; split it")]
    TooLong {
        /// Items, home included.
        count: usize,
    },
}

fn at_item(item: &Option<u16>) -> String {
    item.map_or(String::new(), |item| format!(" at item {item}"))
}
