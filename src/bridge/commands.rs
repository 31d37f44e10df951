//! Commands to the bridge itself, as its own MAVLink component.

use helmlink_wire::dialect::{
    COMMAND_ACK_DATA, COMMAND_INT_DATA, COMMAND_LONG_DATA, COMPONENT_METADATA_DATA, MessageData,
};
use helmlink_wire::{Identity, Message, enums};

/// What a command asks of the bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Order {
    /// Drive the mission: MAV_CMD_MISSION_START, or MAV_CMD_DO_PAUSE_CONTINUE with 1.
    Engage,
    /// Stop the boat and keep the place in the mission: MAV_CMD_DO_PAUSE_CONTINUE with 0.
    Pause,
    /// Go on with this mission item: MAV_CMD_DO_SET_MISSION_CURRENT.
    SetCurrent(u16),
    /// From now on drive at this speed over ground, m/s: MAV_CMD_DO_CHANGE_SPEED.
    ChangeSpeed(f64),
    /// Stop the boat and let go: MAV_CMD_USER_1.
    LetGo,
    /// Parameters back to their factory values: MAV_CMD_PREFLIGHT_STORAGE with 2.
    ResetParameters,
    /// Keep the parameters: MAV_CMD_PREFLIGHT_STORAGE with 1.
    SaveParameters,
    /// Say where the parameters are described: MAV_CMD_REQUEST_MESSAGE for COMPONENT_METADATA.
    Metadata,
    /// A message that the bridge does not have: MAV_CMD_REQUEST_MESSAGE.
    NoSuchMessage,
    /// Nothing that the bridge does.
    Unsupported,
    /// A known command with a parameter that makes no sense.
    Denied,
}

/// A command addressed to the bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Command {
    pub(super) number: u16,
    param1: f32,
    param2: f32,
}

impl Command {
    /// The command in a message, if there is one and it is addressed to `own`.
    pub(super) fn from_message(message: &Message, own: Identity) -> Option<Self> {
        let (system, component, number, param1, param2) = match message {
            Message::COMMAND_LONG(COMMAND_LONG_DATA {
                target_system,
                target_component,
                command,
                param1,
                param2,
                ..
            }) => (*target_system, *target_component, *command, *param1, *param2),
            Message::COMMAND_INT(COMMAND_INT_DATA {
                target_system,
                target_component,
                command,
                param1,
                param2,
                ..
            }) => (*target_system, *target_component, *command, *param1, *param2),
            _ => return None,
        };
        // Commands to "all components" are the flight controller's to answer.
        (system == own.system && component == own.component).then_some(Self { number, param1, param2 })
    }

    /// What it asks for.
    pub(super) fn order(&self) -> Order {
        match self.number {
            enums::MAV_CMD_MISSION_START => Order::Engage,
            enums::MAV_CMD_DO_PAUSE_CONTINUE if self.param1 == 1.0 => Order::Engage,
            enums::MAV_CMD_DO_PAUSE_CONTINUE if self.param1 == 0.0 => Order::Pause,
            enums::MAV_CMD_DO_PAUSE_CONTINUE => Order::Denied,
            enums::MAV_CMD_DO_SET_MISSION_CURRENT if (1.0..=65534.0).contains(&self.param1) => {
                Order::SetCurrent(self.param1 as u16)
            }
            enums::MAV_CMD_DO_SET_MISSION_CURRENT => Order::Denied,
            enums::MAV_CMD_DO_CHANGE_SPEED if self.param2 > 0.0 => Order::ChangeSpeed(f64::from(self.param2)),
            enums::MAV_CMD_DO_CHANGE_SPEED => Order::Denied,
            enums::MAV_CMD_USER_1 => Order::LetGo,
            enums::MAV_CMD_PREFLIGHT_STORAGE if self.param1 == 2.0 => Order::ResetParameters,
            enums::MAV_CMD_PREFLIGHT_STORAGE if self.param1 == 1.0 => Order::SaveParameters,
            enums::MAV_CMD_PREFLIGHT_STORAGE => Order::Denied,
            enums::MAV_CMD_REQUEST_MESSAGE if self.param1 == COMPONENT_METADATA_DATA::ID as f32 => {
                Order::Metadata
            }
            enums::MAV_CMD_REQUEST_MESSAGE => Order::NoSuchMessage,
            _ => Order::Unsupported,
        }
    }

    /// The acknowledgement.
    pub(super) fn acknowledge(&self, to: Identity, result: u8) -> Message {
        Message::COMMAND_ACK(COMMAND_ACK_DATA {
            command: self.number,
            result,
            target_system: to.system,
            target_component: to.component,
            ..COMMAND_ACK_DATA::DEFAULT
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: Identity = Identity { system: 1, component: 191 };

    fn order(command: u16, param1: f32) -> Order {
        let (target_system, target_component) = (OWN.system, OWN.component);
        let data = COMMAND_LONG_DATA {
            target_system,
            target_component,
            command,
            param1,
            param2: 1.5,
            ..COMMAND_LONG_DATA::DEFAULT
        };
        Command::from_message(&Message::COMMAND_LONG(data), OWN).unwrap().order()
    }

    #[test]
    fn knows_its_orders() {
        assert_eq!(order(enums::MAV_CMD_MISSION_START, 0.0), Order::Engage);
        assert_eq!(order(enums::MAV_CMD_DO_PAUSE_CONTINUE, 1.0), Order::Engage);
        assert_eq!(order(enums::MAV_CMD_DO_PAUSE_CONTINUE, 0.0), Order::Pause);
        assert_eq!(order(enums::MAV_CMD_DO_PAUSE_CONTINUE, f32::NAN), Order::Denied);
        assert_eq!(order(enums::MAV_CMD_DO_SET_MISSION_CURRENT, 4.0), Order::SetCurrent(4));
        assert_eq!(order(enums::MAV_CMD_DO_SET_MISSION_CURRENT, f32::NAN), Order::Denied);
        assert_eq!(order(enums::MAV_CMD_DO_CHANGE_SPEED, 1.0), Order::ChangeSpeed(1.5));
        assert_eq!(order(enums::MAV_CMD_USER_1, 0.0), Order::LetGo);
        assert_eq!(order(enums::MAV_CMD_REQUEST_MESSAGE, 148.0), Order::NoSuchMessage);
        assert_eq!(order(enums::MAV_CMD_REQUEST_MESSAGE, 397.0), Order::Metadata);
        assert_eq!(order(60_000, 1.0), Order::Unsupported);
    }

    #[test]
    fn commands_to_others_are_not_its_business() {
        for (target_system, target_component) in [(1, 1), (1, 0), (2, 191)] {
            let data = COMMAND_LONG_DATA { target_system, target_component, ..COMMAND_LONG_DATA::DEFAULT };
            assert_eq!(Command::from_message(&Message::COMMAND_LONG(data), OWN), None);
        }
    }
}
