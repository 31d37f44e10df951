//! One MAVLink frame: header, payload, decoding.
//!
//! Layout: <https://mavlink.io/en/guide/serialization.html>.

use mavlink_core::error::ParserError;
use thiserror::Error;

use crate::candidate::{self, Verdict};
use crate::dialect::{MavlinkVersion, Message, MessageSet};
use crate::layout::{self, MAX_PAYLOAD, SIGNATURE_LENGTH};

/// Which MAVLink protocol a frame is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Version {
    /// MAVLink 1: marker 0xFE, message ids up to 255, no extension fields.
    V1,
    /// MAVLink 2: marker 0xFD, trailing zeroes of the payload left out, optional signature.
    V2,
}

impl Version {
    pub(crate) fn codec(self) -> MavlinkVersion {
        match self {
            Self::V1 => MavlinkVersion::V1,
            Self::V2 => MavlinkVersion::V2,
        }
    }
}

/// Who sends: a system (vehicle or ground station) and a component of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Identity {
    /// System id, 1 to 255.
    pub system: u8,
    /// Component id, 1 to 255 (`MAV_COMP_ID_...`).
    pub component: u8,
}

impl std::fmt::Display for Identity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.system, self.component)
    }
}

/// One whole frame, borrowed from the buffer it arrived in.
///
/// The checksum of a frame has been verified unless [`Frame::is_verified`] says otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    bytes: &'a [u8],
    version: Version,
    verified: bool,
}

impl<'a> Frame<'a> {
    /// The frame that `bytes` consist of, no more and no less.
    ///
    /// # Errors
    /// [`FrameError`] if the bytes are not exactly one frame with a right checksum.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FrameError> {
        match candidate::inspect(bytes) {
            Verdict::Verified(length) if length == bytes.len() => Ok(Self::new(bytes, true)),
            Verdict::Verified(length) => Err(FrameError::TrailingBytes { length, found: bytes.len() }),
            Verdict::Unknown { id, .. } => Err(FrameError::UnknownMessage { id }),
            Verdict::Damaged(_) => Err(FrameError::Checksum),
            Verdict::Incompatible { flags } => Err(FrameError::Incompatible { flags }),
            Verdict::Incomplete => Err(FrameError::Incomplete { found: bytes.len() }),
            Verdict::Noise => Err(FrameError::NoMarker),
        }
    }

    /// The frame that `bytes` begin with; whatever follows it does not matter.
    ///
    /// # Errors
    /// [`FrameError`] if no frame with a right checksum starts there, [`FrameError::Incomplete`] if more bytes
    /// could make one.
    pub fn parse_first(bytes: &'a [u8]) -> Result<Self, FrameError> {
        match candidate::inspect(bytes) {
            Verdict::Verified(length) => Ok(Self::new(&bytes[..length], true)),
            _ => Self::parse(bytes),
        }
    }

    /// `bytes` have been found to be one whole frame by [`candidate::inspect`].
    pub(crate) fn new(bytes: &'a [u8], verified: bool) -> Self {
        let version = if bytes[0] == layout::MARKER_V1 { Version::V1 } else { Version::V2 };
        Self { bytes, version, verified }
    }

    /// The protocol the frame is written in.
    pub fn version(&self) -> Version {
        self.version
    }

    /// The sender's sequence number, counting its frames modulo 256.
    pub fn sequence(&self) -> u8 {
        self.bytes[self.identity_at() - 1]
    }

    /// The sender.
    pub fn identity(&self) -> Identity {
        let at = self.identity_at();
        Identity { system: self.bytes[at], component: self.bytes[at + 1] }
    }

    /// The message id: 0 to 255 in MAVLink 1, 24 bits in MAVLink 2.
    pub fn message_id(&self) -> u32 {
        layout::message_id(self.bytes, self.version)
    }

    /// The message's name, such as `HEARTBEAT`; `None` if the dialect does not know the id.
    pub fn name(&self) -> Option<&'static str> {
        Message::default_message_from_id(self.message_id()).map(|message| message.message_name())
    }

    /// The payload as sent: without the zeroes that MAVLink 2 leaves out at its end.
    pub fn payload(&self) -> &'a [u8] {
        let start = layout::header_length(self.version);
        &self.bytes[start..start + usize::from(self.bytes[1])]
    }

    /// The whole frame, marker to checksum or signature.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Whether a signature is attached. It has not been checked here.
    pub fn is_signed(&self) -> bool {
        self.signature().is_some()
    }

    /// The signature: link id, 48-bit time stamp, 48-bit digest.
    pub fn signature(&self) -> Option<&'a [u8; SIGNATURE_LENGTH]> {
        let signed = self.version == Version::V2 && self.bytes[2] & layout::FLAG_SIGNED != 0;
        if signed { self.bytes.last_chunk() } else { None }
    }

    /// Whether the checksum has been verified.
    ///
    /// It cannot be for an id that the dialect does not know, because the checksum covers the message's
    /// definition. Such a frame may be passed on, never acted on: it may not be a frame at all.
    pub fn is_verified(&self) -> bool {
        self.verified
    }

    /// The message in the frame.
    ///
    /// A payload longer than the definition known here (fields added since) decodes to the known fields.
    ///
    /// # Errors
    /// [`DecodeError`] if the id is unknown or a MAVLink 1 payload lacks fields.
    pub fn decode(&self) -> Result<Message, DecodeError> {
        let id = self.message_id();
        let payload = self.payload();
        let message = Message::parse(self.version.codec(), id, payload).map_err(|error| match error {
            ParserError::UnknownMessage { .. } => DecodeError::UnknownMessage { id },
            other => DecodeError::Payload { id, cause: other.to_string() },
        })?;
        // MAVLink 1 leaves nothing out: what a short payload lacks is missing, not zero.
        if self.version == Version::V1 {
            let needed = message.ser(MavlinkVersion::V1, &mut [0; MAX_PAYLOAD]);
            if payload.len() < needed {
                return Err(DecodeError::TooShort {
                    name: message.message_name(),
                    needed,
                    found: payload.len(),
                });
            }
        }
        Ok(message)
    }

    fn identity_at(&self) -> usize {
        match self.version {
            Version::V1 => 3,
            Version::V2 => 5,
        }
    }
}

/// Why bytes are not one frame.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FrameError {
    /// The first byte is no frame marker.
    #[error("no frame starts here: expected marker 0xFD (MAVLink 2) or 0xFE (MAVLink 1)")]
    NoMarker,
    /// The frame is cut off.
    #[error("the frame is cut off after {found} bytes")]
    Incomplete {
        /// Bytes there are.
        found: usize,
    },
    /// More bytes follow the frame.
    #[error("the frame ends after {length} of {found} bytes: pass one frame at a time, or use a Framer")]
    TrailingBytes {
        /// Length of the frame, bytes.
        length: usize,
        /// Bytes there are.
        found: usize,
    },
    /// The checksum does not fit.
    #[error("wrong checksum: the frame was damaged, or its sender defines the message differently")]
    Checksum,
    /// Incompatibility flags that this implementation does not understand.
    #[error("incompatibility flags {flags:#04x}: only 0x01 (signed) is understood")]
    Incompatible {
        /// The flags, of which at least one is not understood.
        flags: u8,
    },
    /// The dialect lacks the message, so that the checksum cannot be verified.
    #[error("message id {id} is not in the ardupilotmega dialect, so its checksum cannot be verified")]
    UnknownMessage {
        /// The message id.
        id: u32,
    },
}

/// Why a frame's payload is not a message.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum DecodeError {
    /// The dialect lacks the message.
    #[error("message id {id} is not in the ardupilotmega dialect: ignore the frame or pass it on undecoded")]
    UnknownMessage {
        /// The message id.
        id: u32,
    },
    /// A MAVLink 1 payload lacks fields.
    #[error("{name} needs {needed} payload bytes in MAVLink 1, the frame has {found}: its sender is faulty")]
    TooShort {
        /// The message's name.
        name: &'static str,
        /// Payload length without extension fields, bytes.
        needed: usize,
        /// Payload length found, bytes.
        found: usize,
    },
    /// The codec refuses the payload.
    #[error("message id {id} cannot be decoded: {cause}")]
    Payload {
        /// The message id.
        id: u32,
        /// What the codec says.
        cause: String,
    },
}
