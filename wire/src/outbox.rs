//! Writes that wait for one peer, bounded in bytes: what is lost first when the peer does not keep up.
//!
//! Positions, attitudes and set points are worth less the older they are, so the oldest go first. The answer to
//! a question is never said again, so it stays as long as there is room, and so does each sender's newest
//! heartbeat.

use std::collections::VecDeque;

use crate::candidate::{Verdict, inspect};
use crate::frame::{Frame, Identity};

/// Answers that outlive their write may take this share of the room.
const KEPT_SHARE: usize = 4;
/// A frame is added to the last write as long as that stays below this: it fits an Ethernet frame as a datagram.
const WRITE_BYTES: usize = 1400;

/// Writes that wait for one peer, the oldest first.
#[derive(Debug, Default)]
pub struct Outbox {
    /// Answers out of writes that are lost, one each; they are older than all that waits.
    kept: VecDeque<Vec<u8>>,
    kept_bytes: usize,
    waiting: VecDeque<Vec<u8>>,
    waiting_bytes: usize,
}

/// What was lost to make room.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[must_use]
pub struct Lost {
    /// Writes that were lost in whole or in part.
    pub writes: u64,
    /// Bytes of them.
    pub bytes: u64,
}

impl Outbox {
    /// An empty one.
    pub fn new() -> Self {
        Self::default()
    }

    /// Queues one write, at the price of older ones where there would be more than `limit_bytes`. A write larger
    /// than that still waits, alone.
    pub fn push(&mut self, write: &[u8], limit_bytes: usize) -> Lost {
        let lost = self.make_room(write.len(), limit_bytes);
        self.waiting_bytes += write.len();
        self.waiting.push_back(write.to_vec());
        lost
    }

    /// As [`Outbox::push`] for one frame, in a write with frames before it where they fit a datagram together.
    pub fn push_frame(&mut self, frame: &[u8], limit_bytes: usize) -> Lost {
        let lost = self.make_room(frame.len(), limit_bytes);
        self.waiting_bytes += frame.len();
        match self.waiting.back_mut() {
            Some(last) if last.len() + frame.len() <= WRITE_BYTES => last.extend_from_slice(frame),
            _ => self.waiting.push_back(frame.to_vec()),
        }
        lost
    }

    /// The next write.
    pub fn pop(&mut self) -> Option<Vec<u8>> {
        if let Some(kept) = self.kept.pop_front() {
            self.kept_bytes -= kept.len();
            return Some(kept);
        }
        let write = self.waiting.pop_front()?;
        self.waiting_bytes -= write.len();
        Some(write)
    }

    /// Bytes that wait.
    pub fn bytes(&self) -> usize {
        self.kept_bytes + self.waiting_bytes
    }

    /// Gives up all that waits.
    pub fn clear(&mut self) -> Lost {
        let lost = Lost { writes: (self.kept.len() + self.waiting.len()) as u64, bytes: self.bytes() as u64 };
        *self = Self::default();
        lost
    }

    fn make_room(&mut self, for_bytes: usize, limit_bytes: usize) -> Lost {
        let mut lost = Lost::default();
        while self.bytes() + for_bytes > limit_bytes && self.shed(limit_bytes, &mut lost) {}
        lost
    }

    /// Loses the oldest write but for the answers in it; when none is left, the oldest answer. False when there
    /// is nothing to lose.
    fn shed(&mut self, limit_bytes: usize, lost: &mut Lost) -> bool {
        let before = self.bytes();
        if let Some(write) = self.waiting.pop_front() {
            self.waiting_bytes -= write.len();
            each_frame(&write, |frame| self.keep(frame));
            while self.kept_bytes > limit_bytes / KEPT_SHARE {
                self.lose_kept(0);
            }
        } else if self.kept.is_empty() {
            return false;
        } else {
            self.lose_kept(0);
        }
        // A write of nothing but answers stays whole.
        let fewer = before - self.bytes();
        lost.writes += u64::from(fewer > 0);
        lost.bytes += fewer as u64;
        true
    }

    fn keep(&mut self, frame: Frame<'_>) {
        if !outlives_its_time(frame.message_id()) {
            return;
        }
        if frame.message_id() == HEARTBEAT
            && let Some(older) =
                self.kept.iter().position(|kept| heartbeat_of(kept) == Some(frame.identity()))
        {
            self.lose_kept(older);
        }
        self.kept_bytes += frame.bytes().len();
        self.kept.push_back(frame.bytes().to_vec());
    }

    fn lose_kept(&mut self, at: usize) {
        self.kept_bytes -= self.kept.remove(at).map_or(0, |kept| kept.len());
    }
}

/// The frames that `write` consists of; what follows something else is passed over.
fn each_frame(write: &[u8], mut take: impl FnMut(Frame<'_>)) {
    let mut rest = write;
    while let Verdict::Verified(length) = inspect(rest) {
        take(Frame::new(&rest[..length], true));
        rest = &rest[length..];
    }
}

fn heartbeat_of(bytes: &[u8]) -> Option<Identity> {
    let frame = Frame::parse(bytes).ok()?;
    (frame.message_id() == HEARTBEAT).then(|| frame.identity())
}

const HEARTBEAT: u32 = 0;

/// Whether a message answers a question, or is said once: those that a client would wait for in vain.
///
/// Orders and set points are none: a late one does harm, and whoever gives one asks again.
fn outlives_its_time(id: u32) -> bool {
    matches!(
        id,
        HEARTBEAT
            | 22 // PARAM_VALUE
            | 39 | 40 | 44 | 46 | 47 | 51 | 73 // MISSION_ITEM, _REQUEST, _COUNT, _ITEM_REACHED, _ACK, _REQUEST_INT, _ITEM_INT
            | 77 // COMMAND_ACK
            | 110 // FILE_TRANSFER_PROTOCOL
            | 118 | 120 // LOG_ENTRY, LOG_DATA
            | 148 // AUTOPILOT_VERSION
            | 244 // MESSAGE_INTERVAL
            | 253 // STATUSTEXT
            | 345 // PARAM_ERROR
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::dialect::{
        ATTITUDE_DATA, COMMAND_ACK_DATA, HEARTBEAT_DATA, Message, RC_CHANNELS_OVERRIDE_DATA,
    };
    use crate::{Encoder, Framer};

    const BOAT: Identity = Identity { system: 1, component: 1 };

    fn frame(encoder: &mut Encoder, message: &Message) -> Vec<u8> {
        let mut bytes = Vec::new();
        encoder.encode(BOAT, message, &mut bytes);
        bytes
    }

    fn attitude(roll: f32) -> Message {
        Message::ATTITUDE(ATTITUDE_DATA { roll, yawspeed: 1.0, ..ATTITUDE_DATA::DEFAULT })
    }

    fn ack(command: u16) -> Message {
        Message::COMMAND_ACK(COMMAND_ACK_DATA { command, ..COMMAND_ACK_DATA::DEFAULT })
    }

    /// All that comes out, in order.
    fn drained(outbox: &mut Outbox) -> Vec<Message> {
        let mut framer = Framer::new();
        while let Some(write) = outbox.pop() {
            framer.push(&write);
        }
        assert_eq!(outbox.bytes(), 0);
        std::iter::from_fn(|| framer.next_frame().map(|frame| frame.decode().unwrap())).collect()
    }

    #[test]
    fn writes_come_out_as_they_went_in_while_there_is_room() {
        let mut outbox = Outbox::new();
        assert_eq!(outbox.push(b"one", 6), Lost::default());
        assert_eq!(outbox.push(b"two", 6), Lost::default());
        assert_eq!(outbox.push(b"three", 6), Lost { writes: 2, bytes: 6 });
        assert_eq!((outbox.pop().as_deref(), outbox.pop()), (Some(&b"three"[..]), None));
    }

    #[test]
    fn answers_and_the_newest_heartbeat_outlast_a_flood_of_attitudes() {
        let (mut outbox, mut encoder) = (Outbox::new(), Encoder::new());
        let limit_bytes = 4000;
        let mut lost_bytes = 0;
        for i in 0..5000 {
            if i % 1000 == 10 {
                lost_bytes += outbox.push_frame(&frame(&mut encoder, &ack(i)), limit_bytes).bytes;
            }
            if i % 500 == 0 {
                let beat = HEARTBEAT_DATA { custom_mode: i.into(), ..HEARTBEAT_DATA::DEFAULT };
                lost_bytes +=
                    outbox.push_frame(&frame(&mut encoder, &Message::HEARTBEAT(beat)), limit_bytes).bytes;
            }
            lost_bytes += outbox.push_frame(&frame(&mut encoder, &attitude(f32::from(i))), limit_bytes).bytes;
            assert!(outbox.bytes() <= limit_bytes);
        }
        let out = drained(&mut outbox);
        let acks: Vec<u16> = out
            .iter()
            .filter_map(|message| match message {
                Message::COMMAND_ACK(ack) => Some(ack.command),
                _ => None,
            })
            .collect();
        assert_eq!(acks, [10, 1010, 2010, 3010, 4010]);
        let beats: Vec<u32> = out
            .iter()
            .filter_map(|message| match message {
                Message::HEARTBEAT(beat) => Some(beat.custom_mode),
                _ => None,
            })
            .collect();
        assert_eq!(beats, [4500]);
        assert_eq!(out.last(), Some(&attitude(4999.0)));
        assert!(lost_bytes > 100_000);
    }

    #[test]
    fn old_orders_are_lost_like_anything_else() {
        let (mut outbox, mut encoder) = (Outbox::new(), Encoder::new());
        let throttle = |chan3_raw| {
            Message::RC_CHANNELS_OVERRIDE(RC_CHANNELS_OVERRIDE_DATA {
                chan3_raw,
                ..RC_CHANNELS_OVERRIDE_DATA::DEFAULT
            })
        };
        for pwm in 1000..2000 {
            let _ = outbox.push(&frame(&mut encoder, &throttle(pwm)), 100);
        }
        let out = drained(&mut outbox);
        assert_eq!(out, [1995, 1996, 1997, 1998, 1999].map(throttle));
    }

    #[test]
    fn answers_alone_are_bounded_too() {
        let (mut outbox, mut encoder) = (Outbox::new(), Encoder::new());
        for command in 0..10_000 {
            let _ = outbox.push_frame(&frame(&mut encoder, &ack(command)), 2000);
            assert!(outbox.bytes() <= 2000);
        }
        assert_eq!(drained(&mut outbox).last(), Some(&ack(9999)));
    }

    proptest! {
        /// Whatever is pushed, the bound holds, and nothing is lost without being counted.
        #[test]
        fn every_byte_comes_out_or_is_counted(
            writes in prop::collection::vec((0u8..4, 1usize..300), 1..60),
            limit_bytes in 0usize..2000,
        ) {
            let (mut outbox, mut encoder) = (Outbox::new(), Encoder::new());
            let (mut pushed, mut lost) = (0, 0);
            for (kind, length) in writes {
                let write = match kind {
                    0 => vec![7; length],
                    1 => frame(&mut encoder, &attitude(length as f32)),
                    2 => frame(&mut encoder, &ack(length as u16)),
                    _ => frame(&mut encoder, &Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT)),
                };
                pushed += write.len();
                lost += outbox.push(&write, limit_bytes).bytes as usize;
                prop_assert!(outbox.bytes() <= limit_bytes.max(write.len()));
            }
            let mut out = 0;
            while let Some(write) = outbox.pop() {
                out += write.len();
            }
            prop_assert_eq!(pushed, out + lost);
        }
    }
}
