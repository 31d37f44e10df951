//! The bridge and the simulated boat in one process, as fast as the machine allows, and the score of a run.
//!
//! | module | what it does |
//! |---|---|
//! | [`closed_loop`] | steps both in turn, with MAVLink frames in between |
//! | [`recorder`] | watches a run: samples, track, events |
//! | [`score`] | the figures of a run |
//! | [`trial`] | one run as a description |
//! | [`scenario`] | named seas, sensors and delays of a published comparison |
//! | [`perturbation`] | what differs from what the controller was made for |
//! | [`comparison`] | controllers side by side |
//! | [`tuning`] | gains by search |
//! | [`parallel`] | many runs on several threads |
//! | [`statistics`] | means and their confidence |

pub mod closed_loop;
pub mod comparison;
pub mod parallel;
pub mod perturbation;
pub mod recorder;
pub mod scenario;
pub mod score;
pub mod statistics;
pub mod trial;
pub mod tuning;

pub use closed_loop::{ClosedLoop, Outcome};
pub use perturbation::Perturbation;
pub use recorder::RunRecorder;
pub use scenario::Scenario;
pub use score::{Sample, Score, Scorer};
pub use trial::{Trial, TrialError};

#[cfg(test)]
mod estimator_tests;
#[cfg(test)]
mod mission_tests;
#[cfg(test)]
mod steering_floor_tests;
