use helmlink_wire::enums::*;
use proptest::prelude::*;

use super::*;
use crate::plan::{CommandName, Item, Mission};

const HOME: Geodetic = Geodetic { latitude_deg: 59.9, longitude_deg: 10.7 };

fn at(north_m: f64, east_m: f64) -> Item {
    Item::waypoint(LocalFrame::new(HOME).to_geodetic(NorthEast::new(north_m, east_m)))
}

fn command(command: u16, params: [f32; 4]) -> Item {
    Item { command, params, x: 0, y: 0, frame: MAV_FRAME_MISSION, ..at(0.0, 0.0) }
}

fn route(items: &[Item]) -> Result<Route, RouteError> {
    Route::from_mission(&Mission { home: Some(HOME), items: items.to_vec() })
}

#[test]
fn speeds_and_waits_belong_to_the_legs_they_are_written_before_and_after() {
    let items = [
        command(MAV_CMD_NAV_DELAY, [3.0, 0.0, 0.0, 0.0]),
        at(20.0, 0.0),
        command(MAV_CMD_DO_CHANGE_SPEED, [1.0, 1.4, -1.0, 0.0]),
        Item { params: [5.0, 2.0, 0.0, f32::NAN], ..at(40.0, 0.0) },
        command(MAV_CMD_NAV_DELAY, [7.0, 0.0, 0.0, 0.0]),
        command(MAV_CMD_DO_CHANGE_SPEED, [0.0, -1.0, -1.0, 0.0]),
        at(40.0, 20.0),
        command(MAV_CMD_DO_CHANGE_SPEED, [0.0, -2.0, -1.0, 0.0]),
        at(0.0, 20.0),
    ];
    let route = route(&items).unwrap();
    assert_eq!(route.start_delay_s, 3.0);
    assert_eq!(route.ending, Ending::Hold);
    let speeds: Vec<_> = route.waypoints.iter().map(|waypoint| waypoint.speed_mps).collect();
    assert_eq!(speeds, [None, Some(f64::from(1.4_f32)), Some(f64::from(1.4_f32)), None]);
    let second = route.waypoints[1];
    assert_eq!((second.item, second.hold_s, second.acceptance_radius_m), (4, 12.0, Some(2.0)));
    assert!((route.length_m() - 80.0).abs() < 0.05, "{}", route.length_m());
}

#[test]
fn ends_as_the_last_item_says() {
    let home = route(&[at(20.0, 0.0), command(MAV_CMD_NAV_RETURN_TO_LAUNCH, [0.0; 4])]).unwrap();
    assert_eq!((home.ending, home.waypoints.len()), (Ending::ReturnToLaunch, 2));
    assert_eq!(home.waypoints[1].position, HOME);
    let stay = route(&[at(20.0, 0.0), command(MAV_CMD_NAV_LOITER_UNLIM, [0.0; 4])]).unwrap();
    assert_eq!((stay.ending, stay.waypoints.len()), (Ending::Loiter, 1));
    let there = route(&[at(20.0, 0.0), Item { command: MAV_CMD_NAV_LOITER_UNLIM, ..at(30.0, 0.0) }]).unwrap();
    assert_eq!((there.ending, there.waypoints.len()), (Ending::Loiter, 2));
}

#[test]
fn one_waypoint_is_a_route() {
    let route = Route::from_mission(&Mission { home: None, items: vec![at(20.0, 0.0)] }).unwrap();
    assert_eq!((route.waypoints.len(), route.length_m()), (1, 0.0));
}

#[test]
fn items_at_one_place_are_one_waypoint() {
    let hold = |params| Item { params, ..at(20.0, 0.0) };
    let items = [hold([2.0, 3.0, 0.0, 0.0]), hold([4.0, 1.5, 0.0, 0.0]), at(20.0, 0.05), at(20.0, 5.0)];
    let route = route(&items).unwrap();
    assert_eq!(route.waypoints.len(), 2);
    let merged = route.waypoints[0];
    assert_eq!((merged.item, merged.hold_s, merged.acceptance_radius_m), (3, 6.0, Some(1.5)));
}

#[test]
fn says_which_item_cannot_be_carried_out() {
    let error = |items: &[Item]| route(items).unwrap_err();
    assert_eq!(error(&[]), RouteError::NoWaypoint);
    assert_eq!(error(&[command(MAV_CMD_DO_CHANGE_SPEED, [1.0, 1.0, 0.0, 0.0])]), RouteError::NoWaypoint);
    for unsupported in [
        MAV_CMD_NAV_TAKEOFF,
        MAV_CMD_NAV_LAND,
        MAV_CMD_DO_SET_MODE,
        MAV_CMD_COMPONENT_ARM_DISARM,
        MAV_CMD_DO_FLIGHTTERMINATION,
    ] {
        let error = error(&[at(9.0, 0.0), command(unsupported, [0.0; 4])]);
        assert_eq!(error, RouteError::Unsupported { item: 2, command: CommandName(unsupported) });
    }
    let land = error(&[at(9.0, 0.0), command(MAV_CMD_NAV_LAND, [0.0; 4])]);
    assert!(land.to_string().starts_with("item 2: MAV_CMD_NAV_LAND (21) cannot be carried out"), "{land}");
    assert!(matches!(error(&[at(9.0, 0.0), command(16, [0.0; 4])]), RouteError::NoPosition { item: 2, .. }));
    let astray = Item::waypoint(Geodetic::new(15.0, 10.7));
    assert!(
        matches!(error(&[at(9.0, 0.0), astray]), RouteError::TooFar { item: 2, distance_km, from: "home" }
        if (distance_km - 5_000.0).abs() < 50.0)
    );
    let rtl = command(MAV_CMD_NAV_RETURN_TO_LAUNCH, [0.0; 4]);
    assert!(matches!(
        error(&[at(9.0, 0.0), rtl, at(5.0, 0.0)]),
        RouteError::AfterTheEnd { item: 3, last: 2, .. }
    ));
    let no_home = Mission { home: None, items: vec![at(9.0, 0.0), rtl] };
    assert_eq!(Route::from_mission(&no_home).unwrap_err(), RouteError::NoHome { item: 2 });
    for (code, params) in [
        (MAV_CMD_DO_CHANGE_SPEED, [2.0, 1.0, 0.0, 0.0]),
        (MAV_CMD_DO_CHANGE_SPEED, [1.0, 0.0, 0.0, 0.0]),
        (MAV_CMD_DO_CHANGE_SPEED, [1.0, f32::NAN, 0.0, 0.0]),
        (MAV_CMD_NAV_DELAY, [-1.0, 12.0, 0.0, 0.0]),
        (MAV_CMD_NAV_DELAY, [f32::INFINITY, 0.0, 0.0, 0.0]),
        (MAV_CMD_CONDITION_DELAY, [-1.0, 0.0, 0.0, 0.0]),
        (MAV_CMD_CONDITION_DISTANCE, [f32::INFINITY, 0.0, 0.0, 0.0]),
        (MAV_CMD_DO_SET_REVERSE, [2.0, 0.0, 0.0, 0.0]),
        (MAV_CMD_DO_JUMP, [0.0, 1.0, 0.0, 0.0]),
        (MAV_CMD_DO_JUMP, [3.0, 1.0, 0.0, 0.0]),
        (MAV_CMD_DO_JUMP, [2.0, 1.0, 0.0, 0.0]),
        (MAV_CMD_DO_JUMP, [1.5, 1.0, 0.0, 0.0]),
        (MAV_CMD_DO_JUMP, [1.0, -2.0, 0.0, 0.0]),
        (MAV_CMD_DO_JUMP, [1.0, f32::NAN, 0.0, 0.0]),
        (MAV_CMD_DO_JUMP_TAG, [7.0, 1.0, 0.0, 0.0]),
        (MAV_CMD_NAV_LOITER_TURNS, [-1.0, 0.0, 0.0, 0.0]),
        (MAV_CMD_NAV_LOITER_TURNS, [1e9, 0.0, 0.0, 0.0]),
        (MAV_CMD_NAV_LOITER_TURNS, [1.0, 0.0, 0.1, 0.0]),
        (MAV_CMD_NAV_LOITER_TURNS, [1.0, 0.0, f32::INFINITY, 0.0]),
        (MAV_CMD_NAV_LOITER_TIME, [-1.0, 0.0, 0.0, 0.0]),
    ] {
        let error = error(&[at(9.0, 0.0), command(code, params)]);
        let is_of_item =
            matches!(error, RouteError::Parameter { item: 2, .. } | RouteError::Delay { item: 2, .. });
        assert!(is_of_item, "{error}");
    }
    let impatient = Item { params: [-5.0, 0.0, 0.0, 0.0], ..at(9.0, 0.0) };
    assert!(matches!(error(&[impatient]), RouteError::Parameter { item: 1, .. }));
}

#[test]
fn distance_is_from_the_first_waypoint_when_home_is_unknown() {
    let items = vec![at(0.0, 0.0), at(90e3, 0.0), at(101e3, 0.0)];
    let error = Route::from_mission(&Mission { home: None, items }).unwrap_err();
    assert!(matches!(error, RouteError::TooFar { item: 3, from: "the first waypoint", .. }));
}

#[test]
fn no_more_items_than_can_be_numbered() {
    let items = vec![at(9.0, 0.0); 65_536];
    assert_eq!(route(&items).unwrap_err(), RouteError::TooLong(65_536));
    assert_eq!(route(&items[1..]).unwrap().waypoints[0].item, 65_535);
}

/// Item numbers of all visits.
fn visits(route: &Route) -> Vec<u16> {
    route.waypoints.iter().map(|waypoint| waypoint.item).collect()
}

fn jump(to: f32, times: f32) -> Item {
    command(MAV_CMD_DO_JUMP, [to, times, 0.0, 0.0])
}

#[test]
fn jumps_are_made_as_often_as_they_say() {
    let there_and_back = [at(20.0, 0.0), at(40.0, 0.0), jump(1.0, 2.0), at(0.0, 20.0)];
    assert_eq!(visits(&route(&there_and_back).unwrap()), [1, 2, 1, 2, 1, 2, 4]);
    let never = [at(20.0, 0.0), jump(1.0, 0.0), at(40.0, 0.0)];
    assert_eq!(visits(&route(&never).unwrap()), [1, 3]);
    let ahead = [at(20.0, 0.0), jump(4.0, 1.0), at(30.0, 0.0), at(40.0, 0.0)];
    let route_ahead = route(&ahead).unwrap();
    assert_eq!((visits(&route_ahead), route_ahead.unreached), (vec![1, 4], vec![3]));
    // A jump counts over the whole mission, as on ArduPilot: the inner one is used up in the first round.
    let nested = [at(10.0, 0.0), at(20.0, 0.0), jump(2.0, 1.0), at(30.0, 0.0), jump(1.0, 1.0), at(40.0, 0.0)];
    assert_eq!(visits(&route(&nested).unwrap()), [1, 2, 4, 1, 2, 4, 6].to_vec());
    let tags = [
        at(10.0, 0.0),
        command(MAV_CMD_JUMP_TAG, [7.0, 0.0, 0.0, 0.0]),
        at(20.0, 0.0),
        at(30.0, 0.0),
        command(MAV_CMD_DO_JUMP_TAG, [7.0, 1.0, 0.0, 0.0]),
    ];
    assert_eq!(visits(&route(&tags).unwrap()), [1, 3, 4, 3, 4]);
}

#[test]
fn a_mission_without_end_repeats_itself() {
    let round = [at(10.0, 0.0), at(20.0, 0.0), at(20.0, 10.0), jump(2.0, -1.0), at(0.0, 0.0)];
    let route_round = route(&round).unwrap();
    assert_eq!(visits(&route_round), [1, 2, 3, 2, 3]);
    assert_eq!((route_round.repeat_from, route_round.unreached), (Some(3), vec![5]));
    // Finite jumps are used up before the rounds are all the same.
    let both = [at(10.0, 0.0), at(20.0, 0.0), jump(1.0, 1.0), at(30.0, 0.0), jump(1.0, -1.0)];
    let route_both = route(&both).unwrap();
    assert_eq!(visits(&route_both), [1, 2, 1, 2, 4, 1, 2, 4]);
    assert_eq!(route_both.repeat_from, Some(5));
    let nowhere = [at(10.0, 0.0), jump(1.0, -1.0)];
    assert_eq!(route(&nowhere).unwrap_err(), RouteError::LoopWithoutWaypoint { item: 2 });
    let too_often = [at(10.0, 0.0), at(20.0, 0.0), jump(1.0, 65_535.0)];
    assert!(matches!(route(&too_often).unwrap_err(), RouteError::TooManyVisits { .. }));
}

#[test]
fn a_jump_used_up_once_a_round_is_refused_before_long() {
    let items = [at(10.0, 0.0), at(20.0, 0.0), jump(5.0, 65_535.0), at(30.0, 0.0), jump(1.0, -1.0)];
    assert!(matches!(route(&items).unwrap_err(), RouteError::TooManyVisits { .. }));
    let few = [at(10.0, 0.0), at(20.0, 0.0), jump(5.0, 2.0), at(30.0, 0.0), jump(1.0, -1.0)];
    let few = route(&few).unwrap();
    assert_eq!(visits(&few), [1, 2, 1, 2, 1, 2, 4, 1, 2, 4]);
    assert_eq!(few.repeat_from, Some(7));
}

#[test]
fn loiters_turn_or_wait_where_they_say() {
    let turns = Item { command: MAV_CMD_NAV_LOITER_TURNS, params: [2.0, 0.0, -15.0, 0.0], ..at(20.0, 0.0) };
    let time = command(MAV_CMD_NAV_LOITER_TIME, [30.0, 0.0, 0.0, 0.0]);
    let route_found = route(&[at(0.0, 10.0), time, turns, at(40.0, 0.0)]).unwrap();
    assert_eq!((route_found.waypoints.len(), route_found.waypoints[0].hold_s), (3, 30.0));
    let circle = Circle { radius_m: 15.0, turns: 2.0, clockwise: false };
    assert_eq!(route_found.waypoints[1].circle, Some(circle));
    let usual = Item { params: [1.0, 0.0, 0.0, 0.0], ..turns };
    let found = route(&[usual]).unwrap().waypoints[0].circle.unwrap();
    assert_eq!((found.radius_m, found.clockwise), (DEFAULT_CIRCLE_RADIUS_M, true));
    assert_eq!(route(&[time]).unwrap_err(), RouteError::NowhereYet { item: 1 });
}

#[test]
fn what_is_done_on_the_way_belongs_to_a_leg() {
    let servo = |pulse_us| command(MAV_CMD_DO_SET_SERVO, [9.0, pulse_us, 0.0, 0.0]);
    let items = [
        servo(1000.0),
        at(20.0, 0.0),
        servo(1900.0),
        command(MAV_CMD_NAV_DELAY, [60.0, 0.0, 0.0, 0.0]),
        servo(1100.0),
        command(MAV_CMD_CONDITION_DISTANCE, [8.0, 0.0, 0.0, 0.0]),
        command(MAV_CMD_DO_CHANGE_SPEED, [1.0, 0.5, -1.0, 0.0]),
        at(40.0, 0.0),
        at(60.0, 0.0),
        servo(1200.0),
    ];
    let route_found = route(&items).unwrap();
    let legs: Vec<(u16, usize)> = route_found.tasks.iter().map(|task| (task.item, task.leg)).collect();
    assert_eq!(legs, [(1, 0), (3, 1), (5, 2), (6, 2), (7, 2), (10, 4)]);
    // The delay is a stop of its own, so that the servo moves before and after it.
    assert_eq!(visits(&route_found), [2, 4, 8, 9]);
    assert!(route_found.waypoints[0].stop && route_found.waypoints[1].hold_s == 60.0);
    let speeds: Vec<_> = route_found.waypoints.iter().map(|waypoint| waypoint.speed_mps).collect();
    assert_eq!(speeds, [None, None, None, Some(0.5)], "on the leg itself the speed waits for its condition");
}

#[test]
fn going_astern_begins_and_ends_with_a_stop() {
    let reverse = |astern| command(MAV_CMD_DO_SET_REVERSE, [astern, 0.0, 0.0, 0.0]);
    let items = [at(20.0, 0.0), reverse(1.0), at(10.0, 0.0), reverse(0.0), at(20.0, 20.0)];
    let found = route(&items).unwrap().waypoints;
    let kinds: Vec<_> = found.iter().map(|waypoint| (waypoint.reverse, waypoint.is_stop())).collect();
    assert_eq!(kinds, [(false, true), (true, true), (false, false)]);
}

proptest! {
    #[test]
    fn a_route_can_be_drawn_whatever_the_mission(
        items in prop::collection::vec(
            (prop::sample::select(vec![16u16, 16, 16, 178, 93, 17, 20, 22]), any::<u8>(), any::<[f32; 4]>(),
             -300..300i32, -300..300i32, prop::bool::weighted(0.9)),
            0..12),
    ) {
        let items = items.into_iter().map(|(command, frame, params, x, y, sane)| {
            let params = if sane { [1.0, 2.0, 0.0, 0.0] } else { params };
            let frame = if sane { MAV_FRAME_GLOBAL_RELATIVE_ALT } else { frame };
            let (home_x, home_y) = HOME.to_e7();
            Item { command, frame, params, x: home_x + x, y: home_y + y, z: 0.0, autocontinue: true }
        }).collect();
        if let Ok(route) = Route::from_mission(&Mission { home: Some(HOME), items }) {
            prop_assert!(!route.waypoints.is_empty());
            prop_assert!(route.waypoints.windows(2).all(|pair| pair[0].item < pair[1].item));
            prop_assert!(route.waypoints.iter().all(|waypoint| waypoint.hold_s >= 0.0));
            let points = route.local_points(&LocalFrame::new(HOME));
            if points.len() > 1 {
                let path = crate::path::Path::through(&points, &crate::path::PathLimits::new(3.0, 1.0));
                prop_assert!(path.is_ok(), "{path:?}");
            }
        }
    }

    #[test]
    fn any_mission_is_understood_or_refused(
        items in prop::collection::vec(
            (prop::sample::select(vec![16u16, 17, 18, 19, 20, 93, 112, 114, 177, 178, 183, 194, 600, 601]),
             prop::sample::select(vec![0.0f32, 1.0, 2.0, 3.0, -1.0, 65535.0, f32::NAN]),
             prop::sample::select(vec![0.0f32, 1.0, 3.0, -1.0, 65535.0]), 0..4i32),
            0..14),
    ) {
        let items: Vec<Item> = items.into_iter().map(|(command, p1, p2, place)| {
            let near = at(f64::from(place) * 20.0, f64::from(place % 2) * 20.0);
            Item { command, params: [p1, p2, 0.0, 0.0], ..near }
        }).collect();
        let count = items.len();
        if let Ok(route) = route(&items) {
            prop_assert!(route.waypoints.iter().all(|waypoint| usize::from(waypoint.item) <= count));
            prop_assert!(route.tasks.windows(2).all(|pair| pair[0].leg <= pair[1].leg));
            prop_assert!(route.tasks.iter().all(|task| task.leg <= route.waypoints.len()));
            prop_assert!(route.repeat_from.is_none_or(|first| first < route.waypoints.len()));
            for pair in route.waypoints.windows(2) {
                let apart_m = pair[0].position.distance_m(pair[1].position);
                let may_touch = pair[0].is_stop() || pair[0].circle.is_some() || pair[1].circle.is_some();
                prop_assert!(apart_m >= MERGE_DISTANCE_M || may_touch);
            }
        }
    }
}
