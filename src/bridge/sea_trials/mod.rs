//! The bridge against the simulated boat, on simulated time, with everything going wrong on purpose.

mod figures;
mod matrix;
mod recordings;
mod rig;
mod services;
