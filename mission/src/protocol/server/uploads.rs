//! Replacing plans, whole or in part: one client at a time for each type of plan.

use super::rules::polygons_are_whole;
use super::*;
use crate::protocol::REPEAT_GUARD;

impl MissionServer {
    /// MISSION_COUNT begins an upload, or begins it anew for the client that already has one.
    pub(super) fn on_count(&mut self, now: Duration, client: Client, mission_type: u8, count: u16) {
        let Some(known) = MissionType::from_wire(mission_type) else {
            return self.send_ack(client, mission_type, MAV_MISSION_UNSUPPORTED);
        };
        if self.is_busy_with_another(client, known) {
            return self.send_ack(client, mission_type, MAV_MISSION_DENIED);
        }
        self.receiving[index(known)] = None;
        self.verdicts[index(known)] = None;
        if count > self.settings.capacity {
            return self.send_ack(client, mission_type, MAV_MISSION_NO_SPACE);
        }
        if count == 0 {
            self.replace(known, Vec::new());
            return self.send_ack(client, mission_type, MAV_MISSION_ACCEPTED);
        }
        self.receiving[index(known)] = Some(Receiving::whole(client, now, count));
        self.send_request(client, known, 0);
    }

    /// MISSION_WRITE_PARTIAL_LIST: items `start..=end` over the stored ones; the first may be just past the
    /// end of the plan, which it then lengthens.
    pub(super) fn on_write_partial(
        &mut self,
        now: Duration,
        client: Client,
        mission_type: u8,
        start: i16,
        end: i16,
    ) {
        let Some(known) = MissionType::from_wire(mission_type) else {
            return self.send_ack(client, mission_type, MAV_MISSION_UNSUPPORTED);
        };
        if self.is_busy_with_another(client, known) {
            return self.send_ack(client, mission_type, MAV_MISSION_DENIED);
        }
        let (Ok(first), Ok(last)) = (u16::try_from(start), u16::try_from(end)) else {
            return self.send_ack(client, mission_type, MAV_MISSION_ERROR);
        };
        if last < first || first > self.store.count(known) {
            return self.send_ack(client, mission_type, MAV_MISSION_ERROR);
        }
        if last >= self.settings.capacity {
            return self.send_ack(client, mission_type, MAV_MISSION_NO_SPACE);
        }
        let stored = self.store.slots(known).to_vec();
        self.verdicts[index(known)] = None;
        self.receiving[index(known)] = Some(Receiving::part(client, now, stored, first, last + 1));
        self.send_request(client, known, first);
    }

    /// An item of an upload, in either form.
    pub(super) fn on_item(&mut self, now: Duration, client: Client, received: &Received) {
        let Some(known) = MissionType::from_wire(received.mission_type) else { return };
        let rule = self.settings.rule;
        let Some(receiving) = self.receiving[index(known)].as_mut().filter(|r| r.client == client) else {
            return self.repeat_verdict(now, client, known, received.seq);
        };
        let wanted = receiving.next();
        if received.seq != wanted {
            // The client has not heard the last request, or hears it late.
            if receiving.asked_before(now) >= REPEAT_GUARD {
                receiving.ask_again(now);
                self.send_request(client, known, wanted);
            }
            return;
        }
        let is_home = known == MissionType::Mission && wanted == 0;
        if !is_home && let Err(result) = rule(&received.item, known) {
            return self.conclude(now, client, known, wanted, result);
        }
        receiving.take(now, received.item);
        if !receiving.is_complete() {
            let next = receiving.next();
            return self.send_request(client, known, next);
        }
        if known == MissionType::Fence && !polygons_are_whole(receiving.staged()) {
            return self.conclude(now, client, known, wanted, MAV_MISSION_ERROR);
        }
        self.conclude(now, client, known, wanted, MAV_MISSION_ACCEPTED);
    }

    /// MISSION_ACK of a client: thanks for a download, which is not answered, or the end of its upload.
    pub(super) fn on_ack(&mut self, client: Client, mission_type: u8, result: u8) {
        let Some(known) = MissionType::from_wire(mission_type) else { return };
        let receiving = &mut self.receiving[index(known)];
        if result == MAV_MISSION_OPERATION_CANCELLED && receiving.as_ref().is_some_and(|r| r.client == client)
        {
            *receiving = None;
        }
    }

    /// Asks again for items that do not come and gives up uploads that do not go on.
    pub(super) fn keep_uploads_going(&mut self, now: Duration) {
        let Settings { ask_again, give_up, .. } = self.settings;
        for mission_type in MissionType::ALL {
            let Some(receiving) = &mut self.receiving[index(mission_type)] else { continue };
            let client = receiving.client;
            let (ask_at, give_up_at) = receiving.deadlines(ask_again, give_up);
            if now >= give_up_at {
                self.receiving[index(mission_type)] = None;
                self.send_ack(client, mission_type.to_wire(), MAV_MISSION_OPERATION_CANCELLED);
            } else if now >= ask_at {
                receiving.ask_again(now);
                let wanted = receiving.next();
                self.send_request(client, mission_type, wanted);
            }
        }
    }

    /// Whether another client is replacing this plan.
    pub(super) fn is_busy_with_another(&self, client: Client, mission_type: MissionType) -> bool {
        self.receiving[index(mission_type)].as_ref().is_some_and(|r| r.client != client)
    }

    /// Ends an upload with item `seq`: its plan becomes the stored one if it was accepted, and the client is
    /// told.
    fn conclude(&mut self, now: Duration, client: Client, mission_type: MissionType, seq: u16, result: u8) {
        let received = self.receiving[index(mission_type)].take();
        if let (MAV_MISSION_ACCEPTED, Some(received)) = (result, received) {
            self.replace(mission_type, received.into_staged());
        }
        let forget_at = now + self.settings.give_up;
        self.verdicts[index(mission_type)] = Some(Verdict { client, seq, result, told_at: now, forget_at });
        self.send_ack(client, mission_type.to_wire(), result);
    }

    /// A client that sends its last item again has missed how its upload ended. Other items out of the blue
    /// are ignored: an answer could be taken for one about a later exchange.
    fn repeat_verdict(&mut self, now: Duration, client: Client, mission_type: MissionType, seq: u16) {
        let Some(verdict) = &mut self.verdicts[index(mission_type)] else { return };
        let is_its_last = verdict.client == client && verdict.seq == seq && now < verdict.forget_at;
        if is_its_last && now.saturating_sub(verdict.told_at) >= REPEAT_GUARD {
            verdict.told_at = now;
            let result = verdict.result;
            self.send_ack(client, mission_type.to_wire(), result);
        }
    }
}
