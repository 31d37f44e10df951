//! Bounds and waiting times of the transports.

use std::time::Duration;

use super::usb::Places;

/// Bounds and waiting times of a [`Hub`](super::Hub). All times run on tokio's clock, which tests can pause.
#[derive(Debug, Clone)]
pub struct LinkSettings {
    /// Bytes that may wait for one network peer. When more are sent, the oldest waiting writes are lost:
    /// an old command to a boat is worth less than a new one. Answers outlast the rest
    /// ([`helmlink_wire::outbox`]). Default 64 KiB.
    pub queue_bytes: usize,
    /// Bytes that may wait for all peers of the hub together, who share them alike. Default 1 MiB.
    pub total_queue_bytes: usize,
    /// The same bound for a serial port, as the time its line needs to carry what waits. Default 0.5 s
    /// (5.6 KiB at 115200 bit/s).
    pub serial_queue: Duration,
    /// Events that may wait to be taken. When as many wait, TCP peers and serial ports are read no
    /// further and the system discards further datagrams. Default 1024.
    pub event_capacity: usize,
    /// A TCP peer or serial port that takes none of the bytes written to it for this long is dropped; so
    /// is a TCP peer whose machine has vanished, counted from the last sign of it. Default 10 s.
    pub write_stall: Duration,
    /// Longest attempt to connect to a TCP server, name resolution included. Default 5 s.
    pub connect_timeout: Duration,
    /// A remote of a listening UDP endpoint is forgotten when silent for this long. Default 60 s.
    pub udp_silence: Duration,
    /// Remotes that one listening UDP endpoint remembers; a further one takes the place of the one silent
    /// for longest. Default 256.
    pub udp_remotes_max: usize,
    /// Wait before the first attempt to reconnect. Default 100 ms.
    pub retry_first: Duration,
    /// Longest wait between attempts; each is twice the one before up to this. Default 5 s.
    pub retry_longest: Duration,
    /// Longest time that waiting bytes are still being written after the hub has been closed. Default 0.5 s.
    pub flush: Duration,
    /// Where the system shows USB devices; elsewhere in tests.
    pub(super) usb: Places,
}

impl Default for LinkSettings {
    fn default() -> Self {
        Self {
            queue_bytes: 64 * 1024,
            total_queue_bytes: 1024 * 1024,
            serial_queue: Duration::from_millis(500),
            event_capacity: 1024,
            write_stall: Duration::from_secs(10),
            connect_timeout: Duration::from_secs(5),
            udp_silence: Duration::from_secs(60),
            udp_remotes_max: 256,
            retry_first: Duration::from_millis(100),
            retry_longest: Duration::from_secs(5),
            flush: Duration::from_millis(500),
            usb: Places::default(),
        }
    }
}
