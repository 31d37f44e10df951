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
    /// Path point i is waypoint `first_waypoint + i`, minus the points before it.
    first_waypoint: usize,
    /// Points of the path before its first waypoint.
    lead_count: usize,
    /// Arc length at which it is complete, metres.
    complete_m: f64,
    /// The boat goes stern first.
    pub(super) astern: bool,
}

impl Stretch {
    /// From a boat at `position`, by the points of `lead`, through `waypoints` from `first` to the next stop or circle;
    /// none when the boat is at that stop already.
    ///
    /// # Errors
    /// No path can be laid.
    pub(super) fn from(
        position: NorthEast,
        lead: &[NorthEast],
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
            let lead = if is_there { &[] } else { lead };
            let points = [lead, &places[first..last]].concat();
            match Path::around(&points, &orbit, next, limits) {
                Err(PathError::InCircle(_)) if last > first => last -= 1,
                path => {
                    let path = path?;
                    // Where the path goes on after the circle, the boat passes its end at speed.
                    let early_m = if next.is_some() { 0.0 } else { ARRIVAL_M };
                    let complete_m = path.waypoint_s_m(points.len()) - early_m;
                    let (first_waypoint, lead_count) = (first, lead.len());
                    return Ok(Some(Self { path, last, first_waypoint, lead_count, complete_m, astern }));
                }
            }
        }
        let is_there = (places[first] - position).norm() < AT_WAYPOINT_M;
        if is_there && first == last {
            return Ok(None);
        }
        let lead = if is_there { &[] } else { lead };
        let path = Path::through(&[lead, &places[first..=last]].concat(), limits)?;
        let complete_m = path.length_m() - ARRIVAL_M;
        let (first_waypoint, lead_count) = (first, lead.len());
        Ok(Some(Self { path, last, first_waypoint, lead_count, complete_m, astern }))
    }

    /// Whether a boat at this arc length has come to its end.
    pub(super) fn is_complete(&self, place_m: f64) -> bool {
        place_m >= self.complete_m
    }

    /// The path's number of the mission's waypoint `index`.
    pub(super) fn point_index(&self, index: usize) -> usize {
        index.saturating_sub(self.first_waypoint) + self.lead_count
    }

    /// The leg of the mission at this arc length, for a boat under way to waypoint `next`: i for the one from waypoint i
    /// on, none before the first. It changes where the path leaves the leg before, even if its waypoint has counted as
    /// reached earlier.
    pub(super) fn leg_at(&self, place_m: f64, next: usize) -> Option<usize> {
        let has_left = |index: usize| place_m >= self.path.leaving_s_m(self.point_index(index));
        if has_left(next) {
            Some(next)
        } else if next > self.first_waypoint && !has_left(next - 1) {
            next.checked_sub(2)
        } else {
            next.checked_sub(1)
        }
    }

    /// Arc length at which the boat is abeam of the mission's waypoint `index`.
    pub(super) fn arc_length_m(&self, index: usize) -> f64 {
        self.path.waypoint_s_m(self.point_index(index))
    }

    /// Where on the path a boat at `position` is that is under way to waypoint `next`.
    pub(super) fn progress_near(&self, position: NorthEast, next: usize) -> f64 {
        let end_m = self.arc_length_m(next.max(self.first_waypoint));
        let start_m = if next > self.first_waypoint { self.arc_length_m(next - 1) } else { 0.0 };
        let middle_m = 0.5 * (start_m + end_m);
        self.path.project_within(position, middle_m, end_m - start_m).clamp(start_m, end_m)
    }

    /// Distance of a position from the path at an arc length, metres.
    pub(super) fn distance_m(&self, position: NorthEast, place_m: f64) -> f64 {
        (position - self.path.point(place_m).position).norm()
    }

    /// Distance still to go to its end, metres.
    pub(super) fn to_go_m(&self, place_m: f64) -> f64 {
        (self.arc_length_m(self.last) - place_m).max(0.0)
    }
}
