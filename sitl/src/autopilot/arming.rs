//! Arming and disarming, with reasons.

use helmlink_wire::enums::{MAV_SEVERITY_CRITICAL, MAV_SEVERITY_INFO};

use super::Autopilot;
use super::battery::Charge;
use super::parameters::*;

/// Values of the second parameter of the arm command that skip the checks: ArduPilot's and MAVProxy's.
pub(super) const FORCE: [f32; 2] = [21196.0, 2989.0];

impl Autopilot {
    /// Why the boat cannot be armed now; empty if it can.
    pub(super) fn arming_obstacles(&self) -> Vec<&'static str> {
        let mut obstacles = Vec::new();
        if self.parameters.int(ARMING_CHECK) != 0 {
            obstacles.extend(self.start_up_obstacle());
            if self.parameters.int(FS_THR_ENABLE) > 0 && self.has_radio_loss() {
                obstacles.push("Radio failsafe on");
            }
            obstacles.extend(self.fence_margin_obstacle());
            if self.is_outside_fence() {
                obstacles.push("vehicle outside fence");
            }
            if self.battery.state() != Charge::Good {
                obstacles.push("Battery 1 low");
            }
            obstacles.extend(self.battery_obstacle());
        }
        if !self.mode.may_arm() {
            obstacles.push("Mode not armable");
        }
        obstacles
    }

    /// What the battery lacks for setting out (BATT_ARM_VOLT, BATT_ARM_MAH; 0 asks for nothing).
    fn battery_obstacle(&self) -> Option<&'static str> {
        let (least_v, least_mah) = (self.parameters.get(BATT_ARM_VOLT), self.parameters.get(BATT_ARM_MAH));
        if least_v > 0.0 && self.battery_voltage_v() < least_v {
            return Some("Battery 1 below minimum arming voltage");
        }
        let left_mah = self.battery_left() * self.parameters.get(BATT_CAPACITY);
        (least_mah > 0.0 && left_mah < least_mah).then_some("Battery 1 below minimum arming capacity")
    }

    /// What of the sensors is not yet right after starting.
    fn start_up_obstacle(&self) -> Option<&'static str> {
        let start_up = &self.settings.start_up;
        let running = self.since_boot();
        if running >= start_up.armable_after {
            return None;
        }
        // The order in which they come right on ArduRover, spread over the time it takes here.
        let share = running.as_secs_f64() / start_up.armable_after.as_secs_f64();
        Some(match share {
            share if share < 0.14 => "Gyros not healthy",
            share if share < 0.55 => "Accels inconsistent",
            _ => "Gyros inconsistent",
        })
    }

    /// Arms, or says why not.
    pub(crate) fn arm(&mut self, forced: bool) -> bool {
        if self.armed {
            return true;
        }
        let obstacles = if forced { Vec::new() } else { self.arming_obstacles() };
        for obstacle in &obstacles {
            self.links.text(MAV_SEVERITY_CRITICAL, &format!("Arm: {obstacle}"));
        }
        if !obstacles.is_empty() {
            return false;
        }
        self.armed = true;
        self.breadcrumbs.clear();
        if self.has_position() && !self.home_locked {
            self.set_home(self.position());
        } else {
            self.send_home();
        }
        self.links.text(MAV_SEVERITY_INFO, "Throttle armed");
        true
    }

    /// Disarms.
    pub(crate) fn disarm(&mut self) {
        if self.armed {
            self.armed = false;
            self.links.text(MAV_SEVERITY_INFO, "Throttle disarmed");
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::autopilot::modes::Mode;
    use crate::autopilot::testing::Bench;
    use crate::autopilot::{AutopilotSettings, StartUp};

    #[test]
    fn too_early_it_says_why_and_force_overrides() {
        let settings = AutopilotSettings { start_up: StartUp::realistic(), ..Default::default() };
        let mut bench = Bench::new(settings);
        for (at_s, reason) in [(1.0, "Gyros not healthy"), (6.0, "Accels inconsistent"), (18.0, "Gyros inc")]
        {
            bench.run_until(Duration::from_secs_f64(at_s));
            assert!(!bench.autopilot.arm(false));
            let sent = bench.run_loops(1);
            assert!(Bench::texts(&sent).iter().any(|text| text.contains(reason)), "{at_s} s");
        }
        bench.run_until(Duration::from_secs(23));
        assert!(bench.autopilot.arm(false));
        bench.autopilot.disarm();
        assert!(!bench.autopilot.armed);
    }

    #[test]
    fn the_radio_and_the_mode_can_stand_in_the_way() {
        let mut bench = Bench::ready();
        bench.autopilot.parameters.put(SIM_RC_FAIL, 1.0);
        bench.autopilot.mode = Mode::Rtl;
        assert_eq!(bench.autopilot.arming_obstacles(), ["Radio failsafe on", "Mode not armable"]);
        bench.autopilot.parameters.put(ARMING_CHECK, 0.0);
        bench.autopilot.mode = Mode::Hold;
        assert!(bench.autopilot.arm(false));
    }

    #[test]
    fn a_battery_that_is_not_full_enough_keeps_the_boat_in_harbour() {
        let mut bench = Bench::ready();
        let parameters = &mut bench.autopilot.parameters;
        parameters.put(BATT_CAPACITY, 10_000.0);
        parameters.put(BATT_ARM_VOLT, 12.0);
        parameters.put(BATT_ARM_MAH, 6000.0);
        assert!(bench.autopilot.arming_obstacles().is_empty());
        bench.autopilot.battery.set_left(0.5, 10_000.0);
        assert_eq!(bench.autopilot.arming_obstacles(), ["Battery 1 below minimum arming voltage"]);
        bench.autopilot.parameters.put(BATT_ARM_VOLT, 0.0);
        assert_eq!(bench.autopilot.arming_obstacles(), ["Battery 1 below minimum arming capacity"]);
        bench.autopilot.parameters.put(BATT_ARM_MAH, 0.0);
        assert!(bench.autopilot.arm(false));
    }

    #[test]
    fn home_is_where_the_boat_is_armed_unless_it_was_set() {
        let mut bench = Bench::ready();
        assert!(bench.autopilot.arm(false));
        assert_eq!(bench.autopilot.home.map(|home| home.to_e7()), Some(bench.autopilot.position().to_e7()));
    }
}
