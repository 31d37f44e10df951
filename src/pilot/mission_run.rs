//! One mission being driven.
//!
//! A mission is driven in stretches: a smooth path from where the boat is, through all waypoints up to the next
//! one at which it has to stop, or around which it turns. At each stop the boat keeps its place as long as the
//! mission says, then the next stretch begins at the place where it then is. Stern first, the law steers the
//! boat's mirror image.

use std::f64::consts::PI;

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::path::{Path, PathError};
use helmlink_mission::route::{MERGE_DISTANCE_M, Route, RouteError, Task};

use super::stretch::{AT_WAYPOINT_M, Stretch};
use super::tasks::TaskList;
use crate::control::boat::Actuators;
use crate::control::{Boat, Controller, Diagnostics, Helm, HelmError};
use crate::guidance::{EndOfPath, VesselState};
use crate::vehicle::output::Demand;

/// A boat that waits lets itself drift this far before it drives back, metres, or its turning radius if that is
/// larger: less would keep it turning all the time.
const KEEP_WITHIN_M: f64 = 2.0;
/// Stern first, the boat is not asked for more than this part of its largest speed: thrusters push worse astern.
const ASTERN_SPEED_PART: f64 = 0.4;
/// Steps longer than this are made as if they were this long, seconds: the law must not take a gap for motion.
const LONGEST_STEP_S: f64 = 0.2;
/// Telemetry that stays away for longer than this leaves a gap, seconds: several samples are missing.
const GAP_S: f64 = 2.0 * LONGEST_STEP_S;
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

/// What the boat is doing.
#[derive(Debug)]
enum Phase {
    /// Nothing yet, or told to start anew at a waypoint.
    ToStart,
    /// Driving a stretch.
    Driving(Stretch),
    /// Keeping its place for so many more seconds, driving back to it when it has drifted.
    Waiting { place: NorthEast, left_s: f64, back: Option<Path> },
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
    tasks: TaskList,
    /// The delay before setting out is over.
    has_set_out: bool,
    /// The waypoint at which the boat has stopped.
    arrived_at: Option<usize>,
    last_step_s: Option<f64>,
    progress: Progress,
    stretches: usize,
}

impl MissionRun {
    /// Whether `boat` can drive `route`.
    ///
    /// # Errors
    /// The item that it cannot carry out.
    pub fn check(route: &Route, boat: &Boat) -> Result<(), RouteError> {
        let can_go_astern = matches!(boat.actuators, Actuators::TwinThrusters(_));
        match route.waypoints.iter().find(|waypoint| waypoint.reverse && !can_go_astern) {
            Some(waypoint) => Err(RouteError::Astern { item: waypoint.item }),
            None => Ok(()),
        }
    }

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
        let tasks = TaskList::new(&route);
        Self {
            tasks,
            has_set_out: false,
            arrived_at: None,
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

    /// Tells the time from a measurement to the effect of the command made from it, seconds; see
    /// [`Helm::set_delay_s`].
    pub fn set_delay_s(&mut self, delay_s: f64) {
        self.helm.set_delay_s(delay_s);
    }

    /// The law and what it has found out about boat and sensors.
    pub fn helm(&self) -> &Helm {
        &self.helm
    }

    /// Takes over from another controller: everything that the law has integrated starts anew, the place in the
    /// mission is kept.
    pub fn engage(&mut self, state: &VesselState) -> Result<(), HelmError> {
        self.last_step_s = None;
        match &mut self.phase {
            Phase::Driving(stretch) => {
                let progress_m = stretch.progress_near(state.position, self.next);
                self.helm.engage(&facing(state, stretch.astern), progress_m)
            }
            Phase::Waiting { back, .. } => {
                *back = None;
                self.helm.engage(state, 0.0)
            }
            Phase::ToStart | Phase::Complete => self.helm.engage(state, 0.0),
        }
    }

    /// Goes on with waypoint `index`, from wherever the boat is; what the mission asks for on the way to it is
    /// left out, unless it is the first. An index past the last one is ignored.
    pub fn jump_to(&mut self, index: usize) {
        if index < self.waypoints.len() {
            self.next = index;
            self.phase = Phase::ToStart;
            self.has_set_out = index > 0;
            self.arrived_at = None;
            self.tasks.jump(&self.route, index);
            self.progress.next = index;
            self.progress.complete = false;
        }
    }

    /// The next thing to be passed on to the flight controller.
    pub fn pop_due_task(&mut self) -> Option<Task> {
        let index = self.tasks.pop_due()?;
        self.route.tasks.get(index).copied()
    }

    /// One step at vehicle time `boot_s`, with the boat in `state`.
    ///
    /// # Errors
    /// The state is not a number or absurd; the boat must be stopped.
    pub fn step(&mut self, boot_s: f64, state: &VesselState) -> Result<Step, RunError> {
        let since_s = self.last_step_s.map_or(SHORTEST_STEP_S, |last_s| boot_s - last_s);
        if since_s > GAP_S {
            self.helm.bridge_gap(since_s - LONGEST_STEP_S);
        }
        let dt_s = since_s.clamp(SHORTEST_STEP_S, LONGEST_STEP_S);
        self.last_step_s = Some(boot_s);
        let before = self.next;
        if matches!(self.phase, Phase::ToStart) {
            self.start_stretch(state)?;
        }
        let mut step =
            Step { demand: Demand::NEUTRAL, reached: (before, before), diagnostics: Diagnostics::default() };
        match self.phase {
            Phase::Driving(_) => self.drive(dt_s, state, &mut step)?,
            Phase::Waiting { .. } => self.wait(dt_s, state, &mut step)?,
            Phase::ToStart | Phase::Complete => {}
        }
        step.reached = (before, self.next);
        if matches!(self.phase, Phase::Complete) {
            self.tasks.finish(&self.route);
        }
        if self.next >= self.waypoints.len()
            && let Some(first) = self.route.repeat_from
        {
            // Another round of a mission that never ends.
            self.next = first;
            self.tasks.repeat_from(&self.route, first);
        }
        self.progress.next = self.next.min(self.waypoints.len().saturating_sub(1));
        self.progress.complete = matches!(self.phase, Phase::Complete);
        Ok(step)
    }

    fn drive(&mut self, dt_s: f64, state: &VesselState, step: &mut Step) -> Result<(), RunError> {
        let Phase::Driving(stretch) = &self.phase else { return Ok(()) };
        let to_next_m = (self.waypoints[self.next] - state.position).norm();
        self.tasks.step(&self.route, self.next, dt_s, to_next_m);
        let wanted_mps = self.leg_speed_mps(stretch.astern);
        let output = self.helm.step(dt_s, &facing(state, stretch.astern), &stretch.path, wanted_mps)?;
        let reference = &output.diagnostics.reference;
        step.diagnostics = output.diagnostics;
        step.demand = Demand {
            throttle: output.command.throttle,
            steering: output.command.steering,
            speed_mps: output.diagnostics.law.alpha_u_mps,
            // The firmware divides its steering by the speed over ground: with the current it steers too little.
            yaw_rate_radps: output.diagnostics.law.alpha_r_radps
                * if self.boat.steers_by_flow() { output.diagnostics.ground_per_water } else { 1.0 },
        };
        if stretch.astern {
            step.demand.throttle = -step.demand.throttle;
            step.demand.speed_mps = -step.demand.speed_mps;
        }
        let place_m = reference.progress_m;
        while self.next < stretch.last && self.has_reached(stretch, place_m, state.position) {
            self.next += 1;
        }
        let has_left = place_m >= stretch.path.leaving_s_m(stretch.point_index(self.next));
        self.progress.leg = if has_left { Some(self.next) } else { self.next.checked_sub(1) };
        self.progress.cross_track_m = reference.cross_track_m;
        self.progress.speed_mps = state.surge_mps.hypot(state.sway_mps);
        self.progress.wanted_speed_mps = wanted_mps;
        self.progress.to_go_m = stretch.to_go_m(place_m) + self.straight_distance_m(stretch.last);
        if reference.finished || stretch.is_complete(place_m) {
            self.arrive(stretch.last);
        }
        Ok(())
    }

    /// Whether the next waypoint, one of those that are passed, has been: abeam of it, or within its acceptance
    /// radius.
    fn has_reached(&self, stretch: &Stretch, place_m: f64, position: NorthEast) -> bool {
        let left_m = stretch.arc_length_m(self.next) - place_m;
        let radius_m = self.route.waypoints[self.next].acceptance_radius_m.unwrap_or(0.0);
        // Along the path as well: another leg may pass close by.
        left_m <= 0.0 || (left_m <= radius_m && (self.waypoints[self.next] - position).norm() <= radius_m)
    }

    /// Keeps the place: lets the boat drift a little, then drives it back.
    fn wait(&mut self, dt_s: f64, state: &VesselState, step: &mut Step) -> Result<(), RunError> {
        let wanted_mps = self.settings.speed_mps.min(self.boat.limits.cruise_mps);
        let Phase::Waiting { place, left_s, back } = &mut self.phase else { return Ok(()) };
        *left_s -= dt_s;
        if *left_s <= 0.0 {
            self.phase = Phase::ToStart;
            return Ok(());
        }
        let off_m = (*place - state.position).norm();
        self.progress.cross_track_m = 0.0;
        self.progress.speed_mps = state.surge_mps.hypot(state.sway_mps);
        if back.is_none() && off_m > KEEP_WITHIN_M.max(self.boat.limits.turn_radius_m) {
            *back = Some(Path::through(&[state.position, *place], &self.boat.limits.path())?);
            self.helm.engage(state, 0.0)?;
        }
        if let Some(path) = back {
            let output = self.helm.step(dt_s, state, path, wanted_mps)?;
            step.diagnostics = output.diagnostics;
            step.demand = Demand {
                throttle: output.command.throttle,
                steering: output.command.steering,
                speed_mps: output.diagnostics.law.alpha_u_mps,
                yaw_rate_radps: output.diagnostics.law.alpha_r_radps,
            };
            if output.diagnostics.reference.finished || off_m < AT_WAYPOINT_M {
                *back = None;
            }
        }
        Ok(())
    }

    /// The boat has come to the end of a stretch, at waypoint `index`.
    fn arrive(&mut self, index: usize) {
        let hold_s = self.route.waypoints[index].hold_s;
        self.arrived_at = Some(index);
        self.next = index + 1;
        self.phase = if hold_s > 0.0 {
            Phase::Waiting { place: self.waypoints[index], left_s: hold_s, back: None }
        } else if self.next < self.waypoints.len() || self.route.repeat_from.is_some() {
            Phase::ToStart
        } else {
            Phase::Complete
        };
    }

    fn start_stretch(&mut self, state: &VesselState) -> Result<(), RunError> {
        if !std::mem::replace(&mut self.has_set_out, true) && self.route.start_delay_s > 0.0 {
            let left_s = self.route.start_delay_s;
            self.phase = Phase::Waiting { place: state.position, left_s, back: None };
            return Ok(());
        }
        if self.next >= self.waypoints.len() {
            self.phase = Phase::Complete;
            return Ok(());
        }
        if self.is_same_place_again() {
            self.arrive_at_once();
            return Ok(());
        }
        let limits = self.boat.limits.path();
        match Stretch::from(state.position, self.next, &self.route.waypoints, &self.waypoints, &limits)? {
            Some(stretch) => {
                self.helm.engage(&facing(state, stretch.astern), 0.0)?;
                self.arrived_at = None;
                self.phase = Phase::Driving(stretch);
                self.stretches += 1;
            }
            None => self.arrive_at_once(),
        }
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

    /// The next waypoint is where the boat has just arrived: it has not to touch the place once more.
    fn is_same_place_again(&self) -> bool {
        let Some(arrived) = self.arrived_at else { return false };
        let apart_m = (self.waypoints[self.next] - self.waypoints[arrived]).norm();
        apart_m < MERGE_DISTANCE_M && self.route.waypoints[self.next].circle.is_none()
    }

    /// There already: what is to be done on the way is due at once.
    fn arrive_at_once(&mut self) {
        self.tasks.step(&self.route, self.next, 0.0, 0.0);
        self.arrive(self.next);
    }

    /// The speed wanted on the leg to the next waypoint.
    fn leg_speed_mps(&self, astern: bool) -> f64 {
        let given = self.route.waypoints.get(self.next).and_then(|waypoint| waypoint.speed_mps);
        let given = self.speed_mps.or(self.tasks.speed_mps().unwrap_or(given));
        let most_mps = self.boat.limits.speed_max_mps * if astern { ASTERN_SPEED_PART } else { 1.0 };
        given.unwrap_or(self.settings.speed_mps).min(most_mps)
    }

    fn straight_distance_m(&self, from: usize) -> f64 {
        self.waypoints[from.min(self.waypoints.len())..].windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum()
    }
}

/// The boat as the law is to see it: as it is, or its mirror image with the bow where the stern is.
fn facing(state: &VesselState, astern: bool) -> VesselState {
    if !astern {
        return *state;
    }
    VesselState {
        heading_rad: ssa(state.heading_rad + PI),
        surge_mps: -state.surge_mps,
        sway_mps: -state.sway_mps,
        ..*state
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
