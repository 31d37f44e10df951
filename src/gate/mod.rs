//! What may come in from a party's links and go out to them: signatures, allowed systems, secrets.
//!
//! The gate stands between the links and a party such as the bridge. What it lets in arrives as bytes again, noise
//! left out, so the party behind it decides by the same bytes live and in a replay.
//!
//! | coming in | going out |
//! |---|---|
//! | a signed link: only right signatures, RADIO_STATUS, and unsigned frames where allowed | signed, unless somebody else's signature is on it already |
//! | orders: only from allowed systems ([`orders`]) | SETUP_SIGNING, which holds the key: on signed links only |
//! | SETUP_SIGNING: never, so that no key is logged or passed on | |

pub mod orders;

use std::collections::BTreeMap;
use std::time::Duration;

use helmlink_wire::framer::IDLE_FLUSH;
use helmlink_wire::signing::{Refusal, Signing, SigningStatistics, Timestamp, Unsigned, is_secret};
use helmlink_wire::{Frame, Framer, LinkId, LinkStatistics};

/// What holds on the links of one endpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Terms {
    /// Frames are signed and signatures required; without a key, nothing is.
    pub signed: bool,
    /// What to do with unsigned frames on a signed link.
    pub unsigned: Unsigned,
    /// The endpoint's number, which is also the link id in signatures.
    pub number: u8,
}

impl Terms {
    /// No signatures.
    pub const OPEN: Self = Self { signed: false, unsigned: Unsigned::Accepted, number: 0 };
}

/// Frames that were not let through.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Refused {
    /// For their signature, or the lack of one.
    pub signature: u64,
    /// Orders from systems that may give none.
    pub orders: u64,
    /// With a secret in them.
    pub secrets: u64,
}

/// Stands between links and a party.
#[derive(Debug)]
pub struct Gate {
    signing: Option<Signing>,
    /// Systems that may give orders; everybody if empty.
    allowed_systems: Vec<u8>,
    links: BTreeMap<LinkId, Link>,
    refused: Refused,
    /// Refusals that nobody has been told of: of each kind the first, then ever fewer.
    news: Option<String>,
}

#[derive(Debug)]
struct Link {
    terms: Terms,
    framer: Framer,
    last_bytes: Duration,
}

impl Gate {
    /// A gate that signs and checks by `signing` where a link's terms ask for it, and lets orders in only from
    /// `allowed_systems`, or from everybody if there are none.
    pub fn new(signing: Option<Signing>, allowed_systems: Vec<u8>) -> Self {
        Self { signing, allowed_systems, links: BTreeMap::new(), refused: Refused::default(), news: None }
    }

    /// A peer has appeared.
    pub fn link_up(&mut self, now: Duration, link: LinkId, terms: Terms) {
        self.links.insert(link, Link { terms, framer: Framer::new(), last_bytes: now });
    }

    /// A peer has gone.
    pub fn link_down(&mut self, link: LinkId) {
        self.links.remove(&link);
    }

    /// The time of day, for signatures. The gate does without exactness, and copes with jumps.
    pub fn observe_time_of_day(&mut self, since_epoch: Duration) {
        if let Some(signing) = &mut self.signing {
            signing.observe_time(Timestamp::from_unix(since_epoch));
        }
    }

    /// Bytes from a peer; what of them may come in is appended to `inside`.
    pub fn incoming(
        &mut self,
        now: Duration,
        id: LinkId,
        bytes: &[u8],
        is_datagram: bool,
        inside: &mut Vec<u8>,
    ) {
        let Some(link) = self.links.get_mut(&id) else { return };
        link.last_bytes = now;
        link.framer.push(bytes);
        if is_datagram {
            link.framer.end_of_datagram();
        }
        self.let_in(id, inside);
    }

    /// Frames that a false start has held up on a line which is silent now, with their links.
    pub fn after_silence(&mut self, now: Duration) -> Vec<(LinkId, Vec<u8>)> {
        let mut freed = Vec::new();
        let silent: Vec<LinkId> = self
            .links
            .iter()
            .filter(|(_, link)| now.saturating_sub(link.last_bytes) >= IDLE_FLUSH)
            .map(|(id, _)| *id)
            .collect();
        for id in silent {
            if let Some(link) = self.links.get_mut(&id) {
                link.last_bytes = now;
                link.framer.end_of_datagram();
            }
            let mut inside = Vec::new();
            self.let_in(id, &mut inside);
            if !inside.is_empty() {
                freed.push((id, inside));
            }
        }
        freed
    }

    /// A frame to a peer, made ready for its link; false when it must not go there.
    pub fn outgoing(&mut self, id: LinkId, frame: &mut Vec<u8>) -> bool {
        let Some(link) = self.links.get(&id) else { return false };
        let signs = link.terms.signed && self.signing.is_some();
        let id = Frame::parse(frame).map(|frame| frame.message_id());
        if !signs && id.is_ok_and(is_secret) {
            self.refused.secrets += 1;
            return false;
        }
        if let Some(signing) = self.signing.as_mut().filter(|_| signs) {
            signing.sign(link.terms.number, frame, 0);
        }
        true
    }

    /// What a link has carried and lost.
    pub fn statistics(&self, id: LinkId) -> Option<&LinkStatistics> {
        self.links.get(&id).map(|link| link.framer.statistics())
    }

    /// How signatures have fared; none without a key.
    pub fn signing_statistics(&self) -> Option<&SigningStatistics> {
        self.signing.as_ref().map(Signing::statistics)
    }

    /// What must not be used again after a restart; none without a key.
    pub fn timestamp(&self) -> Option<Timestamp> {
        self.signing.as_ref().map(Signing::timestamp)
    }

    /// Frames not let through so far.
    pub fn refused(&self) -> Refused {
        self.refused
    }

    /// A line for the log about frames not let through, now and then.
    pub fn take_news(&mut self) -> Option<String> {
        self.news.take()
    }

    fn let_in(&mut self, id: LinkId, inside: &mut Vec<u8>) {
        let Some(link) = self.links.get_mut(&id) else { return };
        while let Some(frame) = link.framer.next_any() {
            let verdict = judge(&frame, link.terms, self.signing.as_mut(), &self.allowed_systems);
            match verdict {
                Ok(()) => inside.extend_from_slice(frame.bytes()),
                Err(barred) => {
                    let count = self.refused.count(&barred);
                    if count.is_power_of_two() {
                        let (name, from) = (frame.name().unwrap_or("a message"), frame.identity());
                        self.news = Some(barred.describe(name, from.to_string(), count));
                    }
                }
            }
        }
    }
}

/// Why a frame does not come in.
enum Barred {
    Signature(Refusal),
    Order,
    Secret,
}

fn judge(
    frame: &Frame<'_>,
    terms: Terms,
    signing: Option<&mut Signing>,
    allowed_systems: &[u8],
) -> Result<(), Barred> {
    if let Some(signing) = signing.filter(|_| terms.signed) {
        signing.check(frame, terms.unsigned).map_err(Barred::Signature)?;
    }
    if is_secret(frame.message_id()) {
        return Err(Barred::Secret);
    }
    if orders::is_order(frame)
        && !allowed_systems.is_empty()
        && !allowed_systems.contains(&frame.identity().system)
    {
        return Err(Barred::Order);
    }
    Ok(())
}

impl Refused {
    fn count(&mut self, barred: &Barred) -> u64 {
        let counter = match barred {
            Barred::Signature(_) => &mut self.signature,
            Barred::Order => &mut self.orders,
            Barred::Secret => &mut self.secrets,
        };
        *counter += 1;
        *counter
    }
}

impl Barred {
    fn describe(&self, name: &str, from: String, count: u64) -> String {
        let why = match self {
            Self::Signature(refusal) => refusal.to_string(),
            Self::Order => {
                format!("only allowed systems may give orders: add --allow-system {}", system_of(&from))
            }
            Self::Secret => "signing keys are not taken over a link: set them up on each side".to_owned(),
        };
        format!("refused {name} from {from} ({count} so far): {why}")
    }
}

fn system_of(from: &str) -> &str {
    from.split_once('/').map_or(from, |(system, _)| system)
}

#[cfg(test)]
mod tests;
