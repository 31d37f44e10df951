//! Along a stretch, and staying where it ends.

use std::f64::consts::PI;

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::Path;

use super::{MissionRun, Phase, RunError, Step};
use crate::control::Diagnostics;
use crate::guidance::VesselState;
use crate::pilot::stretch::{AT_WAYPOINT_M, Stretch};
use crate::vehicle::output::Demand;

/// A boat that waits lets itself drift this far before it drives back, metres, or its turning radius if that is
/// larger: less would keep it turning all the time.
const KEEP_WITHIN_M: f64 = 2.0;
/// Stern first, the boat is not asked for more than this part of its largest speed: thrusters push worse astern.
const ASTERN_SPEED_PART: f64 = 0.4;

impl MissionRun {
    pub(super) fn drive(&mut self, dt_s: f64, state: &VesselState, step: &mut Step) -> Result<(), RunError> {
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
            yaw_rate_radps: output.diagnostics.law.alpha_r_radps,
            ground_per_water: self.ground_per_water(&output.diagnostics),
        };
        if stretch.astern {
            step.demand.throttle = -step.demand.throttle;
            step.demand.speed_mps = -step.demand.speed_mps;
        }
        let place_m = reference.progress_m;
        while self.next < stretch.last && self.has_reached(stretch, place_m, state.position) {
            self.next += 1;
        }
        self.progress.leg = stretch.leg_at(place_m, self.next);
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
    pub(super) fn wait(&mut self, dt_s: f64, state: &VesselState, step: &mut Step) -> Result<(), RunError> {
        let wanted_mps = self.settings.speed_mps.min(self.boat.limits.cruise_mps);
        let tolerance_m = self.tolerance_m();
        let Phase::Waiting { place, left_s, back } = &mut self.phase else { return Ok(()) };
        *left_s -= dt_s;
        if *left_s <= 0.0 {
            self.phase = Phase::ToStart;
            return Ok(());
        }
        let off_m = (*place - state.position).norm();
        self.progress.cross_track_m = 0.0;
        self.progress.speed_mps = state.surge_mps.hypot(state.sway_mps);
        if back.is_none() && off_m > tolerance_m {
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
                ground_per_water: 1.0,
            };
            if output.diagnostics.reference.finished || off_m < AT_WAYPOINT_M {
                *back = None;
            }
        }
        Ok(())
    }

    /// How much the current changes what the firmware's steering does: nothing where two thrusters turn the boat.
    fn ground_per_water(&self, diagnostics: &Diagnostics) -> f64 {
        if self.boat.steers_by_flow() { diagnostics.ground_per_water } else { 1.0 }
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

    /// How far from its place a boat may be without being told to go back there, metres.
    pub(super) fn tolerance_m(&self) -> f64 {
        KEEP_WITHIN_M.max(self.boat.limits.turn_radius_m)
    }
}

/// The boat as the law is to see it: as it is, or its mirror image with the bow where the stern is.
pub(super) fn facing(state: &VesselState, astern: bool) -> VesselState {
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
