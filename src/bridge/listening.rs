//! What the flight controller says, and which one it is.

use helmlink_wire::dialect::{HEARTBEAT_DATA, MessageSet};
use helmlink_wire::{Identity, LinkId, Message, enums};

use super::{Bridge, MOVE_AFTER_S, Vehicle};
use crate::vehicle::Telemetry;
use crate::vehicle::telemetry::{Sender, Update, classify};

/// No more than so many other flight controllers are told of.
const STRANGERS_TOLD: usize = 16;

impl Bridge {
    /// Somebody says that he is there: perhaps the flight controller. Only one on its own link is, and of several there
    /// the first.
    pub(super) fn meet(&mut self, link: LinkId, from: Identity, heartbeat: &HEARTBEAT_DATA) {
        if !self.links.leads_to_vehicle(link) {
            return;
        }
        match (classify(from, heartbeat), self.vehicle) {
            (Sender::Boat | Sender::WrongVehicle(..), _) if self.kept.is_some_and(|kept| kept != from) => {
                self.tell_of_stranger(from);
            }
            (Sender::Boat, None) => self.adopt(Vehicle { link, id: from }),
            (Sender::Boat, Some(known))
                if known.id == from
                    && known.link != link
                    && self.telemetry.heartbeat_age_s(self.now) > MOVE_AFTER_S =>
            {
                self.follow_to(link);
            }
            (Sender::WrongVehicle(kind, autopilot), None) if self.refusal.is_none() => {
                let text = format!(
                    "system {} is no boat or rover run by ArduPilot (MAV_TYPE {kind}, MAV_AUTOPILOT {autopilot}): \
                     helmlink steers only those; connect it to the boat's flight controller, or set FRAME_CLASS to boat",
                    from.system
                );
                self.refusal = Some(text.clone());
                self.event(enums::MAV_SEVERITY_ERROR, text);
            }
            _ => {}
        }
    }

    /// The same flight controller on another link: everything known of it still holds, only what its port was asked for
    /// has to be asked again. Should it be another one after all, its position and its clock will show it.
    fn follow_to(&mut self, link: LinkId) {
        let Some(vehicle) = &mut self.vehicle else { return };
        vehicle.link = link;
        self.streams.ask_again();
        self.event(
            enums::MAV_SEVERITY_WARNING,
            "the flight controller is heard on another link: followed there",
        );
    }

    /// Says once of each other flight controller that it is left alone.
    fn tell_of_stranger(&mut self, from: Identity) {
        let Some(kept) = self.kept else { return };
        if self.strangers.len() < STRANGERS_TOLD && self.strangers.insert(from) {
            let text = format!(
                "a second flight controller, system {}, is on the link: left alone, helmlink keeps to system {}; \
                 restart it to steer another",
                from.system, kept.system
            );
            self.event(enums::MAV_SEVERITY_WARNING, text);
        }
    }

    pub(super) fn adopt(&mut self, vehicle: Vehicle) {
        self.forget_vehicle();
        self.vehicle = Some(vehicle);
        self.kept = Some(vehicle.id);
        self.refusal = None;
        let text = format!("found the flight controller: system {}", vehicle.id.system);
        self.event(enums::MAV_SEVERITY_INFO, text);
    }

    pub(super) fn forget_vehicle(&mut self) {
        self.vehicle = None;
        self.telemetry = Telemetry::default();
        self.observer.forget_vehicle();
        self.watch.forget_position();
        self.ask_again();
    }

    /// The flight controller is new or has restarted: nothing that was asked of it still holds.
    pub(super) fn ask_again(&mut self) {
        self.streams.ask_again();
        self.parameters.ask_again();
        self.output_ready = self.settings.shadow;
        self.mission.on_vehicle_lost();
        self.current.clear();
    }

    pub(super) fn on_vehicle_message(&mut self, vehicle: Vehicle, message: &Message) {
        self.streams.on_message(self.now, message.message_id());
        let update = self.telemetry.on_message(self.now, message);
        let own = self.own(vehicle.id);
        match message {
            Message::PARAM_VALUE(data) => {
                if self.parameters.on_value(data) && self.output_ready {
                    self.output_ready = self.configure_output();
                }
            }
            Message::MISSION_CURRENT(data) => {
                self.mission.on_total(self.now, data.total, own, vehicle.id);
                if let Some(item) = self.current.on_current(data.seq) {
                    self.jump_to_item(item);
                }
            }
            Message::STATUSTEXT(data) => self.on_vehicle_text(data),
            Message::TIMESYNC(data) => {
                if let Some(answer) = self.timesync.on_message(self.driver_now, vehicle.id, data) {
                    self.links.send(vehicle.link, own, &answer);
                }
                self.tell_delay();
            }
            Message::COMMAND_ACK(data) => self.on_ack(own, data),
            _ => {
                self.mission.on_message(self.now, vehicle.id, message);
                self.observer.fence.on_message(self.now, vehicle.id, message);
            }
        }
        match update {
            Update::None => {}
            Update::Heartbeat => self.supervise(),
            Update::Rebooted => {
                self.event(enums::MAV_SEVERITY_WARNING, "the flight controller has restarted");
                self.observer.forget_vehicle();
                self.watch.forget_position();
                self.observer.rebooted = true;
                self.ask_again();
                self.supervise();
            }
            Update::Attitude(boot_s) => {
                self.clock.on_boot_time(boot_s);
                if self.cadence.on_attitude(boot_s) {
                    self.control_step();
                }
            }
            Update::Position(boot_s) => {
                if self.cadence.on_position(boot_s) {
                    self.control_step();
                }
            }
        }
    }

    /// Tells the controller how long its commands are under way, in the vehicle's time.
    pub(super) fn tell_delay(&mut self) {
        let transport_s = self.transport_s();
        let Some(run) = &mut self.run else { return };
        let delay_s = self.delay_choice.choose(transport_s, run.helm().measured_delay());
        if let Some(delay_s) = delay_s {
            run.set_delay_s(delay_s);
        }
    }

    /// How long messages are usually under way, there and back, in the vehicle's time.
    pub(super) fn transport_s(&self) -> Option<f64> {
        self.timesync.usual_trip().map(|trip| trip.as_secs_f64() * self.clock.rate())
    }
}
