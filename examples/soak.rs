//! Attacks a running simulated boat over real sockets, and measures what an honest client notices.
//!
//! ```console
//! helmlink sitl --listen tcpin:127.0.0.1:5760 &
//! cargo run --release --example soak -- 127.0.0.1:5760 $! 60
//! cargo run --release --example soak -- 127.0.0.1:5760 $! 60 deaf
//! ```
//!
//! Arguments: address, process id of the boat (for its memory; 0 to leave that out), seconds, kind of attack. Fifty
//! connections: noise at 100 kB/s, frames with random fields, frames cut short, some that never read, some that
//! come and go. With `deaf` all but the honest one ask for every stream at 40 Hz, never read, and come back when
//! they are dropped. Exit code 1 when a heartbeat is more than 0.1 s early or late, or the memory grows by more
//! than 2 MB at any time.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use helmlink_wire::dialect::{HEARTBEAT_DATA, MavlinkVersion, Message, MessageSet, REQUEST_DATA_STREAM_DATA};
use helmlink_wire::{Encoder, Framer, Identity};

/// Connections that never read; those that come and go; all others are silent listeners.
const NEVER_READ: usize = 3;
const LISTENERS: usize = 42;
const TOLERANCE: Duration = Duration::from_millis(100);
const GROWTH_KB: u64 = 2048;

struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn bytes(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.next() as u8).collect()
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    let address = arguments.get(1).cloned().unwrap_or_else(|| "127.0.0.1:5760".to_owned());
    let process: u32 = arguments.get(2).and_then(|text| text.parse().ok()).unwrap_or(0);
    let seconds: u64 = arguments.get(3).and_then(|text| text.parse().ok()).unwrap_or(60);
    let attack = if arguments.get(4).is_some_and(|kind| kind == "deaf") { deaf } else { attack };
    match soak(&address, process, Duration::from_secs(seconds), attack) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{address}: {error}");
            ExitCode::from(3)
        }
    }
}

fn soak(
    address: &str,
    process: u32,
    length: Duration,
    attack: fn(&str, usize, &AtomicBool),
) -> std::io::Result<bool> {
    let over = Arc::new(AtomicBool::new(false));
    let mut honest = TcpStream::connect(address)?;
    // Settled before the attack: two heartbeats.
    intervals(&mut honest, Duration::from_secs(3))?;
    let before_kb = memory_kb(process);
    let mut attackers = Vec::new();
    for number in 0..49 {
        let (address, over) = (address.to_owned(), Arc::clone(&over));
        attackers.push(std::thread::spawn(move || attack(&address, number, &over)));
    }
    let watch = Arc::clone(&over);
    let watcher = std::thread::spawn(move || most_memory_kb(process, &watch));
    let intervals = intervals(&mut honest, length)?;
    over.store(true, Ordering::Relaxed);
    for attacker in attackers {
        // Attackers end as they like; a broken connection is theirs.
        let _ = attacker.join();
    }
    let growth_kb = watcher.join().unwrap_or(u64::MAX).saturating_sub(before_kb);
    let least = intervals.iter().min().copied().unwrap_or_default();
    let most = intervals.iter().max().copied().unwrap_or_default();
    eprintln!(
        "{} heartbeats, {:.3} to {:.3} s apart, memory {before_kb} kB + {growth_kb} kB",
        intervals.len() + 1,
        least.as_secs_f64(),
        most.as_secs_f64()
    );
    let second = Duration::from_secs(1);
    let steady = least + TOLERANCE >= second && most <= second + TOLERANCE;
    let all = intervals.len() as u64 + 3 >= length.as_secs();
    Ok(steady && all && growth_kb <= GROWTH_KB)
}

/// Times between the heartbeats of the boat.
fn intervals(stream: &mut TcpStream, length: Duration) -> std::io::Result<Vec<Duration>> {
    stream.set_read_timeout(Some(Duration::from_millis(200)))?;
    let (start, mut last, mut all) = (Instant::now(), None::<Instant>, Vec::new());
    let (mut framer, mut buffer) = (Framer::new(), [0; 65_536]);
    while start.elapsed() < length {
        match stream.read(&mut buffer) {
            Ok(0) => return Err(std::io::ErrorKind::ConnectionAborted.into()),
            Ok(count) => framer.push(&buffer[..count]),
            Err(error)
                if matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut) => {}
            Err(error) => return Err(error),
        }
        while let Some(frame) = framer.next_frame() {
            if frame.identity() == (Identity { system: 1, component: 1 }) && frame.message_id() == 0 {
                all.extend(last.map(|last| last.elapsed()));
                last = Some(Instant::now());
            }
        }
    }
    Ok(all)
}

fn attack(address: &str, number: usize, over: &AtomicBool) {
    let mut numbers = Numbers(0x5EED + number as u64);
    let mut encoder = Encoder::new();
    let ids: Vec<u32> = (0..13_000).filter(|id| Message::default_message_from_id(*id).is_some()).collect();
    while !over.load(Ordering::Relaxed) {
        let Ok(mut stream) = TcpStream::connect(address) else { return };
        let _ = stream.set_read_timeout(Some(Duration::from_millis(20)));
        let until =
            Instant::now() + if number == 4 { Duration::from_millis(100) } else { Duration::from_secs(3600) };
        while !over.load(Ordering::Relaxed) && Instant::now() < until {
            let bytes = match number {
                0 => numbers.bytes(2000),
                1 | 2 => {
                    let id = ids[numbers.next() as usize % ids.len()];
                    let mut bytes = Vec::new();
                    if let Ok(message) = Message::parse(MavlinkVersion::V2, id, &numbers.bytes(255))
                        && !is_an_order(&message)
                    {
                        encoder.encode(Identity { system: 255, component: 190 }, &message, &mut bytes);
                    }
                    if number == 2 {
                        bytes.truncate(numbers.next() as usize % (bytes.len() + 1));
                    }
                    bytes
                }
                // Half open: the other half is closed, and nothing is read.
                3 => {
                    let _ = stream.shutdown(Shutdown::Write);
                    Vec::new()
                }
                _ => Vec::new(),
            };
            if !bytes.is_empty() && stream.write_all(&bytes).is_err() {
                break;
            }
            if number > 4 + NEVER_READ && number < 4 + NEVER_READ + LISTENERS {
                let mut buffer = [0; 65_536];
                // A pause of 20 ms where there is nothing to read.
                let _ = stream.read(&mut buffer);
            } else {
                std::thread::sleep(Duration::from_millis(20));
            }
        }
    }
}

/// Asks for more than anybody would and never reads a byte.
fn deaf(address: &str, _number: usize, over: &AtomicBool) {
    let everything = Message::REQUEST_DATA_STREAM(REQUEST_DATA_STREAM_DATA {
        req_message_rate: 40,
        start_stop: 1,
        target_system: 1,
        target_component: 1,
        ..REQUEST_DATA_STREAM_DATA::DEFAULT
    });
    let mut encoder = Encoder::new();
    while !over.load(Ordering::Relaxed) {
        let Ok(mut stream) = TcpStream::connect(address) else { return };
        let mut message = everything.clone();
        while !over.load(Ordering::Relaxed) {
            let mut bytes = Vec::new();
            encoder.encode(Identity { system: 255, component: 190 }, &message, &mut bytes);
            if stream.write_all(&bytes).is_err() {
                break;
            }
            message =
                Message::HEARTBEAT(HEARTBEAT_DATA { mavtype: 6, autopilot: 8, ..HEARTBEAT_DATA::DEFAULT });
            std::thread::sleep(Duration::from_millis(100));
        }
    }
}

/// What turns the boat off, stops its time, cuts its links or changes their key is no attack but an order.
fn is_an_order(message: &Message) -> bool {
    match message {
        Message::COMMAND_LONG(data) => matches!(data.command, 246 | 31010),
        Message::COMMAND_INT(data) => matches!(data.command, 246 | 31010),
        Message::PARAM_SET(_) | Message::SETUP_SIGNING(_) => true,
        _ => false,
    }
}

/// The most memory that a process holds until it is over, looked at twenty times a second, kB.
fn most_memory_kb(process: u32, over: &AtomicBool) -> u64 {
    let mut most = memory_kb(process);
    while !over.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(50));
        most = most.max(memory_kb(process));
    }
    most
}

/// Resident memory of a process, kB; 0 where that is not known.
fn memory_kb(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmRSS"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok()).unwrap_or(0)
}
