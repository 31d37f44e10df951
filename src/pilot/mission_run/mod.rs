//! One mission being driven.
//!
//! A mission is driven in stretches: a smooth path from where the boat is, through all waypoints up to the next
//! one at which it has to stop, or around which it turns. At each stop the boat keeps its place as long as the
//! mission says, then the next stretch begins at the place where it then is. Stern first, the law steers the
//! boat's mirror image.
//!
//! | module | what it does |
//! |---|---|
//! | `kinds` | what a run is told, and what it tells |
//! | `starting` | taking over, going on elsewhere, the next stretch |
//! | `driving` | along a stretch, and staying at its end |

mod driving;
mod kinds;
mod starting;

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::path::Path;
use helmlink_mission::route::{Route, RouteError, Task};

pub use self::kinds::{Progress, RunError, RunSettings, Step};
use super::stretch::Stretch;
use super::tasks::TaskList;
use crate::control::boat::Actuators;
use crate::control::{Boat, Diagnostics, Helm};
use crate::guidance::{EndOfPath, VesselState};
use crate::vehicle::output::Demand;

/// Steps longer than this are made as if they were this long, seconds: the law must not take a gap for motion.
const LONGEST_STEP_S: f64 = 0.2;
/// Telemetry that stays away for longer than this leaves a gap, seconds: several samples are missing.
const GAP_S: f64 = 2.0 * LONGEST_STEP_S;
/// Steps shorter than this are not made, seconds.
const SHORTEST_STEP_S: f64 = 1e-3;

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
    /// The next stretch begins on the leg to the next waypoint, not with a straight line there.
    joins_leg: bool,
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
            joins_leg: false,
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

    /// Takes over other gains and another usual speed. True when the controller had to be made anew, and has to be
    /// engaged again: what it has learned is kept only by a law that can take over gains.
    pub fn retune(&mut self, boat: &Boat, settings: RunSettings, gains_changed: bool) -> bool {
        self.settings = settings;
        if !gains_changed {
            return false;
        }
        // Guidance and planning are made for their limits; the law alone can take over gains.
        let law_only = self.boat.guidance == boat.guidance && self.boat.limits == boat.limits;
        self.boat = boat.clone();
        let kept = law_only && self.helm.retune(boat);
        if !kept {
            self.helm = Helm::with_controller(boat, settings.controller, EndOfPath::Stop);
        }
        !kept
    }

    /// Drives at this speed over ground from now on, whatever the mission says, m/s; `None` gives the mission its say back.
    pub fn set_speed(&mut self, speed_mps: Option<f64>) {
        self.speed_mps = speed_mps;
    }
}
