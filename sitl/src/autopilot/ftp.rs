//! The simulated flight controller's one file, `@PARAM/param.pck`: the fast way to all parameters.

use std::sync::Arc;

use helmlink_wire::dialect::FILE_TRANSFER_PROTOCOL_DATA;
use helmlink_wire::ftp::FileServer;
use helmlink_wire::{Identity, LinkId};

use super::parameters::Parameters;

/// The packed parameters; a client may ask for defaults as well with `?withdefaults=1`.
const PARAMETERS_FILE: &str = "@PARAM/param.pck";

/// The files that are being read.
#[derive(Debug)]
pub(super) struct Ftp {
    server: FileServer,
}

impl Default for Ftp {
    /// A burst is all the rest of a file, as the firmware sends it.
    fn default() -> Self {
        Self { server: FileServer::new(usize::MAX) }
    }
}

impl Ftp {
    /// The answers to a request of `from`; none if it is itself an answer.
    pub(super) fn answers(
        &mut self,
        link: LinkId,
        from: Identity,
        request: &FILE_TRANSFER_PROTOCOL_DATA,
        parameters: &Parameters,
    ) -> Vec<FILE_TRANSFER_PROTOCOL_DATA> {
        self.server.answers(link, from, request, |path| file(path, parameters))
    }

    /// Forgets the clients on a link.
    pub(super) fn forget(&mut self, link: LinkId) {
        self.server.forget(link);
    }
}

fn file(path: &str, parameters: &Parameters) -> Option<Arc<[u8]>> {
    let (path, query) = path.split_once('?').unwrap_or((path, ""));
    let with_defaults = query.split('&').any(|part| part == "withdefaults=1");
    (path == PARAMETERS_FILE).then(|| parameters.packed(with_defaults).into())
}

#[cfg(test)]
mod tests {
    use helmlink_wire::Message;
    use helmlink_wire::enums::*;
    use helmlink_wire::ftp::at;

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
        let answers = ftp.answers(LINK, GCS, request, &Parameters::new());
        answers.into_iter().map(|answer| answer.payload).collect()
    }

    fn open(ftp: &mut Ftp, name: &str) -> [u8; 251] {
        ask(ftp, &request(MAV_FTP_OPCODE_OPENFILERO, 0, name.len() as u8, name.as_bytes()))[0]
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
}
