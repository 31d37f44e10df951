//! What the bridge says of itself: heartbeat, progress, and messages for the ground station.

use std::time::Duration;

use helmlink_wire::dialect::{
    CharArray, HEARTBEAT_DATA, MISSION_CURRENT_DATA, MISSION_ITEM_REACHED_DATA, STATUSTEXT_DATA,
};
use helmlink_wire::{Identity, Message, enums};

use super::steering::current_item;
use super::{Bridge, Event, Health, controller_state, settings};
use crate::pilot::supervisor::{Duty, State};

/// Interval of the heartbeat and of the progress.
const REPORT_INTERVAL: Duration = Duration::from_secs(1);
/// MAVLink's protocol version, in every heartbeat.
const MAVLINK_VERSION: u8 = 3;
/// A text is cut off after so many messages.
const MOST_CHUNKS: u8 = 5;
/// Characters in one STATUSTEXT.
const TEXT_LENGTH: usize = 50;
/// NAMED_VALUE_FLOAT: steering frames per second.
const RATE_NAME: &str = "HL_HZ";
/// NAMED_VALUE_FLOAT: mean deviation of their intervals, ms.
const JITTER_NAME: &str = "HL_JITTER";
/// NAMED_VALUE_FLOAT: the longest interval since the last report, ms.
const LONGEST_NAME: &str = "HL_LONGEST";
/// NAMED_VALUE_FLOAT: from taking telemetry to handing over the command, at most, ms.
const LATE_NAME: &str = "HL_LATE";
/// NAMED_VALUE_FLOAT: the bridge's share of one processor, %.
const CPU_NAME: &str = "HL_CPU";
/// NAMED_VALUE_FLOAT: the bridge's memory, MB.
const MEMORY_NAME: &str = "HL_MEM";
/// System id of the bridge until it has met its vehicle.
const DEFAULT_SYSTEM: u8 = 1;

/// When what was last said.
#[derive(Debug, Default)]
pub(super) struct Reporter {
    last_report: Option<Duration>,
    last_problem: Option<String>,
    /// How the process is, when it has been told and not been passed on yet.
    pub(super) health: Option<Health>,
    /// Number of the last text that took more than one message.
    text_id: u16,
}

impl Reporter {
    /// Remembers a problem, so that it is told once and not at every step.
    pub(super) fn is_new_problem(&mut self, text: &str) -> bool {
        let is_new = self.last_problem.as_deref() != Some(text);
        self.last_problem = Some(text.to_owned());
        is_new
    }
}

impl Bridge {
    /// Sends heartbeat and progress when they are due.
    pub(super) fn report(&mut self) {
        let is_due =
            self.reporter.last_report.is_none_or(|then| self.now.saturating_sub(then) >= REPORT_INTERVAL);
        if is_due {
            self.reporter.last_report = Some(self.now);
            self.send_heartbeat();
            self.send_progress();
            self.send_live_state();
            self.tell_delay();
            self.send_health();
        }
    }

    pub(super) fn send_heartbeat(&mut self) {
        let system_status = self.system_status();
        // No mode flag is set: a custom mode in a companion's heartbeat is taken for the vehicle's.
        let heartbeat = Message::HEARTBEAT(HEARTBEAT_DATA {
            mavtype: enums::MAV_TYPE_ONBOARD_CONTROLLER,
            autopilot: enums::MAV_AUTOPILOT_INVALID,
            system_status,
            mavlink_version: MAVLINK_VERSION,
            ..HEARTBEAT_DATA::DEFAULT
        });
        let own = self.own_or_default();
        self.links.broadcast(own, &heartbeat);
    }

    /// MAV_STATE: tells whether the control loop is healthy.
    fn system_status(&self) -> u8 {
        match self.supervisor.state() {
            State::Waiting(_) => enums::MAV_STATE_BOOT,
            State::Engaged if self.supervisor.duty() == Duty::Neutral || self.loop_is_late() => {
                enums::MAV_STATE_CRITICAL
            }
            State::Engaging | State::Engaged | State::HandingBack => enums::MAV_STATE_ACTIVE,
            _ => enums::MAV_STATE_STANDBY,
        }
    }

    /// What the controller thinks, and how the bridge is, for the ground station: while there is something to tell.
    fn send_live_state(&mut self) {
        let computes = self.settings.shadow || self.supervisor.state() == State::Engaged;
        if !computes || self.vehicle.is_none() {
            return;
        }
        let boot_s = self.telemetry.boot_s.unwrap_or_default();
        let pace = self.steering.pace;
        let health =
            [(RATE_NAME, pace.rate_hz()), (JITTER_NAME, pace.jitter_ms()), (LONGEST_NAME, pace.longest_ms())];
        let state = controller_state::messages(boot_s, &self.steering.diagnostics, &self.steering.demand);
        let health = health.map(|(name, value)| controller_state::named_value(boot_s, name, value as f32));
        for message in state.chain(health) {
            self.tell(&message);
        }
        self.steering.pace.start_over();
    }

    /// How the bridge's process is, once for each time that it has been measured.
    fn send_health(&mut self) {
        if self.vehicle.is_none() {
            return;
        }
        let Some(health) = self.reporter.health.take() else { return };
        let boot_s = self.telemetry.boot_s.unwrap_or_default();
        let figures =
            [(LATE_NAME, health.late_ms), (CPU_NAME, health.cpu_percent), (MEMORY_NAME, health.memory_mb)];
        for (name, value) in figures {
            self.tell(&controller_state::named_value(boot_s, name, value));
        }
    }

    /// MISSION_CURRENT while the bridge drives: in the mode it steers in, the firmware reports none of this.
    fn send_progress(&mut self) {
        let mission_state = match self.supervisor.state() {
            State::Engaged => enums::MISSION_STATE_ACTIVE,
            State::Holding => enums::MISSION_STATE_PAUSED,
            State::Finished => enums::MISSION_STATE_COMPLETE,
            _ => return,
        };
        let Some(seq) = self.run.as_ref().and_then(current_item) else { return };
        let total = self.mission.mission().map_or(0, |mission| mission.items.len()) as u16;
        let data = MISSION_CURRENT_DATA { seq, total, mission_state, ..MISSION_CURRENT_DATA::DEFAULT };
        self.tell(&Message::MISSION_CURRENT(data));
    }

    pub(super) fn on_waypoint_reached(&mut self, index: usize) {
        let Some(item) =
            self.run.as_ref().and_then(|run| run.route().waypoints.get(index)).map(|point| point.item)
        else {
            return;
        };
        self.tell(&Message::MISSION_ITEM_REACHED(MISSION_ITEM_REACHED_DATA { seq: item }));
        self.event(enums::MAV_SEVERITY_INFO, format!("reached waypoint {item}"));
        self.send_progress();
    }

    /// Tells the ground station, through the flight controller, what is in the log.
    pub(super) fn announce(&mut self, event: &Event) {
        if event.severity > enums::MAV_SEVERITY_INFO || self.vehicle.is_none() {
            return;
        }
        let text: Vec<u8> = format!("Helmlink: {}", event.text).bytes().filter(u8::is_ascii).collect();
        let is_long = text.len() > TEXT_LENGTH;
        if is_long {
            // 0 says that a text is whole.
            self.reporter.text_id = self.reporter.text_id.checked_add(1).unwrap_or(1);
        }
        for (chunk_seq, chunk) in (0..MOST_CHUNKS).zip(text.chunks(TEXT_LENGTH)) {
            let chunk: String = chunk.iter().map(|&byte| char::from(byte)).collect();
            let data = STATUSTEXT_DATA {
                severity: event.severity,
                text: CharArray::from(chunk.as_str()),
                id: if is_long { self.reporter.text_id } else { 0 },
                chunk_seq,
            };
            self.tell(&Message::STATUSTEXT(data));
        }
    }

    /// What the flight controller says goes into the log, not back to it.
    pub(super) fn on_vehicle_text(&mut self, data: &STATUSTEXT_DATA) {
        if let Ok(text) = data.text.to_str() {
            self.mission.on_text(text);
            let event = Event { severity: data.severity, text: format!("flight controller: {text}") };
            self.events.push_back(event);
        }
    }

    /// Says something on every link.
    pub(super) fn tell(&mut self, message: &Message) {
        if let Some(vehicle) = self.vehicle {
            let own = self.own(vehicle.id);
            self.links.broadcast(own, message);
        }
    }

    pub(super) fn own_or_default(&self) -> Identity {
        let system = self.vehicle.map_or(DEFAULT_SYSTEM, |vehicle| vehicle.id.system);
        Identity { system, component: settings::COMPONENT }
    }
}
