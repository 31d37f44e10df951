//! Gets the mission, and notices when another one is on board.

use std::time::Duration;

use helmlink_mission::plan::{Item, Mission};
use helmlink_mission::protocol::MissionType;
use helmlink_mission::protocol::client::{Download, Exchange};
use helmlink_mission::route::Route;
use helmlink_wire::{Identity, Message};

use super::resume::checksum;
use super::settings::MissionSource;
use crate::control::Boat;
use crate::pilot::MissionRun;

/// How long to wait before an empty or unusable mission is asked for again.
const RETRY: Duration = Duration::from_secs(5);

/// How long to wait before a transfer that failed is tried again: another one may just be going on.
const TRANSFER_RETRY: Duration = Duration::from_secs(1);

/// What ArduPilot says when a mission has been uploaded to it.
const UPLOADED_TEXT: &str = "Flight plan received";

/// What became of a mission.
#[derive(Debug)]
pub(super) enum News {
    /// A mission that can be driven.
    Loaded(Route),
    /// There is none, or none that can be driven: why.
    Unusable(String),
    /// It could not be read this time, and will be tried again: why.
    NotRead(String),
}

/// Owns the mission's way from its source to the pilot.
#[derive(Debug)]
pub(super) struct MissionKeeper {
    from_vehicle: bool,
    given: Option<Mission>,
    download: Option<Download>,
    loaded: Option<Mission>,
    /// Of the loaded one.
    checksum: String,
    retry_at: Duration,
    /// Another mission has been uploaded, perhaps with as many items.
    uploaded: bool,
    boat: Boat,
}

impl MissionKeeper {
    pub(super) fn new(source: &MissionSource, boat: &Boat) -> Self {
        let (from_vehicle, given) = match source {
            MissionSource::Vehicle => (true, None),
            MissionSource::Given(mission) => (false, Some(mission.clone())),
        };
        let boat = boat.clone();
        let retry_at = Duration::ZERO;
        let checksum = String::new();
        Self { from_vehicle, given, download: None, loaded: None, checksum, retry_at, uploaded: false, boat }
    }

    /// A mission is there, and no newer one is being read.
    pub(super) fn is_ready(&self) -> bool {
        self.loaded.is_some() && self.download.is_none()
    }

    /// The mission that is being driven.
    pub(super) fn mission(&self) -> Option<&Mission> {
        self.loaded.as_ref()
    }

    /// SHA-256 of the items of the mission that is being driven: see [`checksum`].
    pub(super) fn checksum(&self) -> Option<&str> {
        self.loaded.as_ref().map(|_| self.checksum.as_str())
    }

    /// Reads the mission again: before engaging, since another may have been uploaded meanwhile.
    pub(super) fn refresh(&mut self, own: Identity, vehicle: Identity) {
        if self.from_vehicle && self.download.is_none() {
            let exchange = Exchange::with_ardupilot(own, vehicle, MissionType::Mission);
            self.download = Some(Download::new(exchange));
        }
    }

    /// The vehicle says how many items its mission has (home not counted): a different number is a new mission.
    pub(super) fn on_total(&mut self, now: Duration, total: u16, own: Identity, vehicle: Identity) {
        let known = self.loaded.as_ref().map_or(0, |mission| mission.items.len());
        // 65535: the vehicle does not say.
        if total != u16::MAX && usize::from(total) != known && now >= self.retry_at {
            self.refresh(own, vehicle);
        }
    }

    /// The firmware says when a mission has been uploaded (ArduPilot: "Flight plan received").
    pub(super) fn on_text(&mut self, text: &str) {
        self.uploaded |= text.starts_with(UPLOADED_TEXT);
    }

    pub(super) fn on_message(&mut self, now: Duration, from: Identity, message: &Message) {
        if let Some(download) = &mut self.download {
            download.on_message(now, from, message);
        }
    }

    /// The vehicle has gone or restarted.
    pub(super) fn on_vehicle_lost(&mut self) {
        self.download = None;
        self.retry_at = Duration::ZERO;
    }

    /// The next message to send, if any.
    pub(super) fn poll(&mut self, now: Duration, own: Identity, vehicle: Identity) -> Option<Message> {
        let wants = self.loaded.is_none() || self.uploaded;
        if wants && self.download.is_none() && now >= self.retry_at {
            self.uploaded = false;
            self.refresh(own, vehicle);
        }
        self.download.as_mut().and_then(|download| download.poll(now))
    }

    /// What has become of the mission since the last call.
    pub(super) fn poll_news(&mut self, now: Duration) -> Option<News> {
        if let Some(given) = self.given.take() {
            return Some(self.take_over(now, given));
        }
        let outcome = self.download.as_ref()?.outcome()?.cloned();
        self.download = None;
        match outcome {
            Ok(mission) if self.loaded.as_ref().is_some_and(|loaded| is_same(loaded, &mission)) => None,
            Ok(mission) => Some(self.take_over(now, mission)),
            Err(error) => {
                self.retry_at = now + TRANSFER_RETRY;
                self.uploaded = true;
                Some(News::NotRead(format!("the mission could not be read yet: {error}")))
            }
        }
    }

    fn take_over(&mut self, now: Duration, mission: Mission) -> News {
        let route = Route::from_mission(&mission)
            .and_then(|route| MissionRun::check(&route, &self.boat).map(|()| route));
        match route {
            Ok(route) => {
                self.checksum = checksum(&mission);
                self.loaded = Some(mission);
                News::Loaded(route)
            }
            Err(error) => {
                self.loaded = None;
                self.unusable(now, error.to_string())
            }
        }
    }

    fn unusable(&mut self, now: Duration, complaint: String) -> News {
        self.retry_at = now + RETRY;
        News::Unusable(complaint)
    }
}

/// The same items, bit for bit: parameters that are not numbers are as good as any.
fn is_same(one: &Mission, other: &Mission) -> bool {
    let fixed = |item: &Item| {
        (item.command, item.frame, item.x, item.y, item.z.to_bits(), item.params.map(f32::to_bits))
    };
    one.items.len() == other.items.len()
        && one.items.iter().zip(&other.items).all(|(one, other)| fixed(one) == fixed(other))
}
