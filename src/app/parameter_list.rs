//! `helmlink config parameters`: what can be set over MAVLink, and within what limits.

use std::fmt::Write;

use clap::Args;
use serde::Serialize;

use super::boat;
use super::cli::Common;
use super::console;
use super::failure::Failure;
use crate::bridge::parameters::{PARAMETERS, Tunables};
use crate::pilot::failsafe::FailsafeSettings;

/// `helmlink config parameters`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Example:
  helmlink config parameters --boat motorboat

Ground stations set them on component 191, where they also find ranges and meanings if they ask for them
(COMPONENT_METADATA). A value out of range is refused with the reason, and the one in force is sent back.")]
pub struct ParametersArgs {
    /// The boat whose values and ranges are shown: a name, or a boat file
    #[arg(long, default_value = "otter", value_name = "NAME|FILE")]
    pub boat: String,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// One parameter as it is shown.
#[derive(Debug, Serialize)]
struct Row {
    name: &'static str,
    value: f32,
    least: f64,
    most: f64,
    unit: &'static str,
    meaning: &'static str,
}

pub(super) fn run(args: &ParametersArgs) -> Result<(), Failure> {
    let boat = boat::load(&args.boat)?;
    let rows = rows(&Tunables { boat, failsafes: FailsafeSettings::default(), speed_mps: 0.0 });
    if args.common.json {
        let said = serde_json::json!({ "boat": args.boat, "component": 191, "parameters": rows });
        console::say(&serde_json::to_string_pretty(&said).map_err(Failure::failed)?);
    } else {
        console::say(&table(&rows));
    }
    Ok(())
}

fn rows(tunables: &Tunables) -> Vec<Row> {
    let row = |(index, parameter): (usize, &crate::bridge::parameters::Parameter)| {
        let (least, most) = parameter.range(tunables);
        let (name, unit, meaning) = (parameter.name, parameter.unit, parameter.meaning);
        Some(Row { name, value: tunables.value(index)?, least, most, unit, meaning })
    };
    PARAMETERS.iter().enumerate().filter_map(row).collect()
}

fn table(rows: &[Row]) -> String {
    let mut text = format!("{:<12} {:>9}  {:<18} meaning", "name", "value", "range");
    for row in rows {
        let range = format!("{} to {}", row.least, row.most);
        let unit = if row.unit.is_empty() { String::new() } else { format!(" [{}]", row.unit) };
        // Writing to a string does not fail.
        let _ = write!(text, "\n{:<12} {:>9}  {range:<18} {}{unit}", row.name, row.value, row.meaning);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Boat;

    #[test]
    fn every_parameter_is_listed_with_its_range() {
        let boat = Boat::embedded("otter").unwrap();
        let rows = rows(&Tunables { boat, failsafes: FailsafeSettings::default(), speed_mps: 0.0 });
        assert_eq!(rows.len(), PARAMETERS.len());
        assert!(rows.iter().all(|row| row.least < row.most && !row.meaning.is_empty()));
        let text = table(&rows);
        assert!(text.contains("HL_FS_BATT          15  0 to 100"), "{text}");
    }
}
