use helmlink_wire::dialect::{
    AUTOPILOT_VERSION_DATA, COMMAND_ACK_DATA, COMMAND_LONG_DATA, HEARTBEAT_DATA, MessageData,
    PARAM_REQUEST_LIST_DATA, PARAM_VALUE_DATA, SERVO_OUTPUT_RAW_DATA, STATUSTEXT_DATA,
};
use testing::{Bench, COMPANION, GCS, LINK, OTHER_LINK};

use super::*;

#[test]
fn heartbeats_go_out_once_a_second_on_every_link() {
    let mut bench = Bench::ready();
    let sent = bench.run_s(10.0);
    for link in [LINK, OTHER_LINK] {
        let beats = sent[&link].iter().filter(|each| matches!(each, Message::HEARTBEAT(_))).count();
        assert_eq!(beats, 10);
    }
}

#[test]
fn clients_hear_each_other_and_nothing_comes_back() {
    let mut bench = Bench::ready();
    bench.send(LINK, GCS, &Message::HEARTBEAT(HEARTBEAT_DATA { mavtype: 6, ..HEARTBEAT_DATA::DEFAULT }));
    let companion = Message::STATUSTEXT(STATUSTEXT_DATA { severity: 4, ..STATUSTEXT_DATA::DEFAULT });
    bench.send(OTHER_LINK, COMPANION, &companion);
    let sent = bench.run_loops(1);
    assert!(sent[&LINK].contains(&companion));
    assert!(!sent[&OTHER_LINK].contains(&companion));
    assert!(
        sent[&OTHER_LINK].iter().any(|each| matches!(each, Message::HEARTBEAT(data) if data.mavtype == 6))
    );
    let command = Message::COMMAND_LONG(COMMAND_LONG_DATA {
        command: 400,
        target_system: 1,
        target_component: COMPANION.component,
        ..COMMAND_LONG_DATA::DEFAULT
    });
    bench.send(LINK, GCS, &command);
    let sent = bench.run_loops(1);
    assert!(sent[&OTHER_LINK].contains(&command), "passed on to the companion");
    assert!(!sent[&LINK].iter().any(|each| matches!(each, Message::COMMAND_ACK(_))), "and not acted upon");
}

#[test]
fn a_link_that_is_gone_gets_nothing_and_returns_with_default_rates() {
    let mut bench = Bench::ready();
    bench.autopilot.links.streams(LINK).unwrap().set_group(0, 10);
    assert!(bench.run_s(1.0)[&LINK].len() > 100);
    bench.link_down(LINK);
    assert!(bench.run_s(1.0)[&LINK].is_empty());
    bench.link_up(LINK);
    assert!(bench.run_s(1.0)[&LINK].len() < 50);
}

#[test]
fn the_system_id_changes_with_a_restart() {
    let mut bench = Bench::ready();
    bench.autopilot.parameters.put(SYSID_THISMAV, 7.0);
    assert_eq!(bench.autopilot.links.own.system, 1);
    bench.autopilot.reboot();
    assert_eq!(bench.autopilot.links.own.system, 7);
}

#[test]
fn without_orders_the_boat_stays_disarmed_and_still() {
    let mut bench = Bench::ready();
    bench.run_s(30.0);
    assert!(!bench.autopilot.armed);
    assert!(bench.position().norm() < 0.01);
}

/// Sends in MAVLink 1, as old clients do.
fn send_v1(bench: &mut Bench, message: &Message) {
    let mut bytes = Vec::new();
    helmlink_wire::Encoder::new().encode_v1(GCS, message, &mut bytes).unwrap();
    bench.on_bytes(LINK, &bytes);
}

#[test]
fn requests_in_mavlink_1_are_served_and_answered_in_mavlink_2() {
    let mut bench = Bench::ready();
    send_v1(
        &mut bench,
        &Message::PARAM_REQUEST_LIST(PARAM_REQUEST_LIST_DATA { target_system: 1, target_component: 1 }),
    );
    send_v1(
        &mut bench,
        &Message::COMMAND_LONG(COMMAND_LONG_DATA {
            command: 520,
            target_system: 1,
            target_component: 1,
            ..COMMAND_LONG_DATA::DEFAULT
        }),
    );
    let end = bench.now() + LOOP;
    bench.advance(end);
    let (mut ids, mut framer) = (Vec::new(), helmlink_wire::Framer::new());
    while let Some((link, bytes)) = bench.poll_transmit() {
        assert!(link != LINK || bytes[0] == 0xFD);
        if link == LINK {
            framer.push(&bytes);
        }
    }
    while let Some(frame) = framer.next_frame() {
        ids.push(frame.message_id());
    }
    for id in [PARAM_VALUE_DATA::ID, COMMAND_ACK_DATA::ID, AUTOPILOT_VERSION_DATA::ID] {
        assert!(ids.contains(&id), "message {id} is missing");
    }
}

fn clock(order: f32, count: f32) -> Message {
    Message::COMMAND_LONG(COMMAND_LONG_DATA {
        command: 31010,
        param1: order,
        param2: count,
        target_system: 1,
        target_component: 1,
        ..COMMAND_LONG_DATA::DEFAULT
    })
}

#[test]
fn a_client_stops_time_steps_and_lets_it_pass_again() {
    let mut bench = Bench::ready();
    bench.send(LINK, GCS, &clock(1.0, 0.0));
    bench.run_loops(1);
    let stopped = bench.now();
    assert!(bench.is_paused());
    let later = stopped + Duration::from_secs(10);
    bench.advance(later);
    assert_eq!(bench.now(), stopped);
    bench.send(LINK, GCS, &clock(2.0, 5.0));
    bench.advance(later);
    assert_eq!(bench.now(), stopped + 5 * LOOP);
    let acknowledged = std::iter::from_fn(|| bench.poll_transmit()).any(|(_, bytes)| bytes.contains(&77));
    assert!(acknowledged, "orders are acknowledged while time stands");
    bench.send(LINK, GCS, &clock(0.0, 0.0));
    bench.advance(later);
    assert_eq!(bench.now(), later);
}

#[test]
fn in_lockstep_time_passes_as_the_client_answers() {
    let mut bench = Bench::ready();
    bench.send(LINK, GCS, &clock(3.0, 100.0));
    let start = bench.now() + LOOP;
    let far = start + Duration::from_secs(100);
    bench.advance(far);
    assert_eq!(bench.now(), start - LOOP + Duration::from_millis(100));
    for beat in 2..=20 {
        let (mut framer, mut told) = (helmlink_wire::Framer::new(), None);
        while let Some((link, bytes)) = bench.poll_transmit() {
            if link == LINK {
                framer.push(&bytes);
            }
        }
        while let Some(frame) = framer.next_frame() {
            if let Ok(Message::SYSTEM_TIME(time)) = frame.decode() {
                told = Some(time);
            }
        }
        bench.send(LINK, GCS, &Message::SYSTEM_TIME(told.unwrap()));
        bench.advance(far);
        assert_eq!(bench.now(), start - LOOP + Duration::from_millis(100) * beat);
    }
    bench.link_down(LINK);
    bench.advance(far);
    assert_eq!(bench.now(), far, "nobody waits for one who has gone");
}

/// Measured on ArduRover 4.6: 21 ms at the least, 32 ms in the middle, 61 ms at the most.
#[test]
fn a_stick_reaches_the_servos_as_late_as_on_ardurover() {
    let mut bench = Bench::with_hull("motorboat");
    bench
        .autopilot
        .links
        .streams(LINK)
        .unwrap()
        .set(SERVO_OUTPUT_RAW_DATA::ID, Some(Duration::from_millis(25)));
    bench.arm();
    let mut latencies_ms = Vec::new();
    for number in 0..50_u16 {
        // It arrives this long before the loop that reads it starts.
        let early_ms = f64::from(number % 10) * 2.0;
        let pulse = if number % 2 == 0 { 1700 } else { 1300 };
        bench.run_loops(7 + u32::from(number % 5));
        bench.send(LINK, GCS, &testing::sticks(pulse, 1500));
        for loops in 1..=4 {
            let sent = bench.run_loops(1);
            let seen = sent[&LINK].iter().any(|message| {
                matches!(message, Message::SERVO_OUTPUT_RAW(data) if (data.servo1_raw > 1600) == (pulse > 1600))
            });
            if seen {
                latencies_ms.push(early_ms + 20.0 * f64::from(loops));
                break;
            }
        }
    }
    latencies_ms.sort_by(f64::total_cmp);
    assert_eq!(latencies_ms.len(), 50);
    let (least, middle, most) = (latencies_ms[0], latencies_ms[25], latencies_ms[49]);
    assert!((20.0..25.0).contains(&least), "{least} ms");
    assert!((27.0..40.0).contains(&middle), "{middle} ms");
    assert!(most <= 61.0, "{most} ms");
}

#[test]
fn tide_and_wind_change_under_way_by_parameter() {
    let mut bench = Bench::ready();
    bench.autopilot.parameters.put(SIM_TIDE_SPEED, 0.5);
    bench.autopilot.parameters.put(SIM_TIDE_DIR, 270.0);
    bench.arm();
    bench.run_s(20.0);
    assert!(bench.position().east_m > 7.0, "it comes from the west: {:?}", bench.position());
    assert_eq!(bench.sea().current.map(|current| current.toward_deg), Some(90.0));
    bench.autopilot.parameters.put(SIM_TIDE_SPEED, 0.0);
    bench.run_loops(2);
    assert_eq!(bench.sea().current, None);
}

#[test]
fn the_way_home_leads_to_the_nearest_rally_point() {
    let mut bench = Bench::ready();
    let rally = NorthEast::new(40.0, 30.0);
    let mut item = Item::waypoint(bench.autopilot.frame.to_geodetic(rally));
    item.command = helmlink_wire::enums::MAV_CMD_NAV_RALLY_POINT;
    bench.autopilot.missions.set_items(MissionType::Rally, &[item]).unwrap();
    bench.arm();
    bench.autopilot.enter_mode(Mode::Guided).unwrap();
    bench.go_to(NorthEast::new(40.0, 10.0));
    bench.run_s(60.0);
    bench.autopilot.enter_mode(Mode::Rtl).unwrap();
    bench.run_s(60.0);
    assert!((bench.position() - rally).norm() < 5.0, "{:?}", bench.position());
}
