//! Whether bytes that may be a frame are one.

use crate::checksum::checksum;
use crate::dialect::{MavMessage, MessageSet};
use crate::frame::Version;
use crate::layout::{self, CHECKSUM_LENGTH, FLAG_SIGNED, SIGNATURE_LENGTH};

/// What the bytes at some place turn out to be. Lengths are of the whole frame, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// No frame starts here.
    Noise,
    /// A MAVLink 2 header with incompatibility flags that nobody here understands: the protocol says discard.
    Incompatible { flags: u8 },
    /// More bytes are needed to tell.
    Incomplete,
    /// A known message with a wrong checksum.
    Damaged(usize),
    /// An id that the dialect lacks: nobody can tell whether the checksum is right.
    Unknown { id: u32, length: usize },
    /// A frame.
    Verified(usize),
}

/// Judges the frame that would start with the first of `bytes`; what follows it does not matter.
pub(crate) fn inspect(bytes: &[u8]) -> Verdict {
    let Some(&marker) = bytes.first() else { return Verdict::Incomplete };
    let version = match marker {
        layout::MARKER_V1 => Version::V1,
        layout::MARKER_V2 => Version::V2,
        _ => return Verdict::Noise,
    };
    let mut trailer = CHECKSUM_LENGTH;
    if version == Version::V2
        && let Some(&flags) = bytes.get(2)
    {
        if flags & !FLAG_SIGNED != 0 {
            return Verdict::Incompatible { flags };
        }
        if flags & FLAG_SIGNED != 0 {
            trailer += SIGNATURE_LENGTH;
        }
    }
    let header = layout::header_length(version);
    if bytes.len() < header {
        return Verdict::Incomplete;
    }
    let checked = header + usize::from(bytes[1]);
    let length = checked + trailer;
    if bytes.len() < length {
        return Verdict::Incomplete;
    }
    let id = layout::message_id(bytes, version);
    let Some(extra) = crc_extra(id) else { return Verdict::Unknown { id, length } };
    let found = u16::from_le_bytes([bytes[checked], bytes[checked + 1]]);
    if checksum(&bytes[1..checked], extra) == found {
        Verdict::Verified(length)
    } else {
        Verdict::Damaged(length)
    }
}

/// So many frames of unknown messages in a row are believed without a verified one behind them.
const UNKNOWN_CHAIN: usize = 3;

/// Whether a [`Verdict::Unknown`] is believed to be a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Belief {
    Yes,
    No,
    NeedsMoreBytes,
}

/// Whether the first `length` of `bytes`, which claim to be the frame of an unknown message, are believed.
///
/// They are if frames follow, each after `gap` bytes of something else, or if nothing follows and nothing
/// will (`closed`). They are not if a verified frame lies within them: a false start must not swallow it.
pub(crate) fn believe_unknown(bytes: &[u8], length: usize, gap: usize, closed: bool) -> Belief {
    let mut end = length;
    for _ in 0..UNKNOWN_CHAIN {
        if closed && end == bytes.len() {
            break;
        }
        match bytes.get(end + gap..).map_or(Verdict::Incomplete, inspect) {
            Verdict::Verified(_) => break,
            Verdict::Unknown { length, .. } => end += gap + length,
            Verdict::Incomplete if !closed => return Belief::NeedsMoreBytes,
            _ => return Belief::No,
        }
    }
    let claimed = &bytes[..length];
    let swallows = (1..length)
        .any(|at| layout::is_marker(claimed[at]) && matches!(inspect(&claimed[at..]), Verdict::Verified(_)));
    if swallows { Belief::No } else { Belief::Yes }
}

/// The byte that ties a message's definition into its checksum; `None` if the dialect lacks the message.
pub(crate) fn crc_extra(id: u32) -> Option<u8> {
    match MavMessage::extra_crc(id) {
        // The generated table answers 0 for "unknown", yet 0 is also right for COMPONENT_INFORMATION.
        0 => MavMessage::all_ids().binary_search(&id).ok().map(|_| 0),
        extra => Some(extra),
    }
}
