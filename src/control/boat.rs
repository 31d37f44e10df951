//! Everything the controller knows about one boat: nominal hull, actuators, limits and gains.
//!
//! The boats that come with Helmlink are TOML files next to this one, embedded in the binary. Anyone can
//! write another; every value is checked when it is loaded, and an error names the key and what it may be.

pub mod derived;
mod ranges;

use helmlink_mission::path::PathLimits;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::control::allocation::{CircleSettings, RudderSettings, TwinSettings};
use crate::control::axis::AxisSettings;
use crate::control::baselines::Baselines;
use crate::control::gains;
use crate::control::model::Hull;
use crate::control::observer::ObserverSettings;
use crate::control::parts::PartChanges;
use crate::guidance::GuidanceSettings;

/// Names and texts of the boats that come with Helmlink.
const EMBEDDED: [(&str, &str); 4] = [
    ("otter", include_str!("boats/otter.toml")),
    ("monohull38", include_str!("boats/monohull38.toml")),
    ("motorboat", include_str!("boats/motorboat.toml")),
    ("skiff", include_str!("boats/skiff.toml")),
];

/// Gains of the baselines, tuned for the boats that come with Helmlink.
const EMBEDDED_GAINS: [(&str, &str); 4] = [
    ("otter", include_str!("gains/otter.toml")),
    ("monohull38", include_str!("gains/monohull38.toml")),
    ("motorboat", include_str!("gains/motorboat.toml")),
    ("skiff", include_str!("gains/skiff.toml")),
];

/// A boat as its file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoatFile {
    name: String,
    description: String,
    hull: Hull,
    actuators: Actuators,
    limits: Limits,
    observer: ObserverSettings,
    guidance: GuidanceSettings,
    control: ControlSettings,
    /// Where they are not given they follow from the boat's own gains.
    baselines: Option<Baselines>,
    #[serde(default)]
    parts: PartChanges,
}

impl From<BoatFile> for Boat {
    fn from(file: BoatFile) -> Self {
        let BoatFile { name, description, hull, actuators, limits, observer, guidance, control, .. } = file;
        let (baselines, parts) = (file.baselines, file.parts);
        let baselines = baselines.unwrap_or_else(|| Baselines::matching(&guidance, &control));
        Self { name, description, hull, actuators, limits, observer, guidance, control, baselines, parts }
    }
}

/// One boat, checked.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(from = "BoatFile")]
pub struct Boat {
    /// Short name.
    pub name: String,
    /// One line on what the boat is and where its values come from.
    pub description: String,
    /// Nominal hull.
    pub hull: Hull,
    /// How a force and a moment become throttle and steering.
    pub actuators: Actuators,
    /// What the boat may be asked to do.
    pub limits: Limits,
    /// How waves and noise are told from motion.
    pub observer: ObserverSettings,
    /// Guidance gains.
    pub guidance: GuidanceSettings,
    /// Controller gains.
    pub control: ControlSettings,
    /// Gains of the controllers it is compared with.
    pub baselines: Baselines,
    /// Parts given to the controller or taken from it, to see what they are worth; none in a boat's file.
    #[serde(skip_serializing_if = "PartChanges::is_none")]
    pub parts: PartChanges,
}

/// Actuators of a boat.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Actuators {
    /// Two fixed thrusters behind the autopilot's skid-steer mixer.
    TwinThrusters(TwinSettings),
    /// Propeller and rudder, or an outboard that turns.
    PropellerRudder(RudderSettings),
    /// A boat known by its turning circle alone.
    TurningCircle(CircleSettings),
}

/// What the boat may be asked to do.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Speed over ground where neither the user nor the mission says, m/s.
    pub cruise_mps: f64,
    /// Radius planned for the corners of a path, m; the boat slows down as far as it must.
    pub turn_radius_m: f64,
    /// Largest speed through the water, m/s.
    pub speed_max_mps: f64,
    /// Least speed through the water at which the boat still steers, m/s; zero for twin thrusters.
    pub steerage_mps: f64,
    /// Largest yaw rate ever asked for, rad/s.
    pub yaw_rate_max_radps: f64,
    /// Yaw rate planned for a turn of the path, rad/s: leaves margin below the largest for corrections.
    pub turn_rate_radps: f64,
    /// Lateral acceleration planned for a turn, m/s².
    pub lateral_acceleration_mps2: f64,
    /// Deceleration planned before a turn and before the end of the path, m/s².
    pub deceleration_mps2: f64,
}

/// Gains of the adaptive PI sliding-mode controller.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ControlSettings {
    /// Heading gain k_ψ, 1/s.
    pub heading_gain: f64,
    /// Surge axis.
    pub surge: AxisSettings,
    /// Yaw axis.
    pub yaw: AxisSettings,
}

impl ControlSettings {
    /// The same law with its nominal parameters for ever and no disturbance bound.
    #[must_use]
    pub(super) fn without_adaptation(&self) -> Self {
        let still =
            |axis: &AxisSettings| AxisSettings { parameter_rate: 0.0, disturbance_rate: 0.0, ..axis.clone() };
        Self { surge: still(&self.surge), yaw: still(&self.yaw), ..self.clone() }
    }
}

/// Why a boat cannot be used.
#[derive(Debug, Error)]
pub enum BoatError {
    /// No embedded boat has this name.
    #[error("there is no boat called {name:?}; choose one of {known}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// Not TOML, an unknown key, a missing key or a wrong type.
    #[error("the boat file cannot be read: {0}")]
    Syntax(#[from] Box<toml::de::Error>),
    /// Gains that do not fit the boat.
    #[error("{0}")]
    Gains(String),
    /// A value outside its range.
    #[error("{key} = {value} is outside its range: it must be between {least} and {most} ({meaning})")]
    Range {
        /// Key, with its tables.
        key: &'static str,
        /// Value found.
        value: f64,
        /// Least value allowed.
        least: f64,
        /// Largest value allowed.
        most: f64,
        /// What the value is, and its unit.
        meaning: &'static str,
    },
}

/// Length of the transition into and out of a turn, as a share of its radius.
const TRANSITION_SHARE: f64 = 0.75;

impl Limits {
    /// How sharply a path for this boat may turn.
    pub fn path(&self) -> PathLimits {
        PathLimits::new(self.turn_radius_m, TRANSITION_SHARE * self.turn_radius_m)
    }
}

impl Boat {
    /// Its steering works by the flow of the water past it: not by two thrusters.
    #[must_use]
    pub fn steers_by_flow(&self) -> bool {
        !matches!(self.actuators, Actuators::TwinThrusters(_))
    }

    /// Names of the embedded boats.
    pub fn names() -> impl Iterator<Item = &'static str> {
        EMBEDDED.iter().map(|(name, _)| *name)
    }

    /// An embedded boat.
    ///
    /// # Errors
    /// [`BoatError::Unknown`] lists the names there are.
    pub fn embedded(name: &str) -> Result<Self, BoatError> {
        let Some((_, text)) = EMBEDDED.iter().find(|(known, _)| *known == name) else {
            let known = Self::names().collect::<Vec<_>>().join(", ");
            return Err(BoatError::Unknown { name: name.to_owned(), known });
        };
        let mut boat = Self::from_toml(text)?;
        if let Some((_, gains)) = EMBEDDED_GAINS.iter().find(|(known, _)| *known == name) {
            gains::apply(&mut boat, gains).map_err(|error| BoatError::Gains(error.to_string()))?;
        }
        Ok(boat)
    }

    /// A boat from the text of a file.
    ///
    /// # Errors
    /// Names the line or the key at fault and what would be right.
    pub fn from_toml(text: &str) -> Result<Self, BoatError> {
        let boat: Self = toml::from_str(text).map_err(Box::new)?;
        boat.check()?;
        Ok(boat)
    }
}

#[cfg(test)]
mod tests;
