//! Follows one vehicle through a log: its state at the vehicle's own time, its mode, its mission, its outputs.

use std::time::Duration;

use helmlink_mission::geodesy::Geodetic;
use helmlink_wire::{Identity, Message, enums};

use super::missions::{MissionListener, Transferred};
use super::servo::ServoReader;
use crate::bridge::settings;
use crate::record::{ControlState, RECORDER};
use crate::vehicle::telemetry::Update;
use crate::vehicle::{Cadence, Mode, Telemetry};

/// Steering messages of a companion this old, vehicle seconds, still mean that it drives.
const COMMAND_AGE_S: f64 = 1.0;
/// Heading and position older than this, vehicle seconds, are not steered by.
const STATE_AGE_S: f64 = 1.0;

/// Something of the vehicle that has just become known.
#[derive(Debug, Clone, PartialEq)]
pub enum Sight {
    /// Heading and position are new: a control step is due.
    Step,
    /// A mission has been transferred.
    Mission(Box<Transferred>),
    /// The controller of a bridge has made a step.
    Thought(Box<ControlState>),
    /// The vehicle is under way to this mission item.
    Current(u16),
    /// The vehicle has reached this mission item.
    Reached(u16),
    /// Something worth a line: MAV_SEVERITY and text.
    Event(u8, String),
}

/// Follows one vehicle. Its time is that of its own messages, joined across restarts.
#[derive(Debug)]
pub struct Watch {
    vehicle: Identity,
    telemetry: Telemetry,
    cadence: Cadence,
    missions: MissionListener,
    servos: ServoReader,
    /// Vehicle time before the last restart, seconds.
    before_restart_s: f64,
    last_command_s: Option<f64>,
    mode: Option<Mode>,
    armed: bool,
    /// Records of the vehicle that were older than what was known already.
    stale: u64,
}

impl Watch {
    /// Follows `vehicle`, whose attitude comes every `interval_s` seconds.
    pub fn new(vehicle: Identity, interval_s: f64) -> Self {
        Self {
            vehicle,
            telemetry: Telemetry::default(),
            cadence: Cadence::new(interval_s),
            missions: MissionListener::new(vehicle.system),
            servos: ServoReader::default(),
            before_restart_s: 0.0,
            last_command_s: None,
            mode: None,
            armed: false,
            stale: 0,
        }
    }

    /// Takes one message of the log; what has become known by it goes to `see`.
    pub fn on_message(
        &mut self,
        time_us: u64,
        from: Identity,
        message: &Message,
        see: &mut impl FnMut(&Self, Sight),
    ) {
        if let Some(transferred) = self.missions.on_message(time_us, from, message) {
            see(self, Sight::Mission(Box::new(transferred)));
        }
        if from == self.vehicle {
            self.on_vehicle_message(message, see);
        } else if from == RECORDER
            && let Some(state) = ControlState::from_message(message)
        {
            see(self, Sight::Thought(Box::new(state)));
        }
        if steers(from, self.vehicle, message) {
            self.last_command_s = Some(self.time_s());
        }
        if from.system == self.vehicle.system && from.component == settings::COMPONENT {
            match message {
                Message::STATUSTEXT(data) => {
                    let text = data.text.to_str().unwrap_or_default().to_owned();
                    see(self, Sight::Event(data.severity, text));
                }
                // In the modes in which a bridge steers, the firmware reaches no waypoints of its own.
                Message::MISSION_ITEM_REACHED(data) => see(self, Sight::Reached(data.seq)),
                _ => {}
            }
        }
    }

    fn on_vehicle_message(&mut self, message: &Message, see: &mut impl FnMut(&Self, Sight)) {
        if self.is_stale(message) {
            self.stale += 1;
            return;
        }
        let before_s = self.telemetry.boot_s.unwrap_or_default();
        let now = Duration::try_from_secs_f64(self.time_s()).unwrap_or_default();
        let update = self.telemetry.on_message(now, message);
        match message {
            Message::PARAM_VALUE(data) => self.servos.on_parameter(data),
            Message::SERVO_OUTPUT_RAW(data) => self.servos.on_outputs(data),
            Message::MISSION_CURRENT(data) => see(self, Sight::Current(data.seq)),
            Message::MISSION_ITEM_REACHED(data) => see(self, Sight::Reached(data.seq)),
            // What a flight controller says when it starts would fill every list.
            Message::STATUSTEXT(data) if data.severity <= enums::MAV_SEVERITY_WARNING => {
                let text = data.text.to_str().unwrap_or_default().to_owned();
                see(self, Sight::Event(data.severity, text));
            }
            _ => {}
        }
        let is_due = match update {
            Update::None => false,
            Update::Heartbeat => {
                self.on_heartbeat(see);
                false
            }
            Update::Rebooted => {
                self.before_restart_s += before_s;
                see(
                    self,
                    Sight::Event(enums::MAV_SEVERITY_WARNING, "the flight controller restarted".to_owned()),
                );
                false
            }
            Update::Attitude(boot_s) => self.cadence.on_attitude(boot_s),
            Update::Position(boot_s) => self.cadence.on_position(boot_s),
        };
        if is_due {
            see(self, Sight::Step);
        }
    }

    /// A message of an earlier vehicle time than the latest: out of order in the log, not a restart.
    fn is_stale(&self, message: &Message) -> bool {
        let (boot_ms, known) = match message {
            Message::ATTITUDE(data) => {
                (data.time_boot_ms, self.telemetry.attitude.map(|known| known.value.boot_s))
            }
            Message::GLOBAL_POSITION_INT(data) => {
                (data.time_boot_ms, self.telemetry.position.map(|known| known.value.boot_s))
            }
            _ => return false,
        };
        let boot_s = f64::from(boot_ms) / 1000.0;
        known.is_some_and(|known_s| boot_s < known_s && boot_s > known_s - LARGEST_DISORDER_S)
    }

    fn on_heartbeat(&mut self, see: &mut impl FnMut(&Self, Sight)) {
        let (mode, armed) = (self.telemetry.mode(), self.telemetry.is_armed());
        if mode != self.mode
            && let Some(mode) = mode
        {
            see(self, Sight::Event(enums::MAV_SEVERITY_INFO, format!("mode {mode}")));
        }
        if armed != self.armed {
            let text = if armed { "armed" } else { "disarmed" };
            see(self, Sight::Event(enums::MAV_SEVERITY_INFO, text.to_owned()));
        }
        (self.mode, self.armed) = (mode, armed);
    }

    /// The vehicle's telemetry.
    pub fn telemetry(&self) -> &Telemetry {
        &self.telemetry
    }

    /// What went to motors and rudder.
    pub fn outputs(&self) -> Option<super::servo::Outputs> {
        self.servos.latest()
    }

    /// Where the vehicle is.
    pub fn place(&self) -> Option<Geodetic> {
        self.telemetry.position.map(|position| position.value.place)
    }

    /// Vehicle time, seconds since its first boot in the log.
    pub fn time_s(&self) -> f64 {
        self.before_restart_s + self.telemetry.boot_s.unwrap_or_default()
    }

    /// Vehicle time as of a time since the last boot.
    pub fn joined_s(&self, boot_s: f64) -> f64 {
        self.before_restart_s + boot_s
    }

    /// Messages that came after newer ones.
    pub fn stale(&self) -> u64 {
        self.stale
    }

    /// The motors may turn.
    pub fn is_armed(&self) -> bool {
        self.telemetry.is_armed()
    }

    /// Armed, and steered by itself along a mission or by a companion.
    pub fn is_driven(&self) -> bool {
        let by_itself = matches!(self.telemetry.mode(), Some(Mode::AUTO | Mode::GUIDED));
        let by_companion = self.last_command_s.is_some_and(|then_s| self.time_s() - then_s < COMMAND_AGE_S);
        self.is_armed() && (by_itself || by_companion)
    }

    /// Heading and position are fresh enough to steer by.
    pub fn is_fresh(&self) -> bool {
        let (Some(attitude), Some(position)) = (self.telemetry.attitude, self.telemetry.position) else {
            return false;
        };
        (attitude.value.boot_s - position.value.boot_s).abs() < STATE_AGE_S
    }
}

/// A time stamp of the vehicle that falls back by less than this is out of order; by more, a restart.
const LARGEST_DISORDER_S: f64 = 20.0;

/// Whether a companion steers the vehicle by this message.
fn steers(from: Identity, vehicle: Identity, message: &Message) -> bool {
    from != vehicle
        && from.component == settings::COMPONENT
        && match message {
            Message::RC_CHANNELS_OVERRIDE(data) => data.target_system == vehicle.system,
            Message::MANUAL_CONTROL(data) => data.target == vehicle.system,
            Message::SET_ATTITUDE_TARGET(data) => data.target_system == vehicle.system,
            _ => false,
        }
}
