//! Who else may be on the links, and what he is allowed to change.

use helmlink_wire::dialect::{HEARTBEAT_DATA, MANUAL_CONTROL_DATA, SET_ATTITUDE_TARGET_DATA};
use helmlink_wire::{Encoder, Identity, LinkId, Message, enums};

use super::rig::*;
use crate::pilot::supervisor::State;
use crate::vehicle::{Mode, OutputKind};

const OTHER_BOAT: Identity = Identity { system: 7, component: 1 };

/// A heartbeat as a boat's flight controller sends it, armed and in MANUAL.
fn heartbeat(mavtype: u8, autopilot: u8) -> Message {
    Message::HEARTBEAT(HEARTBEAT_DATA {
        mavtype,
        autopilot,
        base_mode: enums::MAV_MODE_FLAG_SAFETY_ARMED | enums::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
        ..HEARTBEAT_DATA::DEFAULT
    })
}

fn boat() -> Message {
    heartbeat(enums::MAV_TYPE_SURFACE_BOAT, enums::MAV_AUTOPILOT_ARDUPILOTMEGA)
}

/// Somebody says something on one of the bridge's links.
fn hear(rig: &mut Rig, link: LinkId, from: Identity, message: &Message) {
    let mut bytes = Vec::new();
    Encoder::new().encode(from, message, &mut bytes);
    let now = rig.now;
    rig.bridge().on_bytes(now, link, &bytes, true);
}

fn vehicle(rig: &Rig) -> Option<Identity> {
    rig.bridge.as_ref().and_then(|bridge| bridge.status().vehicle)
}

#[test]
fn a_boat_on_a_ground_station_s_link_is_never_steered() {
    let mut rig = Rig::new(Setup::new(OutputKind::RcOverride, true), |_| {});
    rig.cut = true;
    let now = rig.now;
    rig.bridge().station_link_up(now, DIRECT);
    for _ in 0..50 {
        hear(&mut rig, DIRECT, OTHER_BOAT, &boat());
        hear(&mut rig, LinkId(9), OTHER_BOAT, &boat());
        rig.run(0.1);
    }
    assert_eq!((vehicle(&rig), rig.bridge().refusal()), (None, None));
    rig.cut = false;
    assert!(rig.run_until(5.0, |rig| vehicle(rig) == Some(VEHICLE)), "{:?}", rig.texts());
    assert!(rig.run_until(10.0, |rig| rig.state() == State::Ready), "{:?}", rig.texts());
}

#[test]
fn only_an_autopilot_s_heartbeat_makes_a_vehicle() {
    let mut rig = Rig::new(Setup::new(OutputKind::RcOverride, true), |_| {});
    rig.cut = true;
    let company = [
        (Identity { system: 7, component: 191 }, boat()),
        (Identity { system: 7, component: 100 }, boat()),
        (OTHER_BOAT, heartbeat(enums::MAV_TYPE_SURFACE_BOAT, enums::MAV_AUTOPILOT_INVALID)),
        (STATION, heartbeat(enums::MAV_TYPE_GCS, enums::MAV_AUTOPILOT_INVALID)),
    ];
    for (from, message) in company {
        hear(&mut rig, TO_BRIDGE, from, &message);
        assert_eq!(vehicle(&rig), None, "{from}");
    }
    assert_eq!(rig.bridge().refusal(), None);
}

#[test]
fn a_second_flight_controller_on_the_link_is_told_of_once_and_left_alone() {
    let mut rig = Rig::under_way(Setup::new(OutputKind::RcOverride, true), |_| {});
    for _ in 0..20 {
        hear(&mut rig, TO_BRIDGE, OTHER_BOAT, &boat());
        rig.run(0.1);
    }
    assert_eq!((vehicle(&rig), rig.state()), (Some(VEHICLE), State::Engaged));
    let told = rig.texts().iter().filter(|text| text.contains("second flight controller, system 7")).count();
    assert_eq!(told, 1, "{:?}", rig.texts());
    // Nor is it taken for the first one when that falls silent, or when the line has been plugged in again.
    rig.cut = true;
    let now = rig.now;
    rig.bridge().link_down(now, TO_BRIDGE);
    rig.bridge().link_up(now, TO_BRIDGE);
    for _ in 0..60 {
        hear(&mut rig, TO_BRIDGE, OTHER_BOAT, &boat());
        rig.run(0.1);
    }
    assert_eq!(vehicle(&rig), None);
    rig.cut = false;
    assert!(rig.run_until(10.0, |rig| rig.state() == State::Ready), "{:?}", rig.texts());
    assert_eq!(vehicle(&rig), Some(VEHICLE));
}

#[test]
fn who_takes_the_right_to_override_is_noticed_even_if_the_news_is_lost() {
    for output in [OutputKind::RcOverride, OutputKind::ManualControl] {
        for news_arrives in [true, false] {
            let mut rig = Rig::under_way(Setup::new(output, true), |_| {});
            if !news_arrives {
                rig.tamper = Some(Box::new(|message| !matches!(message, Message::PARAM_VALUE(_))));
            }
            rig.set_parameter("SYSID_MYGCS", 42.0);
            rig.run(0.5);
            rig.tamper = None;
            let handed_back = rig.run_until(6.0, |rig| rig.state() != State::Engaged);
            assert!(handed_back, "{output}, {news_arrives}: {:?}", rig.texts());
            let said = rig.texts().join("\n");
            assert!(said.contains("only from system 42 (SYSID_MYGCS)"), "{said}");
            assert!(said.contains("no longer obeys the bridge: neutral-and-release"), "{said}");
            rig.run(5.0);
            assert_eq!(rig.mode, Mode::HOLD, "{output}, {news_arrives}");
            // Given back, it can be driven again.
            rig.set_parameter("SYSID_MYGCS", 255.0);
            assert!(rig.run_until(10.0, |rig| rig.state() == State::Ready), "{:?}", rig.texts());
        }
    }
}

#[test]
fn somebody_else_at_the_helm_is_told_of_once() {
    let manual = Message::MANUAL_CONTROL(MANUAL_CONTROL_DATA { target: 1, ..MANUAL_CONTROL_DATA::DEFAULT });
    let target = Message::SET_ATTITUDE_TARGET(SET_ATTITUDE_TARGET_DATA::DEFAULT);
    for output in OutputKind::ALL {
        let mut rig = Rig::under_way(Setup::new(output, true), |_| {});
        let (his, harmless) = if output.uses_sticks() { (&manual, &target) } else { (&target, &manual) };
        let told = |rig: &Rig| rig.texts().iter().filter(|text| text.contains("steers the boat too")).count();
        hear(&mut rig, DIRECT, STATION, harmless);
        assert_eq!(told(&rig), 0, "{output}");
        for _ in 0..5 {
            hear(&mut rig, DIRECT, STATION, his);
            rig.run(0.1);
        }
        assert_eq!(told(&rig), 1, "{output}: {:?}", rig.texts());
    }
}

#[test]
fn a_flight_controller_that_moves_to_another_port_is_driven_on() {
    for output in OutputKind::ALL {
        let mut rig = Rig::under_way(Setup::new(output, true), |_| {});
        let now = rig.now;
        rig.line = LinkId(12);
        rig.bridge().link_up(now, LinkId(12));
        rig.run(4.0);
        assert_eq!(rig.state(), State::Engaged, "{output}: {:?}", rig.texts());
        let now = rig.now;
        rig.bridge().link_down(now, TO_BRIDGE);
        rig.run(2.0);
        assert_eq!(rig.state(), State::Engaged, "{output}: {:?}", rig.texts());
        let last = rig.steering.last().unwrap().at;
        assert!((rig.now - last).as_secs_f64() < 0.1, "{output}: commands go out");
    }
}

#[test]
fn a_driver_whose_clock_falls_back_is_driven_on() {
    let mut rig = Rig::under_way(Setup::new(OutputKind::RcOverride, true), |_| {});
    let hour = std::time::Duration::from_secs(3600);
    let (early, now) = (rig.now.saturating_sub(hour), rig.now);
    rig.bridge().on_tick(early);
    rig.bridge().on_bytes(early, TO_BRIDGE, b"noise", true);
    rig.bridge().on_tick(now);
    rig.run(2.0);
    assert_eq!(rig.state(), State::Engaged, "{:?}", rig.texts());
}
