//! The whole boat: autopilot and physics in step.
//!
//! | module | what it holds |
//! |---|---|
//! | `settings` | what is simulated, and why it cannot be |
//! | `time` | pausing, stepping, lockstep, pace |
//! | `trouble` | faults and the sea, at once or at a time to come |
//! | `playing` | scenarios |

mod playing;
mod settings;
#[cfg(test)]
mod tests;
mod time;
mod trouble;

use std::collections::VecDeque;
use std::time::Duration;

use helmlink_mission::plan::Item;
use helmlink_wire::LinkId;

pub use self::settings::{PlayError, SitlError, SitlSettings};
use crate::autopilot::{Autopilot, LOOP};
use crate::faults::{Lines, LinkWeather, Schedule};
use crate::physics::{Estimate, Hull, Pose, STEP_S, Truth, Vessel};
use crate::scenario::{Observation, Play};

/// Physics steps per loop of the autopilot.
const STEPS_PER_LOOP: u32 = 2;

/// Packets from bad lines that wait to be taken; what exceeds it is lost.
const MAX_OUTBOX: usize = 20_000;

/// A simulated boat with an ArduRover-like autopilot.
///
/// The owner opens links, hands in the bytes that arrive on them, advances the simulated time and takes out
/// what is to be sent:
///
/// ```
/// use std::time::Duration;
/// use helmlink_sitl::{Sitl, SitlSettings, physics::Hull};
/// use helmlink_wire::LinkId;
///
/// let mut boat = Sitl::new(SitlSettings::new(Hull::builtin("otter")?))?;
/// boat.link_up(LinkId(1));
/// boat.advance(Duration::from_secs(1));
/// let (link, bytes) = boat.poll_transmit().ok_or("a heartbeat is due every second")?;
/// assert_eq!((link, bytes[0]), (LinkId(1), 0xFD));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Sitl {
    pub(crate) autopilot: Autopilot,
    pub(crate) vessel: Vessel,
    now: Duration,
    /// Whether the boat waits at its moorings to be armed.
    moored: bool,
    schedule: Schedule,
    lines: Lines,
    weather: LinkWeather,
    /// What has come out of bad lines.
    outbox: VecDeque<(LinkId, Vec<u8>)>,
    /// The parameters' revision that the faults were last read from, and what they said of tide and wind.
    faults_of: Option<u64>,
    sea_parameters: [f64; 4],
    play: Option<Box<Play>>,
    /// Whether the boat starts by itself as soon as it can.
    starts_itself: bool,
}

impl Sitl {
    /// A boat at its start, the autopilot just switched on. Takes some milliseconds: the autopilot is tuned
    /// to the hull by a short trial.
    ///
    /// # Errors
    /// [`SitlError`] if the settings make no sense; the physics' own settings were checked when they were
    /// made.
    pub fn new(settings: SitlSettings) -> Result<Self, SitlError> {
        settings.home.check().map_err(SitlError::Home)?;
        if !settings.heading_rad.is_finite() {
            return Err(SitlError::Heading(settings.heading_rad));
        }
        let pose = Pose { psi_rad: settings.heading_rad, ..Pose::default() };
        let autopilot = Autopilot::new(settings.autopilot, &settings.hull, settings.home)?;
        let mut vessel = Vessel::new(settings.hull, &settings.sea, &settings.sensors, settings.seed, pose);
        vessel.set_moored(settings.moored_until_armed);
        let mut sitl = Self {
            autopilot,
            vessel,
            now: Duration::ZERO,
            moored: settings.moored_until_armed,
            schedule: Schedule::default(),
            lines: Lines::new(settings.seed),
            weather: LinkWeather::default(),
            outbox: VecDeque::new(),
            faults_of: None,
            sea_parameters: [0.0; 4],
            play: None,
            starts_itself: false,
        };
        sitl.autopilot.put_gps_rate(settings.sensors.noise.map_or(5.0, |noise| noise.gps_rate_hz));
        sitl.autopilot.put_sea(&settings.sea);
        sitl.sea_parameters = sitl.autopilot.sea_parameters();
        sitl.autopilot.sense(sitl.vessel.estimate(), sitl.vessel.truth().hull, Duration::ZERO);
        Ok(sitl)
    }

    /// Opens a link. `false` if there are too many; bytes on it are then ignored.
    pub fn link_up(&mut self, link: LinkId) -> bool {
        self.autopilot.link_up(link)
    }

    /// Closes a link: its rates, its transfers and what waits to be sent on it are forgotten.
    pub fn link_down(&mut self, link: LinkId) {
        self.autopilot.link_down(link);
        self.lines.forget(link);
        self.outbox.retain(|(to, _)| *to != link);
    }

    /// Bytes of a stream that arrive now. They are acted upon in the next loop.
    pub fn on_bytes(&mut self, link: LinkId, bytes: &[u8]) {
        self.receive(link, bytes, false);
    }

    /// A datagram that arrives now: as [`Sitl::on_bytes`], but no frame goes on in the next one.
    pub fn on_datagram(&mut self, link: LinkId, bytes: &[u8]) {
        self.receive(link, bytes, true);
    }

    fn receive(&mut self, link: LinkId, bytes: &[u8], datagram: bool) {
        if self.lines.carries(link, &self.weather) {
            self.lines.take_in(link, bytes, self.now, &self.weather);
        } else {
            self.autopilot.on_bytes(link, bytes, datagram);
        }
    }

    /// Lets simulated time pass, in loops of 20 ms: all that end at or before `until`. Each loop reads what
    /// has arrived, steers, moves the boat, and sends what is due.
    pub fn advance(&mut self, until: Duration) {
        while self.now + LOOP <= until {
            if !self.autopilot.clock.may_run() {
                self.autopilot.serve();
            }
            if !self.autopilot.clock.may_run() {
                break;
            }
            self.run_loop();
        }
    }

    /// How things stand.
    pub fn observe(&self) -> Observation {
        self.autopilot.observe()
    }

    /// Names and values of the parameters that were changed by users, faults and the simulator's own left out:
    /// what a file of parameters is to keep.
    pub fn changed_parameters(&self) -> Vec<(String, f32)> {
        self.autopilot.changed_parameters()
    }

    /// A number that changes whenever a parameter does.
    pub fn parameter_revision(&self) -> u64 {
        self.autopilot.parameter_revision()
    }

    fn run_loop(&mut self) {
        self.starts_itself = self.starts_itself && !self.autopilot.start();
        if let Some(mut play) = self.play.take() {
            play.step(self);
            self.play = Some(play);
        }
        self.turn_faults();
        for (link, bytes) in self.lines.arriving(self.now) {
            self.autopilot.on_bytes(link, &bytes, true);
        }
        let command = self.autopilot.control(self.now);
        if self.moored && self.autopilot.is_armed() {
            self.moored = false;
            self.vessel.set_moored(false);
        }
        for _ in 0..STEPS_PER_LOOP {
            self.vessel.step(STEP_S, command);
        }
        self.now += LOOP;
        self.autopilot.sense(self.vessel.estimate(), self.vessel.truth().hull, self.now);
        self.autopilot.transmit();
        self.send_over_bad_lines();
    }

    /// Takes what is to be sent on bad lines from the autopilot, and what arrives over them.
    fn send_over_bad_lines(&mut self) {
        for link in self.autopilot.links() {
            if self.lines.carries(link, &self.weather) {
                while let Some(bytes) = self.autopilot.poll_transmit_on(link) {
                    self.lines.take_out(link, &bytes, self.now, &self.weather);
                }
            }
        }
        for arrived in self.lines.leaving(self.now) {
            if self.outbox.len() < MAX_OUTBOX {
                self.outbox.push_back(arrived);
            }
        }
    }

    /// The next bytes to send, whole frames, at most 1400 bytes at a time. What is not taken for long is
    /// dropped: at most 256 KiB wait for a link and 1 MiB for all of them, answers longest.
    pub fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.outbox.pop_front().or_else(|| self.autopilot.poll_transmit())
    }

    /// Bytes that were dropped because nobody took them.
    pub fn lost_bytes(&self) -> u64 {
        self.autopilot.lost_bytes()
    }

    /// Simulated time since the start.
    pub fn now(&self) -> Duration {
        self.now
    }

    /// What really happens to the boat, in metres from home.
    pub fn truth(&self) -> Truth {
        self.vessel.truth()
    }

    /// What the flight controller knows of it, in metres from home.
    pub fn estimate(&self) -> Estimate {
        self.vessel.estimate()
    }

    /// The boat.
    pub fn hull(&self) -> &Hull {
        self.vessel.hull()
    }

    /// Whether the motors are armed.
    pub fn is_armed(&self) -> bool {
        self.autopilot.is_armed()
    }

    /// Arms the boat and starts its mission, or has it keep its place if there is none. False while it is not
    /// ready for that; try again later.
    pub fn start(&mut self) -> bool {
        self.autopilot.start()
    }

    /// Has the boat do as [`Sitl::start`] in the first loop in which it can.
    pub fn start_when_ready(&mut self) {
        self.starts_itself = true;
    }

    /// Stores a mission as if it had been uploaded; `items` are without home.
    ///
    /// # Errors
    /// The number of items that can be stored, home included, if there are more.
    pub fn set_mission(&mut self, items: &[Item]) -> Result<(), u16> {
        self.autopilot.set_mission(items)
    }
}
