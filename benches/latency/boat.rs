//! A flight controller that is just real enough to be steered: it obeys at once and knows no inertia.

use std::error::Error;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use helmlink_wire::dialect::{
    ATTITUDE_DATA, CharArray, EKF_STATUS_REPORT_DATA, GLOBAL_POSITION_INT_DATA, HEARTBEAT_DATA, MessageData,
    MessageSet, PARAM_VALUE_DATA, RAW_IMU_DATA, SERVO_OUTPUT_RAW_DATA, SET_ATTITUDE_TARGET_DATA,
    SYS_STATUS_DATA, VFR_HUD_DATA,
};
use helmlink_wire::{Encoder, Frame, Framer, Identity, Message, enums};

use crate::RATE;
use crate::timing::Latencies;

const IDENTITY: Identity = Identity { system: 1, component: 1 };
/// Messages between two positions.
const CYCLE: u32 = RATE / 50;
/// What full thrust means in GUIDED, m/s.
const FULL_SPEED_MPS: f64 = 2.0;
const METRES_PER_DEGREE: f64 = 111_200.0;
const GUIDED: u32 = 15;

pub(crate) struct Boat {
    socket: UdpSocket,
    heard: Receiver<Datagram>,
    bridge: Option<SocketAddr>,
    encoder: Encoder,
    framer: Framer,
    start: Instant,
    /// When the next message is due.
    due: Instant,
    sent: u32,
    north_m: f64,
    east_m: f64,
    heading_rad: f64,
    speed_mps: f64,
    yaw_rate_radps: f64,
    /// When the last position was sent, until it is answered.
    asked: Option<Instant>,
    latencies: Latencies,
}

/// When it came, from whom, and what it says.
type Datagram = (Instant, SocketAddr, Vec<u8>);

/// Tells the echo that it is over.
pub(crate) const GOODBYE: &[u8] = b"goodbye";
/// Asks the echo what it has cost so far.
pub(crate) const HOW_MUCH: &[u8] = b"how much";

/// Whether a datagram is a GLOBAL_POSITION_INT.
pub(crate) fn is_position(datagram: &[u8]) -> bool {
    datagram.get(7..10) == Some(&GLOBAL_POSITION_INT_DATA::ID.to_le_bytes()[..3])
}

impl Boat {
    pub(crate) fn new() -> Result<Self, Box<dyn Error>> {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
        let heard = listen(socket.try_clone()?);
        let now = Instant::now();
        Ok(Self {
            socket,
            heard,
            bridge: None,
            encoder: Encoder::new(),
            framer: Framer::new(),
            start: now,
            due: now,
            sent: 0,
            north_m: 0.0,
            east_m: 0.0,
            heading_rad: 0.0,
            speed_mps: 0.0,
            yaw_rate_radps: 0.0,
            asked: None,
            latencies: Latencies::default(),
        })
    }

    pub(crate) fn port(&self) -> Result<u16, Box<dyn Error>> {
        Ok(self.socket.local_addr()?.port())
    }

    /// Runs until commands come.
    pub(crate) fn wait_until_steered(&mut self) -> Result<(), Box<dyn Error>> {
        for _ in 0..60 {
            if !self.run(Duration::from_secs(1))?.p99_us().is_nan() {
                return Ok(());
            }
        }
        Err("the bridge has not steered within a minute".into())
    }

    /// Sends at the full rate for as long as this; returns how long the answers to positions took.
    pub(crate) fn run(&mut self, span: Duration) -> Result<Latencies, Box<dyn Error>> {
        (self.latencies, self.asked, self.due) = (Latencies::default(), None, Instant::now());
        for _ in 0..(span.as_secs_f64() * f64::from(RATE)) as u32 {
            self.listen_until_due()?;
            self.send_next()?;
        }
        self.due += Duration::from_secs(1) / RATE * CYCLE;
        self.listen_until_due()?;
        Ok(std::mem::take(&mut self.latencies))
    }

    /// Something that is no frame, for the echo.
    pub(crate) fn say(&self, word: &[u8]) -> Result<(), Box<dyn Error>> {
        if let Some(bridge) = self.bridge {
            self.socket.send_to(word, bridge)?;
        }
        Ok(())
    }

    fn listen_until_due(&mut self) -> Result<(), Box<dyn Error>> {
        self.due += Duration::from_secs(1) / RATE;
        loop {
            let left = self.due.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(());
            }
            if let Ok((when, from, datagram)) = self.heard.recv_timeout(left) {
                self.bridge = Some(from);
                self.hear(when, &datagram)?;
            }
        }
    }

    fn hear(&mut self, now: Instant, datagram: &[u8]) -> Result<(), Box<dyn Error>> {
        // What an echo returns: no need to look into it.
        if is_position(datagram) {
            self.answered(now);
            return Ok(());
        }
        let mut heard = Vec::new();
        self.framer.push(datagram);
        self.framer.end_of_datagram();
        while let Some(frame) = self.framer.next_frame() {
            heard.extend(frame.decode());
        }
        for message in heard {
            match message {
                Message::SET_ATTITUDE_TARGET(target) => self.obey(now, &target),
                Message::PARAM_REQUEST_READ(question) => self.tell_parameter(question.param_id)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn obey(&mut self, now: Instant, target: &SET_ATTITUDE_TARGET_DATA) {
        self.answered(now);
        self.speed_mps = f64::from(target.thrust) * FULL_SPEED_MPS;
        self.yaw_rate_radps = f64::from(target.body_yaw_rate);
    }

    fn answered(&mut self, now: Instant) {
        if let Some(then) = self.asked.take() {
            self.latencies.answer(then, now);
        }
    }

    fn tell_parameter(&mut self, name: CharArray<16>) -> Result<(), Box<dyn Error>> {
        let param_value = match name.to_str()? {
            "SYSID_MYGCS" => 255.0,
            "WP_SPEED" | "CRUISE_SPEED" => FULL_SPEED_MPS as f32,
            "RCMAP_ROLL" => 1.0,
            "RCMAP_THROTTLE" => 3.0,
            "RC1_MIN" | "RC3_MIN" => 1100.0,
            "RC1_TRIM" | "RC3_TRIM" => 1500.0,
            "RC1_MAX" | "RC3_MAX" => 1900.0,
            _ => 0.0,
        };
        let value = PARAM_VALUE_DATA {
            param_id: name,
            param_value,
            param_type: enums::MAV_PARAM_TYPE_REAL32,
            param_index: u16::MAX,
            param_count: 1000,
        };
        self.send(&Message::PARAM_VALUE(value))
    }

    fn send_next(&mut self) -> Result<(), Box<dyn Error>> {
        let time_boot_ms = self.start.elapsed().as_millis() as u32;
        let number = self.sent;
        self.sent += 1;
        let message = match (number % RATE, number % CYCLE) {
            (13, _) => heartbeat(),
            (15, _) => Message::EKF_STATUS_REPORT(EKF_STATUS_REPORT_DATA {
                flags: 831,
                ..EKF_STATUS_REPORT_DATA::DEFAULT
            }),
            (17, _) => {
                Message::SYS_STATUS(SYS_STATUS_DATA { voltage_battery: 12_600, ..SYS_STATUS_DATA::DEFAULT })
            }
            (_, 0) => self.attitude(time_boot_ms),
            (_, 1) => {
                self.move_on();
                self.position(time_boot_ms)
            }
            (_, 2..6) => {
                Message::VFR_HUD(VFR_HUD_DATA { groundspeed: self.speed_mps as f32, ..VFR_HUD_DATA::DEFAULT })
            }
            (_, 6..11) => Message::SERVO_OUTPUT_RAW(SERVO_OUTPUT_RAW_DATA {
                servo1_raw: 1500,
                ..SERVO_OUTPUT_RAW_DATA::DEFAULT
            }),
            _ => Message::RAW_IMU(RAW_IMU_DATA { zacc: -981, ..RAW_IMU_DATA::DEFAULT }),
        };
        if message.message_id() == GLOBAL_POSITION_INT_DATA::ID {
            self.latencies.question();
            // One that was never answered stays out of the quantiles and shows in the count.
            self.asked = Some(Instant::now());
        }
        self.send(&message)
    }

    fn send(&mut self, message: &Message) -> Result<(), Box<dyn Error>> {
        if let Some(bridge) = self.bridge {
            let mut frame = Vec::with_capacity(64);
            self.encoder.encode(IDENTITY, message, &mut frame);
            debug_assert!(Frame::parse(&frame).is_ok());
            self.socket.send_to(&frame, bridge)?;
        }
        Ok(())
    }

    fn move_on(&mut self) {
        let interval_s = f64::from(CYCLE) / f64::from(RATE);
        self.heading_rad += self.yaw_rate_radps * interval_s;
        self.north_m += self.speed_mps * self.heading_rad.cos() * interval_s;
        self.east_m += self.speed_mps * self.heading_rad.sin() * interval_s;
    }

    fn attitude(&self, time_boot_ms: u32) -> Message {
        let yaw = self.heading_rad.sin().atan2(self.heading_rad.cos()) as f32;
        let yawspeed = self.yaw_rate_radps as f32;
        Message::ATTITUDE(ATTITUDE_DATA { time_boot_ms, yaw, yawspeed, ..ATTITUDE_DATA::DEFAULT })
    }

    fn position(&self, time_boot_ms: u32) -> Message {
        let latitude_deg: f64 = 63.4389;
        let east_degree_m = METRES_PER_DEGREE * latitude_deg.to_radians().cos();
        Message::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
            time_boot_ms,
            lat: ((latitude_deg + self.north_m / METRES_PER_DEGREE) * 1e7) as i32,
            lon: ((10.399 + self.east_m / east_degree_m) * 1e7) as i32,
            vx: (100.0 * self.speed_mps * self.heading_rad.cos()) as i16,
            vy: (100.0 * self.speed_mps * self.heading_rad.sin()) as i16,
            ..GLOBAL_POSITION_INT_DATA::DEFAULT
        })
    }
}

/// Receives on a thread of its own, so that what comes is timed by its arrival and not by the next message due.
/// It ends with the process.
fn listen(socket: UdpSocket) -> Receiver<Datagram> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let mut buffer = [0; 2048];
        while let Ok((count, from)) = socket.recv_from(&mut buffer) {
            if sender.send((Instant::now(), from, buffer[..count].to_vec())).is_err() {
                break;
            }
        }
    });
    receiver
}

fn heartbeat() -> Message {
    Message::HEARTBEAT(HEARTBEAT_DATA {
        mavtype: enums::MAV_TYPE_SURFACE_BOAT,
        autopilot: enums::MAV_AUTOPILOT_ARDUPILOTMEGA,
        base_mode: enums::MAV_MODE_FLAG_SAFETY_ARMED | enums::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
        custom_mode: GUIDED,
        system_status: enums::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    })
}
