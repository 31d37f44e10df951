//! Files and flight controllers together: over sockets, and over radios that lose and spoil what they carry.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::Duration;

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::plan::{Item, Mission, differences};
use helmlink_mission::protocol::MissionType;
use helmlink_mission::track::{TrackSettings, mission_of_track};
use helmlink_sitl::physics::Hull;
use helmlink_sitl::{Sitl, SitlSettings};
use helmlink_wire::LinkId;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

use super::super::edge::{Edge, Party};
use super::super::paced_sitl::{self, PacedSitl};
use super::super::ranges::WaitS;
use super::super::replay::LogFiles;
use super::vehicle::{Session, Task, VehicleArgs, talk};
use super::*;
use crate::link::{Hub, LinkSettings};

const HOME: Geodetic = Geodetic { latitude_deg: 63.44, longitude_deg: 10.4 };
const LINK: LinkId = LinkId(1);

fn common() -> Common {
    Common { quiet: true, ..Common::default() }
}

fn boat() -> Sitl {
    let hull = Hull::builtin("otter").unwrap();
    Sitl::new(SitlSettings { home: HOME, ..SitlSettings::new(hull) }).unwrap()
}

/// A mission of so many items, all of them different.
fn mission(count: usize, seed: f64) -> Mission {
    let frame = LocalFrame::new(HOME);
    let place = |index: usize| NorthEast::new(10.0 + 3.0 * index as f64, seed);
    let items = (0..count).map(|index| Item {
        params: [(index % 7) as f32, 0.0, 0.0, 0.0],
        ..Item::waypoint(frame.to_geodetic(place(index)))
    });
    Mission { home: None, items: items.collect() }
}

#[test]
fn a_mission_goes_up_and_comes_down_over_a_socket() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let mut hub = Hub::new(LinkSettings::default());
        let endpoint = hub.open(&"tcpin:127.0.0.1:0".parse().unwrap()).await.unwrap();
        let address = hub.local_address(endpoint).unwrap();
        let speedup = 20.0;
        let mut edge = Edge::new(PacedSitl::new(boat(), speedup), hub, paced_sitl::tick(speedup));
        let args = VehicleArgs {
            connect: format!("tcp:{address}").parse().unwrap(),
            wait: WaitS::try_from(30.0).unwrap(),
        };
        let sent = mission(12, 5.0);
        let tasks = vec![Task::Send(MissionType::Mission, sent.clone()), Task::Fetch(MissionType::Mission)];
        let common = common();
        let transfer = talk(&args, &common, |vehicle| {
            assert!(!vehicle.armed);
            Ok(tasks)
        });
        let fetched = tokio::select! {
            fetched = transfer => fetched.unwrap(),
            () = async { loop { edge.turn().await; } } => unreachable!(),
        };
        assert_eq!(checksum(&fetched[0].items), checksum(&sent.items));
        let matters = |difference: &plan::Difference| difference.matters;
        assert!(!differences(&sent.items, &fetched[0].items).iter().any(matters));
    });
}

#[test]
fn nobody_there_is_no_link() {
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let connect = format!("udpout:{}", socket.local_addr().unwrap()).parse().unwrap();
    let args = VehicleArgs { connect, wait: WaitS::try_from(0.2).unwrap() };
    let failure = vehicle::converse(&args, &common(), |_| Ok(Vec::new())).unwrap_err();
    assert_eq!(failure.exit_code(), std::process::ExitCode::from(3));
    assert!(failure.to_string().contains("no heartbeat"), "{failure}");
}

/// What a radio does to the bytes it carries.
#[derive(Clone, Copy)]
struct Radio {
    loss: f64,
    corruption: f64,
    copies: f64,
    jitter_s: f64,
    /// From then on nothing gets through.
    breaks_at_s: f64,
}

const BAD: Radio =
    Radio { loss: 0.2, corruption: 0.01, copies: 0.05, jitter_s: 0.2, breaks_at_s: f64::INFINITY };
const GOOD: Radio = Radio { loss: 0.0, corruption: 0.0, copies: 0.0, jitter_s: 0.0, ..BAD };

/// One direction of a radio.
struct Air {
    radio: Radio,
    random: ChaCha8Rng,
    under_way: VecDeque<(Duration, Vec<u8>)>,
}

impl Air {
    fn new(radio: Radio, seed: u64) -> Self {
        Self { radio, random: ChaCha8Rng::seed_from_u64(seed), under_way: VecDeque::new() }
    }

    fn chance(&mut self) -> f64 {
        f64::from(self.random.next_u32()) / f64::from(u32::MAX)
    }

    fn send(&mut self, now: Duration, frame: &[u8]) {
        let copies = 1 + usize::from(self.chance() < self.radio.copies);
        for _ in 0..copies {
            if self.chance() < self.radio.loss || now.as_secs_f64() > self.radio.breaks_at_s {
                continue;
            }
            let mut frame = frame.to_vec();
            if self.chance() < self.radio.corruption {
                let place = self.random.next_u32() as usize % frame.len();
                frame[place] ^= 1 << (self.random.next_u32() % 8);
            }
            let delay = Duration::from_secs_f64(0.01 + self.radio.jitter_s * self.chance());
            self.under_way.push_back((now + delay, frame));
        }
    }

    fn arrived(&mut self, now: Duration) -> Vec<Vec<u8>> {
        let (arrived, rest) = self.under_way.drain(..).partition(|(then, _)| *then <= now);
        self.under_way = rest;
        let arrived: VecDeque<(Duration, Vec<u8>)> = arrived;
        arrived.into_iter().map(|(_, frame)| frame).collect()
    }
}

/// Carries out tasks over a radio; the plans fetched, or why not.
fn transfer(sitl: &mut Sitl, tasks: Vec<Task>, radio: Radio, seed: u64) -> Result<Vec<Mission>, String> {
    let mut session = Session::new();
    session.begin(tasks);
    let link = LinkId(LINK.0 + seed as u32);
    sitl.link_up(link);
    session.join(Duration::ZERO, link);
    let (mut up, mut down) = (Air::new(radio, seed), Air::new(radio, seed + 1000));
    let start = sitl.now();
    // Longer than any transfer may take before it has to say that it failed.
    for tick in 1..120_000u32 {
        let now = Duration::from_millis(10) * tick;
        sitl.advance(start + now);
        while let Some((to, frame)) = sitl.poll_transmit() {
            if to == link {
                down.send(now, &frame);
            }
        }
        for frame in down.arrived(now) {
            session.on_bytes(now, link, &frame, true);
        }
        session.on_tick(now);
        while let Some((_, frame)) = session.poll_transmit() {
            up.send(now, &frame);
        }
        for frame in up.arrived(now) {
            sitl.on_datagram(link, &frame);
        }
        if session.is_done() {
            sitl.link_down(link);
            return session.result();
        }
    }
    panic!("the transfer neither succeeded nor failed");
}

fn on_board(sitl: &mut Sitl) -> Vec<Item> {
    transfer(sitl, vec![Task::Fetch(MissionType::Mission)], GOOD, 900).unwrap().remove(0).items
}

#[test]
fn two_hundred_items_over_a_bad_radio() {
    let new = mission(200, 5.0);
    for seed in 0..3 {
        let mut sitl = boat();
        sitl.set_mission(&mission(7, 0.0).items).unwrap();
        let tasks = vec![Task::Send(MissionType::Mission, new.clone()), Task::Fetch(MissionType::Mission)];
        let fetched = transfer(&mut sitl, tasks, BAD, seed).unwrap();
        assert_eq!(checksum(&fetched[0].items), checksum(&new.items), "seed {seed}");
        assert_eq!(checksum(&on_board(&mut sitl)), checksum(&new.items), "seed {seed}");
    }
}

#[test]
fn a_link_that_breaks_leaves_the_old_mission_alone() {
    let old = mission(7, 0.0);
    for (seed, breaks_at_s) in [(1, 4.0), (2, 9.0), (3, 20.0)] {
        let mut sitl = boat();
        sitl.set_mission(&old.items).unwrap();
        let radio = Radio { breaks_at_s, ..BAD };
        let tasks = vec![Task::Send(MissionType::Mission, mission(200, 5.0))];
        let failure = transfer(&mut sitl, tasks, radio, seed).unwrap_err();
        assert!(failure.contains("silent") || failure.contains("did not answer"), "{failure}");
        assert_eq!(checksum(&on_board(&mut sitl)), checksum(&old.items), "seed {seed}");
    }
}

#[test]
fn the_sample_can_be_checked_and_shown() {
    let sample = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("mission/plans/harbour-survey.plan");
    let plan = plan::read_plan(&sample).unwrap().plan;
    let (boat, speed_mps) = speed_and_boat("otter", None).unwrap();
    let route = Route::from_mission(&plan.mission).unwrap();
    let review = review::review(&route, &plan.fence, &boat, speed_mps);
    assert!((205.0..240.0).contains(&review.length_m), "{}", review.length_m);
    assert!((150.0..400.0).contains(&review.duration_s), "{}", review.duration_s);
    let problem = |finding: &&review::Finding| finding.level == review::Level::Problem;
    assert_eq!(review.findings.iter().find(problem), None);
}

#[test]
fn a_review_names_what_is_awkward() {
    let frame = LocalFrame::new(HOME);
    let at = |north_m: f64, east_m: f64| Item::waypoint(frame.to_geodetic(NorthEast::new(north_m, east_m)));
    let radius = Item { params: [0.0, 0.1, 0.0, 0.0], ..at(60.0, 0.0) };
    let circle = Item { command: 18, params: [1.0, 0.0, 1.0, 0.0], ..at(100.0, 50.0) };
    let items = vec![
        at(20.0, 0.0),
        radius,
        at(60.0, 2.0),
        at(20.0, 2.0),
        Item::change_speed(30.0),
        circle,
        at(0.0, 90.0),
    ];
    let mission = Mission { home: Some(HOME), items };
    let route = Route::from_mission(&mission).unwrap();
    let rock = plan::Outline::circle(frame.to_geodetic(NorthEast::new(40.0, 2.0)), 1.0).unwrap();
    let fence =
        plan::Fence { areas: vec![plan::Area { inclusion: false, outline: rock }], return_point: None };
    let (boat, _) = speed_and_boat("monohull38", None).unwrap();
    let review = review::review(&route, &fence, &boat, 3.0);
    let texts: Vec<String> =
        review.findings.iter().map(|f| format!("{:?} {:?} {}", f.level, f.item, f.text)).collect();
    let says = |item: u16, what: &str| {
        let found = review.findings.iter().any(|f| f.item == Some(item) && f.text.contains(what));
        assert!(found, "item {item}: {what}: {texts:#?}");
    };
    says(2, "needs");
    says(3, "cannot follow this corner");
    says(6, "tighter than this boat's turning circle");
    says(6, "more than this boat makes");
    assert!(texts.iter().any(|text| text.contains("enters area 1 of the fence")), "{texts:#?}");
}

#[test]
fn a_recorded_track_becomes_a_mission() {
    let log = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/ardurover-4.6-motorboat.tlog");
    let log = LogFiles::find(&[log]).unwrap();
    let fixes = from_track::read_track(&log, None).unwrap();
    assert!(fixes.len() > 1500, "{}", fixes.len());
    assert!(fixes.windows(2).all(|pair| pair[0].time_s <= pair[1].time_s));
    let settings = TrackSettings { tolerance_m: 1.0, stop_s: Some(10.0) };
    let made = mission_of_track(&fixes, &settings).unwrap();
    // The boat was driven along 498.8 m by its own simulator's truth, from the first waypoint on, in 115.7 s.
    assert!((480.0..515.0).contains(&made.length_m), "{}", made.length_m);
    assert!((105.0..125.0).contains(&made.duration_s), "{}", made.duration_s);
    assert!(made.deviation_m <= 1.0 && made.mission.items.len() < 60, "{made:?}");
    assert!(Route::from_mission(&made.mission).is_ok());
    assert!(from_track::read_track(&log, Some(77)).unwrap().is_empty());
}
