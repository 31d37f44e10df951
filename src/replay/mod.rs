//! Recorded logs, replayed.
//!
//! | module | what it does |
//! |---|---|
//! | [`recording`] | reads back what a bridge has recorded: its settings, the calls it had, the frames it sent |
//! | [`proof`] | makes the same calls again and compares every frame |
//! | [`scan`] | one pass over any log: vehicles, missions, clocks, damage |
//! | [`explain`] | what is unusual about it, in words |
//! | [`missions`] | missions out of the traffic |
//! | [`servo`] | what really went to motors and rudder |
//! | [`watch`] | follows one vehicle through a log, at the vehicle's own time |
//! | [`reorder`] | records that are out of order, put in order |
//! | [`what_if`] | the recorded boat through the controller |
//! | [`picture`] | a replay as a run that can be drawn |
//! | [`export`] | CSV, JSON, telemetry log, MCAP |
//! | [`play`] | which frame is due when, at any pace |

pub mod explain;
pub mod export;
pub mod missions;
pub mod picture;
pub mod play;
pub mod proof;
pub mod recording;
pub mod reorder;
pub mod scan;
pub mod servo;
pub mod watch;
pub mod what_if;

#[cfg(test)]
mod log_tests;
#[cfg(test)]
mod tests;
