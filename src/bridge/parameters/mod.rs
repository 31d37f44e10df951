//! The bridge's own parameters over MAVLink: gains and limits, tuned from any ground station.
//!
//! | module | what it holds |
//! |---|---|
//! | [`table`] | every parameter: name, unit, meaning, and where its value lives |
//! | [`store`] | values, ranges, the text they are kept in |
//! | `described` | the file from which ground stations learn ranges and meanings |
//! | `service` | PARAM_REQUEST_LIST, PARAM_REQUEST_READ, PARAM_SET |
//!
//! Every parameter is a REAL32, flags and choices included: the two ways in which MAVLink packs integers into a
//! float, and ground stations' guesses at which one a component uses, then make no difference.
//! Source: <https://mavlink.io/en/services/parameter.html>.

pub(super) mod described;
pub(super) mod service;
pub mod store;
pub mod table;

pub use store::{ParameterError, Tunables};
pub use table::{PARAMETERS, Parameter};
