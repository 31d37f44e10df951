//! The autopilot's links: what waits to be read and written on each, and its message rates.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use helmlink_wire::dialect::{CharArray, Message, STATUSTEXT_DATA};
use helmlink_wire::encoder::Encoder;
use helmlink_wire::frame::Identity;
use helmlink_wire::framer::{Framer, IDLE_FLUSH};
use helmlink_wire::signing::{Signing, Timestamp, Unsigned};
use helmlink_wire::{Frame, LinkId, Outbox};

use super::parameters::Listing;
use super::routes::Routes;
use super::streams::Streams;

/// Links served at once. Further ones are not answered.
pub(super) const MAX_LINKS: usize = 64;
/// Bytes taken in per link and loop; what exceeds it is lost, as in the buffer of a serial port.
const MAX_WAITING_BYTES: usize = 1 << 20;
/// Bytes that a chunk counts for on top of its own, so that many tiny datagrams are limited too.
const CHUNK_OVERHEAD: usize = 64;
/// Bytes that wait to be taken by a link's owner, and by all of them, who share that alike; what exceeds it is
/// lost, answers last.
const MAX_LEAVING_BYTES: (usize, usize) = (256 << 10, 1 << 20);

/// One link.
#[derive(Debug, Default)]
struct Link {
    waiting: VecDeque<Chunk>,
    waiting_bytes: usize,
    /// When bytes last arrived that no flush has followed.
    last_arrival: Option<Duration>,
    framer: Framer,
    encoder: Encoder,
    outbox: Outbox,
    streams: Streams,
    listing: Option<Listing>,
}

/// Bytes as they arrived.
#[derive(Debug)]
pub(super) struct Chunk {
    pub(super) bytes: Vec<u8>,
    /// Whether no frame goes on in the next chunk.
    pub(super) datagram: bool,
}

/// All links of the autopilot, and who is reached over which.
#[derive(Debug)]
pub(super) struct Links {
    links: BTreeMap<LinkId, Link>,
    pub(super) routes: Routes,
    pub(super) own: Identity,
    /// What frames are signed and checked with.
    signing: Option<Signing>,
    /// The frame that is being written.
    frame: Vec<u8>,
    lost: u64,
}

impl Links {
    pub(super) fn new(own: Identity) -> Self {
        Self {
            links: BTreeMap::new(),
            routes: Routes::default(),
            own,
            signing: None,
            frame: Vec::new(),
            lost: 0,
        }
    }

    /// Opens a link; `false` if there are too many already.
    pub(super) fn up(&mut self, link: LinkId) -> bool {
        if self.links.len() >= MAX_LINKS && !self.links.contains_key(&link) {
            return false;
        }
        self.links.entry(link).or_default();
        true
    }

    /// Forgets a link with all that waits on it.
    pub(super) fn down(&mut self, link: LinkId) {
        self.links.remove(&link);
        self.routes.forget(link);
    }

    /// Every link, in order.
    pub(super) fn ids(&self) -> Vec<LinkId> {
        self.links.keys().copied().collect()
    }

    /// Takes in bytes; they are read at the next loop.
    pub(super) fn push(&mut self, link: LinkId, bytes: &[u8], datagram: bool) {
        let Some(link) = self.links.get_mut(&link) else { return };
        let room = MAX_WAITING_BYTES.saturating_sub(link.waiting_bytes);
        let bytes = &bytes[..bytes.len().min(room)];
        if bytes.is_empty() {
            return;
        }
        link.waiting_bytes += bytes.len();
        match link.waiting.back_mut() {
            Some(last) if !datagram && !last.datagram => last.bytes.extend_from_slice(bytes),
            _ => {
                link.waiting_bytes += CHUNK_OVERHEAD;
                link.waiting.push_back(Chunk { bytes: bytes.to_vec(), datagram });
            }
        }
    }

    /// Lends out the framer of a link with the bytes that have arrived, so that its frames can be handled
    /// while the links are in use. Give it back with [`Links::give_back`]. After [`IDLE_FLUSH`] of silence
    /// there is one empty datagram, which frees frames that a false start holds up.
    pub(super) fn take_framer(&mut self, link: LinkId, now: Duration) -> Option<(Framer, VecDeque<Chunk>)> {
        let link = self.links.get_mut(&link)?;
        let mut chunks = std::mem::take(&mut link.waiting);
        if !chunks.is_empty() {
            link.waiting_bytes = 0;
            link.last_arrival = Some(now);
        } else if link.last_arrival.is_some_and(|last| now.saturating_sub(last) >= IDLE_FLUSH) {
            link.last_arrival = None;
            chunks.push_back(Chunk { bytes: Vec::new(), datagram: true });
        } else {
            return None;
        }
        Some((std::mem::take(&mut link.framer), chunks))
    }

    /// Takes a framer back.
    pub(super) fn give_back(&mut self, link: LinkId, framer: Framer) {
        if let Some(link) = self.links.get_mut(&link) {
            link.framer = framer;
        }
    }

    /// Sends a message on one link.
    pub(super) fn send(&mut self, id: LinkId, message: &Message) {
        let limit_bytes = self.limit_bytes();
        let Some(link) = self.links.get_mut(&id) else { return };
        self.frame.clear();
        link.encoder.encode(self.own, message, &mut self.frame);
        if let Some(signing) = &mut self.signing {
            signing.sign(id.0 as u8, &mut self.frame, 0);
        }
        self.lost += link.outbox.push_frame(&self.frame, limit_bytes).bytes;
    }

    /// Bytes that may wait on each link.
    fn limit_bytes(&self) -> usize {
        MAX_LEAVING_BYTES.0.min(MAX_LEAVING_BYTES.1 / self.links.len().max(1))
    }

    /// Bytes that were lost because nobody took them.
    pub(super) fn lost_bytes(&self) -> u64 {
        self.lost
    }

    /// Signs frames from now on, or no longer.
    pub(super) fn set_signing(&mut self, signing: Option<Signing>) {
        self.signing = signing;
    }

    /// Tells the signatures' clock the time.
    pub(super) fn observe_time(&mut self, now: Timestamp) {
        if let Some(signing) = &mut self.signing {
            signing.observe_time(now);
        }
    }

    /// Whether a frame may be acted on: with a key, only if its signature is right.
    pub(super) fn is_trusted(&mut self, frame: &Frame<'_>) -> bool {
        self.signing.as_mut().is_none_or(|signing| signing.check(frame, Unsigned::Refused).is_ok())
    }

    /// Sends a message on every link.
    pub(super) fn broadcast(&mut self, message: &Message) {
        for link in self.ids() {
            self.send(link, message);
        }
    }

    /// Sends STATUSTEXT on every link, in chunks of 50 characters.
    pub(super) fn text(&mut self, severity: u8, text: &str) {
        const CHUNK: usize = 50;
        let chunks: Vec<&[u8]> = text.as_bytes().chunks(CHUNK).collect();
        // A text in one piece has id 0; the pieces of a longer one share an id, here its length.
        let id = if chunks.len() > 1 { u16::try_from(text.len()).unwrap_or(u16::MAX) } else { 0 };
        for (number, chunk) in chunks.iter().enumerate() {
            let mut bytes = [0; CHUNK];
            bytes[..chunk.len()].copy_from_slice(chunk);
            let chunk_seq = u8::try_from(number).unwrap_or(u8::MAX);
            let piece = STATUSTEXT_DATA { severity, text: CharArray::new(bytes), id, chunk_seq };
            self.broadcast(&Message::STATUSTEXT(piece));
        }
    }

    /// Passes a frame on unchanged.
    pub(super) fn forward(&mut self, to: LinkId, frame: &[u8]) {
        let limit_bytes = self.limit_bytes();
        if let Some(link) = self.links.get_mut(&to) {
            self.lost += link.outbox.push_frame(frame, limit_bytes).bytes;
        }
    }

    /// The next packet for a link's owner.
    pub(super) fn poll(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.links.iter_mut().find_map(|(&id, link)| Some((id, link.outbox.pop()?)))
    }

    /// The next packet for one link.
    pub(super) fn poll_on(&mut self, link: LinkId) -> Option<Vec<u8>> {
        self.links.get_mut(&link)?.outbox.pop()
    }

    /// The rates of a link.
    pub(super) fn streams(&mut self, link: LinkId) -> Option<&mut Streams> {
        self.links.get_mut(&link).map(|link| &mut link.streams)
    }

    /// Every link has the default rates again.
    pub(super) fn reset_streams(&mut self) {
        for link in self.links.values_mut() {
            link.streams = Streams::default();
            link.listing = None;
        }
    }

    pub(super) fn set_listing(&mut self, link: LinkId, listing: Option<Listing>) {
        if let Some(link) = self.links.get_mut(&link) {
            link.listing = listing;
        }
    }

    /// The parameter lists under way.
    pub(super) fn listings(&self) -> Vec<(LinkId, Listing)> {
        self.links.iter().filter_map(|(&id, link)| Some((id, link.listing?))).collect()
    }
}

#[cfg(test)]
mod tests {
    use helmlink_wire::dialect::ATTITUDE_DATA;

    use super::*;

    const OWN: Identity = Identity { system: 1, component: 1 };

    #[test]
    fn memory_is_bounded_when_nobody_reads() {
        let mut links = Links::new(OWN);
        links.up(LinkId(1));
        for link in 2..50 {
            links.up(LinkId(link));
        }
        let attitude = Message::ATTITUDE(ATTITUDE_DATA { yawspeed: 1.0, ..ATTITUDE_DATA::DEFAULT });
        for _ in 0..10_000 {
            links.broadcast(&attitude);
        }
        let mut bytes = 0;
        while let Some((_, packet)) = links.poll() {
            assert!(packet.len() <= 1400);
            bytes += packet.len();
        }
        assert!(bytes <= MAX_LEAVING_BYTES.1 && links.lost_bytes() > 0, "{bytes}");
        links.push(LinkId(1), &vec![0; 3 * MAX_WAITING_BYTES], false);
        assert!(links.links[&LinkId(1)].waiting_bytes <= MAX_WAITING_BYTES + CHUNK_OVERHEAD);
        for _ in 0..100_000 {
            links.push(LinkId(1), &[], true);
            links.push(LinkId(1), &[0], true);
        }
        assert_eq!(links.links[&LinkId(1)].waiting.len(), 1);
    }

    #[test]
    fn links_are_limited_in_number_and_forgotten() {
        let mut links = Links::new(OWN);
        for id in 0..MAX_LINKS as u32 {
            assert!(links.up(LinkId(id)));
        }
        assert!(!links.up(LinkId(1000)));
        assert!(links.up(LinkId(3)), "known links stay known");
        links.down(LinkId(3));
        assert!(links.up(LinkId(1000)));
        links.push(LinkId(3), &[1, 2, 3], false);
        assert!(links.take_framer(LinkId(3), Duration::ZERO).is_none());
    }

    #[test]
    fn silence_frees_what_a_false_start_holds_up() {
        let mut links = Links::new(OWN);
        links.up(LinkId(1));
        links.push(LinkId(1), &[0xFD, 200], false);
        let start = Duration::from_secs(1);
        let (framer, chunks) = links.take_framer(LinkId(1), start).unwrap();
        assert_eq!(chunks.len(), 1);
        links.give_back(LinkId(1), framer);
        assert!(links.take_framer(LinkId(1), start + IDLE_FLUSH / 2).is_none());
        let (_, chunks) = links.take_framer(LinkId(1), start + IDLE_FLUSH).unwrap();
        assert!(chunks[0].datagram && chunks[0].bytes.is_empty());
        assert!(links.take_framer(LinkId(1), start + IDLE_FLUSH * 2).is_none(), "once is enough");
    }

    #[test]
    fn long_texts_go_out_in_chunks() {
        let mut links = Links::new(OWN);
        links.up(LinkId(1));
        let text = "x".repeat(70);
        links.text(6, &text);
        let (_, packet) = links.poll().unwrap();
        let mut framer = Framer::new();
        framer.push(&packet);
        let mut joined = String::new();
        while let Some(frame) = framer.next_frame() {
            let Message::STATUSTEXT(piece) = frame.decode().unwrap() else { panic!() };
            assert_ne!(piece.id, 0);
            joined.push_str(piece.text.to_str().unwrap());
        }
        assert_eq!(joined, text);
    }
}
