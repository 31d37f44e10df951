//! Transports: UDP, TCP, serial ports and in-memory pairs. Bytes go in and out; what they mean is not
//! known here.
//!
//! A [`Hub`] owns any number of endpoints, each opened from a [`LinkUrl`]. Whoever is at the other end of
//! an endpoint is a peer with a [`LinkId`] of its own: each TCP client, each UDP remote, a serial port
//! each time it opens. Numbers are never used twice.
//!
//! ```text
//!   udpin ──┬─ peer 1 ─┐
//!           └─ peer 2 ─┤            ┌─► next_event(): Up, Bytes, Bytes, ..., Down
//!   tcpin ──── peer 3 ─┼──► Hub ────┤
//!   serial ─── peer 4 ─┘            └── send(peer, bytes)
//! ```
//!
//! | module | what it holds |
//! |---|---|
//! | [`url`] | link URLs |
//! | [`hub`] | the owner of endpoints and peers |
//! | [`error`] | why an endpoint could not be opened |
//! | [`settings`] | every bound and waiting time |
//! | [`memory`] | pairs of hubs without sockets, for tests |
//! | `peer` | one peer: its number, its bounded queue, its counters |
//! | `udp`, `tcp`, `serial` | the transports |
//! | `usb` | serial ports by their USB device |
//! | `stream` | what TCP and serial ports have in common |
//! | `address` | host names to addresses, addresses to text |
//! | `backoff` | waiting times between attempts |

pub mod error;
pub mod hub;
pub mod memory;
pub mod settings;
pub mod url;

mod address;
mod backoff;
mod peer;
mod serial;
mod stream;
mod tcp;
mod udp;
mod usb;

#[cfg(test)]
mod test_support;

pub use error::OpenError;
pub use helmlink_wire::LinkId;
pub use hub::{EndpointId, Hub, LinkEvent};
pub use peer::Traffic;
pub use settings::LinkSettings;
pub use url::{LinkUrl, UrlError};
