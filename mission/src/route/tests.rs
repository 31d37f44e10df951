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
    let servo = error(&[at(9.0, 0.0), command(MAV_CMD_DO_SET_SERVO, [7.0, 1500.0, 0.0, 0.0])]);
    assert_eq!(servo, RouteError::Unsupported { item: 2, command: CommandName(183) });
    assert!(servo.to_string().starts_with("item 2: MAV_CMD_DO_SET_SERVO (183) is not supported"), "{servo}");
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
    ] {
        let error = error(&[at(9.0, 0.0), command(code, params)]);
        assert!(matches!(error, RouteError::Parameter { item: 2, .. }), "{error}");
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
}
