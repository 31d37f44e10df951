use super::*;
use crate::physics::SeaState;
use crate::scenario::Scenario;

fn packet(frame: u32, rate: u16, steering_us: u16, throttle_us: u16, outputs: usize) -> Vec<u8> {
    let magic: u16 = if outputs == 16 { 18_458 } else { 29_569 };
    let mut bytes = Vec::new();
    bytes.extend(magic.to_le_bytes());
    bytes.extend(rate.to_le_bytes());
    bytes.extend(frame.to_le_bytes());
    for output in 1..=outputs {
        let pulse: u16 = match output {
            1 => steering_us,
            3 => throttle_us,
            _ => 0,
        };
        bytes.extend(pulse.to_le_bytes());
    }
    bytes
}

/// Frame 7 at 1200 Hz, output 1 at 1500 µs and output 3 at 1600 µs, as the compiler lays out ArduPilot's
/// `struct servo_packet` (`libraries/SITL/SIM_JSON.h`; `libraries/SITL/examples/JSON/readme.md`): written down by
/// hand from the declaration, and the same as its pybullet example unpacks with `HHI16H`.
const SIXTEEN: &str = "1a48b00407000000\
                       dc050000400600000000000000000000\
                       00000000000000000000000000000000";
/// The same with SERVO_32_ENABLE = 1.
const THIRTY_TWO: &str = "8173b00407000000\
                          dc050000400600000000000000000000\
                          00000000000000000000000000000000\
                          00000000000000000000000000000000\
                          00000000000000000000000000000000";

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect()
}

#[test]
fn packets_are_read_as_ardupilots_structures_lie_in_memory() {
    for (hex, outputs) in [(SIXTEEN, 16), (THIRTY_TWO, 32)] {
        let read = ServoPacket::parse(&bytes(hex)).unwrap();
        assert_eq!((read.frame_rate_hz, read.frame, read.pulses_us.len()), (1200, 7, outputs));
        assert_eq!(read.pulses_us[..4], [1500, 0, 1600, 0]);
        assert_eq!(bytes(hex), packet(7, 1200, 1500, 1600, outputs));
    }
}

#[test]
fn faults_of_the_hull_happen_and_others_are_refused() {
    let timed = |text: &str| text.parse().unwrap();
    let mut boat = boat("skiff", &Sea::default());
    boat.schedule(timed("rudder-stuck=1@5..20")).unwrap();
    for (fault, hint) in [
        ("gps-loss", "ArduPilot's own"),
        ("link-loss=10", "ArduPilot's own"),
        ("thruster-weak=0.5,right", "no right thruster"),
    ] {
        let refused = boat.schedule(timed(fault)).unwrap_err().to_string();
        assert!(refused.contains(hint), "{refused}");
    }
    let yaw_rate = |boat: &mut ArduPilotPhysics, frames: std::ops::Range<u32>| {
        for frame in frames {
            boat.on_packet(&packet(frame, 50, 1500, 1700, 16)).unwrap();
        }
        boat.truth().hull.r_radps
    };
    assert_eq!(yaw_rate(&mut boat, 0..250), 0.0);
    assert!(yaw_rate(&mut boat, 250..900) > 0.1);
    assert!(yaw_rate(&mut boat, 900..2500).abs() < 0.02);
    // ArduPilot starts anew, and so do the faults.
    assert_eq!(yaw_rate(&mut boat, 0..250), 0.0);
    assert!(yaw_rate(&mut boat, 250..900) > 0.1);
}

#[test]
fn scenarios_of_hull_and_sea_are_played_and_others_refused() {
    let scenario =
        |text: &str| Scenario::from_toml(&format!("name = \"x\"\nduration_s = 20\n{text}")).unwrap();
    let mut boat = boat("skiff", &Sea::default());
    for (text, hint) in [
        ("[[event]]\nat_s = 1\naction = \"mode HOLD\"", "orders mode HOLD at 1 s"),
        ("[[event]]\nat_s = 1\nparameter = \"WP_SPEED=1\"", "sets the parameter WP_SPEED"),
        ("[[event]]\nat_s = 1\nfault = \"ekf-failure\"", "ArduPilot's own"),
        ("[[expect]]\nquantity = \"battery_percent\"\nabove = 1", "looks at battery_percent"),
    ] {
        let refused = boat.play(scenario(text)).unwrap_err().to_string();
        assert!(refused.contains(hint), "{refused}");
    }
    boat.play(scenario(
        "clock = \"armed\"\n[[event]]\nat_s = 5\ncurrent = \"0.5@90\"\n\
         [[expect]]\nquantity = \"east_m\"\nabove = 2\nafter_s = 20\n\
         [[expect]]\nquantity = \"speed_mps\"\nabove = 90\nwithin_s = 9",
    ))
    .unwrap();
    for frame in 0..100 {
        boat.on_packet(&packet(frame, 50, 1500, 1500, 16)).unwrap();
    }
    // Nobody has used the throttle yet.
    assert!(boat.verdicts().iter().all(|verdict| verdict.passed.is_none()));
    for frame in 100..1110 {
        boat.on_packet(&packet(frame, 50, 1500, 1700, 16)).unwrap();
    }
    assert!(boat.is_scenario_over());
    let passed: Vec<_> = boat.verdicts().iter().map(|verdict| verdict.passed).collect();
    assert_eq!(passed, [Some(true), Some(false)]);
}

fn boat(name: &str, sea: &Sea) -> ArduPilotPhysics {
    ArduPilotPhysics::new(Hull::builtin(name).unwrap(), sea, 1, 0.0)
}

/// ArduPilot's reader, as strict as the original (`libraries/SITL/SIM_JSON.cpp`): the last whole line; keys are
/// substrings, sought in the order of its table; the value stands right behind `":`.
struct Reader<'a>(&'a str);

impl<'a> Reader<'a> {
    fn new(answer: &'a str) -> Self {
        let end = answer.rfind('\n').expect("a line end");
        let start = answer[..end].rfind('\n').expect("a line end before");
        Self(&answer[start + 1..end])
    }

    fn value(&self, section: &str, key: &str) -> &'a str {
        let section_at = self.0.find(section).expect(section);
        let rest = &self.0[section_at + section.len()..];
        let key_at = rest.find(key).expect(key);
        &rest[key_at + key.len() + 2..]
    }

    fn number(&self, section: &str, key: &str) -> f64 {
        let text = self.value(section, key);
        let end = text.find([',', '}', ']']).unwrap();
        text[..end].parse().expect(key)
    }

    /// `sscanf(p, "[%f, %f, %f]")`.
    fn vector(&self, section: &str, key: &str) -> [f64; 3] {
        let text = self.value(section, key).strip_prefix('[').expect("no space before the bracket");
        let mut parts =
            text[..text.find(']').unwrap()].split(',').map(|part| part.trim_start().parse::<f64>());
        std::array::from_fn(|_| parts.next().unwrap().expect(key))
    }
}

#[test]
fn at_rest_gravity_is_all_that_is_felt() {
    let mut boat = boat("otter", &Sea::default());
    for outputs in [16, 32] {
        let (kind, answer) = boat.on_packet(&packet(0, 1200, 1500, 1500, outputs)).unwrap();
        assert!(matches!(kind, PacketKind::Reset | PacketKind::Repeated));
        let reader = Reader::new(&answer);
        assert_eq!(reader.vector("imu", "gyro"), [0.0; 3]);
        assert_eq!(reader.vector("imu", "accel_body"), [0.0, 0.0, -9.81]);
        assert_eq!(reader.vector("", "position"), [0.0; 3]);
        assert_eq!(reader.vector("", "velocity"), [0.0; 3]);
        assert_eq!(reader.vector("", "attitude"), [0.0; 3]);
        assert!((reader.number("", "timestamp") - 1.0 / 1200.0).abs() < 1e-9);
        assert_eq!(reader.number("windvane", "speed"), 0.0);
        assert!(!answer.contains(": ") && !answer.contains("NaN"));
    }
}

#[test]
fn integrating_what_is_felt_gives_where_the_boat_is() {
    for (name, pulses_us) in [("otter", (1720, 1750)), ("skiff", (1580, 1750)), ("motorboat", (1580, 1750))] {
        let hull = Hull::builtin(name).unwrap();
        let mut boat = boat(name, &Sea::preset(SeaState::Slight, &hull));
        let (mut velocity, mut place, mut yaw) = ([0.0; 3], [0.0; 3], 0.0);
        let rate = 400;
        for frame in 0..20 * u32::from(rate) {
            let (_, answer) = boat.on_packet(&packet(frame, rate, pulses_us.0, pulses_us.1, 16)).unwrap();
            let reader = Reader::new(&answer);
            let dt_s = 1.0 / f64::from(rate);
            let attitude = reader.vector("", "attitude");
            if frame < 10 {
                (velocity, place) = (reader.vector("", "velocity"), reader.vector("", "position"));
                yaw = attitude[2];
                continue;
            }
            let felt = reader.vector("imu", "accel_body");
            let (sy, cy) = attitude[2].sin_cos();
            // Roll and pitch are small: their part in the horizontal force is gravity's.
            let ahead = felt[0] - 9.81 * attitude[1].sin();
            let aside = felt[1] + 9.81 * attitude[0].sin() * attitude[1].cos();
            velocity[0] += dt_s * (ahead * cy - aside * sy);
            velocity[1] += dt_s * (ahead * sy + aside * cy);
            place[0] += dt_s * velocity[0];
            place[1] += dt_s * velocity[1];
            yaw += dt_s * reader.vector("imu", "gyro")[2];
            let (told, heading) = (reader.vector("", "position"), attitude[2]);
            let off_m = (told[0] - place[0]).hypot(told[1] - place[1]);
            let travelled_m = told[0].hypot(told[1]);
            assert!(off_m < 0.05 + 0.05 * travelled_m, "{name}, frame {frame}: {off_m} m");
            let turn = (heading - yaw + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU);
            assert!((turn - std::f64::consts::PI).abs() < 0.1, "{name}: {heading} against {yaw}");
        }
        assert!(boat.truth().hull.u_mps > 0.5, "{name}");
    }
}

#[test]
fn repeated_packets_get_the_same_answer_and_no_time_passes() {
    let mut boat = boat("skiff", &Sea::default());
    for frame in 0..100 {
        boat.on_packet(&packet(frame, 50, 1500, 1800, 16)).unwrap();
    }
    let (kind, first) = boat.on_packet(&packet(100, 50, 1500, 1800, 16)).unwrap();
    assert_eq!(kind, PacketKind::Next);
    let (kind, again) = boat.on_packet(&packet(100, 50, 1500, 1800, 16)).unwrap();
    assert_eq!((kind, again), (PacketKind::Repeated, first));
}

#[test]
fn lost_packets_are_made_up_for_and_a_restart_begins_anew() {
    let mut boat = boat("skiff", &Sea::default());
    let time_s = |answer: &str| Reader::new(answer).number("", "timestamp");
    for frame in 0..10 {
        boat.on_packet(&packet(frame, 50, 1500, 1800, 16)).unwrap();
    }
    let (kind, answer) = boat.on_packet(&packet(13, 50, 1500, 1800, 16)).unwrap();
    assert_eq!(kind, PacketKind::AfterLoss(3));
    assert!((time_s(&answer) - 14.0 * 0.02).abs() < 1e-9, "{answer}");
    let (kind, answer) = boat.on_packet(&packet(0, 50, 1500, 1500, 16)).unwrap();
    assert_eq!(kind, PacketKind::Reset);
    assert!((time_s(&answer) - 0.02).abs() < 1e-9);
    assert_eq!(Reader::new(&answer).vector("", "position"), [0.0; 3]);
}

#[test]
fn the_current_waits_until_the_throttle_is_used() {
    let sea = Sea { current: Some("0.5@90".parse().unwrap()), ..Sea::default() };
    let mut boat = boat("otter", &sea);
    let mut frame = 0;
    let mut run = |boat: &mut ArduPilotPhysics, seconds: u32, left: u16, right: u16| {
        for _ in 0..seconds * 50 {
            boat.on_packet(&packet(frame, 50, left, right, 16)).unwrap();
            frame += 1;
        }
        boat.truth().hull.east_m
    };
    assert_eq!(run(&mut boat, 30, 1500, 1500), 0.0);
    run(&mut boat, 1, 1600, 1600);
    assert!(run(&mut boat, 30, 1500, 1500) > 10.0);
}

#[test]
fn other_datagrams_are_refused() {
    let mut boat = boat("otter", &Sea::default());
    for size in [0, 1, 39, 41, 71, 73, 1400] {
        let refused = boat.on_packet(&vec![0; size]).unwrap_err();
        assert_eq!(refused, PacketFault::Size { bytes: size });
    }
    let refused = boat.on_packet(&[0; 40]).unwrap_err();
    assert!(refused.to_string().contains("18458"), "{refused}");
    let mut swapped = packet(0, 50, 1500, 1500, 16);
    swapped[..2].copy_from_slice(&29_569u16.to_le_bytes());
    assert!(boat.on_packet(&swapped).is_err());
}

#[test]
fn any_rate_and_any_pulses_give_finite_answers() {
    let mut boat = boat("skiff", &Sea::default());
    for (frame, rate, pulse) in
        [(0, 0, 0), (1, 1, 65535), (2, 65535, 1), (3, 50, 2000), (u32::MAX, 400, 1500)]
    {
        let (_, answer) = boat.on_packet(&packet(frame, rate, pulse, pulse, 32)).unwrap();
        let reader = Reader::new(&answer);
        for (section, key) in [("imu", "gyro"), ("imu", "accel_body"), ("", "position"), ("", "velocity")] {
            assert!(reader.vector(section, key).iter().all(|value| value.is_finite()), "{answer}");
        }
    }
}
