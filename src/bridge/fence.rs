//! Gets the fence from the flight controller.

use std::time::Duration;

use helmlink_mission::geodesy::Geodetic;
use helmlink_mission::plan::Mission;
use helmlink_mission::protocol::MissionType;
use helmlink_mission::protocol::client::{Download, Exchange};
use helmlink_wire::{Identity, Message};

use crate::pilot::failsafe::Fence;

/// How long to wait before a fence that could not be read is tried again.
const RETRY: Duration = Duration::from_secs(10);
/// How often that is done: a flight controller without fences does not answer.
const ATTEMPTS: u32 = 3;

/// Owns the fence's way from the flight controller to the failsafes.
#[derive(Debug, Default)]
pub(super) struct FenceKeeper {
    download: Option<Download>,
    fence: Option<Fence>,
    is_known: bool,
    attempts: u32,
    retry_at: Duration,
}

/// What became of a fence.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum FenceNews {
    /// There is one.
    Loaded,
    /// It could not be read: the boat is not watched by one.
    NotRead(String),
}

impl FenceKeeper {
    /// What is known no longer holds.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Distance outside the fence, metres; none without one.
    pub(super) fn breach_m(&self, place: Geodetic) -> Option<f64> {
        self.fence.as_ref().map(|fence| fence.breach_m(place))
    }

    /// Reads it again, as before every drive: another one may have been uploaded meanwhile.
    pub(super) fn refresh(&mut self) {
        if self.is_known {
            (self.is_known, self.attempts, self.retry_at) = (false, 0, Duration::ZERO);
        }
    }

    pub(super) fn on_message(&mut self, now: Duration, from: Identity, message: &Message) {
        if let Some(download) = &mut self.download {
            download.on_message(now, from, message);
        }
    }

    /// The next message to send. The fence is read when no mission is (`is_free`): one transfer at a time.
    pub(super) fn poll(
        &mut self,
        now: Duration,
        own: Identity,
        vehicle: Identity,
        is_free: bool,
    ) -> Option<Message> {
        let is_due = !self.is_known && self.attempts < ATTEMPTS && now >= self.retry_at;
        if self.download.is_none() && is_due && is_free {
            self.attempts += 1;
            self.download = Some(Download::new(Exchange::with_ardupilot(own, vehicle, MissionType::Fence)));
        }
        self.download.as_mut().and_then(|download| download.poll(now))
    }

    /// What has become of the fence since the last call.
    pub(super) fn poll_news(&mut self, now: Duration) -> Option<FenceNews> {
        let outcome = self.download.as_ref()?.outcome()?.cloned();
        self.download = None;
        match outcome {
            Ok(Mission { items, .. }) => {
                self.is_known = true;
                self.fence = Fence::from_items(&items);
                self.fence.is_some().then_some(FenceNews::Loaded)
            }
            Err(error) => {
                self.retry_at = now + RETRY;
                let is_last = self.attempts >= ATTEMPTS;
                is_last.then(|| FenceNews::NotRead(error.to_string()))
            }
        }
    }
}
