//! What the bridge tells its surroundings.

use helmlink_wire::Identity;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::control::Diagnostics;
use crate::control::response::MeasuredDelay;
use crate::control::sway_balance::CompassError;
use crate::pilot::Progress;
use crate::pilot::supervisor::{Reason, State};
use crate::vehicle::Mode;
use crate::vehicle::output::Demand;

/// Something worth a line in the log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// MAV_SEVERITY: 0 emergency … 7 debug.
    pub severity: u8,
    /// One line.
    pub text: String,
}

/// How the bridge's own process is, as its surroundings measure it: for the ground station, not for steering.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Health {
    /// From taking telemetry to handing over the command, at most, lately, milliseconds.
    pub late_ms: f32,
    /// Share of one processor since the last call, per cent.
    pub cpu_percent: f32,
    /// Resident memory, megabytes.
    pub memory_mb: f32,
}

/// The bridge at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Status {
    /// The safety state machine.
    pub state: State,
    /// Why it is in that state; none at the beginning.
    pub reason: Option<Reason>,
    /// The flight controller, once found.
    pub vehicle: Option<Identity>,
    /// Its mode.
    pub mode: Option<Mode>,
    /// Its motors may turn.
    pub armed: bool,
    /// Where the boat is on its mission, once there is one.
    pub progress: Option<Progress>,
    /// What was last commanded (or would have been, in shadow).
    pub demand: Demand,
    /// What the controller last thought.
    pub diagnostics: Diagnostics,
    /// Control steps made so far.
    pub steps: u64,
    /// How long a question to the flight controller and its answer took the last time, seconds.
    pub round_trip_s: Option<f64>,
    /// The control loop's delay as the boat's answer to its steering shows it, once it has answered clearly enough.
    pub answer_delay: Option<MeasuredDelay>,
    /// What the compass is off by, as far as turns in a current have told; none without a mission.
    pub compass: Option<CompassError>,
    /// The delay that the controller predicts across, seconds of the vehicle's time.
    pub delay_s: f64,
    /// How evenly the steering frames go out.
    pub pace: super::pace::Pace,
}

impl Status {
    /// The same for programs: one object, whose keys stay what they are.
    pub fn to_json(&self) -> Value {
        let progress = self.progress.map(|progress| {
            json!({
                "next_waypoint": progress.next + 1,
                "waypoints": progress.total,
                "complete": progress.complete,
                "cross_track_m": progress.cross_track_m,
                "to_go_m": progress.to_go_m,
                "speed_mps": progress.speed_mps,
                "wanted_speed_mps": progress.wanted_speed_mps,
            })
        });
        json!({
            "state": self.state.name(),
            "reason": self.reason.map(|reason| reason.to_string()),
            "failsafe": self.reason.and_then(|reason| reason.failsafe()).map(|failsafe| failsafe.definition().key),
            "system": self.vehicle.map(|vehicle| vehicle.system),
            "mode": self.mode.map(|mode| mode.to_string()),
            "armed": self.armed,
            "progress": progress,
            "round_trip_s": self.round_trip_s,
        })
    }
}
