//! The frames in a stream of bytes, and the bytes between them.

use helmlink_wire::{Frame, FrameError};

/// A part of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece<'a> {
    /// One whole frame.
    Frame(Frame<'a>),
    /// Bytes that belong to no frame whose checksum is right.
    Noise(&'a [u8]),
}

/// Cuts a stream into pieces that, put together again, are the stream.
///
/// Frames of messages that the dialect lacks cannot be told from noise, and come out as noise.
#[derive(Debug, Clone, Default)]
pub struct Splitter {
    waiting: Vec<u8>,
}

impl Splitter {
    /// Takes bytes in and hands out every piece that is certain; all of them when nothing more belongs to these
    /// bytes (`is_end`).
    pub fn push(&mut self, bytes: &[u8], is_end: bool, mut out: impl FnMut(Piece<'_>)) {
        self.waiting.extend_from_slice(bytes);
        let (mut at, mut noise_start) = (0, 0);
        while at < self.waiting.len() {
            match Frame::parse_first(&self.waiting[at..]) {
                Ok(frame) => {
                    if noise_start < at {
                        out(Piece::Noise(&self.waiting[noise_start..at]));
                    }
                    out(Piece::Frame(frame));
                    at += frame.bytes().len();
                    noise_start = at;
                }
                Err(FrameError::Incomplete { .. }) if !is_end => break,
                Err(_) => at += 1,
            }
        }
        if noise_start < at {
            out(Piece::Noise(&self.waiting[noise_start..at]));
        }
        self.waiting.drain(..at);
    }
}
