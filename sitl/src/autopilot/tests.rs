use helmlink_wire::dialect::{COMMAND_LONG_DATA, HEARTBEAT_DATA, STATUSTEXT_DATA};
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
