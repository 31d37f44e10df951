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
//! # A boat in a test
//!
//! ```
//! use std::time::Duration;
//! use helmlink_mission::{geodesy::Geodetic, plan::Item};
//! use helmlink_sitl::{Sitl, SitlSettings, physics::Hull};
//!
//! let mut settings = SitlSettings::new(Hull::builtin("otter")?);
//! settings.home = Geodetic::new(63.4406, 10.4022);
//! let mut boat = Sitl::new(settings)?;
//! boat.set_mission(&[Item::waypoint(Geodetic::new(63.4409, 10.4022))]).map_err(|most| format!("{most} at most"))?;
//! boat.advance(Duration::from_secs(3)); // a real test talks MAVLink here: `on_bytes` in, `poll_transmit` out
//! assert!(boat.start());
//! boat.advance(Duration::from_secs(90));
//! assert!(boat.observe().mission_complete && boat.truth().hull.north_m > 30.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
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
