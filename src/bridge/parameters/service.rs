//! The parameter protocol, as the bridge's own component.

use std::time::Duration;

use helmlink_wire::dialect::{
    CharArray, PARAM_ERROR_DATA, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA, PARAM_VALUE_DATA,
};
use helmlink_wire::{Identity, LinkId, Message, enums};

use super::store::{ParameterError, Tunables};
use super::table::PARAMETERS;
use crate::bridge::Bridge;
use crate::pilot::RunSettings;
use crate::pilot::supervisor::State;

/// Time between two values of a list: a slow radio is not to be flooded.
const LIST_INTERVAL: Duration = Duration::from_millis(10);
/// PARAM_VALUE of a parameter asked for by name has its true number all the same.
const COUNT: u16 = PARAMETERS.len() as u16;

/// The list being sent, and what is to be kept.
#[derive(Debug, Default)]
pub(in crate::bridge) struct ParameterService {
    /// The link that asked, the next number, and when it is due.
    list: Option<(LinkId, usize, Duration)>,
    unsaved: bool,
}

impl Bridge {
    /// The parameters as text, when they have changed since the last call: to be written to a file, and to be given
    /// to the next bridge as [`BridgeSettings::parameters`](crate::bridge::BridgeSettings::parameters).
    pub fn take_parameters(&mut self) -> Option<String> {
        std::mem::take(&mut self.parameter_service.unsaved).then(|| self.tunables().to_text(&self.factory))
    }

    /// Parameter messages to the bridge, from whichever link. Answers go back there.
    pub(in crate::bridge) fn on_parameter_message(
        &mut self,
        link: LinkId,
        from: Identity,
        message: &Message,
    ) {
        let own = self.own_or_default();
        match message {
            Message::PARAM_REQUEST_LIST(data) => {
                let to_us = data.target_component == own.component || data.target_component == 0;
                if to_us && (data.target_system == own.system || data.target_system == 0) {
                    self.parameter_service.list = Some((link, 0, self.driver_now));
                }
            }
            Message::PARAM_REQUEST_READ(data)
                if (data.target_system, data.target_component) == (own.system, own.component) =>
            {
                self.answer_read(link, from, data);
            }
            Message::PARAM_SET(data)
                if (data.target_system, data.target_component) == (own.system, own.component) =>
            {
                self.answer_set(link, from, data);
            }
            _ => {}
        }
    }

    /// Sends the next values of a list when they are due.
    pub(in crate::bridge) fn send_parameter_list(&mut self) {
        let Some((link, index, due)) = self.parameter_service.list else { return };
        if self.driver_now < due {
            return;
        }
        self.parameter_service.list =
            (index + 1 < PARAMETERS.len()).then_some((link, index + 1, self.driver_now + LIST_INTERVAL));
        if let Some(message) = value_message(&self.tunables(), index) {
            self.links.send(link, self.own_or_default(), &message);
        }
    }

    /// Everything back to what the bridge was started with.
    pub(in crate::bridge) fn reset_parameters(&mut self) {
        let factory = self.factory.clone();
        self.apply_tunables(factory);
        self.parameter_service.unsaved = true;
        self.event(enums::MAV_SEVERITY_INFO, "parameters are back at their factory values");
    }

    fn answer_read(&mut self, link: LinkId, from: Identity, data: &PARAM_REQUEST_READ_DATA) {
        let index = match usize::try_from(data.param_index) {
            Ok(index) => Some(index),
            Err(_) => number_of(data.param_id.to_str().unwrap_or_default()),
        };
        let answer = index.and_then(|index| value_message(&self.tunables(), index)).unwrap_or_else(|| {
            refusal(from, data.param_id, data.param_index, enums::MAV_PARAM_ERROR_DOES_NOT_EXIST)
        });
        self.links.send(link, self.own_or_default(), &answer);
    }

    fn answer_set(&mut self, link: LinkId, from: Identity, data: &PARAM_SET_DATA) {
        let own = self.own_or_default();
        let name = data.param_id.to_str().unwrap_or_default().to_owned();
        let mut tunables = self.tunables();
        match tunables.set(&name, data.param_value) {
            Ok(parameter) => {
                self.apply_tunables(tunables);
                self.parameter_service.unsaved = true;
                self.event(
                    enums::MAV_SEVERITY_INFO,
                    format!("{} is now {}", parameter.name, data.param_value),
                );
            }
            Err(error) => {
                let code = match error {
                    ParameterError::Unknown(_) => enums::MAV_PARAM_ERROR_DOES_NOT_EXIST,
                    _ => enums::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
                };
                self.links.send(link, own, &refusal(from, data.param_id, -1, code));
                self.event(enums::MAV_SEVERITY_WARNING, format!("{name} not set: {error}"));
            }
        }
        // Everybody sees the value in force, also the one that was refused.
        if let Some(message) = number_of(&name).and_then(|index| value_message(&self.tunables(), index)) {
            self.links.broadcast(own, &message);
        }
    }

    /// What the parameters are at.
    fn tunables(&self) -> Tunables {
        self.settings.tunables()
    }

    /// Lets other values take effect, on the boat that is being driven too.
    fn apply_tunables(&mut self, tunables: Tunables) {
        let boat_changed = self.settings.boat != tunables.boat;
        self.settings.boat = tunables.boat;
        self.settings.failsafes = tunables.failsafes;
        self.settings.speed_mps = (tunables.speed_mps > 0.0).then_some(tunables.speed_mps);
        self.watch.configure(self.failsafes_in_force());
        let settings =
            RunSettings { speed_mps: self.usual_speed_mps(), controller: self.settings.controller };
        let engaged = self.supervisor.state() == State::Engaged;
        if let Some(run) = &mut self.run
            && run.retune(&self.settings.boat, settings, boat_changed)
            && engaged
        {
            self.engage_run();
        }
    }
}

fn number_of(name: &str) -> Option<usize> {
    PARAMETERS.iter().position(|parameter| parameter.name == name)
}

fn value_message(tunables: &Tunables, index: usize) -> Option<Message> {
    let parameter = PARAMETERS.get(index)?;
    Some(Message::PARAM_VALUE(PARAM_VALUE_DATA {
        param_id: CharArray::from(parameter.name),
        param_value: tunables.value(index)?,
        param_type: enums::MAV_PARAM_TYPE_REAL32,
        param_count: COUNT,
        param_index: index as u16,
    }))
}

fn refusal(to: Identity, param_id: CharArray<16>, param_index: i16, error: u8) -> Message {
    let (target_system, target_component) = (to.system, to.component);
    Message::PARAM_ERROR(PARAM_ERROR_DATA { target_system, target_component, param_id, param_index, error })
}
