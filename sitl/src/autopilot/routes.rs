//! Which frames are for the autopilot, and which it passes on to its other links.
//!
//! The rules are those of ArduPilot's router (<https://ardupilot.org/dev/docs/mavlink-routing-in-ardupilot.html>):
//! broadcasts go everywhere, targeted messages go where the target has been heard, a message for an unknown
//! component of this system is taken as one's own, and nothing goes back where it came from.

use std::collections::{BTreeMap, BTreeSet};

use helmlink_wire::LinkId;
use helmlink_wire::dialect::{Message, MessageSet};
use helmlink_wire::frame::Identity;

/// Components remembered. A network of boats has a few dozen; the cap holds off invented ones.
const MAX_ROUTES: usize = 256;

/// Where each component has been heard.
#[derive(Debug, Default)]
pub(super) struct Routes {
    heard: BTreeMap<Identity, BTreeSet<LinkId>>,
}

/// Whom a message is for; 0 is everyone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Target {
    pub(super) system: u8,
    pub(super) component: u8,
}

impl Target {
    pub(super) const EVERYONE: Self = Self { system: 0, component: 0 };

    /// The target fields of a message; messages without them are for everyone.
    pub(super) fn of(message: &Message) -> Self {
        if let Message::MANUAL_CONTROL(data) = message {
            return Self { system: data.target, component: 0 };
        }
        let system = message.target_system_id().unwrap_or(0);
        Self { system, component: message.target_component_id().unwrap_or(0) }
    }
}

/// What becomes of a frame.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Verdict {
    /// Whether the autopilot acts on it.
    pub(super) here: bool,
    /// The links it is passed on to.
    pub(super) onward: Vec<LinkId>,
}

impl Routes {
    /// Remembers that `from` is reached over `link`.
    pub(super) fn learn(&mut self, from: Identity, link: LinkId) {
        if let Some(links) = self.heard.get_mut(&from) {
            links.insert(link);
        } else if self.heard.len() < MAX_ROUTES {
            self.heard.insert(from, BTreeSet::from([link]));
        }
    }

    /// Forgets a link and those who were heard on it alone.
    pub(super) fn forget(&mut self, link: LinkId) {
        self.heard.retain(|_, links| {
            links.remove(&link);
            !links.is_empty()
        });
    }

    /// What becomes of a frame of `from` for `target` that arrived on `link`, one of `all`.
    pub(super) fn decide(
        &self,
        own: Identity,
        from: Identity,
        target: Target,
        link: LinkId,
        all: &[LinkId],
    ) -> Verdict {
        let known = self.heard.get(&from);
        let may_pass = |to: &LinkId| *to != link && known.is_none_or(|links| !links.contains(to));
        let reached = |matches: &dyn Fn(&Identity) -> bool| {
            let mut links: BTreeSet<LinkId> = BTreeSet::new();
            for (_, heard_on) in self.heard.iter().filter(|(identity, _)| matches(identity)) {
                links.extend(heard_on.iter().copied().filter(&may_pass));
            }
            links.into_iter().collect::<Vec<_>>()
        };
        if target.system == 0 {
            return Verdict { here: true, onward: all.iter().copied().filter(may_pass).collect() };
        }
        if target.system != own.system {
            return Verdict { here: false, onward: reached(&|known| known.system == target.system) };
        }
        if target.component == own.component {
            return Verdict { here: true, onward: Vec::new() };
        }
        if target.component == 0 {
            return Verdict { here: true, onward: reached(&|known| known.system == own.system) };
        }
        let onward = reached(&|known| known.system == own.system && known.component == target.component);
        Verdict { here: onward.is_empty(), onward }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: Identity = Identity { system: 1, component: 1 };
    const GCS: Identity = Identity { system: 255, component: 190 };
    const COMPANION: Identity = Identity { system: 1, component: 191 };
    const A: LinkId = LinkId(1);
    const B: LinkId = LinkId(2);
    const C: LinkId = LinkId(3);

    fn routes() -> Routes {
        let mut routes = Routes::default();
        routes.learn(GCS, A);
        routes.learn(COMPANION, B);
        routes
    }

    fn decide(from: Identity, system: u8, component: u8, link: LinkId) -> (bool, Vec<LinkId>) {
        let verdict = routes().decide(OWN, from, Target { system, component }, link, &[A, B, C]);
        (verdict.here, verdict.onward)
    }

    #[test]
    fn broadcasts_go_everywhere_but_back() {
        assert_eq!(decide(GCS, 0, 0, A), (true, vec![B, C]));
        assert_eq!(decide(COMPANION, 0, 0, B), (true, vec![A, C]));
    }

    #[test]
    fn targeted_messages_go_where_the_target_was_heard() {
        assert_eq!(decide(COMPANION, 255, 190, B), (false, vec![A]));
        assert_eq!(decide(COMPANION, 255, 7, B), (false, vec![A]), "another component of a known system");
        assert_eq!(decide(GCS, 1, 191, A), (false, vec![B]));
        assert_eq!(decide(GCS, 1, 1, A), (true, vec![]));
        assert_eq!(decide(GCS, 1, 0, A), (true, vec![B]));
        assert_eq!(decide(GCS, 77, 1, A), (false, vec![]));
    }

    #[test]
    fn an_unknown_component_of_the_own_system_is_taken_as_the_autopilot() {
        assert_eq!(decide(GCS, 1, 55, A), (true, vec![]));
    }

    #[test]
    fn a_sender_heard_on_two_links_gets_nothing_back_on_either() {
        let mut routes = routes();
        routes.learn(GCS, C);
        let verdict = routes.decide(OWN, GCS, Target::EVERYONE, A, &[A, B, C]);
        assert_eq!(verdict.onward, [B]);
    }

    #[test]
    fn forgotten_links_lead_nowhere_and_invented_senders_are_capped() {
        let mut routes = routes();
        routes.forget(B);
        let verdict = routes.decide(OWN, GCS, Target { system: 1, component: 191 }, A, &[A]);
        assert!(verdict.here && verdict.onward.is_empty());
        for number in 0..u16::MAX {
            let [system, component] = number.to_le_bytes();
            routes.learn(Identity { system, component }, A);
        }
        assert!(routes.heard.len() <= MAX_ROUTES);
    }
}
