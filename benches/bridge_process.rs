//! The bridge as a process: time from its start to the first heartbeat on the wire, and the memory it takes while
//! it drives a boat. Linux only: memory is read from `/proc`.
//!
//! Prints figures and checks nothing; `cargo bench --bench bridge_process`.

// A benchmark that cannot be set up may stop, and prints.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::io::Read;
use std::net::{TcpListener, UdpSocket};
use std::time::{Duration, Instant};

use helmlink_wire::{Framer, Message};
use support::Helmlink;

/// Starts that are measured.
const STARTS: usize = 20;
/// The mission that is driven while memory is watched.
const PLAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/short-survey.waypoints");

fn main() {
    start_up("UDP", || {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        let url = format!("udpout:{}", socket.local_addr().unwrap());
        (url, move |bytes: &mut [u8]| socket.recv(bytes).unwrap())
    });
    start_up("TCP", || {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("tcp:{}", listener.local_addr().unwrap());
        let mut stream = None;
        (url, move |bytes: &mut [u8]| {
            stream.get_or_insert_with(|| listener.accept().unwrap().0).read(bytes).unwrap()
        })
    });
    memory();
}

/// Time from starting the program to its first heartbeat having arrived.
fn start_up<R: FnMut(&mut [u8]) -> usize>(link: &str, place: impl Fn() -> (String, R)) {
    let mut times: Vec<Duration> = (0..STARTS)
        .map(|_| {
            let (url, mut read) = place();
            let started = Instant::now();
            let _bridge = Helmlink::start(&["bridge", "--quiet", "--connect", &url]);
            first_heartbeat(&mut read);
            started.elapsed()
        })
        .collect();
    times.sort_unstable();
    let ms = |time: Duration| time.as_secs_f64() * 1000.0;
    let (median, longest) = (ms(times[STARTS / 2]), ms(times[STARTS - 1]));
    println!(
        "start to first heartbeat, {link}: median {median:.1} ms, longest of {STARTS} {longest:.1} ms (aim: 100 ms)"
    );
}

fn first_heartbeat(read: &mut impl FnMut(&mut [u8]) -> usize) {
    let (mut framer, mut bytes) = (Framer::new(), [0; 4096]);
    loop {
        let count = read(&mut bytes);
        framer.push(&bytes[..count]);
        while let Some(frame) = framer.next_frame() {
            if matches!(frame.decode(), Ok(Message::HEARTBEAT(_))) {
                return;
            }
        }
    }
}

/// Resident memory of the bridge at the end of a mission.
fn memory() {
    let (_boat, address) = Helmlink::sitl("tcpin", &["--mission", PLAN, "--speedup", "10"]);
    let url = format!("tcp:{address}");
    let bridge = Helmlink::start(&["bridge", "--connect", &url, "--engage", "--arm"]);
    bridge.wait_for_line("mission complete");
    let status = std::fs::read_to_string(format!("/proc/{}/status", bridge.id())).unwrap();
    let kibibytes = |key: &str| -> f64 {
        let line = status.lines().find(|line| line.starts_with(key)).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    let (now, most) = (kibibytes("VmRSS:") / 1024.0, kibibytes("VmHWM:") / 1024.0);
    println!(
        "resident memory of a bridge that has driven a mission: {now:.1} MiB, at most {most:.1} MiB (aim: 15 MB)"
    );
}
