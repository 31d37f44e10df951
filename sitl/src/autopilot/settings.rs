//! What can be chosen about the autopilot.

use std::time::Duration;

use helmlink_wire::signing::{SigningKey, Timestamp};

/// Settings of the autopilot.
#[derive(Debug, Clone, PartialEq)]
pub struct AutopilotSettings {
    /// How long it takes to get ready.
    pub start_up: StartUp,
    /// Whether a radio receiver with centred sticks is connected. Without one the boat can be armed only
    /// while RC overrides arrive, or with the throttle failsafe (`FS_THR_ENABLE`) switched off, as on a real
    /// boat. The parameter `SIM_RC_FAIL` changes it during the run.
    pub has_rc_receiver: bool,
    /// Parameters to begin with, by name, on top of the defaults and the tuning for the hull.
    pub parameters: Vec<(String, f32)>,
    /// The key of the links, and the time from which signatures count: frames are signed with it, and those
    /// that are not are refused. A client changes it with SETUP_SIGNING. Without one nothing is signed.
    pub signing: Option<(SigningKey, Timestamp)>,
}

impl Default for AutopilotSettings {
    fn default() -> Self {
        Self { start_up: StartUp::default(), has_rc_receiver: true, parameters: Vec::new(), signing: None }
    }
}

/// When the autopilot is how far, in simulated time after it is switched on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StartUp {
    /// It leaves INITIALISING for its first mode, and its sensors are healthy.
    pub initialised_after: Duration,
    /// It can be armed.
    pub armable_after: Duration,
    /// It knows its position; home is set then.
    pub position_after: Duration,
}

impl StartUp {
    /// Ready within 2 s: nobody has to wait.
    pub const fn quick() -> Self {
        Self {
            initialised_after: Duration::from_millis(1000),
            armable_after: Duration::from_millis(2000),
            position_after: Duration::from_millis(2000),
        }
    }

    /// As slow as ArduRover 4.6 in its own simulator: armable after 22.7 s, a position after 42 s (measured).
    pub const fn realistic() -> Self {
        Self {
            initialised_after: Duration::from_millis(2300),
            armable_after: Duration::from_millis(22_700),
            position_after: Duration::from_secs(42),
        }
    }
}

impl Default for StartUp {
    fn default() -> Self {
        Self::quick()
    }
}
