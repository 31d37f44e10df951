//! The flight controller's clock, as far as a listener can know it.

use std::time::Duration;

/// How much of the driver's time one estimate of the rate is taken over.
const RATE_WINDOW: Duration = Duration::from_secs(2);
/// A boot time that falls back by more than this means that the flight controller has restarted.
const REBOOT_S: f64 = 1.0;
/// Rates outside this range are measurement errors (a burst after a stall), not simulators run fast.
const RATE_RANGE: (f64, f64) = (0.02, 1000.0);

/// Keeps `time_boot_ms` running between messages.
///
/// A simulated vehicle may run many times faster than the driver's clock. Every age limit of the bridge is
/// meant in the vehicle's own time, so the ratio of the two clocks is measured and applied.
#[derive(Debug, Clone)]
pub struct VehicleClock {
    latest: Option<(Duration, f64)>,
    window_start: Option<(Duration, f64)>,
    rate: f64,
}

/// What a time stamp told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tick {
    /// Time went on (or stood still).
    Forward,
    /// The flight controller has restarted.
    Rebooted,
}

impl Default for VehicleClock {
    fn default() -> Self {
        Self { latest: None, window_start: None, rate: 1.0 }
    }
}

impl VehicleClock {
    /// Takes a message's `time_boot_ms` (as seconds) that arrived at `now` of the driver's clock.
    pub fn on_boot_time(&mut self, now: Duration, boot_s: f64) -> Tick {
        if let Some((_, latest_s)) = self.latest
            && boot_s < latest_s - REBOOT_S
        {
            *self = Self { latest: Some((now, boot_s)), window_start: Some((now, boot_s)), rate: self.rate };
            return Tick::Rebooted;
        }
        let (start, start_s) = *self.window_start.get_or_insert((now, boot_s));
        let elapsed = now.saturating_sub(start);
        if elapsed >= RATE_WINDOW {
            let rate = (boot_s - start_s) / elapsed.as_secs_f64();
            if rate > RATE_RANGE.0 && rate < RATE_RANGE.1 {
                self.rate = rate;
            }
            self.window_start = Some((now, boot_s));
        }
        if self.latest.is_none_or(|(_, latest_s)| boot_s >= latest_s) {
            self.latest = Some((now, boot_s));
        }
        Tick::Forward
    }

    /// Vehicle seconds per second of the driver's clock: 1 for a real boat, N for a simulator at N times real time.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// How long ago `then` was, in the vehicle's seconds.
    pub fn age_s(&self, now: Duration, then: Duration) -> f64 {
        now.saturating_sub(then).as_secs_f64() * self.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_a_fast_simulator() {
        let mut clock = VehicleClock::default();
        for step in 0..500 {
            let now = Duration::from_millis(step * 10);
            assert_eq!(clock.on_boot_time(now, 100.0 + 8.0 * now.as_secs_f64()), Tick::Forward);
        }
        assert!((clock.rate() - 8.0).abs() < 1e-6);
        assert!((clock.age_s(Duration::from_secs(10), Duration::from_secs(9)) - 8.0).abs() < 1e-6);
    }

    #[test]
    fn notices_a_reboot_but_not_reordering() {
        let mut clock = VehicleClock::default();
        clock.on_boot_time(Duration::from_secs(1), 500.0);
        assert_eq!(clock.on_boot_time(Duration::from_secs(2), 499.9), Tick::Forward);
        assert_eq!(clock.on_boot_time(Duration::from_secs(3), 2.0), Tick::Rebooted);
        assert_eq!(clock.on_boot_time(Duration::from_secs(4), 3.0), Tick::Forward);
    }
}
