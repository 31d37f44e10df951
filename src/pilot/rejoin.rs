//! Where to go on when the mission has become another one while it is being driven.

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::route::{Route, Waypoint};

use super::joining::Leg;

/// Waypoints this close to each other are the same one, metres.
const SAME_PLACE_M: f64 = 1.0;
/// A leg that runs against the boat's course counts as so many times farther away: the lane beside it, perhaps.
const AGAINST_COURSE: f64 = 2.0;
/// A mission without any of the old one's waypoints, and farther away than this, is begun at its beginning, metres.
const ANOTHER_MISSION_M: f64 = 50.0;

/// The drive that the mission has changed under.
#[derive(Debug, Clone, Copy)]
pub struct Underway<'a> {
    /// What was being driven.
    pub route: &'a Route,
    /// The waypoint of it that the boat was under way to.
    pub next: usize,
    /// Where the boat is.
    pub place: Geodetic,
    /// Its velocity over ground, m/s.
    pub velocity: NorthEast,
}

/// The waypoint of `route` to go on with: the end of the leg that is nearest, among those after the last waypoint that
/// the boat has passed and up to the first one that it has not, as far as they are still there.
///
/// A boat that had not been at the first waypoint yet goes to the first, as does one whose new mission has nothing in
/// common with the old one and is far away.
pub fn next_waypoint(route: &Route, underway: &Underway<'_>) -> usize {
    let old = &underway.route.waypoints;
    let next = underway.next.min(old.len());
    if next == 0 || route.waypoints.len() < 2 {
        return 0;
    }
    let last = route.waypoints.len() - 1;
    let passed = old[..next].iter().enumerate().rev().find_map(|(number, one)| find(route, one, number, 0));
    let after = passed.map_or(0, |passed| passed + 1);
    let ahead = old[next..].iter().enumerate().find_map(|(ahead, one)| find(route, one, next + ahead, after));
    if after > last {
        return last;
    }
    let points = route.local_points(&LocalFrame::new(underway.place));
    let nearest = (after.max(1)..=ahead.unwrap_or(last).max(after.max(1)))
        .map(|end| (end, cost_m(&Leg::new(points[end - 1], points[end]), underway.velocity)))
        .min_by(|(_, one), (_, other)| one.total_cmp(other));
    match nearest {
        Some((_, cost_m)) if passed.or(ahead).is_none() && cost_m > ANOTHER_MISSION_M => 0,
        Some((end, _)) => end,
        None => last,
    }
}

/// The waypoint of `route` from `first` on at the place of `wanted`; of several the one whose number is nearest to
/// `number`, which `wanted` had.
fn find(route: &Route, wanted: &Waypoint, number: usize, first: usize) -> Option<usize> {
    let is_same = |one: &Waypoint| one.position.distance_m(wanted.position) < SAME_PLACE_M;
    let known = route.waypoints.iter().enumerate().skip(first).filter(|(_, one)| is_same(one));
    known.map(|(index, _)| index).min_by_key(|index| index.abs_diff(number))
}

/// Distance of a leg from a boat at the origin, metres, more where it would have to turn round.
fn cost_m(leg: &Leg, velocity: NorthEast) -> f64 {
    let away_m = leg.distance_m(NorthEast::new(0.0, 0.0));
    away_m * if leg.direction().dot(velocity) < 0.0 { AGAINST_COURSE } else { 1.0 }
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

    fn index(
        old: &[(f64, f64)],
        next: usize,
        new: &[(f64, f64)],
        boat: (f64, f64),
        course: (f64, f64),
    ) -> usize {
        let (old, new) = (route(old), route(new));
        let velocity = NorthEast::new(course.0, course.1);
        next_waypoint(&new, &Underway { route: &old, next, place: at(boat.0, boat.1), velocity })
    }

    const NORTH: (f64, f64) = (2.0, 0.0);
    /// Lanes to the north and back, 20 m apart.
    const LANES: [(f64, f64); 6] =
        [(0.0, 0.0), (100.0, 0.0), (100.0, 20.0), (0.0, 20.0), (0.0, 40.0), (100.0, 40.0)];

    #[test]
    fn what_has_been_passed_is_not_driven_again_and_what_has_not_is_not_left_out() {
        // On the first lane; the same mission with a waypoint more on it, before or behind the boat.
        let mut longer = LANES.to_vec();
        longer.insert(1, (30.0, 0.0));
        assert_eq!(index(&LANES, 1, &longer, (50.0, 0.0), NORTH), 2);
        assert_eq!(index(&LANES, 1, &longer, (20.0, 0.0), NORTH), 1);
        // Another beginning changes nothing for a boat on the third lane.
        let mut longer = vec![(-50.0, -50.0), (-50.0, 0.0)];
        longer.extend(LANES);
        assert_eq!(index(&LANES, 5, &longer, (50.0, 40.0), NORTH), 7);
        // A detour inserted ahead, close by the lane that has been driven.
        let mut detour = LANES.to_vec();
        detour.insert(5, (50.0, 25.0));
        assert_eq!(index(&LANES, 5, &detour, (10.0, 38.0), NORTH), 5);
        assert_eq!(index(&LANES, 5, &detour, (70.0, 32.0), NORTH), 6);
        // What is left ends where the boat has been.
        assert_eq!(index(&LANES, 5, &LANES[..4], (50.0, 40.0), NORTH), 3);
    }

    #[test]
    fn lanes_moved_sideways_are_gone_on_with_in_the_same_direction() {
        let moved = LANES.map(|(north_m, east_m)| (north_m, east_m + 10.0));
        for (next, boat, course) in
            [(1, (50.0, 0.0), NORTH), (3, (50.0, 20.0), (-2.0, 0.0)), (5, (50.0, 40.0), NORTH)]
        {
            assert_eq!(index(&LANES, next, &moved, boat, course), next, "{boat:?}");
        }
    }

    #[test]
    fn a_mission_elsewhere_is_begun_at_its_beginning_and_so_is_one_that_was_not_yet() {
        let elsewhere = LANES.map(|(north_m, east_m)| (north_m, east_m + 500.0));
        assert_eq!(index(&LANES, 3, &elsewhere, (50.0, 20.0), NORTH), 0);
        assert_eq!(index(&LANES, 0, &LANES, (50.0, 0.0), NORTH), 0);
        assert_eq!(index(&LANES, 4, &[(5.0, 5.0)], (60.0, 0.0), NORTH), 0);
    }
}
