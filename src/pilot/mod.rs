//! Mission, guidance and control as one step function, and the state machine that decides when it may steer.
//!
//! | module | what it does |
//! |---|---|
//! | [`supervisor`] | when the bridge drives, and why it stops |
//! | [`failsafe`] | what can go wrong, how it is noticed, what is done about it |
//! | [`mission_run`] | where on the mission the boat is: stretches between stops, waypoints reached |
//! | `stretch` | the path from one stop to the next |
//! | `tasks` | what the mission asks for on the way, and when it is due |
//!
//! The pilot knows a local north-east frame, metres and radians; no MAVLink, no clock, no socket.

pub mod failsafe;
pub mod mission_run;
mod stretch;
pub mod supervisor;
mod tasks;

pub use mission_run::{MissionRun, Progress, RunSettings, Step};
