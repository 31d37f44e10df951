//! Taking over, going on elsewhere in the mission, and the next stretch.

use helmlink_mission::geodesy::{Geodetic, NorthEast};
use helmlink_mission::route::MERGE_DISTANCE_M;

use super::driving::facing;
use super::{MissionRun, Phase, RunError};
use crate::control::HelmError;
use crate::guidance::VesselState;
use crate::pilot::joining::{Leg, lead};
use crate::pilot::stretch::Stretch;

impl MissionRun {
    /// Takes over from another controller: everything that the law has integrated starts anew, the place in the
    /// mission is kept. A boat that is off its path by more than a turn is led back onto the leg it was on, ahead of
    /// where it is.
    ///
    /// # Errors
    /// The state is not a number or absurd.
    pub fn engage(&mut self, state: &VesselState) -> Result<(), HelmError> {
        self.last_step_s = None;
        let tolerance_m = self.tolerance_m();
        match &mut self.phase {
            Phase::Driving(stretch) => {
                let progress_m = stretch.progress_near(state.position, self.next);
                if stretch.distance_m(state.position, progress_m) > tolerance_m {
                    self.phase = Phase::ToStart;
                    self.joins_leg = true;
                    return self.helm.engage(state, 0.0);
                }
                self.helm.engage(&facing(state, stretch.astern), progress_m)
            }
            Phase::Waiting { back, .. } => {
                *back = None;
                self.helm.engage(state, 0.0)
            }
            Phase::ToStart | Phase::Complete => self.helm.engage(state, 0.0),
        }
    }

    /// Goes straight to waypoint `index`, from wherever the boat is; what the mission asks for on the way to it is
    /// left out, unless it is the first. An index past the last one is ignored.
    pub fn jump_to(&mut self, index: usize) {
        if index < self.waypoints.len() {
            self.next = index;
            self.phase = Phase::ToStart;
            self.joins_leg = false;
            self.has_set_out = index > 0;
            self.arrived_at = None;
            self.tasks.jump(&self.route, index);
            self.progress.next = index;
            self.progress.complete = false;
        }
    }

    /// Goes on along the leg to waypoint `index`, from the point of it that is nearest ahead of a boat at `place`:
    /// neither back to the leg's beginning nor straight to its end. A waypoint that the boat is abeam of or past
    /// already, and where it has not to stop, counts as passed. Otherwise as [`Self::jump_to`].
    pub fn join(&mut self, index: usize, place: Geodetic) {
        let position = self.frame.to_local(place);
        let mut index = index;
        while index + 1 < self.waypoints.len() && self.is_past(index, position) {
            index += 1;
        }
        self.jump_to(index);
        self.joins_leg = true;
    }

    /// Abeam of or past a waypoint, as seen along the leg to it, and closer to the leg after it.
    fn is_past(&self, index: usize, position: NorthEast) -> bool {
        let waypoint = &self.route.waypoints[index];
        if waypoint.is_stop() || waypoint.circle.is_some() {
            return false;
        }
        let (Some(leg), Some(after)) = (self.leg_to(index), self.leg_to(index + 1)) else { return false };
        leg.along_m(position) >= leg.length_m() && after.distance_m(position) <= leg.distance_m(position)
    }

    /// The straight leg that ends at waypoint `index`; none where there is none, as to the first and from a circle.
    fn leg_to(&self, index: usize) -> Option<Leg> {
        let from = index.checked_sub(1)?;
        let is_straight = self.route.waypoints.get(from)?.circle.is_none();
        let leg = Leg::new(self.waypoints[from], *self.waypoints.get(index)?);
        (is_straight && leg.length_m() >= MERGE_DISTANCE_M).then_some(leg)
    }

    /// The boat has come to the end of a stretch, at waypoint `index`.
    pub(super) fn arrive(&mut self, index: usize) {
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

    pub(super) fn start_stretch(&mut self, state: &VesselState) -> Result<(), RunError> {
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
        let leg = std::mem::take(&mut self.joins_leg).then(|| self.leg_to(self.next)).flatten();
        let lead = lead(state.position, leg.as_ref(), self.tolerance_m());
        let (waypoints, places) = (&self.route.waypoints, &self.waypoints);
        match Stretch::from(state.position, &lead, self.next, waypoints, places, &limits)? {
            Some(stretch) => {
                // At the beginning of the path, or a little behind it.
                self.helm.engage(&facing(state, stretch.astern), 0.0)?;
                self.arrived_at = None;
                self.phase = Phase::Driving(stretch);
                self.stretches += 1;
            }
            None => self.arrive_at_once(),
        }
        Ok(())
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
}
