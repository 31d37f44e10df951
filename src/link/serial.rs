//! Serial ports: opened when they appear, and again after they were unplugged.

use std::io;
use std::path::PathBuf;

use serial2_tokio::SerialPort;

use super::backoff::{Backoff, Complaints};
use super::hub::Endpoint;
use super::peer::Peer;
use super::stream::{End, converse};
use super::usb::{Places, UsbDevice};

/// Bits on the line for one byte: start, eight data, stop.
const BITS_PER_BYTE: f64 = 10.0;
/// Least room for waiting writes, bytes: several of the longest MAVLink frames (280 bytes) even on the
/// slowest line.
const MIN_QUEUE_BYTES: usize = 1024;

/// Opens a serial port, and again whenever it is not there or is lost.
pub(super) fn open(endpoint: Endpoint, device: String, baud: u32) {
    let tasks = endpoint.clone();
    tasks.spawn(stay_open(endpoint, device, baud));
}

async fn stay_open(endpoint: Endpoint, device: String, baud: u32) {
    let mut backoff = Backoff::new(endpoint.settings.retry_first, endpoint.settings.retry_longest);
    let mut complaints = Complaints::default();
    loop {
        let opened = path_of(&device, &endpoint.settings.usb)
            .and_then(|path| Ok((SerialPort::open(&path, baud)?, path)));
        match opened {
            Ok((port, path)) => {
                complaints.reset();
                // A device that says nothing before it vanishes may do so each time.
                let name = format!("{} at {baud} bit/s", path.display());
                if serve(&endpoint, port, name, baud).await {
                    backoff.reset();
                }
            }
            Err(error) => {
                let reason = describe(&error);
                if complaints.is_news(&reason) {
                    tracing::warn!(%reason, %device, "cannot open the serial port yet; trying on");
                }
            }
        }
        if !endpoint.pause(backoff.next_delay()).await {
            return;
        }
    }
}

/// Where the device is just now.
fn path_of(device: &str, places: &Places) -> io::Result<PathBuf> {
    match UsbDevice::parse(device) {
        Some(usb) => usb.port(places),
        None => Ok(device.into()),
    }
}

/// Carries bytes until the port is lost; true when it has said anything.
async fn serve(endpoint: &Endpoint, mut port: SerialPort, name: String, baud: u32) -> bool {
    let peer = Peer::register(endpoint, name, queue_bytes(endpoint, baud));
    if peer.announce().await.is_err() {
        return false;
    }
    let (reader, writer) = tokio::io::split(&mut port);
    let end = converse(endpoint, &peer, reader, writer).await;
    if !matches!(end, End::HubClosed) {
        // Otherwise closing would wait, for up to half a minute on Linux, for a device that takes nothing.
        _ = port.discard_output_buffer();
    }
    drop(port);
    let heard = peer.outbox.traffic().received_bytes > 0;
    // Without a listener for events there is nobody to tell.
    _ = peer.leave(end.to_string()).await;
    heard
}

/// What the line carries in the time that writes may wait.
fn queue_bytes(endpoint: &Endpoint, baud: u32) -> usize {
    let bytes = endpoint.settings.serial_queue.as_secs_f64() * f64::from(baud) / BITS_PER_BYTE;
    (bytes as usize).clamp(MIN_QUEUE_BYTES, endpoint.settings.queue_bytes.max(MIN_QUEUE_BYTES))
}

/// An error of opening, with its cure where there is a usual one.
fn describe(error: &io::Error) -> String {
    let cure = match error.kind() {
        io::ErrorKind::NotFound => "plug the device in, or check its name",
        io::ErrorKind::PermissionDenied => "give this user access to it; on Linux, by the group `dialout`",
        io::ErrorKind::ResourceBusy => "end the program that holds it",
        _ => return error.to_string(),
    };
    format!("{error}: {cure}")
}

#[cfg(unix)]
#[cfg(test)]
mod tests;
