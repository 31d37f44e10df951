//! Who lets simulated time pass: nobody has to, a client may pause it, and clients in lockstep must agree.

use std::collections::BTreeMap;
use std::time::Duration;

use helmlink_wire::LinkId;

use crate::autopilot::LOOP;

/// Whether time may pass.
#[derive(Debug, Clone, Default)]
pub(crate) struct Clock {
    /// Paused, with so many loops still to run.
    paused: Option<u32>,
    /// Clients in lockstep.
    members: BTreeMap<LinkId, Member>,
}

#[derive(Debug, Clone, Copy)]
struct Member {
    /// Time passes by so much between two answers.
    beat: Duration,
    /// The client has answered all up to here.
    answered: Duration,
    /// The last beat that the client was told of.
    told: Duration,
}

/// What a client asks of the clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ClockOrder {
    /// Let time pass.
    Resume,
    /// Stop time.
    Pause,
    /// With time stopped, run so many loops.
    Step(u32),
    /// Time passes by so much, then waits for this client's answer.
    Join(Duration),
    /// The client is no longer waited for.
    Leave,
}

impl Clock {
    /// Carries out an order of a client.
    pub(crate) fn obey(&mut self, link: LinkId, order: ClockOrder, now: Duration) {
        match order {
            ClockOrder::Resume => self.paused = None,
            ClockOrder::Pause => self.paused = Some(0),
            ClockOrder::Step(loops) => self.paused = Some(self.paused.unwrap_or(0).saturating_add(loops)),
            ClockOrder::Join(beat) => {
                let beat = beat.max(LOOP);
                self.members.insert(link, Member { beat, answered: now, told: now });
            }
            ClockOrder::Leave => self.forget(link),
        }
    }

    /// A client has seen what happened up to `seen`.
    pub(crate) fn answer(&mut self, link: LinkId, seen: Duration) {
        if let Some(member) = self.members.get_mut(&link) {
            member.answered = member.answered.max(seen);
        }
    }

    pub(crate) fn forget(&mut self, link: LinkId) {
        self.members.remove(&link);
    }

    /// Whether the loop that starts at `now` may run.
    pub(crate) fn may_run(&self) -> bool {
        self.paused != Some(0) && self.members.values().all(|member| member.answered >= member.told)
    }

    pub(crate) fn is_paused(&self) -> bool {
        self.paused.is_some()
    }

    /// The clients that are waited for.
    pub(crate) fn waits_for(&self) -> Vec<LinkId> {
        let late = |(_, member): &(&LinkId, &Member)| member.answered < member.told;
        self.members.iter().filter(late).map(|(link, _)| *link).collect()
    }

    /// A loop has ended at `now`; the clients that must be told so.
    pub(crate) fn count(&mut self, now: Duration) -> Vec<LinkId> {
        if let Some(loops) = &mut self.paused {
            *loops = loops.saturating_sub(1);
        }
        let mut tell = Vec::new();
        for (link, member) in &mut self.members {
            if now >= member.told + member.beat {
                member.told = now;
                tell.push(*link);
            }
        }
        tell
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: LinkId = LinkId(1);
    const B: LinkId = LinkId(2);

    fn at(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn a_pause_lasts_until_it_is_ended_and_steps_are_counted() {
        let mut clock = Clock::default();
        assert!(clock.may_run());
        clock.obey(A, ClockOrder::Pause, at(0));
        assert!(!clock.may_run() && clock.is_paused());
        clock.obey(A, ClockOrder::Step(2), at(0));
        for loops in 1..=2 {
            assert!(clock.may_run());
            clock.count(at(20 * loops));
        }
        assert!(!clock.may_run());
        clock.obey(B, ClockOrder::Resume, at(40));
        assert!(clock.may_run() && !clock.is_paused());
    }

    #[test]
    fn in_lockstep_everybody_is_waited_for() {
        let mut clock = Clock::default();
        clock.obey(A, ClockOrder::Join(at(20)), at(0));
        clock.obey(B, ClockOrder::Join(at(40)), at(0));
        assert_eq!(clock.count(at(20)), [A]);
        assert_eq!(clock.waits_for(), [A]);
        clock.answer(A, at(19));
        assert!(!clock.may_run());
        clock.answer(A, at(20));
        assert!(clock.may_run());
        assert_eq!(clock.count(at(40)), [A, B]);
        clock.answer(A, at(40));
        assert_eq!(clock.waits_for(), [B]);
        clock.forget(B);
        assert!(clock.may_run(), "nobody waits for one who has gone");
    }
}
