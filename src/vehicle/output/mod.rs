//! A steering and throttle command as MAVLink, and how to let go again.
//!
//! What ArduRover does with these messages was measured on 4.6: overrides are obeyed only from the ground
//! station's system id (SYSID_MYGCS), pass a dead zone of RCn_DZ microseconds around the trim before they are
//! rescaled, and stay in force for RC_OVERRIDE_TIME after the last one; setpoints in GUIDED stay in force for 3 s.

mod channel;
pub mod checks;
mod kind;
mod rate_loop;

use helmlink_wire::dialect::{
    MANUAL_CONTROL_DATA, RC_CHANNELS_OVERRIDE_DATA, SET_ATTITUDE_TARGET_DATA,
    SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use helmlink_wire::{Identity, Message, enums};

use self::channel::{CHANNELS, Channel};
pub use self::kind::{OutputKind, UnknownOutput};
use self::rate_loop::RateLoop;
use super::parameters::ParameterReader;

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
    /// Speed over ground over speed through the water, where the steering needs the water's flow; 1 where it does not.
    pub ground_per_water: f64,
}

impl Demand {
    /// Motors stopped, rudder amidships.
    pub const NEUTRAL: Self =
        Self { throttle: 0.0, steering: 0.0, speed_mps: 0.0, yaw_rate_radps: 0.0, ground_per_water: 1.0 };

    /// Every value is a number.
    fn is_finite(&self) -> bool {
        let values =
            [self.throttle, self.steering, self.speed_mps, self.yaw_rate_radps, self.ground_per_water];
        values.iter().all(|value| value.is_finite())
    }
}

/// RC_CHANNELS_OVERRIDE: leave this channel as it is.
const KEEP: u16 = u16::MAX;
/// RC_CHANNELS_OVERRIDE: give this channel back to the radio.
const RELEASE: u16 = 0;
/// MANUAL_CONTROL: this axis is not used.
const UNUSED_AXIS: i16 = i16::MAX;
/// Whole steps a side that the firmware cuts steering to (hundredths of a degree), and throttle (per cent).
const STEERING_STEPS: f64 = 4500.0;
const THROTTLE_STEPS: f64 = 100.0;

/// The parameters that [`Output::configure`] and [`checks`] read; those of the channels in use come on top:
/// [`channel_parameters`].
pub const PARAMETERS: [&str; 6] =
    ["SYSID_MYGCS", "RCMAP_ROLL", "RCMAP_THROTTLE", "RC_OVERRIDE_TIME", "WP_SPEED", "CRUISE_SPEED"];

/// Parameters that are looked at where the vehicle has them.
pub const OPTIONAL_PARAMETERS: [&str; 11] = [
    "PILOT_STEER_TYPE",
    "MANUAL_STR_EXPO",
    "FS_GCS_ENABLE",
    "FS_GCS_TIMEOUT",
    "SERVO1_FUNCTION",
    "SERVO2_FUNCTION",
    "SERVO3_FUNCTION",
    "SERVO4_FUNCTION",
    rate_loop::NAMES[0],
    rate_loop::NAMES[1],
    rate_loop::NAMES[2],
];

/// What is to be read once [`PARAMETERS`] have been answered: the calibration of the channels in use, and the ground
/// station's id under its newer name where the older one is not known.
pub fn further_parameters(parameters: &ParameterReader) -> Vec<&'static str> {
    let mut names = channel_parameters(parameters);
    if parameters.value("SYSID_MYGCS").is_none() {
        names.push("MAV_GCS_SYSID");
    }
    names
}

/// The calibration parameters of the channels that steer, as far as the channel map is known.
pub fn channel_parameters(parameters: &ParameterReader) -> Vec<&'static str> {
    let mapped =
        [mapped_channel(parameters, "RCMAP_ROLL", 1), mapped_channel(parameters, "RCMAP_THROTTLE", 3)];
    mapped.into_iter().flatten().flat_map(|number| channel::NAMES[number - 1]).collect()
}

/// The channel that an `RCMAP_` parameter names; none when it is beyond the first eight.
fn mapped_channel(parameters: &ParameterReader, map: &str, usual: usize) -> Option<usize> {
    let number = parameters.value(map).map_or(usual, |value| value as usize);
    (1..=CHANNELS).contains(&number).then_some(number)
}

/// Makes the messages that steer one vehicle.
#[derive(Debug, Clone)]
pub struct Output {
    kind: OutputKind,
    steering: Channel,
    throttle: Channel,
    full_speed_mps: f64,
    /// What of the throttle wanted so far has been cut off: it is made up for later, so that the mean is right.
    throttle_owed: f64,
    rate_loop: RateLoop,
}

impl Output {
    /// An output with ArduRover's default channels (steering 1, throttle 3, 1100–1500–1900 µs, dead zone 30 µs).
    pub fn new(kind: OutputKind) -> Self {
        Self {
            kind,
            steering: Channel::new(1, STEERING_STEPS),
            throttle: Channel::new(3, THROTTLE_STEPS),
            full_speed_mps: 2.0,
            throttle_owed: 0.0,
            rate_loop: RateLoop::default(),
        }
    }

    /// Which kind of messages this makes.
    pub fn kind(&self) -> OutputKind {
        self.kind
    }

    /// Takes over the vehicle's channel calibration and speed limits, as far as they are known.
    ///
    /// # Errors
    /// The channel map points beyond the channels that an override reaches, or to one for both: says which
    /// parameter to set.
    pub fn configure(&mut self, parameters: &ParameterReader) -> Result<(), String> {
        let number = |map: &str, usual| {
            mapped_channel(parameters, map, usual).ok_or_else(|| {
                format!("{map} is beyond channel {CHANNELS}: set it to {usual}, or use --output guided")
            })
        };
        if self.kind.uses_sticks() {
            (self.steering.number, self.throttle.number) =
                (number("RCMAP_ROLL", 1)?, number("RCMAP_THROTTLE", 3)?);
            if self.steering.number == self.throttle.number {
                return Err(
                    "RCMAP_ROLL and RCMAP_THROTTLE are the same channel: set them to 1 and 3".to_owned()
                );
            }
        }
        self.steering.calibrate(parameters);
        self.throttle.calibrate(parameters);
        self.rate_loop.configure(parameters);
        if let Some(speed_mps) = full_speed_mps(parameters) {
            self.full_speed_mps = speed_mps;
        }
        Ok(())
    }

    /// The message that carries out `demand` at `now_s`, in the vehicle's time; anything that is not a number becomes
    /// neutral.
    pub fn drive(&mut self, now_s: f64, vehicle: Identity, demand: Demand) -> Message {
        let demand = if demand.is_finite() { demand } else { Demand::NEUTRAL };
        match self.kind {
            OutputKind::RcOverride => {
                let (steering_us, _) = self.steering.pulse(demand.steering);
                let (throttle_us, read) = self.throttle.pulse(self.throttle_wanted(demand));
                self.owe(demand, read);
                self.override_channels(vehicle, steering_us, throttle_us)
            }
            OutputKind::ManualControl => {
                let (steering, _) = self.steering.stick(demand.steering);
                let (throttle, read) = self.throttle.stick(self.throttle_wanted(demand));
                self.owe(demand, read);
                manual_control(vehicle, steering, throttle)
            }
            OutputKind::Guided => {
                let yaw_rate_radps = self.told_radps(now_s, demand);
                self.attitude_target(vehicle, Demand { yaw_rate_radps, ..demand })
            }
            OutputKind::GuidedVelocity => {
                let yaw_rate_radps = self.told_radps(now_s, demand);
                self.velocity_target(vehicle, Demand { yaw_rate_radps, ..demand })
            }
        }
    }

    /// The turn rate that makes the firmware turn the boat as it is wanted.
    fn told_radps(&mut self, now_s: f64, demand: Demand) -> f64 {
        if demand == Demand::NEUTRAL {
            self.rate_loop.reset();
            return 0.0;
        }
        self.rate_loop.told_radps(now_s, demand.yaw_rate_radps, demand.ground_per_water)
    }

    /// What to ask of the throttle channel: the firmware knows whole per cents only.
    fn throttle_wanted(&self, demand: Demand) -> f64 {
        demand.throttle.clamp(-1.0, 1.0) + self.throttle_owed
    }

    fn owe(&mut self, demand: Demand, read: f64) {
        // Neutral means neutral, whatever was owed.
        let is_neutral = demand.throttle == 0.0;
        let owed = self.throttle_wanted(demand) - read;
        self.throttle_owed =
            if is_neutral { 0.0 } else { owed.clamp(-1.0 / THROTTLE_STEPS, 1.0 / THROTTLE_STEPS) };
    }

    /// The message that lets go at once, if this output has one: setpoints in GUIDED simply end.
    pub fn release(&self, vehicle: Identity) -> Option<Message> {
        // MANUAL_CONTROL has no release of its own, but sets the same overrides.
        self.kind.uses_sticks().then(|| self.override_channels(vehicle, RELEASE, RELEASE))
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

    /// Velocity along the bow with a turn rate; with both given, the firmware takes the velocity's first component for
    /// the speed (measured on 4.6).
    fn velocity_target(&self, vehicle: Identity, demand: Demand) -> Message {
        let speed_mps = demand.speed_mps.clamp(-self.full_speed_mps, self.full_speed_mps);
        Message::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
            target_system: vehicle.system,
            target_component: vehicle.component,
            coordinate_frame: enums::MAV_FRAME_BODY_NED,
            type_mask: VELOCITY_AND_YAW_RATE,
            vx: speed_mps as f32,
            yaw_rate: demand.yaw_rate_radps as f32,
            ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
        })
    }
}

/// POSITION_TARGET_TYPEMASK: everything but velocity and yaw rate ignored.
const VELOCITY_AND_YAW_RATE: u16 = enums::POSITION_TARGET_TYPEMASK_X_IGNORE
    | enums::POSITION_TARGET_TYPEMASK_Y_IGNORE
    | enums::POSITION_TARGET_TYPEMASK_Z_IGNORE
    | enums::POSITION_TARGET_TYPEMASK_AX_IGNORE
    | enums::POSITION_TARGET_TYPEMASK_AY_IGNORE
    | enums::POSITION_TARGET_TYPEMASK_AZ_IGNORE
    | enums::POSITION_TARGET_TYPEMASK_YAW_IGNORE;

/// The speed that the firmware takes thrust 1 for: WP_SPEED, or CRUISE_SPEED where that is zero.
pub fn full_speed_mps(parameters: &ParameterReader) -> Option<f64> {
    [parameters.value("WP_SPEED"), parameters.value("CRUISE_SPEED")]
        .into_iter()
        .flatten()
        .find(|&speed| speed > 0.0)
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
mod tests;
