//! What can go wrong on the way, how it is noticed, and what is done about it.
//!
//! | module | what it holds |
//! |---|---|
//! | [`table`] | every failsafe: its limit, unit, default and action, written once |
//! | [`settings`] | what the user may change of that |
//! | [`watch`] | compares what is observed with the limits |
//! | [`fence`] | the area to stay in or out of |
//!
//! Pure: observations and time come in, a verdict comes out. Times are seconds of vehicle time.

pub mod fence;
pub mod settings;
pub mod table;
pub mod watch;

pub use fence::Fence;
pub use settings::{FailsafeError, FailsafeSettings, Rule};
pub use table::{Action, DEFINITIONS, Definition, Failsafe};
pub use watch::{Observation, PositionFix, Trip, Verdict, Watch};
