//! Every command of a mission, carried out by the bridge on the simulated boat.

use std::time::Duration;

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::plan::{Item, Mission};
use helmlink_mission::route::Route;
use helmlink_sitl::physics::sea::Current;
use helmlink_sitl::physics::{Hull, Sea, SensorSettings};
use helmlink_wire::enums::*;

use super::{ClosedLoop, Trial};
use crate::control::{Boat, Controller};
use crate::pilot::supervisor::State;
use crate::vehicle::{Mode, OutputKind};

const HOME: Geodetic = Geodetic { latitude_deg: 63.44, longitude_deg: 10.4 };
/// Simulated time within which each of these missions must be over, seconds.
const LIMIT_S: u64 = 900;

fn at(north_m: f64, east_m: f64) -> Item {
    Item::waypoint(LocalFrame::new(HOME).to_geodetic(NorthEast::new(north_m, east_m)))
}

fn command(command: u16, p1: f32, p2: f32) -> Item {
    Item { command, params: [p1, p2, 0.0, 0.0], frame: MAV_FRAME_MISSION, x: 0, y: 0, ..at(0.0, 0.0) }
}

fn trial(items: &[Item]) -> Trial {
    let mission = Mission { home: Some(HOME), items: items.to_vec() };
    Trial {
        boat: Boat::embedded("otter").unwrap(),
        controller: Controller::default(),
        output: OutputKind::RcOverride,
        speed_mps: Some(1.2),
        interval_s: 0.04,
        hull: Hull::builtin("otter").unwrap(),
        sea: Sea::default(),
        sensors: SensorSettings::perfect(),
        seed: 1,
        delay_s: 0.0,
        route: Route::from_mission(&mission).unwrap(),
        mission,
        home: HOME,
        heading_rad: 0.0,
    }
}

/// What was seen at one moment.
#[derive(Debug, Clone, Copy)]
struct Sight {
    time_s: f64,
    place: NorthEast,
    surge_mps: f64,
    speed_mps: f64,
    next: usize,
    state: State,
}

/// A drive, looked at ten times a second from its engagement on.
struct Drive {
    sights: Vec<Sight>,
    events: Vec<String>,
    state: State,
    mode: Option<Mode>,
}

impl Drive {
    /// Drives until the mission is over or `limit_s` has passed.
    fn of(trial: &Trial, limit_s: u64) -> Self {
        let mut run = trial.closed_loop().unwrap();
        let mut sights = Vec::new();
        let limit = Duration::from_secs(limit_s);
        while run.now() < limit && !matches!(run.bridge().status().state, State::Finished) {
            for _ in 0..5 {
                run.step();
            }
            sights.extend(sight(&run));
        }
        let (state, mode) = (run.bridge().status().state, run.bridge().status().mode);
        let events = run.into_recorder().0.into_run().events.into_iter().map(|(_, text)| text).collect();
        Self { sights, events, state, mode }
    }

    fn to_the_end(items: &[Item]) -> Self {
        let drive = Self::of(&trial(items), LIMIT_S);
        assert_eq!(drive.state, State::Finished, "{:#?}", drive.events);
        drive
    }

    /// Numbers of the items reached, in order.
    fn reached(&self) -> Vec<u16> {
        self.events.iter().filter_map(|text| text.strip_prefix("reached waypoint ")?.parse().ok()).collect()
    }

    fn said(&self, text: &str) -> bool {
        self.events.iter().any(|event| event.contains(text))
    }

    /// The sights on the leg to waypoint `next` of the route.
    fn leg(&self, next: usize) -> impl Iterator<Item = &Sight> {
        self.sights.iter().filter(move |sight| sight.next == next && sight.state == State::Engaged)
    }
}

fn sight(run: &ClosedLoop) -> Option<Sight> {
    let status = run.bridge().status();
    let hull = run.sitl().truth().hull;
    let (north_mps, east_mps) = hull.velocity_ned_mps();
    let (sin, cos) = hull.psi_rad.sin_cos();
    Some(Sight {
        time_s: run.now().as_secs_f64(),
        place: NorthEast::new(hull.north_m, hull.east_m),
        surge_mps: north_mps * cos + east_mps * sin,
        speed_mps: north_mps.hypot(east_mps),
        next: status.progress?.next,
        state: status.state,
    })
}

#[test]
fn jumps_speeds_and_holds() {
    let drive = Drive::to_the_end(&[
        at(25.0, 0.0),
        command(MAV_CMD_DO_CHANGE_SPEED, 1.0, 0.7),
        Item { params: [12.0, 0.0, 0.0, 0.0], ..at(25.0, 25.0) },
        command(MAV_CMD_DO_JUMP, 1.0, 1.0),
        at(0.0, 25.0),
    ]);
    assert_eq!(drive.reached(), [1, 3, 1, 3, 5]);
    let slow = drive.leg(1).map(|sight| sight.speed_mps).fold(0.0, f64::max);
    let fast = drive.leg(0).map(|sight| sight.speed_mps).fold(0.0, f64::max);
    assert!(fast > 1.1, "{fast}");
    let cruise: Vec<f64> = drive.leg(4).map(|sight| sight.speed_mps).collect();
    assert!(cruise.iter().all(|speed| *speed < 0.9), "the speed lasts");
    assert!(slow < 1.35, "{slow}");
    let waiting = drive.sights.iter().filter(|sight| sight.speed_mps < 0.2 && sight.next == 2).count();
    assert!(waiting > 60, "held for {} tenths of a second", waiting);
}

#[test]
fn a_loiter_keeps_the_place_in_a_current() {
    let loiter = Item { command: MAV_CMD_NAV_LOITER_TIME, params: [90.0, 0.0, 0.0, 0.0], ..at(30.0, 0.0) };
    let mut trial = trial(&[loiter, at(30.0, 30.0)]);
    trial.sea.current = Some(Current { speed_mps: 0.25, toward_deg: 90.0, variability: 0.0 });
    let drive = Drive::of(&trial, LIMIT_S);
    assert_eq!(drive.state, State::Finished, "{:#?}", drive.events);
    assert_eq!(drive.reached(), [1, 2]);
    let arrived_s = drive.sights.iter().find(|sight| sight.next == 1).unwrap().time_s;
    let kept: Vec<f64> = drive
        .leg(1)
        .filter(|sight| sight.time_s < arrived_s + 89.0)
        .map(|sight| (sight.place - NorthEast::new(30.0, 0.0)).norm())
        .collect();
    assert!(kept.len() > 800, "{} sights", kept.len());
    // Adrift it would be 22 m away at the end.
    let most_m = kept.iter().copied().fold(0.0, f64::max);
    assert!(most_m < 8.0, "{most_m}");
}

#[test]
fn turns_around_a_place() {
    let turns = Item { command: MAV_CMD_NAV_LOITER_TURNS, params: [2.0, 0.0, -12.0, 0.0], ..at(40.0, 10.0) };
    let drive = Drive::to_the_end(&[at(15.0, 0.0), turns, at(40.0, 50.0)]);
    assert_eq!(drive.reached(), [1, 2, 3]);
    let centre = NorthEast::new(40.0, 10.0);
    let mut turned_rad = 0.0;
    let mut off_m = Vec::new();
    let around: Vec<NorthEast> = drive
        .leg(1)
        .map(|sight| sight.place - centre)
        .skip_while(|out| (out.norm() - 12.0).abs() > 0.5)
        .collect();
    for pair in around.windows(2) {
        turned_rad += helmlink_mission::angle::ssa(pair[1].bearing_rad() - pair[0].bearing_rad());
        off_m.push((pair[1].norm() - 12.0).abs());
    }
    assert!(turned_rad < -2.0 * std::f64::consts::TAU + 0.3, "to port: {turned_rad} rad");
    let worst_m = off_m.iter().copied().fold(0.0, f64::max);
    let mean_m = off_m.iter().sum::<f64>() / off_m.len() as f64;
    assert!(mean_m < 0.3 && worst_m < 1.5, "mean {mean_m} m, worst {worst_m} m");
}

#[test]
fn commands_reach_the_flight_controller_at_their_waypoint() {
    let drive = Drive::to_the_end(&[
        at(20.0, 0.0),
        command(MAV_CMD_DO_SET_SERVO, 9.0, 1700.0),
        command(MAV_CMD_NAV_DELAY, 5.0, 0.0),
        command(MAV_CMD_DO_SET_SERVO, 1.0, 1500.0),
        at(20.0, 20.0),
        command(MAV_CMD_DO_SET_SERVO, 10.0, 1100.0),
    ]);
    let order: Vec<&String> =
        drive.events.iter().filter(|text| text.contains("item ") || text.contains("reached")).collect();
    assert!(drive.said("item 2: MAV_CMD_DO_SET_SERVO (183): done"), "{order:#?}");
    assert!(
        drive.said("item 4: MAV_CMD_DO_SET_SERVO (183): refused by the flight controller: FAILED"),
        "{order:#?}"
    );
    let position = |text: &str| drive.events.iter().position(|event| event.contains(text)).unwrap();
    assert!(position("reached waypoint 1") < position("item 2:"));
    assert!(
        position("item 2:") < position("reached waypoint 3") || position("item 2:") < position("item 4:")
    );
}

#[test]
fn conditions_wait_for_their_distance() {
    let drive = Drive::to_the_end(&[
        at(10.0, 0.0),
        command(MAV_CMD_CONDITION_DISTANCE, 20.0, 0.0),
        command(MAV_CMD_DO_CHANGE_SPEED, 1.0, 0.6),
        at(60.0, 0.0),
        at(80.0, 0.0),
    ]);
    let speeds = |from_m: f64, to_m: f64| {
        let within = |sight: &&Sight| (from_m..to_m).contains(&sight.place.north_m);
        let speeds: Vec<f64> = drive.leg(1).filter(within).map(|sight| sight.speed_mps).collect();
        speeds.iter().sum::<f64>() / speeds.len() as f64
    };
    assert!(speeds(25.0, 38.0) > 1.1, "{}", speeds(25.0, 38.0));
    assert!(speeds(46.0, 58.0) < 0.75, "{}", speeds(46.0, 58.0));
}

#[test]
fn goes_astern_where_told_to() {
    let drive = Drive::to_the_end(&[
        at(20.0, 0.0),
        command(MAV_CMD_DO_SET_REVERSE, 1.0, 0.0),
        at(0.0, 5.0),
        command(MAV_CMD_DO_SET_REVERSE, 0.0, 0.0),
        at(20.0, 20.0),
    ]);
    assert_eq!(drive.reached(), [1, 3, 5]);
    let astern: Vec<f64> = drive.leg(1).map(|sight| sight.surge_mps).collect();
    let share = astern.iter().filter(|surge| **surge < -0.1).count() as f64 / astern.len() as f64;
    assert!(share > 0.7, "{share} of the leg stern first");
    let line = NorthEast::new(-20.0, 5.0);
    let off_m = drive
        .leg(1)
        .map(|sight| (line.cross(sight.place - NorthEast::new(20.0, 0.0)) / line.norm()).abs())
        .fold(0.0, f64::max);
    assert!(off_m < 2.5, "{off_m} m off the line");
    let ahead = drive.leg(2).filter(|sight| sight.surge_mps > 0.3).count();
    assert!(ahead > 50, "bow first again");
}

#[test]
fn a_boat_that_cannot_go_astern_says_which_item() {
    let mut trial = trial(&[at(20.0, 0.0), command(MAV_CMD_DO_SET_REVERSE, 1.0, 0.0), at(0.0, 5.0)]);
    trial.boat = Boat::embedded("skiff").unwrap();
    trial.hull = Hull::builtin("skiff").unwrap();
    let drive = Drive::of(&trial, 60);
    assert!(drive.said("item 3: the boat is to go stern first"), "{:#?}", drive.events);
    assert!(drive.sights.iter().all(|sight| sight.state != State::Engaged));
}

#[test]
fn stays_where_the_mission_says_for_ever() {
    let drive = Drive::to_the_end(&[at(20.0, 0.0), command(MAV_CMD_NAV_LOITER_UNLIM, 0.0, 0.0)]);
    assert_eq!(drive.mode, Some(Mode::LOITER));
    let home = Drive::to_the_end(&[at(20.0, 0.0), command(MAV_CMD_NAV_RETURN_TO_LAUNCH, 0.0, 0.0)]);
    assert_eq!(home.mode, Some(Mode::HOLD));
    assert!(home.sights.last().unwrap().place.norm() < 2.5);
}

#[test]
fn a_mission_without_end_goes_round_and_round() {
    let drive = Drive::of(
        &trial(&[at(15.0, 0.0), at(15.0, 15.0), at(0.0, 15.0), command(MAV_CMD_DO_JUMP, 1.0, -1.0)]),
        240,
    );
    assert_eq!(drive.state, State::Engaged, "{:#?}", drive.events);
    let reached = drive.reached();
    assert!(reached.len() > 9 && reached.chunks(3).all(|round| [1, 2, 3].starts_with(round)), "{reached:?}");
}

#[test]
fn an_acceptance_radius_counts_a_waypoint_early() {
    let far = |radius_m: f32| {
        let wide = Item { params: [0.0, radius_m, 0.0, 0.0], ..at(30.0, 0.0) };
        let drive = Drive::to_the_end(&[wide, at(60.0, 0.0)]);
        let passed = *drive.sights.iter().find(|sight| sight.next == 1).unwrap();
        (passed.place - NorthEast::new(30.0, 0.0)).norm()
    };
    let (plain_m, wide_m) = (far(0.0), far(8.0));
    assert!(plain_m < 1.0 && (7.0..8.1).contains(&wide_m), "{plain_m} m, {wide_m} m");
}

#[test]
fn the_same_mission_gives_the_same_commands() {
    let turns = Item { command: MAV_CMD_NAV_LOITER_TURNS, params: [1.0, 0.0, 8.0, 0.0], ..at(20.0, 0.0) };
    let items = [turns, command(MAV_CMD_DO_SET_SERVO, 9.0, 1700.0), at(0.0, 20.0)];
    let digest = || trial(&items).run().unwrap().commands_sha256;
    assert_eq!(digest(), digest());
}

#[test]
fn a_mission_of_one_point_is_driven_by_every_controller_from_any_heading() {
    for (index, controller) in Controller::ALL.into_iter().enumerate() {
        let heading_rad = [3.1, 0.0, -1.6][index % 3];
        let drive = Drive::of(&Trial { controller, heading_rad, ..trial(&[at(30.0, 0.0)]) }, 240);
        assert_eq!(drive.state, State::Finished, "{controller}: {:#?}", drive.events);
        assert_eq!(drive.reached(), [1], "{controller}");
        let last = drive.sights.last().unwrap();
        assert!((last.place - NorthEast::new(30.0, 0.0)).norm() < 3.0, "{controller}: {last:?}");
    }
}

#[test]
fn a_mission_of_one_point_where_the_boat_already_is_ends_at_once() {
    let drive = Drive::of(&trial(&[at(0.3, 0.2)]), 60);
    assert_eq!((drive.state, drive.reached()), (State::Finished, vec![1]), "{:#?}", drive.events);
    assert!(drive.sights.iter().all(|sight| sight.speed_mps < 0.2));
}
