//! Reading and clearing plans. Nothing is remembered between two questions, so any number of clients may
//! ask for any items in any order, several at once.

use super::*;

impl MissionServer {
    /// MISSION_REQUEST_LIST. Refused while another client replaces this plan, as ArduRover does.
    pub(super) fn on_list(&mut self, client: Client, mission_type: u8) {
        let Some(known) = MissionType::from_wire(mission_type) else {
            return self.send_ack(client, mission_type, MAV_MISSION_UNSUPPORTED);
        };
        if self.is_busy_with_another(client, known) {
            return self.send_ack(client, mission_type, MAV_MISSION_DENIED);
        }
        self.send_count(client, known);
    }

    /// MISSION_REQUEST_INT is answered with MISSION_ITEM_INT, MISSION_REQUEST with MISSION_ITEM.
    pub(super) fn on_item_request(&mut self, client: Client, mission_type: u8, seq: u16, with_int: bool) {
        let Some(known) = MissionType::from_wire(mission_type) else {
            return self.send_ack(client, mission_type, MAV_MISSION_UNSUPPORTED);
        };
        let Some(item) = self.store.read(known, seq) else {
            return self.send_ack(client, mission_type, MAV_MISSION_ERROR);
        };
        let Identity { system, component } = client.identity;
        let message = if with_int {
            Message::MISSION_ITEM_INT(item.to_int_message(seq, system, component, mission_type))
        } else {
            Message::MISSION_ITEM(item.to_float_message(seq, system, component, mission_type))
        };
        self.send(client, message);
    }

    /// MISSION_CLEAR_ALL for one type or, with type 255, for all of them.
    pub(super) fn on_clear(&mut self, client: Client, mission_type: u8) {
        let to_clear: &[MissionType] = match MissionType::from_wire(mission_type) {
            Some(known) => &[known],
            None if mission_type == MAV_MISSION_TYPE_ALL => &MissionType::ALL,
            None => return self.send_ack(client, mission_type, MAV_MISSION_UNSUPPORTED),
        };
        let in_use = |t: &MissionType| {
            self.receiving[index(*t)].is_some() || (self.in_auto && *t == MissionType::Mission)
        };
        if to_clear.iter().any(in_use) {
            return self.send_ack(client, mission_type, MAV_MISSION_ERROR);
        }
        for mission_type in to_clear {
            self.replace(*mission_type, Vec::new());
        }
        self.send_ack(client, mission_type, MAV_MISSION_ACCEPTED);
    }
}
