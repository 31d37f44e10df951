//! A plan on its way in: what has come is kept aside until the last item is there.

use std::time::Duration;

use super::Client;
use crate::plan::Item;

/// One upload in progress.
#[derive(Debug, Clone)]
pub(super) struct Receiving {
    pub(super) client: Client,
    /// The plan as it will be: empty at first for a whole plan, the stored one for a part.
    staged: Vec<Item>,
    /// The item wanted next, and the one after the last to come.
    next: u16,
    end: u16,
    /// When an item last arrived (or the upload began), and when one was last asked for.
    progress_at: Duration,
    asked_at: Duration,
}

impl Receiving {
    /// A whole plan of `count` items.
    pub(super) fn whole(client: Client, now: Duration, count: u16) -> Self {
        Self::part(client, now, Vec::new(), 0, count)
    }

    /// Items `start..end` over those of `stored`; the vehicle asks for the first at `now`.
    pub(super) fn part(client: Client, now: Duration, stored: Vec<Item>, start: u16, end: u16) -> Self {
        Self { client, staged: stored, next: start, end, progress_at: now, asked_at: now }
    }

    pub(super) fn next(&self) -> u16 {
        self.next
    }

    pub(super) fn is_complete(&self) -> bool {
        self.next >= self.end
    }

    pub(super) fn take(&mut self, now: Duration, item: Item) {
        match self.staged.get_mut(usize::from(self.next)) {
            Some(slot) => *slot = item,
            None => self.staged.push(item),
        }
        self.next += 1;
        self.progress_at = now;
        self.asked_at = now;
    }

    pub(super) fn ask_again(&mut self, now: Duration) {
        self.asked_at = now;
    }

    pub(super) fn asked_before(&self, now: Duration) -> Duration {
        now.saturating_sub(self.asked_at)
    }

    /// When to ask again, and when to give up, under these waits.
    pub(super) fn deadlines(&self, ask_again: Duration, give_up: Duration) -> (Duration, Duration) {
        (self.asked_at + ask_again, self.progress_at + give_up)
    }

    pub(super) fn into_staged(self) -> Vec<Item> {
        self.staged
    }

    pub(super) fn staged(&self) -> &[Item] {
        &self.staged
    }
}

/// How an upload ended, remembered so that the client can be told again when the answer was lost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Verdict {
    pub(super) client: Client,
    /// The item that brought it.
    pub(super) seq: u16,
    /// MAV_MISSION_RESULT.
    pub(super) result: u8,
    pub(super) told_at: Duration,
    pub(super) forget_at: Duration,
}
