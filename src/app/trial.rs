//! Options that decide a simulated run, shared by `simulate`, `compare` and `tune`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::failure::Failure;
use super::mission::Drivable;
use super::ranges::{DelayS, RateHz, SpeedMps, TurnRadiusM};
use super::sitl;
use super::world::World;
use crate::bridge::LEAST_SPEED_MPS;
use crate::control::{Boat, Controller, gains};
use crate::simulation::{Scenario, Trial};
use crate::vehicle::OutputKind;

/// Options of the control side.
#[derive(Debug, Clone, Args)]
pub struct TrialArgs {
    /// Speed over ground, m/s; the mission's own, or the boat's cruising speed, if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<SpeedMps>,
    /// By which messages the bridge steers
    #[arg(long, default_value = "rc-override", value_name = "rc-override|manual-control|guided")]
    pub output: OutputKind,
    /// The control loop's rate, Hz
    #[arg(long, default_value = "25", value_name = "HZ")]
    pub rate: RateHz,
    /// Time that commands need to the boat, seconds
    #[arg(long, default_value = "0", value_name = "S")]
    pub delay: DelayS,
    /// Gains in place of the boat's own, as `helmlink tune` writes them
    #[arg(long, value_name = "FILE")]
    pub gains: Option<PathBuf>,
    /// The controller's idea of the boat, in place of the one of the same name as the simulated hull
    #[arg(long, value_name = "FILE")]
    pub boat_file: Option<PathBuf>,
    /// Radius of the path's corners in place of the boat's own, m
    #[arg(long, value_name = "M")]
    pub turn_radius: Option<TurnRadiusM>,
}

impl TrialArgs {
    /// The controller's boat for a simulated hull called `hull`.
    ///
    /// # Errors
    /// A file that cannot be read or used, or a value that the boat does not allow.
    pub(super) fn boat(&self, hull: &str) -> Result<Boat, Failure> {
        let mut boat = match &self.boat_file {
            Some(path) => Boat::from_toml(&read(path, "--boat-file")?)
                .map_err(|error| Failure::usage(format!("{}: {error}", path.display())))?,
            None => Boat::embedded(hull).map_err(|error| {
                Failure::usage(format!("{error}, or give the controller's boat with --boat-file"))
            })?,
        };
        if let Some(path) = &self.gains {
            gains::apply(&mut boat, &read(path, "--gains")?)
                .map_err(|error| Failure::usage(format!("{}: {error}", path.display())))?;
        }
        if let Some(radius_m) = self.turn_radius {
            boat.limits.turn_radius_m = *radius_m;
            boat.check().map_err(|error| Failure::usage(format!("--turn-radius: {error}")))?;
        }
        Ok(boat)
    }

    /// The run that the options describe, nothing perturbed.
    ///
    /// # Errors
    /// An option out of range, or a file that cannot be used.
    pub(super) fn trial(
        &self,
        controller: Controller,
        world: &World,
        drivable: &Drivable,
    ) -> Result<Trial, Failure> {
        let boat = self.boat(&world.hull.name)?;
        let speed_mps = self.speed.map(f64::from);
        check_speed(speed_mps, &boat)?;
        let home = sitl::home(world, Some(&drivable.mission));
        let toward = sitl::first_target(home, &drivable.route);
        Ok(Trial {
            boat,
            controller,
            output: self.output,
            speed_mps,
            interval_s: 1.0 / *self.rate,
            hull: world.hull.clone(),
            sea: world.sea,
            sensors: world.sensors,
            seed: world.seed,
            delay_s: *self.delay,
            mission: drivable.mission.clone(),
            route: drivable.route.clone(),
            home,
            heading_rad: sitl::heading_rad(world, home, toward),
        })
    }
}

/// Puts a named scenario in place of the sea, the sensors and the delay.
pub(super) fn set_scenario(trial: &mut Trial, scenario: Scenario) {
    trial.sea = scenario.sea(&trial.hull);
    trial.sensors = scenario.sensors();
    trial.delay_s = scenario.delay_s();
}

/// # Errors
/// A speed that the boat cannot run.
pub(super) fn check_speed(speed_mps: Option<f64>, boat: &Boat) -> Result<(), Failure> {
    let range = LEAST_SPEED_MPS..=boat.limits.speed_max_mps;
    match speed_mps {
        Some(speed) if !range.contains(&speed) => Err(Failure::usage(format!(
            "--speed {speed}: it must lie between {} and {} m/s for boat {}",
            range.start(),
            range.end(),
            boat.name
        ))),
        _ => Ok(()),
    }
}

/// # Errors
/// The file that `option` names cannot be read: which, and why.
pub(super) fn read(path: &Path, option: &str) -> Result<String, Failure> {
    std::fs::read_to_string(path)
        .map_err(|error| Failure::usage(format!("{option} {}: {error}", path.display())))
}

/// # Errors
/// The file cannot be written: which, and why.
pub(super) fn write(path: &Path, content: &str, option: &str) -> Result<(), Failure> {
    std::fs::write(path, content).map_err(|error| {
        Failure::failed(format!(
            "cannot write {}: {error}; choose another file with {option}",
            path.display()
        ))
    })
}

/// The items of a comma-separated list.
///
/// # Errors
/// The first item that cannot be read.
pub(super) fn list<T: std::str::FromStr>(text: &str) -> Result<Vec<T>, Failure>
where
    T::Err: std::fmt::Display,
{
    text.split(',').map(|item| item.trim().parse().map_err(Failure::usage)).collect()
}
