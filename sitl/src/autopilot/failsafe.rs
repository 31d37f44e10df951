//! What the autopilot does on its own when radio, ground station or position are lost.

use std::time::Duration;

use helmlink_wire::enums::{MAV_SEVERITY_CRITICAL, MAV_SEVERITY_WARNING};

use super::Autopilot;
use super::modes::Mode;
use super::parameters::*;

/// Which losses the autopilot watches for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Loss {
    /// No radio input, or a throttle pulse below FS_THR_VALUE.
    Radio,
    /// No heartbeat of the ground station SYSID_MYGCS.
    GroundStation,
    /// No position in a mode that needs one.
    Position,
}

const ALL: [Loss; 3] = [Loss::Radio, Loss::GroundStation, Loss::Position];

/// Since when what has been lost.
#[derive(Debug, Clone, Default)]
pub(super) struct Failsafe {
    since: [Option<Duration>; 3],
    acted: [bool; 3],
    /// Last sign of life of the ground station, once there was one.
    ground_station_heard: Option<Duration>,
}

impl Failsafe {
    /// The ground station has been heard.
    pub(super) fn hear_ground_station(&mut self, now: Duration) {
        self.ground_station_heard = Some(now);
    }

    /// Whether a loss that was acted upon persists.
    pub(super) fn is_active(&self) -> bool {
        self.acted.iter().any(|acted| *acted)
    }
}

impl Autopilot {
    /// Acts on losses that have lasted for FS_TIMEOUT. Disarmed, nothing is lost.
    pub(super) fn watch_failsafes(&mut self) {
        for loss in ALL {
            let index = loss as usize;
            if !self.armed || !self.is_lost(loss) {
                self.failsafe.since[index] = None;
                self.failsafe.acted[index] = false;
                continue;
            }
            let since = *self.failsafe.since[index].get_or_insert(self.now);
            let lasted_s = self.now.saturating_sub(since).as_secs_f64();
            if lasted_s >= self.parameters.get(FS_TIMEOUT) && !self.failsafe.acted[index] {
                self.failsafe.acted[index] = true;
                self.act_on(loss);
            }
        }
    }

    fn is_lost(&self, loss: Loss) -> bool {
        match loss {
            Loss::Radio => self.parameters.int(FS_THR_ENABLE) > 0 && self.has_radio_loss(),
            Loss::GroundStation => {
                let timeout_s = self.parameters.get(FS_GCS_TIMEOUT);
                let silent_s = |heard: Duration| self.now.saturating_sub(heard).as_secs_f64() >= timeout_s;
                self.parameters.int(FS_GCS_ENABLE) > 0
                    && self.failsafe.ground_station_heard.is_some_and(silent_s)
            }
            Loss::Position => {
                self.parameters.int(FS_EKF_ACTION) > 0 && self.mode.is_autopilot() && !self.has_position()
            }
        }
    }

    /// Whether there is no radio input now, or the receiver says by its throttle pulse that it has none.
    pub(super) fn has_radio_loss(&self) -> bool {
        let least_us = self.parameters.int(FS_THR_VALUE);
        !self.rc.has_input(self.now, &self.parameters)
            || i32::from(self.rc.throttle_us(&self.parameters)) < least_us
    }

    fn act_on(&mut self, loss: Loss) {
        if loss == Loss::Position {
            self.links.text(MAV_SEVERITY_CRITICAL, "EKF failsafe");
            self.first_possible(&[Mode::Hold]);
            return;
        }
        let (text, enabled) = match loss {
            Loss::Radio => ("Radio Failsafe", FS_THR_ENABLE),
            _ => ("GCS Failsafe", FS_GCS_ENABLE),
        };
        /// FS_THR_ENABLE and FS_GCS_ENABLE: keep on with a mission.
        const CONTINUE_MISSION: i32 = 2;
        self.links.text(MAV_SEVERITY_WARNING, text);
        if loss == Loss::GroundStation {
            self.rc.clear();
        }
        let goes_on = self.mode == Mode::Auto && self.parameters.int(enabled) == CONTINUE_MISSION;
        if goes_on || matches!(self.mode, Mode::Hold | Mode::Rtl) {
            return;
        }
        self.act_by_number(self.parameters.int(FS_ACTION));
    }

    /// What the numbers of FS_ACTION, FENCE_ACTION and BATT_FS_LOW_ACT mean.
    pub(super) fn act_by_number(&mut self, action: i32) {
        match action {
            1 => self.first_possible(&[Mode::Rtl, Mode::Hold]),
            2 => self.first_possible(&[Mode::Hold]),
            3 => self.first_possible(&[Mode::SmartRtl, Mode::Rtl, Mode::Hold]),
            4 => self.first_possible(&[Mode::SmartRtl, Mode::Hold]),
            5 => self.disarm(),
            6 => self.first_possible(&[Mode::Loiter, Mode::Hold]),
            _ => {}
        }
    }

    fn first_possible(&mut self, modes: &[Mode]) {
        for mode in modes {
            if self.enter_mode(*mode).is_ok() {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use helmlink_wire::Message;
    use helmlink_wire::dialect::HEARTBEAT_DATA;
    use helmlink_wire::enums::{MAV_STATE_ACTIVE, MAV_STATE_CRITICAL};

    use super::*;
    use crate::autopilot::testing::{Bench, GCS, LINK};

    fn sticks(throttle_us: u16) -> Message {
        crate::autopilot::testing::sticks(1500, throttle_us)
    }

    fn without_receiver() -> Bench {
        let mut bench = Bench::ready();
        bench.autopilot.parameters.put(SIM_RC_FAIL, 1.0);
        bench.send(LINK, GCS, &sticks(1500));
        bench.run_loops(1);
        bench.arm();
        bench
    }

    #[test]
    fn without_a_receiver_guided_is_left_for_hold_after_two_seconds() {
        let mut bench = without_receiver();
        bench.autopilot.enter_mode(Mode::Guided).unwrap();
        bench.run_s(1.8);
        assert_eq!(bench.autopilot.mode, Mode::Guided);
        let sent = bench.run_s(0.3);
        assert_eq!(bench.autopilot.mode, Mode::Hold);
        assert!(Bench::texts(&sent).contains(&"Radio Failsafe".to_owned()));
    }

    #[test]
    fn a_radio_failsafe_can_be_switched_off() {
        let mut bench = without_receiver();
        bench.autopilot.parameters.put(FS_THR_ENABLE, 0.0);
        bench.autopilot.enter_mode(Mode::Guided).unwrap();
        bench.run_s(8.0);
        assert_eq!(bench.autopilot.mode, Mode::Guided);
    }

    #[test]
    fn a_throttle_pulse_below_the_limit_is_a_loss_and_the_state_stays_critical() {
        let mut bench = Bench::ready();
        bench.arm();
        for _ in 0..20 {
            bench.send(LINK, GCS, &sticks(900));
            bench.run_s(0.1);
        }
        assert_eq!(bench.autopilot.mode, Mode::Hold);
        bench.autopilot.enter_mode(Mode::Manual).unwrap();
        for _ in 0..2 {
            bench.send(LINK, GCS, &sticks(900));
            bench.run_loops(1);
        }
        assert_eq!(bench.autopilot.system_status(), MAV_STATE_CRITICAL);
        bench.send(LINK, GCS, &sticks(1500));
        bench.run_loops(1);
        assert_eq!(bench.autopilot.system_status(), MAV_STATE_ACTIVE);
    }

    #[test]
    fn a_silent_ground_station_is_noticed_once_it_has_been_heard() {
        let mut bench = Bench::ready();
        bench.autopilot.parameters.put(FS_GCS_ENABLE, 1.0);
        bench.arm();
        bench.autopilot.enter_mode(Mode::Guided).unwrap();
        bench.run_s(20.0);
        assert_eq!(bench.autopilot.mode, Mode::Guided, "never heard, never lost");
        bench.send(LINK, GCS, &Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT));
        bench.run_s(6.4);
        assert_eq!(bench.autopilot.mode, Mode::Guided);
        let sent = bench.run_s(0.2);
        assert_eq!(bench.autopilot.mode, Mode::Hold);
        assert!(Bench::texts(&sent).contains(&"GCS Failsafe".to_owned()));
    }

    #[test]
    fn a_lost_position_ends_in_hold() {
        let mut bench = Bench::ready();
        bench.arm();
        bench.autopilot.enter_mode(Mode::Loiter).unwrap();
        bench.inject(crate::faults::Fault::GpsLoss).unwrap();
        bench.run_s(2.0);
        assert_eq!(bench.autopilot.mode, Mode::Hold);
    }
}
