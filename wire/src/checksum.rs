//! The checksum of MAVLink frames: CRC-16/MCRF4XX (ITU X.25 without the final complement), eight bytes at a time.
//!
//! Every frame is checked at least once at either end, byte by byte that is a good part of all work on a frame.

/// Tables by how many zero bytes follow the byte.
static TABLES: [[u16; 256]; STRIDE] = tables();
/// Bytes taken in at once.
const STRIDE: usize = 8;
/// x¹⁶ + x¹² + x⁵ + 1, bits reversed.
const POLYNOMIAL: u16 = 0x8408;
const START: u16 = 0xFFFF;

const fn tables() -> [[u16; 256]; STRIDE] {
    let mut tables = [[0; 256]; STRIDE];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = byte as u16;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ POLYNOMIAL } else { crc >> 1 };
            bit += 1;
        }
        tables[0][byte] = crc;
        byte += 1;
    }
    let mut zeroes = 1;
    while zeroes < STRIDE {
        let mut byte = 0;
        while byte < 256 {
            let shorter = tables[zeroes - 1][byte];
            tables[zeroes][byte] = (shorter >> 8) ^ tables[0][(shorter & 0xFF) as usize];
            byte += 1;
        }
        zeroes += 1;
    }
    tables
}

/// Checksum of `bytes` followed by `extra`, the byte that stands for the message's definition.
pub(crate) fn checksum(bytes: &[u8], extra: u8) -> u16 {
    let (strides, rest) = bytes.as_chunks::<STRIDE>();
    let mut crc = START;
    for stride in strides {
        let [low, high] = crc.to_le_bytes();
        let mut next = TABLES[7][usize::from(stride[0] ^ low)] ^ TABLES[6][usize::from(stride[1] ^ high)];
        for (byte, table) in stride[2..].iter().zip([5, 4, 3, 2, 1, 0]) {
            next ^= TABLES[table][usize::from(*byte)];
        }
        crc = next;
    }
    for byte in rest.iter().chain([&extra]) {
        let [low, high] = crc.to_le_bytes();
        crc = u16::from(high) ^ TABLES[0][usize::from(byte ^ low)];
    }
    crc
}

#[cfg(test)]
mod tests {
    use mavlink_core::calculate_crc;
    use proptest::prelude::*;

    use super::*;

    /// The check value of CRC-16/MCRF4XX is that of the nine digits.
    #[test]
    fn the_check_value_of_the_catalogue() {
        assert_eq!(checksum(b"12345678", b'9'), 0x6F91);
    }

    proptest! {
        #[test]
        fn agrees_with_the_library(bytes: Vec<u8>, extra: u8) {
            prop_assert_eq!(checksum(&bytes, extra), calculate_crc(&bytes, extra));
        }
    }
}
