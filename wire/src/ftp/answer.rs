//! One answer of a file server.

use super::at;
use crate::Identity;
use crate::dialect::FILE_TRANSFER_PROTOCOL_DATA;
use crate::enums::{MAV_FTP_OPCODE_ACK, MAV_FTP_OPCODE_NAK};

/// One answer, before it is put into a message.
pub(super) enum Answer<'a> {
    /// It is done.
    Done,
    /// It is done, and this came out: the size of a file in bytes, or its checksum.
    Number(u32),
    /// A piece of a file.
    Data { offset: usize, bytes: &'a [u8], burst_complete: bool },
    /// It is not done: MAV_FTP_ERR.
    Refused(u8),
}

impl Answer<'_> {
    pub(super) fn message(
        &self,
        to: Identity,
        request: &FILE_TRANSFER_PROTOCOL_DATA,
        sequence: u16,
    ) -> FILE_TRANSFER_PROTOCOL_DATA {
        let mut payload = [0; 251];
        payload[..2].copy_from_slice(&sequence.to_le_bytes());
        payload[at::SESSION] = request.payload[at::SESSION];
        payload[at::REQUEST_OPCODE] = request.payload[at::OPCODE];
        payload[at::OPCODE] = MAV_FTP_OPCODE_ACK;
        match self {
            Self::Done => {}
            Self::Number(number) => {
                payload[at::SIZE] = 4;
                payload[at::DATA..at::DATA + 4].copy_from_slice(&number.to_le_bytes());
            }
            Self::Data { offset, bytes, burst_complete } => {
                payload[at::SIZE] = bytes.len() as u8;
                payload[at::BURST_COMPLETE] = u8::from(*burst_complete);
                let offset = u32::try_from(*offset).unwrap_or(u32::MAX).to_le_bytes();
                payload[at::OFFSET..at::OFFSET + 4].copy_from_slice(&offset);
                payload[at::DATA..at::DATA + bytes.len()].copy_from_slice(bytes);
            }
            Self::Refused(error) => {
                payload[at::OPCODE] = MAV_FTP_OPCODE_NAK;
                payload[at::SIZE] = 1;
                payload[at::DATA] = *error;
            }
        }
        FILE_TRANSFER_PROTOCOL_DATA {
            target_network: 0,
            target_system: to.system,
            target_component: to.component,
            payload,
        }
    }
}
