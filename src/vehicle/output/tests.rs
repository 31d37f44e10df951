//! The messages, as the firmware takes them.

use super::*;
use helmlink_wire::dialect::{CharArray, PARAM_VALUE_DATA};

const VEHICLE: Identity = Identity { system: 1, component: 1 };

fn set(parameters: &mut ParameterReader, name: &str, param_value: f32) {
    let param_id = CharArray::from(name);
    parameters.on_value(&PARAM_VALUE_DATA { param_id, param_value, ..PARAM_VALUE_DATA::DEFAULT });
}

fn demand(throttle: f64, steering: f64) -> Demand {
    Demand { throttle, steering, speed_mps: 1.0, yaw_rate_radps: 0.1, ground_per_water: 1.0 }
}

fn overrides(output: &mut Output, demand: Demand) -> (u16, u16) {
    match output.drive(0.0, VEHICLE, demand) {
        Message::RC_CHANNELS_OVERRIDE(data) => {
            assert_eq!([data.chan2_raw, data.chan4_raw, data.chan8_raw], [KEEP; 3]);
            (data.chan1_raw, data.chan3_raw)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn throttle_between_two_steps_is_right_in_the_mean() {
    let mut output = Output::new(OutputKind::RcOverride);
    let channel = output.throttle;
    let mut sum = 0.0;
    for _ in 0..1000 {
        let (_, throttle_us) = overrides(&mut output, demand(0.4437, 0.0));
        let percent = (100.0 * (f64::from(throttle_us) - 1530.0) / (channel.max_us - 1530.0)).trunc();
        assert!((44.0..=45.0).contains(&percent));
        sum += percent;
    }
    assert!((sum / 1000.0 - 44.37).abs() < 0.05, "{}", sum / 1000.0);
    assert_eq!(overrides(&mut output, Demand::NEUTRAL), (1500, 1500));
}

#[test]
fn every_channel_map_is_followed() {
    let mut parameters = ParameterReader::new(&PARAMETERS);
    set(&mut parameters, "RCMAP_ROLL", 4.0);
    set(&mut parameters, "RCMAP_THROTTLE", 2.0);
    let names = channel_parameters(&parameters);
    assert!(names.contains(&"RC4_TRIM") && names.contains(&"RC2_DZ") && names.len() == 10);
    parameters.require(&names);
    set(&mut parameters, "RC4_REVERSED", 1.0);
    set(&mut parameters, "RC2_DZ", 0.0);
    let mut output = Output::new(OutputKind::RcOverride);
    output.configure(&parameters).unwrap();
    let Message::RC_CHANNELS_OVERRIDE(data) = output.drive(0.0, VEHICLE, demand(1.0, 1.0)) else { panic!() };
    assert_eq!([data.chan4_raw, data.chan2_raw, data.chan1_raw, data.chan3_raw], [1100, 1900, KEEP, KEEP]);
    set(&mut parameters, "RCMAP_THROTTLE", 4.0);
    assert!(output.configure(&parameters).unwrap_err().contains("RCMAP_ROLL"));
    set(&mut parameters, "RCMAP_THROTTLE", 9.0);
    assert!(output.configure(&parameters).unwrap_err().contains("RCMAP_THROTTLE"));
}

#[test]
fn a_velocity_target_carries_speed_and_turn_rate() {
    let mut output = Output::new(OutputKind::GuidedVelocity);
    let Message::SET_POSITION_TARGET_LOCAL_NED(data) = output.drive(0.0, VEHICLE, demand(0.0, 0.0)) else {
        panic!()
    };
    assert_eq!((data.type_mask, data.coordinate_frame), (0x5C7, 8));
    assert_eq!((data.vx, data.yaw_rate), (1.0, 0.1));
    assert!(output.release(VEHICLE).is_none());
}

#[test]
fn not_a_number_becomes_neutral() {
    let mut output = Output::new(OutputKind::RcOverride);
    assert_eq!(overrides(&mut output, demand(f64::NAN, 0.5)), (1500, 1500));
    assert_eq!(overrides(&mut output, demand(0.5, f64::INFINITY)), (1500, 1500));
}

#[test]
fn lets_go_of_its_own_channels_only() {
    let Some(Message::RC_CHANNELS_OVERRIDE(data)) = Output::new(OutputKind::RcOverride).release(VEHICLE)
    else {
        panic!("no release");
    };
    assert_eq!((data.chan1_raw, data.chan3_raw, data.chan2_raw), (RELEASE, RELEASE, KEEP));
    assert!(Output::new(OutputKind::Guided).release(VEHICLE).is_none());
}

#[test]
fn guided_speed_is_a_share_of_the_vehicles_own() {
    let mut parameters = ParameterReader::new(&PARAMETERS);
    set(&mut parameters, "WP_SPEED", 0.0);
    set(&mut parameters, "CRUISE_SPEED", 4.0);
    let mut output = Output::new(OutputKind::Guided);
    output.configure(&parameters).unwrap();
    let Message::SET_ATTITUDE_TARGET(data) = output.drive(0.0, VEHICLE, demand(0.0, 0.0)) else { panic!() };
    assert!((data.thrust - 0.25).abs() < 1e-6 && (data.body_yaw_rate - 0.1).abs() < 1e-6);
    assert_eq!(data.type_mask, 0x83);
}

#[test]
fn a_calibration_that_makes_no_sense_is_not_taken() {
    let mut parameters = ParameterReader::new(&PARAMETERS);
    parameters.require(&channel_parameters(&parameters));
    set(&mut parameters, "RC1_MIN", 1800.0);
    let mut output = Output::new(OutputKind::RcOverride);
    output.configure(&parameters).unwrap();
    assert_eq!(output.steering, Output::new(OutputKind::RcOverride).steering);
}
