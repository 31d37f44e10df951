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
//! | [`controller_state`] | what the controller thinks, as messages |
//! | `links` | peers, sequence numbers, the journal, the digest of all commands |
//! | `mission` | gets the mission, and notices another one |
//! | `actions` | commands of the mission that are the flight controller's |
//! | `commands` | commands to the bridge itself |
//! | `follow` | keeps the flight controller's current item and the bridge's the same |
//! | `observing` | what the failsafes see |
//! | `fence` | gets the fence |
//! | `routing` | passes frames on between links |
//! | `steering` | one control step: supervise, compute, send |
//! | [`pace`] | how evenly the steering frames go out |
//! | [`parameters`] | the bridge's own parameters |
//! | `timesync` | the flight controller's distance in time |
//! | `reporting` | heartbeat, progress and messages for the ground station |

mod actions;
mod commands;
pub mod controller_state;
mod fence;
mod follow;
mod links;
mod mission;
mod observing;
pub mod pace;
pub mod parameters;
mod reporting;
mod routing;
pub mod settings;
pub mod status;
mod steering;
mod timesync;

use std::collections::VecDeque;
use std::time::Duration;

use helmlink_mission::route::Ending;
use helmlink_wire::dialect::{COMMAND_ACK_DATA, HEARTBEAT_DATA, MISSION_SET_CURRENT_DATA, MessageSet};
use helmlink_wire::{Identity, LinkId, LinkStatistics, Message, enums};

pub use settings::{BridgeSettings, MissionSource};
pub use status::{Event, Status};

use self::actions::Actions;
use self::commands::{Command, Order};
use self::fence::FenceNews;
use self::follow::CurrentItem;
use self::links::Links;
use self::mission::{MissionKeeper, News};
use self::observing::Observer;
use self::parameters::Tunables;
use self::parameters::service::ParameterService;
use self::reporting::Reporter;
use self::steering::Steering;
use self::timesync::TimeSync;
use crate::control::boat::Actuators;
use crate::pilot::failsafe::Watch;
use crate::pilot::supervisor::{Policy, Request, State, Supervisor};
use crate::pilot::{MissionRun, RunSettings};
use crate::record::{ControlState, Header, Journal};
use crate::vehicle::output::{self, Output, checks};
use crate::vehicle::telemetry::{Sender, Update, classify};
use crate::vehicle::{Cadence, Mode, ParameterReader, StreamRequests, Telemetry, VehicleClock};

/// How often a driver should call [`Bridge::on_tick`], on its own clock.
pub const TICK: Duration = Duration::from_millis(20);
/// Time between two looks at requests and time-outs, at the vehicle's pace.
const HOUSEKEEPING: Duration = Duration::from_millis(10);
/// Time between two requests for a mode or for arming.
const REQUEST_REPEAT: Duration = Duration::from_millis(700);
/// A flight controller that shows up on another link is followed there when the old link has been silent this long.
const MOVE_AFTER_S: f64 = 3.0;
/// Nobody drives slower than this, m/s.
const LEAST_SPEED_MPS: f64 = 0.1;
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
    parameter_service: ParameterService,
    /// The parameters as the bridge was started with, saved ones left out.
    factory: Tunables,
    steering: Steering,
    reporter: Reporter,
    last_request: Option<Duration>,
    events: VecDeque<Event>,
    /// The settings before parameters changed them.
    given: BridgeSettings,
}

impl Bridge {
    /// A bridge that has not heard anything yet.
    pub fn new(mut settings: BridgeSettings) -> Self {
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
            refusal: None,
            telemetry: Telemetry::default(),
            cadence: Cadence::new(settings.control_interval_s),
            streams: StreamRequests::new(settings.control_interval_s),
            parameters: ParameterReader::new(&output::PARAMETERS),
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
            parameter_service: ParameterService::default(),
            factory,
            steering: Steering::default(),
            reporter: Reporter::default(),
            last_request: None,
            events: VecDeque::new(),
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

    /// Keeps everything received and sent, and what is needed to make the same calls again, for
    /// [`Self::take_journal`]. The driver's time zero is `unix_start_us` microseconds after the Unix epoch.
    /// To be called before anything else happens: see [`crate::record`].
    pub fn keep_journal(&mut self, unix_start_us: u64) {
        self.links.keep_journal(Journal::new(&Header::new(unix_start_us, &self.given)));
    }

    /// Keeps the frames of the bridge's own, not those it passes on, for [`Self::poll_own`] as well.
    pub fn keep_own(&mut self) {
        self.links.keep_own();
    }

    /// The next frame of the bridge's own that was put out for sending, where [`Self::keep_own`] was called.
    pub fn poll_own(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.links.poll_own()
    }

    /// Telemetry log records since the last call, whole ones only.
    pub fn take_journal(&mut self) -> Vec<u8> {
        self.links.journal().map(Journal::take).unwrap_or_default()
    }

    /// The last records of the log: nothing that happens afterwards can be proven from it.
    pub fn finish_journal(&mut self) -> Vec<u8> {
        self.links.journal().map(Journal::finish).unwrap_or_default()
    }

    /// The records with which every file of the log begins; those of the first are in [`Self::take_journal`] too.
    pub fn journal_header(&mut self) -> Vec<u8> {
        self.links.journal().map(|journal| journal.header().to_vec()).unwrap_or_default()
    }

    /// A peer has appeared. It hears from the bridge at once.
    pub fn link_up(&mut self, now: Duration, link: LinkId) {
        self.record(|journal| journal.link_up(now, link));
        self.advance(now);
        self.links.add(now, link);
        self.send_heartbeat();
    }

    /// A peer has gone.
    pub fn link_down(&mut self, now: Duration, link: LinkId) {
        self.record(|journal| journal.link_down(now, link));
        self.advance(now);
        self.links.remove(link);
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

    /// The bridge at this instant.
    pub fn status(&self) -> Status {
        Status {
            state: self.supervisor.state(),
            vehicle: self.vehicle.map(|vehicle| vehicle.id),
            mode: self.telemetry.mode(),
            armed: self.telemetry.is_armed(),
            progress: self.run.as_ref().map(MissionRun::progress),
            demand: self.steering.demand,
            diagnostics: self.steering.diagnostics,
            steps: self.steering.steps,
            pace: self.steering.pace,
            round_trip_s: self.timesync.round_trip().map(|trip| trip.as_secs_f64()),
        }
    }

    /// The mission being driven, once there is one.
    pub fn run(&self) -> Option<&MissionRun> {
        self.run.as_ref()
    }

    /// What the controller took in and thought at the last step, once there was one.
    pub fn thought(&self) -> Option<ControlState> {
        self.steering.thought
    }

    /// Why this vehicle cannot be steered at all, if so.
    pub fn refusal(&self) -> Option<&str> {
        self.refusal.as_deref()
    }

    /// What a link has carried and lost.
    pub fn statistics(&self, link: LinkId) -> Option<LinkStatistics> {
        self.links.statistics(link)
    }

    /// SHA-256 of every steering frame sent so far, in order, and their number.
    pub fn commands_digest(&self) -> (String, u64) {
        self.links.commands_digest()
    }

    /// Lets the journal, if one is kept, take something down.
    pub(super) fn record(&mut self, write: impl FnOnce(&mut Journal)) {
        if let Some(journal) = self.links.journal() {
            write(journal);
        }
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
        }
        self.on_order(link, from, vehicle, message);
    }

    /// Somebody says that he is there: perhaps the flight controller.
    fn meet(&mut self, link: LinkId, from: Identity, heartbeat: &HEARTBEAT_DATA) {
        match (classify(from, heartbeat), self.vehicle) {
            (Sender::Boat, None) => self.adopt(Vehicle { link, id: from }),
            (Sender::Boat, Some(known))
                if known.id == from
                    && known.link != link
                    && self.telemetry.heartbeat_age_s(self.now) > MOVE_AFTER_S =>
            {
                self.adopt(Vehicle { link, id: from });
            }
            (Sender::WrongVehicle(kind, autopilot), None) if self.refusal.is_none() => {
                let text = format!(
                    "system {} is no boat or rover run by ArduPilot (MAV_TYPE {kind}, MAV_AUTOPILOT {autopilot}): \
                     helmlink steers only those; connect it to the boat's flight controller, or set FRAME_CLASS to boat",
                    from.system
                );
                self.refusal = Some(text.clone());
                self.event(enums::MAV_SEVERITY_ERROR, text);
            }
            _ => {}
        }
    }

    fn adopt(&mut self, vehicle: Vehicle) {
        self.forget_vehicle();
        self.vehicle = Some(vehicle);
        self.refusal = None;
        let text = format!("found the flight controller: system {}", vehicle.id.system);
        self.event(enums::MAV_SEVERITY_INFO, text);
    }

    fn forget_vehicle(&mut self) {
        self.vehicle = None;
        self.telemetry = Telemetry::default();
        self.observer.forget_vehicle();
        self.watch.forget_position();
        self.ask_again();
    }

    /// The flight controller is new or has restarted: nothing that was asked of it still holds.
    fn ask_again(&mut self) {
        self.streams.ask_again();
        self.parameters.ask_again();
        self.output_ready = self.settings.shadow;
        self.mission.on_vehicle_lost();
        self.current.clear();
    }

    fn on_vehicle_message(&mut self, vehicle: Vehicle, message: &Message) {
        self.streams.on_message(self.now, message.message_id());
        let update = self.telemetry.on_message(self.now, message);
        let own = self.own(vehicle.id);
        match message {
            Message::PARAM_VALUE(data) => {
                if self.parameters.on_value(data) && self.output_ready {
                    self.configure_output();
                }
            }
            Message::MISSION_CURRENT(data) => {
                self.mission.on_total(self.now, data.total, own, vehicle.id);
                if let Some(item) = self.current.on_current(data.seq) {
                    self.jump_to_item(item);
                }
            }
            Message::STATUSTEXT(data) => self.on_vehicle_text(data),
            Message::TIMESYNC(data) => {
                if let Some(answer) = self.timesync.on_message(self.driver_now, vehicle.id, data) {
                    self.links.send(vehicle.link, own, &answer);
                }
                self.tell_delay();
            }
            Message::COMMAND_ACK(data) => self.on_ack(own, data),
            _ => {
                self.mission.on_message(self.now, vehicle.id, message);
                self.observer.fence.on_message(self.now, vehicle.id, message);
            }
        }
        match update {
            Update::None => {}
            Update::Heartbeat => self.supervise(),
            Update::Rebooted => {
                self.event(enums::MAV_SEVERITY_WARNING, "the flight controller has restarted");
                self.observer.forget_vehicle();
                self.watch.forget_position();
                self.observer.rebooted = true;
                self.ask_again();
                self.supervise();
            }
            Update::Attitude(boot_s) => {
                self.clock.on_boot_time(boot_s);
                if self.cadence.on_attitude(boot_s) {
                    self.control_step();
                }
            }
            Update::Position(boot_s) => {
                if self.cadence.on_position(boot_s) {
                    self.control_step();
                }
            }
        }
    }

    /// Tells the controller how long its commands are under way, in the vehicle's time.
    fn tell_delay(&mut self) {
        if let (Some(run), Some(trip)) = (&mut self.run, self.timesync.usual_trip()) {
            run.set_delay_s(trip.as_secs_f64() * self.clock.rate());
        }
    }

    /// Commands and requests to the bridge itself, from anybody.
    fn on_order(&mut self, link: LinkId, from: Identity, vehicle: Vehicle, message: &Message) {
        let own = self.own(vehicle.id);
        if let Message::MISSION_SET_CURRENT(MISSION_SET_CURRENT_DATA { seq, target_system, target_component }) =
            message
            && (*target_system, *target_component) == (own.system, own.component)
        {
            self.jump_to_item(*seq);
        }
        self.on_parameter_message(link, from, message);
        let Some(command) = Command::from_message(message, own) else { return };
        let result = match command.order() {
            Order::Engage => {
                if command.number == enums::MAV_CMD_MISSION_START
                    && let Some(run) = self.run.as_mut().filter(|_| self.supervisor.state() == State::Ready)
                {
                    run.jump_to(0);
                }
                self.obey(Request::Engage { patient: false })
            }
            Order::Pause => self.obey(Request::Pause),
            Order::SetCurrent(item) => {
                if self.jump_to_item(item) {
                    enums::MAV_RESULT_ACCEPTED
                } else {
                    enums::MAV_RESULT_DENIED
                }
            }
            Order::ChangeSpeed(speed_mps) => self.change_speed(speed_mps),
            Order::LetGo => self.obey(Request::LetGo),
            Order::ResetParameters => {
                self.reset_parameters();
                enums::MAV_RESULT_ACCEPTED
            }
            // Parameters are kept as they are set.
            Order::SaveParameters => enums::MAV_RESULT_ACCEPTED,
            // FAILED and not UNSUPPORTED, on which some ground stations ask again and again.
            Order::NoSuchMessage => enums::MAV_RESULT_FAILED,
            Order::Unsupported => enums::MAV_RESULT_UNSUPPORTED,
            Order::Denied => enums::MAV_RESULT_DENIED,
        };
        self.links.send(link, own, &command.acknowledge(from, result));
    }

    fn change_speed(&mut self, speed_mps: f64) -> u8 {
        let most_mps = self.settings.boat.limits.speed_max_mps;
        let Some(run) = self.run.as_mut().filter(|_| (LEAST_SPEED_MPS..=most_mps).contains(&speed_mps))
        else {
            return enums::MAV_RESULT_DENIED;
        };
        run.set_speed(Some(speed_mps));
        self.event(enums::MAV_SEVERITY_INFO, format!("speed {speed_mps:.2} m/s from now on, as asked"));
        enums::MAV_RESULT_ACCEPTED
    }

    fn obey(&mut self, request: Request) -> u8 {
        match self.take_request(request) {
            Ok(()) => enums::MAV_RESULT_ACCEPTED,
            Err(why) => {
                self.event(enums::MAV_SEVERITY_WARNING, format!("command refused: {why}"));
                enums::MAV_RESULT_TEMPORARILY_REJECTED
            }
        }
    }

    /// Goes on with the first waypoint that belongs to this mission item or a later one.
    fn jump_to_item(&mut self, item: u16) -> bool {
        let Some(run) = &mut self.run else { return false };
        let Some(index) = run.route().waypoints.iter().position(|waypoint| waypoint.item >= item) else {
            return false;
        };
        run.jump_to(index);
        self.event(
            enums::MAV_SEVERITY_INFO,
            format!("going on with item {item}, as the ground station asked"),
        );
        true
    }

    fn on_ack(&mut self, own: Identity, data: &COMMAND_ACK_DATA) {
        let is_ours = data.target_system == 0
            || (data.target_system, data.target_component) == (own.system, own.component);
        let refused =
            data.result != enums::MAV_RESULT_ACCEPTED && data.result != enums::MAV_RESULT_IN_PROGRESS;
        if is_ours && self.actions.on_ack(data) {
            self.tell_of_actions();
        } else if is_ours && refused {
            let text = format!("command {} refused with MAV_RESULT {}", data.command, data.result);
            self.event(enums::MAV_SEVERITY_DEBUG, text);
        }
    }

    fn tell_of_actions(&mut self) {
        while let Some(outcome) = self.actions.poll_outcome() {
            self.event(outcome.severity, outcome.text);
        }
    }

    fn housekeeping(&mut self) {
        let is_due = self.last_housekeeping.is_none_or(|then| self.now.saturating_sub(then) >= HOUSEKEEPING);
        if !is_due {
            return;
        }
        self.last_housekeeping = Some(self.now);
        self.report();
        self.send_parameter_list();
        self.take_mission_news();
        if let Some(vehicle) = self.vehicle {
            self.ask(vehicle);
            self.check_output();
        }
        self.supervise();
        self.keep_sending();
    }

    /// Sends what is due to be asked of the flight controller.
    fn ask(&mut self, vehicle: Vehicle) {
        let own = self.own(vehicle.id);
        let Vehicle { link, id } = vehicle;
        while let Some(message) = self.streams.poll(self.now, id) {
            self.links.send(link, own, &message);
        }
        if let Some(message) = self.timesync.poll(self.driver_now, id) {
            self.links.send(link, own, &message);
        }
        while let Some(message) = self.parameters.poll(self.now, id) {
            self.links.send(link, own, &message);
        }
        while let Some(message) = self.mission.poll(self.now, own, id) {
            self.links.send(link, own, &message);
        }
        let is_free = self.mission.is_ready() || self.run.is_none();
        while let Some(message) = self.observer.fence.poll(self.now, own, id, is_free) {
            self.links.send(link, own, &message);
        }
        while let Some(message) = self.current.poll(self.now, id) {
            self.links.send(link, own, &message);
        }
        while let Some(message) = self.actions.poll(self.now, id) {
            self.links.send(link, own, &message);
        }
        self.tell_of_actions();
    }

    fn check_output(&mut self) {
        if self.output_ready || !self.parameters.is_complete() {
            return;
        }
        self.parameters.require(&output::channel_parameters(&self.parameters));
        if self.parameters.is_complete() {
            self.output_ready = self.configure_output();
            if self.output_ready {
                self.warn_of_parameters();
            }
        }
    }

    /// Fits the output to the vehicle's parameters; says what stands against it.
    fn configure_output(&mut self) -> bool {
        self.watch.configure(self.failsafes_in_force());
        let (kind, system) = (self.settings.output, self.settings.ground_station_system);
        let configured = self.output.configure(&self.parameters);
        let obstacle = checks::obstacle(kind, system, &self.parameters);
        match configured.err().or(obstacle) {
            None => true,
            Some(text) => {
                if self.reporter.is_new_problem(&text) {
                    self.event(enums::MAV_SEVERITY_ERROR, text);
                }
                false
            }
        }
    }

    fn warn_of_parameters(&mut self) {
        let is_twin = matches!(self.settings.boat.actuators, Actuators::TwinThrusters(_));
        for warning in checks::warnings(self.settings.output, is_twin, &self.parameters) {
            self.event(enums::MAV_SEVERITY_WARNING, warning);
        }
    }

    fn take_mission_news(&mut self) {
        match self.mission.poll_news(self.now) {
            Some(News::Loaded(route)) => {
                // To stay for ever at the end is the flight controller's to do: it goes on without the bridge.
                let stays = route.ending == Ending::Loiter;
                self.supervisor.set_end_mode(if stays { Mode::LOITER } else { self.settings.end_mode });
                let text = format!("mission loaded: {} waypoints", route.waypoints.len());
                let speed_mps = self.usual_speed_mps();
                let settings = RunSettings { speed_mps, controller: self.settings.controller };
                self.run = Some(MissionRun::new(route, self.settings.boat.clone(), settings));
                self.tell_delay();
                self.event(enums::MAV_SEVERITY_INFO, text);
            }
            Some(News::Unusable(text)) => {
                self.run = None;
                if self.reporter.is_new_problem(&text) {
                    self.event(enums::MAV_SEVERITY_ERROR, text);
                }
            }
            Some(News::NotRead(text)) if self.reporter.is_new_problem(&text) => {
                self.event(enums::MAV_SEVERITY_WARNING, text);
            }
            Some(News::NotRead(_)) | None => {}
        }
        match self.observer.fence.poll_news(self.now) {
            Some(FenceNews::Loaded) => {
                self.event(enums::MAV_SEVERITY_INFO, "fence loaded: the bridge watches it too");
            }
            Some(FenceNews::NotRead(why)) => {
                let text = format!("the fence could not be read, so it is not watched: {why}");
                self.event(enums::MAV_SEVERITY_WARNING, text);
            }
            None => {}
        }
    }

    /// Speed over ground where the mission does not say, m/s.
    fn usual_speed_mps(&self) -> f64 {
        self.settings
            .speed_mps
            .or_else(|| output::full_speed_mps(&self.parameters))
            .unwrap_or(self.settings.boat.limits.cruise_mps)
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
