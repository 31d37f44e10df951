//! FILE_TRANSFER_PROTOCOL (<https://mavlink.io/en/services/ftp.html>): one file, `@PARAM/param.pck`, which is
//! the fast way to all parameters. Every other file is refused at once; clients then do without.

use std::collections::BTreeMap;

use helmlink_wire::dialect::{FILE_TRANSFER_PROTOCOL_DATA, Message};
use helmlink_wire::enums::*;
use helmlink_wire::{Identity, LinkId};

use super::parameters::Parameters;

/// The packed parameters; a client may ask for defaults as well with `?withdefaults=1`.
const PARAMETERS_FILE: &str = "@PARAM/param.pck";
/// Files open at once; a further client takes the place of the first.
const MAX_OPEN: usize = 32;
/// Bytes of a file in one message.
const DATA_BYTES: usize = 239;

/// Places of the header fields in the payload.
mod at {
    pub(super) const SESSION: usize = 2;
    pub(super) const OPCODE: usize = 3;
    pub(super) const SIZE: usize = 4;
    pub(super) const REQUEST_OPCODE: usize = 5;
    pub(super) const BURST_COMPLETE: usize = 6;
    pub(super) const OFFSET: usize = 8;
    pub(super) const DATA: usize = 12;
}

/// A client with a file open.
type Reader = (LinkId, u8, u8);

/// The files that are being read.
#[derive(Debug, Default)]
pub(super) struct Ftp {
    open: BTreeMap<Reader, Vec<u8>>,
}

/// One answer, before it is put into a message.
enum Answer<'a> {
    Done,
    Opened { bytes: usize },
    Data { offset: usize, bytes: &'a [u8], burst_complete: bool },
    Refused(u8),
}

impl Ftp {
    /// The answers to a request of `from`; none if it is itself an answer.
    pub(super) fn answers(
        &mut self,
        link: LinkId,
        from: Identity,
        request: &FILE_TRANSFER_PROTOCOL_DATA,
        parameters: &Parameters,
    ) -> Vec<Message> {
        let reader = (link, from.system, from.component);
        let payload = &request.payload;
        let opcode = payload[at::OPCODE];
        let offset_bytes = [payload[8], payload[9], payload[10], payload[11]];
        let offset = u32::from_le_bytes(offset_bytes) as usize;
        let size = usize::from(payload[at::SIZE]).min(DATA_BYTES);
        let file = self.open.get(&reader).map(Vec::as_slice);
        let answers = match opcode {
            MAV_FTP_OPCODE_ACK | MAV_FTP_OPCODE_NAK => return Vec::new(),
            MAV_FTP_OPCODE_TERMINATESESSION | MAV_FTP_OPCODE_RESETSESSION => {
                self.open.remove(&reader);
                vec![Answer::Done]
            }
            MAV_FTP_OPCODE_OPENFILERO => {
                vec![self.open_file(reader, &payload[at::DATA..][..size], parameters)]
            }
            MAV_FTP_OPCODE_READFILE => vec![read(file, offset, size)],
            MAV_FTP_OPCODE_BURSTREADFILE => burst(file, offset, size),
            MAV_FTP_OPCODE_LISTDIRECTORY | MAV_FTP_OPCODE_CALCFILECRC => {
                vec![Answer::Refused(MAV_FTP_ERR_FILENOTFOUND)]
            }
            MAV_FTP_OPCODE_WRITEFILE => vec![Answer::Refused(MAV_FTP_ERR_INVALIDSESSION)],
            _ => vec![Answer::Refused(MAV_FTP_ERR_UNKNOWNCOMMAND)],
        };
        let sequence = u16::from_le_bytes([payload[0], payload[1]]);
        let numbered = answers.iter().zip(1u16..);
        numbered
            .map(|(answer, number)| message(from, request, sequence.wrapping_add(number), answer))
            .collect()
    }

    /// Forgets the clients on a link.
    pub(super) fn forget(&mut self, link: LinkId) {
        self.open.retain(|(on, ..), _| *on != link);
    }

    fn open_file(&mut self, reader: Reader, name: &[u8], parameters: &Parameters) -> Answer<'static> {
        let name = String::from_utf8_lossy(name);
        let (path, query) =
            name.trim_end_matches('\0').split_once('?').unwrap_or((name.trim_end_matches('\0'), ""));
        if path != PARAMETERS_FILE {
            return Answer::Refused(MAV_FTP_ERR_FILENOTFOUND);
        }
        let with_defaults = query.split('&').any(|part| part == "withdefaults=1");
        let file = parameters.packed(with_defaults);
        let bytes = file.len();
        if self.open.len() >= MAX_OPEN && !self.open.contains_key(&reader) {
            self.open.pop_first();
        }
        self.open.insert(reader, file);
        Answer::Opened { bytes }
    }
}

fn read(file: Option<&[u8]>, offset: usize, size: usize) -> Answer<'_> {
    let Some(file) = file else { return Answer::Refused(MAV_FTP_ERR_INVALIDSESSION) };
    match file.get(offset..) {
        None | Some([]) => Answer::Refused(MAV_FTP_ERR_EOF),
        Some(rest) => Answer::Data { offset, bytes: &rest[..size.min(rest.len())], burst_complete: false },
    }
}

/// All the rest of the file, in messages of `size` bytes.
fn burst(file: Option<&[u8]>, offset: usize, size: usize) -> Vec<Answer<'_>> {
    let size = if size == 0 { DATA_BYTES } else { size };
    let Some(rest) = file.and_then(|file| file.get(offset..)).filter(|rest| !rest.is_empty()) else {
        return vec![read(file, offset, size)];
    };
    let count = rest.len().div_ceil(size);
    let piece = |(number, bytes)| Answer::Data {
        offset: offset + number * size,
        bytes,
        burst_complete: number + 1 == count,
    };
    rest.chunks(size).enumerate().map(piece).collect()
}

fn message(
    to: Identity,
    request: &FILE_TRANSFER_PROTOCOL_DATA,
    sequence: u16,
    answer: &Answer<'_>,
) -> Message {
    let mut payload = [0; 251];
    payload[..2].copy_from_slice(&sequence.to_le_bytes());
    payload[at::SESSION] = request.payload[at::SESSION];
    payload[at::REQUEST_OPCODE] = request.payload[at::OPCODE];
    payload[at::OPCODE] = MAV_FTP_OPCODE_ACK;
    match answer {
        Answer::Done => {}
        Answer::Opened { bytes } => {
            payload[at::SIZE] = 4;
            let size = u32::try_from(*bytes).unwrap_or(u32::MAX).to_le_bytes();
            payload[at::DATA..at::DATA + 4].copy_from_slice(&size);
        }
        Answer::Data { offset, bytes, burst_complete } => {
            payload[at::SIZE] = bytes.len() as u8;
            payload[at::BURST_COMPLETE] = u8::from(*burst_complete);
            let offset = u32::try_from(*offset).unwrap_or(u32::MAX).to_le_bytes();
            payload[at::OFFSET..at::OFFSET + 4].copy_from_slice(&offset);
            payload[at::DATA..at::DATA + bytes.len()].copy_from_slice(bytes);
        }
        Answer::Refused(error) => {
            payload[at::OPCODE] = MAV_FTP_OPCODE_NAK;
            payload[at::SIZE] = 1;
            payload[at::DATA] = *error;
        }
    }
    Message::FILE_TRANSFER_PROTOCOL(FILE_TRANSFER_PROTOCOL_DATA {
        target_network: 0,
        target_system: to.system,
        target_component: to.component,
        payload,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autopilot::testing::Bench;

    const GCS: Identity = Identity { system: 255, component: 230 };
    const LINK: LinkId = LinkId(1);

    fn request(opcode: u8, offset: u32, size: u8, data: &[u8]) -> FILE_TRANSFER_PROTOCOL_DATA {
        let mut payload = [0; 251];
        payload[..2].copy_from_slice(&41u16.to_le_bytes());
        payload[at::SESSION] = 3;
        payload[at::OPCODE] = opcode;
        payload[at::SIZE] = size;
        payload[at::OFFSET..at::DATA].copy_from_slice(&offset.to_le_bytes());
        payload[at::DATA..at::DATA + data.len()].copy_from_slice(data);
        FILE_TRANSFER_PROTOCOL_DATA { payload, ..FILE_TRANSFER_PROTOCOL_DATA::DEFAULT }
    }

    fn ask(ftp: &mut Ftp, request: &FILE_TRANSFER_PROTOCOL_DATA) -> Vec<[u8; 251]> {
        let payload = |message: Message| match message {
            Message::FILE_TRANSFER_PROTOCOL(data) => data.payload,
            _ => panic!(),
        };
        ftp.answers(LINK, GCS, request, &Parameters::new()).into_iter().map(payload).collect()
    }

    fn open(ftp: &mut Ftp, name: &str) -> [u8; 251] {
        ask(ftp, &request(MAV_FTP_OPCODE_OPENFILERO, 0, name.len() as u8, name.as_bytes()))[0]
    }

    #[test]
    fn every_other_file_and_operation_is_refused_at_once() {
        let mut ftp = Ftp::default();
        for opcode in 0..=u8::MAX {
            let answers = ask(&mut ftp, &request(opcode, 0, 5, b"a.txt"));
            if opcode == MAV_FTP_OPCODE_ACK || opcode == MAV_FTP_OPCODE_NAK {
                assert!(answers.is_empty());
                continue;
            }
            let payload = answers[0];
            assert_eq!((payload[0], payload[at::SESSION], payload[at::REQUEST_OPCODE]), (42, 3, opcode));
            let ends = matches!(opcode, MAV_FTP_OPCODE_TERMINATESESSION | MAV_FTP_OPCODE_RESETSESSION);
            let expected = if ends { MAV_FTP_OPCODE_ACK } else { MAV_FTP_OPCODE_NAK };
            assert_eq!(payload[at::OPCODE], expected, "opcode {opcode}");
        }
    }

    /// Reads the packed parameters as MAVProxy does: names, values and defaults.
    fn unpack(file: &[u8]) -> Vec<(String, f64, Option<f64>)> {
        let with_defaults = file[..2] == 0x671C_u16.to_le_bytes();
        let count = u16::from_le_bytes([file[2], file[3]]);
        let mut rest = &file[6..];
        let (mut all, mut last) = (Vec::new(), String::new());
        while !rest.is_empty() {
            let (kind, flags) = (rest[0] & 0xF, rest[0] >> 4);
            let (common, length) = (usize::from(rest[1] & 0xF), usize::from(rest[1] >> 4) + 1);
            last = last[..common].to_owned() + std::str::from_utf8(&rest[2..2 + length]).unwrap();
            rest = &rest[2 + length..];
            let mut value = || {
                let (number, bytes) = match kind {
                    1 => (f64::from(rest[0] as i8), 1),
                    2 => (f64::from(i16::from_le_bytes([rest[0], rest[1]])), 2),
                    3 => (f64::from(i32::from_le_bytes(rest[..4].try_into().unwrap())), 4),
                    4 => (f64::from(f32::from_le_bytes(rest[..4].try_into().unwrap())), 4),
                    _ => panic!("kind {kind}"),
                };
                rest = &rest[bytes..];
                number
            };
            let now = value();
            let default = (with_defaults && flags & 1 != 0).then(value);
            all.push((last.clone(), now, default));
        }
        assert_eq!(all.len(), usize::from(count));
        all
    }

    #[test]
    fn the_parameters_come_in_one_burst() {
        for (name, magic) in
            [(PARAMETERS_FILE.to_owned(), 0x671B_u16), (format!("{PARAMETERS_FILE}?withdefaults=1"), 0x671C)]
        {
            let mut ftp = Ftp::default();
            let opened = open(&mut ftp, &name);
            assert_eq!((opened[at::OPCODE], opened[at::SIZE]), (MAV_FTP_OPCODE_ACK, 4));
            let size = u32::from_le_bytes(opened[12..16].try_into().unwrap()) as usize;
            let mut file = Vec::new();
            let pieces = ask(&mut ftp, &request(MAV_FTP_OPCODE_BURSTREADFILE, 0, 239, &[]));
            let count = pieces.len();
            for (number, piece) in pieces.into_iter().enumerate() {
                let offset = u32::from_le_bytes(piece[8..12].try_into().unwrap()) as usize;
                assert_eq!(offset, file.len());
                assert_eq!(piece[at::BURST_COMPLETE] == 1, number + 1 == count);
                file.extend_from_slice(&piece[at::DATA..][..usize::from(piece[at::SIZE])]);
            }
            assert_eq!(file.len(), size);
            assert_eq!(file[..2], magic.to_le_bytes());
            let parameters = Parameters::new();
            let unpacked = unpack(&file);
            assert_eq!(unpacked.len(), parameters.count());
            for (name, value, _) in unpacked {
                let param = parameters.find(&name).unwrap();
                assert_eq!(parameters.get(param), value, "{name}");
            }
        }
    }

    /// MAVProxy's part of the three seconds until it has all parameters is a second of waiting and the rest Python.
    #[test]
    fn the_boats_part_in_fetching_all_parameters_is_two_loops() {
        let mut bench = Bench::ready();
        let mut asked = |request| {
            bench.send(LINK, GCS, &Message::FILE_TRANSFER_PROTOCOL(request));
            let sent = bench.run_loops(1);
            let is_answer = |message: &&Message| matches!(message, Message::FILE_TRANSFER_PROTOCOL(_));
            sent[&LINK].iter().filter(is_answer).cloned().collect::<Vec<_>>()
        };
        let name = PARAMETERS_FILE.as_bytes();
        assert_eq!(asked(request(MAV_FTP_OPCODE_OPENFILERO, 0, name.len() as u8, name)).len(), 1);
        let pieces = asked(request(MAV_FTP_OPCODE_BURSTREADFILE, 0, 239, &[]));
        let Some(Message::FILE_TRANSFER_PROTOCOL(last)) = pieces.last() else { panic!("no piece") };
        assert!(pieces.len() > 5 && last.payload[at::BURST_COMPLETE] == 1);
    }

    #[test]
    fn a_file_is_read_in_pieces_to_its_end() {
        let mut ftp = Ftp::default();
        let early = ask(&mut ftp, &request(MAV_FTP_OPCODE_READFILE, 0, 100, &[]))[0];
        assert_eq!((early[at::OPCODE], early[at::DATA]), (MAV_FTP_OPCODE_NAK, MAV_FTP_ERR_INVALIDSESSION));
        let size = u32::from_le_bytes(open(&mut ftp, PARAMETERS_FILE)[12..16].try_into().unwrap());
        let first = ask(&mut ftp, &request(MAV_FTP_OPCODE_READFILE, 0, 100, &[]))[0];
        assert_eq!((first[at::OPCODE], first[at::SIZE]), (MAV_FTP_OPCODE_ACK, 100));
        let last = ask(&mut ftp, &request(MAV_FTP_OPCODE_READFILE, size - 7, 100, &[]))[0];
        assert_eq!(last[at::SIZE], 7);
        for beyond in [size, u32::MAX] {
            for opcode in [MAV_FTP_OPCODE_READFILE, MAV_FTP_OPCODE_BURSTREADFILE] {
                let end = ask(&mut ftp, &request(opcode, beyond, 100, &[]))[0];
                assert_eq!((end[at::OPCODE], end[at::DATA]), (MAV_FTP_OPCODE_NAK, MAV_FTP_ERR_EOF));
            }
        }
        ftp.forget(LINK);
        assert!(ftp.open.is_empty());
    }

    #[test]
    fn open_files_are_limited() {
        let mut ftp = Ftp::default();
        for number in 0..100 {
            let client = Identity { system: number, component: 1 };
            let name = PARAMETERS_FILE.as_bytes();
            let open = request(MAV_FTP_OPCODE_OPENFILERO, 0, name.len() as u8, name);
            ftp.answers(LINK, client, &open, &Parameters::new());
        }
        assert_eq!(ftp.open.len(), MAX_OPEN);
    }
}
