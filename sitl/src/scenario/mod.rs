//! Scenarios: a sea, faults and orders over time, and what must come of them, in one file.
//!
//! The format is described in `docs/simulator.md`; examples lie in `sitl/scenarios/`. [`Scenario::from_toml`]
//! reads a file, [`Sitl::play`](crate::Sitl::play) puts it on, and
//! [`Sitl::verdicts`](crate::Sitl::verdicts) tells which expectations have come true.

mod expectation;
mod file;
mod play;

use std::time::Duration;

use crate::autopilot::mode_name;
use crate::faults::Fault;
use crate::physics::SeaState;
use crate::physics::sea::{Current, Waves, Wind};

pub use expectation::{Expectation, Observation, Verdict};
pub use file::ScenarioError;
pub(crate) use play::{Play, Stage};

/// A scenario, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// What it is called.
    pub name: String,
    /// One line about it.
    pub summary: String,
    /// How long it takes, on its own clock.
    pub duration: Duration,
    /// When its clock starts.
    pub clock: ScenarioClock,
    /// The world it wants, where it says so.
    pub world: ScenarioWorld,
    /// What must come of it.
    pub expectations: Vec<Expectation>,
    events: Vec<Event>,
}

/// When a scenario's clock starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScenarioClock {
    /// With the simulation.
    Start,
    /// When the boat is armed for the first time.
    Armed,
}

/// The world that a scenario wants, as it would be written on the command line; all of it has been checked
/// save home and mission, which are up to the program.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScenarioWorld {
    /// The boat.
    pub boat: Option<String>,
    /// The sea's name.
    pub sea: Option<String>,
    /// The current, `SPEED@TOWARD`.
    pub current: Option<String>,
    /// The wind, `SPEED@FROM`.
    pub wind: Option<String>,
    /// The waves, `HS:TP@FROM`.
    pub waves: Option<String>,
    /// Depth of the water, m.
    pub depth_m: Option<f64>,
    /// The sensors.
    pub sensors: Option<String>,
    /// Seed of everything random.
    pub seed: Option<u64>,
    /// Where the boat starts, `LAT,LON[,HEADING]`.
    pub home: Option<String>,
    /// A mission file, relative to the scenario's.
    pub mission: Option<String>,
}

/// Something that happens at a time of the scenario's clock.
#[derive(Debug, Clone, PartialEq)]
struct Event {
    at: Duration,
    what: Happening,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Happening {
    Fail(Fault),
    Repair(Fault),
    Sea(SeaState),
    Current(Current),
    Wind(Wind),
    Waves(Waves),
    DepthM(f64),
    Parameter { name: String, value: f32 },
    Arm,
    Disarm,
    Mode(u32),
}

/// The scenarios that come with helmlink, by name.
const BUILTIN: [(&str, &str); 6] = [
    ("bad-link", include_str!("../../scenarios/bad-link.toml")),
    ("freshening-wind", include_str!("../../scenarios/freshening-wind.toml")),
    ("gps-loss", include_str!("../../scenarios/gps-loss.toml")),
    ("lost-rudder", include_str!("../../scenarios/lost-rudder.toml")),
    ("rising-sea", include_str!("../../scenarios/rising-sea.toml")),
    ("tired-battery", include_str!("../../scenarios/tired-battery.toml")),
];

impl Scenario {
    /// Reads a scenario file.
    ///
    /// # Errors
    /// [`ScenarioError`] with the key, its line and what would be allowed.
    pub fn from_toml(text: &str) -> Result<Self, ScenarioError> {
        file::parse(text)
    }

    /// The first order that it gives the autopilot, in words: such a scenario wants the helm for itself. None if
    /// it leaves the steering to others.
    pub fn order(&self) -> Option<String> {
        self.events.iter().find_map(|Event { at, what }| {
            let order = match what {
                Happening::Arm => "arms the boat".to_owned(),
                Happening::Disarm => "disarms the boat".to_owned(),
                Happening::Mode(number) => format!("orders mode {}", mode_name(*number)?),
                _ => return None,
            };
            Some(format!("{order} at {} s", at.as_secs_f64()))
        })
    }

    /// What in it only an autopilot of our own can do or tell, in words.
    pub(crate) fn of_the_autopilot(&self) -> Option<String> {
        let parameter = || self.parameters().next().map(|name| format!("sets the parameter {name}"));
        let looks = || self.expectations.iter().find_map(Expectation::looks_at_the_autopilot);
        self.order().or_else(parameter).or_else(looks)
    }

    /// Every fault that it injects.
    pub(crate) fn faults(&self) -> impl Iterator<Item = &Fault> {
        self.events.iter().filter_map(|event| match &event.what {
            Happening::Fail(fault) => Some(fault),
            _ => None,
        })
    }

    /// Every parameter that it sets.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = &str> {
        self.events.iter().filter_map(|event| match &event.what {
            Happening::Parameter { name, .. } => Some(name.as_str()),
            _ => None,
        })
    }

    /// The scenario of this name that comes with helmlink.
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        BUILTIN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// Names of the scenarios that come with helmlink.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|(name, _)| *name)
    }
}

#[cfg(test)]
mod tests;
