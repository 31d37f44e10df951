//! How many frames per second one core frames, decodes and encodes: `cargo bench -p helmlink-wire`.

use divan::counter::{BytesCount, ItemsCount};
use divan::{Bencher, black_box};
use helmlink_wire::tlog::{TlogReader, records};
use helmlink_wire::{Encoder, Framer, Identity, Message};

/// A recorded run of ArduRover.
const LOG: &[u8] = include_bytes!("../../tests/data/ardurover-4.6-motorboat.tlog");

/// As much as one read of a socket yields at most.
const CHUNK: usize = 64 * 1024;

fn main() {
    divan::main();
}

fn frames() -> Vec<u8> {
    records(LOG).flat_map(|record| record.frame.bytes().to_vec()).collect()
}

#[divan::bench]
fn frame(bencher: Bencher<'_, '_>) {
    let bytes = frames();
    bencher.counter(ItemsCount::new(records(LOG).count())).counter(BytesCount::new(bytes.len())).bench(
        || {
            let mut framer = Framer::new();
            for chunk in bytes.chunks(CHUNK) {
                framer.push(chunk);
                while let Some(frame) = framer.next_frame() {
                    black_box(frame);
                }
            }
            framer
        },
    );
}

#[divan::bench]
fn frame_and_decode(bencher: Bencher<'_, '_>) {
    let bytes = frames();
    bencher.counter(ItemsCount::new(records(LOG).count())).counter(BytesCount::new(bytes.len())).bench(
        || {
            let mut framer = Framer::new();
            for chunk in bytes.chunks(CHUNK) {
                framer.push(chunk);
                while let Some(frame) = framer.next_frame() {
                    let _ = black_box(frame.decode());
                }
            }
            framer
        },
    );
}

#[divan::bench]
fn read_log_and_decode(bencher: Bencher<'_, '_>) {
    bencher.counter(ItemsCount::new(records(LOG).count())).counter(BytesCount::new(LOG.len())).bench(|| {
        let mut reader = TlogReader::new(LOG);
        while let Ok(Some(record)) = reader.next_record() {
            let _ = black_box(record.frame.decode());
        }
        reader
    });
}

#[divan::bench]
fn encode(bencher: Bencher<'_, '_>) {
    let from = Identity { system: 1, component: 1 };
    let messages: Vec<Message> = records(LOG).filter_map(|record| record.frame.decode().ok()).collect();
    bencher.counter(ItemsCount::new(messages.len())).bench(|| {
        let (mut encoder, mut out) = (Encoder::new(), Vec::with_capacity(CHUNK));
        for message in &messages {
            if out.len() > CHUNK / 2 {
                out.clear();
            }
            encoder.encode(from, message, &mut out);
        }
        out
    });
}
