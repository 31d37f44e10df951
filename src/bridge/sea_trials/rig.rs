//! A bridge, a simulated boat and a ground station, with a line between them that can be tampered with.

use std::time::Duration;

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::plan::{Item, Mission};
use helmlink_mission::protocol::MissionType;
use helmlink_mission::protocol::client::{Exchange, TransferError, Upload};
use helmlink_sitl::physics::Hull;
use helmlink_sitl::{AutopilotSettings, Sitl, SitlSettings};
use helmlink_wire::dialect::{CharArray, HEARTBEAT_DATA, PARAM_SET_DATA};
use helmlink_wire::{Encoder, Framer, Identity, LinkId, Message, enums};

use crate::bridge::{Bridge, BridgeSettings, Event};
use crate::control::Boat;
use crate::pilot::supervisor::{Request, State};
use crate::vehicle::streams::{command_long, set_mode};
use crate::vehicle::{Mode, OutputKind};

const LOOP: Duration = Duration::from_millis(20);
pub(super) const TO_BRIDGE: LinkId = LinkId(1);
const TO_STATION: LinkId = LinkId(2);
/// The ground station's own link to the bridge, where there is one.
pub(super) const DIRECT: LinkId = LinkId(3);
pub(super) const VEHICLE: Identity = Identity { system: 1, component: 1 };
pub(super) const BRIDGE: Identity = Identity { system: 1, component: 191 };
pub(super) const STATION: Identity = Identity { system: 255, component: 190 };
pub(super) const HOME: Geodetic = Geodetic { latitude_deg: 63.4406, longitude_deg: 10.4022 };

/// Changes a message on its way to the bridge; false drops it.
pub(super) type Tamper = Box<dyn FnMut(&mut Message) -> bool>;

/// A steering frame that the bridge has sent.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sent {
    pub(super) at: Duration,
    pub(super) message: Message,
}

/// All parties.
pub(super) struct Rig {
    pub(super) sitl: Sitl,
    pub(super) bridge: Option<Bridge>,
    pub(super) settings: BridgeSettings,
    recorded: bool,
    pub(super) now: Duration,
    /// Nothing gets through between bridge and boat.
    pub(super) cut: bool,
    pub(super) tamper: Option<Tamper>,
    /// The boat's link as the bridge sees it.
    pub(super) line: LinkId,
    pub(super) steering: Vec<Sent>,
    pub(super) events: Vec<(Duration, Event)>,
    /// The ground station sends its heartbeat.
    pub(super) station_talks: bool,
    /// What the ground station has heard since it was last taken.
    pub(super) heard: Vec<(Identity, Message)>,
    /// What the ground station has heard on its own link to the bridge.
    pub(super) heard_directly: Vec<(Identity, Message)>,
    pub(super) mode: Mode,
    pub(super) servos_us: [u16; 2],
    framers: [Framer; 4],
    encoders: [Encoder; 3],
    last_heartbeat: Option<Duration>,
}

/// How a rig is set up.
pub(super) struct Setup {
    pub(super) output: OutputKind,
    pub(super) receiver: bool,
    pub(super) hull: &'static str,
    pub(super) waypoints: Vec<(f64, f64)>,
    pub(super) parameters: Vec<(String, f32)>,
    /// The bridge keeps a journal.
    pub(super) recorded: bool,
    /// Of everything random in the simulator.
    pub(super) seed: u64,
}

impl Setup {
    pub(super) fn new(output: OutputKind, receiver: bool) -> Self {
        // Without a receiver the boat can only be armed with the throttle failsafe off, as a real one.
        let parameters = if receiver { vec![] } else { vec![("FS_THR_ENABLE".to_owned(), 0.0)] };
        let waypoints = vec![(20.0, 0.0), (600.0, 0.0)];
        Self { output, receiver, hull: "otter", waypoints, parameters, recorded: false, seed: 1 }
    }

    pub(super) fn recorded(output: OutputKind) -> Self {
        Self { recorded: true, ..Self::new(output, true) }
    }
}

pub(super) fn place(north_m: f64, east_m: f64) -> Geodetic {
    LocalFrame::new(HOME).to_geodetic(NorthEast::new(north_m, east_m))
}

pub(super) fn items(points: &[(f64, f64)]) -> Vec<Item> {
    points.iter().map(|&(north_m, east_m)| Item::waypoint(place(north_m, east_m))).collect()
}

impl Rig {
    pub(super) fn new(setup: Setup, change: impl FnOnce(&mut BridgeSettings)) -> Self {
        let mut settings = SitlSettings::new(Hull::builtin(setup.hull).unwrap());
        settings.home = HOME;
        settings.seed = setup.seed;
        settings.autopilot = AutopilotSettings {
            has_rc_receiver: setup.receiver,
            parameters: setup.parameters,
            ..AutopilotSettings::default()
        };
        let mut sitl = Sitl::new(settings).unwrap();
        sitl.set_mission(&items(&setup.waypoints)).unwrap();
        sitl.link_up(TO_BRIDGE);
        sitl.link_up(TO_STATION);
        let boat = Boat::embedded(setup.hull).unwrap();
        let speed_mps = Some(boat.limits.cruise_mps);
        let mut settings = BridgeSettings { output: setup.output, speed_mps, ..BridgeSettings::new(boat) };
        change(&mut settings);
        let mut rig = Self {
            sitl,
            bridge: None,
            settings,
            recorded: setup.recorded,
            now: Duration::ZERO,
            cut: false,
            tamper: None,
            line: TO_BRIDGE,
            steering: Vec::new(),
            events: Vec::new(),
            station_talks: true,
            heard: Vec::new(),
            heard_directly: Vec::new(),
            mode: Mode(u32::MAX),
            servos_us: [0; 2],
            framers: std::array::from_fn(|_| Framer::new()),
            encoders: std::array::from_fn(|_| Encoder::new()),
            last_heartbeat: None,
        };
        rig.start_bridge();
        rig
    }

    /// Starts a bridge, as after a restart of the companion.
    pub(super) fn start_bridge(&mut self) {
        let mut bridge = Bridge::new(self.settings.clone());
        if self.recorded {
            bridge.keep_journal(0);
        }
        bridge.link_up(self.now, TO_BRIDGE);
        self.bridge = Some(bridge);
    }

    pub(super) fn bridge(&mut self) -> &mut Bridge {
        self.bridge.as_mut().unwrap()
    }

    pub(super) fn state(&self) -> State {
        self.bridge.as_ref().unwrap().status().state
    }

    /// Lets time pass.
    pub(super) fn run(&mut self, seconds: f64) {
        let until = self.now + Duration::from_secs_f64(seconds);
        while self.now < until {
            self.step();
        }
    }

    /// Lets time pass until something is so; false if it does not come about in time.
    pub(super) fn run_until(&mut self, limit_s: f64, mut is_so: impl FnMut(&Self) -> bool) -> bool {
        let until = self.now + Duration::from_secs_f64(limit_s);
        while self.now < until {
            self.step();
            if is_so(self) {
                return true;
            }
        }
        false
    }

    /// Armed, and driving for a while.
    pub(super) fn under_way(setup: Setup, change: impl FnOnce(&mut BridgeSettings)) -> Self {
        let mut rig = Self::new(setup, change);
        rig.arm_and_engage();
        rig.run(3.0);
        assert_eq!(rig.state(), State::Engaged, "{:?}", rig.texts());
        rig
    }

    pub(super) fn arm_and_engage(&mut self) {
        assert!(self.run_until(10.0, |rig| rig.state() == State::Ready), "{:?}", self.texts());
        self.say(&command_long(VEHICLE, enums::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]));
        assert!(self.run_until(3.0, |rig| rig.sitl.is_armed()), "{:?}", self.texts());
        self.run(0.2);
        let now = self.now;
        self.bridge().request(now, Request::Engage { patient: false }).unwrap();
        assert!(self.run_until(3.0, |rig| rig.state() == State::Engaged), "{:?}", self.texts());
    }

    /// The ground station says something, on its own link to the boat.
    pub(super) fn say(&mut self, message: &Message) {
        let mut bytes = Vec::new();
        self.encoders[0].encode(STATION, message, &mut bytes);
        self.sitl.on_bytes(TO_STATION, &bytes);
    }

    /// The ground station says something on its own link to the bridge.
    pub(super) fn say_directly(&mut self, message: &Message) {
        self.say_directly_as(STATION, message);
    }

    /// Somebody says something there.
    pub(super) fn say_directly_as(&mut self, who: Identity, message: &Message) {
        let mut bytes = Vec::new();
        self.encoders[2].encode(who, message, &mut bytes);
        let now = self.now;
        self.bridge().on_bytes(now, DIRECT, &bytes, true);
    }

    /// The ground station sets a parameter of the flight controller.
    pub(super) fn set_parameter(&mut self, name: &str, param_value: f32) {
        self.say(&Message::PARAM_SET(PARAM_SET_DATA {
            param_id: CharArray::from(name),
            param_value,
            param_type: enums::MAV_PARAM_TYPE_INT16,
            target_system: VEHICLE.system,
            target_component: VEHICLE.component,
        }));
    }

    pub(super) fn choose(&mut self, mode: Mode) {
        self.say(&set_mode(VEHICLE, mode));
    }

    /// The ground station uploads a plan.
    pub(super) fn upload(&mut self, mission_type: MissionType, items: Vec<Item>) {
        assert_eq!(self.try_to_upload(mission_type, items, |_| {}).err(), None);
    }

    /// The same, looking at all parties at every step.
    pub(super) fn try_to_upload(
        &mut self,
        mission_type: MissionType,
        items: Vec<Item>,
        mut look: impl FnMut(&Self),
    ) -> Result<(), TransferError> {
        let exchange = Exchange::with_ardupilot(STATION, VEHICLE, mission_type);
        let mut upload = Upload::new(exchange, &Mission { home: None, items });
        while upload.outcome().is_none() {
            if let Some(message) = upload.poll(self.now) {
                self.say(&message);
            }
            self.heard.clear();
            self.step();
            look(self);
            for (from, message) in std::mem::take(&mut self.heard) {
                upload.on_message(self.now, from, &message);
            }
        }
        upload.outcome().unwrap()
    }

    pub(super) fn texts(&self) -> Vec<&str> {
        self.events.iter().map(|(_, event)| event.text.as_str()).collect()
    }

    pub(super) fn step(&mut self) {
        self.now += LOOP;
        if self.station_talks
            && self.last_heartbeat.is_none_or(|then| self.now - then >= Duration::from_secs(1))
        {
            self.last_heartbeat = Some(self.now);
            self.say(&Message::HEARTBEAT(HEARTBEAT_DATA {
                mavtype: enums::MAV_TYPE_GCS,
                autopilot: enums::MAV_AUTOPILOT_INVALID,
                ..HEARTBEAT_DATA::DEFAULT
            }));
        }
        self.sitl.advance(self.now);
        while let Some((link, bytes)) = self.sitl.poll_transmit() {
            match link {
                TO_BRIDGE => self.tell_bridge(&bytes),
                _ => self.tell_station(&bytes),
            }
        }
        self.turn_bridge();
    }

    fn turn_bridge(&mut self) {
        let Some(bridge) = &mut self.bridge else { return };
        bridge.on_tick(self.now);
        while let Some((link, bytes)) = bridge.poll_transmit() {
            if link == DIRECT {
                self.framers[3].push(&bytes);
                while let Some(frame) = self.framers[3].next_frame() {
                    self.heard_directly
                        .extend(frame.decode().ok().map(|message| (frame.identity(), message)));
                }
                continue;
            }
            self.framers[1].push(&bytes);
            while let Some(frame) = self.framers[1].next_frame() {
                let message = frame.decode().unwrap();
                if is_steering(&message) {
                    self.steering.push(Sent { at: self.now, message });
                }
            }
            if !self.cut && link == self.line {
                self.sitl.on_bytes(TO_BRIDGE, &bytes);
            }
        }
        while let Some(event) = bridge.poll_event() {
            self.events.push((self.now, event));
        }
    }

    fn tell_bridge(&mut self, bytes: &[u8]) {
        let Some(bridge) = self.bridge.as_mut().filter(|_| !self.cut) else { return };
        let Some(tamper) = &mut self.tamper else {
            return bridge.on_bytes(self.now, self.line, bytes, false);
        };
        self.framers[0].push(bytes);
        while let Some(frame) = self.framers[0].next_frame() {
            let Ok(mut message) = frame.decode() else { continue };
            if tamper(&mut message) {
                let mut changed = Vec::new();
                self.encoders[1].encode(frame.identity(), &message, &mut changed);
                bridge.on_bytes(self.now, self.line, &changed, false);
            }
        }
    }

    fn tell_station(&mut self, bytes: &[u8]) {
        self.framers[2].push(bytes);
        while let Some(frame) = self.framers[2].next_frame() {
            let Ok(message) = frame.decode() else { continue };
            match &message {
                Message::HEARTBEAT(data) if frame.identity() == VEHICLE => self.mode = Mode(data.custom_mode),
                Message::SERVO_OUTPUT_RAW(data) => self.servos_us = [data.servo1_raw, data.servo3_raw],
                _ => {}
            }
            self.heard.push((frame.identity(), message));
        }
    }
}

pub(super) fn is_steering(message: &Message) -> bool {
    matches!(
        message,
        Message::RC_CHANNELS_OVERRIDE(_)
            | Message::MANUAL_CONTROL(_)
            | Message::SET_ATTITUDE_TARGET(_)
            | Message::SET_POSITION_TARGET_LOCAL_NED(_)
    )
}

/// The frame lets go of the boat.
pub(super) fn is_release(message: &Message) -> bool {
    matches!(message, Message::RC_CHANNELS_OVERRIDE(data) if (data.chan1_raw, data.chan3_raw) == (0, 0))
}

/// The frame asks for no thrust.
pub(super) fn is_neutral(message: &Message) -> bool {
    match message {
        Message::RC_CHANNELS_OVERRIDE(data) => data.chan3_raw == 1500,
        Message::MANUAL_CONTROL(data) => data.z == 0,
        Message::SET_ATTITUDE_TARGET(data) => data.thrust == 0.0,
        Message::SET_POSITION_TARGET_LOCAL_NED(data) => data.vx == 0.0,
        _ => false,
    }
}
