//! What the bridge does for the ground station.

use helmlink_mission::protocol::MissionType;
use helmlink_wire::dialect::{
    COMMAND_LONG_DATA, CharArray, MISSION_CLEAR_ALL_DATA, PARAM_REQUEST_LIST_DATA, PARAM_SET_DATA,
};
use helmlink_wire::{Framer, Identity, Message, enums};

use super::rig::*;
use crate::bridge::parameters::PARAMETERS;
use crate::bridge::{Health, controller_state};
use crate::pilot::supervisor::State;
use crate::vehicle::{Mode, OutputKind};

fn under_way() -> Rig {
    Rig::under_way(Setup::new(OutputKind::RcOverride, true), |_| {})
}

fn command(target: Identity, command: u16, param1: f32, param2: f32) -> Message {
    Message::COMMAND_LONG(COMMAND_LONG_DATA {
        target_system: target.system,
        target_component: target.component,
        command,
        param1,
        param2,
        ..COMMAND_LONG_DATA::DEFAULT
    })
}

/// The result with which a command was acknowledged by `target`.
fn result_of(rig: &mut Rig, target: Identity, number: u16, param1: f32, param2: f32) -> u8 {
    rig.heard_directly.clear();
    rig.say_directly(&command(target, number, param1, param2));
    rig.run(0.3);
    let result = rig.heard_directly.iter().find_map(|(from, message)| match message {
        Message::COMMAND_ACK(data) if *from == target && data.command == number => Some(data.result),
        _ => None,
    });
    result.unwrap_or_else(|| panic!("no acknowledgement of {number} by {target}"))
}

#[test]
fn every_command_to_the_bridge_is_obeyed_and_acknowledged() {
    let mut rig = under_way();
    let accepted = enums::MAV_RESULT_ACCEPTED;
    assert_eq!(result_of(&mut rig, BRIDGE, enums::MAV_CMD_DO_CHANGE_SPEED, 0.0, 0.8), accepted);
    rig.run(20.0);
    let speed_mps = rig.bridge().status().progress.unwrap().speed_mps;
    assert!((speed_mps - 0.8).abs() < 0.1, "{speed_mps} m/s");
    let denied = enums::MAV_RESULT_DENIED;
    assert_eq!(result_of(&mut rig, BRIDGE, enums::MAV_CMD_DO_CHANGE_SPEED, 0.0, 50.0), denied);
    assert_eq!(result_of(&mut rig, BRIDGE, enums::MAV_CMD_DO_SET_MISSION_CURRENT, 2.0, 0.0), accepted);
    assert_eq!(rig.bridge().status().progress.unwrap().next, 1);
    assert_eq!(result_of(&mut rig, BRIDGE, enums::MAV_CMD_DO_PAUSE_CONTINUE, 0.0, 0.0), accepted);
    assert!(rig.run_until(3.0, |rig| rig.state() == State::Holding));
    assert_eq!(result_of(&mut rig, BRIDGE, enums::MAV_CMD_DO_PAUSE_CONTINUE, 1.0, 0.0), accepted);
    assert!(rig.run_until(3.0, |rig| rig.state() == State::Engaged), "{:?}", rig.texts());
    assert_eq!(result_of(&mut rig, BRIDGE, enums::MAV_CMD_USER_1, 0.0, 0.0), accepted);
    assert!(rig.run_until(3.0, |rig| rig.state() == State::Stopped));
    assert_eq!(result_of(&mut rig, BRIDGE, enums::MAV_CMD_MISSION_START, 0.0, 0.0), accepted);
    assert!(rig.run_until(3.0, |rig| rig.state() == State::Engaged), "{:?}", rig.texts());
    assert_eq!(
        result_of(&mut rig, BRIDGE, enums::MAV_CMD_REQUEST_MESSAGE, 148.0, 0.0),
        enums::MAV_RESULT_FAILED
    );
    assert_eq!(result_of(&mut rig, BRIDGE, 31_999, 0.0, 0.0), enums::MAV_RESULT_UNSUPPORTED);
}

#[test]
fn a_ground_station_on_the_bridges_own_link_reaches_the_flight_controller() {
    let mut rig = under_way();
    let ack = result_of(&mut rig, VEHICLE, enums::MAV_CMD_REQUEST_MESSAGE, 148.0, 0.0);
    assert_eq!(ack, enums::MAV_RESULT_ACCEPTED);
    let hears = |rig: &Rig, wanted: fn(&Message) -> bool| {
        rig.heard_directly.iter().any(|(from, message)| *from == VEHICLE && wanted(message))
    };
    assert!(hears(&rig, |message| matches!(message, Message::AUTOPILOT_VERSION(_))));
    rig.run(1.0);
    assert!(hears(&rig, |message| matches!(message, Message::GLOBAL_POSITION_INT(_))));
    // What it hears of the bridge itself, once a second.
    let states =
        rig.heard_directly.iter().filter(|(_, message)| controller_state::from_message(message).is_some());
    let states = states.count();
    assert!((11..=22).contains(&states), "{states}");
}

#[test]
fn the_ground_station_hears_how_the_process_is_and_which_failsafes_have_acted_is_counted() {
    let mut rig = under_way();
    let now = rig.now;
    rig.bridge().station_link_up(now, DIRECT);
    rig.bridge().set_health(now, Health { late_ms: 1.5, cpu_percent: 2.5, memory_mb: 6.5 });
    rig.run(3.0);
    let named = |rig: &Rig, wanted: &str| -> Vec<f32> {
        let values = rig.heard_directly.iter().filter_map(|(_, message)| match message {
            Message::NAMED_VALUE_FLOAT(data) if data.name.to_str() == Ok(wanted) => Some(data.value),
            _ => None,
        });
        values.collect()
    };
    assert_eq!(["HL_LATE", "HL_CPU", "HL_MEM"].map(|name| named(&rig, name)), [[1.5], [2.5], [6.5]]);
    let now = rig.now;
    rig.bridge().set_recording_failed(now, true);
    rig.run(1.0);
    rig.choose(Mode::HOLD);
    rig.run(1.0);
    let counts: Vec<_> = rig.bridge().counts().failsafes().filter(|(_, count)| *count > 0).collect();
    assert_eq!(counts, [("mode-changed", 1), ("recording", 1)]);
}

fn set(rig: &mut Rig, name: &str, param_value: f32) -> Vec<Message> {
    rig.heard_directly.clear();
    rig.say_directly(&Message::PARAM_SET(PARAM_SET_DATA {
        target_system: BRIDGE.system,
        target_component: BRIDGE.component,
        param_id: CharArray::from(name),
        param_value,
        param_type: enums::MAV_PARAM_TYPE_REAL32,
    }));
    rig.run(0.1);
    let of_bridge = rig.heard_directly.iter().filter(|(from, _)| *from == BRIDGE);
    of_bridge.map(|(_, message)| message.clone()).collect()
}

#[test]
fn parameters_are_listed_set_refused_kept_and_reset() {
    let mut rig = under_way();
    rig.say_directly(&Message::PARAM_REQUEST_LIST(PARAM_REQUEST_LIST_DATA {
        target_system: BRIDGE.system,
        target_component: 0,
    }));
    rig.run(3.0);
    let mut numbers: Vec<u16> = rig
        .heard_directly
        .iter()
        .filter_map(|(from, message)| match message {
            Message::PARAM_VALUE(data) if *from == BRIDGE => Some(data.param_index),
            _ => None,
        })
        .collect();
    numbers.dedup();
    assert_eq!(numbers, (0..PARAMETERS.len() as u16).collect::<Vec<_>>());

    assert_eq!(rig.bridge().take_parameters(), None, "nothing to keep");
    let answer = set(&mut rig, "HL_R_K", 2.25);
    assert!(
        answer.iter().any(|m| matches!(m, Message::PARAM_VALUE(data) if data.param_value == 2.25)),
        "{answer:?}"
    );
    assert_eq!(rig.state(), State::Engaged, "while driving");
    let refusal = set(&mut rig, "HL_R_K", -1.0);
    let is_refused = |m: &Message| matches!(m, Message::PARAM_ERROR(data) if data.error == enums::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE);
    assert!(refusal.iter().any(is_refused), "{refusal:?}");
    assert!(refusal.iter().any(|m| matches!(m, Message::STATUSTEXT(_))), "with the reason");
    assert!(refusal.iter().any(|m| matches!(m, Message::PARAM_VALUE(data) if data.param_value == 2.25)));

    let kept = rig.bridge().take_parameters().unwrap();
    assert!(kept.contains("HL_R_K 2.25"), "{kept}");
    rig.settings.parameters = kept;
    rig.start_bridge();
    let number = PARAMETERS.iter().position(|parameter| parameter.name == "HL_R_K").unwrap();
    assert_eq!(rig.bridge().settings.tunables().value(number), Some(2.25));
    rig.run(3.0);
    let accepted = enums::MAV_RESULT_ACCEPTED;
    assert_eq!(result_of(&mut rig, BRIDGE, enums::MAV_CMD_PREFLIGHT_STORAGE, 2.0, 0.0), accepted);
    assert!(!rig.bridge().take_parameters().unwrap().contains("HL_R_K"), "back at the factory value");
}

#[test]
fn every_change_of_state_has_its_reason_for_programs_too() {
    let mut rig = under_way();
    rig.choose(Mode::LOITER);
    rig.run(1.0);
    let changes: Vec<_> =
        std::iter::from_fn(|| rig.bridge().poll_change()).map(|change| change.to_json()).collect();
    let states: Vec<_> = changes.iter().map(|change| change["state"].as_str().unwrap()).collect();
    assert_eq!(states[states.len() - 3..], ["engaging", "engaged", "ready"], "{changes:?}");
    assert!(changes.iter().all(|change| change["reason"].as_str().is_some_and(|reason| !reason.is_empty())));
    let last = changes.last().unwrap();
    assert_eq!((last["failsafe"].as_str(), last["mode"].as_str()), (Some("mode-changed"), Some("LOITER")));
    assert_eq!(last["progress"]["next_waypoint"], 1);
    assert_eq!(rig.bridge().status().to_json()["reason"], last["reason"]);
}

#[test]
fn a_mission_changed_under_way_is_followed_from_where_the_boat_is() {
    let mut rig = under_way();
    rig.run(25.0);
    assert_eq!(rig.bridge().status().progress.unwrap().next, 1);
    // As many items as before: only what the firmware says shows that it is another one.
    rig.upload(MissionType::Mission, items(&[(20.0, 5.0), (300.0, 5.0)]));
    let has_changed = |rig: &Rig| {
        let run = rig.bridge.as_ref().and_then(|bridge| bridge.run());
        run.is_some_and(|run| (run.route().waypoints[1].position.distance_m(place(300.0, 5.0))) < 0.1)
    };
    assert!(rig.run_until(5.0, has_changed), "{:?}", rig.texts());
    rig.run(1.0);
    assert_eq!(rig.state(), State::Engaged);
    assert_eq!(rig.bridge().status().progress.unwrap().next, 1, "not back to the first");
}

#[test]
fn a_mission_cleared_under_way_ends_in_loiter() {
    let mut rig = under_way();
    rig.say(&Message::MISSION_CLEAR_ALL(MISSION_CLEAR_ALL_DATA {
        target_system: VEHICLE.system,
        target_component: VEHICLE.component,
        ..MISSION_CLEAR_ALL_DATA::DEFAULT
    }));
    assert!(rig.run_until(10.0, |rig| rig.state() == State::Holding), "{:?}", rig.texts());
    rig.run(1.2);
    assert_eq!(rig.mode, Mode::LOITER);
}

#[test]
fn a_bridge_that_cannot_go_on_stops_the_boat_and_lets_go() {
    for output in OutputKind::ALL {
        let mut rig = Rig::under_way(Setup::new(output, true), |_| {});
        rig.bridge().abandon();
        let mut framer = Framer::new();
        while let Some((_, bytes)) = rig.bridge().poll_transmit() {
            framer.push(&bytes);
        }
        let mut sent = Vec::new();
        while let Some(frame) = framer.next_frame() {
            sent.extend(frame.decode().ok().filter(is_steering));
        }
        let (released, driven): (Vec<_>, Vec<_>) = sent.iter().partition(|message| is_release(message));
        assert!(!driven.is_empty() && driven.iter().all(|message| is_neutral(message)), "{output}: {sent:?}");
        assert_eq!(!released.is_empty(), output.uses_sticks(), "{output}: {sent:?}");
        assert_eq!(sent.last().is_some_and(is_release), output.uses_sticks(), "{output}: {sent:?}");
    }
}

#[test]
fn a_shadow_sends_nothing_at_all() {
    let mut rig = Rig::new(Setup::new(OutputKind::RcOverride, true), |settings| settings.shadow = true);
    rig.run(30.0);
    assert!(rig.steering.is_empty());
    assert!(!rig.heard.iter().any(|(from, _)| *from == BRIDGE), "not even a heartbeat");
}

#[test]
fn steering_frames_come_ten_times_a_second_even_when_telemetry_is_slow() {
    let mut rig = under_way();
    let mut count = 0;
    // Two positions and headings a second get through.
    rig.tamper = Some(Box::new(move |message| {
        let is_fast = matches!(message, Message::ATTITUDE(_) | Message::GLOBAL_POSITION_INT(_));
        count += i32::from(is_fast);
        !is_fast || count % 26 < 2
    }));
    rig.run(1.0);
    let from = rig.steering.len();
    rig.run(5.0);
    let rate_hz = (rig.steering.len() - from) as f64 / 5.0;
    assert!(rate_hz >= 10.0, "{rate_hz} Hz");
    assert_eq!(rig.state(), State::Engaged, "{:?}", rig.texts());
}
