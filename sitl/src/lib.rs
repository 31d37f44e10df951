//! .
pub mod physics;
