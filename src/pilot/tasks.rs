//! What a mission asks for on the way: when each of it is due.

use std::collections::VecDeque;

use helmlink_mission::route::{Action, Route};

/// Keeps track of the tasks of a route.
#[derive(Debug)]
pub(super) struct TaskList {
    /// The first task that has not been dealt with.
    next: usize,
    /// Time since the last task of this leg was dealt with, seconds.
    waited_s: f64,
    /// The leg whose tasks are being done.
    leg: usize,
    /// Speed that a task of this leg has set; within it, none is the vehicle's own.
    speed_mps: Option<Option<f64>>,
    /// Tasks to be passed on, by their index.
    due: VecDeque<usize>,
}

impl TaskList {
    pub(super) fn new(route: &Route) -> Self {
        // Room for all of them: nothing is allocated under way.
        let due = VecDeque::with_capacity(route.tasks.len());
        Self { next: 0, waited_s: 0.0, leg: 0, speed_mps: None, due }
    }

    /// The boat goes on with waypoint `leg`; what is written before it has been skipped, unless it is the start.
    pub(super) fn jump(&mut self, route: &Route, leg: usize) {
        let first = leg + usize::from(leg > 0);
        *self = Self {
            next: route.tasks.partition_point(|task| task.leg < first),
            waited_s: 0.0,
            leg,
            speed_mps: None,
            due: std::mem::take(&mut self.due),
        };
        self.due.clear();
    }

    /// The boat begins another round at waypoint `leg`: everything written there is done again.
    pub(super) fn repeat_from(&mut self, route: &Route, leg: usize) {
        self.next = route.tasks.partition_point(|task| task.leg < leg);
        self.enter(leg);
    }

    /// The boat is under way to waypoint `leg`, `distance_m` away, `dt_s` after the last call.
    pub(super) fn step(&mut self, route: &Route, leg: usize, dt_s: f64, distance_m: f64) {
        while let Some(task) = route.tasks.get(self.next).filter(|task| task.leg < leg) {
            // Legs that were over before their tasks were due: what waits for a condition is left out, as on
            // ArduPilot.
            if task.leg > self.leg {
                self.enter(task.leg);
            }
            match task.action {
                Action::Command(_) => self.due.push_back(self.next),
                Action::Speed(_) => {}
                Action::Delay(_) | Action::Distance(_) => {
                    self.next = route.tasks.partition_point(|other| other.leg <= task.leg);
                    continue;
                }
            }
            self.next += 1;
        }
        if leg != self.leg {
            self.enter(leg);
        }
        self.waited_s += dt_s;
        while let Some(task) = route.tasks.get(self.next).filter(|task| task.leg == leg) {
            match task.action {
                Action::Delay(delay_s) if self.waited_s < delay_s => return,
                Action::Distance(within_m) if distance_m > within_m => return,
                Action::Delay(_) | Action::Distance(_) => self.waited_s = 0.0,
                Action::Speed(speed_mps) => self.speed_mps = Some(speed_mps),
                Action::Command(_) => self.due.push_back(self.next),
            }
            self.next += 1;
        }
    }

    /// The mission is over: what is written after the last waypoint is done at once.
    pub(super) fn finish(&mut self, route: &Route) {
        self.step(route, route.waypoints.len() + 1, 0.0, 0.0);
    }

    /// The speed that a task of this leg has set, if one has; within it, none is the vehicle's own.
    pub(super) fn speed_mps(&self) -> Option<Option<f64>> {
        self.speed_mps
    }

    /// The next task to be passed on.
    pub(super) fn pop_due(&mut self) -> Option<usize> {
        self.due.pop_front()
    }

    fn enter(&mut self, leg: usize) {
        self.leg = leg;
        self.waited_s = 0.0;
        self.speed_mps = None;
    }
}
