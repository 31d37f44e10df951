use super::*;
use crate::dialect::{HEARTBEAT_DATA, Message};
use crate::{Encoder, Identity};

const BOAT: Identity = Identity { system: 1, component: 1 };

fn heartbeat(mode: u32) -> Message {
    Message::HEARTBEAT(HEARTBEAT_DATA { custom_mode: mode, mavtype: 250, ..HEARTBEAT_DATA::DEFAULT })
}

#[test]
fn frames_come_back_out() {
    let (mut encoder, mut bytes) = (Encoder::new(), vec![0x55, 0xFD, 0x07]);
    for mode in 0..300 {
        encoder.encode(BOAT, &heartbeat(mode), &mut bytes);
    }
    let mut framer = Framer::new();
    framer.push(&bytes);
    framer.end_of_datagram();
    let mut mode = 0;
    while let Some(frame) = framer.next_frame() {
        assert_eq!(frame.decode(), Ok(heartbeat(mode)));
        mode += 1;
    }
    assert_eq!(mode, 300);
    assert_eq!(framer.statistics().sequence_gaps, 0);
}
