//! What a mission will be like for a boat: its path, its length and time, and what is awkward about it.

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::path::{Corner, Orbit, Path};
use helmlink_mission::plan::Fence;
use helmlink_mission::route::{Route, Waypoint};
use serde::Serialize;

use crate::control::Boat;

/// Spacing of the points that a path is looked at, metres.
const SPACING_M: f64 = 1.0;
/// At most so many points a path: long missions are looked at more coarsely.
const MOST_POINTS: f64 = 20_000.0;

/// How serious a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Level {
    /// The mission should not be driven so.
    Problem,
    /// It will be driven, but not quite as drawn.
    Warning,
    /// Worth knowing.
    Note,
}

/// Something worth knowing about a mission.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Finding {
    pub(super) level: Level,
    /// Number of the item, where it is about one.
    pub(super) item: Option<u16>,
    pub(super) text: String,
}

/// What was found out about a mission.
#[derive(Debug, Clone)]
pub(super) struct Review {
    pub(super) findings: Vec<Finding>,
    /// Along the smooth path, metres; one round of a mission that never ends.
    pub(super) length_m: f64,
    /// About, seconds.
    pub(super) duration_s: f64,
    /// The smooth path, in the frame of `frame`.
    pub(super) path: Vec<NorthEast>,
    pub(super) frame: LocalFrame,
    /// The waypoints in the same frame.
    pub(super) waypoints: Vec<NorthEast>,
}

/// Looks at how `boat` will drive `route` at `speed_mps`, where the mission gives no speed.
pub(super) fn review(route: &Route, fence: &Fence, boat: &Boat, speed_mps: f64) -> Review {
    let first = route.waypoints.first().map(|waypoint| waypoint.position);
    let frame = LocalFrame::new(route.home.or(first).unwrap_or_default());
    let mut reviewer = Reviewer {
        route,
        boat,
        speed_mps,
        review: Review {
            findings: Vec::new(),
            length_m: 0.0,
            duration_s: route.start_delay_s,
            path: Vec::new(),
            frame,
            waypoints: route.local_points(&frame),
        },
        position: route.home.map(|home| frame.to_local(home)),
    };
    reviewer.drive();
    reviewer.check_fence(fence);
    reviewer.check_rest();
    reviewer.review
}

struct Reviewer<'a> {
    route: &'a Route,
    boat: &'a Boat,
    speed_mps: f64,
    review: Review,
    /// Where the boat is, when that is known.
    position: Option<NorthEast>,
}

impl Reviewer<'_> {
    /// Follows the mission from stop to stop.
    fn drive(&mut self) {
        let waypoints = &self.route.waypoints;
        let is_end = |waypoint: &Waypoint| waypoint.is_stop() || waypoint.circle.is_some();
        let mut first = 0;
        while first < waypoints.len() {
            let last = waypoints[first..].iter().position(is_end).map_or(waypoints.len() - 1, |n| first + n);
            self.stretch(first, last);
            let waypoint = &waypoints[last];
            self.review.duration_s += waypoint.hold_s;
            if waypoint.is_stop() || last + 1 == waypoints.len() {
                // Slowing down and speeding up again take about this much longer than passing.
                self.review.duration_s += self.leg_speed_mps(last) / self.boat.limits.deceleration_mps2;
            }
            first = last + 1;
        }
    }

    fn stretch(&mut self, first: usize, last: usize) {
        let places = &self.review.waypoints;
        let circle = self.route.waypoints[last].circle;
        let end = if circle.is_some() { last } else { last + 1 };
        let mut points: Vec<NorthEast> = self.position.into_iter().collect();
        for place in &places[first..end] {
            if points.last().is_none_or(|known| (*place - *known).norm() >= helmlink_mission::path::MIN_LEG_M)
            {
                points.push(*place);
            }
        }
        // Path point i is waypoint i − before + first.
        let before = points.len() - (end - first).min(points.len());
        let limits = self.boat.limits.path();
        let path = match circle {
            Some(circle) => {
                let orbit = Orbit {
                    centre: places[last],
                    radius_m: circle.radius_m,
                    turns: circle.turns,
                    clockwise: circle.clockwise,
                };
                if points.is_empty() {
                    points.push(orbit.centre);
                }
                let next = places.get(last + 1).copied();
                let around = Path::around(&points, &orbit, next, &limits);
                self.check_circle(last, circle.radius_m);
                around.or_else(|_| Path::around(&points[points.len() - 1..], &orbit, next, &limits)).ok()
            }
            None if points.len() > 1 => Path::through(&points, &limits).ok(),
            None => None,
        };
        let Some(path) = path else {
            self.position = points.last().copied().or(self.position);
            return;
        };
        for corner in path.corners() {
            if let Some(index) = (corner.waypoint + first).checked_sub(before).filter(|index| *index < end) {
                self.check_corner(index, corner, &path);
            }
        }
        let length_m = if circle.is_some() { path.waypoint_s_m(points.len()) } else { path.length_m() };
        self.follow(&path, length_m, first, before);
        self.position = Some(path.point(length_m).position);
    }

    /// Adds a path to the length, the time and the picture.
    fn follow(&mut self, path: &Path, length_m: f64, first: usize, before: usize) {
        let count = (length_m / SPACING_M).ceil().clamp(1.0, MOST_POINTS);
        let step_m = length_m / count;
        self.review.length_m += length_m;
        for index in 0..=count as usize {
            let s_m = index as f64 * step_m;
            let point = path.point(s_m);
            self.review.path.push(point.position);
            let leg = (path.leg_at(s_m) + 1 + first).saturating_sub(before);
            let wanted_mps = self.leg_speed_mps(leg.min(self.route.waypoints.len() - 1));
            if index > 0 {
                self.review.duration_s += step_m / wanted_mps.min(self.bend_speed_mps(point.curvature_radpm));
            }
        }
    }

    fn leg_speed_mps(&self, index: usize) -> f64 {
        let given = self.route.waypoints.get(index).and_then(|waypoint| waypoint.speed_mps);
        given.unwrap_or(self.speed_mps).min(self.boat.limits.speed_max_mps)
    }

    /// How fast a bend can be run, in still water.
    fn bend_speed_mps(&self, curvature_radpm: f64) -> f64 {
        let limits = &self.boat.limits;
        let curvature = curvature_radpm.abs().max(1e-9);
        (limits.turn_rate_radps / curvature).min((limits.lateral_acceleration_mps2 / curvature).sqrt())
    }

    fn check_corner(&mut self, index: usize, corner: &Corner, path: &Path) {
        let waypoint = self.route.waypoints[index];
        let degrees = corner.turn_rad.to_degrees().abs();
        if corner.scale < 1.0 {
            let points = path.points();
            let legs_m =
                [corner.waypoint, corner.waypoint + 1].map(|end| (points[end] - points[end - 1]).norm());
            let needs_m = corner.tangent_m / corner.scale;
            let speed_mps = self.bend_speed_mps(1.0 / corner.radius_m);
            let short_m = legs_m[0].min(legs_m[1]);
            let text = format!(
                "the turn of {degrees:.0}° needs {needs_m:.1} m of each leg, but half of the shorter one is {:.1} m: it \
                 is drawn tighter, with a radius of {:.1} m, and run at {speed_mps:.1} m/s",
                0.5 * short_m,
                corner.radius_m
            );
            self.find(Level::Warning, Some(waypoint.item), text);
            if speed_mps < self.boat.limits.steerage_mps {
                let text = format!(
                    "the boat cannot follow this corner: so slow ({speed_mps:.1} m/s) it does not steer; it will overshoot"
                );
                self.find(Level::Problem, Some(waypoint.item), text);
            }
        }
        if let Some(radius_m) = waypoint.acceptance_radius_m.filter(|radius_m| corner.cut_m > *radius_m) {
            let text = format!(
                "the turn of {degrees:.0}° passes {:.1} m inside of the waypoint, more than its acceptance radius of {radius_m} m",
                corner.cut_m
            );
            self.find(Level::Warning, Some(waypoint.item), text);
        }
    }

    fn check_circle(&mut self, index: usize, radius_m: f64) {
        let least_m = self.boat.limits.turn_radius_m;
        let speed_mps = self.bend_speed_mps(1.0 / radius_m);
        let item = Some(self.route.waypoints[index].item);
        if radius_m < least_m {
            let text = format!(
                "a circle of {radius_m:.1} m is tighter than this boat's turning circle of {least_m:.1} m: it is run at {speed_mps:.1} m/s"
            );
            let cannot = speed_mps < self.boat.limits.steerage_mps;
            self.find(if cannot { Level::Problem } else { Level::Warning }, item, text);
        }
    }

    fn check_fence(&mut self, fence: &Fence) {
        let frame = self.review.frame;
        let places: Vec<Geodetic> = self.review.path.iter().map(|place| frame.to_geodetic(*place)).collect();
        let mut told = Vec::new();
        for (index, leg) in places.windows(2).enumerate() {
            let Some(area) = fence.crossed_by(leg[0], leg[1]) else { continue };
            if told.contains(&area) {
                continue;
            }
            told.push(area);
            let how = if fence.areas[area - 1].inclusion { "leaves" } else { "enters" };
            let item = self.nearest_item(self.review.path[index]);
            let text = format!("the path {how} area {area} of the fence, near {}", leg[0]);
            self.find(Level::Problem, item, text);
        }
    }

    fn nearest_item(&self, place: NorthEast) -> Option<u16> {
        let distance = |index: &usize| (self.review.waypoints[*index] - place).norm();
        let nearest = (0..self.review.waypoints.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        Some(self.route.waypoints[nearest].item)
    }

    fn check_rest(&mut self) {
        if let Err(error) = crate::pilot::MissionRun::check(self.route, self.boat) {
            self.find(Level::Problem, None, error.to_string());
        }
        let most_mps = self.boat.limits.speed_max_mps;
        let mut last = None;
        for waypoint in &self.route.waypoints {
            if let Some(speed_mps) =
                waypoint.speed_mps.filter(|speed| *speed > most_mps && last != Some(*speed))
            {
                last = Some(speed_mps);
                let text =
                    format!("{speed_mps:.1} m/s is more than this boat makes: it will run {most_mps:.1} m/s");
                self.find(Level::Warning, Some(waypoint.item), text);
            }
        }
        for item in &self.route.unreached {
            self.find(
                Level::Warning,
                Some(*item),
                "it is never carried out: a jump leads past it".to_owned(),
            );
        }
        if self.route.repeat_from.is_some() {
            let text = "the mission never ends: length and time are those of one round".to_owned();
            self.find(Level::Note, None, text);
        }
        if self.route.home.is_none() {
            let text = "home is not known: the way to the first waypoint is not counted".to_owned();
            self.find(Level::Note, None, text);
        }
    }

    fn find(&mut self, level: Level, item: Option<u16>, text: String) {
        let finding = Finding { level, item, text };
        // A mission with jumps comes by the same place again.
        if !self.review.findings.contains(&finding) {
            self.review.findings.push(finding);
        }
    }
}
