//! What a simulated boat hears and says, as a telemetry log.

use std::collections::BTreeMap;
use std::time::Duration;

use helmlink_wire::tlog::TlogWriter;
use helmlink_wire::{Frame, Framer, LinkId};

/// Takes down every frame of every link, stamped with the boat's own time.
///
/// The boat tells each of its links the same: what it says to several of them at one instant is logged once.
pub(super) struct SitlLog {
    start_us: u64,
    now: Duration,
    log: TlogWriter<Vec<u8>>,
    incoming: BTreeMap<LinkId, Framer>,
    outgoing: Framer,
    /// Message and content of all that the boat has said at this instant.
    said: Vec<(u32, Vec<u8>)>,
}

impl SitlLog {
    /// A log whose boat's time zero is `start_us` microseconds after the Unix epoch.
    pub(super) fn new(start_us: u64) -> Self {
        Self {
            start_us,
            now: Duration::ZERO,
            log: TlogWriter::new(Vec::new()),
            incoming: BTreeMap::new(),
            outgoing: Framer::new(),
            said: Vec::new(),
        }
    }

    /// Bytes of a client have arrived at this time of the boat's.
    pub(super) fn received(&mut self, now: Duration, link: LinkId, bytes: &[u8], is_datagram: bool) {
        self.advance(now);
        let time_us = self.time_us();
        let framer = self.incoming.entry(link).or_default();
        framer.push(bytes);
        if is_datagram {
            framer.end_of_datagram();
        }
        while let Some(frame) = framer.next_any() {
            write(&mut self.log, time_us, &frame);
        }
    }

    /// The boat has said this, whole frames, to one of its links.
    pub(super) fn said(&mut self, now: Duration, bytes: &[u8]) {
        self.advance(now);
        let time_us = self.time_us();
        self.outgoing.push(bytes);
        while let Some(frame) = self.outgoing.next_any() {
            // MAVLink 2 leaves zeros at the end out, MAVLink 1 does not.
            let end = frame.payload().iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
            let content = &frame.payload()[..end];
            let is_known = |(id, said): &(u32, Vec<u8>)| *id == frame.message_id() && said == content;
            if !self.said.iter().any(is_known) {
                self.said.push((frame.message_id(), content.to_vec()));
                write(&mut self.log, time_us, &frame);
            }
        }
    }

    /// A client has gone: the rest of a frame of its will not come.
    pub(super) fn forget(&mut self, link: LinkId) {
        self.incoming.remove(&link);
    }

    /// The records since the last call, whole ones only.
    pub(super) fn take(&mut self) -> Vec<u8> {
        std::mem::replace(&mut self.log, TlogWriter::new(Vec::new())).into_inner()
    }

    fn advance(&mut self, now: Duration) {
        if now != self.now {
            self.now = now;
            self.said.clear();
        }
    }

    fn time_us(&self) -> u64 {
        self.start_us + self.now.as_micros() as u64
    }
}

fn write(log: &mut TlogWriter<Vec<u8>>, time_us: u64, frame: &Frame<'_>) {
    // Memory takes everything.
    log.write(time_us, frame).ok();
}

#[cfg(test)]
mod tests {
    use helmlink_wire::dialect::HEARTBEAT_DATA;
    use helmlink_wire::tlog::records;
    use helmlink_wire::{Encoder, Identity, Message};

    use super::*;

    const BOAT: Identity = Identity { system: 1, component: 1 };

    fn heartbeat(encoder: &mut Encoder, custom_mode: u32) -> Vec<u8> {
        let mut frame = Vec::new();
        let message = Message::HEARTBEAT(HEARTBEAT_DATA { custom_mode, ..HEARTBEAT_DATA::DEFAULT });
        encoder.encode(BOAT, &message, &mut frame);
        frame
    }

    #[test]
    fn what_several_links_hear_at_once_is_logged_once_and_what_comes_in_always() {
        let mut log = SitlLog::new(1_000_000);
        let (mut to_one, mut to_other) = (Encoder::new(), Encoder::new());
        to_other.encode(BOAT, &Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT), &mut Vec::new());
        let second = Duration::from_secs(1);
        log.said(second, &heartbeat(&mut to_one, 7));
        log.said(second, &heartbeat(&mut to_other, 7));
        log.said(second, &heartbeat(&mut to_other, 8));
        log.said(2 * second, &heartbeat(&mut to_one, 7));
        let from_client = heartbeat(&mut Encoder::new(), 7);
        log.received(2 * second, LinkId(1), &from_client[..5], false);
        log.received(3 * second, LinkId(1), &from_client[5..], false);
        log.received(3 * second, LinkId(2), &from_client, true);
        let taken = log.take();
        let stamps: Vec<u64> = records(&taken).map(|record| record.time_us / 1_000_000).collect();
        assert_eq!(stamps, [2, 2, 3, 4, 4]);
        assert!(log.take().is_empty());
    }

    #[test]
    fn a_client_that_comes_back_begins_anew() {
        let mut log = SitlLog::new(0);
        let frame = heartbeat(&mut Encoder::new(), 1);
        log.received(Duration::ZERO, LinkId(1), &frame[..9], false);
        log.forget(LinkId(1));
        log.received(Duration::ZERO, LinkId(1), &frame, false);
        assert_eq!(records(&log.take()).count(), 1);
    }
}
