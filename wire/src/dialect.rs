//! The messages of the ardupilotmega dialect, generated from `dialect/messages.xml`.
//!
//! Field names are MAVLink's own, with one exception of the generator: `type` is called `mavtype`.
//! Enumerations and bit masks are integers (see [`crate::enums`]), so a number that has no name here never
//! loses a message, and every field of a `DEFAULT` is zero.

mod generated {
    #![allow(missing_docs, non_camel_case_types, non_snake_case, unreachable_pub, unused_imports)]
    #![allow(clippy::all, clippy::pedantic, clippy::restriction)]
    include!(concat!(env!("OUT_DIR"), "/messages.rs"));
}

pub use generated::*;
pub use mavlink_core::types::CharArray;
pub use mavlink_core::{MavlinkVersion, Message as MessageSet, MessageData};

/// Any message of the dialect.
pub use generated::MavMessage as Message;
