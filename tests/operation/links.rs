//! Links that break on purpose, under the real bridge and the real simulated boat: it finds its way back by itself.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::os::fd::OwnedFd;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use helmlink_wire::Encoder;
use helmlink_wire::dialect::MessageSet;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use socket2::SockRef;

use crate::support::correspondent::{BOAT, boat_heartbeat, frame};
use crate::support::process::PATIENCE;
use crate::support::{Correspondent, Folder, Helmlink};

const FOUND: &str = "found the flight controller";
const FOLLOWED: &str = "heard on another link: followed there";
const LOST: &str = "the link to the flight controller went down";

/// A boat's heartbeat as bytes.
fn heartbeat() -> Vec<u8> {
    frame(&mut Encoder::new(), BOAT, &boat_heartbeat())
}

/// How often a flight controller says that it is there; faster than real ones, to be short.
const HEARTBEAT_INTERVAL: Duration = Duration::from_millis(100);

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
        bridge.wait_for_line(LOST);
    }
}

#[test]
fn a_boat_that_comes_back_from_another_udp_port_is_found_there() {
    let bridge = Helmlink::start(&["bridge", "--connect", "udpin:127.0.0.1:0", "--wait", "0"]);
    let listen = format!("udpout:{}", bridge.wait_for_place());
    for said in [FOUND, FOLLOWED] {
        let _boat = Helmlink::start(&["sitl", "--listen", &listen]);
        bridge.wait_for_line(said);
    }
}

#[test]
fn a_reset_tcp_connection_is_made_again() {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let connect = format!("tcp:{}", server.local_addr().unwrap());
    let bridge = Helmlink::start(&["bridge", "--connect", &connect, "--wait", "0"]);
    for _ in 0..3 {
        let (mut stream, _) = server.accept().unwrap();
        stream.write_all(&heartbeat()).unwrap();
        bridge.wait_for_line(FOUND);
        // Closing a socket that does not linger resets the connection.
        SockRef::from(&stream).set_linger(Some(Duration::ZERO)).unwrap();
        drop(stream);
        bridge.wait_for_line(LOST);
    }
}

#[test]
fn a_flight_controller_that_goes_on_from_another_udp_port_is_followed_there() {
    let bridge = Helmlink::start(&["bridge", "--connect", "udpin:127.0.0.1:0", "--wait", "0"]);
    let place = bridge.wait_for_place();
    let mut old = Correspondent::of(&place);
    old.say(BOAT, &boat_heartbeat());
    bridge.wait_for_line(FOUND);
    old.hear_bridge("a question at the old port", |message| (message.message_id() != 0).then_some(()));
    // The old port stays silent from now on, and nothing tells the bridge so.
    let mut new = Correspondent::of(&place);
    let deadline = Instant::now() + PATIENCE;
    while !bridge.printed().contains(FOLLOWED) {
        assert!(Instant::now() < deadline, "not followed: {}", bridge.printed());
        new.say(BOAT, &boat_heartbeat());
        thread::sleep(HEARTBEAT_INTERVAL);
    }
    new.hear_bridge("a question at the new port", |message| (message.message_id() != 0).then_some(()));
}

/// A name in a folder like `/dev/serial/by-id`, which leads to whatever terminal the device has got this time.
struct ById<'a>(&'a Path);

impl ById<'_> {
    /// Plugs a device in; returns the far end of its line.
    fn plug(&self) -> OwnedFd {
        let far = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&far).unwrap();
        unlockpt(&far).unwrap();
        symlink(ptsname(&far, Vec::new()).unwrap().to_str().unwrap(), self.0).unwrap();
        far
    }

    /// Pulls it out: the name goes, and the line hangs up.
    fn unplug(&self, far: OwnedFd) {
        std::fs::remove_file(self.0).unwrap();
        drop(far);
    }
}

#[test]
fn a_serial_device_that_comes_back_under_another_name_is_found_by_its_id() {
    let folder = Folder::new("by-id");
    let name = folder.0.join("usb-ArduPilot_CubeOrange-if00");
    let socket = ById(&name);
    let device = format!("serial:{}:115200", name.display());
    let bridge = Helmlink::start(&["bridge", "--connect", &device, "--wait", "0"]);
    // Another device takes the name that has become free, as the next one does on a USB bus.
    let mut others = Vec::new();
    for _ in 0..3 {
        let far = socket.plug();
        bridge.wait_for_line("link up");
        rustix::io::write(&far, &heartbeat()).unwrap();
        bridge.wait_for_line(FOUND);
        socket.unplug(far);
        others.push(openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap());
        bridge.wait_for_line(LOST);
    }
}
