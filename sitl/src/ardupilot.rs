//! The physics behind a real ArduPilot: its JSON protocol for external simulators
//! (ArduPilot, `libraries/SITL/examples/JSON/readme.md`), without the sockets.
//!
//! ArduPilot sends servo pulses in small binary packets, one per frame, and waits for the answer: where the
//! boat is one frame later, as a line of JSON. Its reader looks for keys as substrings and expects a value
//! right behind the colon, so the answer has no spaces.

mod motion;
mod packet;
mod stage;

use crate::faults::Schedule;
use crate::physics::{ActuatorCommand, Hull, Pose, Sea, SensorSettings, Truth, Vessel};
use crate::scenario::Play;

use motion::Motion;
pub use packet::{PacketFault, ServoPacket};
pub use stage::NotOfTheHull;

/// Frame rates that are believed, Hz. Below 10 Hz ArduPilot does not let its time pass.
const FRAME_RATES_HZ: (f64, f64) = (12.0, 10_000.0);
/// Frames that are made up for at once when packets have been lost.
const MOST_LOST_FRAMES: u32 = 100;
/// Half of the range of a pulse, and its middle, µs.
const HALF_RANGE_US: f64 = 500.0;
const CENTRE_US: f64 = 1500.0;
/// A throttle this far from neutral is meant, µs.
const MEANT_US: f64 = 15.0;

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

/// A boat that an ArduPilot drives.
///
/// Output 1 steers and output 3 drives, as on ArduPilot's motorboat; on a boat with two thrusters they are the
/// left and the right one (`SERVO1_FUNCTION` 73, `SERVO3_FUNCTION` 74).
#[derive(Debug, Clone)]
pub struct ArduPilotPhysics {
    start: Run,
    run: Run,
    last: Option<(u32, String)>,
    twin: bool,
}

/// All that begins anew with ArduPilot.
#[derive(Debug, Clone)]
struct Run {
    vessel: Vessel,
    motion: Motion,
    /// Whether the throttle has not been used yet.
    moored: bool,
    schedule: Schedule,
    play: Option<Box<Play>>,
}

impl ArduPilotPhysics {
    /// A boat at its start, heading `heading_rad`, moored until the throttle is used for the first time.
    pub fn new(hull: Hull, sea: &Sea, seed: u64, heading_rad: f64) -> Self {
        let twin = hull.has_twin_thrusters();
        let pose = Pose { psi_rad: heading_rad, ..Pose::default() };
        let mut vessel = Vessel::new(hull, sea, &SensorSettings::perfect(), seed, pose);
        vessel.set_moored(true);
        let motion = Motion::at_rest(&vessel.truth());
        let start = Run { vessel, motion, moored: true, schedule: Schedule::default(), play: None };
        Self { run: start.clone(), start, last: None, twin }
    }

    /// What really happens to the boat.
    pub fn truth(&self) -> Truth {
        self.run.vessel.truth()
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
                self.run = self.start.clone();
                (PacketKind::Reset, 1)
            }
        };
        let dt_s = 1.0 / f64::from(packet.frame_rate_hz).clamp(FRAME_RATES_HZ.0, FRAME_RATES_HZ.1);
        for _ in 0..frames {
            self.step(&packet, dt_s);
        }
        let answer = self.run.motion.json(&self.truth());
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
        if self.run.moored && (drives(3) || self.twin && drives(1)) {
            self.run.moored = false;
            self.run.vessel.set_moored(false);
        }
        self.run.turn();
        let command = if self.twin {
            ActuatorCommand::TwinThrusters { left: share(1), right: share(3) }
        } else {
            ActuatorCommand::ThrottleSteering { steering: share(1), throttle: share(3) }
        };
        self.run.vessel.step(dt_s, command);
        self.run.motion = self.run.motion.next(&self.truth(), dt_s);
    }
}

#[cfg(test)]
mod tests;
