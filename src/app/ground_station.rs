//! The demonstration's ground station: uploads the mission, arms the boat, disarms it in the end.
//!
//! It talks to the boat over a link of its own, as any ground station would.

use std::collections::VecDeque;
use std::time::Duration;

use helmlink_mission::plan::Mission;
use helmlink_mission::protocol::MissionType;
use helmlink_mission::protocol::client::{Exchange, Upload};
use helmlink_wire::{Identity, LinkId, Message, enums};

use super::client::{Client, OWN, is_due};
use super::edge::Party;
use crate::link::EndpointId;
use crate::vehicle::streams::command_long;
use crate::vehicle::telemetry::{Sender, classify};
use crate::vehicle::{StreamRequests, Telemetry};

/// Interval of its heartbeat at the boat's pace, and of repeated requests.
const INTERVAL: Duration = Duration::from_secs(1);
/// How often it wants to hear where the boat is, seconds.
const STREAM_INTERVAL_S: f64 = 0.5;

/// What it is doing.
#[derive(Debug)]
enum Task {
    /// Waiting for the boat.
    Finding,
    /// Sending the mission.
    Uploading(Box<Upload>),
    /// Waiting for a position, then arming.
    Arming,
    /// The boat is armed; the bridge drives.
    Watching,
    /// The run is over: disarming.
    Disarming,
    /// Done, or failed: why.
    Ended(Option<String>),
}

/// A ground station that prepares one run.
pub(super) struct GroundStation {
    mission: Mission,
    client: Client,
    vehicle: Option<Identity>,
    telemetry: Telemetry,
    streams: StreamRequests,
    task: Task,
    heartbeat_interval: Duration,
    last_request: Option<Duration>,
    notes: VecDeque<String>,
}

impl GroundStation {
    /// A ground station that will upload `mission` to a boat whose time runs `speedup` times as fast as the clock:
    /// who watches its heartbeat on the boat's time must not miss it.
    pub(super) fn new(mission: Mission, speedup: f64) -> Self {
        Self {
            mission,
            client: Client::default(),
            vehicle: None,
            telemetry: Telemetry::default(),
            streams: StreamRequests::new(STREAM_INTERVAL_S),
            task: Task::Finding,
            heartbeat_interval: INTERVAL.div_f64(speedup.max(1.0)),
            last_request: None,
            notes: VecDeque::new(),
        }
    }

    /// Something for the log.
    pub(super) fn poll_note(&mut self) -> Option<String> {
        self.notes.pop_front()
    }

    /// The mission is on board and the boat is armed.
    pub(super) fn is_watching(&self) -> bool {
        matches!(self.task, Task::Watching)
    }

    /// Ends the run: disarms the boat.
    pub(super) fn disarm(&mut self) {
        self.task = Task::Disarming;
        self.last_request = None;
    }

    /// The boat is disarmed.
    pub(super) fn is_done(&self) -> bool {
        matches!(self.task, Task::Ended(None))
    }

    /// Why the run could not be prepared.
    pub(super) fn failure(&self) -> Option<&str> {
        match &self.task {
            Task::Ended(failure) => failure.as_deref(),
            _ => None,
        }
    }

    fn on_message(&mut self, now: Duration, from: Identity, message: &Message) {
        if let Message::HEARTBEAT(heartbeat) = message
            && self.vehicle.is_none()
            && classify(from, heartbeat) == Sender::Boat
        {
            self.vehicle = Some(from);
            self.notes.push_back("ground station: found the boat, uploading the mission".to_owned());
            let exchange = Exchange::with_ardupilot(OWN, from, MissionType::Mission);
            let upload = Upload::new(exchange, &self.mission);
            self.task = Task::Uploading(Box::new(upload));
        }
        if self.vehicle == Some(from) {
            self.streams.on_message(now, helmlink_wire::dialect::MessageSet::message_id(message));
            self.telemetry.on_message(now, message);
            if let Task::Uploading(upload) = &mut self.task {
                upload.on_message(now, from, message);
            }
        }
    }

    fn work(&mut self, now: Duration) {
        self.client.keep_alive(now, self.heartbeat_interval);
        let Some(vehicle) = self.vehicle else { return };
        while let Some(message) = self.streams.poll(now, vehicle) {
            self.client.send(&message);
        }
        match &mut self.task {
            Task::Uploading(upload) => {
                let (message, outcome) = (upload.poll(now), upload.outcome());
                if let Some(message) = message {
                    self.client.send(&message);
                }
                match outcome {
                    Some(Ok(())) => {
                        self.notes.push_back("ground station: mission uploaded, arming the boat".to_owned());
                        self.task = Task::Arming;
                    }
                    Some(Err(error)) => {
                        self.task = Task::Ended(Some(format!("the mission could not be uploaded: {error}")));
                    }
                    None => {}
                }
            }
            Task::Arming if self.telemetry.is_armed() => self.task = Task::Watching,
            Task::Arming if self.telemetry.estimator_is_ready(now) => self.ask_to_arm(now, vehicle, true),
            Task::Disarming if !self.telemetry.is_armed() => self.task = Task::Ended(None),
            Task::Disarming => self.ask_to_arm(now, vehicle, false),
            _ => {}
        }
    }

    fn ask_to_arm(&mut self, now: Duration, vehicle: Identity, arm: bool) {
        if is_due(&mut self.last_request, now, INTERVAL) {
            let params = [f32::from(u8::from(arm)), 0.0, 0.0];
            self.client.send(&command_long(vehicle, enums::MAV_CMD_COMPONENT_ARM_DISARM, params));
        }
    }
}

impl Party for GroundStation {
    fn link_up(&mut self, _now: Duration, link: LinkId, _endpoint: EndpointId) {
        self.client.link_up(link);
    }

    fn link_down(&mut self, _now: Duration, link: LinkId) {
        self.client.link_down(link);
    }

    fn on_bytes(&mut self, now: Duration, _link: LinkId, bytes: &[u8], _is_datagram: bool) {
        self.client.push(bytes);
        while let Some((from, message)) = self.client.next_message() {
            self.on_message(now, from, &message);
        }
        self.work(now);
    }

    fn on_tick(&mut self, now: Duration) {
        self.work(now);
    }

    fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.client.poll_transmit()
    }
}
