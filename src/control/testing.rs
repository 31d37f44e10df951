//! A compact boat for closed-loop tests, written apart from the controller's model.
//!
//! Rigid body and added mass with sway-yaw coupling, linear to cubic damping, cross-flow drag by strips,
//! irrotational current; Fossen 2021, ch. 6 and 8. Integrated at 200 Hz.

mod plant;
mod run;

pub(crate) use plant::{Drive, Plant};
pub(crate) use run::{Report, Run, box_path, box_points};

#[cfg(test)]
mod scratch {
    use super::*;
    use crate::control::Boat;
    use crate::guidance::unit;

    #[test]
    fn scratch() {
        let boat = match std::env::var("BOAT") { Ok(p) => Boat::from_toml(&std::fs::read_to_string(p).unwrap()).unwrap(), _ => Boat::embedded("otter").unwrap() };
        let kappa: f64 = std::env::var("KAPPA").map_or(0.3, |k| k.parse().unwrap());
        let points = box_points();
        let path = helmlink_mission::path::Path::stub(&points, kappa);
        let mut plant = Plant::otter();
        plant.heading_rad = std::f64::consts::FRAC_PI_2;
        plant.current = unit(30f64.to_radians()) * 0.3;
        let run = Run { boat: &boat, path: &path, points: &points, speed_mps: 1.38, rate_hz: 20.0, delay_ticks: std::env::var("DELAY").map_or(0, |k| k.parse().unwrap()), trace: std::env::var("TRACE").is_ok() };
        println!("{:#?}", run.run(&mut plant));
    }
}
