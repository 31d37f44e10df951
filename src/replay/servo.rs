//! What really went to the motors and the rudder, from SERVO_OUTPUT_RAW.

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

/// How one output is set up.
#[derive(Debug, Clone, Copy)]
struct Servo {
    function: Option<f32>,
    min_us: f64,
    trim_us: f64,
    max_us: f64,
    is_reversed: bool,
}

impl Servo {
    const DEFAULT: Self =
        Self { function: None, min_us: 1100.0, trim_us: 1500.0, max_us: 1900.0, is_reversed: false };

    /// −1…1 of a pulse width; none where the output is switched off.
    fn normalised(&self, pulse_us: u16) -> Option<f64> {
        let sign = if self.is_reversed { -1.0 } else { 1.0 };
        let off_us = f64::from(pulse_us) - self.trim_us;
        let span_us = if off_us > 0.0 { self.max_us - self.trim_us } else { self.trim_us - self.min_us };
        (pulse_us != 0 && span_us > 0.0).then(|| sign * (off_us / span_us).clamp(-1.0, 1.0))
    }
}

/// Reads the outputs of one vehicle, calibrated by its parameters as far as the log shows them.
#[derive(Debug, Clone)]
pub struct ServoReader {
    servos: [Servo; OUTPUTS],
    latest: Option<Outputs>,
}

impl Default for ServoReader {
    fn default() -> Self {
        Self { servos: [Servo::DEFAULT; OUTPUTS], latest: None }
    }
}

impl ServoReader {
    /// Takes a parameter.
    pub fn on_parameter(&mut self, data: &PARAM_VALUE_DATA) {
        let name = data.param_id.to_str().ok().and_then(|name| name.strip_prefix("SERVO"));
        let Some((number, what)) = name.and_then(|name| name.split_once('_')) else { return };
        let index = number.parse().ok().and_then(|number: usize| number.checked_sub(1));
        let Some(servo) = index.and_then(|index| self.servos.get_mut(index)) else { return };
        let value = data.param_value;
        match what {
            _ if !value.is_finite() => {}
            "FUNCTION" => servo.function = Some(value),
            "MIN" => servo.min_us = value.into(),
            "TRIM" => servo.trim_us = value.into(),
            "MAX" => servo.max_us = value.into(),
            "REVERSED" => servo.is_reversed = value != 0.0,
            _ => {}
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
            let known = self.servos.iter().position(|servo| servo.function == Some(function));
            known.or(or).and_then(|index| self.servos[index].normalised(pulses[index]))
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
}
