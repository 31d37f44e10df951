//! Links that break on purpose, under the real bridge and the real simulated boat: it finds its way back by itself.

#![cfg(unix)]
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

mod support;

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::thread;

use support::Helmlink;

const FOUND: &str = "found the flight controller";

/// Carries bytes between two sockets until one of them ends.
fn join(one: &TcpStream, other: &TcpStream) {
    let carry = |mut from: TcpStream, mut to: TcpStream| {
        move || {
            let mut buffer = [0; 4096];
            while let Ok(count @ 1..) = from.read(&mut buffer) {
                if to.write_all(&buffer[..count]).is_err() {
                    break;
                }
            }
            to.shutdown(Shutdown::Both).ok();
        }
    };
    thread::spawn(carry(one.try_clone().unwrap(), other.try_clone().unwrap()));
    thread::spawn(carry(other.try_clone().unwrap(), one.try_clone().unwrap()));
}

/// The place in a line such as `listening at udpin:127.0.0.1:0 (127.0.0.1:41234)`.
fn place(line: &str) -> String {
    line.rsplit_once('(').unwrap().1.trim_end_matches(')').to_owned()
}

#[test]
fn a_cut_tcp_connection_is_made_again() {
    let (_boat, address) = Helmlink::sitl("tcpin", &[]);
    let between = TcpListener::bind("127.0.0.1:0").unwrap();
    let connect = format!("tcp:{}", between.local_addr().unwrap());
    let bridge = Helmlink::start(&["bridge", "--connect", &connect]);
    for _ in 0..3 {
        let (to_bridge, _) = between.accept().unwrap();
        let to_boat = TcpStream::connect(&address).unwrap();
        join(&to_bridge, &to_boat);
        bridge.wait_for_line(FOUND);
        to_bridge.shutdown(Shutdown::Both).unwrap();
        bridge.wait_for_line("the link to the flight controller went down");
    }
}

#[test]
fn a_boat_that_comes_back_from_another_udp_port_is_found_there() {
    let bridge = Helmlink::start(&["bridge", "--connect", "udpin:127.0.0.1:0", "--wait", "0"]);
    let listen = format!("udpout:{}", place(&bridge.wait_for_line("listening at")));
    for _ in 0..2 {
        let _boat = Helmlink::start(&["sitl", "--listen", &listen]);
        bridge.wait_for_line(FOUND);
    }
}
