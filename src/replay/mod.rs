//! Recorded logs, replayed.
//!
//! | module | what it does |
//! |---|---|
//! | [`recording`] | reads back what a bridge has recorded: its settings, the calls it had, the frames it sent |
//! | [`proof`] | makes the same calls again and compares every frame |

pub mod proof;
pub mod recording;

#[cfg(test)]
mod tests;
