//! Messages in, bytes out.

use std::collections::BTreeMap;

use thiserror::Error;

use crate::candidate::crc_extra;
use crate::checksum::checksum;
use crate::dialect::{Message, MessageSet};
use crate::frame::{Identity, Version};
use crate::layout::{self, MAX_PAYLOAD};

/// Writes the frames of one link, with a sequence number of its own for each sender.
#[derive(Debug, Clone, Default)]
pub struct Encoder {
    /// The sequence number of each sender's next frame.
    next: BTreeMap<Identity, u8>,
}

impl Encoder {
    /// An encoder whose senders all start at sequence number 0.
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends `message` to `out` as one MAVLink 2 frame, unsigned, trailing zeroes of the payload left out.
    pub fn encode(&mut self, from: Identity, message: &Message, out: &mut Vec<u8>) {
        let sequence = self.next_sequence(from);
        let [id_low, id_middle, id_high, _] = message.message_id().to_le_bytes();
        let (no_flags, length_later) = (0, 0);
        out.reserve(layout::MAX_FRAME);
        let start = out.len();
        out.extend_from_slice(&[
            layout::MARKER_V2,
            length_later,
            no_flags,
            no_flags,
            sequence,
            from.system,
            from.component,
            id_low,
            id_middle,
            id_high,
        ]);
        append_payload_and_checksum(Version::V2, message, start, out);
    }

    /// Appends `message` to `out` as one MAVLink 1 frame, without extension fields.
    ///
    /// # Errors
    /// [`EncodeError::NeedsMavlink2`] if the message id does not fit; nothing is appended then.
    pub fn encode_v1(
        &mut self,
        from: Identity,
        message: &Message,
        out: &mut Vec<u8>,
    ) -> Result<(), EncodeError> {
        let id = message.message_id();
        let short_id =
            u8::try_from(id).map_err(|_| EncodeError::NeedsMavlink2 { id, name: message.message_name() })?;
        let sequence = self.next_sequence(from);
        let length_later = 0;
        out.reserve(layout::MAX_FRAME);
        let start = out.len();
        out.extend_from_slice(&[
            layout::MARKER_V1,
            length_later,
            sequence,
            from.system,
            from.component,
            short_id,
        ]);
        append_payload_and_checksum(Version::V1, message, start, out);
        Ok(())
    }

    fn next_sequence(&mut self, from: Identity) -> u8 {
        let next = self.next.entry(from).or_insert(0);
        let sequence = *next;
        *next = sequence.wrapping_add(1);
        sequence
    }
}

/// `message` as one frame with a sequence number of the caller's choice: for a frame that takes another's place.
///
/// Where a MAVLink 1 frame cannot hold the message it becomes one of MAVLink 2.
pub fn encode_numbered(version: Version, from: Identity, sequence: u8, message: &Message) -> Vec<u8> {
    let mut encoder = Encoder::new();
    encoder.next.insert(from, sequence);
    let mut out = Vec::new();
    if version == Version::V2 || encoder.encode_v1(from, message, &mut out).is_err() {
        encoder.encode(from, message, &mut out);
    }
    out
}

/// Completes the frame whose header starts at `start` and ends `out`.
fn append_payload_and_checksum(version: Version, message: &Message, start: usize, out: &mut Vec<u8>) {
    let mut payload = [0; MAX_PAYLOAD];
    let length = message.ser(version.codec(), &mut payload);
    out.extend_from_slice(&payload[..length]);
    out[start + 1] = length as u8; // the codec writes at most 255 bytes: that is all the buffer holds
    let extra = crc_extra(message.message_id()).unwrap_or_default(); // every `Message` is in the dialect
    let sum = checksum(&out[start + 1..], extra);
    out.extend_from_slice(&sum.to_le_bytes());
}

/// Why a message cannot be written.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// MAVLink 1 has one byte for the message id.
    #[error(
        "{name} (id {id}) cannot be sent in MAVLink 1, which ends at id 255: switch the link to MAVLink 2"
    )]
    NeedsMavlink2 {
        /// The message id.
        id: u32,
        /// The message's name.
        name: &'static str,
    },
}
