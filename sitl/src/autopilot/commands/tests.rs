use proptest::prelude::*;

use super::*;
use crate::autopilot::testing::{Bench, COMPANION, GCS, LINK, OTHER_LINK};

fn long(command: u16, params: [f32; 7]) -> Message {
    let [param1, param2, param3, param4, param5, param6, param7] = params;
    Message::COMMAND_LONG(COMMAND_LONG_DATA {
        param1,
        param2,
        param3,
        param4,
        param5,
        param6,
        param7,
        command,
        target_system: 1,
        target_component: 1,
        confirmation: 0,
    })
}

fn simple(command: u16, param1: f32, param2: f32) -> Message {
    long(command, [param1, param2, 0.0, 0.0, 0.0, 0.0, 0.0])
}

fn int(command: u16, params: [f32; 4], x: i32, y: i32, frame: u8) -> Message {
    let [param1, param2, param3, param4] = params;
    Message::COMMAND_INT(COMMAND_INT_DATA {
        param1,
        param2,
        param3,
        param4,
        x,
        y,
        command,
        target_system: 1,
        target_component: 1,
        frame,
        ..COMMAND_INT_DATA::DEFAULT
    })
}

fn acks(messages: &[Message]) -> Vec<COMMAND_ACK_DATA> {
    let ack = |message: &Message| match message {
        Message::COMMAND_ACK(data) => Some(data.clone()),
        _ => None,
    };
    messages.iter().filter_map(ack).collect()
}

/// The result of a command, and the messages that came with it.
fn result(bench: &mut Bench, command: &Message) -> (u8, Vec<Message>) {
    bench.send(LINK, GCS, command);
    let mut sent = bench.run_loops(1);
    let acks = acks(&sent[&LINK]);
    assert_eq!(acks.len(), 1, "{command:?}");
    assert_eq!((acks[0].target_system, acks[0].target_component), (GCS.system, GCS.component));
    (acks[0].result, sent.remove(&LINK).unwrap())
}

#[test]
fn results_are_those_measured_on_ardurover() {
    let mut bench = Bench::ready();
    for (command, param1, param2, expected) in [
        (MAV_CMD_COMPONENT_ARM_DISARM, 2.0, 0.0, MAV_RESULT_UNSUPPORTED),
        (MAV_CMD_COMPONENT_ARM_DISARM, f32::NAN, 0.0, MAV_RESULT_UNSUPPORTED),
        (MAV_CMD_DO_SET_MODE, 1.0, 4.0, MAV_RESULT_ACCEPTED),
        (MAV_CMD_DO_SET_MODE, 129.0, 0.0, MAV_RESULT_ACCEPTED),
        (MAV_CMD_DO_SET_MODE, 0.0, 4.0, MAV_RESULT_DENIED),
        (MAV_CMD_DO_SET_MODE, 1.0, 99.0, MAV_RESULT_FAILED),
        (MAV_CMD_DO_SET_MODE, 1.0, 6.0, MAV_RESULT_FAILED),
        (MAV_CMD_DO_SET_MODE, 1.0, f32::NAN, MAV_RESULT_FAILED),
        (MAV_CMD_MISSION_START, 0.0, 0.0, MAV_RESULT_FAILED),
        (MAV_CMD_DO_PAUSE_CONTINUE, 0.0, 0.0, MAV_RESULT_UNSUPPORTED),
        (MAV_CMD_NAV_TAKEOFF, 0.0, 0.0, MAV_RESULT_UNSUPPORTED),
        (MAV_CMD_NAV_LAND, 0.0, 0.0, MAV_RESULT_UNSUPPORTED),
        (9999, 0.0, 0.0, MAV_RESULT_UNSUPPORTED),
        (MAV_CMD_DO_SET_SERVO, 1.0, 1600.0, MAV_RESULT_FAILED),
        (MAV_CMD_DO_SET_SERVO, 9.0, 1600.0, MAV_RESULT_ACCEPTED),
        (MAV_CMD_REQUEST_MESSAGE, 435.0, 0.0, MAV_RESULT_FAILED),
        (MAV_CMD_REQUEST_MESSAGE, 397.0, 0.0, MAV_RESULT_FAILED),
        (MAV_CMD_SET_MESSAGE_INTERVAL, 230.0, 1e6, MAV_RESULT_DENIED),
        (MAV_CMD_SET_MESSAGE_INTERVAL, 30.0, f32::NAN, MAV_RESULT_ACCEPTED),
        (MAV_CMD_DO_SET_MISSION_CURRENT, 7.0, 0.0, MAV_RESULT_DENIED),
        (MAV_CMD_NAV_RETURN_TO_LAUNCH, 0.0, 0.0, MAV_RESULT_ACCEPTED),
    ] {
        let found = result(&mut bench, &simple(command, param1, param2)).0;
        assert_eq!(found, expected, "command {command} ({param1}, {param2})");
    }
}

#[test]
fn both_forms_arm_and_the_ack_goes_to_the_sender_alone() {
    let mut bench = Bench::ready();
    bench.send(LINK, COMPANION, &int(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0, 0.0], 0, 0, 0));
    let sent = bench.run_loops(1);
    assert!(bench.autopilot.armed);
    assert_eq!(acks(&sent[&LINK])[0].target_component, COMPANION.component);
    assert!(acks(&sent[&OTHER_LINK]).is_empty());
    result(&mut bench, &simple(MAV_CMD_COMPONENT_ARM_DISARM, 0.0, 21196.0));
    assert!(!bench.autopilot.armed);
}

#[test]
fn every_repetition_is_acknowledged() {
    let mut bench = Bench::ready();
    for _ in 0..20 {
        bench.send(LINK, GCS, &simple(MAV_CMD_DO_SET_MODE, 1.0, 4.0));
    }
    assert_eq!(acks(&bench.run_loops(1)[&LINK]).len(), 20);
}

#[test]
fn other_systems_commands_are_not_answered_and_unknown_components_are_the_autopilot() {
    let mut bench = Bench::ready();
    let to = |system, component| {
        let Message::COMMAND_LONG(data) = simple(MAV_CMD_DO_SET_MODE, 1.0, 4.0) else { panic!() };
        Message::COMMAND_LONG(COMMAND_LONG_DATA {
            target_system: system,
            target_component: component,
            ..data
        })
    };
    for (system, component, answers) in [(77, 1, 0), (1, 55, 1), (1, 0, 1), (0, 0, 1)] {
        bench.send(LINK, GCS, &to(system, component));
        assert_eq!(acks(&bench.run_loops(1)[&LINK]).len(), answers, "{system}/{component}");
    }
}

#[test]
fn requested_messages_follow_their_acknowledgement() {
    let mut bench = Bench::ready();
    let (found, sent) = result(&mut bench, &simple(MAV_CMD_REQUEST_MESSAGE, 148.0, 0.0));
    assert_eq!(found, MAV_RESULT_ACCEPTED);
    let Some(Message::AUTOPILOT_VERSION(version)) = sent.last() else { panic!("{sent:?}") };
    assert_eq!(version.capabilities, 0xF1EF);
    let old = result(&mut bench, &simple(MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1.0, 0.0)).1;
    assert!(matches!(old.last(), Some(Message::AUTOPILOT_VERSION(_))));
    let home = result(&mut bench, &simple(MAV_CMD_REQUEST_MESSAGE, 242.0, 0.0)).1;
    assert!(matches!(home.last(), Some(Message::HOME_POSITION(_))));
}

#[test]
fn intervals_are_set_and_told_per_link() {
    let mut bench = Bench::ready();
    assert_eq!(result(&mut bench, &simple(MAV_CMD_SET_MESSAGE_INTERVAL, 30.0, 1e5)).0, MAV_RESULT_ACCEPTED);
    let interval = |bench: &mut Bench| {
        let (_, sent) = result(bench, &simple(MAV_CMD_GET_MESSAGE_INTERVAL, 30.0, 0.0));
        sent.iter().find_map(|message| match message {
            Message::MESSAGE_INTERVAL(data) => Some(data.interval_us),
            _ => None,
        })
    };
    assert_eq!(interval(&mut bench), Some(100_000));
    let sent = bench.run_s(2.0);
    let count = |link| sent[&link].iter().filter(|message| matches!(message, Message::ATTITUDE(_))).count();
    assert_eq!((count(LINK), count(OTHER_LINK)), (20, 2));
    result(&mut bench, &simple(MAV_CMD_SET_MESSAGE_INTERVAL, 30.0, -1.0));
    assert_eq!(interval(&mut bench), Some(-1));
    result(&mut bench, &simple(MAV_CMD_SET_MESSAGE_INTERVAL, 30.0, 0.0));
    assert_eq!(interval(&mut bench), Some(1_000_000));
}

#[test]
fn a_reposition_changes_the_mode_only_when_told_to() {
    let mut bench = Bench::ready();
    bench.arm();
    let (x, y) = (bench.autopilot.position().to_e7().0 + 1000, bench.autopilot.position().to_e7().1);
    let refused = int(MAV_CMD_DO_REPOSITION, [-1.0, 0.0, 0.0, 0.0], x, y, MAV_FRAME_GLOBAL_INT);
    assert_eq!(result(&mut bench, &refused).0, MAV_RESULT_DENIED);
    let nowhere = int(MAV_CMD_DO_REPOSITION, [-1.0, 1.0, 0.0, 0.0], i32::MAX, y, MAV_FRAME_GLOBAL);
    assert_eq!(result(&mut bench, &nowhere).0, MAV_RESULT_DENIED);
    let accepted = int(MAV_CMD_DO_REPOSITION, [-1.0, 1.0, 0.0, f32::NAN], x, y, MAV_FRAME_GLOBAL);
    assert_eq!(result(&mut bench, &accepted).0, MAV_RESULT_ACCEPTED);
    assert_eq!(bench.autopilot.mode, Mode::Guided);
    assert_eq!(result(&mut bench, &simple(MAV_CMD_DO_CHANGE_SPEED, 1.0, 0.5)).0, MAV_RESULT_ACCEPTED);
}

#[test]
fn home_can_be_set_here_or_there() {
    let mut bench = Bench::ready();
    let there = long(MAV_CMD_DO_SET_HOME, [0.0, 0.0, 0.0, 0.0, 50.0, 6.0, 0.0]);
    assert_eq!(result(&mut bench, &there).0, MAV_RESULT_ACCEPTED);
    let home = bench.autopilot.home.unwrap();
    assert!((home.latitude_deg - 50.0).abs() < 1e-6);
    bench.arm();
    assert_eq!(bench.autopilot.home, Some(home), "arming does not move a home that was set");
    let nowhere = long(MAV_CMD_DO_SET_HOME, [0.0, 0.0, 0.0, 0.0, f32::NAN, 6.0, 0.0]);
    assert_eq!(result(&mut bench, &nowhere).0, MAV_RESULT_FAILED);
    assert_eq!(result(&mut bench, &simple(MAV_CMD_DO_SET_HOME, 1.0, 0.0)).0, MAV_RESULT_ACCEPTED);
}

#[test]
fn a_restart_starts_the_clock_again_and_keeps_the_parameters() {
    let mut bench = Bench::ready();
    bench.autopilot.parameters.put(super::super::parameters::SYSID_MYGCS, 42.0);
    bench.arm();
    assert_eq!(result(&mut bench, &simple(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0, 0.0)).0, MAV_RESULT_FAILED);
    bench.autopilot.disarm();
    assert_eq!(
        result(&mut bench, &simple(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0, 0.0)).0,
        MAV_RESULT_ACCEPTED
    );
    assert!(bench.autopilot.since_boot() < Duration::from_millis(100));
    assert_eq!(bench.autopilot.parameters.int(super::super::parameters::SYSID_MYGCS), 42);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_command_is_acknowledged_once(
        commands in prop::collection::vec(
            (prop_oneof![0u16..700, any::<u16>()], prop::array::uniform7(any::<f32>())), 1..20),
    ) {
        let mut bench = Bench::ready();
        for (command, params) in commands {
            bench.send(LINK, GCS, &long(command, params));
            prop_assert_eq!(acks(&bench.run_loops(1)[&LINK]).len(), 1);
        }
    }
}
