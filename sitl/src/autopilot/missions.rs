//! The mission as stored, and telling ground stations how far it is.

use helmlink_mission::geodesy::Geodetic;
use helmlink_mission::plan::Item;
use helmlink_mission::protocol::MissionType;
use helmlink_wire::dialect::{MISSION_CURRENT_DATA, MISSION_ITEM_REACHED_DATA, Message};
use helmlink_wire::enums::*;

use super::Autopilot;
use super::auto::{Event, Progress, Situation};
use super::modes::Mode;
use super::motion::Demand;
use super::navigation::Report;
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
                MissionType::Fence => self.parameters.put(FENCE_TOTAL, count),
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
mod tests {
    use std::collections::BTreeMap;

    use helmlink_mission::geodesy::{LocalFrame, NorthEast};
    use helmlink_wire::LinkId;
    use helmlink_wire::dialect::{MISSION_CLEAR_ALL_DATA, MISSION_SET_CURRENT_DATA};

    use super::*;
    use crate::autopilot::testing::{Bench, GCS, HULLS, LINK, OTHER_LINK};

    fn square(side_m: f64, origin: Geodetic) -> Vec<Item> {
        let frame = LocalFrame::new(origin);
        [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]
            .map(|(north, east)| {
                Item::waypoint(frame.to_geodetic(NorthEast::new(north * side_m, east * side_m)))
            })
            .to_vec()
    }

    fn reached(sent: &BTreeMap<LinkId, Vec<Message>>, link: LinkId) -> Vec<u16> {
        let seq = |message: &Message| match message {
            Message::MISSION_ITEM_REACHED(data) => Some(data.seq),
            _ => None,
        };
        sent[&link].iter().filter_map(seq).collect()
    }

    fn with_square(hull: &str, side_m: f64) -> Bench {
        let mut bench = Bench::with_hull(hull);
        let items = square(side_m, bench.autopilot.position());
        bench.autopilot.missions.set_items(MissionType::Mission, &items).unwrap();
        bench.run_loops(1);
        bench
    }

    #[test]
    fn every_boat_drives_a_square_and_stops_at_its_end() {
        for hull in HULLS {
            let length_m = crate::physics::Hull::builtin(hull).unwrap().length_m;
            let side_m = 25.0 * length_m.max(2.0);
            let mut bench = with_square(hull, side_m);
            bench.autopilot.enter_mode(Mode::Auto).unwrap();
            bench.arm();
            let cruise_mps = bench.autopilot.parameters.get(CRUISE_SPEED);
            let mut worst_m: f64 = 0.0;
            let mut all = Vec::new();
            let limit_s = 8.0 * side_m / cruise_mps;
            let mut elapsed_s = 0.0;
            while bench.autopilot.auto.progress() != Progress::Complete && elapsed_s < limit_s {
                let sent = bench.run_s(1.0);
                all.extend(reached(&sent, LINK));
                elapsed_s += 1.0;
                let report = bench.autopilot.report;
                let away = |report: Report| report.cross_track_m.abs();
                worst_m = worst_m.max(report.map_or(0.0, away));
            }
            assert_eq!(all, [1, 2, 3, 4], "{hull}: after {elapsed_s} s at {:?}", bench.position());
            assert!(worst_m < 0.1 * side_m, "{hull}: {worst_m} m off");
            assert!(elapsed_s < 5.0 * side_m / cruise_mps, "{hull}: {elapsed_s} s");
            bench.run_s(60.0);
            assert_eq!(bench.autopilot.mode, Mode::Auto);
            assert!(bench.autopilot.armed);
            let away_m = bench.position().norm();
            assert!(away_m < 3.0_f64.max(length_m), "{hull}: stopped {away_m} m away");
        }
    }

    #[test]
    fn the_end_of_the_mission_is_told_on_every_link() {
        let mut bench = with_square("otter", 25.0);
        bench.autopilot.enter_mode(Mode::Auto).unwrap();
        bench.arm();
        let sent = bench.run_s(200.0);
        for link in [LINK, OTHER_LINK] {
            assert_eq!(reached(&sent, link), [1, 2, 3, 4]);
            let last = sent[&link].iter().rev().find_map(|message| match message {
                Message::MISSION_CURRENT(data) => Some(data.clone()),
                _ => None,
            });
            let last = last.unwrap();
            assert_eq!((last.seq, last.total, last.mission_state, last.mission_mode), (4, 4, 5, 1));
        }
        let texts = Bench::texts(&sent);
        assert!(texts.contains(&"Reached waypoint #2".to_owned()));
        assert!(texts.contains(&"Mission Complete".to_owned()));
    }

    #[test]
    fn a_current_item_is_confirmed_at_once_and_nonsense_is_not() {
        let mut bench = with_square("otter", 25.0);
        for (seq, expected) in [(3, Some(3)), (0, Some(0)), (77, None)] {
            let message = MISSION_SET_CURRENT_DATA { seq, target_system: 1, target_component: 1 };
            bench.send(LINK, GCS, &Message::MISSION_SET_CURRENT(message));
            let sent = bench.run_loops(1);
            let told = sent[&LINK].iter().find_map(|message| match message {
                Message::MISSION_CURRENT(data) => Some(data.seq),
                _ => None,
            });
            assert_eq!(told, expected);
        }
    }

    #[test]
    fn a_mission_under_way_is_not_cleared() {
        let mut bench = with_square("otter", 25.0);
        bench.autopilot.enter_mode(Mode::Auto).unwrap();
        bench.run_loops(1);
        let clear = MISSION_CLEAR_ALL_DATA { target_system: 1, target_component: 1, mission_type: 0 };
        bench.send(LINK, GCS, &Message::MISSION_CLEAR_ALL(clear.clone()));
        bench.run_loops(1);
        assert_eq!(bench.autopilot.mission_items().len(), 4);
        bench.autopilot.enter_mode(Mode::Hold).unwrap();
        bench.run_loops(1);
        bench.send(LINK, GCS, &Message::MISSION_CLEAR_ALL(clear));
        bench.run_loops(1);
        assert!(bench.autopilot.mission_items().is_empty());
    }
}
