//! The bridge between a flight controller and the pilot, without input or output of its own.
//!
//! Bytes come in by [`Bridge::on_bytes`], time by every call, bytes go out by [`Bridge::poll_transmit`]. The same
//! bridge runs behind sockets, inside the simulation and on a recorded log. The control loop steps when new
//! telemetry has come, so the commands depend on nothing but the bytes received.
//!
//! | module | what it does |
//! |---|---|
//! | [`settings`] | what the user decides beforehand |
//! | [`status`] | what the bridge tells its surroundings |
//! | [`counts`] | how often what has gone wrong |
//! | [`controller_state`] | what the controller thinks, as messages |
//! | `links` | peers, sequence numbers, the journal, the digest of all commands |
//! | `mission` | gets the mission, and notices another one |
//! | `actions` | commands of the mission that are the flight controller's |
//! | `commands` | commands to the bridge itself |
//! | `looking` | what the driver can look at, and the journal |
//! | `follow` | keeps the flight controller's current item and the bridge's the same |
//! | `listening` | what the flight controller says, and which one it is |
//! | `ordering` | commands to the bridge, and the answers to its own |
//! | `housekeeping` | requests, parameters and missions, looked after from time to time |
//! | `observing` | what the failsafes see |
//! | `fence` | gets the fence |
//! | [`resume`] | going on after the bridge itself has died |
//! | `routing` | passes frames on between links |
//! | `steering` | one control step: supervise, compute, send |
//! | [`pace`] | how evenly the steering frames go out |
//! | [`parameters`] | the bridge's own parameters |
//! | `metadata` | their ranges and meanings, for ground stations to read |
//! | `timesync` | the flight controller's distance in time |
//! | `reporting` | heartbeat, progress and messages for the ground station |

mod actions;
mod commands;
pub mod controller_state;
pub mod counts;
mod fence;
mod follow;
mod housekeeping;
mod links;
mod listening;
mod looking;
mod metadata;
mod mission;
mod observing;
mod ordering;
pub mod pace;
pub mod parameters;
mod reporting;
pub mod resume;
mod routing;
#[cfg(test)]
mod sea_trials;
pub mod settings;
pub mod status;
mod steering;
mod timesync;

use std::collections::{BTreeSet, VecDeque};
use std::time::Duration;

use helmlink_wire::{Identity, LinkId, Message, enums};

pub use counts::Counts;
pub use settings::{BridgeSettings, MissionSource};
pub use status::{Event, Health, Status};

use self::actions::Actions;
use self::follow::CurrentItem;
use self::links::{FarEnd, Links};
use self::metadata::Metadata;
use self::mission::MissionKeeper;
use self::observing::Observer;
use self::parameters::Tunables;
use self::parameters::service::ParameterService;
use self::reporting::Reporter;
use self::steering::Steering;
use self::timesync::TimeSync;
use crate::control::response::DelayChoice;
use crate::pilot::MissionRun;
use crate::pilot::failsafe::Watch;
use crate::pilot::supervisor::{Policy, Reason, Request, State, Supervisor};
use crate::vehicle::output::{self, Demand, Output};
use crate::vehicle::{Cadence, ParameterReader, StreamRequests, Telemetry, VehicleClock};

/// How often a driver should call [`Bridge::on_tick`], on its own clock.
pub const TICK: Duration = Duration::from_millis(20);
/// Time between two looks at requests and time-outs, at the vehicle's pace.
const HOUSEKEEPING: Duration = Duration::from_millis(10);
/// Time between two requests for a mode or for arming.
const REQUEST_REPEAT: Duration = Duration::from_millis(700);
/// A flight controller that shows up on another link is followed there when the old link has been silent this long: a
/// datagram's sender has changed its port, or a modem its address. Sooner than its silence ends a drive.
const MOVE_AFTER_S: f64 = 1.0;
/// Nobody drives slower than this, m/s.
pub(crate) const LEAST_SPEED_MPS: f64 = 0.1;
/// Changes of state that nobody has taken beyond this number are dropped.
const CHANGE_LIMIT: usize = 100;
/// Events that nobody has taken beyond this number are dropped.
const EVENT_LIMIT: usize = 1000;

/// The flight controller that is being steered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Vehicle {
    link: LinkId,
    id: Identity,
}

/// Steers one boat through its flight controller.
pub struct Bridge {
    settings: BridgeSettings,
    links: Links,
    clock: VehicleClock,
    driver_now: Duration,
    now: Duration,
    last_housekeeping: Option<Duration>,
    vehicle: Option<Vehicle>,
    /// The flight controller that was found first: the bridge keeps to it.
    kept: Option<Identity>,
    /// Other flight controllers on its link that have been told of.
    strangers: BTreeSet<Identity>,
    refusal: Option<String>,
    telemetry: Telemetry,
    cadence: Cadence,
    streams: StreamRequests,
    parameters: ParameterReader,
    output: Output,
    output_ready: bool,
    mission: MissionKeeper,
    run: Option<MissionRun>,
    actions: Actions,
    current: CurrentItem,
    supervisor: Supervisor,
    watch: Watch,
    observer: Observer,
    timesync: TimeSync,
    delay_choice: DelayChoice,
    parameter_service: ParameterService,
    metadata: Metadata,
    /// The parameters as the bridge was started with, saved ones left out.
    factory: Tunables,
    steering: Steering,
    counts: Counts,
    abandoned: bool,
    reporter: Reporter,
    last_request: Option<Duration>,
    events: VecDeque<Event>,
    /// The bridge at each change of state that nobody has taken yet.
    changes: VecDeque<Status>,
    /// Why the state machine is where it is.
    reason: Option<Reason>,
    /// The settings before parameters changed them.
    given: BridgeSettings,
}

impl Bridge {
    /// A bridge that has not heard anything yet.
    pub fn new(mut settings: BridgeSettings) -> Self {
        let mut parameters = ParameterReader::new(&output::PARAMETERS);
        parameters.wish_for(&output::OPTIONAL_PARAMETERS);
        let given = settings.clone();
        let factory = settings.tunables();
        let complaints = settings.take_saved_parameters();
        let policy = Policy {
            drive_mode: settings.output.mode(),
            engage_mode: settings.engage_mode,
            may_arm: settings.may_arm,
            end_mode: settings.end_mode,
            shadow: settings.shadow,
            limits: settings.effective_limits(),
        };
        let mut bridge = Self {
            links: Links::new(settings.shadow),
            clock: VehicleClock::default(),
            driver_now: Duration::ZERO,
            now: Duration::ZERO,
            last_housekeeping: None,
            vehicle: None,
            kept: None,
            strangers: BTreeSet::new(),
            refusal: None,
            telemetry: Telemetry::default(),
            cadence: Cadence::new(settings.control_interval_s),
            streams: StreamRequests::new(settings.control_interval_s),
            parameters,
            output: Output::new(settings.output),
            // A shadow asks nothing, so there is nothing to wait for.
            output_ready: settings.shadow,
            mission: MissionKeeper::new(&settings.mission, &settings.boat),
            run: None,
            actions: Actions::default(),
            current: CurrentItem::default(),
            supervisor: Supervisor::new(policy),
            watch: Watch::new(settings.failsafes.clone()),
            observer: Observer::default(),
            timesync: TimeSync::default(),
            delay_choice: DelayChoice::default(),
            parameter_service: ParameterService::default(),
            metadata: Metadata::default(),
            factory,
            steering: Steering::default(),
            counts: Counts::default(),
            abandoned: false,
            reporter: Reporter::default(),
            last_request: None,
            events: VecDeque::new(),
            changes: VecDeque::new(),
            reason: None,
            given,
            settings,
        };
        for complaint in complaints {
            bridge.event(enums::MAV_SEVERITY_WARNING, format!("saved parameter left out: {complaint}"));
        }
        if bridge.settings.engage {
            bridge.request(Duration::ZERO, Request::Engage { patient: true }).ok();
        }
        bridge
    }

    /// A peer has appeared where the flight controller is. It hears from the bridge at once.
    pub fn link_up(&mut self, now: Duration, link: LinkId) {
        self.record(|journal| journal.link_up(now, link));
        self.welcome(now, link, FarEnd::Vehicle);
    }

    /// A peer has appeared that is no flight controller: a ground station, or another program. Whatever it says, it is
    /// not steered. Bytes from a link of which nothing has been said count as such a peer's.
    pub fn station_link_up(&mut self, now: Duration, link: LinkId) {
        self.record(|journal| journal.station_up(now, link));
        self.welcome(now, link, FarEnd::Station);
    }

    fn welcome(&mut self, now: Duration, link: LinkId, far_end: FarEnd) {
        self.advance(now);
        self.links.add(now, link, far_end);
        self.send_heartbeat();
    }

    /// A peer has gone.
    pub fn link_down(&mut self, now: Duration, link: LinkId) {
        self.record(|journal| journal.link_down(now, link));
        self.advance(now);
        self.links.remove(link);
        self.metadata.forget(link);
        if self.vehicle.is_some_and(|vehicle| vehicle.link == link) {
            self.event(enums::MAV_SEVERITY_WARNING, "the link to the flight controller went down");
            self.forget_vehicle();
            self.supervise();
        }
    }

    /// Bytes of a peer have arrived; `is_datagram` when they are one whole datagram.
    pub fn on_bytes(&mut self, now: Duration, link: LinkId, bytes: &[u8], is_datagram: bool) {
        self.record(|journal| journal.bytes(now, link, bytes, is_datagram));
        self.advance(now);
        self.housekeeping();
        self.links.push(now, link, bytes, is_datagram);
        self.drain(link);
    }

    /// Time has passed. Call it every [`TICK`].
    pub fn on_tick(&mut self, now: Duration) {
        self.record(|journal| journal.tick(now));
        self.advance(now);
        self.links.flush_idle(now);
        let links: Vec<LinkId> = self.links.ids().collect();
        for link in links {
            self.drain(link);
        }
        self.housekeeping();
    }

    /// The next frame to send, and to whom.
    pub fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.links.poll_transmit()
    }

    /// The next line for the log.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// The bridge as it was at the next change of its state, with the reason.
    pub fn poll_change(&mut self) -> Option<Status> {
        self.changes.pop_front()
    }

    /// Asks something of the bridge, as the user at its console.
    ///
    /// # Errors
    /// Why it will not be done.
    pub fn request(&mut self, now: Duration, request: Request) -> Result<(), String> {
        self.record(|journal| journal.request(now, &request));
        self.advance(now);
        self.take_request(request)
    }

    fn take_request(&mut self, request: Request) -> Result<(), String> {
        if matches!(request, Request::Engage { .. })
            && let Some(vehicle) = self.vehicle
        {
            self.mission.refresh(self.own(vehicle.id), vehicle.id);
            self.observer.fence.refresh();
        }
        self.look_out();
        let conditions = self.conditions();
        let answer = self.supervisor.request(self.now.as_secs_f64(), request, &conditions);
        self.supervise();
        answer
    }

    /// Stops the boat and lets it go at once, whatever the state: for a driver that cannot go on. Nothing else is to be
    /// asked of this bridge than its last frames.
    pub fn abandon(&mut self) {
        self.abandoned = true;
        let drives = matches!(self.supervisor.state(), State::Engaging | State::Engaged | State::HandingBack);
        if let Some(vehicle) = self.vehicle.filter(|_| drives) {
            self.send_demand(Demand::NEUTRAL);
            self.let_go(vehicle);
        }
    }

    /// How the bridge's process is; the ground station is told with the next report. What is not a number is not told.
    pub fn set_health(&mut self, now: Duration, health: Health) {
        if ![health.late_ms, health.cpu_percent, health.memory_mb].iter().all(|value| value.is_finite()) {
            return;
        }
        self.record(|journal| journal.health(now, &health));
        self.advance(now);
        self.reporter.health = Some(health);
    }

    fn advance(&mut self, now: Duration) {
        self.driver_now = self.driver_now.max(now);
        self.now = self.clock.advance(now);
    }

    fn own(&self, vehicle: Identity) -> Identity {
        Identity { system: vehicle.system, component: settings::COMPONENT }
    }

    /// Every address that the bridge sends with.
    fn own_addresses(&self) -> [Identity; 2] {
        let own = self.own_or_default();
        [own, self.settings.steering_identity(own)]
    }

    fn drain(&mut self, link: LinkId) {
        while let Some((from, message)) =
            self.links.next_message(self.driver_now, link, &self.own_addresses())
        {
            self.on_message(link, from, &message);
        }
    }

    fn on_message(&mut self, link: LinkId, from: Identity, message: &Message) {
        if let Message::HEARTBEAT(heartbeat) = message {
            self.observer.on_heartbeat(self.now, heartbeat);
            self.meet(link, from, heartbeat);
        }
        let Some(vehicle) = self.vehicle else { return };
        if from == vehicle.id && link == vehicle.link {
            self.on_vehicle_message(vehicle, message);
        } else {
            self.watch_for_rivals(from, message);
        }
        self.on_order(link, from, vehicle, message);
    }

    fn event(&mut self, severity: u8, text: impl Into<String>) {
        let event = Event { severity, text: text.into() };
        self.record(|journal| journal.event(event.severity, &event.text));
        self.announce(&event);
        if self.events.len() >= EVENT_LIMIT {
            self.events.pop_front();
        }
        self.events.push_back(event);
    }
}
