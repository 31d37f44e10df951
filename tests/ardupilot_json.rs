//! `helmlink sitl --ardupilot-json` against an imitation of ArduPilot's end of the line: its loop, its buffer and its
//! parser, as strict as the original (ArduPilot, `libraries/SITL/SIM_JSON.h` and `SIM_JSON.cpp`,
//! `libraries/SITL/examples/JSON/readme.md`).

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::net::UdpSocket;

use support::Helmlink;
use support::process::PATIENCE;

/// What ArduPilot seeks: section, key, whether three numbers, whether it must be there.
const KEYS: [(&str, &str, bool, bool); 9] = [
    ("", "timestamp", false, true),
    ("imu", "gyro", true, true),
    ("imu", "accel_body", true, true),
    ("", "position", true, true),
    ("", "attitude", true, true),
    ("", "velocity", true, true),
    ("windvane", "direction", false, false),
    ("windvane", "speed", false, false),
    ("", "airspeed", false, false),
];
/// A timestamp this much later or more does not let ArduPilot's time advance, s.
const LONGEST_STEP_S: f64 = 0.1;

/// ArduPilot's end.
struct ArduPilot {
    socket: UdpSocket,
    outputs: usize,
    rate_hz: u16,
    frame_counter: u32,
    last_timestamp_s: f64,
    /// Steps in which its time advanced, and how often it found the physics reset.
    advanced: u32,
    resets: u32,
    values: Vec<[f64; 3]>,
}

impl ArduPilot {
    fn start(physics: &str, outputs: usize) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(physics).unwrap();
        socket.set_read_timeout(Some(PATIENCE)).unwrap();
        let (rate_hz, values) = (50, vec![[0.0; 3]; KEYS.len()]);
        let (frame_counter, advanced, resets) = (0, 0, 0);
        Self { socket, outputs, rate_hz, frame_counter, last_timestamp_s: 0.0, advanced, resets, values }
    }

    /// `struct servo_packet`.
    fn output_servos(&self, steering_us: u16, throttle_us: u16) {
        let magic: u16 = if self.outputs == 16 { 18_458 } else { 29_569 };
        let mut packet = [&magic.to_le_bytes()[..], &self.rate_hz.to_le_bytes()].concat();
        packet.extend(self.frame_counter.to_le_bytes());
        let pulses = [steering_us, 0, throttle_us];
        let pulse = |output: usize| pulses.get(output).copied().unwrap_or(0);
        (0..self.outputs).for_each(|output| packet.extend(pulse(output).to_le_bytes()));
        assert_eq!(self.socket.send(&packet).unwrap(), packet.len());
    }

    /// Line ends become zeroes; the row lies between the last two.
    fn recv_fdm(&mut self) {
        let mut buffer = [0; 65_000];
        let length = self.socket.recv(&mut buffer).expect("an answer to every packet");
        let text = std::str::from_utf8(&buffer[..length]).unwrap();
        let end = text.rfind('\n').expect("ends with a line end");
        let start = text[..end].rfind('\n').expect("starts with a line end");
        self.parse_sensors(&text[start + 1..end]);
        let timestamp_s = self.values[0][0];
        if timestamp_s < self.last_timestamp_s {
            self.resets += 1;
        } else if (f64::MIN_POSITIVE..LONGEST_STEP_S).contains(&(timestamp_s - self.last_timestamp_s)) {
            self.advanced += 1;
        }
        self.last_timestamp_s = timestamp_s;
        self.frame_counter += 1;
    }

    /// Substrings all the way; the value stands two characters behind the key, and three numbers start with their
    /// bracket right there.
    fn parse_sensors(&mut self, json: &str) {
        for ((section, key, three, required), value) in KEYS.iter().zip(&mut self.values) {
            let found = json.find(section).and_then(|at| {
                let rest = json.get(at + section.len() + 1..)?;
                rest.get(rest.find(key)? + key.len() + 2..)
            });
            match found {
                None => assert!(!required, "Failed to find key {section}/{key} in {json}"),
                Some(text) if *three => {
                    let numbers = text
                        .strip_prefix('[')
                        .unwrap_or_else(|| panic!("Failed to parse Vector3f for {section}/{key} in {json}"));
                    let mut numbers = numbers[..numbers.find(']').unwrap()].split(',');
                    *value = std::array::from_fn(|_| numbers.next().unwrap().trim_start().parse().unwrap());
                }
                Some(text) => {
                    let end = text.find([',', '}']).unwrap();
                    value[0] = text[..end].trim_start().parse().unwrap();
                }
            }
        }
    }

    fn update(&mut self, steering_us: u16, throttle_us: u16) {
        self.output_servos(steering_us, throttle_us);
        self.recv_fdm();
    }

    fn value(&self, key: &str) -> [f64; 3] {
        self.values[KEYS.iter().position(|(_, known, ..)| *known == key).unwrap()]
    }
}

/// The physics on a free port, and its address.
fn physics(arguments: &[&str]) -> (Helmlink, String) {
    let physics =
        Helmlink::start(&[&["sitl", "--json", "--ardupilot-json", "127.0.0.1:0"], arguments].concat());
    let line = physics.wait_for_line("\"ardupilot_json\"");
    let said: serde_json::Value = serde_json::from_str(&line).unwrap();
    let address = said["ardupilot_json"].as_str().unwrap().to_owned();
    (physics, address)
}

#[test]
fn ardupilot_drives_with_16_and_32_outputs_in_lockstep_and_starts_anew() {
    let (_physics, address) = physics(&["--boat", "skiff", "--sea", "slight"]);
    for outputs in [16, 32, 16] {
        // Each one counts its frames from 0 again, on another port.
        let mut ardupilot = ArduPilot::start(&address, outputs);
        ardupilot.update(1500, 1500);
        assert!((ardupilot.value("timestamp")[0] - 0.02).abs() < 1e-9, "the boat is back at its start");
        (1..500).for_each(|_| ardupilot.update(1500, 1700));
        assert_eq!((ardupilot.advanced, ardupilot.resets), (500, 0));
        assert!((ardupilot.value("timestamp")[0] - 10.0).abs() < 1e-6);
        assert!(ardupilot.value("position")[0] > 5.0, "{:?}", ardupilot.value("position"));
        assert!((ardupilot.value("accel_body")[2] + 9.81).abs() < 3.0);
        // The answer got lost: the same frame again gets the same answer, and no time passes.
        ardupilot.update(1500, 1700);
        let position = ardupilot.value("position");
        ardupilot.frame_counter -= 1;
        ardupilot.update(1500, 1700);
        assert_eq!((ardupilot.value("position"), ardupilot.advanced, ardupilot.resets), (position, 501, 0));
        // At another rate.
        ardupilot.rate_hz = 1200;
        (0..1200).for_each(|_| ardupilot.update(1500, 1700));
        assert!((ardupilot.value("timestamp")[0] - 11.02).abs() < 1e-6);
    }
}

#[test]
fn faults_and_scenarios_of_hull_and_sea_happen_behind_ardupilot() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("ardupilot-json.toml");
    let expectation =
        "name = \"x\"\nduration_s = 8\n[[expect]]\nquantity = \"heading_deg\"\nabove = 20\nwithin_s = 8\n";
    std::fs::write(&folder, expectation).unwrap();
    let scenario = folder.to_str().unwrap();
    for (arguments, exit_code) in [
        (&["--boat", "skiff", "--fault", "rudder-stuck=0.5@2", "--scenario", scenario][..], 0),
        (&["--boat", "skiff", "--scenario", scenario], 1),
    ] {
        let (physics, address) = physics(arguments);
        let mut ardupilot = ArduPilot::start(&address, 16);
        (0..401).for_each(|_| ardupilot.update(1500, 1700));
        let ended = physics.into_process().wait();
        assert_eq!(ended.status.code(), Some(exit_code), "{}", ended.printed);
    }
    for (arguments, hint) in
        [(["--fault", "gps-loss"], "ArduPilot's own"), (["--scenario", "gps-loss"], "gps-loss")]
    {
        let ended = Helmlink::run(&[&["sitl", "--ardupilot-json", "127.0.0.1:0"][..], &arguments].concat());
        assert_eq!(ended.status.code(), Some(2), "{}", ended.printed);
        assert!(ended.printed.contains(hint) && ended.printed.lines().count() == 1, "{}", ended.printed);
    }
}
