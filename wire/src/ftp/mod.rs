//! A server of files that can only be read, by FILE_TRANSFER_PROTOCOL (<https://mavlink.io/en/services/ftp.html>):
//! simulated boat and bridge serve theirs with it.
//!
//! It is asked by anybody: whatever comes, it keeps at most [`MAX_OPEN`] files open and answers with at most the pieces
//! of one burst. Every file that is not offered, and everything that would change one, is refused at once; clients
//! then do without.

mod answer;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::Arc;

use self::answer::Answer;
use crate::dialect::FILE_TRANSFER_PROTOCOL_DATA;
use crate::enums::*;
use crate::{Identity, LinkId};

/// Files open at once; a further client takes the place of the first.
pub const MAX_OPEN: usize = 32;
/// Bytes of a file in one message.
pub const DATA_BYTES: usize = 239;

/// Places of the header fields in the payload.
pub mod at {
    /// Who asks, among several of one client.
    pub const SESSION: usize = 2;
    /// MAV_FTP_OPCODE.
    pub const OPCODE: usize = 3;
    /// Bytes of data.
    pub const SIZE: usize = 4;
    /// In an answer: what was asked.
    pub const REQUEST_OPCODE: usize = 5;
    /// In an answer: 1 for the last piece of a burst.
    pub const BURST_COMPLETE: usize = 6;
    /// Place in the file, four bytes, the lowest first.
    pub const OFFSET: usize = 8;
    /// Up to [`DATA_BYTES`](super::DATA_BYTES) bytes.
    pub const DATA: usize = 12;
}

/// A client with a file open.
type Reader = (LinkId, u8, u8);

/// What a client has open.
#[derive(Debug)]
struct OpenFile {
    session: u8,
    bytes: Arc<[u8]>,
}

/// The files that are being read.
#[derive(Debug)]
pub struct FileServer {
    open: BTreeMap<Reader, OpenFile>,
    pieces_per_burst: usize,
}

impl FileServer {
    /// Answers a request for a burst with at most so many messages; the client asks for the rest.
    pub fn new(pieces_per_burst: usize) -> Self {
        Self { open: BTreeMap::new(), pieces_per_burst }
    }

    /// The answers to a request of `from`; none if it is itself an answer. `file` gives the file of a path, if there is
    /// one; clients ask with and without a slash in front.
    pub fn answers(
        &mut self,
        link: LinkId,
        from: Identity,
        request: &FILE_TRANSFER_PROTOCOL_DATA,
        file: impl FnOnce(&str) -> Option<Arc<[u8]>>,
    ) -> Vec<FILE_TRANSFER_PROTOCOL_DATA> {
        let reader = (link, from.system, from.component);
        let payload = &request.payload;
        let [opcode, session] = [at::OPCODE, at::SESSION].map(|place| payload[place]);
        let offset = [0, 1, 2, 3].map(|byte| payload[at::OFFSET + byte]);
        let offset = u32::from_le_bytes(offset) as usize;
        let size = usize::from(payload[at::SIZE]).min(DATA_BYTES);
        let file = || {
            let path = String::from_utf8_lossy(&payload[at::DATA..][..size]);
            file(path.trim_end_matches('\0'))
        };
        let answers = match opcode {
            MAV_FTP_OPCODE_ACK | MAV_FTP_OPCODE_NAK => return Vec::new(),
            MAV_FTP_OPCODE_TERMINATESESSION | MAV_FTP_OPCODE_RESETSESSION => {
                self.close(reader, session, opcode);
                vec![Answer::Done]
            }
            MAV_FTP_OPCODE_OPENFILERO => vec![self.open(reader, session, file())],
            MAV_FTP_OPCODE_CALCFILECRC => vec![match file() {
                Some(bytes) => Answer::Number(crc32(&bytes)),
                None => Answer::Refused(MAV_FTP_ERR_FILENOTFOUND),
            }],
            MAV_FTP_OPCODE_READFILE => vec![read(self.bytes(reader, session), offset, size)],
            MAV_FTP_OPCODE_BURSTREADFILE => {
                burst(self.bytes(reader, session), offset, size, self.pieces_per_burst)
            }
            MAV_FTP_OPCODE_LISTDIRECTORY => vec![Answer::Refused(MAV_FTP_ERR_FILENOTFOUND)],
            MAV_FTP_OPCODE_WRITEFILE => vec![Answer::Refused(MAV_FTP_ERR_INVALIDSESSION)],
            _ => vec![Answer::Refused(MAV_FTP_ERR_UNKNOWNCOMMAND)],
        };
        let sequence = u16::from_le_bytes([payload[0], payload[1]]);
        let numbered = answers.iter().zip(1u16..);
        numbered
            .map(|(answer, number)| answer.message(from, request, sequence.wrapping_add(number)))
            .collect()
    }

    /// Forgets the clients on a link.
    pub fn forget(&mut self, link: LinkId) {
        self.open.retain(|(on, ..), _| *on != link);
    }

    /// Files that are open.
    pub fn open_count(&self) -> usize {
        self.open.len()
    }

    /// To end another session than the one that is open changes nothing.
    fn close(&mut self, reader: Reader, session: u8, opcode: u8) {
        let is_meant = |open: &OpenFile| opcode == MAV_FTP_OPCODE_RESETSESSION || open.session == session;
        if self.open.get(&reader).is_some_and(is_meant) {
            self.open.remove(&reader);
        }
    }

    fn open(&mut self, reader: Reader, session: u8, file: Option<Arc<[u8]>>) -> Answer<'static> {
        let Some(bytes) = file else { return Answer::Refused(MAV_FTP_ERR_FILENOTFOUND) };
        let size = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        if self.open.len() >= MAX_OPEN && !self.open.contains_key(&reader) {
            self.open.pop_first();
        }
        self.open.insert(reader, OpenFile { session, bytes });
        Answer::Number(size)
    }

    fn bytes(&self, reader: Reader, session: u8) -> Option<&[u8]> {
        self.open.get(&reader).filter(|open| open.session == session).map(|open| &open.bytes[..])
    }
}

fn read(file: Option<&[u8]>, offset: usize, size: usize) -> Answer<'_> {
    let Some(file) = file else { return Answer::Refused(MAV_FTP_ERR_INVALIDSESSION) };
    match file.get(offset..) {
        None | Some([]) => Answer::Refused(MAV_FTP_ERR_EOF),
        Some(rest) => Answer::Data { offset, bytes: &rest[..size.min(rest.len())], burst_complete: false },
    }
}

/// The file from `offset` on, in messages of `size` bytes.
fn burst(file: Option<&[u8]>, offset: usize, size: usize, most: usize) -> Vec<Answer<'_>> {
    let size = if size == 0 { DATA_BYTES } else { size };
    let Some(rest) = file.and_then(|file| file.get(offset..)).filter(|rest| !rest.is_empty()) else {
        return vec![read(file, offset, size)];
    };
    let count = rest.len().div_ceil(size).min(most);
    let piece = |(number, bytes)| Answer::Data {
        offset: offset + number * size,
        bytes,
        burst_complete: number + 1 == count,
    };
    rest.chunks(size).take(count).enumerate().map(piece).collect()
}

/// The checksum of MAVLink's services (<https://mavlink.io/en/guide/crc.html>): the polynomial of Ethernet's, lowest bit
/// first, but begun with 0 and not inverted at the end.
pub fn crc32(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0, |crc, byte| {
        (0..8).fold(
            crc ^ u32::from(*byte),
            |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 },
        )
    })
}
