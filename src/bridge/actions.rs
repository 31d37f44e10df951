//! Commands of the mission that are the flight controller's to carry out: sent one after the other, each until it
//! is acknowledged.

use std::collections::VecDeque;
use std::time::Duration;

use helmlink_mission::plan::{CommandName, Item};
use helmlink_wire::dialect::{COMMAND_ACK_DATA, COMMAND_INT_DATA, COMMAND_LONG_DATA};
use helmlink_wire::{Identity, Message, enums};

/// How long an acknowledgement may take before the command is sent again.
const TIMEOUT: Duration = Duration::from_secs(1);
/// How often a command is sent before it is given up.
const ATTEMPTS: u8 = 4;
/// More commands than this do not wait: older ones are told as lost.
const WAITING_LIMIT: usize = 64;

/// A command on its way.
#[derive(Debug, Clone, Copy)]
struct Pending {
    item: u16,
    command: Item,
    attempts: u8,
    last_sent: Option<Duration>,
}

/// What became of a command.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Outcome {
    /// MAV_SEVERITY.
    pub(super) severity: u8,
    /// In words.
    pub(super) text: String,
}

/// The commands that have not been acknowledged yet.
#[derive(Debug, Default)]
pub(super) struct Actions {
    pending: VecDeque<Pending>,
    outcomes: VecDeque<Outcome>,
}

impl Actions {
    /// A command of mission item `item` is due.
    pub(super) fn push(&mut self, item: u16, command: Item) {
        if self.pending.len() >= WAITING_LIMIT
            && let Some(lost) = self.pending.pop_front()
        {
            self.note(enums::MAV_SEVERITY_WARNING, lost, "was not sent: too many commands wait");
        }
        self.pending.push_back(Pending { item, command, attempts: 0, last_sent: None });
    }

    /// The boat is no longer the bridge's: what has not been sent is not sent any more.
    pub(super) fn clear(&mut self) {
        self.pending.clear();
    }

    /// The message to send now, if any.
    pub(super) fn poll(&mut self, now: Duration, vehicle: Identity) -> Option<Message> {
        let first = self.pending.front_mut()?;
        if first.last_sent.is_some_and(|then| now.saturating_sub(then) < TIMEOUT) {
            return None;
        }
        if first.attempts >= ATTEMPTS {
            if let Some(lost) = self.pending.pop_front() {
                self.note(enums::MAV_SEVERITY_WARNING, lost, "was not acknowledged by the flight controller");
            }
            return None;
        }
        let confirmation = first.attempts;
        first.attempts += 1;
        first.last_sent = Some(now);
        Some(message(&first.command, vehicle, confirmation))
    }

    /// The flight controller acknowledges a command; true if it was one of these.
    pub(super) fn on_ack(&mut self, ack: &COMMAND_ACK_DATA) -> bool {
        let sent = |first: &&Pending| first.command.command == ack.command && first.attempts > 0;
        if self.pending.front().filter(sent).is_none() {
            return false;
        }
        if ack.result == enums::MAV_RESULT_IN_PROGRESS {
            return true;
        }
        if let Some(done) = self.pending.pop_front() {
            match ack.result {
                enums::MAV_RESULT_ACCEPTED => self.note(enums::MAV_SEVERITY_INFO, done, "done"),
                result => {
                    let text = format!("refused by the flight controller: {}", result_name(result));
                    self.note(enums::MAV_SEVERITY_WARNING, done, &text);
                }
            }
        }
        true
    }

    /// What became of a command, each once.
    pub(super) fn poll_outcome(&mut self) -> Option<Outcome> {
        self.outcomes.pop_front()
    }

    fn note(&mut self, severity: u8, pending: Pending, what: &str) {
        let name = CommandName(pending.command.command);
        self.outcomes.push_back(Outcome { severity, text: format!("item {}: {name}: {what}", pending.item) });
    }
}

/// As COMMAND_INT where the command has a position, which COMMAND_LONG would carry to a metre only.
fn message(item: &Item, vehicle: Identity, confirmation: u8) -> Message {
    let [param1, param2, param3, param4] = item.params;
    let (target_system, target_component) = (vehicle.system, vehicle.component);
    if item.position().is_some() {
        return Message::COMMAND_INT(COMMAND_INT_DATA {
            target_system,
            target_component,
            frame: item.frame,
            command: item.command,
            param1,
            param2,
            param3,
            param4,
            x: item.x,
            y: item.y,
            z: item.z,
            ..COMMAND_INT_DATA::DEFAULT
        });
    }
    let [param5, param6] = item.coordinates().map(|value| value as f32);
    Message::COMMAND_LONG(COMMAND_LONG_DATA {
        target_system,
        target_component,
        command: item.command,
        confirmation,
        param1,
        param2,
        param3,
        param4,
        param5,
        param6,
        param7: item.z,
    })
}

fn result_name(result: u8) -> String {
    let name = match result {
        enums::MAV_RESULT_TEMPORARILY_REJECTED => "TEMPORARILY_REJECTED",
        enums::MAV_RESULT_DENIED => "DENIED",
        enums::MAV_RESULT_UNSUPPORTED => "UNSUPPORTED, it does not know the command",
        enums::MAV_RESULT_FAILED => "FAILED, see its messages",
        enums::MAV_RESULT_CANCELLED => "CANCELLED",
        other => return format!("MAV_RESULT {other}"),
    };
    name.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use helmlink_mission::geodesy::Geodetic;

    const VEHICLE: Identity = Identity { system: 1, component: 1 };

    fn servo(channel: f32) -> Item {
        let command = enums::MAV_CMD_DO_SET_SERVO;
        let frame = enums::MAV_FRAME_MISSION;
        Item {
            command,
            frame,
            params: [channel, 1700.0, 0.0, 0.0],
            x: 0,
            y: 0,
            ..Item::waypoint(Geodetic::default())
        }
    }

    fn ack(command: u16, result: u8) -> COMMAND_ACK_DATA {
        COMMAND_ACK_DATA { command, result, ..COMMAND_ACK_DATA::DEFAULT }
    }

    #[test]
    fn one_after_the_other_each_until_it_is_acknowledged() {
        let mut actions = Actions::default();
        actions.push(3, servo(9.0));
        actions.push(4, servo(10.0));
        let Some(Message::COMMAND_LONG(first)) = actions.poll(Duration::ZERO, VEHICLE) else { panic!() };
        assert_eq!((first.command, first.param1, first.param2, first.confirmation), (183, 9.0, 1700.0, 0));
        assert!(actions.poll(Duration::from_millis(500), VEHICLE).is_none(), "waits for the answer");
        let Some(Message::COMMAND_LONG(again)) = actions.poll(TIMEOUT, VEHICLE) else { panic!() };
        assert_eq!((again.param1, again.confirmation), (9.0, 1));
        assert!(!actions.on_ack(&ack(181, 0)), "of another command");
        assert!(actions.on_ack(&ack(183, enums::MAV_RESULT_IN_PROGRESS)));
        assert!(actions.on_ack(&ack(183, enums::MAV_RESULT_ACCEPTED)));
        let Some(Message::COMMAND_LONG(second)) = actions.poll(TIMEOUT, VEHICLE) else { panic!() };
        assert_eq!(second.param1, 10.0);
        assert!(actions.on_ack(&ack(183, enums::MAV_RESULT_FAILED)));
        let texts: Vec<String> = std::iter::from_fn(|| actions.poll_outcome()).map(|o| o.text).collect();
        assert_eq!(
            texts,
            [
                "item 3: MAV_CMD_DO_SET_SERVO (183): done",
                "item 4: MAV_CMD_DO_SET_SERVO (183): refused by the flight controller: FAILED, see its messages"
            ]
        );
    }

    #[test]
    fn silence_is_told_and_does_not_hold_up_the_next() {
        let mut actions = Actions::default();
        actions.push(3, servo(9.0));
        actions.push(4, servo(10.0));
        let sent: Vec<f32> = (0..60)
            .filter_map(|tenths| match actions.poll(Duration::from_millis(tenths * 100), VEHICLE) {
                Some(Message::COMMAND_LONG(data)) => Some(data.param1),
                _ => None,
            })
            .collect();
        assert_eq!(sent, [9.0, 9.0, 9.0, 9.0, 10.0, 10.0]);
        assert!(actions.poll_outcome().unwrap().text.contains("not acknowledged"));
    }

    #[test]
    fn positions_go_as_integers() {
        let mut actions = Actions::default();
        let roi =
            Item { command: enums::MAV_CMD_DO_SET_ROI_LOCATION, ..Item::waypoint(Geodetic::new(59.9, 10.7)) };
        actions.push(3, roi);
        let Some(Message::COMMAND_INT(data)) = actions.poll(Duration::ZERO, VEHICLE) else { panic!() };
        assert_eq!(
            (data.x, data.y, data.frame),
            (599_000_000, 107_000_000, enums::MAV_FRAME_GLOBAL_RELATIVE_ALT)
        );
        actions.clear();
        assert!(actions.poll(TIMEOUT, VEHICLE).is_none());
    }
}
