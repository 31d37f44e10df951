//! Where things are in a frame (<https://mavlink.io/en/guide/serialization.html>).

use crate::frame::Version;

/// First byte of a MAVLink 1 frame.
pub(crate) const MARKER_V1: u8 = 0xFE;
/// First byte of a MAVLink 2 frame.
pub(crate) const MARKER_V2: u8 = 0xFD;
/// Incompatibility flag: 13 bytes of signature follow the checksum.
pub(crate) const FLAG_SIGNED: u8 = 0x01;
/// Longest payload, bytes.
pub(crate) const MAX_PAYLOAD: usize = 255;
/// Length of the checksum, bytes.
pub(crate) const CHECKSUM_LENGTH: usize = 2;
/// Length of a MAVLink 2 signature, bytes.
pub(crate) const SIGNATURE_LENGTH: usize = 13;
/// Longest frame: MAVLink 2 header, full payload, checksum, signature.
pub(crate) const MAX_FRAME: usize = 10 + MAX_PAYLOAD + CHECKSUM_LENGTH + SIGNATURE_LENGTH;

/// Whether a frame may start with `byte`.
pub(crate) fn is_marker(byte: u8) -> bool {
    byte == MARKER_V1 || byte == MARKER_V2
}

/// Bytes before the payload, marker included.
pub(crate) fn header_length(version: Version) -> usize {
    match version {
        Version::V1 => 6,
        Version::V2 => 10,
    }
}

/// The message id in a header that is all there.
pub(crate) fn message_id(header: &[u8], version: Version) -> u32 {
    match version {
        Version::V1 => u32::from(header[5]),
        Version::V2 => u32::from_le_bytes([header[7], header[8], header[9], 0]),
    }
}
