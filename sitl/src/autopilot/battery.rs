//! The battery: it drains with thrust, its voltage falls, and the autopilot acts on it.

use std::time::Duration;

use helmlink_wire::enums::*;

use super::Autopilot;
use super::parameters::*;

/// Share of the charge left, and the voltage at rest as a share of a full battery's: a lithium-ion pack.
const DISCHARGE: [(f64, f64); 6] =
    [(0.0, 0.72), (0.05, 0.82), (0.2, 0.87), (0.5, 0.91), (0.8, 0.96), (1.0, 1.0)];
/// Voltage lost per ampere, as a share of a full battery's per ampere and ampere-hour: 10 A on 10 Ah cost 2 %.
const SAG_PER_C_RATE: f64 = 0.02;

/// How bad the battery is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) enum Charge {
    #[default]
    Good,
    Low,
    Critical,
}

/// The battery and what has been done about it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Battery {
    consumed_mah: f64,
    current_a: f64,
    low_since: Option<Duration>,
    critical_since: Option<Duration>,
    state: Charge,
}

impl Battery {
    /// Draws a current for `dt_s`.
    pub(super) fn draw(&mut self, current_a: f64, dt_s: f64) {
        self.current_a = current_a;
        self.consumed_mah += current_a * dt_s / 3.6;
    }

    /// Has only this share of `capacity_mah` left from now on.
    pub(super) fn set_left(&mut self, share: f64, capacity_mah: f64) {
        self.consumed_mah = (1.0 - share) * capacity_mah;
    }

    pub(super) fn consumed_mah(&self) -> f64 {
        self.consumed_mah
    }

    pub(super) fn current_a(&self) -> f64 {
        self.current_a
    }

    pub(super) fn state(&self) -> Charge {
        self.state
    }

    /// Share of the charge that is left, [0, 1].
    pub(super) fn left(&self, capacity_mah: f64) -> f64 {
        (1.0 - self.consumed_mah / capacity_mah).clamp(0.0, 1.0)
    }

    /// Voltage under the present load, V.
    pub(super) fn voltage_v(&self, full_v: f64, capacity_mah: f64) -> f64 {
        let c_rate = self.current_a / (capacity_mah / 1000.0);
        (full_v * (at_rest(self.left(capacity_mah)) - SAG_PER_C_RATE * c_rate)).max(0.0)
    }
}

/// Voltage at rest, as a share of the full one.
fn at_rest(left: f64) -> f64 {
    let above = DISCHARGE.iter().position(|(share, _)| *share >= left).unwrap_or(DISCHARGE.len() - 1).max(1);
    let ((x0, y0), (x1, y1)) = (DISCHARGE[above - 1], DISCHARGE[above]);
    y0 + (y1 - y0) * (left - x0) / (x1 - x0)
}

impl Autopilot {
    pub(super) fn battery_voltage_v(&self) -> f64 {
        self.battery.voltage_v(self.parameters.get(SIM_BATT_VOLTAGE), self.parameters.get(BATT_CAPACITY))
    }

    /// Share of the battery's charge that is left, [0, 1].
    pub(super) fn battery_left(&self) -> f64 {
        self.battery.left(self.parameters.get(BATT_CAPACITY))
    }

    /// Watches the battery and acts once when it gets low, and once more when it gets critical
    /// (BATT_LOW_VOLT, BATT_LOW_MAH and BATT_FS_LOW_ACT, and the same with CRT).
    pub(super) fn watch_battery(&mut self) {
        let timer = Duration::try_from_secs_f64(self.parameters.get(BATT_LOW_TIMER)).unwrap_or_default();
        let low = self.is_below(BATT_LOW_VOLT, BATT_LOW_MAH);
        let critical = self.is_below(BATT_CRT_VOLT, BATT_CRT_MAH);
        let lasts = |since: &mut Option<Duration>, is: bool, now: Duration| {
            *since = if is { Some(since.unwrap_or(now)) } else { None };
            since.is_some_and(|since| now.saturating_sub(since) >= timer)
        };
        let low = lasts(&mut self.battery.low_since, low, self.now);
        let critical = lasts(&mut self.battery.critical_since, critical, self.now);
        let state = if critical {
            Charge::Critical
        } else if low {
            Charge::Low
        } else {
            return;
        };
        // A failsafe lasts until the next start, as on ArduRover.
        if state > self.battery.state {
            self.battery.state = state;
            self.act_on_battery(state);
        }
    }

    /// Whether the voltage or the charge left is below its limit; a limit of 0 is none.
    fn is_below(&self, volt: Param, mah: Param) -> bool {
        let (least_v, least_mah) = (self.parameters.get(volt), self.parameters.get(mah));
        let left_mah = self.parameters.get(BATT_CAPACITY) - self.battery.consumed_mah();
        (least_v > 0.0 && self.battery_voltage_v() < least_v) || (least_mah > 0.0 && left_mah < least_mah)
    }

    fn act_on_battery(&mut self, state: Charge) {
        let (word, action) = match state {
            Charge::Critical => ("critical", BATT_FS_CRT_ACT),
            _ => ("low", BATT_FS_LOW_ACT),
        };
        let text = format!(
            "Battery 1 is {word} {:.2}V used {:.0} mAh",
            self.battery_voltage_v(),
            self.battery.consumed_mah()
        );
        self.links.text(MAV_SEVERITY_WARNING, &text);
        if self.armed {
            self.act_by_number(self.parameters.int(action));
        }
    }
}

#[cfg(test)]
mod tests {
    use helmlink_wire::Message;

    use super::*;
    use crate::autopilot::modes::Mode;
    use crate::autopilot::testing::{Bench, LINK};
    use crate::faults::Fault;

    #[test]
    fn the_voltage_falls_with_the_charge_and_the_load() {
        let mut battery = Battery::default();
        assert!((battery.voltage_v(12.6, 10_000.0) - 12.6).abs() < 1e-9);
        battery.draw(20.0, 0.0);
        assert!((battery.voltage_v(12.6, 10_000.0) - 12.6 * 0.96).abs() < 1e-9);
        battery.set_left(0.5, 10_000.0);
        battery.draw(0.0, 0.0);
        assert!((battery.voltage_v(12.6, 10_000.0) - 12.6 * 0.91).abs() < 1e-9);
        battery.set_left(0.0, 10_000.0);
        assert!((battery.voltage_v(12.6, 10_000.0) - 12.6 * 0.72).abs() < 1e-9);
    }

    #[test]
    fn thrust_drains_the_battery() {
        let used_mah = |throttle: u16| {
            let mut bench = Bench::ready();
            bench.arm();
            for _ in 0..60 {
                bench.send(
                    LINK,
                    crate::autopilot::testing::GCS,
                    &crate::autopilot::testing::sticks(1500, throttle),
                );
                bench.run_s(1.0);
            }
            bench.autopilot.battery.consumed_mah()
        };
        assert!(used_mah(1900) > 3.0 * used_mah(1500), "{} {}", used_mah(1900), used_mah(1500));
    }

    #[test]
    fn a_low_battery_stops_the_boat_when_it_is_told_to() {
        for (action, mode) in [(0.0, Mode::Loiter), (2.0, Mode::Hold), (1.0, Mode::Rtl)] {
            let mut bench = Bench::ready();
            bench.autopilot.parameters.put(BATT_LOW_VOLT, 11.0);
            bench.autopilot.parameters.put(BATT_FS_LOW_ACT, action);
            bench.arm();
            bench.autopilot.enter_mode(Mode::Loiter).unwrap();
            bench.run_s(12.0);
            assert_eq!(bench.autopilot.mode, Mode::Loiter);
            bench.inject(Fault::LowBattery { percent: 10.0 }).unwrap();
            bench.run_s(9.0);
            assert_eq!(bench.autopilot.mode, Mode::Loiter, "BATT_LOW_TIMER has not passed");
            let sent = bench.run_s(2.0);
            assert_eq!(bench.autopilot.mode, mode);
            assert!(Bench::texts(&sent).iter().any(|text| text.starts_with("Battery 1 is low")));
            let told = sent[&LINK].iter().rev().find_map(|message| match message {
                Message::BATTERY_STATUS(data) => Some((data.charge_state, data.voltages[0])),
                _ => None,
            });
            let (charge_state, voltage_mv) = told.unwrap();
            assert!(charge_state == MAV_BATTERY_CHARGE_STATE_LOW && voltage_mv < 11_000);
        }
    }
}
