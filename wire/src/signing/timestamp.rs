//! Time stamps of signatures.

use std::time::Duration;

/// Time stamps count this many units in a second: each is 10 µs.
pub(super) const TICKS_PER_SECOND: u64 = 100_000;
/// 1 January 2015, 00:00 UTC, when time stamps start, in seconds after the Unix epoch.
const EPOCH_UNIX_S: u64 = 1_420_070_400;
/// The largest time stamp: 48 bits, in the year 2104.
const LARGEST: u64 = (1 << 48) - 1;

/// A signature's time stamp: units of 10 µs since 1 January 2015 UTC, in 48 bits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Timestamp(u64);

impl Timestamp {
    /// From the number of units; more than 48 bits can hold counts as the last there is.
    pub fn from_units(units: u64) -> Self {
        Self(units.min(LARGEST))
    }

    /// From the time since the Unix epoch. Before 2015, which is where a clock without battery starts, all are zero.
    pub fn from_unix(since_epoch: Duration) -> Self {
        let since_2015 = since_epoch.saturating_sub(Duration::from_secs(EPOCH_UNIX_S));
        let units = since_2015.as_micros() / 10;
        Self::from_units(u64::try_from(units).unwrap_or(LARGEST))
    }

    /// The number of units.
    pub fn units(self) -> u64 {
        self.0
    }

    /// This much later.
    pub fn later(self, by: Duration) -> Self {
        let units = u64::try_from(by.as_micros() / 10).unwrap_or(LARGEST);
        Self::from_units(self.0.saturating_add(units))
    }

    /// The one after it.
    pub(super) fn next(self) -> Self {
        Self::from_units(self.0 + 1)
    }

    /// How many units this lies behind `other`; 0 if it does not.
    pub(super) fn lag_behind(self, other: Self) -> u64 {
        other.0.saturating_sub(self.0)
    }

    pub(super) fn to_bytes(self) -> [u8; 6] {
        let [b0, b1, b2, b3, b4, b5, _, _] = self.0.to_le_bytes();
        [b0, b1, b2, b3, b4, b5]
    }

    pub(super) fn from_bytes([b0, b1, b2, b3, b4, b5]: [u8; 6]) -> Self {
        Self(u64::from_le_bytes([b0, b1, b2, b3, b4, b5, 0, 0]))
    }
}
