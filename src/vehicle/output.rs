//! A steering and throttle command as MAVLink, and how to let go again.
//!
//! What ArduRover does with these messages was measured on 4.6: overrides are obeyed only from the ground
//! station's system id (SYSID_MYGCS), pass a dead zone of RCn_DZ microseconds around the trim before they are
//! rescaled, and stay in force for RC_OVERRIDE_TIME after the last one; setpoints in GUIDED stay in force for 3 s.

use std::str::FromStr;

use helmlink_wire::dialect::{MANUAL_CONTROL_DATA, RC_CHANNELS_OVERRIDE_DATA, SET_ATTITUDE_TARGET_DATA};
use helmlink_wire::{Identity, Message, enums};
use serde::{Deserialize, Serialize};

use super::modes::Mode;
use super::parameters::ParameterReader;

/// By which messages the boat is steered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputKind {
    /// RC_CHANNELS_OVERRIDE of the steering and the throttle channel, in MANUAL: the quickest and most exact path.
    RcOverride,
    /// MANUAL_CONTROL, in MANUAL.
    ManualControl,
    /// SET_ATTITUDE_TARGET with turn rate and speed, in GUIDED: the firmware's own loops drive the motors.
    Guided,
}

impl OutputKind {
    /// The name as it is typed.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::RcOverride => "rc-override",
            Self::ManualControl => "manual-control",
            Self::Guided => "guided",
        }
    }

    /// The flight mode in which the firmware obeys these messages.
    pub fn mode(self) -> Mode {
        match self {
            Self::RcOverride | Self::ManualControl => Mode::MANUAL,
            Self::Guided => Mode::GUIDED,
        }
    }

    /// The firmware obeys these messages only from the system id in its SYSID_MYGCS.
    pub fn needs_ground_station_id(self) -> bool {
        self != Self::Guided
    }
}

/// A name that is none of the outputs.
#[derive(Debug, thiserror::Error)]
#[error("`{0}` is not an output: use rc-override, manual-control or guided")]
pub struct UnknownOutput(String);

impl FromStr for OutputKind {
    type Err = UnknownOutput;

    fn from_str(text: &str) -> Result<Self, UnknownOutput> {
        match text {
            "rc-override" => Ok(Self::RcOverride),
            "manual-control" => Ok(Self::ManualControl),
            "guided" => Ok(Self::Guided),
            _ => Err(UnknownOutput(text.to_owned())),
        }
    }
}

/// What the controller wants, in the two forms that the outputs need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// −1 full astern to 1 full ahead.
    pub throttle: f64,
    /// −1 full to port to 1 full to starboard.
    pub steering: f64,
    /// Speed through the firmware's own speed loop, m/s.
    pub speed_mps: f64,
    /// Turn rate through the firmware's own rate loop, rad/s, positive to starboard.
    pub yaw_rate_radps: f64,
}

impl Demand {
    /// Motors stopped, rudder amidships.
    pub const NEUTRAL: Self = Self { throttle: 0.0, steering: 0.0, speed_mps: 0.0, yaw_rate_radps: 0.0 };

    /// Every value is a number.
    fn is_finite(&self) -> bool {
        [self.throttle, self.steering, self.speed_mps, self.yaw_rate_radps]
            .iter()
            .all(|value| value.is_finite())
    }
}

/// How the firmware turns pulse widths of one channel into −1…1.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Channel {
    /// 1 to 8.
    number: usize,
    min_us: f64,
    trim_us: f64,
    max_us: f64,
    dead_zone_us: f64,
    reversed: bool,
}

/// RC_CHANNELS_OVERRIDE: leave this channel as it is.
const KEEP: u16 = u16::MAX;
/// RC_CHANNELS_OVERRIDE: give this channel back to the radio.
const RELEASE: u16 = 0;
/// MANUAL_CONTROL: this axis is not used.
const UNUSED_AXIS: i16 = i16::MAX;
/// Pulse widths that a receiver or an override may ever carry.
const PULSE_RANGE_US: (f64, f64) = (800.0, 2200.0);

/// The parameters that [`Output::configure`] reads.
pub const PARAMETERS: [&str; 15] = [
    "SYSID_MYGCS",
    "RCMAP_ROLL",
    "RCMAP_THROTTLE",
    "RC1_MIN",
    "RC1_TRIM",
    "RC1_MAX",
    "RC1_DZ",
    "RC1_REVERSED",
    "RC3_MIN",
    "RC3_TRIM",
    "RC3_MAX",
    "RC3_DZ",
    "RC3_REVERSED",
    "WP_SPEED",
    "CRUISE_SPEED",
];

/// Makes the messages that steer one vehicle.
#[derive(Debug, Clone)]
pub struct Output {
    kind: OutputKind,
    steering: Channel,
    throttle: Channel,
    full_speed_mps: f64,
}

impl Output {
    /// An output with ArduRover's default channels (steering 1, throttle 3, 1100–1500–1900 µs, dead zone 30 µs).
    pub fn new(kind: OutputKind) -> Self {
        let channel = |number| Channel {
            number,
            min_us: 1100.0,
            trim_us: 1500.0,
            max_us: 1900.0,
            dead_zone_us: 30.0,
            reversed: false,
        };
        Self { kind, steering: channel(1), throttle: channel(3), full_speed_mps: 2.0 }
    }

    /// Which kind of messages this makes.
    pub fn kind(&self) -> OutputKind {
        self.kind
    }

    /// Takes over the vehicle's channel calibration and speed limits, as far as they are known.
    ///
    /// # Errors
    /// The channel map points beyond the channels that Helmlink can calibrate: says which parameter to set.
    pub fn configure(&mut self, parameters: &ParameterReader) -> Result<(), String> {
        for (map, expected) in [("RCMAP_ROLL", 1.0), ("RCMAP_THROTTLE", 3.0)] {
            let mapped = parameters.value(map).unwrap_or(expected);
            if mapped != expected && self.kind == OutputKind::RcOverride {
                return Err(format!(
                    "{map} is {mapped}: helmlink needs {expected}; set it, or use --output guided"
                ));
            }
        }
        calibrate(
            &mut self.steering,
            parameters,
            ["RC1_MIN", "RC1_TRIM", "RC1_MAX", "RC1_DZ", "RC1_REVERSED"],
        );
        calibrate(
            &mut self.throttle,
            parameters,
            ["RC3_MIN", "RC3_TRIM", "RC3_MAX", "RC3_DZ", "RC3_REVERSED"],
        );
        if let Some(speed_mps) = full_speed_mps(parameters) {
            self.full_speed_mps = speed_mps;
        }
        Ok(())
    }

    /// The message that carries out `demand`; anything that is not a number becomes neutral.
    pub fn drive(&self, vehicle: Identity, demand: Demand) -> Message {
        let demand = if demand.is_finite() { demand } else { Demand::NEUTRAL };
        match self.kind {
            OutputKind::RcOverride => {
                let steering = pulse_us(&self.steering, demand.steering);
                self.override_channels(vehicle, steering, pulse_us(&self.throttle, demand.throttle))
            }
            OutputKind::ManualControl => manual_control(
                vehicle,
                self.stick(&self.steering, demand.steering),
                self.stick(&self.throttle, demand.throttle),
            ),
            OutputKind::Guided => self.attitude_target(vehicle, demand),
        }
    }

    /// The message that lets go at once, if this output has one: setpoints in GUIDED simply end.
    pub fn release(&self, vehicle: Identity) -> Option<Message> {
        match self.kind {
            OutputKind::RcOverride => Some(self.override_channels(vehicle, RELEASE, RELEASE)),
            // MANUAL_CONTROL has no release of its own, but sets the same overrides.
            OutputKind::ManualControl => Some(self.override_channels(vehicle, RELEASE, RELEASE)),
            OutputKind::Guided => None,
        }
    }

    fn override_channels(&self, vehicle: Identity, steering_us: u16, throttle_us: u16) -> Message {
        let mut channels = [KEEP; 8];
        for (channel, pulse) in [(self.steering, steering_us), (self.throttle, throttle_us)] {
            channels[channel.number - 1] = pulse;
        }
        let [chan1_raw, chan2_raw, chan3_raw, chan4_raw, chan5_raw, chan6_raw, chan7_raw, chan8_raw] =
            channels;
        Message::RC_CHANNELS_OVERRIDE(RC_CHANNELS_OVERRIDE_DATA {
            target_system: vehicle.system,
            target_component: vehicle.component,
            chan1_raw,
            chan2_raw,
            chan3_raw,
            chan4_raw,
            chan5_raw,
            chan6_raw,
            chan7_raw,
            chan8_raw,
            ..RC_CHANNELS_OVERRIDE_DATA::DEFAULT
        })
    }

    /// MANUAL_CONTROL's ±1000 spans a channel from end to end, so the dead zone has to be crossed here too.
    fn stick(&self, channel: &Channel, value: f64) -> i16 {
        let pulse = f64::from(pulse_us(channel, value));
        let ratio = (pulse - channel.min_us) / (channel.max_us - channel.min_us);
        ((ratio * 2000.0).round() - 1000.0).clamp(-1000.0, 1000.0) as i16
    }

    fn attitude_target(&self, vehicle: Identity, demand: Demand) -> Message {
        let thrust = (demand.speed_mps / self.full_speed_mps).clamp(-1.0, 1.0);
        Message::SET_ATTITUDE_TARGET(SET_ATTITUDE_TARGET_DATA {
            target_system: vehicle.system,
            target_component: vehicle.component,
            type_mask: enums::ATTITUDE_TARGET_TYPEMASK_BODY_ROLL_RATE_IGNORE
                | enums::ATTITUDE_TARGET_TYPEMASK_BODY_PITCH_RATE_IGNORE
                | enums::ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE,
            q: [1.0, 0.0, 0.0, 0.0],
            body_yaw_rate: demand.yaw_rate_radps as f32,
            thrust: thrust as f32,
            ..SET_ATTITUDE_TARGET_DATA::DEFAULT
        })
    }
}

/// The speed that the firmware takes thrust 1 for: WP_SPEED, or CRUISE_SPEED where that is zero.
pub fn full_speed_mps(parameters: &ParameterReader) -> Option<f64> {
    [parameters.value("WP_SPEED"), parameters.value("CRUISE_SPEED")]
        .into_iter()
        .flatten()
        .find(|&speed| speed > 0.0)
}

fn calibrate(channel: &mut Channel, parameters: &ParameterReader, names: [&str; 5]) {
    let [min, trim, max, dead_zone, reversed] = names.map(|name| parameters.value(name));
    let candidate = Channel {
        number: channel.number,
        min_us: min.unwrap_or(channel.min_us),
        trim_us: trim.unwrap_or(channel.trim_us),
        max_us: max.unwrap_or(channel.max_us),
        dead_zone_us: dead_zone.unwrap_or(channel.dead_zone_us),
        reversed: reversed.map_or(channel.reversed, |value| value != 0.0),
    };
    let room_us = candidate.dead_zone_us.max(0.0);
    let is_sound = candidate.dead_zone_us >= 0.0
        && candidate.min_us + room_us < candidate.trim_us
        && candidate.trim_us + room_us < candidate.max_us;
    if is_sound {
        *channel = candidate;
    }
}

/// The pulse width that the firmware reads as `value` (−1…1).
fn pulse_us(channel: &Channel, value: f64) -> u16 {
    let value = if channel.reversed { -value } else { value }.clamp(-1.0, 1.0);
    let pulse = if value > 0.0 {
        let start = channel.trim_us + channel.dead_zone_us;
        start + value * (channel.max_us - start)
    } else if value < 0.0 {
        let start = channel.trim_us - channel.dead_zone_us;
        start + value * (start - channel.min_us)
    } else {
        channel.trim_us
    };
    pulse.clamp(PULSE_RANGE_US.0, PULSE_RANGE_US.1).round() as u16
}

fn manual_control(vehicle: Identity, steering: i16, throttle: i16) -> Message {
    Message::MANUAL_CONTROL(MANUAL_CONTROL_DATA {
        target: vehicle.system,
        x: UNUSED_AXIS,
        y: steering,
        z: throttle,
        r: UNUSED_AXIS,
        ..MANUAL_CONTROL_DATA::DEFAULT
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use helmlink_wire::dialect::{CharArray, PARAM_VALUE_DATA};

    const VEHICLE: Identity = Identity { system: 1, component: 1 };

    fn demand(throttle: f64, steering: f64) -> Demand {
        Demand { throttle, steering, speed_mps: 1.0, yaw_rate_radps: 0.1 }
    }

    fn overrides(output: &Output, demand: Demand) -> (u16, u16) {
        match output.drive(VEHICLE, demand) {
            Message::RC_CHANNELS_OVERRIDE(data) => {
                assert_eq!([data.chan2_raw, data.chan4_raw, data.chan8_raw], [KEEP; 3]);
                (data.chan1_raw, data.chan3_raw)
            }
            other => panic!("{other:?}"),
        }
    }

    /// The firmware's own reading of a pulse width.
    fn firmware_reads(pulse: u16, channel: &Channel) -> f64 {
        let offset = f64::from(pulse) - channel.trim_us;
        let past = offset.abs() - channel.dead_zone_us;
        let span =
            if offset > 0.0 { channel.max_us - channel.trim_us } else { channel.trim_us - channel.min_us };
        let value = if past > 0.0 { offset.signum() * past / (span - channel.dead_zone_us) } else { 0.0 };
        if channel.reversed { -value } else { value }
    }

    #[test]
    fn the_firmware_reads_back_what_was_wanted() {
        let mut output = Output::new(OutputKind::RcOverride);
        for reversed in [false, true] {
            output.steering.reversed = reversed;
            for step in -20..=20 {
                let wanted = f64::from(step) / 20.0;
                let (steering_us, throttle_us) = overrides(&output, demand(wanted, wanted));
                assert!((firmware_reads(steering_us, &output.steering) - wanted).abs() < 2e-3);
                assert!((firmware_reads(throttle_us, &output.throttle) - wanted).abs() < 2e-3);
            }
        }
    }

    #[test]
    fn not_a_number_becomes_neutral() {
        let output = Output::new(OutputKind::RcOverride);
        assert_eq!(overrides(&output, demand(f64::NAN, 0.5)), (1500, 1500));
        assert_eq!(overrides(&output, demand(0.5, f64::INFINITY)), (1500, 1500));
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
        for (name, param_value) in [("WP_SPEED", 0.0), ("CRUISE_SPEED", 4.0)] {
            let param_id = CharArray::from(name);
            parameters.on_value(&PARAM_VALUE_DATA { param_id, param_value, ..PARAM_VALUE_DATA::DEFAULT });
        }
        let mut output = Output::new(OutputKind::Guided);
        output.configure(&parameters).unwrap();
        let Message::SET_ATTITUDE_TARGET(data) = output.drive(VEHICLE, demand(0.0, 0.0)) else { panic!() };
        assert!((data.thrust - 0.25).abs() < 1e-6 && (data.body_yaw_rate - 0.1).abs() < 1e-6);
        assert_eq!(data.type_mask, 0x83);
    }

    #[test]
    fn a_calibration_that_makes_no_sense_is_not_taken() {
        let mut parameters = ParameterReader::new(&PARAMETERS);
        let param_id = CharArray::from("RC1_MIN");
        parameters.on_value(&PARAM_VALUE_DATA { param_id, param_value: 1800.0, ..PARAM_VALUE_DATA::DEFAULT });
        let mut output = Output::new(OutputKind::RcOverride);
        output.configure(&parameters).unwrap();
        assert_eq!(output.steering, Output::new(OutputKind::RcOverride).steering);
    }
}
