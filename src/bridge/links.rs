//! The bridge's peers: one framer, one encoder each, and everything that is to be sent.

use std::collections::VecDeque;
use std::fmt::Write;
use std::time::Duration;

use helmlink_wire::{Encoder, Frame, Framer, Identity, LinkId, LinkStatistics, Message};
use sha2::{Digest, Sha256};

use super::routing::Router;
use crate::record::Journal;
use crate::record::journal::Purpose;

/// Frames waiting for the driver beyond this number are dropped, oldest first: they would be stale anyway.
const OUTBOX_LIMIT: usize = 4096;

/// Who may be at the other end of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FarEnd {
    /// The flight controller, and whoever it passes on.
    Vehicle,
    /// Ground stations and other programs: never the flight controller that is steered.
    Station,
}

/// One peer.
#[derive(Debug)]
struct Link {
    id: LinkId,
    far_end: FarEnd,
    framer: Framer,
    encoder: Encoder,
    last_bytes: Duration,
}

/// All peers of a bridge.
#[derive(Debug)]
pub(super) struct Links {
    links: Vec<Link>,
    outbox: VecDeque<(LinkId, Vec<u8>)>,
    commands: Sha256,
    command_count: u64,
    journal: Option<Journal>,
    /// Frames of the bridge's own, for whoever compares them.
    own: Option<VecDeque<(LinkId, Vec<u8>)>>,
    router: Router,
    listen_only: bool,
}

impl Links {
    pub(super) fn new(listen_only: bool) -> Self {
        Self {
            links: Vec::new(),
            outbox: VecDeque::new(),
            commands: Sha256::new(),
            command_count: 0,
            journal: None,
            own: None,
            router: Router::default(),
            listen_only,
        }
    }

    pub(super) fn keep_journal(&mut self, journal: Journal) {
        self.journal = Some(journal);
    }

    pub(super) fn journal(&mut self) -> Option<&mut Journal> {
        self.journal.as_mut()
    }

    pub(super) fn add(&mut self, now: Duration, id: LinkId, far_end: FarEnd) {
        if let Some(link) = self.links.iter_mut().find(|link| link.id == id) {
            link.far_end = far_end;
        } else {
            let (framer, encoder) = (Framer::new(), Encoder::new());
            self.links.push(Link { id, far_end, framer, encoder, last_bytes: now });
        }
    }

    /// Whether the flight controller may be at the other end of this link.
    pub(super) fn leads_to_vehicle(&self, id: LinkId) -> bool {
        self.links.iter().any(|link| link.id == id && link.far_end == FarEnd::Vehicle)
    }

    pub(super) fn remove(&mut self, id: LinkId) {
        self.router.forget(id);
        self.links.retain(|link| link.id != id);
        self.outbox.retain(|(to, _)| *to != id);
    }

    pub(super) fn ids(&self) -> impl Iterator<Item = LinkId> + '_ {
        self.links.iter().map(|link| link.id)
    }

    pub(super) fn statistics(&self, id: LinkId) -> Option<LinkStatistics> {
        self.links.iter().find(|link| link.id == id).map(|link| *link.framer.statistics())
    }

    /// Takes bytes of one peer in; the frames in them come out of [`Self::next_message`].
    pub(super) fn push(&mut self, now: Duration, id: LinkId, bytes: &[u8], is_datagram: bool) {
        if self.links.iter().all(|link| link.id != id) {
            // Nobody has said who is there.
            self.add(now, id, FarEnd::Station);
        }
        if let Some(link) = self.links.iter_mut().find(|link| link.id == id) {
            link.framer.push(bytes);
            link.last_bytes = now;
            if is_datagram {
                link.framer.end_of_datagram();
            }
        }
    }

    /// Bytes that have been lying in a framer for a while cannot be the start of a frame: looks behind them.
    pub(super) fn flush_idle(&mut self, now: Duration) {
        for link in &mut self.links {
            if now.saturating_sub(link.last_bytes) >= helmlink_wire::framer::IDLE_FLUSH {
                link.framer.end_of_datagram();
                link.last_bytes = now;
            }
        }
    }

    /// The next message of this peer that the bridge has to look at, with who sent it. What is for others is passed on;
    /// `own` are the addresses that the bridge itself sends with.
    pub(super) fn next_message(
        &mut self,
        now: Duration,
        id: LinkId,
        own: &[Identity],
    ) -> Option<(Identity, Message)> {
        let all: Vec<LinkId> = self.ids().collect();
        let link = self.links.iter_mut().find(|link| link.id == id)?;
        while let Some(frame) = link.framer.next_any() {
            if frame.is_verified()
                && let Some(journal) = &mut self.journal
            {
                journal.taken(id, frame.bytes());
            }
            let message = if frame.is_verified() { frame.decode().ok() } else { None };
            let way = self.router.way(now, id, &frame, message.as_ref(), own, &all);
            if !self.listen_only {
                self.outbox.extend(way.onward.into_iter().map(|to| (to, frame.bytes().to_vec())));
            }
            if let Some(message) = message.filter(|_| !way.ignore) {
                return Some((frame.identity(), message));
            }
        }
        None
    }

    /// Sends one message on one link.
    pub(super) fn send(&mut self, to: LinkId, from: Identity, message: &Message) {
        self.encode(to, from, message, Purpose::Talk);
    }

    /// Sends one message on every link.
    pub(super) fn broadcast(&mut self, from: Identity, message: &Message) {
        let all: Vec<LinkId> = self.ids().collect();
        for id in all {
            self.encode(id, from, message, Purpose::Talk);
        }
    }

    /// Sends one message that steers the boat, and counts it into the digest.
    pub(super) fn command(&mut self, to: LinkId, from: Identity, message: &Message) {
        let before = self.outbox.len();
        self.encode(to, from, message, Purpose::Steer);
        if self.outbox.len() > before
            && let Some((_, frame)) = self.outbox.back()
        {
            self.commands.update(frame);
            self.command_count += 1;
        }
    }

    fn encode(&mut self, to: LinkId, from: Identity, message: &Message, purpose: Purpose) {
        if self.listen_only {
            return;
        }
        let Some(link) = self.links.iter_mut().find(|link| link.id == to) else { return };
        if self.outbox.len() >= OUTBOX_LIMIT {
            self.outbox.pop_front();
        }
        let mut frame = Vec::with_capacity(64);
        link.encoder.encode(from, message, &mut frame);
        if let Some(journal) = &mut self.journal
            && let Ok(encoded) = Frame::parse(&frame)
        {
            journal.sent(to, &encoded, purpose);
        }
        if let Some(own) = &mut self.own {
            own.push_back((to, frame.clone()));
        }
        self.outbox.push_back((to, frame));
    }

    pub(super) fn keep_own(&mut self) {
        self.own = Some(VecDeque::new());
    }

    pub(super) fn poll_own(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.own.as_mut()?.pop_front()
    }

    pub(super) fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.outbox.pop_front()
    }

    /// SHA-256 of every steering frame sent so far, in order, as hexadecimal digits; and their number.
    pub(super) fn commands_digest(&self) -> (String, u64) {
        let digest = self.commands.clone().finalize();
        let hex = digest.iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        });
        (hex, self.command_count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_of_another_dialect_is_passed_on_as_it_is() {
        let mut links = Links::new(false);
        let (one, other) = (LinkId(1), LinkId(2));
        links.add(Duration::ZERO, one, FarEnd::Vehicle);
        links.add(Duration::ZERO, other, FarEnd::Station);
        // MAVLink 2, message 54000, three bytes, a checksum that nobody here can check.
        let frame = [0xFD, 3, 0, 0, 7, 255, 190, 0xF0, 0xD2, 0, 1, 2, 3, 0xAA, 0x55];
        links.push(Duration::ZERO, other, &frame, true);
        let own = [Identity { system: 1, component: 191 }];
        assert!(links.next_message(Duration::ZERO, other, &own).is_none(), "nothing to look at");
        assert_eq!(links.poll_transmit(), Some((one, frame.to_vec())));
        assert_eq!(links.poll_transmit(), None);
    }
}
