//! Starting, and starting anew.

use std::time::Duration;

use helmlink_wire::Identity;
use helmlink_wire::enums::{MAV_COMP_ID_AUTOPILOT1, MAV_SEVERITY_INFO};

use super::Autopilot;
use super::auto::Auto;
use super::failsafe::Failsafe;
use super::guided::Guided;
use super::mode_switch::ModeSwitch;
use super::modes::Mode;
use super::outputs::Outputs;
use super::parameters::*;
use super::rc::RcInput;
use super::steering::Steering;

/// After a restart the first HEARTBEAT comes this late (measured: about a second).
const BOOT_SILENCE: Duration = Duration::from_secs(1);

impl Autopilot {
    /// What happens once in the course of starting.
    pub(super) fn start_up(&mut self) {
        if self.mode == Mode::Initialising && self.is_initialised() {
            let wanted = u32::try_from(self.parameters.int(INITIAL_MODE)).unwrap_or_default();
            let mode = Mode::from_number(wanted).unwrap_or(Mode::Manual);
            self.links.text(MAV_SEVERITY_INFO, "ArduRover V4.6.0-dev (helmlink)");
            self.links.text(MAV_SEVERITY_INFO, "ArduPilot Ready");
            if self.enter_mode(mode).is_err() {
                self.mode = Mode::Manual;
            }
        }
        if self.home.is_none() && self.has_position() {
            self.links.text(MAV_SEVERITY_INFO, "EKF3 IMU0 is using GPS");
            self.set_home(self.position());
        }
    }

    /// Starts anew: everything but parameters, plans and links.
    pub(super) fn reboot(&mut self) {
        self.booted = self.now;
        self.silent_until = self.now + BOOT_SILENCE;
        self.mode = Mode::Initialising;
        self.armed = false;
        self.home = None;
        self.home_locked = false;
        self.rc = RcInput::default();
        self.mode_switch = ModeSwitch::default();
        self.guided = Guided::default();
        self.auto = Auto::default();
        self.failsafe = Failsafe::default();
        self.steering = Steering::default();
        self.outputs = Outputs::default();
        self.report = None;
        self.missions.set_home(None);
        self.links.own = own_identity(&self.parameters);
        self.links.reset_streams();
        let count = self.parameters.get(STAT_BOOTCNT) as f32 + 1.0;
        self.parameters.put(STAT_BOOTCNT, count);
    }

    /// Time since the last start.
    pub(super) fn since_boot(&self) -> Duration {
        self.now.saturating_sub(self.booted)
    }

    /// Whether the computer has only just been started anew and neither hears nor says anything.
    pub(super) fn is_starting(&self) -> bool {
        self.now < self.silent_until
    }

    /// Whether the autopilot has left INITIALISING behind.
    pub(super) fn is_initialised(&self) -> bool {
        self.since_boot() >= self.settings.start_up.initialised_after
    }

    /// Whether the estimator has a position.
    pub(super) fn has_position(&self) -> bool {
        !self.has_failed_estimator()
            && self.since_boot() >= self.settings.start_up.position_after
            && self.estimate.has_gps
    }
}

/// The address that SYSID_THISMAV gives the autopilot.
pub(super) fn own_identity(parameters: &Parameters) -> Identity {
    let system = u8::try_from(parameters.int(SYSID_THISMAV)).unwrap_or(1);
    Identity { system, component: MAV_COMP_ID_AUTOPILOT1 }
}
