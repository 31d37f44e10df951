use helmlink_wire::Message;
use helmlink_wire::dialect::{PARAM_SET_DATA, SET_MODE_DATA};
use helmlink_wire::enums::EKF_POS_HORIZ_ABS;

use super::*;
use crate::autopilot::modes::Mode;
use crate::autopilot::testing::{Bench, GCS, LINK, OTHER_LINK};
use crate::faults::FaultError;

fn every_fault() -> Vec<Fault> {
    [
        "link-loss=30",
        "link-delay=200,50",
        "link-duplicate=5",
        "link-reorder=10",
        "link-corrupt=1",
        "gps-loss",
        "gps-freeze",
        "gps-jump=20,-5",
        "gps-drift=0.5,0.25",
        "compass-offset=15",
        "rudder-stuck",
        "rudder-stuck=-0.25",
        "rudder-weak=0.5",
        "thruster-stuck",
        "thruster-weak=0.5",
        "ekf-failure",
    ]
    .map(|text| text.parse().unwrap())
    .to_vec()
}

#[test]
fn every_lasting_fault_changes_the_world_and_lifting_it_restores_it() {
    for fault in every_fault() {
        let mut bench = Bench::with_hull("skiff");
        let world = |bench: &Bench| {
            let autopilot = &bench.autopilot;
            (autopilot.vessel_faults(), autopilot.link_weather(), autopilot.has_failed_estimator())
        };
        let sound = world(&bench);
        bench.inject(fault).unwrap();
        assert_ne!(world(&bench), sound, "{fault}");
        bench.lift(&fault);
        assert_eq!(world(&bench), sound, "{fault}");
    }
}

#[test]
fn a_jump_in_metres_arrives_as_a_jump_in_metres() {
    let mut bench = Bench::ready();
    bench.inject(Fault::GpsJump { north_m: 20.0, east_m: -5.0 }).unwrap();
    let jump_m = bench.autopilot.vessel_faults().gps.jump_m;
    assert!((jump_m.north - 20.0).abs() < 0.01 && (jump_m.east + 5.0).abs() < 0.01, "{jump_m:?}");
    bench.run_s(1.0);
    assert!((bench.autopilot.motion().position.north_m - 20.0).abs() < 0.01);
}

#[test]
fn a_boat_without_the_part_refuses_the_fault() {
    let mut bench = Bench::ready();
    let refused = bench.inject(Fault::RudderStuck { at: None }).unwrap_err();
    assert!(matches!(refused, FaultError::NoSuchPart { .. }));
    assert!(refused.to_string().contains("otter has no rudder"), "{refused}");
    let mut skiff = Bench::with_hull("skiff");
    assert!(skiff.inject(Fault::ThrusterWeak { which: Thrusters::Right, share: 0.0 }).is_err());
    assert!(skiff.inject(Fault::LinkLoss { share: 1.5 }).is_err());
}

#[test]
fn ground_stations_inject_faults_by_parameter() {
    let mut bench = Bench::ready();
    let set = |value: f32| {
        Message::PARAM_SET(PARAM_SET_DATA {
            param_value: value,
            target_system: 1,
            target_component: 1,
            param_id: "SIM_GPS_DISABLE".into(),
            param_type: 9,
        })
    };
    bench.send(LINK, GCS, &set(1.0));
    bench.run_s(0.1);
    assert!(!bench.autopilot.has_position());
    bench.send(LINK, GCS, &set(0.0));
    bench.run_s(0.1);
    assert!(bench.autopilot.has_position());
}

#[test]
fn scheduled_faults_come_and_go() {
    let mut bench = Bench::ready();
    bench.schedule("gps-loss@5..7".parse().unwrap()).unwrap();
    bench.run_until(Duration::from_millis(4_900));
    assert!(bench.autopilot.has_position());
    bench.run_until(Duration::from_millis(6_000));
    assert!(!bench.autopilot.has_position());
    bench.run_until(Duration::from_millis(7_200));
    assert!(bench.autopilot.has_position());
}

fn heartbeats(messages: &[Message]) -> usize {
    messages.iter().filter(|message| matches!(message, Message::HEARTBEAT(_))).count()
}

#[test]
fn a_dead_link_is_silent_both_ways_and_recovers() {
    let mut bench = Bench::ready();
    bench.autopilot.parameters.put(SIM_LNK_NUMBER, LINK.0 as f32);
    bench.inject(Fault::LinkLoss { share: 1.0 }).unwrap();
    bench.run_loops(1);
    bench.send(
        LINK,
        GCS,
        &Message::SET_MODE(SET_MODE_DATA {
            custom_mode: Mode::Hold.number(),
            target_system: 1,
            base_mode: 1,
        }),
    );
    let sent = bench.run_s(5.0);
    assert!(sent[&LINK].is_empty());
    assert_eq!(heartbeats(&sent[&OTHER_LINK]), 5, "the other link is as good as ever");
    assert_eq!(bench.autopilot.mode, Mode::Manual);
    bench.lift(&Fault::LinkLoss { share: 0.0 });
    assert_eq!(heartbeats(&bench.run_s(5.0)[&LINK]), 5);
}

#[test]
fn an_outage_ends_by_itself() {
    let mut bench = Bench::ready();
    bench.autopilot.parameters.put(SIM_LNK_OUTAGE, 4.0);
    bench.run_loops(2);
    assert!(bench.run_s(3.9)[&LINK].is_empty());
    assert_eq!(heartbeats(&bench.run_s(3.2)[&LINK]), 3);
}

#[test]
fn late_messages_still_all_arrive() {
    let mut bench = Bench::ready();
    bench.inject("link-delay=500,300".parse().unwrap()).unwrap();
    bench.run_s(1.0);
    assert_eq!(heartbeats(&bench.run_s(10.0)[&LINK]), 10);
    bench.lift(&"link-delay=0".parse().unwrap());
    bench.run_s(1.0);
    assert_eq!(heartbeats(&bench.run_s(10.0)[&LINK]), 10);
}

#[test]
fn a_failed_estimator_shows_and_ends_in_hold() {
    let mut bench = Bench::ready();
    bench.arm();
    bench.autopilot.enter_mode(Mode::Loiter).unwrap();
    bench.inject(Fault::EkfFailure).unwrap();
    let sent = bench.run_s(3.0);
    assert_eq!(bench.autopilot.mode, Mode::Hold);
    let flags = sent[&LINK].iter().rev().find_map(|message| match message {
        Message::EKF_STATUS_REPORT(data) => Some((data.flags, data.pos_horiz_variance)),
        _ => None,
    });
    let (flags, variance) = flags.unwrap();
    assert!(flags & EKF_POS_HORIZ_ABS == 0 && variance > 1.0);
}

#[test]
fn a_reboot_disarms_falls_silent_and_comes_back() {
    let mut bench = Bench::ready();
    bench.arm();
    bench.run_loops(1);
    bench.inject(Fault::Reboot).unwrap();
    let silent = bench.run_s(0.9);
    assert!(!bench.is_armed());
    assert!(silent[&LINK].is_empty(), "{:?}", silent[&LINK].len());
    let sent = bench.run_s(3.0);
    assert!(heartbeats(&sent[&LINK]) >= 2);
    assert!(Bench::texts(&sent).contains(&"ArduPilot Ready".to_owned()));
    let modes = sent[&LINK].iter().filter_map(|message| match message {
        Message::HEARTBEAT(data) => Some(data.custom_mode),
        _ => None,
    });
    let modes: Vec<u32> = modes.collect();
    assert_eq!((modes.first(), modes.last()), (Some(&16), Some(&Mode::Manual.number())));
    assert_eq!(bench.autopilot.parameters.int(SIM_REBOOT), 0, "once is enough");
}

#[test]
fn a_low_battery_is_low() {
    let mut bench = Bench::ready();
    bench.inject(Fault::LowBattery { percent: 12.0 }).unwrap();
    let sent = bench.run_s(2.0);
    let left = sent[&LINK].iter().rev().find_map(|message| match message {
        Message::SYS_STATUS(data) => Some(data.battery_remaining),
        _ => None,
    });
    assert!((11..=12).contains(&left.unwrap()), "{left:?}");
}
