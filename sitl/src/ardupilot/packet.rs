//! Servo pulses as ArduPilot sends them (ArduPilot, `libraries/SITL/SIM_JSON.h`, `struct servo_packet_16` and
//! `servo_packet_32`): little-endian, without padding.

/// First word of a packet with 16 outputs, and of one with 32.
const MAGIC: [(u16, usize); 2] = [(18_458, 16), (29_569, 32)];
/// Bytes before the pulses.
const HEADER_BYTES: usize = 8;
/// Why a datagram was not answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PacketFault {
    /// Not a packet of the protocol.
    #[error("{bytes} bytes are no servo packet of ArduPilot (40 bytes, or 72 with SERVO_32_ENABLE = 1)")]
    Size {
        /// How many bytes came.
        bytes: usize,
    },
    /// The first word is not the protocol's.
    #[error("the packet starts with {found}, not with {expected}: is it ArduPilot's JSON protocol?")]
    Magic {
        /// The word that came.
        found: u16,
        /// The word that packets of this size start with.
        expected: u16,
    },
}

/// One packet of servo pulses.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoPacket {
    /// Frames per second that ArduPilot wants.
    pub frame_rate_hz: u16,
    /// Number of the frame.
    pub frame: u32,
    /// Pulses, µs.
    pub pulses_us: Vec<u16>,
}

impl ServoPacket {
    /// Reads a datagram.
    ///
    /// # Errors
    /// [`PacketFault`] if it is no servo packet.
    pub fn parse(bytes: &[u8]) -> Result<Self, PacketFault> {
        let size = |outputs: usize| HEADER_BYTES + 2 * outputs;
        let known = MAGIC.iter().find(|(_, outputs)| size(*outputs) == bytes.len());
        let Some(&(expected, _)) = known else { return Err(PacketFault::Size { bytes: bytes.len() }) };
        let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let found = word(0);
        if found != expected {
            return Err(PacketFault::Magic { found, expected });
        }
        Ok(Self {
            frame_rate_hz: word(2),
            frame: u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]),
            pulses_us: bytes[HEADER_BYTES..]
                .chunks_exact(2)
                .map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
                .collect(),
        })
    }
}
