//! What of the flight controller's parameters stands against steering, in words that say what to set.

use super::OutputKind;
use crate::vehicle::parameters::ParameterReader;

/// Parameters that may take the override right away at any time.
pub const WATCHED: [&str; 4] = ["SYSID_MYGCS", "MAV_GCS_SYSID", "RC_OVERRIDE_TIME", "PILOT_STEER_TYPE"];
/// The ground station whose overrides are obeyed: its name up to ArduPilot 4.6, and since.
const STATION_NAMES: [&str; 2] = ["SYSID_MYGCS", "MAV_GCS_SYSID"];

/// SERVOn_FUNCTION: steering, throttle, left and right thruster.
const STEERING: f64 = 26.0;
const THROTTLE_LEFT: f64 = 73.0;
const THROTTLE_RIGHT: f64 = 74.0;
/// Outputs whose functions are looked at.
const SERVO_FUNCTIONS: [&str; 4] =
    ["SERVO1_FUNCTION", "SERVO2_FUNCTION", "SERVO3_FUNCTION", "SERVO4_FUNCTION"];

/// What makes steering impossible, if anything.
pub fn obstacle(kind: OutputKind, ground_station_system: u8, parameters: &ParameterReader) -> Option<String> {
    if !kind.uses_sticks() {
        return None;
    }
    let own_system = f64::from(ground_station_system);
    let station = STATION_NAMES.iter().find_map(|name| parameters.value(name).map(|system| (name, system)));
    if let Some((name, system)) = station.filter(|(_, system)| *system != own_system) {
        return Some(format!(
            "the flight controller obeys overrides only from system {system} ({name}): set that to \
             {own_system}, start helmlink with --gcs-system {system}, or use --output guided"
        ));
    }
    match parameters.value("RC_OVERRIDE_TIME") {
        Some(0.0) => {
            return Some(
                "RC_OVERRIDE_TIME is 0, which forbids overrides: set it to 3, or use --output guided"
                    .to_owned(),
            );
        }
        Some(time_s) if time_s < 0.0 => {
            return Some(format!(
                "RC_OVERRIDE_TIME is {time_s}: an override would outlive its sender for ever; set it to 3 or less"
            ));
        }
        _ => {}
    }
    if parameters.value("PILOT_STEER_TYPE") == Some(1.0) {
        return Some(
            "PILOT_STEER_TYPE is 1 (two paddles): helmlink needs steering and throttle; set it to 0, or use \
             --output guided"
                .to_owned(),
        );
    }
    None
}

/// What is odd, but no obstacle.
pub fn warnings(kind: OutputKind, twin_thrusters: bool, parameters: &ParameterReader) -> Vec<String> {
    let mut found = Vec::new();
    let functions: Vec<f64> = SERVO_FUNCTIONS.iter().filter_map(|name| parameters.value(name)).collect();
    let has = |function| functions.contains(&function);
    let skid_steers = has(THROTTLE_LEFT) && has(THROTTLE_RIGHT);
    if skid_steers && !twin_thrusters {
        found.push(
            "the outputs are two thrusters (SERVOn_FUNCTION 73 and 74), but --boat has a rudder".to_owned(),
        );
    } else if has(STEERING) && !skid_steers && twin_thrusters {
        found.push("the outputs are a rudder (SERVOn_FUNCTION 26), but --boat has two thrusters".to_owned());
    }
    if kind.uses_sticks() && parameters.value("MANUAL_STR_EXPO").is_some_and(|expo| expo != 0.0) {
        found.push("MANUAL_STR_EXPO bends the steering: set it to 0".to_owned());
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::output::{OPTIONAL_PARAMETERS, PARAMETERS};
    use helmlink_wire::dialect::{CharArray, PARAM_VALUE_DATA};

    fn with(values: &[(&str, f32)]) -> ParameterReader {
        let mut parameters = ParameterReader::new(&PARAMETERS);
        parameters.wish_for(&OPTIONAL_PARAMETERS);
        parameters.require(&WATCHED);
        for &(name, param_value) in values {
            let param_id = CharArray::from(name);
            parameters.on_value(&PARAM_VALUE_DATA { param_id, param_value, ..PARAM_VALUE_DATA::DEFAULT });
        }
        parameters
    }

    #[test]
    fn every_obstacle_names_its_parameter() {
        let sound = with(&[("SYSID_MYGCS", 255.0), ("RC_OVERRIDE_TIME", 3.0), ("PILOT_STEER_TYPE", 0.0)]);
        for (name, value) in [
            ("SYSID_MYGCS", 42.0),
            ("MAV_GCS_SYSID", 42.0),
            ("RC_OVERRIDE_TIME", 0.0),
            ("RC_OVERRIDE_TIME", -1.0),
            ("PILOT_STEER_TYPE", 1.0),
        ] {
            let parameters = with(&[(name, value)]);
            for kind in OutputKind::ALL {
                assert_eq!(obstacle(kind, 255, &sound), None);
                let found = obstacle(kind, 255, &parameters);
                assert_eq!(
                    found.is_some_and(|text| text.contains(name)),
                    kind.uses_sticks(),
                    "{name} {kind}"
                );
            }
        }
        assert_eq!(obstacle(OutputKind::RcOverride, 42, &with(&[("SYSID_MYGCS", 42.0)])), None);
    }

    #[test]
    fn outputs_that_do_not_fit_the_boat_are_told() {
        let skid = with(&[("SERVO1_FUNCTION", 73.0), ("SERVO3_FUNCTION", 74.0)]);
        let rudder = with(&[("SERVO1_FUNCTION", 26.0), ("SERVO3_FUNCTION", 70.0), ("MANUAL_STR_EXPO", 0.3)]);
        assert!(warnings(OutputKind::Guided, true, &skid).is_empty());
        assert_eq!(warnings(OutputKind::Guided, false, &skid).len(), 1);
        assert_eq!(warnings(OutputKind::RcOverride, true, &rudder).len(), 2);
        assert_eq!(warnings(OutputKind::Guided, false, &rudder).len(), 0);
    }
}
