//! The simulated boat at a given multiple of real time.

use std::time::Duration;

use helmlink_sitl::Sitl;
use helmlink_wire::LinkId;

use super::edge::Party;
use crate::link::EndpointId;
use crate::simulation::closed_loop::LOOP;

/// A boat that has fallen behind its pace by more than this much simulated time goes on from where it is:
/// catching up in one go would look like a frozen boat that then jumps.
const LONGEST_LAG: Duration = Duration::from_millis(500);

/// How often the boat looks at the clock: at high pace every millisecond, the timer's resolution.
pub(super) fn tick(speedup: f64) -> Duration {
    (LOOP.div_f64(speedup.max(0.01)) / 2).clamp(Duration::from_millis(1), LOOP / 2)
}

/// The simulated boat with its pace.
pub(super) struct PacedSitl {
    /// The boat.
    pub(super) sitl: Sitl,
    speedup: f64,
    /// Driver's time and simulated time at the last change of pace.
    origin: (Duration, Duration),
    lost: Duration,
}

impl PacedSitl {
    /// A boat that runs `speedup` times as fast as real time.
    pub(super) fn new(sitl: Sitl, speedup: f64) -> Self {
        let origin = (Duration::ZERO, sitl.now());
        Self { sitl, speedup, origin, lost: Duration::ZERO }
    }

    /// Simulated time that the machine was too slow for.
    pub(super) fn lost(&self) -> Duration {
        self.lost
    }

    fn wanted(&self, now: Duration) -> Duration {
        self.origin.1 + now.saturating_sub(self.origin.0).mul_f64(self.speedup)
    }
}

impl Party for PacedSitl {
    fn link_up(&mut self, _now: Duration, link: LinkId, _endpoint: EndpointId) {
        self.sitl.link_up(link);
    }

    fn link_down(&mut self, _now: Duration, link: LinkId) {
        self.sitl.link_down(link);
    }

    fn on_bytes(&mut self, _now: Duration, link: LinkId, bytes: &[u8], is_datagram: bool) {
        if is_datagram {
            self.sitl.on_datagram(link, bytes);
        } else {
            self.sitl.on_bytes(link, bytes);
        }
    }

    fn on_tick(&mut self, now: Duration) {
        let wanted = self.wanted(now);
        let lag = wanted.saturating_sub(self.sitl.now());
        if lag > LONGEST_LAG.max(4 * LOOP.mul_f64(self.speedup)) {
            self.lost += lag;
            self.origin = (now, self.sitl.now());
            return;
        }
        while self.sitl.now() + LOOP <= wanted {
            let next = self.sitl.now() + LOOP;
            self.sitl.advance(next);
        }
    }

    fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.sitl.poll_transmit()
    }
}
