//! A real ground station that signs, at the bridge's link.

#![cfg(unix)]

mod support;

use std::fs;
use std::os::unix::fs::PermissionsExt;

use support::{Helmlink, Script};

const PASSPHRASE: &str = "correct horse battery staple";

#[test]
fn pymavlink_signs_and_the_bridge_answers_nobody_else() {
    let folder = std::env::temp_dir().join(format!("helmlink-signed-link-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let key = folder.join("key");
    fs::write(&key, format!("{PASSPHRASE}\n")).unwrap();
    fs::set_permissions(&key, fs::Permissions::from_mode(0o600)).unwrap();

    let (_boat, address) = Helmlink::sitl("tcpin", &[]);
    let bridge = Helmlink::start(&[
        "bridge",
        "--connect",
        &format!("tcp:{address}"),
        "--gcs",
        "udpin:127.0.0.1:0",
        "--sign",
        "gcs",
        "--signing-key",
        key.to_str().unwrap(),
        "--state-dir",
        folder.to_str().unwrap(),
    ]);
    let line = bridge.wait_for_line("listening at");
    let place = line.rsplit_once('(').unwrap().1.trim_end_matches(')');
    bridge.wait_for_line("found the flight controller");
    Script::run("pymavlink_signing.py", &[&format!("udpout:{place}"), PASSPHRASE]);
    fs::remove_dir_all(&folder).ok();
}
