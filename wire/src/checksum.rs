//! The checksum of a frame: CRC-16/MCRF4XX, by MAVLink's documents "X.25", four bytes at a time.
//!
//! It is most of what a frame costs, going and coming.

/// The polynomial x¹⁶ + x¹² + x⁵ + 1, its bits in the order they are sent in.
const POLYNOMIAL: u16 = 0x8408;
const START: u16 = 0xffff;

/// What each value of a byte does to the checksum when 0, 1, 2 or 3 further bytes follow.
const TABLES: [[u16; 256]; 4] = {
    let mut tables = [[0; 256]; 4];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = byte as u16;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ POLYNOMIAL } else { crc >> 1 };
            bit += 1;
        }
        tables[0][byte] = crc;
        byte += 1;
    }
    let mut later = 1;
    while later < 4 {
        let mut byte = 0;
        while byte < 256 {
            let before = tables[later - 1][byte];
            tables[later][byte] = before >> 8 ^ tables[0][before as usize & 0xff];
            byte += 1;
        }
        later += 1;
    }
    tables
};

/// The checksum of `bytes` followed by `extra`, the byte that ties a message's definition in.
pub(crate) fn checksum(bytes: &[u8], extra: u8) -> u16 {
    let mut groups = bytes.chunks_exact(4);
    let mut crc = groups.by_ref().fold(START, |crc, group| {
        let [low, high] = crc.to_le_bytes();
        TABLES[3][usize::from(group[0] ^ low)]
            ^ TABLES[2][usize::from(group[1] ^ high)]
            ^ TABLES[1][usize::from(group[2])]
            ^ TABLES[0][usize::from(group[3])]
    });
    for byte in groups.remainder().iter().chain([&extra]) {
        crc = crc >> 8 ^ TABLES[0][usize::from(crc as u8 ^ byte)];
    }
    crc
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_check_value_of_the_catalogue_comes_out() {
        // "123456789" gives 0x6F91 (catalogue of parametrised CRC algorithms, CRC-16/MCRF4XX).
        assert_eq!(checksum(b"12345678", b'9'), 0x6f91);
    }

    proptest! {
        #[test]
        fn it_is_that_of_the_library(bytes in prop::collection::vec(any::<u8>(), 0..300), extra: u8) {
            prop_assert_eq!(checksum(&bytes, extra), mavlink_core::calculate_crc(&bytes, extra));
        }
    }
}
