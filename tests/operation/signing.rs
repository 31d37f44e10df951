//! A real ground station that signs, at the bridge's link; and what outlives the bridge.

use std::fs;
use std::os::unix::fs::PermissionsExt;

use crate::support::{Correspondent, Folder, Helmlink, Script};

const PASSPHRASE: &str = "correct horse battery staple";

/// What the bridge keeps the time stamp of its signatures in.
const TIMESTAMP_FILE: &str = "signing-timestamp";

/// A folder with a key in it.
fn with_key(name: &str) -> Folder {
    let folder = Folder::new(name);
    let key = folder.0.join("key");
    fs::write(&key, format!("{PASSPHRASE}\n")).unwrap();
    fs::set_permissions(&key, fs::Permissions::from_mode(0o600)).unwrap();
    folder
}

/// A bridge that signs with the key in the folder.
fn start_bridge(folder: &Folder, options: &[&str]) -> Helmlink {
    let key = folder.0.join("key");
    let arguments = ["bridge", "--signing-key", key.to_str().unwrap(), "--state-dir", folder.path()];
    Helmlink::start(&[&arguments, options].concat())
}

/// The time stamp of the first signed frame that a bridge sends to a remote, in 10 microseconds since 2015.
fn first_timestamp(folder: &Folder) -> u64 {
    let remote = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let url = format!("udpout:{}", remote.local_addr().unwrap());
    let mut bridge = start_bridge(folder, &["--connect", &url, "--wait", "0"]);
    let timestamp = Correspondent::from(remote).hear("a signed frame", |frame| {
        let mut units = [0; 8];
        // Behind the link id, before the digest.
        units[..6].copy_from_slice(&frame.signature()?[1..7]);
        Some(u64::from_le_bytes(units))
    });
    // Long before it would have been saved again.
    bridge.kill();
    timestamp
}

#[test]
fn a_killed_bridge_never_signs_with_a_time_stamp_twice_even_when_the_clock_has_gone_back() {
    let folder = with_key("timestamps");
    // As a clock that was right only once would have left it: 2050.
    let far: u64 = 110_000_000_000_000;
    fs::write(folder.0.join(TIMESTAMP_FILE), format!("{far}\n")).unwrap();
    let first = first_timestamp(&folder);
    assert!(first > far, "{first}");
    let second = first_timestamp(&folder);
    assert!(second > first, "{second} after {first}");
}

#[test]
fn pymavlink_signs_and_the_bridge_answers_nobody_else() {
    let folder = with_key("signed-link");
    let (_boat, address) = Helmlink::sitl("tcpin", &[]);
    let connect = format!("tcp:{address}");
    let bridge =
        start_bridge(&folder, &["--connect", &connect, "--gcs", "udpin:127.0.0.1:0", "--sign", "gcs"]);
    let place = bridge.wait_for_place();
    bridge.wait_for_line("found the flight controller");
    Script::run("pymavlink_signing.py", &[&format!("udpout:{place}"), PASSPHRASE]);
}
