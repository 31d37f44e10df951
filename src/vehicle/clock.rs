//! Time at the vehicle's pace.

use std::time::Duration;

/// How much of the driver's time one estimate of the rate is taken over.
const RATE_WINDOW: Duration = Duration::from_secs(2);
/// Rates outside this range are measurement errors (a burst after a stall), not simulators run fast.
const RATE_RANGE: (f64, f64) = (0.02, 1000.0);
/// Rates this close to one are a real vehicle, whose clock is as good as ours.
const REAL_TIME_TOLERANCE: f64 = 0.05;

/// Turns the driver's clock into one that runs at the vehicle's pace.
///
/// A simulated vehicle may run many times faster than the driver's clock. Every age limit of the bridge is
/// meant in the vehicle's own time, so the ratio of the two clocks is measured on the vehicle's time stamps
/// and applied. The result never runs backwards, whatever the vehicle's time stamps do.
#[derive(Debug, Clone)]
pub struct VehicleClock {
    driver: Duration,
    paced: Duration,
    window_start: Option<(Duration, f64)>,
    rate: f64,
}

impl Default for VehicleClock {
    fn default() -> Self {
        Self { driver: Duration::ZERO, paced: Duration::ZERO, window_start: None, rate: 1.0 }
    }
}

impl VehicleClock {
    /// The paced time at `now` of the driver's clock. Instants before the last one count as the last one.
    pub fn advance(&mut self, now: Duration) -> Duration {
        let elapsed = now.saturating_sub(self.driver);
        self.driver = self.driver.max(now);
        self.paced += elapsed.mul_f64(self.rate);
        self.paced
    }

    /// Takes a time stamp of the vehicle, seconds since its boot, that arrived at the last instant given.
    pub fn on_boot_time(&mut self, boot_s: f64) {
        let (start, start_s) = *self.window_start.get_or_insert((self.driver, boot_s));
        let elapsed = self.driver.saturating_sub(start);
        if elapsed < RATE_WINDOW && boot_s >= start_s {
            return;
        }
        let rate = (boot_s - start_s) / elapsed.as_secs_f64();
        if rate > RATE_RANGE.0 && rate < RATE_RANGE.1 {
            self.rate = if (rate - 1.0).abs() < REAL_TIME_TOLERANCE { 1.0 } else { rate };
        }
        self.window_start = Some((self.driver, boot_s));
    }

    /// Vehicle seconds per second of the driver's clock: 1 for a real boat, N for a simulator at N times real time.
    pub fn rate(&self) -> f64 {
        self.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(clock: &mut VehicleClock, from_ms: u64, to_ms: u64, rate: f64) {
        for now in (from_ms..to_ms).step_by(10).map(Duration::from_millis) {
            clock.advance(now);
            clock.on_boot_time(100.0 + rate * now.as_secs_f64());
        }
    }

    #[test]
    fn keeps_pace_with_a_fast_simulator() {
        let mut clock = VehicleClock::default();
        run(&mut clock, 0, 3000, 8.0);
        assert!((clock.rate() - 8.0).abs() < 1e-6);
        let before = clock.advance(Duration::from_secs(10));
        let after = clock.advance(Duration::from_secs(11));
        assert!(((after - before).as_secs_f64() - 8.0).abs() < 1e-6);
    }

    #[test]
    fn a_reboot_of_the_vehicle_does_not_turn_time_back() {
        let mut clock = VehicleClock::default();
        run(&mut clock, 0, 5000, 1.0);
        let before = clock.advance(Duration::from_secs(5));
        clock.on_boot_time(0.5);
        assert!(clock.advance(Duration::from_millis(4900)) >= before);
        assert_eq!(clock.rate(), 1.0);
    }
}
