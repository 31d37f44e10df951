//! Whatever the radio does, a transfer ends, and ends with a whole plan or the old one.

use proptest::prelude::*;

use super::channel::{Cost, Dice, Radio, run};
use super::*;
use crate::protocol::client::{Download, Upload};
use crate::protocol::server::{MissionServer, Settings};

/// A telemetry radio that loses a fifth of what it carries, each way.
const TWENTY_PERCENT: Radio = Radio { loss: 0.2, copies: 0.02, least_delay_s: 0.02, most_delay_s: 0.12 };
/// Seeds for the exchanges that must always succeed.
const SEEDS: u64 = 100;

fn server_with(mission_type: MissionType, items: &[Item]) -> MissionServer {
    let mut server = MissionServer::new(Settings::default());
    server.set_items(mission_type, items).unwrap();
    server
}

/// Uploads over `radio`; the server must hold the old plan or the new one, whole, at every moment.
fn upload(radio: Radio, seed: u64, mission_type: MissionType, old: &[Item], new: &[Item]) -> (bool, Cost) {
    let mut server = server_with(mission_type, old);
    let plan = Mission { home: None, items: new.to_vec() };
    let mut upload = Upload::new(exchange(mission_type), &plan);
    let cost = run(&mut upload, &mut server, radio, &mut Dice(seed), at(5.0), |server| {
        let stored = server.items(mission_type);
        assert!(stored == old || stored == new, "half a plan: {} items", stored.len());
    });
    let succeeded = upload.outcome().unwrap().is_ok();
    if succeeded {
        assert_eq!(server.items(mission_type), new);
    }
    (succeeded, cost)
}

/// Downloads over `radio`; success means exactly the server's items.
fn download(radio: Radio, seed: u64, mission_type: MissionType, stored: &[Item]) -> (bool, Cost) {
    let mut server = server_with(mission_type, stored);
    let mut download = Download::new(exchange(mission_type));
    let cost = run(&mut download, &mut server, radio, &mut Dice(seed), at(5.0), |_| {});
    let succeeded = download.outcome().unwrap().map(|mission| assert_eq!(mission.items, stored)).is_ok();
    (succeeded, cost)
}

#[test]
fn two_hundred_items_go_up_at_twenty_percent_loss() {
    let new = items(MissionType::Mission, 200);
    let old = items(MissionType::Mission, 3);
    for seed in 0..SEEDS {
        let (succeeded, cost) = upload(TWENTY_PERCENT, seed, MissionType::Mission, &old, &new);
        assert!(succeeded, "seed {seed}: {cost:?}");
    }
}

#[test]
fn two_hundred_items_come_down_at_twenty_percent_loss() {
    let stored = items(MissionType::Mission, 200);
    for seed in 0..SEEDS {
        let (succeeded, cost) = download(TWENTY_PERCENT, seed, MissionType::Mission, &stored);
        assert!(succeeded, "seed {seed}: {cost:?}");
    }
}

#[test]
fn a_good_link_carries_each_message_once() {
    let radio = Radio { loss: 0.0, copies: 0.0, least_delay_s: 0.01, most_delay_s: 0.01 };
    let stored = items(MissionType::Rally, 50);
    // COUNT, 50 requests, 50 items, ACK; the list request makes one more of the download.
    let (succeeded, cost) = upload(radio, 1, MissionType::Rally, &[], &stored);
    assert_eq!((succeeded, cost.messages), (true, 102));
    let (succeeded, cost) = download(radio, 1, MissionType::Rally, &stored);
    assert_eq!((succeeded, cost.messages), (true, 103));
}

#[test]
fn copies_of_everything_do_not_multiply() {
    let radio = Radio { loss: 0.0, copies: 1.0, least_delay_s: 0.01, most_delay_s: 0.05 };
    let (succeeded, cost) = upload(radio, 3, MissionType::Fence, &[], &items(MissionType::Fence, 100));
    assert!(succeeded && cost.messages <= 210, "{cost:?}");
}

#[test]
fn a_dead_link_ends_both_transfers_in_nine_seconds() {
    let radio = Radio { loss: 1.0, ..TWENTY_PERCENT };
    let stored = items(MissionType::Mission, 4);
    for (succeeded, cost) in [
        upload(radio, 1, MissionType::Mission, &[], &stored),
        download(radio, 1, MissionType::Mission, &stored),
    ] {
        assert!(!succeeded && cost.ended_at <= at(5.0 + 9.0), "{cost:?}");
    }
}

fn any_radio() -> impl Strategy<Value = Radio> {
    (0.0..0.7f64, 0.0..0.5f64, 0.0..2.0f64, 0.0..2.0f64).prop_map(|(loss, copies, one, other)| Radio {
        loss,
        copies,
        least_delay_s: one.min(other),
        most_delay_s: one.max(other),
    })
}

fn any_type() -> impl Strategy<Value = MissionType> {
    prop::sample::select(&MissionType::ALL[..])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn uploads_end_with_the_whole_plan_or_the_old_one(
        radio in any_radio(), seed: u64, mission_type in any_type(), old in 0u16..5, new in 0u16..40,
    ) {
        // The old plan differs from the new one in its first item.
        let mut old_items = items(mission_type, old);
        if let Some(first) = old_items.first_mut() {
            first.params[3] = 7.0;
        }
        upload(radio, seed, mission_type, &old_items, &items(mission_type, new));
    }

    #[test]
    fn downloads_end_with_the_whole_plan_or_none(
        radio in any_radio(), seed: u64, mission_type in any_type(), count in 0u16..40,
    ) {
        download(radio, seed, mission_type, &items(mission_type, count));
    }

    #[test]
    fn the_same_seed_costs_the_same(seed: u64) {
        let plan = items(MissionType::Rally, 12);
        let once = upload(TWENTY_PERCENT, seed, MissionType::Rally, &[], &plan).1;
        let again = upload(TWENTY_PERCENT, seed, MissionType::Rally, &[], &plan).1;
        prop_assert_eq!((once.messages, once.ended_at), (again.messages, again.ended_at));
    }
}
