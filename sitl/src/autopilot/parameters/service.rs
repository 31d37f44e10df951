//! The parameter protocol: list, read and set (<https://mavlink.io/en/services/parameter.html>).
//!
//! Values travel as 32-bit floats by C cast, as ArduPilot does it. Where ArduRover 4.6 keeps silent (unknown
//! name, impossible value), PARAM_ERROR says so: clients that know it need not wait for their time-out, the
//! others ignore it.

use helmlink_wire::dialect::{
    CharArray, Message, PARAM_ERROR_DATA, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA, PARAM_VALUE_DATA,
};
use helmlink_wire::enums::{
    MAV_PARAM_ERROR_DOES_NOT_EXIST, MAV_PARAM_ERROR_READ_ONLY, MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
};
use helmlink_wire::{Identity, LinkId};

use super::{Param, Parameters, SetError};
use crate::autopilot::Autopilot;

/// PARAM_VALUE's index for a value that was asked for by name or changed: "not part of a list".
const NO_INDEX: u16 = u16::MAX;
/// Parameters sent per link and loop while listing: some 1000 per second, as measured on ArduRover.
const LISTED_PER_LOOP: usize = 20;

/// How far a link's parameter list has been sent: index of the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::autopilot) struct Listing(pub(in crate::autopilot) usize);

impl Parameters {
    fn message(&self, param: Param, index: u16) -> Option<Message> {
        let (definition, value) = self.at(param.0)?;
        Some(Message::PARAM_VALUE(PARAM_VALUE_DATA {
            param_value: value,
            param_count: u16::try_from(self.count()).unwrap_or(u16::MAX),
            param_index: index,
            param_id: CharArray::from(definition.name.as_str()),
            param_type: definition.kind.to_wire(),
        }))
    }
}

impl Autopilot {
    /// PARAM_REQUEST_LIST: starts sending all, from the first again if a list is under way.
    pub(in crate::autopilot) fn start_parameter_list(&mut self, link: LinkId) {
        self.links.set_listing(link, Some(Listing(0)));
    }

    /// Sends the next few parameters of every list under way.
    pub(in crate::autopilot) fn continue_parameter_lists(&mut self) {
        for (link, Listing(next)) in self.links.listings() {
            let end = (next + LISTED_PER_LOOP).min(self.parameters.count());
            for index in next..end {
                let number = u16::try_from(index).unwrap_or(NO_INDEX);
                if let Some(message) = self.parameters.message(Param(index), number) {
                    self.links.send(link, &message);
                }
            }
            let done = end == self.parameters.count();
            self.links.set_listing(link, (!done).then_some(Listing(end)));
        }
    }

    /// PARAM_REQUEST_READ: by index, or by name when the index is −1.
    pub(in crate::autopilot) fn read_parameter(
        &mut self,
        link: LinkId,
        from: Identity,
        request: &PARAM_REQUEST_READ_DATA,
    ) {
        let found = match usize::try_from(request.param_index) {
            Ok(index) if index < self.parameters.count() => {
                self.parameters.message(Param(index), u16::try_from(index).unwrap_or(NO_INDEX))
            }
            Ok(_) => None,
            Err(_) => {
                let param = request.param_id.to_str().ok().and_then(|name| self.parameters.find(name));
                param.and_then(|param| self.parameters.message(param, NO_INDEX))
            }
        };
        match found {
            Some(message) => self.links.send(link, &message),
            None => self.refuse_parameter(
                link,
                from,
                request.param_id,
                request.param_index,
                MAV_PARAM_ERROR_DOES_NOT_EXIST,
            ),
        }
    }

    /// PARAM_SET. The type sent along is ignored: many clients always send REAL32.
    pub(in crate::autopilot) fn set_parameter(
        &mut self,
        link: LinkId,
        from: Identity,
        request: &PARAM_SET_DATA,
    ) {
        let name = request.param_id.to_str().unwrap_or_default();
        let error = match self.parameters.set(name, request.param_value) {
            Ok(param) => {
                self.announce_parameter(param);
                return;
            }
            Err(SetError::Unknown) => MAV_PARAM_ERROR_DOES_NOT_EXIST,
            Err(SetError::OutOfRange) => MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
            Err(SetError::ReadOnly) => MAV_PARAM_ERROR_READ_ONLY,
        };
        self.refuse_parameter(link, from, request.param_id, -1, error);
    }

    /// Tells everyone a parameter's value.
    pub(in crate::autopilot) fn announce_parameter(&mut self, param: Param) {
        if let Some(message) = self.parameters.message(param, NO_INDEX) {
            self.links.broadcast(&message);
        }
    }

    fn refuse_parameter(&mut self, link: LinkId, to: Identity, id: CharArray<16>, index: i16, error: u8) {
        let message = PARAM_ERROR_DATA {
            param_index: index,
            target_system: to.system,
            target_component: to.component,
            param_id: id,
            error,
        };
        self.links.send(link, &Message::PARAM_ERROR(message));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autopilot::testing::{Bench, GCS, LINK, OTHER_LINK};

    fn set(name: &str, value: f32) -> Message {
        Message::PARAM_SET(PARAM_SET_DATA {
            param_value: value,
            target_system: 1,
            target_component: 1,
            param_id: CharArray::from(name),
            param_type: 9,
        })
    }

    fn values(messages: &[Message]) -> Vec<PARAM_VALUE_DATA> {
        let value = |message: &Message| match message {
            Message::PARAM_VALUE(data) => Some(data.clone()),
            _ => None,
        };
        messages.iter().filter_map(value).collect()
    }

    #[test]
    fn a_list_holds_every_index_once_and_is_paced() {
        let mut bench = Bench::ready();
        bench.send(LINK, GCS, &Message::PARAM_REQUEST_LIST(Default::default()));
        let first = values(&bench.run_loops(1)[&LINK]);
        assert_eq!(first.len(), LISTED_PER_LOOP);
        let rest = values(&bench.run_s(1.0)[&LINK]);
        let listed: Vec<u16> = first.iter().chain(&rest).map(|value| value.param_index).collect();
        let count = first[0].param_count;
        assert!(count > 80);
        assert_eq!(
            listed.into_iter().filter(|&at| at != NO_INDEX).collect::<Vec<_>>(),
            (0..count).collect::<Vec<_>>()
        );
    }

    #[test]
    fn a_set_is_answered_on_all_links_with_the_true_type() {
        let mut bench = Bench::ready();
        bench.send(LINK, GCS, &set("SYSID_MYGCS", 42.0));
        let answers = bench.run_loops(1);
        for link in [LINK, OTHER_LINK] {
            let value = &values(&answers[&link])[0];
            assert_eq!((value.param_value, value.param_type, value.param_index), (42.0, 4, NO_INDEX));
        }
    }

    #[test]
    fn reads_by_name_and_by_index() {
        let mut bench = Bench::ready();
        let read = |name: &str, index: i16| {
            Message::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
                param_index: index,
                target_system: 1,
                target_component: 1,
                param_id: CharArray::from(name),
            })
        };
        bench.send(LINK, GCS, &read("WP_SPEED", -1));
        bench.send(LINK, GCS, &read("", 3));
        let answers = values(&bench.run_loops(1)[&LINK]);
        assert_eq!(answers[0].param_id.to_str(), Ok("WP_SPEED"));
        assert_eq!(answers[0].param_index, NO_INDEX);
        assert_eq!(answers[1].param_index, 3);
    }

    #[test]
    fn what_cannot_be_answered_is_refused_at_once_to_the_asker_only() {
        let mut bench = Bench::ready();
        for (name, value, expected) in
            [("NO_SUCH", 1.0, 1), ("WP_RADIUS", f32::NAN, 2), ("WP_RADIUS", -5.0, 2), ("MIS_TOTAL", 1.0, 5)]
        {
            bench.send(LINK, GCS, &set(name, value));
            let answers = bench.run_loops(1);
            let errors = |link| {
                let error = |message: &Message| match message {
                    Message::PARAM_ERROR(data) => Some((data.error, data.target_system)),
                    _ => None,
                };
                answers[&link].iter().filter_map(error).collect::<Vec<_>>()
            };
            assert_eq!(errors(LINK), [(expected, GCS.system)], "{name} = {value}");
            assert_eq!(errors(OTHER_LINK), []);
        }
    }
}
