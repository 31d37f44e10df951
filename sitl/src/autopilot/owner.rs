//! What whoever runs the simulation sees and asks for, past all links.

use helmlink_mission::geodesy::NorthEast;

use super::modes::Mode;
use super::{Autopilot, auto};
use crate::scenario::Observation;

impl Autopilot {
    /// How things stand, for scenarios; what really happens is `truth`.
    pub(crate) fn observe(&self) -> Observation {
        let place = NorthEast::new(self.truth.north_m, self.truth.east_m);
        let (north_mps, east_mps) = self.truth.velocity_ned_mps();
        Observation {
            mode: self.mode.number(),
            armed: self.armed,
            has_position: self.has_position(),
            mission_complete: self.auto.progress() == auto::Progress::Complete,
            mission_item: f64::from(self.auto.current()),
            north_m: place.north_m,
            east_m: place.east_m,
            distance_home_m: (place - self.home_point()).norm(),
            speed_mps: north_mps.hypot(east_mps),
            heading_deg: self.truth.psi_rad.to_degrees().rem_euclid(360.0),
            cross_track_m: self.distance_from_mission_m(place),
            position_error_m: (place - self.motion().position).norm(),
            battery_percent: 100.0 * self.battery_left(),
        }
    }

    /// Sets a parameter whose name has been checked, and tells everyone; a value out of its range is cut.
    pub(crate) fn set_known_parameter(&mut self, name: &str, value: f32) {
        if let Some(param) = self.parameters.find(name) {
            self.parameters.put(param, value);
            self.announce_parameter(param);
        }
    }

    /// Whether there is a parameter of this name.
    pub(crate) fn has_parameter(&self, name: &str) -> bool {
        self.parameters.find(name).is_some()
    }

    /// Names and values of the parameters that a user has changed.
    pub(crate) fn changed_parameters(&self) -> Vec<(String, f32)> {
        self.parameters.changed()
    }

    /// Arms and starts the mission, or keeps the place; false while that is not possible.
    pub(crate) fn start(&mut self) -> bool {
        if !self.has_position() || !self.arming_obstacles().is_empty() || !self.arm(false) {
            return false;
        }
        let mode = if self.mission_items().is_empty() { Mode::Loiter } else { Mode::Auto };
        self.enter_mode(mode).is_ok()
    }

    /// Enters a mode as if a ground station had asked for it.
    pub(crate) fn order_mode(&mut self, number: u32) {
        // A refusal has been told as STATUSTEXT.
        let _ = self.enter_mode_number(number);
    }
}
