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
//! | [`faults`] | links, sensors, actuators and the autopilot made to fail |
//! | [`scenario`] | seas, faults and expectations over time, from files |
//! | [`ardupilot`] | the same physics behind a real ArduPilot |
//! | `clock` | pausing, stepping and lockstep |
//! | `trial` | how a hull answers throttle and steering, from which the autopilot is tuned |
//!
//! # Faults
//! Anything of [`faults::Fault`] can be made to fail at any time, and repaired:
//!
//! ```
//! use helmlink_sitl::{Sitl, SitlSettings, faults::Fault, physics::Hull};
//!
//! let mut boat = Sitl::new(SitlSettings::new(Hull::builtin("otter")?))?;
//! boat.inject(Fault::GpsLoss)?;
//! boat.inject("link-loss=30".parse()?)?;
//! boat.lift(&Fault::GpsLoss);
//! boat.schedule("gps-jump=20,0@60..90".parse()?)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Nothing here owns a socket or a clock. The same settings and the same bytes at the same simulated times
//! give the same bytes out.

pub mod ardupilot;
mod autopilot;
mod clock;
pub mod faults;
pub mod physics;
pub mod scenario;
mod sitl;
mod toml_place;
mod trial;

pub use autopilot::{AutopilotSettings, StartUp};
pub use sitl::{PlayError, Sitl, SitlError, SitlSettings};
