//! Helmlink steers an uncrewed boat along its mission.
pub mod simulation { pub mod score; }
pub mod report;
pub mod vehicle;
pub mod pilot { pub mod supervisor; }
