//! Heading and speed control: from what guidance asks to throttle and steering.
//!
//! | module | what it holds |
//! |---|---|
//! | [`boat`] | everything known of one boat, from a checked file |
//! | [`model`] | the nominal hull: parameters Θ, regressors f, coefficients ζ, the sway model |
//! | [`axis`] | one axis of the adaptive PI sliding-mode law |
//! | [`pi_smc`] | both axes together |
//! | [`law`] | the seam where other laws plug in |
//! | [`baselines`] | the laws it is compared with |
//! | [`controller`] | controllers by name |
//! | [`parts`] | what a controller is made of: parts to leave out or give, to see what they are worth |
//! | [`gains`] | gains by name, and files of them |
//! | [`filter`] | command filter |
//! | [`allocation`] | forces to throttle and steering, and what becomes of them |
//! | [`command`] | throttle and steering, normalised |
//! | [`observer`] | the state without waves and noise |
//! | [`dead_reckoning`] | position and velocity put together: a wandering fix, a velocity that is off |
//! | [`sway_balance`] | what turns tell of the compass and of the hull's sway |
//! | [`predictor`] | the state when the command chosen now takes effect |
//! | [`response`] | the loop's delay, measured on the boat's answer to its steering |
//! | [`helm`] | the façade: state and path in, command out |

pub mod allocation;
pub mod axis;
pub mod baselines;
pub mod boat;
#[cfg(test)]
mod closed_loop_tests;
pub mod command;
pub mod controller;
pub mod dead_reckoning;
pub mod filter;
pub mod gains;
pub mod helm;
pub mod law;
pub mod model;
pub mod observer;
pub mod parts;
pub mod pi_smc;
pub mod predictor;
pub mod response;
pub mod sway_balance;

#[cfg(test)]
mod speed_schedule_tests;
#[cfg(test)]
mod testing;

pub use boat::{Boat, BoatError, Limits};
pub use command::{Command, Wrench};
pub use controller::Controller;
pub use helm::{Diagnostics, Helm, HelmError, Output};
pub use model::{Hull, SwayModel};
pub use parts::Variant;
pub use pi_smc::PiSmc;
