//! Radios that lose, delay, double and damage what they carry.

use std::time::Duration;

use helmlink_mission::protocol::MissionType;
use helmlink_sitl::faults::{Fault, TimedFault};

use super::rig::*;
use crate::pilot::supervisor::State;
use crate::simulation::RunRecorder;
use crate::vehicle::OutputKind;

/// A fifth lost, up to 200 ms late in any order, one in a hundred damaged, one in fifty doubled.
const BAD_RADIO: [Fault; 4] = [
    Fault::LinkLoss { share: 0.2 },
    Fault::LinkDelay { delay_s: 0.0, jitter_s: 0.2 },
    Fault::LinkCorruption { share: 0.01 },
    Fault::LinkDuplication { share: 0.02 },
];

fn spoil(rig: &mut Rig) {
    for fault in BAD_RADIO {
        rig.sitl.inject(fault).unwrap();
    }
}

/// Lanes of 20 m, as many as make this number of waypoints.
fn lanes(count: usize) -> Vec<(f64, f64)> {
    let far_end = |index: usize| if matches!(index % 4, 1 | 2) { 100.0 } else { 20.0 };
    (0..count).map(|index| (far_end(index), 20.0 * (index / 2) as f64)).collect()
}

#[test]
fn a_long_mission_comes_whole_over_a_bad_radio() {
    for seed in 0..8 {
        let setup = Setup { waypoints: lanes(200), seed, ..Setup::new(OutputKind::RcOverride, true) };
        let mut rig = Rig::new(setup, |_| {});
        spoil(&mut rig);
        let has_it = |rig: &Rig| rig.bridge.as_ref().and_then(|bridge| bridge.run()).is_some();
        assert!(rig.run_until(300.0, has_it), "seed {seed}: {:?}", rig.texts());
        let run = rig.bridge().run().unwrap();
        let places: Vec<_> = run.route().waypoints.iter().map(|waypoint| waypoint.position).collect();
        for (found, (north_m, east_m)) in places.iter().zip(lanes(200)) {
            assert!(found.distance_m(place(north_m, east_m)) < 0.1, "seed {seed}");
        }
        assert_eq!(places.len(), 200, "seed {seed}");
    }
}

#[test]
fn a_mission_sent_over_a_bad_radio_arrives_whole_or_not_at_all_and_the_old_one_is_driven_until_then() {
    for seed in 0..4 {
        let mut rig = Rig::under_way(Setup { seed, ..Setup::new(OutputKind::RcOverride, true) }, |_| {});
        spoil(&mut rig);
        let longer = lanes(200);
        let is_known = |count: usize| count == 2 || count == 200;
        let result = rig.try_to_upload(MissionType::Mission, items(&longer), |rig| {
            let run = rig.bridge.as_ref().and_then(|bridge| bridge.run());
            assert!(
                run.is_none_or(|run| is_known(run.route().waypoints.len())),
                "seed {seed}: half a mission"
            );
        });
        let driven = |rig: &Rig| {
            let run = rig.bridge.as_ref().and_then(|bridge| bridge.run());
            run.map_or(0, |run| run.route().waypoints.len())
        };
        let expected = if result.is_ok() { 200 } else { 2 };
        assert!(rig.run_until(300.0, |rig| driven(rig) == expected), "seed {seed}: {:?}", rig.texts());
    }
}

#[test]
fn another_ground_station_s_upload_is_waited_for_no_longer_than_it_takes() {
    let mut rig = Rig::under_way(Setup::new(OutputKind::RcOverride, true), |_| {});
    rig.upload(MissionType::Mission, items(&lanes(120)));
    let uploaded_at = rig.now;
    let driven = |rig: &Rig| {
        let run = rig.bridge.as_ref().and_then(|bridge| bridge.run());
        run.map_or(0, |run| run.route().waypoints.len())
    };
    assert!(rig.run_until(20.0, |rig| driven(rig) == 120), "{:?}", rig.texts());
    let after_s = (rig.now - uploaded_at).as_secs_f64();
    println!("a mission of 120 items is driven {after_s:.1} s after its upload");
    // Read at 20 ms an item, twice that with the answer's way, and one retry.
    assert!(after_s < 8.0, "{after_s} s: {:?}", rig.texts());
}

/// Root mean square distance from the mission's legs, metres, and whether the mission was completed.
fn survey(spoil: impl FnOnce(&mut Rig)) -> (f64, bool) {
    let waypoints = vec![(20.0, 0.0), (100.0, 0.0), (100.0, 25.0), (20.0, 25.0), (20.0, 50.0), (100.0, 50.0)];
    let setup = Setup { waypoints, ..Setup::new(OutputKind::RcOverride, true) };
    let mut rig = Rig::under_way(setup, |_| {});
    spoil(&mut rig);
    let mut recorder = RunRecorder::new(HOME);
    for step in 0..30_000_u32 {
        rig.step();
        if step % 5 == 0 {
            let time_s = rig.now.as_secs_f64();
            recorder.sample(time_s, &rig.sitl, rig.bridge.as_ref().unwrap());
        }
        if rig.state() == State::Finished {
            break;
        }
    }
    let rms_m =
        recorder.score().and_then(|score| score.cross_track_m).map_or(f64::INFINITY, |spread| spread.rms);
    (rms_m, rig.state() == State::Finished)
}

#[test]
fn a_bad_link_and_a_bad_sky_at_most_double_the_distance_from_the_track() {
    let (clean_m, _) = survey(|_| {});
    let (spoilt_m, completed) = survey(|rig| {
        rig.sitl.inject(Fault::LinkLoss { share: 0.2 }).unwrap();
        rig.sitl.inject(Fault::LinkDelay { delay_s: 0.2, jitter_s: 0.0 }).unwrap();
        for minute in 0..8 {
            let from = Duration::from_secs(30 + 40 * minute);
            let until = Some(from + Duration::from_secs(2));
            let fault = TimedFault { fault: Fault::GpsLoss, from, until };
            rig.sitl.schedule(fault).unwrap();
        }
    });
    println!("off the track: {clean_m:.3} m rms clean, {spoilt_m:.3} m rms spoilt");
    assert!(completed);
    assert!(spoilt_m <= 2.0 * clean_m, "{clean_m} m clean, {spoilt_m} m spoilt");
}
