//! The bridge and the simulated boat in one process, as fast as the machine allows, and the score of a run.
//!
//! | module | what it does |
//! |---|---|
//! | [`closed_loop`] | steps both in turn, with MAVLink frames in between |
//! | [`recorder`] | watches a run: samples, track, events |
//! | [`score`] | the figures of a run |

pub mod closed_loop;
pub mod recorder;
pub mod score;

pub use closed_loop::{ClosedLoop, Outcome};
pub use recorder::RunRecorder;
pub use score::{Sample, Score, Scorer};
