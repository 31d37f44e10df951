//! A party behind a gate: the edge sees a party, the party sees only what may come in.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use helmlink_wire::LinkId;

use super::edge::Party;
use crate::gate::{Gate, Terms};
use crate::link::EndpointId;

/// How often the gate is told the time of day.
const CLOCK_INTERVAL: Duration = Duration::from_secs(1);

/// A party and its gate.
pub(super) struct Guarded<P> {
    party: P,
    /// The gate.
    pub(super) gate: Gate,
    terms: BTreeMap<EndpointId, Terms>,
    inside: Vec<u8>,
    told_time: Option<Duration>,
}

impl<P> Guarded<P> {
    pub(super) fn new(party: P, gate: Gate) -> Self {
        Self { party, gate, terms: BTreeMap::new(), inside: Vec::new(), told_time: None }
    }

    /// What holds for the links of an endpoint; to be said before they come up.
    pub(super) fn agree(&mut self, endpoint: EndpointId, terms: Terms) {
        self.terms.insert(endpoint, terms);
    }
}

impl<P> Deref for Guarded<P> {
    type Target = P;

    fn deref(&self) -> &P {
        &self.party
    }
}

impl<P> DerefMut for Guarded<P> {
    fn deref_mut(&mut self) -> &mut P {
        &mut self.party
    }
}

impl<P: Party> Party for Guarded<P> {
    fn link_up(&mut self, now: Duration, link: LinkId, endpoint: EndpointId) {
        let terms = self.terms.get(&endpoint).copied().unwrap_or(Terms::OPEN);
        self.gate.link_up(now, link, terms);
        self.party.link_up(now, link, endpoint);
    }

    fn link_down(&mut self, now: Duration, link: LinkId) {
        self.gate.link_down(link);
        self.party.link_down(now, link);
    }

    fn on_bytes(&mut self, now: Duration, link: LinkId, bytes: &[u8], is_datagram: bool) {
        self.inside.clear();
        self.gate.incoming(now, link, bytes, is_datagram, &mut self.inside);
        if !self.inside.is_empty() {
            self.party.on_bytes(now, link, &self.inside, is_datagram);
        }
    }

    fn on_tick(&mut self, now: Duration) {
        if self.told_time.is_none_or(|then| now.saturating_sub(then) >= CLOCK_INTERVAL) {
            self.told_time = Some(now);
            self.gate.observe_time_of_day(SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default());
        }
        for (link, bytes) in self.gate.after_silence(now) {
            self.party.on_bytes(now, link, &bytes, false);
        }
        self.party.on_tick(now);
    }

    fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        loop {
            let (link, mut frame) = self.party.poll_transmit()?;
            if self.gate.outgoing(link, &mut frame) {
                return Some((link, frame));
            }
        }
    }
}
