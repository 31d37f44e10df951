//! Speed of the whole boat: physics, sensors, autopilot and MAVLink, on one core.
//!
//! Run with `cargo bench -p helmlink-sitl --bench autopilot`. An item is one simulated second, so items per
//! second is the factor over real time.

use std::time::Duration;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use helmlink_sitl::physics::{Hull, Sea, SeaState, SensorSettings};
use helmlink_sitl::{Sitl, SitlSettings};
use helmlink_wire::dialect::{MANUAL_CONTROL_DATA, Message};
use helmlink_wire::{Encoder, Identity, LinkId};

fn main() {
    divan::main();
}

const LINK: LinkId = LinkId(1);
const LOOP: Duration = Duration::from_millis(20);
const LOOPS_PER_SECOND: u32 = 50;
/// Asked for of every stream: the firmware's limit.
const FASTEST_HZ: u16 = 40;

fn boat(sea: SeaState) -> Option<Sitl> {
    let hull = Hull::builtin("otter").ok()?;
    let sea = Sea::preset(sea, &hull);
    let settings = SitlSettings { sea, sensors: SensorSettings::typical(), ..SitlSettings::new(hull) };
    let mut boat = Sitl::new(settings).ok()?;
    boat.link_up(LINK);
    boat.advance(Duration::from_secs(3));
    Some(boat)
}

/// Everything at its default rate of once a second.
#[divan::bench]
fn default_streams(bencher: Bencher) {
    let Some(mut boat) = boat(SeaState::Moderate) else { return };
    bencher.counter(ItemsCount::new(1usize)).bench_local(|| {
        boat.advance(boat.now() + LOOP * LOOPS_PER_SECOND);
        while let Some(packet) = boat.poll_transmit() {
            black_box(packet);
        }
    });
}

/// Ten messages per loop of 20 ms: five of a client to the boat, and more than five at 40 Hz back.
#[divan::bench]
fn ten_messages_per_loop(bencher: Bencher) {
    let Some(mut boat) = boat(SeaState::Moderate) else { return };
    let mut encoder = Encoder::new();
    let from = Identity { system: 255, component: 190 };
    let mut bytes = Vec::new();
    // ATTITUDE, GLOBAL_POSITION_INT, LOCAL_POSITION_NED, VFR_HUD, SERVO_OUTPUT_RAW, RC_CHANNELS and others.
    for stream in [3, 6, 10, 11] {
        let request = helmlink_wire::dialect::REQUEST_DATA_STREAM_DATA {
            req_stream_id: stream,
            req_message_rate: FASTEST_HZ,
            start_stop: 1,
            target_system: 1,
            target_component: 1,
        };
        encoder.encode(from, &Message::REQUEST_DATA_STREAM(request), &mut bytes);
    }
    boat.on_bytes(LINK, &bytes);
    let stick =
        Message::MANUAL_CONTROL(MANUAL_CONTROL_DATA { target: 1, z: 300, ..MANUAL_CONTROL_DATA::DEFAULT });
    bencher.counter(ItemsCount::new(1usize)).bench_local(|| {
        for _ in 0..LOOPS_PER_SECOND {
            bytes.clear();
            for _ in 0..5 {
                encoder.encode(from, &stick, &mut bytes);
            }
            boat.on_bytes(LINK, &bytes);
            boat.advance(boat.now() + LOOP);
            while let Some(packet) = boat.poll_transmit() {
                black_box(packet);
            }
        }
    });
}
