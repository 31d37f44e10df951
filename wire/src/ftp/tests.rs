use proptest::prelude::*;

use super::*;

const GCS: Identity = Identity { system: 255, component: 230 };
const LINK: LinkId = LinkId(1);
const NAME: &str = "/text.json";

/// The one file of these tests.
fn text() -> Arc<[u8]> {
    (0..1000_u32).map(|number| number as u8).collect()
}

fn request(session: u8, opcode: u8, offset: u32, size: u8, data: &[u8]) -> FILE_TRANSFER_PROTOCOL_DATA {
    let mut payload = [0; 251];
    payload[..2].copy_from_slice(&41u16.to_le_bytes());
    payload[at::SESSION] = session;
    payload[at::OPCODE] = opcode;
    payload[at::SIZE] = size;
    payload[at::OFFSET..at::DATA].copy_from_slice(&offset.to_le_bytes());
    payload[at::DATA..at::DATA + data.len()].copy_from_slice(data);
    FILE_TRANSFER_PROTOCOL_DATA { payload, ..FILE_TRANSFER_PROTOCOL_DATA::DEFAULT }
}

fn ask_as(server: &mut FileServer, who: Identity, request: &FILE_TRANSFER_PROTOCOL_DATA) -> Vec<[u8; 251]> {
    let answers = server.answers(LINK, who, request, |path| (path == NAME).then(text));
    answers.into_iter().map(|answer| answer.payload).collect()
}

fn ask(server: &mut FileServer, request: &FILE_TRANSFER_PROTOCOL_DATA) -> Vec<[u8; 251]> {
    ask_as(server, GCS, request)
}

fn open_request(session: u8, name: &str) -> FILE_TRANSFER_PROTOCOL_DATA {
    request(session, MAV_FTP_OPCODE_OPENFILERO, 0, name.len() as u8, name.as_bytes())
}

fn refusal(answer: &[u8; 251]) -> Option<u8> {
    (answer[at::OPCODE] == MAV_FTP_OPCODE_NAK).then_some(answer[at::DATA])
}

fn number(answer: &[u8; 251]) -> u32 {
    u32::from_le_bytes(answer[at::DATA..at::DATA + 4].try_into().unwrap())
}

#[test]
fn every_other_file_and_operation_is_refused_at_once() {
    let mut server = FileServer::new(usize::MAX);
    for opcode in 0..=u8::MAX {
        let answers = ask(&mut server, &request(3, opcode, 0, 5, b"a.txt"));
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

#[test]
fn a_file_is_read_in_pieces_to_its_end() {
    let mut server = FileServer::new(usize::MAX);
    let early = ask(&mut server, &request(3, MAV_FTP_OPCODE_READFILE, 0, 100, &[]))[0];
    assert_eq!(refusal(&early), Some(MAV_FTP_ERR_INVALIDSESSION));
    let size = number(&ask(&mut server, &open_request(3, NAME))[0]);
    let first = ask(&mut server, &request(3, MAV_FTP_OPCODE_READFILE, 0, 100, &[]))[0];
    assert_eq!((first[at::OPCODE], first[at::SIZE]), (MAV_FTP_OPCODE_ACK, 100));
    let last = ask(&mut server, &request(3, MAV_FTP_OPCODE_READFILE, size - 7, 100, &[]))[0];
    assert_eq!(last[at::SIZE], 7);
    for beyond in [size, u32::MAX] {
        for opcode in [MAV_FTP_OPCODE_READFILE, MAV_FTP_OPCODE_BURSTREADFILE] {
            let end = ask(&mut server, &request(3, opcode, beyond, 100, &[]))[0];
            assert_eq!(refusal(&end), Some(MAV_FTP_ERR_EOF));
        }
    }
    server.forget(LINK);
    assert_eq!(server.open_count(), 0);
}

#[test]
fn a_session_reads_what_it_has_opened_and_nobody_elses() {
    let mut server = FileServer::new(usize::MAX);
    ask(&mut server, &open_request(3, NAME));
    let read = |session| request(session, MAV_FTP_OPCODE_READFILE, 0, 10, &[]);
    let other = Identity { component: 190, ..GCS };
    assert_eq!(refusal(&ask(&mut server, &read(4))[0]), Some(MAV_FTP_ERR_INVALIDSESSION));
    assert_eq!(refusal(&ask_as(&mut server, other, &read(3))[0]), Some(MAV_FTP_ERR_INVALIDSESSION));
    for (session, opcode, stays) in
        [(4, MAV_FTP_OPCODE_TERMINATESESSION, true), (3, MAV_FTP_OPCODE_TERMINATESESSION, false)]
    {
        assert_eq!(refusal(&ask(&mut server, &request(session, opcode, 0, 0, &[]))[0]), None);
        assert_eq!(refusal(&ask(&mut server, &read(3))[0]).is_none(), stays, "ended {session}");
    }
    ask(&mut server, &open_request(3, NAME));
    ask(&mut server, &request(9, MAV_FTP_OPCODE_RESETSESSION, 0, 0, &[]));
    assert_eq!(server.open_count(), 0, "a reset ends every session of a client");
}

#[test]
fn open_files_are_limited() {
    let mut server = FileServer::new(1);
    for system in 0..100 {
        ask_as(&mut server, Identity { system, component: 1 }, &open_request(3, NAME));
    }
    assert_eq!(server.open_count(), MAX_OPEN);
}

#[test]
fn a_burst_has_the_pieces_it_may_have_and_the_client_asks_for_the_rest() {
    let mut server = FileServer::new(3);
    ask(&mut server, &open_request(3, NAME));
    let mut file: Vec<u8> = Vec::new();
    let mut bursts = 0;
    while file.len() < text().len() {
        let from = file.len() as u32;
        let pieces = ask(&mut server, &request(3, MAV_FTP_OPCODE_BURSTREADFILE, from, 100, &[]));
        assert!(pieces.len() <= 3);
        for (number, piece) in pieces.iter().enumerate() {
            assert_eq!(piece[at::BURST_COMPLETE] == 1, number + 1 == pieces.len());
            assert_eq!(u32::from_le_bytes(piece[8..12].try_into().unwrap()) as usize, file.len());
            file.extend_from_slice(&piece[at::DATA..][..usize::from(piece[at::SIZE])]);
        }
        bursts += 1;
    }
    assert_eq!((bursts, &file[..]), (4, &text()[..]));
}

#[test]
fn the_checksum_is_mavlinks() {
    // "123456789" gives 0x2DFD2D88: CRC-32 as in zip, begun with 0 and not inverted (zlib.crc32(data, 0xFFFFFFFF) ^
    // 0xFFFFFFFF in Python).
    assert_eq!(crc32(b"123456789"), 0x2DFD_2D88);
    let mut server = FileServer::new(1);
    let asked = request(0, MAV_FTP_OPCODE_CALCFILECRC, 0, NAME.len() as u8, NAME.as_bytes());
    assert_eq!(number(&ask(&mut server, &asked)[0]), crc32(&text()));
}

proptest! {
    #[test]
    fn whatever_is_asked_nothing_grows(
        requests in prop::collection::vec((any::<u8>(), 0..20_u8, 0..4_u8, any::<u32>(), any::<u8>(), any::<bool>()), 1..300),
    ) {
        let mut server = FileServer::new(4);
        for (system, opcode, session, offset, size, is_known) in requests {
            let name = if is_known { NAME } else { "/../../etc/passwd" };
            let who = Identity { system, component: 1 };
            let size = if opcode == MAV_FTP_OPCODE_OPENFILERO { name.len() as u8 } else { size };
            let answers = ask_as(&mut server, who, &request(session, opcode, offset, size, name.as_bytes()));
            prop_assert_eq!(answers.len().clamp(1, 4), answers.len());
            prop_assert!(server.open_count() <= MAX_OPEN);
            if opcode == MAV_FTP_OPCODE_OPENFILERO && !is_known {
                prop_assert_eq!(refusal(&answers[0]), Some(MAV_FTP_ERR_FILENOTFOUND));
            }
        }
    }
}
