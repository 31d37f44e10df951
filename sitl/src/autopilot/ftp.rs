//! FILE_TRANSFER_PROTOCOL, as far as is needed to say at once that there are no files
//! (<https://mavlink.io/en/services/ftp.html>). Clients then fall back to what needs none.

use helmlink_wire::Identity;
use helmlink_wire::dialect::{FILE_TRANSFER_PROTOCOL_DATA, Message};
use helmlink_wire::enums::*;

/// Places of the header fields in the payload.
mod at {
    pub(super) const SESSION: usize = 2;
    pub(super) const OPCODE: usize = 3;
    pub(super) const SIZE: usize = 4;
    pub(super) const REQUEST_OPCODE: usize = 5;
    pub(super) const DATA: usize = 12;
}

/// The answer to a request of `from`; `None` if it is itself an answer.
pub(super) fn answer(from: Identity, request: &FILE_TRANSFER_PROTOCOL_DATA) -> Option<Message> {
    let opcode = request.payload[at::OPCODE];
    let error = match opcode {
        MAV_FTP_OPCODE_ACK | MAV_FTP_OPCODE_NAK => return None,
        // There is never a session to end: that is a success.
        MAV_FTP_OPCODE_TERMINATESESSION | MAV_FTP_OPCODE_RESETSESSION => None,
        MAV_FTP_OPCODE_OPENFILERO | MAV_FTP_OPCODE_LISTDIRECTORY | MAV_FTP_OPCODE_CALCFILECRC => {
            Some(MAV_FTP_ERR_FILENOTFOUND)
        }
        MAV_FTP_OPCODE_READFILE | MAV_FTP_OPCODE_BURSTREADFILE | MAV_FTP_OPCODE_WRITEFILE => {
            Some(MAV_FTP_ERR_INVALIDSESSION)
        }
        _ => Some(MAV_FTP_ERR_UNKNOWNCOMMAND),
    };
    let mut payload = [0; 251];
    let sequence = u16::from_le_bytes([request.payload[0], request.payload[1]]).wrapping_add(1);
    payload[..2].copy_from_slice(&sequence.to_le_bytes());
    payload[at::SESSION] = request.payload[at::SESSION];
    payload[at::REQUEST_OPCODE] = opcode;
    match error {
        None => payload[at::OPCODE] = MAV_FTP_OPCODE_ACK,
        Some(error) => {
            payload[at::OPCODE] = MAV_FTP_OPCODE_NAK;
            payload[at::SIZE] = 1;
            payload[at::DATA] = error;
        }
    }
    Some(Message::FILE_TRANSFER_PROTOCOL(FILE_TRANSFER_PROTOCOL_DATA {
        target_network: 0,
        target_system: from.system,
        target_component: from.component,
        payload,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GCS: Identity = Identity { system: 255, component: 190 };

    fn request(opcode: u8) -> FILE_TRANSFER_PROTOCOL_DATA {
        let mut payload = [0; 251];
        payload[..4].copy_from_slice(&[0xFF, 0xFF, 7, opcode]);
        FILE_TRANSFER_PROTOCOL_DATA { payload, ..FILE_TRANSFER_PROTOCOL_DATA::DEFAULT }
    }

    #[test]
    fn every_request_is_answered_and_no_answer_is() {
        for opcode in 0..=u8::MAX {
            let Some(Message::FILE_TRANSFER_PROTOCOL(reply)) = answer(GCS, &request(opcode)) else {
                assert!(matches!(opcode, 128 | 129), "{opcode}");
                continue;
            };
            assert_eq!(reply.payload[..3], [0, 0, 7], "sequence plus one, session echoed");
            assert_eq!(reply.payload[at::REQUEST_OPCODE], opcode);
            let ends_session = matches!(opcode, 1 | 2);
            assert_eq!(reply.payload[at::OPCODE], if ends_session { 128 } else { 129 });
            assert_eq!((reply.target_system, reply.target_component), (255, 190));
        }
    }

    #[test]
    fn opening_a_file_says_that_it_is_not_there() {
        let Some(Message::FILE_TRANSFER_PROTOCOL(reply)) = answer(GCS, &request(4)) else { panic!() };
        assert_eq!((reply.payload[at::SIZE], reply.payload[at::DATA]), (1, 10));
    }
}
