//! The scenario file as it is written, and its validation.

use std::time::Duration;

use serde::Deserialize;

use super::expectation::{Expectation, Quantity, Test, Window};
use super::{Event, Happening, Scenario, ScenarioClock, ScenarioWorld};
use crate::autopilot::mode_number;
use crate::physics::sea::checked_depth_m;
use crate::physics::{Hull, SeaState, SensorSettings};
use crate::toml_place::{in_words, line_of};

/// Longest scenario, s: a week.
const LONGEST_S: f64 = 604_800.0;

/// Why a scenario was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScenarioError {
    /// The text is not TOML of the right form; the message shows the line.
    #[error("the scenario file cannot be read: {0}")]
    Syntax(String),
    /// A value that is not allowed.
    #[error("scenario key `{key}`{}: {cause}", in_words(*.line))]
    Key {
        /// Dotted key; tables of an array count from 0.
        key: String,
        /// Its line, from 1.
        line: Option<usize>,
        /// What is wrong, and what is allowed.
        cause: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(default)]
    summary: String,
    duration_s: f64,
    clock: Option<String>,
    world: Option<WorldTable>,
    #[serde(default)]
    event: Vec<EventTable>,
    #[serde(default)]
    expect: Vec<ExpectTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WorldTable {
    boat: Option<String>,
    sea: Option<String>,
    current: Option<String>,
    wind: Option<String>,
    waves: Option<String>,
    depth_m: Option<f64>,
    sensors: Option<String>,
    seed: Option<u64>,
    home: Option<String>,
    mission: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EventTable {
    at_s: f64,
    until_s: Option<f64>,
    fault: Option<String>,
    sea: Option<String>,
    current: Option<String>,
    wind: Option<String>,
    waves: Option<String>,
    depth_m: Option<f64>,
    parameter: Option<String>,
    action: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ExpectTable {
    quantity: String,
    is: Option<toml::Value>,
    below: Option<f64>,
    above: Option<f64>,
    after_s: Option<f64>,
    until_s: Option<f64>,
    within_s: Option<f64>,
}

/// The text, to find lines in.
struct Source<'a>(&'a str);

impl Source<'_> {
    fn wrong(&self, key: &str, cause: impl ToString) -> ScenarioError {
        ScenarioError::Key { key: key.to_owned(), line: line_of(self.0, key), cause: cause.to_string() }
    }

    fn seconds(&self, key: &str, value: f64) -> Result<Duration, ScenarioError> {
        if (0.0..=LONGEST_S).contains(&value) {
            return Ok(Duration::from_secs_f64(value));
        }
        Err(self.wrong(key, format!("{value} must be between 0 and {LONGEST_S} s")))
    }

    fn depth_m(&self, key: &str, depth_m: f64) -> Result<f64, ScenarioError> {
        checked_depth_m(depth_m).map_err(|error| self.wrong(key, error))
    }

    fn text<T: std::str::FromStr<Err: ToString>>(&self, key: &str, text: &str) -> Result<T, ScenarioError> {
        text.parse::<T>().map_err(|error| self.wrong(key, error.to_string()))
    }
}

pub(super) fn parse(text: &str) -> Result<Scenario, ScenarioError> {
    let file: File = toml::from_str(text).map_err(|error| ScenarioError::Syntax(error.to_string()))?;
    let source = Source(text);
    let duration = source.seconds("duration_s", file.duration_s)?;
    if duration.is_zero() {
        return Err(source.wrong("duration_s", "a scenario must take some time"));
    }
    let clock = match file.clock.as_deref() {
        None | Some("start") => ScenarioClock::Start,
        Some("armed") => ScenarioClock::Armed,
        Some(other) => return Err(source.wrong("clock", format!("`{other}` must be start or armed"))),
    };
    let mut events = Vec::new();
    for (number, table) in file.event.iter().enumerate() {
        events.extend(event(&source, &format!("event.{number}"), table)?);
    }
    // Stable, so that what stands first in the file happens first.
    events.sort_by_key(|event| event.at);
    let expectations = file
        .expect
        .iter()
        .enumerate()
        .map(|(number, table)| expectation(&source, &format!("expect.{number}"), table, duration))
        .collect::<Result<_, _>>()?;
    let world = file.world.map(|table| world(&source, table)).transpose()?.unwrap_or_default();
    Ok(Scenario { name: file.name, summary: file.summary, duration, clock, world, expectations, events })
}

fn world(source: &Source<'_>, table: WorldTable) -> Result<ScenarioWorld, ScenarioError> {
    let check = |key: &str, text: &Option<String>, test: fn(&str) -> Result<(), String>| match text {
        Some(text) => test(text).map_err(|cause| source.wrong(&format!("world.{key}"), cause)),
        None => Ok(()),
    };
    fn parses<T: std::str::FromStr<Err: ToString>>(text: &str) -> Result<(), String> {
        text.parse::<T>().map(|_| ()).map_err(|error| error.to_string())
    }
    // A path of a hull file is for the program to find.
    let is_name = |boat: &str| !boat.contains(['.', '/', '\\']);
    if let Some(boat) = table.boat.as_deref().filter(|boat| is_name(boat)) {
        Hull::builtin(boat).map_err(|error| source.wrong("world.boat", error))?;
    }
    check("sea", &table.sea, parses::<SeaState>)?;
    check("current", &table.current, parses::<crate::physics::sea::Current>)?;
    check("wind", &table.wind, parses::<crate::physics::sea::Wind>)?;
    check("waves", &table.waves, parses::<crate::physics::sea::Waves>)?;
    check("sensors", &table.sensors, parses::<SensorSettings>)?;
    let depth_m = table.depth_m.map(|depth_m| source.depth_m("world.depth_m", depth_m)).transpose()?;
    let WorldTable { boat, sea, current, wind, waves, depth_m: _, sensors, seed, home, mission } = table;
    Ok(ScenarioWorld { boat, sea, current, wind, waves, depth_m, sensors, seed, home, mission })
}

fn event(source: &Source<'_>, key: &str, table: &EventTable) -> Result<Vec<Event>, ScenarioError> {
    let at = source.seconds(&format!("{key}.at_s"), table.at_s)?;
    let until = table.until_s.map(|until| source.seconds(&format!("{key}.until_s"), until)).transpose()?;
    let sub = |name: &str| format!("{key}.{name}");
    let mut events = Vec::new();
    let mut happen = |what| events.push(Event { at, what });
    if let Some(text) = &table.sea {
        happen(Happening::Sea(source.text(&sub("sea"), text)?));
    }
    if let Some(text) = &table.current {
        happen(Happening::Current(source.text(&sub("current"), text)?));
    }
    if let Some(text) = &table.wind {
        happen(Happening::Wind(source.text(&sub("wind"), text)?));
    }
    if let Some(text) = &table.waves {
        happen(Happening::Waves(source.text(&sub("waves"), text)?));
    }
    if let Some(depth_m) = table.depth_m {
        happen(Happening::DepthM(source.depth_m(&sub("depth_m"), depth_m)?));
    }
    if let Some(text) = &table.parameter {
        happen(parameter(text).map_err(|cause| source.wrong(&sub("parameter"), cause))?);
    }
    if let Some(text) = &table.action {
        happen(action(text).map_err(|cause| source.wrong(&sub("action"), cause))?);
    }
    if let Some(text) = &table.fault {
        let fault = source.text(&sub("fault"), text)?;
        happen(Happening::Fail(fault));
        if let Some(until) = until {
            if until <= at {
                return Err(
                    source.wrong(&sub("until_s"), format!("must be later than at_s = {}", table.at_s))
                );
            }
            events.push(Event { at: until, what: Happening::Repair(fault) });
        }
    } else if until.is_some() {
        return Err(source.wrong(&sub("until_s"), "only a fault has an end"));
    }
    if events.is_empty() {
        let kinds = "fault, sea, current, wind, waves, depth_m, parameter or action";
        return Err(source.wrong(key, format!("nothing happens: give one of {kinds}")));
    }
    Ok(events)
}

/// `NAME=VALUE`.
fn parameter(text: &str) -> Result<Happening, String> {
    let form = || format!("`{text}` must be NAME=VALUE, such as FS_GCS_ENABLE=1");
    let (name, value) = text.split_once('=').ok_or_else(form)?;
    let value = value.trim().parse().map_err(|_| form())?;
    Ok(Happening::Parameter { name: name.trim().to_owned(), value })
}

fn action(text: &str) -> Result<Happening, String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    match words.as_slice() {
        ["arm"] => Ok(Happening::Arm),
        ["disarm"] => Ok(Happening::Disarm),
        ["mode", name] => {
            let number =
                mode_number(name).ok_or_else(|| format!("`{name}` is no mode, such as AUTO or HOLD"))?;
            Ok(Happening::Mode(number))
        }
        _ => Err(format!("`{text}` must be arm, disarm or mode NAME")),
    }
}

fn expectation(
    source: &Source<'_>,
    key: &str,
    table: &ExpectTable,
    duration: Duration,
) -> Result<Expectation, ScenarioError> {
    let sub = |name: &str| format!("{key}.{name}");
    let quantity: Quantity = source.text(&sub("quantity"), &table.quantity)?;
    let test = match (&table.is, table.below, table.above) {
        (Some(value), None, None) => quantity.is(value).map_err(|cause| source.wrong(&sub("is"), cause))?,
        (None, None, None) => return Err(source.wrong(key, "give is, below or above")),
        (None, below, above) if quantity.is_number() => {
            let bound = |name: &str, value: Option<f64>| match value {
                Some(value) if !value.is_finite() => Err(source.wrong(&sub(name), "must be a finite number")),
                value => Ok(value),
            };
            Test::Between { above: bound("above", above)?, below: bound("below", below)? }
        }
        (None, ..) => return Err(source.wrong(key, format!("{quantity} is no number: use is"))),
        (Some(_), ..) => return Err(source.wrong(key, "give is alone, or below and above")),
    };
    let after = match table.after_s {
        Some(after_s) => source.seconds(&sub("after_s"), after_s)?,
        None => Duration::ZERO,
    };
    let window = match (table.within_s, table.until_s) {
        (Some(_), Some(_)) => {
            return Err(
                source.wrong(&sub("until_s"), "give within_s (once) or until_s (all the time), not both")
            );
        }
        (Some(within_s), None) => {
            Window::Once { from: after, until: after + source.seconds(&sub("within_s"), within_s)? }
        }
        (None, until) => {
            let until = until.map(|until| source.seconds(&sub("until_s"), until)).transpose()?;
            Window::Always { from: after, until: until.unwrap_or(duration) }
        }
    };
    let (from, until) = window.span();
    if until < from || until > duration {
        let cause = format!("its time must lie within the scenario's {} s", duration.as_secs_f64());
        return Err(source.wrong(key, cause));
    }
    Ok(Expectation { quantity, test, window })
}
