//! A test bench: a boat with two links, its messages decoded.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::time::Duration;

use helmlink_mission::geodesy::NorthEast;
use helmlink_wire::dialect::{Message, RC_CHANNELS_OVERRIDE_DATA};
use helmlink_wire::{Encoder, Framer, Identity, LinkId};

use super::{AutopilotSettings, LOOP};
use crate::physics::{Hull, Sea};
use crate::{Sitl, SitlSettings};

pub(crate) const LINK: LinkId = LinkId(1);
pub(crate) const OTHER_LINK: LinkId = LinkId(2);
pub(crate) const GCS: Identity = Identity { system: 255, component: 190 };
pub(crate) const COMPANION: Identity = Identity { system: 1, component: 191 };
/// One hull of every kind.
pub(crate) const HULLS: [&str; 4] = ["otter", "monohull38", "skiff", "motorboat"];

/// Sticks as a ground station sends them.
pub(crate) fn sticks(steering_us: u16, throttle_us: u16) -> Message {
    Message::RC_CHANNELS_OVERRIDE(RC_CHANNELS_OVERRIDE_DATA {
        chan1_raw: steering_us,
        chan3_raw: throttle_us,
        target_system: 1,
        target_component: 1,
        ..RC_CHANNELS_OVERRIDE_DATA::DEFAULT
    })
}

/// A boat and what its clients see.
pub(crate) struct Bench {
    sitl: Sitl,
    encoder: Encoder,
    framers: BTreeMap<LinkId, Framer>,
}

impl Deref for Bench {
    type Target = Sitl;

    fn deref(&self) -> &Sitl {
        &self.sitl
    }
}

impl DerefMut for Bench {
    fn deref_mut(&mut self) -> &mut Sitl {
        &mut self.sitl
    }
}

impl Bench {
    /// A boat with twin thrusters that has just been switched on.
    pub(crate) fn new(autopilot: AutopilotSettings) -> Self {
        Self::start("otter", Sea::default(), autopilot)
    }

    fn start(hull: &str, sea: Sea, autopilot: AutopilotSettings) -> Self {
        let settings = SitlSettings { sea, autopilot, ..SitlSettings::new(Hull::builtin(hull).unwrap()) };
        let mut sitl = Sitl::new(settings).unwrap();
        let mut framers = BTreeMap::new();
        for link in [LINK, OTHER_LINK] {
            sitl.link_up(link);
            framers.insert(link, Framer::new());
        }
        Self { sitl, encoder: Encoder::new(), framers }
    }

    /// A boat with twin thrusters, ready to be armed.
    pub(crate) fn ready() -> Self {
        Self::with_hull("otter")
    }

    /// A boat with this hull, ready to be armed.
    pub(crate) fn with_hull(hull: &str) -> Self {
        Self::at_sea(hull, Sea::default())
    }

    /// The same, on a sea that is not calm.
    pub(crate) fn at_sea(hull: &str, sea: Sea) -> Self {
        let mut bench = Self::start(hull, sea, AutopilotSettings::default());
        bench.run_s(3.0);
        bench
    }

    /// Arms, which must work.
    pub(crate) fn arm(&mut self) {
        assert!(self.autopilot.arm(false), "{:?}", self.autopilot.arming_obstacles());
    }

    /// Has a client send a message; it is read in the next loop.
    pub(crate) fn send(&mut self, link: LinkId, from: Identity, message: &Message) {
        let mut bytes = Vec::new();
        self.encoder.encode(from, message, &mut bytes);
        self.sitl.on_bytes(link, &bytes);
    }

    /// Runs so many loops; everything sent by link.
    pub(crate) fn run_loops(&mut self, loops: u32) -> BTreeMap<LinkId, Vec<Message>> {
        let mut sent: BTreeMap<LinkId, Vec<Message>> =
            self.framers.keys().map(|link| (*link, Vec::new())).collect();
        for _ in 0..loops {
            let end = self.sitl.now() + LOOP;
            self.sitl.advance(end);
            while let Some((link, bytes)) = self.sitl.poll_transmit() {
                let framer = self.framers.get_mut(&link).unwrap();
                framer.push(&bytes);
                while let Some(frame) = framer.next_frame() {
                    sent.get_mut(&link).unwrap().push(frame.decode().unwrap());
                }
            }
        }
        sent
    }

    /// Runs for so many seconds.
    pub(crate) fn run_s(&mut self, seconds: f64) -> BTreeMap<LinkId, Vec<Message>> {
        self.run_loops((seconds / LOOP.as_secs_f64()).round() as u32)
    }

    /// Runs until this time.
    pub(crate) fn run_until(&mut self, time: Duration) {
        let left = time.saturating_sub(self.sitl.now());
        self.run_s(left.as_secs_f64());
    }

    /// Sends the boat to a place; it must be in GUIDED.
    pub(crate) fn go_to(&mut self, place: NorthEast) {
        self.autopilot.go_to(place);
    }

    /// Where the boat really is.
    pub(crate) fn position(&self) -> NorthEast {
        let hull = self.vessel.truth().hull;
        NorthEast::new(hull.north_m, hull.east_m)
    }

    /// The STATUSTEXTs on the first link.
    pub(crate) fn texts(sent: &BTreeMap<LinkId, Vec<Message>>) -> Vec<String> {
        let text = |message: &Message| match message {
            Message::STATUSTEXT(data) => data.text.to_str().map(str::to_owned).ok(),
            _ => None,
        };
        sent[&LINK].iter().filter_map(text).collect()
    }
}
