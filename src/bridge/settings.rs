//! What the user decides before a bridge is started.

use helmlink_mission::plan::Mission;
use helmlink_wire::Identity;
use serde::{Deserialize, Serialize};

use super::parameters::{ParameterError, Tunables};
use crate::control::Controller;
use crate::pilot::failsafe::{Failsafe, FailsafeSettings};
use crate::pilot::supervisor::Limits;
use crate::vehicle::{Mode, OutputKind};

/// Component id of the bridge on the vehicle's system: MAV_COMP_ID_ONBOARD_COMPUTER.
pub const COMPONENT: u8 = helmlink_wire::enums::MAV_COMP_ID_ONBOARD_COMPUTER;

/// In shadow a position may be this old, seconds.
const SHADOW_STALE_S: f64 = 2.5;

/// Where the mission comes from.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MissionSource {
    /// The one on the flight controller, read by the mission protocol.
    Vehicle,
    /// One that the user gave.
    Given(Mission),
}

/// Settings of a [`super::Bridge`].
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct BridgeSettings {
    /// The controller's model, limits and gains.
    pub boat: crate::control::Boat,
    /// The controller.
    pub controller: Controller,
    /// Where the mission comes from.
    pub mission: MissionSource,
    /// By which messages the boat is steered.
    pub output: OutputKind,
    /// Speed over ground where the mission does not say, m/s; the vehicle's own speed setting if not given.
    pub speed_mps: Option<f64>,
    /// Interval of the control loop, and of the telemetry that drives it, seconds.
    pub control_interval_s: f64,
    /// Drive as soon as everything is ready and the motors are armed.
    pub engage: bool,
    /// Drive when the pilot changes into this mode.
    pub engage_mode: Option<Mode>,
    /// Arm the motors when engaging.
    pub may_arm: bool,
    /// The mode to leave the boat in when the mission is complete.
    pub end_mode: Mode,
    /// Compute, but send nothing at all.
    pub shadow: bool,
    /// System id that overrides are sent with; the flight controller's SYSID_MYGCS must be the same.
    pub ground_station_system: u8,
    /// Waiting times.
    pub limits: Limits,
    /// What can go wrong, and what is then done.
    pub failsafes: FailsafeSettings,
    /// Parameters set over MAVLink in an earlier run, as [`super::Bridge::take_parameters`] gave them; empty for none.
    pub parameters: String,
}

impl BridgeSettings {
    /// The safe defaults for a boat: watches, and drives only when commanded to.
    pub fn new(boat: crate::control::Boat) -> Self {
        Self {
            boat,
            controller: Controller::default(),
            mission: MissionSource::Vehicle,
            output: OutputKind::RcOverride,
            speed_mps: None,
            control_interval_s: 0.04,
            engage: false,
            engage_mode: None,
            may_arm: false,
            end_mode: Mode::HOLD,
            shadow: false,
            ground_station_system: 255,
            limits: Limits::default(),
            failsafes: FailsafeSettings::default(),
            parameters: String::new(),
        }
    }

    /// What parameters change.
    pub(super) fn tunables(&self) -> Tunables {
        Tunables {
            boat: self.boat.clone(),
            failsafes: self.failsafes.clone(),
            speed_mps: self.speed_mps.unwrap_or_default(),
        }
    }

    /// Lets the saved parameters take effect; what could not be taken over is told.
    pub(super) fn take_saved_parameters(&mut self) -> Vec<ParameterError> {
        let mut tunables = self.tunables();
        let complaints = tunables.read(&std::mem::take(&mut self.parameters));
        self.boat = tunables.boat;
        self.failsafes = tunables.failsafes;
        self.speed_mps = (tunables.speed_mps > 0.0).then_some(tunables.speed_mps);
        complaints
    }

    /// The waiting times of the state machine.
    pub(super) fn effective_limits(&self) -> Limits {
        let heartbeat_s = self.failsafes.limit(Failsafe::LinkLost);
        // A shadow asks for nothing, so it has to live with the rates that it finds: once a second.
        let stale_s = if self.shadow { self.limits.stale_s.max(SHADOW_STALE_S) } else { self.limits.stale_s };
        Limits { heartbeat_s, stale_s, ..self.limits }
    }

    /// Who sends the steering messages.
    pub(super) fn steering_identity(&self, own: Identity) -> Identity {
        if self.output.needs_ground_station_id() {
            Identity { system: self.ground_station_system, component: own.component }
        } else {
            own
        }
    }
}
