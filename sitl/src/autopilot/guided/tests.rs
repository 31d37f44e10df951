use helmlink_wire::Message;

use super::*;
use crate::autopilot::testing::{Bench, COMPANION, LINK};

fn guided() -> Bench {
    let mut bench = Bench::ready();
    bench.arm();
    bench.autopilot.enter_mode(Mode::Guided).unwrap();
    bench
}

fn attitude_target(type_mask: u8, yaw_rate: f32, thrust: f32) -> Message {
    let half = std::f32::consts::FRAC_PI_4;
    Message::SET_ATTITUDE_TARGET(SET_ATTITUDE_TARGET_DATA {
        q: [half.cos(), 0.0, 0.0, half.sin()],
        body_yaw_rate: yaw_rate,
        thrust,
        target_system: 1,
        target_component: 1,
        type_mask,
        ..SET_ATTITUDE_TARGET_DATA::DEFAULT
    })
}

fn velocity_target(type_mask: u16, vx: f32, vy: f32, yaw_rate: f32) -> Message {
    Message::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
        vx,
        vy,
        yaw_rate,
        type_mask,
        target_system: 1,
        target_component: 1,
        coordinate_frame: MAV_FRAME_LOCAL_NED,
        ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
    })
}

fn drive(bench: &mut Bench, message: &Message, seconds: u32) {
    for _ in 0..2 * seconds {
        bench.send(LINK, COMPANION, message);
        bench.run_s(0.5);
    }
}

#[test]
fn thrust_is_a_share_of_the_default_speed_and_the_yaw_rate_is_kept() {
    let mut bench = guided();
    let full_mps = navigation::default_speed_mps(&bench.autopilot.parameters);
    drive(&mut bench, &attitude_target(0x83, 0.1, 0.5), 30);
    let truth = bench.vessel.truth();
    assert!((truth.hull.u_mps - 0.5 * full_mps).abs() < 0.05 * full_mps, "{truth:?}");
    assert!((truth.hull.r_radps - 0.1).abs() < 0.01, "{truth:?}");
}

#[test]
fn attitude_is_a_heading_when_the_rate_is_ignored() {
    let mut bench = guided();
    drive(&mut bench, &attitude_target(0x07, 0.0, 0.4), 30);
    let heading_deg = bench.vessel.truth().hull.psi_rad.to_degrees();
    assert!((heading_deg - 90.0).abs() < 2.0, "{heading_deg}");
}

#[test]
fn velocity_alone_steers_its_direction_and_is_limited() {
    let mut bench = guided();
    drive(&mut bench, &velocity_target(0xDC7, 0.0, 20.0, 0.0), 40);
    let hull = bench.vessel.truth().hull;
    let full_mps = navigation::default_speed_mps(&bench.autopilot.parameters);
    assert!((hull.psi_rad.to_degrees() - 90.0).abs() < 2.0);
    assert!((hull.u_mps - full_mps).abs() < 0.05 * full_mps, "{hull:?}");
}

#[test]
fn combinations_without_meaning_are_ignored() {
    let mut bench = guided();
    let before = bench.autopilot.guided.target;
    for message in [
        velocity_target(0x1C7, 1.0, 0.0, 0.1),
        velocity_target(0xC07, 1.0, 0.0, 0.0),
        velocity_target(0xDC7, f32::NAN, 0.0, 0.0),
        attitude_target(0x40, 0.1, 0.5),
        attitude_target(0x00, f32::INFINITY, 0.5),
        attitude_target(0x07, 0.0, f32::NAN),
    ] {
        bench.send(LINK, COMPANION, &message);
        bench.run_loops(1);
        assert_eq!(bench.autopilot.guided.target, before, "{message:?}");
    }
}

#[test]
fn targets_are_ignored_outside_guided() {
    let mut bench = guided();
    bench.autopilot.enter_mode(Mode::Hold).unwrap();
    drive(&mut bench, &attitude_target(0x83, 0.1, 0.5), 2);
    assert_eq!(bench.autopilot.command, Default::default());
}

#[test]
fn a_target_lasts_three_seconds_and_then_the_place_is_kept() {
    let mut bench = guided();
    drive(&mut bench, &attitude_target(0x83, 0.0, 0.5), 10);
    bench.send(LINK, COMPANION, &attitude_target(0x83, 0.0, 0.5));
    let held = bench.run_s(2.9);
    assert!(!Bench::texts(&held).iter().any(|text| text.contains("3secs")));
    let stopped = bench.run_s(0.3);
    assert!(Bench::texts(&stopped).iter().any(|text| text.contains("3secs")));
    let there = bench.position();
    bench.run_s(60.0);
    assert!((bench.position() - there).norm() < 8.0);
    assert!(bench.vessel.truth().hull.u_mps.abs() < 0.3);
}

#[test]
fn a_place_is_reached_and_kept() {
    let mut bench = guided();
    let place = NorthEast::new(30.0, 40.0);
    let (lat_int, lon_int) = bench.autopilot.frame.to_geodetic(place).to_e7();
    let target = SET_POSITION_TARGET_GLOBAL_INT_DATA {
        lat_int,
        lon_int,
        type_mask: 0xFF8,
        target_system: 1,
        target_component: 1,
        coordinate_frame: MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
        ..SET_POSITION_TARGET_GLOBAL_INT_DATA::DEFAULT
    };
    bench.send(LINK, COMPANION, &Message::SET_POSITION_TARGET_GLOBAL_INT(target));
    bench.run_s(120.0);
    assert!((bench.position() - place).norm() < 4.0, "{:?}", bench.position());
}
