//! Scenario files: found, put over the options of the world, and their expectations reported.

use std::path::{Path, PathBuf};

use helmlink_sitl::scenario::{Scenario, Verdict};

use super::failure::Failure;
use super::ranges::DepthM;
use super::world::WorldArgs;

/// A scenario file and where it lies.
#[derive(Debug, Clone)]
pub(super) struct ScenarioFile {
    pub(super) scenario: Scenario,
    folder: PathBuf,
}

/// Finds a scenario: the name of one that comes with helmlink, or the path of a file.
///
/// # Errors
/// There is no such file, or it is no scenario: which key, on which line.
pub(super) fn load(name: &str) -> Result<ScenarioFile, Failure> {
    let path = Path::new(name);
    let (text, folder) = match Scenario::builtin_text(name) {
        Some(text) => (text.to_owned(), PathBuf::new()),
        None => {
            let names = Scenario::names().collect::<Vec<_>>().join(", ");
            let text = std::fs::read_to_string(path).map_err(|error| {
                Failure::usage(format!("--scenario {name}: {error}; give a file, or one of {names}"))
            })?;
            (text, path.parent().map(Path::to_owned).unwrap_or_default())
        }
    };
    let scenario =
        Scenario::from_toml(&text).map_err(|error| Failure::usage(format!("--scenario {name}: {error}")))?;
    Ok(ScenarioFile { scenario, folder })
}

/// The same for a boat that somebody else steers.
///
/// # Errors
/// As [`load`], or the scenario gives orders of its own.
pub(super) fn load_without_orders(name: &str) -> Result<ScenarioFile, Failure> {
    let file = load(name)?;
    match file.scenario.order() {
        None => Ok(file),
        Some(order) => Err(Failure::usage(format!(
            "--scenario {name}: it {order}, but here the bridge is at the helm; run it with `helmlink sitl \
             --scenario {name}`"
        ))),
    }
}

impl ScenarioFile {
    /// Puts the scenario's world over the options.
    pub(super) fn apply(&self, args: &mut WorldArgs) {
        let world = &self.scenario.world;
        let put = |option: &mut String, value: &Option<String>| {
            if let Some(value) = value {
                option.clone_from(value);
            }
        };
        put(&mut args.boat, &world.boat);
        put(&mut args.sea, &world.sea);
        put(&mut args.sensors, &world.sensors);
        for (option, value) in [
            (&mut args.current, &world.current),
            (&mut args.wind, &world.wind),
            (&mut args.waves, &world.waves),
            (&mut args.home, &world.home),
        ] {
            if value.is_some() {
                option.clone_from(value);
            }
        }
        // The scenario's has been checked.
        let depth = world.depth_m.and_then(|depth_m| DepthM::try_from(depth_m).ok());
        args.depth = depth.or(args.depth);
        if let Some(seed) = world.seed {
            args.seed = seed;
        }
    }

    /// The mission file that the scenario names, next to the scenario's own.
    pub(super) fn mission(&self) -> Option<PathBuf> {
        self.scenario.world.mission.as_ref().map(|mission| self.folder.join(mission))
    }
}

/// The expectations and what has become of them, one line each.
pub(super) fn text(verdicts: &[Verdict]) -> String {
    let line = |verdict: &Verdict| {
        let word = match verdict.passed {
            Some(true) => "passed",
            Some(false) => "FAILED",
            None => "open  ",
        };
        let seen = if verdict.seen.is_empty() { String::new() } else { format!(" ({})", verdict.seen) };
        format!("  {word}  {}{seen}", verdict.expectation)
    };
    verdicts.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// The same for programs.
pub(super) fn json(verdicts: &[Verdict]) -> serde_json::Value {
    let entry = |verdict: &Verdict| {
        serde_json::json!({
            "expectation": verdict.expectation,
            "passed": verdict.passed,
            "seen": verdict.seen,
        })
    };
    serde_json::Value::Array(verdicts.iter().map(entry).collect())
}

/// # Errors
/// An expectation has not come true: the first such one.
pub(super) fn check(verdicts: &[Verdict]) -> Result<(), Failure> {
    match verdicts.iter().find(|verdict| verdict.passed != Some(true)) {
        None => Ok(()),
        Some(verdict) => {
            let seen = if verdict.seen.is_empty() { "it was never decided" } else { &verdict.seen };
            Err(Failure::failed(format!("the scenario expected {}: {seen}", verdict.expectation)))
        }
    }
}
