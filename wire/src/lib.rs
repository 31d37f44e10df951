//! MAVLink on the wire, without input or output of its own.
//!
//! | module | what it holds |
//! |---|---|
//! | [`dialect`] | every message of the ardupilotmega dialect as a plain structure, enumerations as integers |
//! | [`enums`] | the names of those integers |
//! | [`frame`] | one checked frame: header, payload, decoding |
//! | [`framer`] | bytes in, frames out; resynchronises after anything |
//! | [`encoder`] | messages in, bytes out; one sequence counter per component |
//! | [`stats`] | what a link has carried and lost |
//! | [`tlog`] | telemetry logs: time-stamped frames, as ground stations write them |
//!
//! This crate knows frames, not what a message means.

mod candidate;
pub mod dialect;
pub mod encoder;
pub mod enums;
pub mod frame;
pub mod framer;
mod layout;
pub mod stats;
pub mod tlog;

pub use dialect::Message;
pub use encoder::{EncodeError, Encoder};
pub use frame::{DecodeError, Frame, FrameError, Identity, Version};
pub use framer::Framer;
pub use stats::LinkStatistics;

/// One peer of a party: a TCP client, a UDP remote, a serial port, an in-memory link.
///
/// Numbers are given by whoever owns the transports and are never used twice in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub u32);
