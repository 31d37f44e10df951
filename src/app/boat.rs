//! `helmlink boat`: a boat file by rule, for a boat about which little is known.

use std::path::{Path, PathBuf};

use clap::Args;

use super::cli::Common;
use super::console;
use super::failure::Failure;
use super::ranges::{EffectDelayS, LengthM, TopSpeedMps, TurningCircleM};
use super::trial;
use crate::control::Boat;
use crate::control::boat::derived::Particulars;

/// The controller's boat: one that comes with Helmlink by its name, or a boat file.
///
/// # Errors
/// A file that cannot be read or used, or a name that is none.
pub(super) fn load(boat: &str) -> Result<Boat, Failure> {
    if !is_file(boat) {
        return by_name(boat).map_err(Failure::usage);
    }
    let text = trial::read(Path::new(boat), "boat file")?;
    Boat::from_toml(&text).map_err(|error| Failure::usage(format!("{boat}: {error}")))
}

/// One that comes with Helmlink.
pub(super) fn by_name(name: &str) -> Result<Boat, String> {
    Boat::embedded(name).map_err(|error| format!("{error}, or give a boat file as `helmlink boat` writes it"))
}

/// Whether this is meant to be the name of a file rather than of a boat.
pub(super) fn is_file(boat: &str) -> bool {
    boat.contains(['.', '/', '\\']) || (Boat::names().all(|name| name != boat) && Path::new(boat).is_file())
}

/// `helmlink boat`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Example, for a boat of 2.8 m that makes 3.8 m/s and turns in 14 m:
  helmlink boat --length 2.8 --top-speed 3.8 --turning-circle 14 --out my-boat.toml
  helmlink simulate mission/plans/harbour-survey.waypoints --boat skiff --boat-file my-boat.toml")]
pub struct BoatArgs {
    /// Length of the hull, m
    #[arg(long, value_name = "M")]
    pub length: LengthM,
    /// Speed through the water at full throttle, m/s
    #[arg(long, value_name = "M/S")]
    pub top_speed: TopSpeedMps,
    /// Diameter of the circle at full steering and half throttle, m
    #[arg(long, value_name = "M")]
    pub turning_circle: TurningCircleM,
    /// From a command to its effect, seconds: transport, autopilot and servo
    #[arg(long, default_value = "0.2", value_name = "S")]
    pub delay: EffectDelayS,
    /// Name of the boat
    #[arg(long, default_value = "my-boat")]
    pub name: String,
    /// Write the boat file there instead of standard output
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

pub(super) fn run(args: &BoatArgs) -> Result<(), Failure> {
    let particulars = Particulars {
        length_m: *args.length,
        top_speed_mps: *args.top_speed,
        turning_circle_m: *args.turning_circle,
        delay_s: *args.delay,
    };
    let text = Boat::derived_file(&args.name, &particulars).map_err(Failure::usage)?;
    // What is written can be used.
    Boat::from_toml(&text).map_err(Failure::failed)?;
    if let Some(path) = &args.out {
        trial::write(path, &text, "--out")?;
    }
    if args.common.json {
        console::say(&serde_json::json!({ "name": args.name, "boat_file": text }).to_string());
    } else if args.out.is_none() {
        console::say(text.trim_end());
    }
    Ok(())
}
