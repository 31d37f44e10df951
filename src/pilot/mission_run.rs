//! One mission being driven.
//!
//! A mission is driven in stretches: a smooth path from where the boat is, through all waypoints up to the next
//! one at which it has to stop. At each stop the boat waits as long as the mission says, then the next stretch
//! begins at the place where it then is.

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::path::{Path, PathError};
use helmlink_mission::route::Route;

use crate::control::{Boat, Controller, Diagnostics, Helm, HelmError};
use crate::guidance::{EndOfPath, VesselState};
use crate::vehicle::output::Demand;

/// A stretch that would start closer than this to its first waypoint starts at the waypoint itself, metres.
const AT_WAYPOINT_M: f64 = 1.0;
/// A stretch is complete this far before its last waypoint at the latest, metres: a boat that stops cannot
/// be expected to touch a point.
const ARRIVAL_M: f64 = 0.5;
/// Steps longer than this are made as if they were this long, seconds: the law must not take a gap for motion.
const LONGEST_STEP_S: f64 = 0.2;
/// Steps shorter than this are not made, seconds.
const SHORTEST_STEP_S: f64 = 1e-3;

/// What the user or the vehicle has set for a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunSettings {
    /// Speed over ground on legs for which the mission gives none, m/s.
    pub speed_mps: f64,
    /// The controller.
    pub controller: Controller,
}

/// Where the boat is on its mission.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Index of the waypoint that the boat is under way to.
    pub next: usize,
    /// Number of waypoints.
    pub total: usize,
    /// The leg that the boat is on: i for the one from waypoint i to waypoint i + 1; none on the way to the first.
    /// It changes where the path begins its turn into the next leg.
    pub leg: Option<usize>,
    /// Distance to the right of the smooth path, metres.
    pub cross_track_m: f64,
    /// Distance still to go along this stretch and the straight legs after it, metres.
    pub to_go_m: f64,
    /// Speed over ground, m/s.
    pub speed_mps: f64,
    /// The speed that the mission wants on this leg, m/s.
    pub wanted_speed_mps: f64,
    /// The last waypoint has been reached.
    pub complete: bool,
}

/// What one step gave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// What to send.
    pub demand: Demand,
    /// The waypoints reached with this step: indices from the first up to, not including, the second.
    pub reached: (usize, usize),
    /// What the controller thought.
    pub diagnostics: Diagnostics,
}

/// The path through the waypoints from one stop to the next.
#[derive(Debug)]
struct Stretch {
    path: Path,
    /// Index of the mission's waypoint at which the path ends.
    last: usize,
    /// Path point i is waypoint `offset + i`, minus one where the path starts at the boat.
    first_waypoint: usize,
    starts_at_boat: bool,
}

/// What the boat is doing.
#[derive(Debug)]
enum Phase {
    /// Nothing yet, or told to start anew at a waypoint.
    ToStart,
    /// Driving a stretch.
    Driving(Stretch),
    /// Stopped at a waypoint for so many more seconds.
    Waiting(f64),
    /// The last waypoint has been reached.
    Complete,
}

/// One mission being driven by one boat.
pub struct MissionRun {
    frame: LocalFrame,
    route: Route,
    waypoints: Vec<NorthEast>,
    boat: Boat,
    settings: RunSettings,
    /// Speed that wins over the mission's, m/s.
    speed_mps: Option<f64>,
    helm: Helm,
    phase: Phase,
    next: usize,
    last_step_s: Option<f64>,
    progress: Progress,
    stretches: usize,
}

impl MissionRun {
    /// A run of `route` that has not begun.
    pub fn new(route: Route, boat: Boat, settings: RunSettings) -> Self {
        let origin = route.waypoints.first().map_or_else(|| Geodetic::new(0.0, 0.0), |first| first.position);
        let frame = LocalFrame::new(origin);
        let waypoints: Vec<NorthEast> =
            route.waypoints.iter().map(|point| frame.to_local(point.position)).collect();
        let progress = Progress {
            next: 0,
            total: waypoints.len(),
            leg: None,
            cross_track_m: 0.0,
            to_go_m: 0.0,
            speed_mps: 0.0,
            wanted_speed_mps: settings.speed_mps,
            complete: false,
        };
        let helm = Helm::with_controller(&boat, settings.controller, EndOfPath::Stop);
        Self {
            frame,
            route,
            waypoints,
            boat,
            settings,
            speed_mps: None,
            helm,
            phase: Phase::ToStart,
            next: 0,
            last_step_s: None,
            progress,
            stretches: 0,
        }
    }

    /// The frame in which the run takes positions; its origin is the first waypoint.
    pub fn frame(&self) -> &LocalFrame {
        &self.frame
    }

    /// What is being driven.
    pub fn route(&self) -> &Route {
        &self.route
    }

    /// The waypoints in the local frame.
    pub fn waypoints(&self) -> &[NorthEast] {
        &self.waypoints
    }

    /// The smooth path of the present stretch.
    pub fn path(&self) -> Option<&Path> {
        match &self.phase {
            Phase::Driving(stretch) => Some(&stretch.path),
            _ => None,
        }
    }

    /// How many stretches have been started; a change means that [`Self::path`] is another one.
    pub fn stretches(&self) -> usize {
        self.stretches
    }

    /// Where the boat is on its mission.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// Takes over from another controller: everything that the law has integrated starts anew, the place in the
    /// mission is kept.
    pub fn engage(&mut self, state: &VesselState) -> Result<(), HelmError> {
        self.last_step_s = None;
        let progress_m = match &self.phase {
            Phase::Driving(stretch) => stretch.progress_near(state.position, self.next),
            _ => 0.0,
        };
        self.helm.engage(state, progress_m)
    }

    /// Goes on with waypoint `index`, from wherever the boat is. An index past the last one is ignored.
    pub fn jump_to(&mut self, index: usize) {
        if index < self.waypoints.len() {
            self.next = index;
            self.phase = Phase::ToStart;
            self.progress.next = index;
            self.progress.complete = false;
        }
    }

    /// One step at vehicle time `boot_s`, with the boat in `state`.
    ///
    /// # Errors
    /// The state is not a number or absurd; the boat must be stopped.
    pub fn step(&mut self, boot_s: f64, state: &VesselState) -> Result<Step, RunError> {
        let dt_s = self.last_step_s.map_or(SHORTEST_STEP_S, |last_s| boot_s - last_s);
        let dt_s = dt_s.clamp(SHORTEST_STEP_S, LONGEST_STEP_S);
        self.last_step_s = Some(boot_s);
        let before = self.next;
        if matches!(self.phase, Phase::ToStart) {
            self.start_stretch(state)?;
        }
        let mut step =
            Step { demand: Demand::NEUTRAL, reached: (before, before), diagnostics: Diagnostics::default() };
        match &mut self.phase {
            Phase::Driving(_) => self.drive(dt_s, state, &mut step)?,
            Phase::Waiting(left_s) => {
                *left_s -= dt_s;
                if *left_s <= 0.0 {
                    self.phase = Phase::ToStart;
                }
            }
            Phase::ToStart | Phase::Complete => {}
        }
        step.reached = (before, self.next);
        self.progress.next = self.next.min(self.waypoints.len().saturating_sub(1));
        self.progress.complete = matches!(self.phase, Phase::Complete);
        Ok(step)
    }

    fn drive(&mut self, dt_s: f64, state: &VesselState, step: &mut Step) -> Result<(), RunError> {
        let Phase::Driving(stretch) = &self.phase else { return Ok(()) };
        let wanted_mps = self.leg_speed_mps(self.next).min(self.boat.limits.speed_max_mps);
        let output = self.helm.step(dt_s, state, &stretch.path, wanted_mps)?;
        let reference = &output.diagnostics.reference;
        step.diagnostics = output.diagnostics;
        step.demand = Demand {
            throttle: output.command.throttle,
            steering: output.command.steering,
            speed_mps: output.diagnostics.law.alpha_u_mps,
            yaw_rate_radps: output.diagnostics.law.alpha_r_radps,
        };
        let place_m = reference.progress_m;
        while self.next < stretch.last && place_m >= stretch.arc_length_m(self.next) {
            self.next += 1;
        }
        let has_left = place_m >= stretch.path.leaving_s_m(stretch.point_index(self.next));
        self.progress.leg = if has_left { Some(self.next) } else { self.next.checked_sub(1) };
        let to_stop_m = stretch.path.length_m() - place_m;
        self.progress.cross_track_m = reference.cross_track_m;
        self.progress.speed_mps = state.surge_mps.hypot(state.sway_mps);
        self.progress.wanted_speed_mps = wanted_mps;
        self.progress.to_go_m = to_stop_m.max(0.0) + self.straight_distance_m(stretch.last);
        if reference.finished || to_stop_m <= ARRIVAL_M {
            self.arrive(stretch.last);
        }
        Ok(())
    }

    /// The boat has come to the end of a stretch, at waypoint `index`.
    fn arrive(&mut self, index: usize) {
        self.next = index + 1;
        self.phase = if self.next < self.waypoints.len() {
            Phase::Waiting(self.route.waypoints[index].hold_s)
        } else {
            Phase::Complete
        };
    }

    fn start_stretch(&mut self, state: &VesselState) -> Result<(), RunError> {
        let last = (self.next..self.waypoints.len())
            .find(|&index| self.route.waypoints[index].hold_s > 0.0)
            .unwrap_or(self.waypoints.len().saturating_sub(1));
        let Some(first) = self.waypoints.get(self.next) else {
            self.phase = Phase::Complete;
            return Ok(());
        };
        let is_there = (*first - state.position).norm() < AT_WAYPOINT_M;
        if is_there && self.next == last {
            self.arrive(last);
            return Ok(());
        }
        let mut points = Vec::with_capacity(self.waypoints.len() + 1);
        if !is_there {
            points.push(state.position);
        }
        points.extend_from_slice(&self.waypoints[self.next..=last]);
        let path = Path::through(&points, &self.boat.limits.path())?;
        let stretch = Stretch { path, last, first_waypoint: self.next, starts_at_boat: !is_there };
        self.helm.engage(state, 0.0)?;
        self.phase = Phase::Driving(stretch);
        self.stretches += 1;
        Ok(())
    }

    /// Takes over other gains and another usual speed. True when the controller had to be made anew, and has to be
    /// engaged again: what it has learned is kept only by a law that can take over gains.
    pub fn retune(&mut self, boat: &Boat, settings: RunSettings, gains_changed: bool) -> bool {
        self.settings = settings;
        if !gains_changed {
            return false;
        }
        self.boat = boat.clone();
        let kept = self.helm.retune(boat);
        if !kept {
            self.helm = Helm::with_controller(boat, settings.controller, EndOfPath::Stop);
        }
        !kept
    }

    /// Drives at this speed over ground from now on, whatever the mission says, m/s; `None` gives the mission its say back.
    pub fn set_speed(&mut self, speed_mps: Option<f64>) {
        self.speed_mps = speed_mps;
    }

    /// The speed wanted on the leg to waypoint `index`.
    fn leg_speed_mps(&self, index: usize) -> f64 {
        if let Some(speed_mps) = self.speed_mps {
            return speed_mps;
        }
        let given = self.route.waypoints.get(index).and_then(|waypoint| waypoint.speed_mps);
        given.unwrap_or(self.settings.speed_mps)
    }

    fn straight_distance_m(&self, from: usize) -> f64 {
        self.waypoints[from.min(self.waypoints.len())..].windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum()
    }
}

impl Stretch {
    /// The path's number of the mission's waypoint `index`.
    fn point_index(&self, index: usize) -> usize {
        index.saturating_sub(self.first_waypoint) + usize::from(self.starts_at_boat)
    }

    /// Arc length at which the boat is abeam of the mission's waypoint `index`.
    fn arc_length_m(&self, index: usize) -> f64 {
        self.path.waypoint_s_m(self.point_index(index))
    }

    /// Where on the path a boat at `position` is that is under way to waypoint `next`.
    fn progress_near(&self, position: NorthEast, next: usize) -> f64 {
        let end_m = self.arc_length_m(next.max(self.first_waypoint));
        let start_m = if next > self.first_waypoint { self.arc_length_m(next - 1) } else { 0.0 };
        self.path.project(position, 0.5 * (start_m + end_m)).clamp(start_m, end_m)
    }
}

/// Why a step could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The controller refused.
    #[error(transparent)]
    Helm(#[from] HelmError),
    /// No path could be laid.
    #[error(transparent)]
    Path(#[from] PathError),
}
