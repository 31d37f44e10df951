//! A compact boat and a closed loop for tests, written apart from the controller's model.

mod noise;
mod plant;
mod run;

pub(crate) use noise::Noise;
pub(crate) use plant::Plant;
pub(crate) use run::{Report, Run};
