//! What the bridge says of itself: heartbeat, progress, and messages for the ground station.

use std::time::Duration;

use helmlink_wire::dialect::{
    CharArray, HEARTBEAT_DATA, MISSION_CURRENT_DATA, MISSION_ITEM_REACHED_DATA, STATUSTEXT_DATA,
};
use helmlink_wire::{Identity, Message, enums};

use super::steering::current_item;
use super::{Bridge, Event, settings};
use crate::pilot::supervisor::State;

/// Interval of the heartbeat and of the progress.
const REPORT_INTERVAL: Duration = Duration::from_secs(1);
/// MAVLink's protocol version, in every heartbeat.
const MAVLINK_VERSION: u8 = 3;
/// Characters in one STATUSTEXT.
const TEXT_LENGTH: usize = 50;
/// System id of the bridge until it has met its vehicle.
const DEFAULT_SYSTEM: u8 = 1;

/// When what was last said.
#[derive(Debug, Default)]
pub(super) struct Reporter {
    last_report: Option<Duration>,
    last_problem: Option<String>,
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
        }
    }

    pub(super) fn send_heartbeat(&mut self) {
        let system_status = match self.supervisor.state() {
            State::Waiting(_) => enums::MAV_STATE_BOOT,
            State::Engaging | State::Engaged | State::HandingBack => enums::MAV_STATE_ACTIVE,
            State::Ready | State::Holding | State::Finished | State::Stopped => enums::MAV_STATE_STANDBY,
        };
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
        let text: String =
            format!("Helmlink: {}", event.text).chars().filter(char::is_ascii).take(TEXT_LENGTH).collect();
        let data = STATUSTEXT_DATA {
            severity: event.severity,
            text: CharArray::from(text.as_str()),
            ..STATUSTEXT_DATA::DEFAULT
        };
        self.tell(&Message::STATUSTEXT(data));
    }

    /// What the flight controller says goes into the log, not back to it.
    pub(super) fn on_vehicle_text(&mut self, data: &STATUSTEXT_DATA) {
        if let Ok(text) = data.text.to_str() {
            let event = Event { severity: data.severity, text: format!("flight controller: {text}") };
            self.events.push_back(event);
        }
    }

    fn tell(&mut self, message: &Message) {
        if let Some(vehicle) = self.vehicle {
            let own = self.own(vehicle.id);
            self.links.send(vehicle.link, own, message);
        }
    }

    fn own_or_default(&self) -> Identity {
        let system = self.vehicle.map_or(DEFAULT_SYSTEM, |vehicle| vehicle.id.system);
        Identity { system, component: settings::COMPONENT }
    }
}
