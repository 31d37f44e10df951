//! What a bridge records of itself, as an ordinary telemetry log.
//!
//! A recording holds every frame received and sent, so every tool that opens `.tlog` files reads it. Between them
//! stand frames that were on no link, from component [`COMPONENT`]: what the controller thought
//! (DEBUG_FLOAT_ARRAY, NAMED_VALUE_FLOAT), events (STATUSTEXT), the settings, and the *tape* (both TUNNEL). The tape
//! tells which calls the bridge has had at which instant, and which frames came in and went out by which
//! link, so that the same calls can be made again.
//!
//! | module | what it does |
//! |---|---|
//! | [`tape`] | the calls and frames of a recording, as bytes |
//! | [`splitter`] | the frames in a stream of bytes, and what lies between them |
//! | [`state`] | what the controller thought, as a message |
//! | [`settings`] | the bridge's settings, as text |
//! | [`journal`] | writes all of it |
//!
//! The format is described in `docs/replay.md`.

pub mod journal;
pub mod settings;
pub mod splitter;
pub mod state;
pub mod tape;

#[cfg(test)]
mod tests;

pub use journal::Journal;
pub use settings::Header;
pub use state::ControlState;

use helmlink_wire::Identity;

/// Component id of what is in the log only and was on no link: MAV_COMP_ID_ONBOARD_COMPUTER2.
pub const COMPONENT: u8 = helmlink_wire::enums::MAV_COMP_ID_ONBOARD_COMPUTER2;
/// TUNNEL payload type of the tape. Types above 32767 are private.
pub const TAPE: u16 = 0xC0_0E;
/// TUNNEL payload type of the settings.
pub const SETTINGS: u16 = 0xC0_0F;
/// Bytes in one TUNNEL.
pub const TUNNEL_LENGTH: usize = 128;

/// The sender of what is in the log only.
pub const RECORDER: Identity = Identity { system: 1, component: COMPONENT };
