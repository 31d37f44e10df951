//! Helmlink steers an uncrewed boat along its mission.

pub mod link;
