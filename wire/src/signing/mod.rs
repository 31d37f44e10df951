//! MAVLink 2 message signing (<https://mavlink.io/en/guide/message_signing.html>), without a clock of its own.
//!
//! A signature says that the sender knows the key, and its time stamp says that the frame is no recording. It
//! hides nothing: everybody can still read the frame.
//!
//! One [`Signing`] serves all links of a party, so that what was heard on one link cannot be replayed on another.
//! Its time is told to it ([`Signing::observe_time`]) and kept by its owner ([`Signing::timestamp`]) from run to run.
//!
//! ```
//! use helmlink_wire::dialect::HEARTBEAT_DATA;
//! use helmlink_wire::signing::{Signing, SigningKey, Timestamp, Unsigned};
//! use helmlink_wire::{Encoder, Frame, Identity, Message};
//!
//! let key = SigningKey::from_passphrase("correct horse battery staple");
//! let now = Timestamp::from_unix(std::time::Duration::from_secs(1_800_000_000));
//! let (mut boat, mut station) = (Signing::new(key.clone(), now), Signing::new(key, now));
//!
//! let mut bytes = Vec::new();
//! let from = Identity { system: 1, component: 1 };
//! Encoder::new().encode(from, &Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT), &mut bytes);
//! boat.sign(0, &mut bytes, 0);
//! let frame = Frame::parse(&bytes)?;
//! assert_eq!(station.check(&frame, Unsigned::Refused), Ok(()));
//! assert!(station.check(&frame, Unsigned::Refused).is_err(), "the same frame again is a recording");
//! # Ok::<(), helmlink_wire::FrameError>(())
//! ```

mod key;
mod timestamp;

use sha2::{Digest, Sha256};
use thiserror::Error;

pub use key::{KeyError, SigningKey};
pub use timestamp::Timestamp;

use crate::checksum::checksum;
use crate::dialect::{MessageData, RADIO_STATUS_DATA, SETUP_SIGNING_DATA};
use crate::frame::{Frame, Identity};
use crate::layout::{CHECKSUM_LENGTH, FLAG_SIGNED, MARKER_V2, MAX_FRAME, SIGNATURE_LENGTH};

/// A sender heard for the first time may lag behind the own time stamp by this much, in units of 10 µs: one minute.
pub const NEW_STREAM_LAG: u64 = 60 * timestamp::TICKS_PER_SECOND;
/// Streams that are told apart. Only holders of the key can open one, and a boat has a handful.
pub const MAX_STREAMS: usize = 256;
/// Where the incompatibility flags are.
const FLAGS_AT: usize = 2;
/// Digest bytes at the end of a signature; link id and time stamp come before.
const DIGEST_LENGTH: usize = 6;

/// What to do with frames that carry no signature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Unsigned {
    /// Refuse all but RADIO_STATUS, which telemetry radios write without knowing the key.
    Refused,
    /// Accept them.
    Accepted,
}

/// Why a frame must not be acted on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Refusal {
    /// No signature where one is required.
    #[error("the frame is not signed: give its sender the key, or allow unsigned frames on this link")]
    Unsigned,
    /// Another key, or a forged frame.
    #[error("the signature is wrong: its sender has another key")]
    WrongSignature,
    /// The time stamp has been seen already.
    #[error("the time stamp is no newer than the last one of this sender: a repeated frame")]
    Replayed,
    /// A new sender whose time stamp is older than [`NEW_STREAM_LAG`].
    #[error("the time stamp of this new sender lags by more than a minute: set its clock")]
    TooOld,
    /// No room for another sender.
    #[error("more than {MAX_STREAMS} senders hold the key")]
    TooManyStreams,
}

/// How frames have fared.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SigningStatistics {
    /// Frames sent with a signature.
    pub signed_sent: u64,
    /// Frames with a right signature.
    pub accepted: u64,
    /// Frames accepted without one.
    pub unsigned_accepted: u64,
    /// Frames refused for the lack of one.
    pub unsigned_refused: u64,
    /// Frames refused for a wrong signature.
    pub wrong: u64,
    /// Frames refused as recordings: repeated or too old.
    pub replayed: u64,
}

/// Signs and checks the frames of one party with one key.
#[derive(Debug, Clone)]
pub struct Signing {
    key: SigningKey,
    /// The newest time stamp used or heard.
    timestamp: Timestamp,
    streams: Vec<(Stream, Timestamp)>,
    statistics: SigningStatistics,
}

/// A sender on one of its links.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stream {
    link: u8,
    sender: Identity,
}

impl Signing {
    /// Starts with the newer of the clock's time and the time stamp kept from the last run.
    pub fn new(key: SigningKey, timestamp: Timestamp) -> Self {
        Self { key, timestamp, streams: Vec::new(), statistics: SigningStatistics::default() }
    }

    /// Takes note of the time. A clock that goes back is not followed: time stamps never repeat.
    pub fn observe_time(&mut self, now: Timestamp) {
        self.timestamp = self.timestamp.max(now);
    }

    /// The newest time stamp used or heard. The next run has to start with it, or a later one.
    pub fn timestamp(&self) -> Timestamp {
        self.timestamp
    }

    /// How frames have fared so far.
    pub fn statistics(&self) -> &SigningStatistics {
        &self.statistics
    }

    /// Signs the MAVLink 2 frame that starts at `start` and ends `out`, as sent on the sender's link number `link`.
    ///
    /// A MAVLink 1 frame cannot be signed, and one that is signed already keeps its signature: both stay as they are.
    pub fn sign(&mut self, link: u8, out: &mut Vec<u8>, start: usize) {
        let Some(frame) = out.get_mut(start..).filter(|frame| can_be_signed(frame)) else { return };
        self.timestamp = self.timestamp.next();
        self.statistics.signed_sent += 1;
        mark_as_signed(frame);
        out.push(link);
        out.extend_from_slice(&self.timestamp.to_bytes());
        let digest = self.key.digest(&out[start..]);
        out.extend_from_slice(&digest);
    }

    /// Whether `frame` may be acted on.
    ///
    /// # Errors
    /// Why not; the frame has been counted.
    pub fn check(&mut self, frame: &Frame<'_>, unsigned: Unsigned) -> Result<(), Refusal> {
        let result = self.judge(frame, unsigned);
        let counter = match result {
            Ok(()) if frame.is_signed() => &mut self.statistics.accepted,
            Ok(()) => &mut self.statistics.unsigned_accepted,
            Err(Refusal::Unsigned) => &mut self.statistics.unsigned_refused,
            Err(Refusal::WrongSignature | Refusal::TooManyStreams) => &mut self.statistics.wrong,
            Err(Refusal::Replayed | Refusal::TooOld) => &mut self.statistics.replayed,
        };
        *counter += 1;
        result
    }

    fn judge(&mut self, frame: &Frame<'_>, unsigned: Unsigned) -> Result<(), Refusal> {
        let Some(&[link, t0, t1, t2, t3, t4, t5, ref digest @ ..]) = frame.signature() else {
            let is_radio = frame.message_id() == RADIO_STATUS_DATA::ID;
            return if is_radio || unsigned == Unsigned::Accepted { Ok(()) } else { Err(Refusal::Unsigned) };
        };
        let bytes = frame.bytes();
        if self.key.digest(&bytes[..bytes.len() - DIGEST_LENGTH]) != *digest {
            return Err(Refusal::WrongSignature);
        }
        let stamp = Timestamp::from_bytes([t0, t1, t2, t3, t4, t5]);
        self.follow(Stream { link, sender: frame.identity() }, stamp)?;
        self.timestamp = self.timestamp.max(stamp);
        Ok(())
    }

    /// Moves a stream on to `stamp`, if that is ahead.
    fn follow(&mut self, stream: Stream, stamp: Timestamp) -> Result<(), Refusal> {
        if let Some((_, newest)) = self.streams.iter_mut().find(|(known, _)| *known == stream) {
            if stamp <= *newest {
                return Err(Refusal::Replayed);
            }
            *newest = stamp;
            return Ok(());
        }
        if stamp.lag_behind(self.timestamp) > NEW_STREAM_LAG {
            return Err(Refusal::TooOld);
        }
        if self.streams.len() >= MAX_STREAMS {
            return Err(Refusal::TooManyStreams);
        }
        self.streams.push((stream, stamp));
        Ok(())
    }
}

/// Whether a message carries a secret: it must never be logged, passed on, or sent without a signature.
pub fn is_secret(message_id: u32) -> bool {
    message_id == SETUP_SIGNING_DATA::ID
}

/// Whether this is one whole MAVLink 2 frame without a signature.
fn can_be_signed(frame: &[u8]) -> bool {
    const HEADER: usize = 10;
    frame.len() >= HEADER + CHECKSUM_LENGTH
        && frame[0] == MARKER_V2
        && frame[FLAGS_AT] & FLAG_SIGNED == 0
        && frame.len() == HEADER + usize::from(frame[1]) + CHECKSUM_LENGTH
}

/// Sets the flag and puts the checksum right.
///
/// The checksum is linear: what a changed bit does to it depends on the bit's place alone, not on the message's
/// definition. So frames of messages that the dialect lacks can be signed too.
fn mark_as_signed(frame: &mut [u8]) {
    frame[FLAGS_AT] |= FLAG_SIGNED;
    let end = frame.len() - CHECKSUM_LENGTH;
    let zeroes = [0; MAX_FRAME - SIGNATURE_LENGTH];
    let mut change = zeroes;
    change[FLAGS_AT] = FLAG_SIGNED;
    let effect = checksum(&change[1..end], 0) ^ checksum(&zeroes[1..end], 0);
    let changed = u16::from_le_bytes([frame[end], frame[end + 1]]) ^ effect;
    frame[end..].copy_from_slice(&changed.to_le_bytes());
}

impl SigningKey {
    /// The digest that ends a signature, of everything before it.
    fn digest(&self, signed: &[u8]) -> [u8; DIGEST_LENGTH] {
        let hash = Sha256::new().chain_update(self.bytes()).chain_update(signed).finalize();
        let mut digest = [0; DIGEST_LENGTH];
        digest.copy_from_slice(&hash[..DIGEST_LENGTH]);
        digest
    }
}

#[cfg(test)]
mod tests;
