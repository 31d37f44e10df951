//! The physics behind a real ArduPilot: its JSON protocol for external simulators
//! (ArduPilot, `libraries/SITL/examples/JSON/readme.md`), without the sockets.
//!
//! ArduPilot sends servo pulses in small binary packets, one per frame, and waits for the answer: where the
//! boat is one frame later, as a line of JSON. Its reader looks for keys as substrings and expects a value
//! right behind the colon, so the answer has no spaces.

use std::fmt::Write;

use crate::physics::{ActuatorCommand, GRAVITY_MPS2, Hull, Pose, Sea, SensorSettings, Truth, Vessel};

/// First word of a packet with 16 outputs, and of one with 32.
const MAGIC: [(u16, usize); 2] = [(18_458, 16), (29_569, 32)];
/// Bytes before the pulses.
const HEADER_BYTES: usize = 8;
/// Frame rates that are believed, Hz. Below 10 Hz ArduPilot does not let its time pass.
const FRAME_RATES_HZ: (f64, f64) = (12.0, 10_000.0);
/// Frames that are made up for at once when packets have been lost.
const MOST_LOST_FRAMES: u32 = 100;
/// Half of the range of a pulse, and its middle, µs.
const HALF_RANGE_US: f64 = 500.0;
const CENTRE_US: f64 = 1500.0;
/// A throttle this far from neutral is meant, µs.
const MEANT_US: f64 = 15.0;

/// Why a datagram was not answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PacketFault {
    /// Not a packet of the protocol.
    #[error("{bytes} bytes are no servo packet of ArduPilot (40 bytes, or 72 with SERVO_32_ENABLE = 1)")]
    Size {
        /// How many bytes came.
        bytes: usize,
    },
    /// The first word is not the protocol's.
    #[error("the packet starts with {found}, not with {expected}: is it ArduPilot's JSON protocol?")]
    Magic {
        /// The word that came.
        found: u16,
        /// The word that packets of this size start with.
        expected: u16,
    },
}

/// What a packet was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PacketKind {
    /// The first one, or the first after ArduPilot has started anew: the boat is back at its start.
    Reset,
    /// The next frame.
    Next,
    /// So many frames were lost before this one; the boat has moved on for them as well.
    AfterLoss(u32),
    /// ArduPilot has not had the answer and sends the packet again: time does not pass.
    Repeated,
}

/// One packet of servo pulses.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoPacket {
    /// Frames per second that ArduPilot wants.
    pub frame_rate_hz: u16,
    /// Number of the frame.
    pub frame: u32,
    /// Pulses, µs.
    pub pulses_us: Vec<u16>,
}

impl ServoPacket {
    /// Reads a datagram.
    ///
    /// # Errors
    /// [`PacketFault`] if it is no servo packet.
    pub fn parse(bytes: &[u8]) -> Result<Self, PacketFault> {
        let size = |outputs: usize| HEADER_BYTES + 2 * outputs;
        let known = MAGIC.iter().find(|(_, outputs)| size(*outputs) == bytes.len());
        let Some(&(expected, _)) = known else { return Err(PacketFault::Size { bytes: bytes.len() }) };
        let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let found = word(0);
        if found != expected {
            return Err(PacketFault::Magic { found, expected });
        }
        Ok(Self {
            frame_rate_hz: word(2),
            frame: u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]),
            pulses_us: bytes[HEADER_BYTES..]
                .chunks_exact(2)
                .map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
                .collect(),
        })
    }
}

/// A boat that an ArduPilot drives.
///
/// Output 1 steers and output 3 drives, as on ArduPilot's motorboat; on a boat with two thrusters they are the
/// left and the right one (`SERVO1_FUNCTION` 73, `SERVO3_FUNCTION` 74).
#[derive(Debug, Clone)]
pub struct ArduPilotPhysics {
    start: Vessel,
    vessel: Vessel,
    last: Option<(u32, String)>,
    motion: Motion,
    twin: bool,
}

/// What ArduPilot's sensors feel.
#[derive(Debug, Clone, Copy, Default)]
struct Motion {
    time_s: f64,
    position_m: [f64; 3],
    velocity_mps: [f64; 3],
    attitude_rad: [f64; 3],
    gyro_radps: [f64; 3],
    /// Specific force in body axes.
    force_mps2: [f64; 3],
}

impl ArduPilotPhysics {
    /// A boat at its start, heading `heading_rad`, moored until the throttle is used for the first time.
    pub fn new(hull: Hull, sea: &Sea, seed: u64, heading_rad: f64) -> Self {
        let twin = hull.has_twin_thrusters();
        let pose = Pose { psi_rad: heading_rad, ..Pose::default() };
        let mut start = Vessel::new(hull, sea, &SensorSettings::perfect(), seed, pose);
        start.set_moored(true);
        let motion = Motion::at_rest(&start.truth());
        Self { vessel: start.clone(), start, last: None, motion, twin }
    }

    /// What really happens to the boat.
    pub fn truth(&self) -> Truth {
        self.vessel.truth()
    }

    /// Takes a packet in and gives the answer to it.
    ///
    /// # Errors
    /// [`PacketFault`] if the datagram is no servo packet; it is not answered then.
    pub fn on_packet(&mut self, bytes: &[u8]) -> Result<(PacketKind, String), PacketFault> {
        let packet = ServoPacket::parse(bytes)?;
        let (kind, frames) = match &self.last {
            Some((frame, answer)) if *frame == packet.frame => {
                return Ok((PacketKind::Repeated, answer.clone()));
            }
            Some((frame, _)) if packet.frame > *frame => match packet.frame - frame {
                1 => (PacketKind::Next, 1),
                steps => (PacketKind::AfterLoss(steps - 1), steps.min(MOST_LOST_FRAMES)),
            },
            _ => {
                self.vessel = self.start.clone();
                self.motion = Motion::at_rest(&self.start.truth());
                (PacketKind::Reset, 1)
            }
        };
        let dt_s = 1.0 / f64::from(packet.frame_rate_hz).clamp(FRAME_RATES_HZ.0, FRAME_RATES_HZ.1);
        for _ in 0..frames {
            self.step(&packet, dt_s);
        }
        let answer = self.motion.json(&self.vessel.truth());
        self.last = Some((packet.frame, answer.clone()));
        Ok((kind, answer))
    }

    fn step(&mut self, packet: &ServoPacket, dt_s: f64) {
        let pulse_us = |output: usize| packet.pulses_us.get(output - 1).copied().unwrap_or(0);
        // No pulse at all moves nothing.
        let share = |output: usize| match pulse_us(output) {
            0 => 0.0,
            pulse_us => (f64::from(pulse_us) - CENTRE_US) / HALF_RANGE_US,
        };
        let drives = |output: usize| share(output).abs() * HALF_RANGE_US > MEANT_US;
        if drives(3) || self.twin && drives(1) {
            self.vessel.set_moored(false);
        }
        let command = if self.twin {
            ActuatorCommand::TwinThrusters { left: share(1), right: share(3) }
        } else {
            ActuatorCommand::ThrottleSteering { steering: share(1), throttle: share(3) }
        };
        self.vessel.step(dt_s, command);
        self.motion = self.motion.next(&self.vessel.truth(), dt_s);
    }
}

impl Motion {
    fn at_rest(truth: &Truth) -> Self {
        let place = Self::place(truth);
        Self { force_mps2: [0.0, 0.0, -GRAVITY_MPS2], ..place }
    }

    /// Position, velocity over ground and attitude, wave motion included.
    fn place(truth: &Truth) -> Self {
        let (wave, hull) = (&truth.wave_motion, &truth.hull);
        let (north_mps, east_mps) = hull.velocity_ned_mps();
        Self {
            time_s: truth.time_s,
            position_m: [hull.north_m + wave.north_m, hull.east_m + wave.east_m, -wave.heave_m],
            velocity_mps: [north_mps + wave.north_mps, east_mps + wave.east_mps, 0.0],
            attitude_rad: [wave.roll_rad, wave.pitch_rad, hull.psi_rad + wave.psi_rad],
            gyro_radps: [0.0, 0.0, hull.r_radps + wave.r_radps],
            force_mps2: [0.0; 3],
        }
    }

    /// The motion one step later; rates that the physics does not give are differences.
    fn next(&self, truth: &Truth, dt_s: f64) -> Self {
        let mut now = Self::place(truth);
        now.velocity_mps[2] = (now.position_m[2] - self.position_m[2]) / dt_s;
        let rate = |axis: usize| (now.attitude_rad[axis] - self.attitude_rad[axis]) / dt_s;
        let [roll, pitch, yaw] = now.attitude_rad;
        let (roll_rate, pitch_rate, yaw_rate) = (rate(0), rate(1), now.gyro_radps[2]);
        // Body rates from Euler rates (Fossen 2021, eq. 2.39, inverted).
        now.gyro_radps = [
            roll_rate - yaw_rate * pitch.sin(),
            pitch_rate * roll.cos() + yaw_rate * pitch.cos() * roll.sin(),
            yaw_rate * pitch.cos() * roll.cos() - pitch_rate * roll.sin(),
        ];
        let mut felt: [f64; 3] =
            std::array::from_fn(|axis| (now.velocity_mps[axis] - self.velocity_mps[axis]) / dt_s);
        felt[2] -= GRAVITY_MPS2;
        now.force_mps2 = to_body(felt, roll, pitch, yaw);
        now
    }

    /// The answer. Nine decimals keep what a float can hold.
    fn json(&self, truth: &Truth) -> String {
        let mut text = String::with_capacity(512);
        let vector = |values: [f64; 3]| format!("[{:.9},{:.9},{:.9}]", values[0], values[1], values[2]);
        let wind = truth.wind_mps;
        let apparent = (wind.north - self.velocity_mps[0], wind.east - self.velocity_mps[1]);
        let from_rad = (-apparent.1).atan2(-apparent.0) - self.attitude_rad[2];
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "\n{{\"timestamp\":{:.9},\"imu\":{{\"gyro\":{},\"accel_body\":{}}},\"position\":{},\"velocity\":{},\
             \"attitude\":{},\"windvane\":{{\"direction\":{:.6},\"speed\":{:.6}}}}}\n",
            self.time_s,
            vector(self.gyro_radps),
            vector(self.force_mps2),
            vector(self.position_m),
            vector(self.velocity_mps),
            vector(self.attitude_rad),
            from_rad.rem_euclid(std::f64::consts::TAU),
            apparent.0.hypot(apparent.1),
        );
        text
    }
}

/// A vector in NED in body axes (rotation zyx: Fossen 2021, eq. 2.31, transposed).
fn to_body(ned: [f64; 3], roll: f64, pitch: f64, yaw: f64) -> [f64; 3] {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    let [n, e, d] = ned;
    [
        cp * cy * n + cp * sy * e - sp * d,
        (sr * sp * cy - cr * sy) * n + (sr * sp * sy + cr * cy) * e + sr * cp * d,
        (cr * sp * cy + sr * sy) * n + (cr * sp * sy - sr * cy) * e + cr * cp * d,
    ]
}

#[cfg(test)]
mod tests;
