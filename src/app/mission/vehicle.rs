//! One conversation with a flight controller: find it, then send or fetch plans, one after the other.

use std::collections::VecDeque;
use std::time::Duration;

use clap::Args;
use helmlink_mission::plan::Mission;
use helmlink_mission::protocol::MissionType;
use helmlink_mission::protocol::client::{Download, Exchange, Progress, TransferError, Upload};
use helmlink_wire::enums::{self, MAV_MISSION_DENIED, MAV_MISSION_OPERATION_CANCELLED};
use helmlink_wire::{Identity, LinkId, Message};

use super::super::cli::Common;
use super::super::client::{Client, OWN};
use super::super::console::ProgressLine;
use super::super::edge::{Edge, Party};
use super::super::failure::Failure;
use super::super::interrupt::interrupted;
use super::super::ranges::WaitS;
use crate::link::{EndpointId, Hub, LinkSettings, LinkUrl};
use crate::vehicle::Mode;
use crate::vehicle::telemetry::{Sender, classify};

const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(1);
/// How often the machines look at the clock.
const TICK: Duration = Duration::from_millis(10);
/// A transfer that another ground station or the radio has disturbed is begun anew so many times, after a while.
const ATTEMPTS: u32 = 4;
const PAUSE: Duration = Duration::from_secs(2);

/// Where the flight controller is.
#[derive(Debug, Clone, Args)]
pub struct VehicleArgs {
    /// The flight controller: tcp:HOST:PORT, udpin:HOST:PORT, udpout:HOST:PORT or serial:DEVICE:BAUD
    #[arg(long, value_name = "URL")]
    pub connect: LinkUrl,
    /// Give up when no heartbeat has come for this many seconds
    #[arg(long, default_value = "10", value_name = "S")]
    pub wait: WaitS,
}

/// A transfer to be made.
#[derive(Debug, Clone)]
pub(super) enum Task {
    /// Send a plan of this kind.
    Send(MissionType, Mission),
    /// Fetch the plan of this kind.
    Fetch(MissionType),
}

/// The transfer that is going on.
enum Running {
    Sending(Box<Upload>),
    Fetching(Box<Download>),
}

/// What the flight controller's last heartbeat said.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vehicle {
    pub(super) id: Identity,
    pub(super) mode: Mode,
    pub(super) armed: bool,
}

/// The conversation.
pub(super) struct Session {
    tasks: VecDeque<Task>,
    running: Option<Running>,
    attempts: u32,
    begin_at: Duration,
    fetched: Vec<Mission>,
    failure: Option<TransferError>,
    vehicle: Option<Vehicle>,
    wrong: Option<(u8, u8)>,
    client: Client,
    may_begin: bool,
}

impl Session {
    pub(super) fn new() -> Self {
        Self {
            tasks: VecDeque::new(),
            running: None,
            attempts: 0,
            begin_at: Duration::ZERO,
            fetched: Vec::new(),
            failure: None,
            vehicle: None,
            wrong: None,
            client: Client::default(),
            may_begin: false,
        }
    }

    /// A way to the flight controller is there.
    pub(super) fn join(&mut self, now: Duration, link: LinkId) {
        self.client.link_up(link);
        self.work(now);
    }

    /// Makes these transfers, one after the other.
    pub(super) fn begin(&mut self, tasks: Vec<Task>) {
        self.tasks = tasks.into();
        self.may_begin = true;
    }

    /// The plans fetched, in their order.
    ///
    /// # Errors
    /// Why a transfer failed, in words.
    pub(super) fn result(self) -> Result<Vec<Mission>, String> {
        let Some(error) = self.failure else { return Ok(self.fetched) };
        let was_under_way = !matches!(error, TransferError::NoAnswer { .. } | TransferError::TooLong { .. });
        Err(match self.tasks.front() {
            // ArduPilot overwrites the old plan item by item.
            Some(Task::Send(..)) if was_under_way => format!(
                "{error}; what is on board now may be a part of either plan: upload again, or look with \
                 `helmlink mission download`"
            ),
            _ => error.to_string(),
        })
    }

    pub(super) fn is_done(&self) -> bool {
        self.failure.is_some() || (self.running.is_none() && self.tasks.is_empty())
    }

    fn progress(&self) -> Option<(&'static str, Progress)> {
        self.running.as_ref().map(|running| match running {
            Running::Sending(upload) => ("sent", upload.progress()),
            Running::Fetching(download) => ("received", download.progress()),
        })
    }

    fn on_message(&mut self, now: Duration, from: Identity, message: &Message) {
        if let Message::HEARTBEAT(heartbeat) = message {
            match classify(from, heartbeat) {
                Sender::Boat if self.vehicle.is_none_or(|vehicle| vehicle.id == from) => {
                    let armed = heartbeat.base_mode & enums::MAV_MODE_FLAG_SAFETY_ARMED != 0;
                    self.vehicle = Some(Vehicle { id: from, mode: Mode(heartbeat.custom_mode), armed });
                }
                Sender::WrongVehicle(kind, autopilot) => self.wrong = Some((kind, autopilot)),
                _ => {}
            }
        }
        match &mut self.running {
            Some(Running::Sending(upload)) => {
                upload.on_message(now, from, message);
            }
            Some(Running::Fetching(download)) => {
                download.on_message(now, from, message);
            }
            None => {}
        }
    }

    fn work(&mut self, now: Duration) {
        self.client.keep_alive(now, HEARTBEAT_INTERVAL);
        let Some(vehicle) = self.vehicle.filter(|_| self.may_begin && self.failure.is_none()) else { return };
        if self.running.is_none() && now >= self.begin_at {
            self.running = self.tasks.front().map(|task| start(task, vehicle.id));
        }
        loop {
            let message = match &mut self.running {
                Some(Running::Sending(upload)) => upload.poll(now),
                Some(Running::Fetching(download)) => download.poll(now),
                None => None,
            };
            let Some(message) = message else { break };
            self.client.send(&message);
        }
        let outcome = match &self.running {
            Some(Running::Sending(upload)) => upload.outcome().map(|outcome| outcome.map(|()| None)),
            Some(Running::Fetching(download)) => download.outcome().map(|outcome| outcome.cloned().map(Some)),
            None => None,
        };
        if let Some(outcome) = outcome {
            self.running = None;
            self.finish(now, outcome);
        }
    }

    fn finish(&mut self, now: Duration, outcome: Result<Option<Mission>, TransferError>) {
        match outcome {
            Ok(fetched) => {
                self.fetched.extend(fetched);
                self.tasks.pop_front();
                self.attempts = 0;
            }
            Err(error) => {
                self.attempts += 1;
                if is_passing(&error) && self.attempts < ATTEMPTS {
                    tracing::warn!("{error}; trying again");
                    self.begin_at = now + PAUSE;
                } else {
                    self.failure = Some(error);
                }
            }
        }
    }
}

fn start(task: &Task, vehicle: Identity) -> Running {
    let exchange = |kind| Exchange::with_ardupilot(OWN, vehicle, kind);
    match task {
        Task::Send(kind, plan) => Running::Sending(Box::new(Upload::new(exchange(*kind), plan))),
        Task::Fetch(kind) => Running::Fetching(Box::new(Download::new(exchange(*kind)))),
    }
}

/// Whether the next attempt may well succeed: another ground station was at work, or the radio lost too much.
fn is_passing(error: &TransferError) -> bool {
    match error {
        TransferError::Stalled { .. } | TransferError::Unconfirmed { .. } => true,
        TransferError::Refused { result, .. } => {
            matches!(result.0, MAV_MISSION_DENIED | MAV_MISSION_OPERATION_CANCELLED)
        }
        TransferError::NoAnswer { .. } | TransferError::TooLong { .. } => false,
    }
}

impl Party for Session {
    fn link_up(&mut self, now: Duration, link: LinkId, _endpoint: EndpointId) {
        self.join(now, link);
    }

    fn link_down(&mut self, _now: Duration, link: LinkId) {
        self.client.link_down(link);
    }

    fn on_bytes(&mut self, now: Duration, _link: LinkId, bytes: &[u8], _is_datagram: bool) {
        self.client.push(bytes);
        while let Some((from, message)) = self.client.next_message() {
            self.on_message(now, from, &message);
            self.work(now);
        }
    }

    fn on_tick(&mut self, now: Duration) {
        self.work(now);
    }

    fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.client.poll_transmit()
    }
}

/// Makes the transfers that `plan` decides on once the flight controller has been found; the plans fetched, in
/// their order.
pub(super) fn converse(
    args: &VehicleArgs,
    common: &Common,
    plan: impl FnOnce(Vehicle) -> Result<Vec<Task>, Failure>,
) -> Result<Vec<Mission>, Failure> {
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::failed)?;
    runtime.block_on(talk(args, common, plan))
}

pub(super) async fn talk(
    args: &VehicleArgs,
    common: &Common,
    plan: impl FnOnce(Vehicle) -> Result<Vec<Task>, Failure>,
) -> Result<Vec<Mission>, Failure> {
    let wait = Duration::from_secs_f64(*args.wait);
    let mut hub = Hub::new(LinkSettings::default());
    hub.open(&args.connect).await.map_err(Failure::usage)?;
    let mut edge = Edge::new(Session::new(), hub, TICK);
    let mut line = ProgressLine::new(common);
    let mut interrupt = std::pin::pin!(interrupted());
    let mut plan = Some(plan);
    let mut shown = None;
    let ending = loop {
        tokio::select! {
            biased;
            () = &mut interrupt => break Err(Failure::failed("interrupted: what the flight controller now has is not known")),
            _ = edge.turn() => {}
        }
        let now = edge.now();
        let session = &mut edge.party;
        if let (Some(vehicle), Some(decide)) = (session.vehicle, plan.take_if(|_| session.vehicle.is_some()))
        {
            match decide(vehicle) {
                Ok(tasks) => session.begin(tasks),
                Err(failure) => break Err(failure),
            }
            session.work(now);
        }
        if session.vehicle.is_none() && now > wait {
            break Err(not_found(args, session.wrong));
        }
        let progress = session.progress().filter(|progress| Some(*progress) != shown);
        if let Some((what, progress)) = progress {
            shown = Some((what, progress));
            let total = progress.total.map_or_else(|| "?".to_owned(), |total| total.to_string());
            line.show(&format!("{what} {} of {total} items", progress.done));
        }
        if plan.is_none() && session.is_done() {
            break Ok(());
        }
    };
    line.clear();
    let session = edge.close().await;
    ending?;
    session.result().map_err(Failure::failed)
}

fn not_found(args: &VehicleArgs, wrong: Option<(u8, u8)>) -> Failure {
    match wrong {
        Some((kind, autopilot)) => Failure::usage(format!(
            "the vehicle on {} is no boat or rover run by ArduPilot (MAV_TYPE {kind}, MAV_AUTOPILOT {autopilot})",
            args.connect
        )),
        None => Failure::no_link(format!(
            "no heartbeat of a flight controller on {} for {} s: check that it is powered, the address and the \
             baud rate, and that the port speaks MAVLink 2 (SERIALn_PROTOCOL 2)",
            args.connect, args.wait
        )),
    }
}
