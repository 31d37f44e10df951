//! `helmlink mission convert`: from one mission file format to another.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use helmlink_mission::plan::{self, Format, Loss, Plan};
use serde_json::json;

use super::super::cli::Common;
use super::super::console;
use super::super::failure::Failure;
use super::say_notes;

/// `helmlink mission convert`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink mission convert survey.plan survey.waypoints
  helmlink mission convert track.gpx mission.plan
  helmlink mission convert survey.plan - --format geojson
  helmlink mission convert survey.plan survey.gpx --strict      fail rather than lose anything

The ending of the second file decides the format; docs/missions.md says what each can hold.")]
pub struct ConvertArgs {
    /// The mission file to read
    pub input: PathBuf,
    /// The file to write; - for standard output
    pub output: PathBuf,
    /// The format to write, if the ending does not say: wpl, plan, geojson, gpx, kml, kmz or csv
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Write nothing when something would be lost
    #[arg(long)]
    pub strict: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

pub(super) fn run(args: &ConvertArgs) -> Result<(), Failure> {
    let output = Some(args.output.as_path()).filter(|path| *path != Path::new("-"));
    let format = target(output, args.format.as_deref())?;
    let reading = plan::read_plan(&args.input).map_err(Failure::usage)?;
    say_notes(&reading.notes);
    let losses = format.losses(&reading.plan);
    if args.strict && !losses.is_empty() {
        let list: Vec<String> = losses.iter().map(ToString::to_string).collect();
        return Err(Failure::failed(format!(
            "{} cannot hold everything, so nothing was written: {}",
            format.name(),
            list.join("; ")
        )));
    }
    write(&reading.plan, format, output, args.common.json)?;
    if args.common.json {
        let losses: Vec<String> = losses.iter().map(ToString::to_string).collect();
        let report = json!({
            "input": args.input, "input_format": reading.format.name(), "output": output, "output_format": format.name(),
            "items": reading.plan.mission.items.len(), "fence_areas": reading.plan.fence.areas.len(),
            "rally_points": reading.plan.rally.len(), "losses": losses, "notes": reading.notes,
        });
        console::say(&report.to_string());
    }
    Ok(())
}

/// The format to write.
///
/// # Errors
/// Neither the name nor the ending says one.
pub(super) fn target(output: Option<&Path>, name: Option<&str>) -> Result<Format, Failure> {
    let known = || Format::ALL.map(Format::name).join(", ");
    match (name, output) {
        (Some(name), _) => Format::from_name(name)
            .ok_or_else(|| Failure::usage(format!("--format {name}: choose one of {}", known()))),
        (None, None) => Ok(Format::Wpl),
        (None, Some(path)) => Format::of_path(path).ok_or_else(|| {
            Failure::usage(format!(
                "the ending of {} stands for no format: give it another or say --format FORMAT ({})",
                path.display(),
                known()
            ))
        }),
    }
}

/// Writes a plan and tells what was lost.
///
/// # Errors
/// The file cannot be written; JSON and a file cannot both go to standard output.
pub(super) fn write(
    plan: &Plan,
    format: Format,
    output: Option<&Path>,
    json: bool,
) -> Result<Vec<Loss>, Failure> {
    let (bytes, losses) = format.encode(plan).map_err(Failure::failed)?;
    for loss in &losses {
        tracing::warn!("not in the {} file: {loss}", format.name());
    }
    match output {
        Some(path) => std::fs::write(path, bytes)
            .map_err(|error| Failure::failed(format!("cannot write {}: {error}", path.display())))?,
        None if json => {
            return Err(Failure::usage("--json needs standard output for itself: name a file to write"));
        }
        // A reader that has gone away is not our failure.
        None => {
            std::io::stdout().write_all(&bytes).ok();
        }
    }
    Ok(losses)
}
