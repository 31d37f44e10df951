//! Sixty seconds of hostile traffic: everybody else is served as ever, and the memory stays flat.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use helmlink_sitl::physics::Hull;
use helmlink_sitl::{Sitl, SitlSettings};
use helmlink_wire::dialect::*;
use helmlink_wire::{Encoder, Framer, Identity, LinkId};

/// Bytes in use, over all threads.
static IN_USE: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, counting.
struct Counting;

// A global allocator cannot be written without `unsafe`; this one hands everything to the system's.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        IN_USE.fetch_add(layout.size(), Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The tests measure the memory of all threads, so they run one after the other.
static ALONE: Mutex<()> = Mutex::new(());

/// Growth that is allowed, bytes.
const GROWTH: usize = 2 << 20;
const LOOP: Duration = Duration::from_millis(20);
const HONEST: LinkId = LinkId(0);
const GCS: Identity = Identity { system: 255, component: 190 };

/// A small generator of numbers (xorshift), the same every time.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }

    /// Random bytes, those that fields like best among them more often: 0, 1, 255, parts of NaN.
    fn bytes(&mut self, count: usize) -> Vec<u8> {
        let favourites = [0, 0, 1, 1, 255, 0x7F, 0xC0];
        (0..count)
            .map(|_| match self.below(2) {
                0 => favourites[self.below(favourites.len() as u64) as usize],
                _ => self.next() as u8,
            })
            .collect()
    }
}

/// What turns the boat off, stops its time, cuts its links or changes their key is no attack but an order.
fn is_an_order(message: &Message) -> bool {
    let command = match message {
        Message::COMMAND_LONG(data) => data.command,
        Message::COMMAND_INT(data) => data.command,
        Message::PARAM_SET(_) | Message::SETUP_SIGNING(_) => return true,
        _ => return false,
    };
    matches!(command, 246 | 31010)
}

/// A message with a random id and random fields, whole and with a right checksum.
fn any_message(numbers: &mut Numbers, ids: &[u32], encoder: &mut Encoder) -> Vec<u8> {
    loop {
        let id = ids[numbers.below(ids.len() as u64) as usize];
        let payload = numbers.bytes(255);
        let Ok(message) = Message::parse(MavlinkVersion::V2, id, &payload) else { continue };
        if is_an_order(&message) {
            continue;
        }
        let from = Identity { system: numbers.below(256) as u8, component: numbers.below(256) as u8 };
        let mut bytes = Vec::new();
        encoder.encode(from, &message, &mut bytes);
        return bytes;
    }
}

/// Orders that the boat knows, for it, with not a number in every field.
fn not_a_number(command: u16) -> [Message; 4] {
    let nan = f32::NAN;
    [
        Message::COMMAND_LONG(COMMAND_LONG_DATA {
            command,
            param1: nan,
            param2: nan,
            param3: nan,
            param4: nan,
            param5: nan,
            param6: nan,
            param7: nan,
            target_system: 1,
            target_component: 1,
            confirmation: 0,
        }),
        Message::COMMAND_INT(COMMAND_INT_DATA {
            command,
            param1: nan,
            param2: nan,
            param3: nan,
            param4: nan,
            x: i32::MAX,
            y: i32::MIN,
            z: nan,
            target_system: 1,
            target_component: 1,
            frame: 6,
            ..COMMAND_INT_DATA::DEFAULT
        }),
        Message::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
            x: nan,
            vx: nan,
            yaw: nan,
            target_system: 1,
            target_component: 1,
            coordinate_frame: 1,
            type_mask: command,
            ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
        }),
        Message::MISSION_ITEM_INT(MISSION_ITEM_INT_DATA {
            command,
            param1: nan,
            param4: nan,
            z: nan,
            seq: command,
            target_system: 1,
            target_component: 1,
            ..MISSION_ITEM_INT_DATA::DEFAULT
        }),
    ]
}

/// An honest client: hears heartbeats and asks for the version once a second.
#[derive(Default)]
struct Honest {
    framer: Framer,
    beats: Vec<Duration>,
    answered: u32,
}

impl Honest {
    fn hear(&mut self, bytes: &[u8], now: Duration) {
        self.framer.push(bytes);
        while let Some(frame) = self.framer.next_frame() {
            if frame.identity() != (Identity { system: 1, component: 1 }) {
                continue;
            }
            match frame.decode() {
                Ok(Message::HEARTBEAT(_)) => self.beats.push(now),
                Ok(Message::COMMAND_ACK(ack)) if ack.command == 512 && ack.target_system == 255 => {
                    self.answered += 1
                }
                _ => {}
            }
        }
    }
}

#[test]
fn sixty_seconds_of_hostile_traffic_change_nothing_for_the_others() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut boat = Sitl::new(SitlSettings::new(Hull::builtin("skiff").unwrap())).unwrap();
    let mut numbers = Numbers(0x5EED);
    let mut encoder = Encoder::new();
    let ids: Vec<u32> = (0..13_000).filter(|id| Message::default_message_from_id(*id).is_some()).collect();
    assert!(ids.len() > 200);
    for link in 0..50 {
        assert!(boat.link_up(LinkId(link)));
    }
    let mut honest = Honest::default();
    let mut asked = 0;
    let mut before = 0;
    for step in 1..=(65 * 50_u32) {
        let now = LOOP * step;
        let hostile = now > Duration::from_secs(5);
        if step.is_multiple_of(50) {
            let ask = Message::COMMAND_LONG(COMMAND_LONG_DATA {
                command: 512,
                param1: 148.0,
                target_system: 1,
                target_component: 1,
                ..COMMAND_LONG_DATA::DEFAULT
            });
            let mut bytes = Vec::new();
            encoder.encode(GCS, &ask, &mut bytes);
            boat.on_bytes(HONEST, &bytes);
            asked += 1;
        }
        if hostile {
            // 100 kB/s of noise, as a stream and as datagrams.
            boat.on_bytes(LinkId(1), &numbers.bytes(2000));
            boat.on_datagram(LinkId(2), &numbers.bytes(700));
            for _ in 0..8 {
                let frame = any_message(&mut numbers, &ids, &mut encoder);
                boat.on_bytes(LinkId(3), &frame);
                // Cut short, and with a wrong byte.
                boat.on_bytes(LinkId(4), &frame[..numbers.below(frame.len() as u64) as usize]);
                let mut damaged = frame;
                let at = numbers.below(damaged.len() as u64) as usize;
                damaged[at] ^= 0x55;
                boat.on_datagram(LinkId(5), &damaged);
            }
            let command = if numbers.below(2) == 0 { numbers.below(600) } else { numbers.below(65_536) };
            for message in not_a_number(command as u16) {
                let mut bytes = Vec::new();
                if !is_an_order(&message) {
                    encoder.encode(GCS, &message, &mut bytes);
                    boat.on_bytes(LinkId(6), &bytes);
                }
            }
            // Links that come and go.
            boat.link_down(LinkId(40 + step % 10));
            boat.link_up(LinkId(40 + step % 10));
        }
        boat.advance(now);
        while let Some((link, bytes)) = boat.poll_transmit() {
            if link == HONEST {
                honest.hear(&bytes, now);
            }
        }
        if now == Duration::from_secs(5) {
            before = IN_USE.load(Ordering::Relaxed);
            honest.beats.clear();
        }
        // What the test itself keeps grows by a heartbeat a second.
        let growth = IN_USE.load(Ordering::Relaxed).saturating_sub(before);
        assert!(!hostile || growth <= GROWTH, "{growth} bytes more after {now:?}");
    }
    assert_eq!(boat.now(), Duration::from_secs(65));
    assert!(honest.beats.len() >= 60, "{} heartbeats", honest.beats.len());
    for pair in honest.beats.windows(2) {
        let interval_s = (pair[1] - pair[0]).as_secs_f64();
        assert!((interval_s - 1.0).abs() <= 0.1, "{interval_s} s between heartbeats at {:?}", pair[1]);
    }
    assert_eq!(honest.answered, asked, "every question is answered");
    let truth = boat.truth().hull;
    assert!(truth.north_m.is_finite() && truth.psi_rad.is_finite());
}

#[test]
fn fifty_clients_that_never_read_cost_no_memory_and_find_their_answers() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut boat = Sitl::new(SitlSettings::new(Hull::builtin("skiff").unwrap())).unwrap();
    let mut encoder = Encoder::new();
    let mut said = |boat: &mut Sitl, link: LinkId, message: &Message| {
        let mut bytes = Vec::new();
        encoder.encode(GCS, message, &mut bytes);
        boat.on_bytes(link, &bytes);
    };
    for link in 0..50 {
        assert!(boat.link_up(LinkId(link)));
    }
    boat.advance(Duration::from_secs(5));
    while boat.poll_transmit().is_some() {}
    let before = IN_USE.load(Ordering::Relaxed);
    for link in 0..50 {
        let everything = REQUEST_DATA_STREAM_DATA {
            req_message_rate: 40,
            start_stop: 1,
            target_system: 1,
            target_component: 1,
            ..REQUEST_DATA_STREAM_DATA::DEFAULT
        };
        said(&mut boat, LinkId(link), &Message::REQUEST_DATA_STREAM(everything));
        let unknown = COMMAND_LONG_DATA { command: 60_000, target_system: 1, ..COMMAND_LONG_DATA::DEFAULT };
        said(&mut boat, LinkId(link), &Message::COMMAND_LONG(unknown));
    }
    let mut most = 0;
    for step in 1..=(60 * 50) {
        boat.advance(Duration::from_secs(5) + LOOP * step);
        most = most.max(IN_USE.load(Ordering::Relaxed).saturating_sub(before));
    }
    println!("{most} bytes more, {} bytes lost", boat.lost_bytes());
    assert!(most <= GROWTH, "{most} bytes more");
    assert!(boat.lost_bytes() > 10 << 20, "the streams were lost, not held: {}", boat.lost_bytes());
    let mut clients: Vec<(Framer, u32, u32)> = (0..50).map(|_| (Framer::new(), 0, 0)).collect();
    while let Some((link, bytes)) = boat.poll_transmit() {
        let (framer, acks, beats) = &mut clients[link.0 as usize];
        framer.push(&bytes);
        while let Some(frame) = framer.next_frame() {
            match frame.decode() {
                Ok(Message::COMMAND_ACK(ack)) if ack.command == 60_000 => *acks += 1,
                Ok(Message::HEARTBEAT(_)) => *beats += 1,
                _ => {}
            }
        }
    }
    assert!(clients.iter().all(|(_, acks, beats)| *acks == 1 && *beats >= 1));
}
