//! The mission as stored, and telling ground stations how far it is.

use helmlink_mission::geodesy::{Geodetic, NorthEast};
use helmlink_mission::plan::Item;
use helmlink_mission::protocol::MissionType;
use helmlink_wire::dialect::{MISSION_CURRENT_DATA, MISSION_ITEM_REACHED_DATA, Message};
use helmlink_wire::enums::*;

use super::Autopilot;
use super::auto::{Event, Progress, Situation};
use super::modes::Mode;
use super::motion::Demand;
use super::navigation::{Leg, Report};
use super::parameters::*;

impl Autopilot {
    /// The stored mission; item `n` has sequence number `n + 1`.
    pub(super) fn mission_items(&self) -> &[Item] {
        self.missions.items(MissionType::Mission)
    }

    /// Sends what the mission protocol has to say, and takes note of plans that have changed.
    pub(super) fn poll_missions(&mut self) {
        while let Some(changed) = self.missions.take_changed() {
            let count = self.missions.items(changed).len() as f32;
            match changed {
                MissionType::Mission => {
                    self.parameters.put(MIS_TOTAL, count);
                    let items = self.mission_items().len();
                    if self.auto.items_changed(items) && self.mode == Mode::Auto {
                        self.links.text(MAV_SEVERITY_NOTICE, "Auto mission changed, restarted command");
                    }
                }
                MissionType::Fence => {
                    self.parameters.put(FENCE_TOTAL, count);
                    self.read_fence();
                }
                MissionType::Rally => self.parameters.put(RALLY_TOTAL, count),
            }
        }
        self.missions.set_in_auto(self.mode == Mode::Auto);
        while let Some((link, message)) = self.missions.poll(self.now) {
            self.links.send(link, &message);
        }
    }

    /// MISSION_SET_CURRENT and the command of that purpose; false if there is no such item.
    pub(super) fn set_current_item(&mut self, seq: u16) -> bool {
        let known = usize::from(seq) <= self.mission_items().len() && !self.mission_items().is_empty();
        if known {
            self.auto.set_current(seq);
        }
        known
    }

    /// Carries out the mission, and tells everyone what has been reached.
    pub(super) fn auto_demand(&mut self) -> (Demand, Option<Report>) {
        if !self.armed {
            return (Demand::NEUTRAL, None);
        }
        let situation = Situation {
            items: self.missions.items(MissionType::Mission),
            motion: self.motion(),
            frame: &self.frame,
            parameters: &self.parameters,
            home: self.home_point(),
            now: self.now,
        };
        let outcome = self.auto.update(&situation);
        for event in self.auto.take_events() {
            match event {
                Event::Reached(seq) => {
                    let reached = MISSION_ITEM_REACHED_DATA { seq };
                    self.links.broadcast(&Message::MISSION_ITEM_REACHED(reached));
                }
                Event::Text(text) => self.links.text(MAV_SEVERITY_INFO, &text),
                Event::Complete => self.end_mission(),
            }
        }
        outcome
    }

    /// MIS_DONE_BEHAVE: 0 stops, 1 keeps the place (both within AUTO), 2 and 3 change the mode.
    fn end_mission(&mut self) {
        self.links.broadcast(&self.mission_current(self.auto.current()));
        let next = match self.parameters.int(MIS_DONE_BEHAVE) {
            2 => Mode::Acro,
            3 => Mode::Manual,
            _ => return,
        };
        if let Err(refusal) = self.enter_mode(next) {
            self.links.text(MAV_SEVERITY_WARNING, &refusal.to_string());
        }
    }

    /// Distance to the nearest leg of the mission, m; 0 without one.
    pub(super) fn distance_from_mission_m(&self, place: NorthEast) -> f64 {
        let positions = self.mission_items().iter().filter_map(|item| item.position());
        let places: Vec<NorthEast> = positions.map(|place| self.frame.to_local(place)).collect();
        let distance = |pair: &[NorthEast]| {
            let leg = Leg { from: pair[0], to: pair[1] };
            let (along_m, right_m) = leg.along_and_right_m(place);
            let length_m = (leg.to - leg.from).norm();
            if along_m <= 0.0 {
                (place - leg.from).norm()
            } else if along_m >= length_m {
                (place - leg.to).norm()
            } else {
                right_m.abs()
            }
        };
        places.windows(2).map(distance).min_by(f64::total_cmp).unwrap_or(0.0)
    }

    /// MISSION_CURRENT with this sequence number.
    pub(super) fn mission_current(&self, seq: u16) -> Message {
        let count = self.mission_items().len();
        let mission_state = match self.auto.progress() {
            _ if count == 0 => MISSION_STATE_NO_MISSION,
            Progress::Stopped => MISSION_STATE_NOT_STARTED,
            Progress::Running => MISSION_STATE_ACTIVE,
            Progress::Complete => MISSION_STATE_COMPLETE,
        };
        Message::MISSION_CURRENT(MISSION_CURRENT_DATA {
            seq,
            total: u16::try_from(count).unwrap_or(u16::MAX),
            mission_state,
            mission_mode: u8::from(self.mode == Mode::Auto),
            ..MISSION_CURRENT_DATA::DEFAULT
        })
    }

    /// Makes a place home, and tells everyone.
    pub(super) fn set_home(&mut self, home: Geodetic) {
        self.home = Some(home);
        self.missions.set_home(Some((home, 0.0)));
        self.send_home();
    }
}

#[cfg(test)]
mod tests;
