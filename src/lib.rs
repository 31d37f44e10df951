//! Helmlink steers an uncrewed boat along its mission, over MAVLink.
//!
//! ```text
//!  bytes ──► wire ──► vehicle ──► pilot ──► vehicle ──► wire ──► bytes
//!           frames   telemetry   mission,  command     frames
//!           in       as a state  guidance, as MAVLink  out
//!                                control,
//!                                supervisor
//! ```
//!
//! | module | what it holds | what it does not know |
//! |---|---|---|
//! | [`vehicle`] | what the flight controller says and accepts | the control law |
//! | [`guidance`], [`control`] | path following, the adaptive sliding-mode law, allocation | MAVLink |
//! | [`pilot`] | the mission as a step function, and the safety state machine | sockets, clocks |
//! | [`bridge`] | all of that behind bytes in, bytes out | sockets, clocks |
//! | [`gate`] | signatures, allowed systems, secrets: what passes between links and bridge | sockets, clocks |
//! | [`simulation`] | the bridge and the simulated boat in one process, and the score | sockets, clocks |
//! | [`record`] | what a bridge records of itself, so that it can be replayed | files |
//! | [`replay`] | logs through the controller: proof, what-if, comparison, play | sockets, clocks |
//! | [`report`] | a run as a picture | where the run came from |
//! | `thin` | long rows of samples in little room | what the samples are |
//! | [`link`] | UDP, TCP, serial and in-memory transports | what the bytes mean |
//! | [`app`] | the subcommands | |
//!
//! Frames are the crate `helmlink-wire`, missions `helmlink-mission`, the simulated boat `helmlink-sitl`.

pub mod app;
pub mod bridge;
pub mod control;
pub mod gate;
pub mod guidance;
pub mod link;
pub mod pilot;
pub mod record;
pub mod replay;
pub mod report;
pub mod simulation;
mod thin;
pub mod vehicle;
