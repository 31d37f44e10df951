//! From steering and throttle to servo pulses, and from pulses to what the actuators do.

use super::parameters::*;
use super::steering::Command;
use crate::physics::ActuatorCommand;

/// Outputs of SERVO_OUTPUT_RAW.
pub(super) const OUTPUTS: usize = 16;
/// Half of the range of a servo as the boat's actuators are wired: 1500 ± 500 µs.
const HALF_RANGE_US: f64 = 500.0;
const CENTRE_US: f64 = 1500.0;

/// SERVOn_FUNCTION numbers of ArduPilot.
pub(super) mod function {
    pub(in crate::autopilot) const NONE: i32 = 0;
    pub(in crate::autopilot) const STEERING: i32 = 26;
    pub(in crate::autopilot) const THROTTLE: i32 = 70;
    pub(in crate::autopilot) const THROTTLE_LEFT: i32 = 73;
    pub(in crate::autopilot) const THROTTLE_RIGHT: i32 = 74;
}

/// The outputs of the autopilot.
#[derive(Debug, Clone, Default)]
pub(super) struct Outputs {
    pulses_us: [u16; OUTPUTS],
    /// Set by DO_SET_SERVO, on outputs without a function.
    set_us: [u16; OUTPUTS],
    throttle: f64,
}

impl Outputs {
    /// The pulses, µs; 0 on unused outputs.
    pub(super) fn pulses_us(&self) -> &[u16; OUTPUTS] {
        &self.pulses_us
    }

    /// The throttle after slew limiting, [−1, 1].
    pub(super) fn throttle(&self) -> f64 {
        self.throttle
    }

    /// Load of the motors, [0, 1]: the mean of the cubes of their speeds.
    pub(super) fn motor_load(&self, twin: bool) -> f64 {
        match self.actuators(twin) {
            ActuatorCommand::TwinThrusters { left, right } => {
                0.5 * (left.abs().powi(3) + right.abs().powi(3)).min(2.0)
            }
            ActuatorCommand::ThrottleSteering { throttle, .. } => throttle.abs().powi(3).min(1.0),
        }
    }

    /// DO_SET_SERVO; false if the output does not exist or has a function.
    pub(super) fn set(&mut self, output: usize, pulse_us: u16, parameters: &Parameters) -> bool {
        let free = match output {
            1..=CHANNELS => parameters.int(servo(output, ServoField::Function)) == function::NONE,
            _ => output <= OUTPUTS && output > 0,
        };
        if free {
            self.set_us[output - 1] = pulse_us;
        }
        free
    }

    /// Puts out a command, one loop of `dt_s` after the last. The throttle is limited in its rate
    /// (MOT_SLEWRATE, per cent per second) and kept at neutral while disarmed; steering is neither.
    pub(super) fn put(&mut self, command: Command, armed: bool, parameters: &Parameters, dt_s: f64) {
        self.throttle = if armed {
            let most = parameters.get(MOT_THR_MAX) / 100.0;
            self.slewed(command.throttle.clamp(-most, most), parameters, dt_s)
        } else {
            0.0
        };
        let (left, right) = if armed { mixed(command.steering, self.throttle) } else { (0.0, 0.0) };
        for output in 1..=OUTPUTS {
            let assigned =
                if output <= CHANNELS { parameters.int(servo(output, ServoField::Function)) } else { 0 };
            self.pulses_us[output - 1] = match assigned {
                function::STEERING => pulse_us(output, command.steering, parameters),
                function::THROTTLE => pulse_us(output, self.throttle, parameters),
                function::THROTTLE_LEFT => pulse_us(output, left, parameters),
                function::THROTTLE_RIGHT => pulse_us(output, right, parameters),
                _ => self.set_us[output - 1],
            };
        }
    }

    fn slewed(&self, throttle: f64, parameters: &Parameters, dt_s: f64) -> f64 {
        let rate = parameters.get(MOT_SLEWRATE) / 100.0;
        if rate <= 0.0 {
            return throttle;
        }
        throttle.clamp(self.throttle - rate * dt_s, self.throttle + rate * dt_s)
    }

    /// What the pulses make the boat's actuators do: steering on output 1 and throttle on output 3, or the
    /// left and the right thruster there.
    pub(super) fn actuators(&self, twin: bool) -> ActuatorCommand {
        let share = |output: usize| (f64::from(self.pulses_us[output - 1]) - CENTRE_US) / HALF_RANGE_US;
        // No pulse at all moves nothing.
        let share = |output: usize| if self.pulses_us[output - 1] == 0 { 0.0 } else { share(output) };
        if twin {
            ActuatorCommand::TwinThrusters { left: share(1), right: share(3) }
        } else {
            ActuatorCommand::ThrottleSteering { steering: share(1), throttle: share(3) }
        }
    }
}

/// Left and right thruster. What exceeds full power is scaled down evenly, so the ratio of turning to
/// driving is kept (MOT_STR_THR_MIX at its default of one half).
fn mixed(steering: f64, throttle: f64) -> (f64, f64) {
    let scale = (steering.abs() + throttle.abs()).max(1.0);
    ((throttle + steering) / scale, (throttle - steering) / scale)
}

fn pulse_us(output: usize, value: f64, parameters: &Parameters) -> u16 {
    let value = if parameters.int(servo(output, ServoField::Reversed)) == 1 { -value } else { value };
    let trim = parameters.get(servo(output, ServoField::Trim));
    let end = if value >= 0.0 { ServoField::Max } else { ServoField::Min };
    let reach = (parameters.get(servo(output, end)) - trim).abs();
    // Cut, not rounded, as the firmware's integer arithmetic does; the slack undoes binary fractions.
    (trim + (value * reach * (1.0 + 1e-9)).trunc()) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_S: f64 = 0.02;

    fn parameters(twin: bool) -> Parameters {
        let mut parameters = Parameters::new();
        let functions = if twin { [73.0, 74.0] } else { [26.0, 70.0] };
        parameters.put(servo(1, ServoField::Function), functions[0]);
        parameters.put(servo(3, ServoField::Function), functions[1]);
        parameters
    }

    #[test]
    fn the_throttle_slews_ten_microseconds_per_loop_and_steering_does_not() {
        let parameters = parameters(false);
        let mut outputs = Outputs::default();
        let command = Command { steering: 1.0, throttle: 1.0 };
        outputs.put(command, true, &parameters, DT_S);
        assert_eq!((outputs.pulses_us[0], outputs.pulses_us[2]), (2000, 1510));
        for _ in 0..49 {
            outputs.put(command, true, &parameters, DT_S);
        }
        assert_eq!(outputs.pulses_us[2], 2000);
        assert_eq!(outputs.pulses_us[4], 0, "unused");
    }

    #[test]
    fn disarmed_the_motors_are_neutral() {
        for twin in [false, true] {
            let parameters = parameters(twin);
            let mut outputs = Outputs::default();
            outputs.put(Command { steering: 0.5, throttle: 1.0 }, false, &parameters, DT_S);
            assert_eq!(outputs.pulses_us[2], 1500);
            assert_eq!(outputs.pulses_us[0], if twin { 1500 } else { 1750 });
        }
    }

    #[test]
    fn two_thrusters_share_steering_and_throttle() {
        assert_eq!(mixed(0.25, 0.5), (0.75, 0.25));
        let (left, right) = mixed(1.0, 1.0);
        assert_eq!((left, right), (1.0, 0.0));
        let mut parameters = parameters(true);
        parameters.put(MOT_SLEWRATE, 0.0);
        let mut outputs = Outputs::default();
        outputs.put(Command { steering: 0.25, throttle: 0.5 }, true, &parameters, DT_S);
        assert_eq!(outputs.actuators(true), ActuatorCommand::TwinThrusters { left: 0.75, right: 0.25 });
    }

    #[test]
    fn only_free_outputs_can_be_set() {
        let parameters = parameters(false);
        let mut outputs = Outputs::default();
        assert!(!outputs.set(1, 1900, &parameters));
        assert!(!outputs.set(0, 1900, &parameters));
        assert!(!outputs.set(17, 1900, &parameters));
        assert!(outputs.set(9, 1900, &parameters) && outputs.set(2, 1900, &parameters));
        outputs.put(Command::default(), true, &parameters, DT_S);
        assert_eq!((outputs.pulses_us[1], outputs.pulses_us[8]), (1900, 1900));
    }

    #[test]
    fn a_reversed_servo_really_turns_the_other_way() {
        let mut parameters = parameters(false);
        parameters.put(servo(1, ServoField::Reversed), 1.0);
        let mut outputs = Outputs::default();
        outputs.put(Command { steering: 0.4, throttle: 0.0 }, true, &parameters, DT_S);
        let expected = ActuatorCommand::ThrottleSteering { steering: -0.4, throttle: 0.0 };
        assert_eq!(outputs.actuators(false), expected);
    }
}
