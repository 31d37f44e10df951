//! Commands to the bridge, and the answers to its own.

use helmlink_wire::dialect::{COMMAND_ACK_DATA, MISSION_SET_CURRENT_DATA};
use helmlink_wire::{Identity, LinkId, Message, enums};

use super::commands::{Command, Order};
use super::{Bridge, LEAST_SPEED_MPS, Vehicle};
use crate::pilot::supervisor::{Request, State};

impl Bridge {
    /// Commands and requests to the bridge itself, from anybody.
    pub(super) fn on_order(&mut self, link: LinkId, from: Identity, vehicle: Vehicle, message: &Message) {
        let own = self.own(vehicle.id);
        if let Message::MISSION_SET_CURRENT(MISSION_SET_CURRENT_DATA { seq, target_system, target_component }) =
            message
            && (*target_system, *target_component) == (own.system, own.component)
        {
            self.jump_to_item(*seq);
        }
        self.on_parameter_message(link, from, message);
        if let Message::FILE_TRANSFER_PROTOCOL(request) = message {
            self.on_file_request(link, from, request);
        }
        let Some(command) = Command::from_message(message, own) else { return };
        let result = match command.order() {
            Order::Engage => {
                if command.number == enums::MAV_CMD_MISSION_START
                    && let Some(run) = self.run.as_mut().filter(|_| self.supervisor.state() == State::Ready)
                {
                    run.jump_to(0);
                }
                self.obey(Request::Engage { patient: false })
            }
            Order::Pause => self.obey(Request::Pause),
            Order::SetCurrent(item) => {
                if self.jump_to_item(item) {
                    enums::MAV_RESULT_ACCEPTED
                } else {
                    enums::MAV_RESULT_DENIED
                }
            }
            Order::ChangeSpeed(speed_mps) => self.change_speed(speed_mps),
            Order::LetGo => self.obey(Request::LetGo),
            Order::ResetParameters => {
                self.reset_parameters();
                enums::MAV_RESULT_ACCEPTED
            }
            // Parameters are kept as they are set.
            Order::SaveParameters => enums::MAV_RESULT_ACCEPTED,
            Order::Metadata => enums::MAV_RESULT_ACCEPTED,
            // FAILED and not UNSUPPORTED, on which some ground stations ask again and again.
            Order::NoSuchMessage => enums::MAV_RESULT_FAILED,
            Order::Unsupported => enums::MAV_RESULT_UNSUPPORTED,
            Order::Denied => enums::MAV_RESULT_DENIED,
        };
        self.links.send(link, own, &command.acknowledge(from, result));
        if command.order() == Order::Metadata {
            let metadata = self.component_metadata();
            self.links.send(link, own, &metadata);
        }
    }

    pub(super) fn change_speed(&mut self, speed_mps: f64) -> u8 {
        let most_mps = self.settings.boat.limits.speed_max_mps;
        let Some(run) = self.run.as_mut().filter(|_| (LEAST_SPEED_MPS..=most_mps).contains(&speed_mps))
        else {
            return enums::MAV_RESULT_DENIED;
        };
        run.set_speed(Some(speed_mps));
        self.event(enums::MAV_SEVERITY_INFO, format!("speed {speed_mps:.2} m/s from now on, as asked"));
        enums::MAV_RESULT_ACCEPTED
    }

    pub(super) fn obey(&mut self, request: Request) -> u8 {
        match self.take_request(request) {
            Ok(()) => enums::MAV_RESULT_ACCEPTED,
            Err(why) => {
                self.event(enums::MAV_SEVERITY_WARNING, format!("command refused: {why}"));
                enums::MAV_RESULT_TEMPORARILY_REJECTED
            }
        }
    }

    /// Goes on with the first waypoint that belongs to this mission item or a later one.
    pub(super) fn jump_to_item(&mut self, item: u16) -> bool {
        let Some(run) = &mut self.run else { return false };
        let Some(index) = run.route().waypoints.iter().position(|waypoint| waypoint.item >= item) else {
            return false;
        };
        run.jump_to(index);
        self.watch.on_new_way();
        self.event(
            enums::MAV_SEVERITY_INFO,
            format!("going on with item {item}, as the ground station asked"),
        );
        true
    }

    pub(super) fn on_ack(&mut self, own: Identity, data: &COMMAND_ACK_DATA) {
        let is_ours = data.target_system == 0
            || (data.target_system, data.target_component) == (own.system, own.component);
        let refused =
            data.result != enums::MAV_RESULT_ACCEPTED && data.result != enums::MAV_RESULT_IN_PROGRESS;
        if is_ours && self.actions.on_ack(data) {
            self.tell_of_actions();
        } else if is_ours && refused {
            let text = format!("command {} refused with MAV_RESULT {}", data.command, data.result);
            self.event(enums::MAV_SEVERITY_DEBUG, text);
        }
    }
}
