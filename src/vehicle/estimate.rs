//! From the latest telemetry to the boat's state at one instant.

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::{LocalFrame, NorthEast};

use super::telemetry::{Attitude, Position, Telemetry};
use crate::guidance::VesselState;

/// Heading and position that are farther apart in time than this are not carried over the gap, seconds: the
/// supervisor's age limits deal with what is really stale.
const LONGEST_GAP_S: f64 = 1.0;

/// The boat's state at the newest time stamp, with that time in seconds since the flight controller's boot.
///
/// Heading and position come in messages of their own; the older of the two is carried forward to the time of
/// the newer one with the yaw rate or the velocity that came with it.
pub fn vessel_state(telemetry: &Telemetry, frame: &LocalFrame) -> Option<(f64, VesselState)> {
    let attitude = telemetry.attitude?.value;
    let position = telemetry.position?.value;
    let boot_s = attitude.boot_s.max(position.boot_s);
    Some((boot_s, state_at(boot_s, &attitude, &position, frame)))
}

fn state_at(boot_s: f64, attitude: &Attitude, position: &Position, frame: &LocalFrame) -> VesselState {
    let since_attitude_s = (boot_s - attitude.boot_s).min(LONGEST_GAP_S);
    let since_position_s = (boot_s - position.boot_s).min(LONGEST_GAP_S);
    let heading_rad = ssa(attitude.heading_rad + attitude.yaw_rate_radps * since_attitude_s);
    let velocity = NorthEast { north_m: position.north_mps, east_m: position.east_mps };
    let (sin, cos) = heading_rad.sin_cos();
    VesselState {
        position: frame.to_local(position.place) + velocity * since_position_s,
        heading_rad,
        surge_mps: velocity.north_m * cos + velocity.east_m * sin,
        sway_mps: velocity.east_m * cos - velocity.north_m * sin,
        yaw_rate_radps: attitude.yaw_rate_radps,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use helmlink_mission::geodesy::Geodetic;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn the_older_message_is_carried_forward() {
        let place = Geodetic::new(63.4389, 10.399);
        let frame = LocalFrame::new(place);
        let attitude = Attitude { boot_s: 10.0, heading_rad: FRAC_PI_2, yaw_rate_radps: 0.1 };
        let position = Position { boot_s: 10.1, place, north_mps: 0.0, east_mps: 2.0 };
        let state = state_at(10.1, &attitude, &position, &frame);
        assert!((state.heading_rad - FRAC_PI_2 - 0.01).abs() < 1e-12);
        assert!((state.surge_mps - 2.0).abs() < 1e-3 && (state.sway_mps + 0.02).abs() < 1e-3);
        let later = state_at(10.2, &attitude, &position, &frame);
        assert!((later.position.east_m - 0.2).abs() < 1e-6);
    }
}
