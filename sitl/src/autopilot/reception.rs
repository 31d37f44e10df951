//! From the bytes of a link to messages: passed on, acted upon, or both.

use helmlink_wire::dialect::{MessageData, RADIO_DATA, RADIO_STATUS_DATA};
use helmlink_wire::signing::is_secret;
use helmlink_wire::{Frame, LinkId};

use super::Autopilot;
use super::routes::Target;

impl Autopilot {
    /// Reads what has arrived on a link.
    pub(super) fn receive(&mut self, link: LinkId) {
        let Some((mut framer, chunks)) = self.links.take_framer(link, self.now) else { return };
        for chunk in chunks {
            framer.push(&chunk.bytes);
            if chunk.datagram {
                framer.end_of_datagram();
            }
            while let Some(frame) = framer.next_any() {
                self.take_frame(link, &frame);
            }
        }
        self.links.give_back(link, framer);
    }

    /// Passes a frame on to where it is to go, and acts on it if it is for this autopilot.
    fn take_frame(&mut self, link: LinkId, frame: &Frame) {
        let (from, own) = (frame.identity(), self.links.own);
        // Reports of the radio about itself concern its own link alone.
        let is_local = matches!(frame.message_id(), RADIO_STATUS_DATA::ID | RADIO_DATA::ID);
        if from == own || from.system == 0 || is_local || self.is_starting() || !self.links.is_trusted(frame)
        {
            return;
        }
        let message = if frame.is_verified() { frame.decode().ok() } else { None };
        let target = message.as_ref().map_or(Target::EVERYONE, Target::of);
        if message.is_some() {
            self.links.routes.learn(from, link);
        }
        let verdict = self.links.routes.decide(own, from, target, link, &self.links.ids());
        // Nobody else is to hear a key.
        if !is_secret(frame.message_id()) {
            for to in verdict.onward {
                self.links.forward(to, frame.bytes());
            }
        }
        if let Some(message) = message
            && verdict.here
        {
            self.on_message(link, from, &message);
        }
    }
}
