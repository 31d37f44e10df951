//! Passes frames on between the bridge's links: a ground station on a second link reaches the flight controller.
//!
//! The rules are MAVLink's (<https://mavlink.io/en/guide/routing.html>): what is for everyone goes to every other link,
//! what is for somebody goes where he has been heard, nothing goes back where it came from. On top of that a frame that
//! has just been passed on is not passed on again, so that two ways to the same place make no loop.

use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::hash::{Hash, Hasher};
use std::time::Duration;

use helmlink_wire::dialect::MessageSet;
use helmlink_wire::{Frame, Identity, LinkId, Message};

/// Components remembered: enough for a fleet, and a bound for invented ones.
const MAX_ROUTES: usize = 256;
/// Frames remembered…
const MAX_SEEN: usize = 512;
/// …for this long: sequence numbers come round again, so an equal frame later is another one.
const SEEN_FOR: Duration = Duration::from_millis(500);

/// Where everybody has been heard, and what has just passed.
#[derive(Debug, Default)]
pub(super) struct Router {
    heard: BTreeMap<Identity, BTreeSet<LinkId>>,
    seen: VecDeque<(u64, Duration)>,
}

/// What becomes of a frame.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Way {
    /// It is nothing that the bridge has to look at: its own, or a copy.
    pub(super) ignore: bool,
    /// The links to pass it on to.
    pub(super) onward: Vec<LinkId>,
}

impl Router {
    /// Forgets a link and those who were heard on it alone.
    pub(super) fn forget(&mut self, link: LinkId) {
        self.heard.retain(|_, links| {
            links.remove(&link);
            !links.is_empty()
        });
    }

    /// What becomes of a frame that arrived on `link`, one of `all`; `message` is none where it cannot be decoded.
    /// `own` are the addresses that the bridge itself sends with.
    pub(super) fn way(
        &mut self,
        now: Duration,
        link: LinkId,
        frame: &Frame<'_>,
        message: Option<&Message>,
        own: &[Identity],
        all: &[LinkId],
    ) -> Way {
        let from = frame.identity();
        if own.contains(&from) {
            return Way { ignore: true, onward: Vec::new() };
        }
        if frame.is_verified() {
            self.learn(from, link);
        }
        if all.len() < 2 {
            return Way::default();
        }
        if self.is_copy(now, frame) {
            return Way { ignore: true, onward: Vec::new() };
        }
        Way { ignore: false, onward: self.onward(link, from, message, own, all) }
    }

    fn onward(
        &self,
        link: LinkId,
        from: Identity,
        message: Option<&Message>,
        own: &[Identity],
        all: &[LinkId],
    ) -> Vec<LinkId> {
        let (system, component) = target(message);
        if own.iter().any(|own| (own.system, own.component) == (system, component)) {
            return Vec::new();
        }
        let senders = self.heard.get(&from);
        let may_pass = |to: &LinkId| *to != link && senders.is_none_or(|links| !links.contains(to));
        let is_target =
            |known: &Identity| known.system == system && (component == 0 || known.component == component);
        let is_reached = |to: &LinkId| {
            system == 0 || self.heard.iter().any(|(known, links)| is_target(known) && links.contains(to))
        };
        all.iter().copied().filter(|to| may_pass(to) && is_reached(to)).collect()
    }

    fn learn(&mut self, from: Identity, link: LinkId) {
        if let Some(links) = self.heard.get_mut(&from) {
            links.insert(link);
        } else if self.heard.len() < MAX_ROUTES {
            self.heard.insert(from, BTreeSet::from([link]));
        }
    }

    /// The very same frame, sequence number included, has come by a moment ago.
    fn is_copy(&mut self, now: Duration, frame: &Frame<'_>) -> bool {
        while self.seen.len() >= MAX_SEEN
            || self.seen.front().is_some_and(|(_, then)| now.saturating_sub(*then) > SEEN_FOR)
        {
            self.seen.pop_front();
        }
        let mut hasher = DefaultHasher::new();
        frame.bytes().hash(&mut hasher);
        let digest = hasher.finish();
        let is_copy = self.seen.iter().any(|(known, _)| *known == digest);
        if !is_copy {
            self.seen.push_back((digest, now));
        }
        is_copy
    }
}

/// Whom a message is for; 0 is everybody.
fn target(message: Option<&Message>) -> (u8, u8) {
    match message {
        Some(Message::MANUAL_CONTROL(data)) => (data.target, 0),
        Some(message) => {
            (message.target_system_id().unwrap_or(0), message.target_component_id().unwrap_or(0))
        }
        None => (0, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use helmlink_wire::Encoder;
    use helmlink_wire::dialect::{COMMAND_LONG_DATA, HEARTBEAT_DATA};

    const VEHICLE: Identity = Identity { system: 1, component: 1 };
    const STATION: Identity = Identity { system: 255, component: 190 };
    const OWN: [Identity; 2] =
        [Identity { system: 1, component: 191 }, Identity { system: 255, component: 191 }];
    const TO_VEHICLE: LinkId = LinkId(1);
    const TO_STATION: LinkId = LinkId(2);
    const THIRD: LinkId = LinkId(3);
    const ALL: [LinkId; 3] = [TO_VEHICLE, TO_STATION, THIRD];

    struct Network {
        router: Router,
        encoder: Encoder,
    }

    impl Network {
        fn bytes(&mut self, from: Identity, message: &Message) -> Vec<u8> {
            let mut bytes = Vec::new();
            self.encoder.encode(from, message, &mut bytes);
            bytes
        }

        fn pass(&mut self, now_s: u64, link: LinkId, bytes: &[u8]) -> Way {
            let frame = Frame::parse(bytes).unwrap();
            let message = frame.decode().ok();
            self.router.way(Duration::from_secs(now_s), link, &frame, message.as_ref(), &OWN, &ALL)
        }

        fn send(&mut self, link: LinkId, from: Identity, message: &Message) -> Way {
            let bytes = self.bytes(from, message);
            self.pass(0, link, &bytes)
        }
    }

    fn met() -> Network {
        let mut network = Network { router: Router::default(), encoder: Encoder::new() };
        let heartbeat = Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT);
        assert_eq!(network.send(TO_VEHICLE, VEHICLE, &heartbeat).onward, [TO_STATION, THIRD]);
        assert_eq!(network.send(TO_STATION, STATION, &heartbeat).onward, [TO_VEHICLE, THIRD]);
        network
    }

    fn command(target: Identity) -> Message {
        Message::COMMAND_LONG(COMMAND_LONG_DATA {
            target_system: target.system,
            target_component: target.component,
            ..COMMAND_LONG_DATA::DEFAULT
        })
    }

    #[test]
    fn what_is_for_somebody_goes_to_him_alone() {
        let mut network = met();
        assert_eq!(network.send(TO_STATION, STATION, &command(VEHICLE)).onward, [TO_VEHICLE]);
        assert_eq!(network.send(TO_VEHICLE, VEHICLE, &command(STATION)).onward, [TO_STATION]);
        let to_us = network.send(TO_STATION, STATION, &command(OWN[0]));
        assert_eq!(to_us, Way::default(), "kept, and looked at");
        let stranger = Identity { system: 77, component: 1 };
        assert_eq!(network.send(TO_STATION, STATION, &command(stranger)).onward, []);
    }

    #[test]
    fn nothing_goes_round_in_circles() {
        let mut network = met();
        let own = network.send(THIRD, OWN[1], &Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT));
        assert_eq!(own, Way { ignore: true, onward: Vec::new() }, "our own, come back");
        let bytes = network.bytes(STATION, &Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT));
        assert_eq!(network.pass(1, TO_STATION, &bytes).onward, [TO_VEHICLE, THIRD]);
        for link in ALL {
            assert!(network.pass(1, link, &bytes).ignore, "a copy");
        }
        assert!(!network.pass(9, TO_STATION, &bytes).ignore, "a new frame with an old number");
    }

    #[test]
    fn one_who_is_heard_on_two_links_is_not_told_what_he_said() {
        let mut network = met();
        let heartbeat = Message::HEARTBEAT(HEARTBEAT_DATA { mavtype: 6, ..HEARTBEAT_DATA::DEFAULT });
        network.send(TO_VEHICLE, STATION, &heartbeat);
        assert_eq!(network.send(TO_STATION, STATION, &heartbeat).onward, [THIRD]);
        network.router.forget(TO_VEHICLE);
        assert_eq!(network.send(TO_STATION, STATION, &heartbeat).onward, [TO_VEHICLE, THIRD]);
    }
}
