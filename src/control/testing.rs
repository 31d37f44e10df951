//! A compact boat for closed-loop tests, written apart from the controller's model.
//!
//! Rigid body and added mass with sway-yaw coupling, linear to cubic damping, cross-flow drag by strips,
//! irrotational current; Fossen 2021, ch. 6 and 8. Integrated at 200 Hz.

mod plant;
mod run;

pub(crate) use plant::{Drive, Plant};
pub(crate) use run::{Report, Run, box_path, box_points};


#[cfg(test)]
mod scratch;
