//! Where to go on when the mission has become another one while it is being driven.

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::route::Route;

/// A waypoint this close to the one that was being driven to is the same one, metres.
const SAME_PLACE_M: f64 = 1.0;

/// The waypoint of `route` to go on with, for a boat at `position` that was under way to `target`, and had
/// (`set_out`) passed the first waypoint.
///
/// The same waypoint, if it is still there; otherwise the end of the nearest leg. A boat that had not been at the first
/// waypoint yet goes to the first.
pub fn next_waypoint(route: &Route, position: Geodetic, target: Option<Geodetic>, set_out: bool) -> usize {
    let same = |target: Geodetic| {
        route.waypoints.iter().position(|waypoint| waypoint.position.distance_m(target) < SAME_PLACE_M)
    };
    if let Some(index) = target.and_then(same) {
        return index;
    }
    if !set_out {
        return 0;
    }
    let frame = LocalFrame::new(position);
    let points = route.local_points(&frame);
    let nearest = points
        .windows(2)
        .enumerate()
        .min_by(|(_, one), (_, other)| from_here_m(one).total_cmp(&from_here_m(other)));
    nearest.map_or(0, |(index, _)| index + 1)
}

/// Distance from the origin to a leg, metres.
fn from_here_m(leg: &[NorthEast]) -> f64 {
    let along = leg[1] - leg[0];
    let share = (-leg[0].dot(along) / along.dot(along)).clamp(0.0, 1.0);
    (leg[0] + along * share).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use helmlink_mission::plan::{Item, Mission};

    const ORIGIN: Geodetic = Geodetic { latitude_deg: 63.44, longitude_deg: 10.4 };

    fn at(north_m: f64, east_m: f64) -> Geodetic {
        LocalFrame::new(ORIGIN).to_geodetic(NorthEast::new(north_m, east_m))
    }

    fn route(points: &[(f64, f64)]) -> Route {
        let items = points.iter().map(|&(north_m, east_m)| Item::waypoint(at(north_m, east_m))).collect();
        Route::from_mission(&Mission { home: None, items }).unwrap()
    }

    #[test]
    fn the_same_waypoint_is_kept_wherever_it_now_stands() {
        let longer = route(&[(0.0, 0.0), (10.0, 50.0), (100.0, 0.0), (100.0, 100.0)]);
        assert_eq!(next_waypoint(&longer, at(50.0, 0.0), Some(at(100.0, 0.0)), true), 2);
    }

    #[test]
    fn otherwise_the_nearest_leg_is_followed() {
        let shifted = route(&[(0.0, 20.0), (100.0, 20.0), (100.0, 120.0), (0.0, 120.0)]);
        assert_eq!(next_waypoint(&shifted, at(60.0, 0.0), Some(at(100.0, 0.0)), true), 1);
        assert_eq!(next_waypoint(&shifted, at(90.0, 90.0), Some(at(100.0, 0.0)), true), 2);
        assert_eq!(next_waypoint(&shifted, at(20.0, 140.0), None, true), 3);
    }

    #[test]
    fn a_boat_that_had_not_set_out_goes_to_the_first() {
        let shifted = route(&[(0.0, 20.0), (100.0, 20.0)]);
        assert_eq!(next_waypoint(&shifted, at(60.0, 0.0), Some(at(0.0, 0.0)), false), 0);
        assert_eq!(next_waypoint(&route(&[(5.0, 5.0)]), at(60.0, 0.0), None, true), 0);
    }
}
