//! Mission, guidance and control as one step function, and the state machine that decides when it may steer.
//!
//! | module | what it does |
//! |---|---|
//! | [`supervisor`] | when the bridge drives, and why it stops |
//! | [`failsafe`] | what can go wrong, how it is noticed, what is done about it |
//! | [`rejoin`] | where to go on when the mission has changed under way |
//! | [`mission_run`] | where on the mission the boat is: stretches between stops, waypoints reached |
//! | `joining` | onto a leg from beside it |
//! | `stretch` | the path from one stop to the next |
//! | `tasks` | what the mission asks for on the way, and when it is due |
//!
//! The pilot knows a local north-east frame, metres and radians; no MAVLink, no clock, no socket.

pub mod failsafe;
mod joining;
pub mod mission_run;
pub mod rejoin;
mod stretch;
pub mod supervisor;
mod tasks;

pub use mission_run::{MissionRun, Progress, RunSettings, Step};
