//! The bridge against the simulated boat, on simulated time, with everything going wrong on purpose.

mod bad_links;
mod company;
mod descriptions;
mod figures;
mod gone;
mod matrix;
mod recordings;
mod rejoining;
mod rig;
mod senses;
mod services;
mod survey;
