//! The physical boat: hull, actuators, sea and sensors, stepped at a fixed rate.
//!
//! ```text
//!  command ─► actuators ─► forces ─► dynamics ─► hull state ─► sensors ─► estimate
//!                            ▲                        │
//!             sea: current, wind, wave drift          └─ + first-order wave motion
//! ```
//!
//! [`Vessel`] ties the parts together; it is what an autopilot drives. Everything here is pure: no clock, no
//! I/O, no allocation per step, and the same seed gives the same bytes.
//!
//! Frames: NED with x north and y east, heading clockwise from north; body axes forward and to starboard.
//! Notation and equations follow T. I. Fossen, *Handbook of Marine Craft Hydrodynamics and Motion Control*,
//! 2nd edition, Wiley 2021, cited below as "Fossen 2021".

pub mod actuators;
mod angles;
pub mod dynamics;
pub mod environment;
mod estimator;
pub mod faults;
pub mod hull;
mod hull_check;
mod hull_file;
pub(crate) mod random;
pub mod sea;
pub mod sensors;
mod shallow;
pub mod vessel;
pub mod waves;

#[cfg(test)]
mod otter_reference;
#[cfg(test)]
mod tests;

pub use actuators::ActuatorCommand;
pub use dynamics::{NedVector, State};
pub use faults::VesselFaults;
pub use hull::{Hull, HullError};
pub use sea::{Sea, SeaError, SeaState};
pub use sensors::{Estimate, SensorSettings};
pub use vessel::{Pose, Truth, Vessel};

/// Density of sea water, kg/m³ (Fossen's vessel models).
pub const WATER_DENSITY_KGPM3: f64 = 1025.0;
/// Density of air at 20 °C, kg/m³ (MSS, blendermann94.m).
pub const AIR_DENSITY_KGPM3: f64 = 1.224;
/// Acceleration of gravity, m/s².
pub const GRAVITY_MPS2: f64 = 9.81;
/// The step at which the models were tested, s; [`Vessel::step`] splits longer spans.
pub const STEP_S: f64 = 0.01;
