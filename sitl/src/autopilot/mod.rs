//! The simulated flight controller: ArduRover 4.6 as a boat, as far as its clients can tell.
//!
//! | module | what it holds |
//! |---|---|
//! | `links`, `routes` | the links, and who is reached over which |
//! | `reception`, `messages` | from bytes to frames, and what is done with each message |
//! | `commands`, `parameters`, `missions`, `ftp` | the services |
//! | `streams`, `telemetry` | what is sent when |
//! | `modes`, `arming`, `failsafe`, `battery`, `fence` | what the boat may do |
//! | `faults` | what is made to fail, as parameters |
//! | `rc`, `guided`, `auto`, `breadcrumbs` | where the orders come from |
//! | `navigation`, `steering`, `outputs` | from places to turn rates to actuators |
//! | `tuning` | the gains for a hull |
//! | `boot` | starting, and starting anew |
//! | `owner` | what whoever runs the simulation sees and asks for |
//!
//! It runs in loops of 20 ms: [`Autopilot::control`] reads what has arrived and steers, the owner moves the
//! boat, [`Autopilot::sense`] takes in the new estimate, [`Autopilot::transmit`] sends what is due.
//! "Measured" in comments means on ArduRover 4.6 in its own simulator.

mod arming;
mod auto;
mod battery;
mod boot;
mod breadcrumbs;
mod commands;
mod failsafe;
mod faults;
mod fence;
mod ftp;
mod guided;
mod links;
mod messages;
mod missions;
mod mode_switch;
mod modes;
mod motion;
mod navigation;
mod outputs;
mod owner;
mod parameters;
mod rc;
mod reception;
mod routes;
mod settings;
#[cfg(test)]
mod signing_tests;
mod steering;
mod streams;
mod telemetry;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;
mod tuning;

use std::time::Duration;

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::plan::Item;
use helmlink_mission::protocol::MissionType;
use helmlink_mission::protocol::server::{MissionServer, Settings as MissionSettings};
use helmlink_wire::LinkId;
use helmlink_wire::dialect::{Message, TIMESYNC_DATA};
use helmlink_wire::signing::{Signing, Timestamp};

pub(crate) use modes::{mode_name, mode_number};
pub use settings::{AutopilotSettings, StartUp};

use crate::SitlError;
use crate::clock::Clock;
use crate::physics::{ActuatorCommand, Estimate, Hull, State};
use auto::Auto;
use battery::Battery;
use boot::own_identity;
use breadcrumbs::Breadcrumbs;
use failsafe::Failsafe;
use faults::FaultClock;
use fence::Fence;
use ftp::Ftp;
use guided::Guided;
use links::Links;
use mode_switch::ModeSwitch;
use modes::{Mode, ModeState};
use motion::{Demand, Drift, Motion};
use navigation::Report;
use outputs::{Outputs, function};
use parameters::*;
use rc::RcInput;
use steering::{Command, Steering};

/// Period of the autopilot's loop.
pub(crate) const LOOP: Duration = Duration::from_millis(20);
const LOOP_S: f64 = 0.02;
/// Period of the autopilot's own TIMESYNC questions.
const TIMESYNC_PERIOD: Duration = Duration::from_secs(10);
/// Period at which STAT_RUNTIME is told unasked.
const RUNTIME_PERIOD: Duration = Duration::from_secs(30);
/// Time constant of the drift angle's filter, in time constants of the heading.
const DRIFT_SHARE: f64 = 4.0;
/// Current drawn at rest, and by the motors at full revolutions on top, A.
const CURRENT_A: (f64, f64) = (0.5, 20.0);

/// The flight controller.
#[derive(Debug)]
pub(crate) struct Autopilot {
    settings: AutopilotSettings,
    /// Whether two thrusters steer.
    twin: bool,
    /// Local coordinates; the origin is where the boat started.
    frame: LocalFrame,
    parameters: Parameters,
    links: Links,
    missions: MissionServer,
    /// Simulated time, and that of the last start.
    now: Duration,
    booted: Duration,
    estimate: Estimate,
    /// What really happens, for SIMSTATE alone.
    truth: State,
    mode: Mode,
    mode_state: ModeState,
    armed: bool,
    home: Option<Geodetic>,
    /// Whether home was set by hand and stays where it is on arming.
    home_locked: bool,
    rc: RcInput,
    mode_switch: ModeSwitch,
    guided: Guided,
    auto: Auto,
    breadcrumbs: Breadcrumbs,
    failsafe: Failsafe,
    drift: Drift,
    steering: Steering,
    command: Command,
    outputs: Outputs,
    report: Option<Report>,
    /// The message that a command has asked for.
    requested: Option<Message>,
    battery: Battery,
    fence: Fence,
    ftp: Ftp,
    /// Who lets time pass.
    pub(crate) clock: Clock,
    /// A computer that starts says nothing until then.
    silent_until: Duration,
    faults: FaultClock,
    /// Time of the signatures when signing was set up, and simulated time then.
    signing_since: Timestamp,
    signing_started: Duration,
}

impl Autopilot {
    /// A flight controller that has just been switched on, tuned to `hull`, with its local origin at `origin`.
    pub(crate) fn new(settings: AutopilotSettings, hull: &Hull, origin: Geodetic) -> Result<Self, SitlError> {
        let twin = hull.has_twin_thrusters();
        let mut parameters = Parameters::new();
        tuning::apply(&crate::trial::run(hull), twin, &mut parameters);
        let (first, third) = if twin {
            (function::THROTTLE_LEFT, function::THROTTLE_RIGHT)
        } else {
            (function::STEERING, function::THROTTLE)
        };
        parameters.put(servo(1, ServoField::Function), first as f32);
        parameters.put(servo(3, ServoField::Function), third as f32);
        parameters.put(SIM_RC_FAIL, if settings.has_rc_receiver { 0.0 } else { 1.0 });
        parameters.set_base();
        for (name, value) in &settings.parameters {
            parameters.set(name, *value).map_err(|error| SitlError::Parameter {
                name: name.clone(),
                value: *value,
                cause: error.to_string(),
            })?;
        }
        let own = own_identity(&parameters);
        let mut autopilot = Self {
            settings,
            twin,
            frame: LocalFrame::new(origin),
            parameters,
            links: Links::new(own),
            missions: MissionServer::new(MissionSettings::default()),
            now: Duration::ZERO,
            booted: Duration::ZERO,
            estimate: Estimate::default(),
            truth: State::default(),
            mode: Mode::Initialising,
            mode_state: ModeState::default(),
            armed: false,
            home: None,
            home_locked: false,
            rc: RcInput::default(),
            mode_switch: ModeSwitch::default(),
            guided: Guided::default(),
            auto: Auto::default(),
            breadcrumbs: Breadcrumbs::default(),
            failsafe: Failsafe::default(),
            drift: Drift::default(),
            steering: Steering::default(),
            command: Command::default(),
            outputs: Outputs::default(),
            report: None,
            requested: None,
            battery: Battery::default(),
            fence: Fence::default(),
            ftp: Ftp::default(),
            clock: Clock::default(),
            silent_until: Duration::ZERO,
            faults: FaultClock::default(),
            signing_since: Timestamp::default(),
            signing_started: Duration::ZERO,
        };
        if let Some((key, since)) = autopilot.settings.signing.clone() {
            autopilot.signing_since = since;
            autopilot.links.set_signing(Some(Signing::new(key, since)));
        }
        Ok(autopilot)
    }

    pub(crate) fn link_up(&mut self, link: LinkId) -> bool {
        self.links.up(link)
    }

    pub(crate) fn link_down(&mut self, link: LinkId) {
        self.links.down(link);
        self.missions.link_down(link);
        self.ftp.forget(link);
        self.clock.forget(link);
    }

    /// Bytes that arrive; they are acted upon in the next loop.
    pub(crate) fn on_bytes(&mut self, link: LinkId, bytes: &[u8], datagram: bool) {
        self.links.push(link, bytes, datagram);
    }

    pub(crate) fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.links.poll()
    }

    pub(crate) fn lost_bytes(&self) -> u64 {
        self.links.lost_bytes()
    }

    pub(crate) fn is_armed(&self) -> bool {
        self.armed
    }

    pub(crate) fn set_mission(&mut self, items: &[Item]) -> Result<(), u16> {
        self.missions.set_items(MissionType::Mission, items)
    }

    /// The first half of a loop: reads what has arrived, and says what the actuators are to do.
    pub(crate) fn control(&mut self, now: Duration) -> ActuatorCommand {
        self.now = now;
        for link in self.links.ids() {
            self.receive(link);
        }
        self.take_passing_faults();
        self.start_up();
        self.poll_missions();
        self.rc.expire(now, &self.parameters);
        self.watch_mode_switch();
        self.watch_failsafes();
        self.watch_battery();
        self.watch_fence();
        self.drift.update(&self.motion(), DRIFT_SHARE / self.parameters.get(ATC_STR_ANG_P), LOOP_S);
        let demand = self.demand();
        let demand = if self.armed || self.mode == Mode::Manual { demand } else { Demand::NEUTRAL };
        let motion = self.motion();
        self.command = self.steering.command(demand, &motion, &self.parameters, self.twin, LOOP_S);
        self.outputs.put(self.command, self.armed, &self.parameters, LOOP_S);
        self.leave_breadcrumb();
        self.draw_current();
        self.outputs.actuators(self.twin)
    }

    /// Takes in the state of the boat at `now`.
    pub(crate) fn sense(&mut self, estimate: Estimate, truth: State, now: Duration) {
        self.estimate = estimate;
        self.truth = truth;
        self.now = now;
    }

    /// The second half of a loop: sends what is due.
    pub(crate) fn transmit(&mut self) {
        if self.is_starting() {
            return;
        }
        let before = self.now.saturating_sub(LOOP);
        self.links.observe_time(self.signing_since.later(self.now.saturating_sub(self.signing_started)));
        self.continue_parameter_lists();
        self.send_due(before);
        if self.passes(TIMESYNC_PERIOD) {
            let question = TIMESYNC_DATA { ts1: self.boot_nanoseconds(), ..TIMESYNC_DATA::DEFAULT };
            self.links.broadcast(&Message::TIMESYNC(question));
        }
        if self.passes(RUNTIME_PERIOD) {
            self.parameters.put(STAT_RUNTIME, self.since_boot().as_secs_f32());
            self.announce_parameter(STAT_RUNTIME);
        }
        for link in self.clock.count(self.now) {
            self.links.send(link, &self.system_time());
        }
    }

    /// While time stands: answers questions and takes orders that have arrived.
    pub(crate) fn serve(&mut self) {
        for link in self.links.ids() {
            self.receive(link);
        }
        self.poll_missions();
        self.continue_parameter_lists();
    }

    /// Whether a multiple of `period` since the start lies within this loop.
    fn passes(&self, period: Duration) -> bool {
        let (now, period) = (self.since_boot().as_nanos(), period.as_nanos());
        now / period > now.saturating_sub(LOOP.as_nanos()) / period
    }

    fn leave_breadcrumb(&mut self) {
        if self.armed && self.has_position() && self.mode != Mode::SmartRtl {
            let capacity = usize::try_from(self.parameters.int(SRTL_POINTS)).unwrap_or_default();
            let position = self.motion().position;
            self.breadcrumbs.drop_at(position, self.parameters.get(SRTL_ACCURACY), capacity);
        }
    }

    fn motion(&self) -> Motion {
        Motion::new(&self.estimate, &self.drift)
    }

    /// The estimated position.
    fn position(&self) -> Geodetic {
        self.frame.to_geodetic(self.motion().position)
    }

    /// Home in local coordinates; the origin as long as there is none.
    fn home_point(&self) -> NorthEast {
        self.home.map_or(NorthEast::ZERO, |home| self.frame.to_local(home))
    }

    /// Draws from the battery what this loop costs: the power of a propeller grows with the cube of its speed.
    fn draw_current(&mut self) {
        let load = self.outputs.motor_load(self.twin);
        self.battery.draw(CURRENT_A.0 + CURRENT_A.1 * load, LOOP_S);
    }
}
