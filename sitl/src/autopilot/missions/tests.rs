use std::collections::BTreeMap;

use helmlink_mission::geodesy::{LocalFrame, NorthEast};
use helmlink_wire::LinkId;
use helmlink_wire::dialect::{MISSION_CLEAR_ALL_DATA, MISSION_SET_CURRENT_DATA};

use super::*;
use crate::autopilot::testing::{Bench, GCS, HULLS, LINK, OTHER_LINK};
use crate::physics::{Sea, SeaState};

fn square(side_m: f64, origin: Geodetic) -> Vec<Item> {
    let frame = LocalFrame::new(origin);
    [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]
        .map(|(north, east)| Item::waypoint(frame.to_geodetic(NorthEast::new(north * side_m, east * side_m))))
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

#[test]
fn a_working_day_at_sea_keeps_the_boat_from_nothing() {
    for hull in HULLS {
        let hull = crate::physics::Hull::builtin(hull).unwrap();
        let sea = Sea::preset(SeaState::Moderate, &hull);
        let mut bench = Bench::at_sea(&hull.name, sea);
        let side_m = 25.0 * hull.length_m;
        let items = square(side_m, bench.autopilot.position());
        bench.set_mission(&items).unwrap();
        bench.autopilot.enter_mode(Mode::Auto).unwrap();
        bench.arm();
        let sent = bench.run_s(8.0 * side_m / hull.cruise_speed_mps);
        assert_eq!(reached(&sent, LINK), [1, 2, 3, 4], "{}: at {:?}", hull.name, bench.position());
    }
}
