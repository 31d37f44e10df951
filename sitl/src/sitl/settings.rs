//! What is simulated, and why it cannot be.

use helmlink_mission::geodesy::{Geodetic, PositionFault};

use crate::autopilot::AutopilotSettings;
use crate::faults::FaultError;
use crate::physics::{Hull, Sea, SensorSettings};

/// What is simulated. Same settings, same run.
#[derive(Debug, Clone, PartialEq)]
pub struct SitlSettings {
    /// The boat.
    pub hull: Hull,
    /// Current, wind and waves.
    pub sea: Sea,
    /// How good the sensors are.
    pub sensors: SensorSettings,
    /// Decides gusts, waves and sensor noise.
    pub seed: u64,
    /// Where the boat lies at the start.
    pub home: Geodetic,
    /// Its heading there, clockwise from north, rad.
    pub heading_rad: f64,
    /// Whether the boat is held at its place until it is first armed, so that no current carries it off
    /// while the user gets ready (ArduPilot's simulator has no current before arming either).
    pub moored_until_armed: bool,
    /// The autopilot.
    pub autopilot: AutopilotSettings,
}

impl SitlSettings {
    /// A boat in calm water with perfect sensors, heading north in the harbour basin of Trondheim.
    pub fn new(hull: Hull) -> Self {
        Self {
            hull,
            sea: Sea::default(),
            sensors: SensorSettings::perfect(),
            seed: 1,
            home: Geodetic::new(63.4406, 10.4022),
            heading_rad: 0.0,
            moored_until_armed: true,
            autopilot: AutopilotSettings::default(),
        }
    }
}

/// Why a boat cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SitlError {
    /// The start is nowhere on the globe.
    #[error("the boat cannot start at home: {0}")]
    Home(PositionFault),
    /// A heading that is no angle.
    #[error("the heading at the start is {0} rad: it must be a finite number")]
    Heading(f64),
    /// A parameter that the autopilot does not take.
    #[error("parameter {name} cannot be set to {value}: {cause}")]
    Parameter {
        /// Its name.
        name: String,
        /// The value asked for.
        value: f32,
        /// What is wrong.
        cause: String,
    },
}

/// Why a scenario cannot be played with this boat.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlayError {
    /// A fault that it cannot have.
    #[error(transparent)]
    Fault(#[from] FaultError),
    /// A parameter that it does not have.
    #[error("the scenario sets the parameter `{0}`, which the autopilot does not have")]
    NoSuchParameter(String),
}
