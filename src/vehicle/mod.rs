//! The flight controller as the bridge sees it: what it says, and what it accepts.
//!
//! | module | what it does |
//! |---|---|
//! | [`modes`] | names and numbers of ArduRover's modes |
//! | [`telemetry`] | the latest of each message that matters, with its age |
//! | [`clock`] | the flight controller's clock, kept running between messages |
//! | [`cadence`] | when enough new telemetry has come for one control step |
//! | [`estimate`] | the boat's state at one instant |
//! | [`parameters`] | reads the parameters that the outputs depend on |
//! | [`streams`] | asks for the messages that the bridge needs, and asks again when they stop |
//! | [`output`] | a steering and throttle command as MAVLink, and how to let go again |
//!
//! Degrees, 1e7 integers and pulse widths stop here: everything that leaves this module is in SI units.

pub mod cadence;
pub mod clock;
pub mod estimate;
pub mod modes;
pub mod output;
pub mod parameters;
pub mod streams;
pub mod telemetry;

pub use cadence::Cadence;
pub use clock::VehicleClock;
pub use modes::Mode;
pub use output::{Output, OutputKind};
pub use parameters::ParameterReader;
pub use streams::StreamRequests;
pub use telemetry::Telemetry;
