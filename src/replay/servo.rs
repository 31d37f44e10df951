//! What really went to the motors and the rudder, from SERVO_OUTPUT_RAW.

use std::collections::BTreeMap;

use helmlink_wire::dialect::{PARAM_VALUE_DATA, SERVO_OUTPUT_RAW_DATA};

/// SERVOn_FUNCTION of ArduRover (<https://ardupilot.org/rover/docs/parameters.html#servo1-function>).
const GROUND_STEERING: f32 = 26.0;
const THROTTLE: f32 = 70.0;
const THROTTLE_LEFT: f32 = 73.0;
const THROTTLE_RIGHT: f32 = 74.0;
/// Outputs that SERVO_OUTPUT_RAW carries in the fields that every autopilot fills.
const OUTPUTS: usize = 8;

/// Steering and throttle as the autopilot put them out, each −1…1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// Steering, positive to starboard.
    pub steering: f64,
    /// Throttle, positive ahead.
    pub throttle: f64,
}

/// Reads the outputs of one vehicle, calibrated by its parameters as far as the log shows them.
#[derive(Debug, Clone, Default)]
pub struct ServoReader {
    parameters: BTreeMap<String, f32>,
    latest: Option<Outputs>,
}

impl ServoReader {
    /// Takes a parameter.
    pub fn on_parameter(&mut self, data: &PARAM_VALUE_DATA) {
        if let Ok(name) = data.param_id.to_str()
            && name.starts_with("SERVO")
            && data.param_value.is_finite()
        {
            self.parameters.insert(name.to_owned(), data.param_value);
        }
    }

    /// Takes the outputs.
    pub fn on_outputs(&mut self, data: &SERVO_OUTPUT_RAW_DATA) {
        // Port 1 has the outputs from 17 on.
        if data.port != 0 {
            return;
        }
        let pulses = [
            data.servo1_raw,
            data.servo2_raw,
            data.servo3_raw,
            data.servo4_raw,
            data.servo5_raw,
            data.servo6_raw,
            data.servo7_raw,
            data.servo8_raw,
        ];
        let of = |function: f32, or: Option<usize>| {
            let known = (0..OUTPUTS).find(|&index| self.parameter(index, "FUNCTION") == Some(function));
            known.or(or).and_then(|index| self.normalised(index, pulses[index]))
        };
        let twin = (of(THROTTLE_LEFT, None), of(THROTTLE_RIGHT, None));
        self.latest = if let (Some(left), Some(right)) = twin {
            Some(Outputs { steering: (left - right) / 2.0, throttle: (left + right) / 2.0 })
        } else {
            // Without parameters: ArduRover's usual places.
            of(GROUND_STEERING, Some(0))
                .zip(of(THROTTLE, Some(2)))
                .map(|(steering, throttle)| Outputs { steering, throttle })
        };
    }

    /// What was put out last.
    pub fn latest(&self) -> Option<Outputs> {
        self.latest
    }

    fn parameter(&self, index: usize, what: &str) -> Option<f32> {
        self.parameters.get(&format!("SERVO{}_{what}", index + 1)).copied()
    }

    /// −1…1 of a pulse width; none where the output is switched off.
    fn normalised(&self, index: usize, pulse_us: u16) -> Option<f64> {
        let of = |what: &str, or: f32| f64::from(self.parameter(index, what).unwrap_or(or));
        let (min_us, trim_us, max_us) = (of("MIN", 1100.0), of("TRIM", 1500.0), of("MAX", 1900.0));
        let sign = if of("REVERSED", 0.0) == 0.0 { 1.0 } else { -1.0 };
        let off_us = f64::from(pulse_us) - trim_us;
        let span_us = if off_us > 0.0 { max_us - trim_us } else { trim_us - min_us };
        (pulse_us != 0 && span_us > 0.0).then(|| sign * (off_us / span_us).clamp(-1.0, 1.0))
    }
}
