//! MAVLink on the wire, without input or output of its own.
//!
//! | module | what it holds |
//! |---|---|
//! | [`dialect`] | every message of the ardupilotmega dialect as a plain structure, enumerations as integers |
//! | [`enums`] | the names of those integers |
//! | [`frame`] | one checked frame: header, payload, decoding |
//! | [`framer`] | bytes in, frames out; resynchronises after anything |
//! | [`encoder`] | messages in, bytes out; one sequence counter per component |
//! | [`ftp`] | a server of files that can only be read, by MAVLink's file transfer protocol |
//! | [`outbox`] | what waits for a peer that does not keep up, and what of it is lost first |
//! | [`signing`] | MAVLink 2 signatures: keys, time stamps, what is refused and why |
//! | [`stats`] | what a link has carried and lost |
//! | [`tlog`] | telemetry logs: time-stamped frames, as ground stations write them |
//!
//! This crate knows frames, not what a message means; only [`ftp`] does, for all who serve files.
//!
//! ```
//! use helmlink_wire::dialect::HEARTBEAT_DATA;
//! use helmlink_wire::{Encoder, Framer, Identity, Message};
//!
//! let boat = Identity { system: 1, component: 1 };
//! let message = Message::HEARTBEAT(HEARTBEAT_DATA { mavtype: 11, ..HEARTBEAT_DATA::DEFAULT });
//! let mut bytes = b"noise".to_vec();
//! Encoder::new().encode(boat, &message, &mut bytes);
//!
//! let mut framer = Framer::new();
//! framer.push(&bytes);
//! framer.end_of_datagram();
//! while let Some(frame) = framer.next_frame() {
//!     assert_eq!(frame.identity(), boat);
//!     assert_eq!(frame.decode(), Ok(message.clone()));
//! }
//! assert_eq!(framer.statistics().frames, 1);
//! ```

mod candidate;
mod checksum;
pub mod dialect;
pub mod encoder;
pub mod enums;
pub mod frame;
pub mod framer;
pub mod ftp;
mod layout;
pub mod outbox;
pub mod signing;
pub mod stats;
pub mod tlog;

pub use dialect::Message;
pub use encoder::{EncodeError, Encoder};
pub use frame::{DecodeError, Frame, FrameError, Identity, Version};
pub use framer::Framer;
pub use outbox::Outbox;
pub use stats::LinkStatistics;

/// One peer of a party: a TCP client, a UDP remote, a serial port, an in-memory link.
///
/// Numbers are given by whoever owns the transports and are never used twice in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub u32);
