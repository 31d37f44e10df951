//! Logs of other tools' making: a recorded run of ArduRover, whole, damaged, out of order, played.

use std::io::Cursor;
use std::time::Duration;

use helmlink_wire::dialect::HEARTBEAT_DATA;
use helmlink_wire::signing::{Signing, SigningKey, Timestamp};
use helmlink_wire::tlog::{Index, TlogWriter, records};
use helmlink_wire::{Encoder, Frame, Identity, Message};

use super::explain::explain;
use super::export::rows::{RowFormat, Rows};
use super::export::{Export, Exporting};
use super::picture::{PictureSink, Side};
use super::play::{PlayFilter, PlaySettings, Player, message_id};
use super::reorder::Ordered;
use super::scan::Scan;
use super::what_if::{Sink, WhatIf, WhatIfResult, WhatIfSettings, Window};
use crate::control::{Boat, Controller};
use crate::vehicle::OutputKind;

/// Recorded at ten times real time: nine mission items are uploaded, eight waypoints reached.
const LOG: &[u8] = include_bytes!("../../tests/data/ardurover-4.6-motorboat.tlog");

fn settings(boat: &str) -> WhatIfSettings {
    WhatIfSettings {
        boat: Boat::embedded(boat).unwrap(),
        controller: Controller::default(),
        output: OutputKind::RcOverride,
        speed_mps: None,
        mission: None,
        window: Window::Driven,
        ground_station_system: 255,
    }
}

fn replay(log: &[u8], settings: WhatIfSettings, sink: &mut impl Sink) -> (WhatIfResult, Vec<String>) {
    let scan = Scan::of(log).unwrap();
    let vehicle = scan.vehicle(None).unwrap();
    let interval_s = scan.vehicles[&vehicle].interval_s();
    let mut what_if = WhatIf::new(settings, vehicle, interval_s, scan.missions.clone(), &scan.parameters);
    let mut log = Ordered::new(log, scan.disordered > 0);
    while log
        .next(|time_us, frame| {
            if let Ok(message) = frame.decode() {
                what_if.on_message(time_us, frame.identity(), &message, sink);
            }
        })
        .unwrap()
    {}
    what_if.finish()
}

#[test]
fn the_mission_and_the_clock_come_from_the_log_itself() {
    let scan = Scan::of(LOG).unwrap();
    let vehicle = scan.vehicle(None).unwrap();
    let summary = &scan.vehicles[&vehicle];
    assert_eq!((scan.records, vehicle.system, summary.reached), (17_732, 1, 8));
    assert!(summary.is_simulated && (summary.rate() - 10.0).abs() < 0.5, "{}", summary.rate());
    assert_eq!(scan.missions.len(), 1);
    assert_eq!(scan.missions[0].mission.items.len(), 8);
    assert!(scan.missions[0].mission.home.is_some() || scan.missions[0].from.system == 255);
    let words = explain(&scan, vehicle).join("\n");
    assert!(words.contains("× real time") && words.contains("the vehicle's time is used"), "{words}");
}

#[test]
fn the_recorded_run_goes_through_the_controller_to_its_end() {
    let mut picture = PictureSink::new(Side::Replayed);
    let (result, faults) = replay(LOG, settings("motorboat"), &mut picture);
    assert!(faults.is_empty(), "{faults:?}");
    assert_eq!((result.waypoints, result.reached_recorded), (8, 8));
    assert!(result.reached_replayed >= 7, "{result:?}");
    assert!(result.steps > 1000 && result.driven_s > 60.0, "{result:?}");
    assert_eq!(result.commands, result.steps);
    let driven = result.recorded.unwrap();
    assert!(driven.distance_m > 200.0 && driven.cross_track_straight_m.unwrap().rms < 3.0, "{driven:?}");
    let difference = result.difference.unwrap();
    // Two controllers on the same states. Each has its own way round the corners, and one that only listens there
    // steers against the turn that the other makes early: so nothing is said of their correlation.
    assert!(difference.samples > 500 && difference.steering_rms < 0.2, "{difference:?}");
    assert!(difference.throttle_rms < 0.2, "{difference:?}");
    assert!(picture.panels()[0].curves[1].readings.len() > 500);
}

#[test]
fn the_same_log_gives_the_same_commands_even_out_of_order() {
    let (straight, _) = replay(LOG, settings("motorboat"), &mut PictureSink::new(Side::Replayed));
    let mut all: Vec<_> = records(LOG).collect();
    for pair in all.chunks_exact_mut(7) {
        pair.reverse();
    }
    let mut writer = TlogWriter::new(Vec::new());
    for record in &all {
        writer.write(record.time_us, &record.frame).unwrap();
    }
    let shuffled = writer.into_inner();
    assert!(Scan::of(shuffled.as_slice()).unwrap().disordered > 1000);
    let (again, _) = replay(&shuffled, settings("motorboat"), &mut PictureSink::new(Side::Replayed));
    // Records of the same stamp cannot be told apart, so a step or two may differ; the run is the same.
    assert!(again.steps.abs_diff(straight.steps) <= straight.steps / 50);
    assert_eq!((again.reached_recorded, again.waypoints), (8, 8));
}

#[test]
fn a_damaged_log_still_runs_to_its_end_and_says_so() {
    let mut log = LOG[..LOG.len() - 1234].to_vec();
    for place in (5000..log.len()).step_by(9973) {
        log[place] ^= 0x55;
    }
    let scan = Scan::of(log.as_slice()).unwrap();
    let words = explain(&scan, scan.vehicle(None).unwrap()).join("\n");
    assert!(words.contains("damaged"), "{words}");
    let (result, _) = replay(&log, settings("motorboat"), &mut PictureSink::new(Side::Replayed));
    assert!(result.steps > 1000, "{result:?}");
}

#[test]
fn another_boat_and_another_controller_command_otherwise() {
    let digest = |settings: WhatIfSettings| {
        replay(LOG, settings, &mut PictureSink::new(Side::Replayed)).0.commands_sha256
    };
    let own = digest(settings("motorboat"));
    assert_eq!(own, digest(settings("motorboat")));
    assert_ne!(own, digest(settings("skiff")));
    assert_ne!(own, digest(WhatIfSettings { controller: Controller::Pid, ..settings("motorboat") }));
}

#[test]
fn every_step_is_a_row() {
    let mut csv = Rows::new(Vec::new(), RowFormat::Csv);
    csv.finish().unwrap();
    struct Count(u64);
    impl Export for Count {
        fn moment(&mut self, _: &super::what_if::Moment) -> std::io::Result<()> {
            self.0 += 1;
            if self.0 > 3 { Err(std::io::Error::other("full")) } else { Ok(()) }
        }
        fn command(&mut self, _: u64, _: &[u8]) -> std::io::Result<()> {
            Ok(())
        }
        fn event(&mut self, _: u64, _: &str) -> std::io::Result<()> {
            Ok(())
        }
        fn finish(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let mut failing = Exporting::new("a.csv".to_owned(), Box::new(Count(0)));
    replay(LOG, settings("motorboat"), &mut failing);
    assert_eq!(failing.finish().unwrap_err().0, "a.csv", "the first error ends a file, not the replay");
}

fn player(settings: PlaySettings) -> Player<Cursor<&'static [u8]>> {
    let index = Index::build(LOG).unwrap();
    Player::new(Cursor::new(LOG), index, settings, Duration::ZERO).unwrap()
}

fn play_settings() -> PlaySettings {
    PlaySettings {
        speedup: 1.0,
        from_s: 0.0,
        until_s: None,
        looped: false,
        filter: PlayFilter { commands: true, ..PlayFilter::default() },
        rebase_us: None,
    }
}

/// Plays to the end in steps of ten milliseconds; the frames and when the last one came, seconds.
fn played(player: &mut Player<Cursor<&'static [u8]>>, limit_s: u64) -> (Vec<Vec<u8>>, f64) {
    let (mut frames, mut last_s) = (Vec::new(), 0.0);
    for hundredth in 0..limit_s * 100 {
        let now = Duration::from_millis(hundredth * 10);
        while let Some(frame) = player.poll(now).unwrap() {
            frames.push(frame);
            last_s = now.as_secs_f64();
        }
        if player.is_ended() {
            break;
        }
    }
    (frames, last_s)
}

#[test]
fn a_log_is_played_byte_for_byte_at_its_pace() {
    let (frames, last_s) = played(&mut player(play_settings()), 60);
    let recorded: Vec<&[u8]> = records(LOG).map(|record| record.frame.bytes()).collect();
    assert_eq!(frames, recorded);
    assert!((last_s - 16.85).abs() < 0.05, "{last_s}");
    let (_, fast_s) = played(&mut player(PlaySettings { speedup: 4.0, ..play_settings() }), 60);
    assert!((fast_s - last_s / 4.0).abs() < 0.05, "{fast_s}");
}

#[test]
fn parts_and_kinds_of_a_log_are_played_and_commands_only_when_asked_for() {
    let attitude = message_id("attitude").unwrap();
    assert_eq!((attitude, message_id("30"), message_id("NO_SUCH")), (30, Some(30), None));
    let filter = PlayFilter { only: vec![attitude], ..PlayFilter::default() };
    let part = PlaySettings { from_s: 5.0, until_s: Some(10.0), filter, ..play_settings() };
    let (frames, last_s) = played(&mut player(part), 60);
    assert!(frames.len() > 700 && frames.len() < 1300, "{}", frames.len());
    assert!((last_s - 5.0).abs() < 0.05);
    let without = PlaySettings { filter: PlayFilter::default(), ..play_settings() };
    let (frames, _) = played(&mut player(without), 60);
    for frame in &frames {
        let name = Frame::parse(frame).unwrap().name().unwrap();
        assert!(!["COMMAND_LONG", "MISSION_ITEM_INT", "PARAM_SET"].contains(&name), "{name}");
    }
    assert!(frames.len() > 17_000);
}

#[test]
fn a_player_pauses_seeks_and_loops() {
    let mut player = player(PlaySettings { until_s: Some(2.0), looped: true, ..play_settings() });
    let second = Duration::from_secs(1);
    player.set_paused(second, true);
    assert!((player.position_s(10 * second) - 1.0).abs() < 1e-9);
    player.set_paused(10 * second, false);
    player.seek(10 * second, 1.5).unwrap();
    assert!((player.position_s(10 * second) - 1.5).abs() < 1e-9);
    let mut count = 0;
    for tenth in 100..200_u32 {
        while player.poll(tenth * second / 10).unwrap().is_some() {
            count += 1;
        }
    }
    let first_two_s = records(LOG).take_while(|record| record.time_us <= 1_795_422_929_539_027).count();
    assert!(!player.is_ended() && count > 3 * first_two_s, "{count} of {first_two_s} each time");
}

/// A log of three systems: MAVLink 2, MAVLink 1, a signed frame and one of an unknown dialect, ten of each, a tenth of a
/// second apart.
fn mixed_log() -> (Vec<u8>, Vec<Vec<u8>>) {
    let beat = Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT);
    let mut encoder = Encoder::new();
    let mut signer = Signing::new(SigningKey::from_passphrase("mixed"), Timestamp::from_units(1));
    let unknown = [0xFD, 3, 0, 0, 1, 4, 1, 0xFF, 0xFF, 0x7F, 0xFD, 0xFE, 0xFD, 0x12, 0x34];
    let (mut log, mut frames) = (Vec::new(), Vec::new());
    for round in 0..10 {
        let mut of_round = [Vec::new(), Vec::new(), Vec::new(), unknown.to_vec()];
        encoder.encode(Identity { system: 1, component: 1 }, &beat, &mut of_round[0]);
        encoder.encode_v1(Identity { system: 2, component: 1 }, &beat, &mut of_round[1]).unwrap();
        encoder.encode(Identity { system: 3, component: 1 }, &beat, &mut of_round[2]);
        signer.sign(0, &mut of_round[2], 0);
        for (part, frame) in (0..).zip(of_round) {
            log.extend((1_795_000_000_000_000 + 100_000 * (4 * round + part) as u64).to_be_bytes());
            log.extend(&frame);
            frames.push(frame);
        }
    }
    (log, frames)
}

fn played_of(log: &'static [u8], filter: PlayFilter) -> Vec<Vec<u8>> {
    let settings = PlaySettings { filter, ..play_settings() };
    let index = Index::build(log).unwrap();
    let mut player = Player::new(Cursor::new(log), index, settings, Duration::ZERO).unwrap();
    played(&mut player, 60).0
}

#[test]
fn frames_of_every_version_signed_and_of_unknown_dialects_are_played_as_they_are() {
    let (log, frames) = mixed_log();
    let log: &'static [u8] = Box::leak(log.into_boxed_slice());
    assert!(Frame::parse(&frames[2]).unwrap().is_signed());
    let with_commands = PlayFilter { commands: true, ..PlayFilter::default() };
    // A log ends with the last frame that is known.
    assert_eq!(played_of(log, with_commands.clone()), frames[..39]);
    let of_two = played_of(log, PlayFilter { systems: vec![2, 3], ..with_commands });
    assert_eq!(of_two.len(), 20);
    assert!(of_two.iter().all(|frame| [2, 3].contains(&Frame::parse(frame).unwrap().identity().system)));
    // Nobody knows what an unknown message asks of a boat.
    assert_eq!(played_of(log, PlayFilter::default()).len(), 30);
}
