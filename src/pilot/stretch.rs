//! The path from where the boat is to the next place at which it stops, or around which it turns.

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::{Orbit, Path, PathError, PathLimits};
use helmlink_mission::route::Waypoint;

/// A stretch that would start closer than this to its first waypoint starts at the waypoint itself, metres.
pub(super) const AT_WAYPOINT_M: f64 = 1.0;
/// A stretch is complete this far before its last waypoint at the latest, metres: a boat that stops cannot
/// be expected to touch a point.
const ARRIVAL_M: f64 = 0.5;

/// The path through the waypoints from one stop to the next.
#[derive(Debug)]
pub(super) struct Stretch {
    pub(super) path: Path,
    /// Index of the mission's waypoint at which the stretch ends.
    pub(super) last: usize,
    /// Path point i is waypoint `first_waypoint + i`, minus one where the path starts at the boat.
    first_waypoint: usize,
    starts_at_boat: bool,
    /// Arc length at which it is complete, metres.
    complete_m: f64,
    /// The boat goes stern first.
    pub(super) astern: bool,
}

impl Stretch {
    /// From `position` through `waypoints` from `first` to the next stop or circle; none when the boat is at that
    /// stop already.
    ///
    /// # Errors
    /// No path can be laid.
    pub(super) fn from(
        position: NorthEast,
        first: usize,
        waypoints: &[Waypoint],
        places: &[NorthEast],
        limits: &PathLimits,
    ) -> Result<Option<Self>, PathError> {
        let is_end = |waypoint: &Waypoint| waypoint.is_stop() || waypoint.circle.is_some();
        let last = waypoints.iter().skip(first).position(is_end);
        let mut last = last.map_or(waypoints.len().saturating_sub(1), |offset| first + offset);
        let Some(Waypoint { reverse: astern, .. }) = waypoints.get(first).copied() else { return Ok(None) };
        if let Some(circle) = waypoints[last].circle {
            let orbit = Orbit {
                centre: places[last],
                radius_m: circle.radius_m,
                turns: circle.turns,
                clockwise: circle.clockwise,
            };
            let next = (!waypoints[last].is_stop()).then(|| places.get(last + 1).copied()).flatten();
            let is_there = last > first && (places[first] - position).norm() < AT_WAYPOINT_M;
            let points = path_points(position, is_there, &places[first..last]);
            match Path::around(&points, &orbit, next, limits) {
                Err(PathError::InCircle(_)) if last > first => last -= 1,
                path => {
                    let path = path?;
                    // Where the path goes on after the circle, the boat passes its end at speed.
                    let early_m = if next.is_some() { 0.0 } else { ARRIVAL_M };
                    let complete_m = path.waypoint_s_m(points.len()) - early_m;
                    let starts_at_boat = !is_there;
                    return Ok(Some(Self {
                        path,
                        last,
                        first_waypoint: first,
                        starts_at_boat,
                        complete_m,
                        astern,
                    }));
                }
            }
        }
        let is_there = (places[first] - position).norm() < AT_WAYPOINT_M;
        if is_there && first == last {
            return Ok(None);
        }
        let path = Path::through(&path_points(position, is_there, &places[first..=last]), limits)?;
        let complete_m = path.length_m() - ARRIVAL_M;
        Ok(Some(Self { path, last, first_waypoint: first, starts_at_boat: !is_there, complete_m, astern }))
    }

    /// Whether a boat at this arc length has come to its end.
    pub(super) fn is_complete(&self, place_m: f64) -> bool {
        place_m >= self.complete_m
    }

    /// The path's number of the mission's waypoint `index`.
    pub(super) fn point_index(&self, index: usize) -> usize {
        index.saturating_sub(self.first_waypoint) + usize::from(self.starts_at_boat)
    }

    /// Arc length at which the boat is abeam of the mission's waypoint `index`.
    pub(super) fn arc_length_m(&self, index: usize) -> f64 {
        self.path.waypoint_s_m(self.point_index(index))
    }

    /// Where on the path a boat at `position` is that is under way to waypoint `next`.
    pub(super) fn progress_near(&self, position: NorthEast, next: usize) -> f64 {
        let end_m = self.arc_length_m(next.max(self.first_waypoint));
        let start_m = if next > self.first_waypoint { self.arc_length_m(next - 1) } else { 0.0 };
        self.path.project(position, 0.5 * (start_m + end_m)).clamp(start_m, end_m)
    }

    /// Distance still to go to its end, metres.
    pub(super) fn to_go_m(&self, place_m: f64) -> f64 {
        (self.arc_length_m(self.last) - place_m).max(0.0)
    }
}

fn path_points(position: NorthEast, is_there: bool, places: &[NorthEast]) -> Vec<NorthEast> {
    let mut points = Vec::with_capacity(places.len() + 1);
    if !is_there {
        points.push(position);
    }
    points.extend_from_slice(places);
    points
}
