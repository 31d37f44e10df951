//! Ground stations read what the bridge's parameters are.

use helmlink_wire::dialect::{COMMAND_LONG_DATA, FILE_TRANSFER_PROTOCOL_DATA};
use helmlink_wire::ftp::{at, crc32};
use helmlink_wire::{Identity, Message, enums};
use serde_json::Value;

use super::rig::*;
use crate::bridge::parameters::PARAMETERS;
use crate::pilot::supervisor::State;
use crate::vehicle::OutputKind;

const COMPONENT_METADATA: u32 = 397;

fn under_way() -> Rig {
    Rig::under_way(Setup::new(OutputKind::RcOverride, true), |_| {})
}

fn request(target: Identity, opcode: u8, offset: usize, size: u8, data: &str) -> Message {
    let mut payload = [0; 251];
    payload[at::OPCODE] = opcode;
    payload[at::SIZE] = size;
    payload[at::OFFSET..at::DATA].copy_from_slice(&(offset as u32).to_le_bytes());
    payload[at::DATA..at::DATA + data.len()].copy_from_slice(data.as_bytes());
    Message::FILE_TRANSFER_PROTOCOL(FILE_TRANSFER_PROTOCOL_DATA {
        target_network: 0,
        target_system: target.system,
        target_component: target.component,
        payload,
    })
}

/// What one answers to a request within a second.
fn answers(rig: &mut Rig, target: Identity, request: &Message) -> Vec<[u8; 251]> {
    rig.heard_directly.clear();
    rig.say_directly(request);
    rig.run(1.0);
    let answers = rig.heard_directly.iter().filter_map(|(from, message)| match message {
        Message::FILE_TRANSFER_PROTOCOL(data) if *from == target => Some(data.payload),
        _ => None,
    });
    answers.collect()
}

/// Reads a whole file, burst by burst.
fn download(rig: &mut Rig, from: Identity, path: &str) -> Vec<u8> {
    let open = request(from, enums::MAV_FTP_OPCODE_OPENFILERO, 0, path.len() as u8, path);
    let opened = answers(rig, from, &open)[0];
    assert_eq!(opened[at::OPCODE], enums::MAV_FTP_OPCODE_ACK, "{path}");
    let size = u32::from_le_bytes(opened[at::DATA..at::DATA + 4].try_into().unwrap()) as usize;
    let mut file: Vec<u8> = Vec::new();
    while file.len() < size {
        let before = file.len();
        let burst = request(from, enums::MAV_FTP_OPCODE_BURSTREADFILE, before, 239, "");
        for piece in answers(rig, from, &burst) {
            assert_eq!(u32::from_le_bytes(piece[8..12].try_into().unwrap()) as usize, file.len());
            file.extend_from_slice(&piece[at::DATA..][..usize::from(piece[at::SIZE])]);
        }
        assert!(file.len() > before, "{path} ends after {before} of {size} bytes");
    }
    file
}

/// Checksum and place of a file, and where it is asked for.
fn metadata(rig: &mut Rig) -> (u32, String) {
    rig.heard_directly.clear();
    rig.say_directly(&Message::COMMAND_LONG(COMMAND_LONG_DATA {
        target_system: BRIDGE.system,
        target_component: BRIDGE.component,
        command: enums::MAV_CMD_REQUEST_MESSAGE,
        param1: COMPONENT_METADATA as f32,
        ..COMMAND_LONG_DATA::DEFAULT
    }));
    rig.run(0.1);
    let accepted = rig.heard_directly.iter().any(|(from, message)| {
        *from == BRIDGE
            && matches!(message, Message::COMMAND_ACK(data) if data.result == enums::MAV_RESULT_ACCEPTED)
    });
    assert!(accepted);
    let said = rig.heard_directly.iter().find_map(|(from, message)| match message {
        Message::COMPONENT_METADATA(data) if *from == BRIDGE => {
            Some((data.file_crc, data.uri.to_str().unwrap().to_owned()))
        }
        _ => None,
    });
    said.unwrap()
}

fn path(uri: &str) -> String {
    uri.strip_prefix("mftp://[;comp=191]").unwrap().to_owned()
}

#[test]
fn ranges_and_meanings_are_read_while_driving_and_stay_the_same() {
    let mut rig = under_way();
    let (crc, uri) = metadata(&mut rig);
    let file = download(&mut rig, BRIDGE, &path(&uri));
    assert_eq!(crc32(&file), crc);
    let general: Value = serde_json::from_slice(&file).unwrap();
    let listed = &general["metadataTypes"][0];
    assert_eq!(listed["type"], enums::COMP_METADATA_TYPE_PARAMETER);
    let file = download(&mut rig, BRIDGE, &path(listed["uri"].as_str().unwrap()));
    assert_eq!(listed["fileCrc"], crc32(&file));
    let described: Value = serde_json::from_slice(&file).unwrap();
    let names: Vec<&str> =
        described["parameters"].as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(names, PARAMETERS.iter().map(|parameter| parameter.name).collect::<Vec<_>>());
    assert_eq!(rig.state(), State::Engaged, "{:?}", rig.texts());
    // What is asked for later is the same file, whatever has been tuned in between.
    let now = rig.now;
    rig.bridge().station_link_up(now, DIRECT);
    assert_eq!(metadata(&mut rig), (crc, uri));
}

#[test]
fn files_leave_room_for_steering() {
    let mut rig = under_way();
    let name = "/parameter.json";
    let open = request(BRIDGE, enums::MAV_FTP_OPCODE_OPENFILERO, 0, name.len() as u8, name);
    answers(&mut rig, BRIDGE, &open);
    // More bursts than can be sent in a second, from many who each want one.
    rig.heard_directly.clear();
    let from = rig.steering.len();
    for _ in 0..100 {
        rig.say_directly(&request(BRIDGE, enums::MAV_FTP_OPCODE_BURSTREADFILE, 0, 239, ""));
        rig.run(0.04);
    }
    let is_piece = |message: &Message| matches!(message, Message::FILE_TRANSFER_PROTOCOL(_));
    let bytes_per_s = 266 * rig.heard_directly.iter().filter(|(_, message)| is_piece(message)).count() / 4;
    assert!((3000..=5300).contains(&bytes_per_s), "{bytes_per_s} bytes a second");
    let rate_hz = (rig.steering.len() - from) as f64 / 4.0;
    assert!(rate_hz >= 10.0, "{rate_hz} Hz");
}

#[test]
fn files_of_the_flight_controller_are_still_the_flight_controllers() {
    let mut rig = under_way();
    let file = download(&mut rig, VEHICLE, "@PARAM/param.pck");
    assert_eq!(file[..2], 0x671B_u16.to_le_bytes());
}

#[test]
fn what_is_wrong_is_refused_and_nothing_piles_up() {
    let mut rig = under_way();
    let mut refused = |opcode: u8, offset: usize, size: u8, data: &str| {
        let answers = answers(&mut rig, BRIDGE, &request(BRIDGE, opcode, offset, size, data));
        assert_eq!(answers.len(), 1, "{opcode}");
        let is_refused = answers[0][at::OPCODE] == enums::MAV_FTP_OPCODE_NAK;
        is_refused.then_some(answers[0][at::DATA])
    };
    let read = enums::MAV_FTP_OPCODE_READFILE;
    assert_eq!(refused(read, 0, 239, ""), Some(enums::MAV_FTP_ERR_INVALIDSESSION), "nothing is open");
    for wrong in ["/etc/passwd", "/../general.json", "//general.json", "@PARAM/param.pck", "", "/"] {
        let answer = refused(enums::MAV_FTP_OPCODE_OPENFILERO, 0, wrong.len() as u8, wrong);
        assert_eq!(answer, Some(enums::MAV_FTP_ERR_FILENOTFOUND), "{wrong}");
    }
    let name = "general.json";
    assert_eq!(refused(enums::MAV_FTP_OPCODE_OPENFILERO, 0, name.len() as u8, name), None);
    assert_eq!(refused(read, 4_000_000_000, 239, ""), Some(enums::MAV_FTP_ERR_EOF));
    for opcode in [enums::MAV_FTP_OPCODE_WRITEFILE, enums::MAV_FTP_OPCODE_REMOVEFILE, 77] {
        assert!(refused(opcode, 0, 10, name).is_some(), "{opcode}");
    }
    // Everybody asks, nobody waits for the answer.
    let name = "/parameter.json";
    for system in 0..=255 {
        for (opcode, data) in
            [(enums::MAV_FTP_OPCODE_OPENFILERO, name), (enums::MAV_FTP_OPCODE_BURSTREADFILE, "")]
        {
            let who = Identity { system, component: 7 };
            rig.say_directly_as(who, &request(BRIDGE, opcode, 0, name.len() as u8, data));
        }
    }
    let kept = rig.bridge().metadata.kept();
    assert!(kept.0 <= helmlink_wire::ftp::MAX_OPEN && kept.1 <= 64, "{kept:?}");
    rig.run(10.0);
    assert_eq!(rig.bridge().metadata.kept().1, 0, "all sent");
    assert_eq!(rig.state(), State::Engaged, "{:?}", rig.texts());
}
