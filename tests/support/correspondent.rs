//! Somebody on the other end of a UDP link, for tests that need single frames rather than a whole ground station.

use std::net::UdpSocket;
use std::time::{Duration, Instant};

use helmlink_wire::dialect::{HEARTBEAT_DATA, MessageSet};
use helmlink_wire::{Encoder, Frame, Framer, Identity, Message, enums};

use super::process::PATIENCE;

/// A flight controller.
pub const BOAT: Identity = Identity { system: 1, component: 1 };
/// The bridge that steers it.
pub const BRIDGE: Identity = Identity { system: 1, component: 191 };
/// A ground station.
pub const STATION: Identity = Identity { system: 255, component: 190 };

/// Says and hears frames at one UDP address.
pub struct Correspondent {
    socket: UdpSocket,
    encoder: Encoder,
    framer: Framer,
}

impl Correspondent {
    /// One who writes to `HOST:PORT`, from a port of his own.
    pub fn of(address: &str) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(address).unwrap();
        Self::from(socket)
    }

    /// One who hears what comes to `socket`.
    pub fn from(socket: UdpSocket) -> Self {
        Self { socket, encoder: Encoder::new(), framer: Framer::new() }
    }

    /// Sends one message.
    pub fn say(&mut self, from: Identity, message: &Message) {
        self.socket.send(&frame(&mut self.encoder, from, message)).unwrap();
    }

    /// The first frame that `wanted` takes something from; `what` it is, for the complaint when none comes.
    pub fn hear<T>(&mut self, what: &str, mut wanted: impl FnMut(&Frame<'_>) -> Option<T>) -> T {
        let deadline = Instant::now() + PATIENCE;
        let mut buffer = [0; 4096];
        loop {
            // What came with the last one is still there.
            while let Some(frame) = self.framer.next_frame() {
                if let Some(found) = wanted(&frame) {
                    return found;
                }
            }
            let left = deadline.saturating_duration_since(Instant::now());
            assert!(left > Duration::ZERO, "waited in vain for {what}");
            self.socket.set_read_timeout(Some(left)).unwrap();
            // Out of time: said above.
            let Ok(count) = self.socket.recv(&mut buffer) else { continue };
            self.framer.push(&buffer[..count]);
            self.framer.end_of_datagram();
        }
    }

    /// The first message of the bridge that `wanted` takes something from.
    pub fn hear_bridge<T>(&mut self, what: &str, wanted: impl Fn(&Message) -> Option<T>) -> T {
        self.hear(what, |frame| {
            let message = frame.decode().ok().filter(|_| frame.identity() == BRIDGE)?;
            wanted(&message)
        })
    }
}

/// One frame as bytes.
pub fn frame(encoder: &mut Encoder, from: Identity, message: &Message) -> Vec<u8> {
    let mut bytes = Vec::new();
    encoder.encode(from, message, &mut bytes);
    bytes
}

/// What a disarmed boat in MANUAL says of itself.
pub fn boat_heartbeat() -> Message {
    Message::HEARTBEAT(HEARTBEAT_DATA {
        mavtype: enums::MAV_TYPE_SURFACE_BOAT,
        autopilot: enums::MAV_AUTOPILOT_ARDUPILOTMEGA,
        base_mode: enums::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
        system_status: enums::MAV_STATE_STANDBY,
        mavlink_version: 3,
        ..HEARTBEAT_DATA::DEFAULT
    })
}
