//! Puts records whose time stamps are out of order back into order, within a window.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::io::{self, Read};

use helmlink_wire::Frame;
use helmlink_wire::tlog::TlogReader;

/// Records looked ahead: tools that write several links into one log are a few records out of order, no more.
const WINDOW: usize = 2048;

/// A log, record by record, in order of time where that was asked for.
pub struct Ordered<R> {
    reader: TlogReader<R>,
    waiting: BinaryHeap<Reverse<(u64, u64, Vec<u8>)>>,
    window: usize,
    arrived: u64,
}

impl<R: Read> Ordered<R> {
    /// Reads as it is; `sort` where the stamps are known to be out of order.
    pub fn new(source: R, sort: bool) -> Self {
        let window = if sort { WINDOW } else { 1 };
        Self { reader: TlogReader::new(source), waiting: BinaryHeap::new(), window, arrived: 0 }
    }

    /// Hands the next record to `take`: its time stamp and its frame. False at the end.
    ///
    /// # Errors
    /// Those of the source.
    pub fn next(&mut self, take: impl FnOnce(u64, &Frame<'_>)) -> io::Result<bool> {
        if self.window == 1 {
            let Some(record) = self.reader.next_record()? else { return Ok(false) };
            take(record.time_us, &record.frame);
            return Ok(true);
        }
        while self.waiting.len() < self.window {
            let Some(record) = self.reader.next_record()? else { break };
            self.arrived += 1;
            self.waiting.push(Reverse((record.time_us, self.arrived, record.frame.bytes().to_vec())));
        }
        let Some(Reverse((time_us, _, bytes))) = self.waiting.pop() else { return Ok(false) };
        if let Ok(frame) = Frame::parse(&bytes) {
            take(time_us, &frame);
        }
        Ok(true)
    }
}
