//! The simulated boat at a given multiple of real time, or as fast as the machine goes.

use std::time::Duration;

use helmlink_sitl::Sitl;
use helmlink_wire::LinkId;
use sha2::{Digest, Sha256};

use super::edge::Party;
use super::sitl_log::SitlLog;
use crate::link::EndpointId;
use crate::simulation::closed_loop::LOOP;

/// A boat that has fallen behind its pace by more than this much simulated time goes on from where it is:
/// catching up in one go would look like a frozen boat that then jumps.
const LONGEST_LAG: Duration = Duration::from_millis(500);
/// Loops that a boat without a pace runs between two looks at its links.
const LOOPS_AT_ONCE: u32 = 25;
/// A client in lockstep that gives no answer for so long is no longer waited for.
const LOCKSTEP_PATIENCE: Duration = Duration::from_secs(10);
/// The link whose output is digested and logged; nobody else has it.
const RECORDER: LinkId = LinkId(u32::MAX);

/// The speedup that stands for "as fast as the machine goes".
pub(super) const MAX: f64 = f64::INFINITY;

/// How often the boat looks at the clock: at high pace every millisecond, the timer's resolution.
pub(super) fn tick(speedup: f64) -> Duration {
    (LOOP.div_f64(speedup.clamp(0.01, 1000.0)) / 2).clamp(Duration::from_millis(1), LOOP / 2)
}

/// The simulated boat with its pace.
pub(super) struct PacedSitl {
    /// The boat.
    pub(super) sitl: Sitl,
    speedup: f64,
    /// The pace as the boat's parameter shows it; a client changes it there.
    shown: f64,
    /// Driver's time and simulated time at the last change of pace.
    origin: (Duration, Duration),
    lost: Duration,
    end: Option<Duration>,
    held_since: Option<Duration>,
    digest: Option<(Sha256, u64)>,
    log: Option<SitlLog>,
}

impl PacedSitl {
    /// A boat that runs `speedup` times as fast as real time; [`MAX`] is as fast as it goes.
    pub(super) fn new(mut sitl: Sitl, speedup: f64) -> Self {
        let origin = (Duration::ZERO, sitl.now());
        sitl.set_speedup(if speedup == MAX { 0.0 } else { speedup });
        let shown = sitl.speedup();
        Self {
            sitl,
            speedup,
            shown,
            origin,
            lost: Duration::ZERO,
            end: None,
            held_since: None,
            digest: None,
            log: None,
        }
    }

    /// Stops time for good at `end`.
    pub(super) fn end_at(&mut self, end: Duration) {
        self.end = Some(end);
    }

    /// Takes the digest of all that a client without requests gets to hear.
    pub(super) fn keep_digest(&mut self) {
        if self.sitl.link_up(RECORDER) {
            self.digest = Some((Sha256::new(), 0));
        }
    }

    /// Keeps everything that the boat hears and says for [`Self::take_log`]; the boat's time zero is `start_us`
    /// microseconds after the Unix epoch.
    pub(super) fn keep_log(&mut self, start_us: u64) {
        // Even a boat without clients says something then.
        self.sitl.link_up(RECORDER);
        self.log = Some(SitlLog::new(start_us));
    }

    /// Telemetry log records since the last call.
    pub(super) fn take_log(&mut self) -> Vec<u8> {
        self.log.as_mut().map(SitlLog::take).unwrap_or_default()
    }

    /// The digest so far, SHA-256 in hexadecimal digits, and the number of bytes.
    pub(super) fn digest(&self) -> Option<(String, u64)> {
        let (digest, bytes) = self.digest.as_ref()?;
        let digits = digest.clone().finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Some((digits, *bytes))
    }

    /// Whether there is nothing more to simulate.
    pub(super) fn is_over(&self) -> bool {
        self.sitl.is_scenario_over() || self.end.is_some_and(|end| self.sitl.now() + LOOP > end)
    }

    /// Simulated time that the machine was too slow for.
    pub(super) fn lost(&self) -> Duration {
        self.lost
    }

    /// The pace in force.
    pub(super) fn speedup(&self) -> f64 {
        self.speedup
    }

    fn wanted(&self, now: Duration) -> Duration {
        self.origin.1 + now.saturating_sub(self.origin.0).mul_f64(self.speedup)
    }

    /// Takes over the pace that a client has asked for by parameter.
    fn follow_parameter(&mut self, now: Duration) {
        let asked = self.sitl.speedup();
        if asked != self.shown {
            self.shown = asked;
            self.speedup = if asked == 0.0 { MAX } else { asked };
            self.origin = (now, self.sitl.now());
        }
    }

    /// Runs loops up to `until`; ends early when time is held or all is over.
    fn run(&mut self, until: Duration) {
        while self.sitl.now() + LOOP <= until && !self.sitl.is_held() && !self.is_over() {
            let next = self.sitl.now() + LOOP;
            self.sitl.advance(next);
        }
    }

    /// While time is held: the pace starts anew from here, and nobody is waited for for ever.
    fn wait(&mut self, now: Duration) {
        self.sitl.serve();
        self.origin = (now, self.sitl.now());
        let since = *self.held_since.get_or_insert(now);
        if now.saturating_sub(since) > LOCKSTEP_PATIENCE {
            for link in self.sitl.waits_for() {
                tracing::warn!(
                    "link {} has not answered for {LOCKSTEP_PATIENCE:?}: no longer in lockstep",
                    link.0
                );
                self.sitl.leave_lockstep(link);
            }
        }
    }
}

impl Party for PacedSitl {
    fn link_up(&mut self, _now: Duration, link: LinkId, _endpoint: EndpointId) {
        self.sitl.link_up(link);
    }

    fn link_down(&mut self, _now: Duration, link: LinkId) {
        self.sitl.link_down(link);
        if let Some(log) = &mut self.log {
            log.forget(link);
        }
    }

    fn on_bytes(&mut self, _now: Duration, link: LinkId, bytes: &[u8], is_datagram: bool) {
        if let Some(log) = &mut self.log {
            log.received(self.sitl.now(), link, bytes, is_datagram);
        }
        if is_datagram {
            self.sitl.on_datagram(link, bytes);
        } else {
            self.sitl.on_bytes(link, bytes);
        }
        if self.sitl.is_held() {
            self.sitl.serve();
        }
    }

    fn on_tick(&mut self, now: Duration) {
        self.follow_parameter(now);
        if self.sitl.is_held() {
            self.wait(now);
            return;
        }
        self.held_since = None;
        if self.speedup == MAX {
            self.run(self.sitl.now() + LOOP * LOOPS_AT_ONCE);
            return;
        }
        let wanted = self.wanted(now);
        let lag = wanted.saturating_sub(self.sitl.now());
        if lag > LONGEST_LAG.max(4 * LOOP.mul_f64(self.speedup)) {
            self.lost += lag;
            self.origin = (now, self.sitl.now());
            return;
        }
        self.run(wanted);
    }

    fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        loop {
            let (link, bytes) = self.sitl.poll_transmit()?;
            if let Some(log) = &mut self.log {
                log.said(self.sitl.now(), &bytes);
            }
            if link != RECORDER {
                return Some((link, bytes));
            }
            if let Some((digest, count)) = &mut self.digest {
                digest.update(&bytes);
                *count += bytes.len() as u64;
            }
        }
    }

    fn is_eager(&self) -> bool {
        self.speedup == MAX && !self.sitl.is_held() && !self.is_over()
    }
}

#[cfg(test)]
mod tests {
    use helmlink_sitl::SitlSettings;
    use helmlink_sitl::physics::{Hull, SensorSettings};

    use super::*;

    fn boat(speedup: f64) -> PacedSitl {
        let mut settings = SitlSettings::new(Hull::builtin("otter").unwrap());
        settings.sensors = SensorSettings::typical();
        PacedSitl::new(Sitl::new(settings).unwrap(), speedup)
    }

    /// The digest of ten seconds, ticked every `tick_ms` of real time.
    fn digest(speedup: f64, tick_ms: u64) -> (String, u64) {
        let mut boat = boat(speedup);
        boat.sitl.start_when_ready();
        boat.keep_digest();
        boat.end_at(Duration::from_secs(10));
        let mut now = Duration::ZERO;
        while !boat.is_over() {
            now += Duration::from_millis(tick_ms);
            boat.on_tick(now);
            while boat.poll_transmit().is_some() {}
        }
        assert_eq!(boat.sitl.now(), Duration::from_secs(10));
        boat.digest().unwrap()
    }

    #[test]
    fn the_output_is_the_same_at_any_pace() {
        let reference = digest(MAX, 1);
        assert!(reference.1 > 1000);
        assert_eq!(digest(MAX, 1), reference);
        // Only what the parameter of the pace itself says may differ, and nobody has asked for it.
        assert_eq!(digest(1.0, 10), reference);
        assert_eq!(digest(50.0, 1), reference);
    }

    #[test]
    fn a_paused_boat_stands_still_and_goes_on_at_its_pace() {
        let mut boat = boat(1.0);
        let at = Duration::from_millis;
        (1..=10).for_each(|tick| boat.on_tick(at(20 * tick)));
        boat.sitl.set_paused(true);
        (11..=1000).for_each(|tick| boat.on_tick(at(20 * tick)));
        assert_eq!(boat.sitl.now(), at(200));
        boat.sitl.set_paused(false);
        boat.on_tick(at(20_020));
        assert_eq!((boat.sitl.now(), boat.lost()), (at(220), Duration::ZERO));
    }

    #[test]
    fn a_silent_client_in_lockstep_is_given_up() {
        let mut boat = boat(MAX);
        let link = LinkId(3);
        boat.sitl.link_up(link);
        boat.sitl.join_lockstep(link, Duration::from_millis(100));
        boat.on_tick(Duration::from_secs(1));
        assert_eq!(boat.sitl.now(), Duration::from_millis(100));
        boat.on_tick(Duration::from_secs(2));
        boat.on_tick(Duration::from_secs(11));
        assert_eq!(boat.sitl.now(), Duration::from_millis(100));
        boat.on_tick(Duration::from_secs(13));
        boat.on_tick(Duration::from_secs(14));
        assert!(boat.sitl.now() > Duration::from_millis(100));
    }
}
