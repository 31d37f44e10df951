//! A ground station's end of one link: its frames, its heartbeat, and what waits to be sent.

use std::collections::VecDeque;
use std::time::Duration;

use helmlink_wire::dialect::HEARTBEAT_DATA;
use helmlink_wire::{Encoder, Framer, Identity, LinkId, Message, enums};

/// Who a ground station of ours is.
pub(super) const OWN: Identity = Identity { system: 255, component: enums::MAV_COMP_ID_MISSIONPLANNER };

/// What every ground station has to do on its link, whatever it is there for.
#[derive(Debug, Default)]
pub(super) struct Client {
    link: Option<LinkId>,
    framer: Framer,
    encoder: Encoder,
    outbox: VecDeque<Vec<u8>>,
    last_heartbeat: Option<Duration>,
}

impl Client {
    /// A way to the vehicle is there. The next [`Self::keep_alive`] sends a heartbeat.
    pub(super) fn link_up(&mut self, link: LinkId) {
        self.link = Some(link);
        self.last_heartbeat = None;
    }

    /// A peer is gone.
    pub(super) fn link_down(&mut self, link: LinkId) {
        self.link = self.link.filter(|known| *known != link);
    }

    /// Bytes of the vehicle's have arrived.
    pub(super) fn push(&mut self, bytes: &[u8]) {
        self.framer.push(bytes);
    }

    /// The next message among them, and from whom.
    pub(super) fn next_message(&mut self) -> Option<(Identity, Message)> {
        loop {
            let frame = self.framer.next_frame()?;
            if let Ok(message) = frame.decode() {
                return Some((frame.identity(), message));
            }
        }
    }

    /// Sends a heartbeat when the last one is `interval` old.
    pub(super) fn keep_alive(&mut self, now: Duration, interval: Duration) {
        if is_due(&mut self.last_heartbeat, now, interval) {
            self.send(&Message::HEARTBEAT(HEARTBEAT_DATA {
                mavtype: enums::MAV_TYPE_GCS,
                autopilot: enums::MAV_AUTOPILOT_INVALID,
                system_status: enums::MAV_STATE_ACTIVE,
                mavlink_version: 3,
                ..HEARTBEAT_DATA::DEFAULT
            }));
        }
    }

    /// Sends a message.
    pub(super) fn send(&mut self, message: &Message) {
        let mut frame = Vec::new();
        self.encoder.encode(OWN, message, &mut frame);
        self.outbox.push_back(frame);
    }

    /// The next frame to send; nothing leaves while there is no link.
    pub(super) fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        let link = self.link?;
        self.outbox.pop_front().map(|frame| (link, frame))
    }
}

/// True once per interval.
pub(super) fn is_due(last: &mut Option<Duration>, now: Duration, interval: Duration) -> bool {
    let due = last.is_none_or(|then| now.saturating_sub(then) >= interval);
    if due {
        *last = Some(now);
    }
    due
}
