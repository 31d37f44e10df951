//! Walks through a mission as a boat will, jumps included, and writes down where it goes.

use std::collections::HashMap;

use super::read::{Step, Visit};
use super::{Action, Ending, MAX_DISTANCE_M, MERGE_DISTANCE_M, Route, RouteError, Task, Waypoint};
use crate::geodesy::Geodetic;
use crate::plan::CommandName;

/// Waypoints, repetitions included, that a mission may have: more than MAVLink can number.
const MOST_VISITS: usize = 65_535;
/// Items, repetitions included, that are walked through.
const MOST_STEPS: usize = 1_000_000;

/// Everything that decides how a mission goes on at a jump, and how many waypoints had been visited there.
struct Pass {
    jumps_made: HashMap<usize, u32>,
    speed_mps: Option<f64>,
    reverse: bool,
    visits: usize,
}

/// A mission being walked through.
pub(super) struct Walk {
    route: Route,
    /// Speed after the last change, also one that waits for a condition.
    speed_mps: Option<f64>,
    /// Speed of the next leg from its beginning.
    leg_speed_mps: Option<f64>,
    reverse: bool,
    has_condition: bool,
    jumps_made: HashMap<usize, u32>,
    /// The last pass of each jump that never ends. Jumps only ever get used up, so what differs from the last
    /// pass has never been before.
    passes: HashMap<usize, Pass>,
}

/// How the walk goes on.
enum Next {
    Following,
    Item(u16),
    End,
}

impl Walk {
    /// The route of the items' `steps`.
    pub(super) fn through(
        home: Option<Geodetic>,
        steps: &[(CommandName, Step)],
    ) -> Result<Route, RouteError> {
        let mut walk = Self::new(home);
        let mut walked = vec![false; steps.len()];
        let mut ended_by = None;
        let mut index = 0;
        for count in 0.. {
            let Some((_, step)) = steps.get(index) else { break };
            let number = (index + 1) as u16;
            if count >= MOST_STEPS {
                return Err(RouteError::TooManyVisits { item: number });
            }
            walked[index] = true;
            match walk.take(number, step)? {
                Next::Following => index += 1,
                Next::Item(to) => index = usize::from(to) - 1,
                Next::End => {
                    ended_by = Some(number);
                    break;
                }
            }
        }
        let numbered = (1..=u16::MAX).zip(&walked);
        walk.route.unreached = numbered.filter(|(_, walked)| !**walked).map(|(number, _)| number).collect();
        // After a mission that repeats itself there may be a way home for when the pilot says so.
        if let Some(last) = ended_by.filter(|_| walk.route.repeat_from.is_none())
            && let Some(item) = walk.route.unreached.iter().copied().find(|item| *item > last)
        {
            return Err(RouteError::AfterTheEnd { item, command: steps[usize::from(item) - 1].0, last });
        }
        walk.finish()
    }

    fn new(home: Option<Geodetic>) -> Self {
        Self {
            route: Route {
                home,
                start_delay_s: 0.0,
                waypoints: Vec::new(),
                tasks: Vec::new(),
                repeat_from: None,
                unreached: Vec::new(),
                ending: Ending::Hold,
            },
            speed_mps: None,
            leg_speed_mps: None,
            reverse: false,
            has_condition: false,
            jumps_made: HashMap::new(),
            passes: HashMap::new(),
        }
    }

    fn finish(mut self) -> Result<Route, RouteError> {
        if self.route.waypoints.is_empty() {
            return Err(RouteError::NoWaypoint);
        }
        if self.route.repeat_from.is_some() {
            // What is written before the jump back is done on the first leg of the next round, too.
            let count = self.route.waypoints.len();
            self.route.tasks.retain(|task| task.leg < count);
        }
        Ok(self.route)
    }

    fn take(&mut self, number: u16, step: &Step) -> Result<Next, RouteError> {
        match *step {
            Step::Visit(visit) => self.visit(number, visit)?,
            Step::Speed(speed_mps) => self.change_speed(number, speed_mps),
            Step::Delay(delay_s) => self.delay(number, delay_s)?,
            Step::Reverse(reverse) => self.reverse = reverse,
            Step::Do(action) => self.add_task(number, action),
            Step::Jump { to, times } => return self.jump(number, to, times),
            Step::Nothing => {}
            Step::Stay(place) => {
                self.route.ending = Ending::Loiter;
                if place.is_some() || self.route.waypoints.is_empty() {
                    self.visit(number, Visit { place, radius_m: None, hold_s: 0.0, circle: None })?;
                }
                return Ok(Next::End);
            }
            Step::Home => {
                self.route.ending = Ending::ReturnToLaunch;
                let home = self.route.home.ok_or(RouteError::NoHome { item: number })?;
                self.visit(number, Visit { place: Some(home), radius_m: None, hold_s: 0.0, circle: None })?;
                return Ok(Next::End);
            }
        }
        Ok(Next::Following)
    }

    fn change_speed(&mut self, number: u16, speed_mps: Option<f64>) {
        self.speed_mps = speed_mps;
        if self.has_condition {
            self.add_task(number, Action::Speed(speed_mps));
        } else {
            self.leg_speed_mps = speed_mps;
        }
    }

    fn add_task(&mut self, item: u16, action: Action) {
        self.has_condition |= matches!(action, Action::Delay(_) | Action::Distance(_));
        self.route.tasks.push(Task { leg: self.route.waypoints.len(), item, action });
    }

    fn delay(&mut self, number: u16, delay_s: f64) -> Result<(), RouteError> {
        match self.route.waypoints.last().map(|last| last.position) {
            // What is written between a waypoint and a delay there is done before the waiting.
            Some(place) if self.has_tasks() => self
                .visit(number, Visit { place: Some(place), radius_m: None, hold_s: delay_s, circle: None }),
            Some(_) => {
                if let Some(last) = self.route.waypoints.last_mut() {
                    last.hold_s += delay_s;
                }
                Ok(())
            }
            None => {
                self.route.start_delay_s += delay_s;
                Ok(())
            }
        }
    }

    /// Something is to be done on the way to the next waypoint.
    fn has_tasks(&self) -> bool {
        self.route.tasks.last().is_some_and(|task| task.leg == self.route.waypoints.len())
    }

    fn visit(&mut self, item: u16, visit: Visit) -> Result<(), RouteError> {
        let before = self.route.waypoints.last().map(|last| last.position);
        let position = visit.place.or(before).ok_or(RouteError::NowhereYet { item })?;
        let waypoint = Waypoint {
            item,
            position,
            acceptance_radius_m: visit.radius_m,
            hold_s: visit.hold_s,
            stop: false,
            speed_mps: self.leg_speed_mps,
            reverse: self.reverse,
            circle: visit.circle,
        };
        self.check_distance(&waypoint)?;
        let is_same_place = before.is_some_and(|before| before.distance_m(position) < MERGE_DISTANCE_M);
        let has_tasks = self.has_tasks();
        match self.route.waypoints.last_mut() {
            Some(last)
                if is_same_place && !has_tasks && last.circle.is_none() && waypoint.circle.is_none() =>
            {
                last.item = item;
                last.hold_s += waypoint.hold_s;
                last.acceptance_radius_m = smaller(last.acceptance_radius_m, waypoint.acceptance_radius_m);
            }
            last => {
                if let Some(last) = last {
                    // The same place again, or another way to go: the boat has to stop there.
                    last.stop |= (is_same_place && last.circle.is_none()) || last.reverse != waypoint.reverse;
                }
                self.route.waypoints.push(waypoint);
                if self.route.waypoints.len() > MOST_VISITS {
                    return Err(RouteError::TooManyVisits { item });
                }
            }
        }
        self.leg_speed_mps = self.speed_mps;
        self.has_condition = false;
        Ok(())
    }

    fn jump(&mut self, number: u16, to: u16, times: Option<u32>) -> Result<Next, RouteError> {
        let key = usize::from(number);
        let Some(times) = times else { return self.jump_for_ever(number, to) };
        let made = self.jumps_made.entry(key).or_insert(0);
        if *made >= times {
            return Ok(Next::Following);
        }
        *made += 1;
        Ok(Next::Item(to))
    }

    /// Once everything is as it was at an earlier pass, the rest repeats itself.
    fn jump_for_ever(&mut self, number: u16, to: u16) -> Result<Next, RouteError> {
        let visits = self.route.waypoints.len();
        let pass = Pass {
            jumps_made: self.jumps_made.clone(),
            speed_mps: self.speed_mps,
            reverse: self.reverse,
            visits,
        };
        match self.passes.insert(usize::from(number), pass) {
            Some(last)
                if last.jumps_made == self.jumps_made
                    && last.speed_mps == self.speed_mps
                    && last.reverse == self.reverse =>
            {
                if last.visits == visits {
                    return Err(RouteError::LoopWithoutWaypoint { item: number });
                }
                self.route.repeat_from = Some(last.visits);
                Ok(Next::End)
            }
            _ => Ok(Next::Item(to)),
        }
    }

    fn check_distance(&self, waypoint: &Waypoint) -> Result<(), RouteError> {
        let first = self.route.waypoints.first().map(|first| (first.position, "the first waypoint"));
        let Some((reference, from)) = self.route.home.map(|home| (home, "home")).or(first) else {
            return Ok(());
        };
        let distance_m = reference.distance_m(waypoint.position);
        if distance_m > MAX_DISTANCE_M {
            return Err(RouteError::TooFar { item: waypoint.item, distance_km: distance_m / 1e3, from });
        }
        Ok(())
    }
}

fn smaller(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}
