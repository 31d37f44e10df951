//! The laws that the adaptive PI sliding mode is compared with, each as its authors would build it.
//!
//! | module | what it holds |
//! |---|---|
//! | [`pid`] | heading PID by pole placement with feed-forward, speed PI |
//! | [`sign_smc`] | sliding mode with a sign function and no integral |
//! | [`gains`] | the gains of all baselines of a boat |

pub mod gains;
pub mod pid;
pub mod sign_smc;

pub use gains::Baselines;
pub use pid::{HeadingPidSettings, Pid, SpeedPi, SpeedPiSettings};
pub use sign_smc::{SignAxisSettings, SignSmc};

#[cfg(test)]
mod tests;
