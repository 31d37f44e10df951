//! A simulated boat that ground stations and bridges take for a real one.
//!
//! ```text
//!  bytes ─► autopilot ─► actuators ─► physics ─► estimate ─► autopilot ─► bytes
//! ```
//!
//! | module | what it holds |
//! |---|---|
//! | [`Sitl`] | the whole boat: bytes in, simulated time on, bytes out |
//! | [`physics`] | hull, actuators, sea and sensors |
//! | `autopilot` | an ArduRover-like flight controller: modes, missions, parameters, failsafes, MAVLink |
//! | `trial` | how a hull answers throttle and steering, from which the autopilot is tuned |
//!
//! Nothing here owns a socket or a clock. The same settings and the same bytes at the same simulated times
//! give the same bytes out.

mod autopilot;
pub mod physics;
mod sitl;
mod trial;

pub use autopilot::{AutopilotSettings, StartUp};
pub use sitl::{Sitl, SitlError, SitlSettings};
