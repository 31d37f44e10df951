//! A simulated radio that loses, copies, delays and so reorders messages, and a driver for both ends.

use std::time::Duration;

use helmlink_wire::dialect::Message;
use helmlink_wire::{Identity, LinkId};

use super::{BOAT, STATION};
use crate::protocol::client::{Download, Upload};
use crate::protocol::server::MissionServer;

/// Radio habits; the same for both directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Radio {
    pub(super) loss: f64,
    pub(super) copies: f64,
    pub(super) least_delay_s: f64,
    pub(super) most_delay_s: f64,
}

/// A number generator with a period and quality that do for dice (SplitMix64, Steele et al. 2014).
#[derive(Debug)]
pub(super) struct Dice(pub(super) u64);

impl Dice {
    /// Uniform in [0, 1).
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Either client machine.
pub(super) trait Machine {
    fn on_message(&mut self, now: Duration, from: Identity, message: &Message) -> bool;
    fn poll(&mut self, now: Duration) -> Option<Message>;
    fn next_deadline(&self) -> Option<Duration>;
}

macro_rules! machine {
    ($machine:ty) => {
        impl Machine for $machine {
            fn on_message(&mut self, now: Duration, from: Identity, message: &Message) -> bool {
                self.on_message(now, from, message)
            }
            fn poll(&mut self, now: Duration) -> Option<Message> {
                self.poll(now)
            }
            fn next_deadline(&self) -> Option<Duration> {
                self.next_deadline()
            }
        }
    };
}
machine!(Download);
machine!(Upload);

#[derive(Debug)]
struct InFlight {
    arrives: Duration,
    to_boat: bool,
    message: Message,
}

/// What an exchange cost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cost {
    pub(super) ended_at: Duration,
    pub(super) messages: usize,
}

const LINK: LinkId = LinkId(7);
/// No exchange of the tests may need more messages than this.
const MOST_MESSAGES: usize = 60_000;

/// Runs `client` against `server` over `radio` until the client has finished and the radio is empty.
/// `watch` sees the server after every event.
pub(super) fn run(
    client: &mut impl Machine,
    server: &mut MissionServer,
    radio: Radio,
    dice: &mut Dice,
    start: Duration,
    mut watch: impl FnMut(&MissionServer),
) -> Cost {
    let mut now = start;
    let mut air: Vec<InFlight> = Vec::new();
    let mut cost = Cost { ended_at: start, messages: 0 };
    loop {
        while let Some(message) = client.poll(now) {
            cost.messages += 1;
            transmit(&mut air, radio, dice, now, true, message);
        }
        while let Some((link, message)) = server.poll(now) {
            assert_eq!(link, LINK, "replies go to the link of the question");
            cost.messages += 1;
            transmit(&mut air, radio, dice, now, false, message);
        }
        watch(server);
        assert!(cost.messages < MOST_MESSAGES, "the exchange does not end");
        if client.next_deadline().is_some() {
            cost.ended_at = now;
        }
        let wakes = [client.next_deadline(), server.next_deadline()];
        let arrivals = air.iter().map(|flight| flight.arrives);
        let Some(next) = arrivals.chain(wakes.into_iter().flatten()).min() else { return cost };
        now = now.max(next);
        // The earliest arrival, the first sent of two at the same time.
        let earliest = (0..air.len()).min_by_key(|i| air[*i].arrives);
        if let Some(i) = earliest.filter(|i| air[*i].arrives <= now) {
            let flight = air.remove(i);
            if flight.to_boat {
                server.on_message(now, LINK, STATION, BOAT, &flight.message);
            } else {
                client.on_message(now, BOAT, &flight.message);
            }
        }
    }
}

fn transmit(
    air: &mut Vec<InFlight>,
    radio: Radio,
    dice: &mut Dice,
    now: Duration,
    to_boat: bool,
    message: Message,
) {
    let copies = if dice.roll() < radio.copies { 2 } else { 1 };
    for _ in 0..copies {
        let delay_s = radio.least_delay_s + dice.roll() * (radio.most_delay_s - radio.least_delay_s);
        if dice.roll() >= radio.loss {
            let arrives = now + Duration::from_secs_f64(delay_s);
            air.push(InFlight { arrives, to_boat, message: message.clone() });
        }
    }
}
