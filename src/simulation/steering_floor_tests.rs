//! How much steering a mission asks for by itself, whoever steers.

use helmlink_mission::geodesy::{LocalFrame, NorthEast};
use helmlink_mission::path::Path;
use helmlink_mission::plan::Mission;
use helmlink_mission::route::Route;

use crate::control::Boat;
use crate::control::allocation::{Allocator, Situation};
use crate::control::command::Wrench;
use crate::control::model::{WaterMotion, damping_force};
use crate::guidance::EndOfPath;
use crate::guidance::speed::SpeedLimits;

const STEP_M: f64 = 0.05;

/// Total variation of the steering per minute of an Otter that follows the path exactly, at the speed planned, and needs
/// no moment to speed its turning up or to slow it down: the steering that holds each bend, there and back.
fn steering_per_min(mission: &str, speed_mps: f64, turn_radius_m: Option<f64>) -> f64 {
    let mission: Mission = mission.parse().unwrap();
    let mut boat = Boat::embedded("otter").unwrap();
    boat.limits.turn_radius_m = turn_radius_m.unwrap_or(boat.limits.turn_radius_m);
    let points = Route::from_mission(&mission).unwrap().local_points(&LocalFrame::new(mission.home.unwrap()));
    let path = Path::through(&points, &boat.limits.path()).unwrap();
    let speeds = SpeedLimits::new(&boat.limits, boat.guidance.creep_mps);
    let mut allocator = Allocator::new(&boat.actuators, &boat.hull);
    let (mut variation, mut time_s, mut last) = (0.0, 0.0, 0.0);
    for step in 0..(path.length_m() / STEP_M) as u32 {
        let along_m = f64::from(step) * STEP_M;
        let surge_mps = speeds.speed_mps(&path, along_m, speed_mps, NorthEast::ZERO, EndOfPath::Stop);
        let dt_s = STEP_M / surge_mps;
        let yaw_rate_radps = path.direction(along_m).curvature_radpm * surge_mps;
        let demand = Wrench {
            surge_n: damping_force(boat.hull.surge_damping, surge_mps),
            sway_n: 0.0,
            yaw_nm: damping_force(boat.hull.yaw_damping, yaw_rate_radps),
        };
        let motion = WaterMotion { surge_mps, sway_mps: 0.0, yaw_rate_radps };
        let steering =
            allocator.allocate(dt_s, demand, &Situation { motion, heading_error_rad: 0.0 }).command.steering;
        variation += f64::abs(steering - last);
        time_s += dt_s;
        last = steering;
    }
    60.0 * variation / time_s
}

#[test]
fn tight_bends_ask_for_most_of_the_steering_there_is() {
    let harbour = steering_per_min(include_str!("../../mission/plans/harbour-survey.waypoints"), 1.4, None);
    let lawn = steering_per_min(include_str!("../../mission/plans/lawnmower-30m.waypoints"), 1.4, None);
    let fossen = steering_per_min(include_str!("../../mission/plans/fossen-otter.waypoints"), 1.38, None);
    let arcs = steering_per_min(include_str!("../../mission/plans/arcs-otter.waypoints"), 1.5, Some(13.0));
    println!(
        "steering per minute that holds the bends: harbour {harbour:.1}, lawnmower {lawn:.1}, Fossen {fossen:.1}, arcs {arcs:.1}"
    );
    // Twelve bends of 4 m in three minutes: no controller that holds them steers a tenth of what a sign function does.
    assert!((3.0..7.5).contains(&harbour) && arcs < 0.5, "{harbour} {arcs}");
}
