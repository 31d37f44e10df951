//! Gains by name: what a gains file may set, and what tuning may change.
//!
//! ```toml
//! boat = "otter"
//!
//! [pid]
//! lead_m = 3.2
//! heading.frequency_radps = 1.3
//! ```
//!
//! Every controller has its own table; a key that is left out keeps the boat's value. Tables named `history` and
//! `tuning` are notes of how the gains were found, and are not read.

use thiserror::Error;
use toml::{Table, Value};

use super::boat::{Boat, BoatError};
use super::controller::Controller;

/// Tables that hold notes.
const NOTES: [&str; 2] = ["history", "tuning"];
/// No gain is larger than this.
const MOST: f64 = 1.0e6;

/// One gain of one controller.
#[derive(Debug, Clone, Copy)]
pub struct Gain {
    /// Its name in a gains file.
    pub key: &'static str,
    /// Whether tuning may change it.
    pub tuned: bool,
    get: fn(&Boat) -> f64,
    set: fn(&mut Boat, f64),
}

impl Gain {
    /// The boat's value.
    #[must_use]
    pub fn get(&self, boat: &Boat) -> f64 {
        (self.get)(boat)
    }

    /// Changes the boat's value, unchecked.
    pub fn set(&self, boat: &mut Boat, value: f64) {
        (self.set)(boat, value);
    }
}

/// Why gains cannot be used.
#[derive(Debug, Error)]
pub enum GainsError {
    /// Not TOML.
    #[error("the gains file cannot be read: {0}")]
    Syntax(#[from] Box<toml::de::Error>),
    /// For another boat.
    #[error("the gains are for boat {for_boat:?}, not {boat:?}: give the file that was tuned for it")]
    OtherBoat {
        /// The boat that they are for.
        for_boat: String,
        /// The boat that they were given to.
        boat: String,
    },
    /// A table that is no controller.
    #[error("[{0}] is no controller: tables may be called {known}", known = Controller::names())]
    Table(String),
    /// A key that the controller does not have.
    #[error("{controller} has no gain {key:?}: it has {known}")]
    Key {
        /// Whose table.
        controller: Controller,
        /// The key.
        key: String,
        /// The keys there are.
        known: String,
    },
    /// A value that is no sensible number.
    #[error("{controller}: {key} must be a number from 0 to {MOST}, not {value}")]
    Value {
        /// Whose table.
        controller: Controller,
        /// The key.
        key: String,
        /// What it was set to.
        value: String,
    },
    /// A value outside the range that the boat allows.
    #[error(transparent)]
    Range(#[from] BoatError),
}

macro_rules! gain {
    ($tuned:literal, $key:literal, $boat:ident => $place:expr) => {
        Gain { key: $key, tuned: $tuned, get: |$boat| $place, set: |$boat, value| $place = value }
    };
}

/// Gains of the practical guidance.
macro_rules! practical {
    ($boat:ident => $guidance:expr) => {
        vec![
            gain!(true, "lead_m", $boat => $guidance.lead_m),
            gain!(false, "lead_time_s", $boat => $guidance.lead_time_s),
            gain!(true, "lead_softness_m", $boat => $guidance.lead_softness_m),
            gain!(true, "drift_time_s", $boat => $guidance.drift_time_s),
            gain!(true, "preview_s", $boat => $guidance.preview_s),
            gain!(false, "speed_preview_s", $boat => $guidance.speed_preview_s),
        ]
    };
}

/// Gains of the PI sliding mode.
macro_rules! sliding {
    ($boat:ident => $control:expr) => {
        [
            gain!(true, "heading_gain", $boat => $control.heading_gain),
            gain!(false, "surge.filter_s", $boat => $control.surge.filter_s),
            gain!(true, "surge.reaching_gain", $boat => $control.surge.reaching_gain),
            gain!(false, "surge.integral_slope", $boat => $control.surge.integral_slope),
            gain!(false, "surge.boundary", $boat => $control.surge.boundary),
            gain!(false, "surge.disturbance_max", $boat => $control.surge.disturbance_max),
            gain!(true, "yaw.filter_s", $boat => $control.yaw.filter_s),
            gain!(false, "yaw.acceleration_max", $boat => $control.yaw.acceleration_max),
            gain!(true, "yaw.reaching_gain", $boat => $control.yaw.reaching_gain),
            gain!(true, "yaw.integral_slope", $boat => $control.yaw.integral_slope),
            gain!(true, "yaw.boundary", $boat => $control.yaw.boundary),
            gain!(true, "yaw.disturbance_max", $boat => $control.yaw.disturbance_max),
            gain!(false, "yaw.disturbance_rate", $boat => $control.yaw.disturbance_rate),
            gain!(false, "yaw.parameter_rate", $boat => $control.yaw.parameter_rate),
            gain!(false, "yaw.dead_zone", $boat => $control.yaw.dead_zone),
            gain!(false, "yaw.integral_max", $boat => $control.yaw.integral_max),
        ]
    };
}

/// Gains of a heading PID and a speed PI.
macro_rules! pid {
    ($boat:ident => $pid:expr) => {
        [
            gain!(true, "heading.frequency_radps", $boat => $pid.heading.frequency_radps),
            gain!(true, "heading.damping_ratio", $boat => $pid.heading.damping_ratio),
            gain!(true, "heading.integral_share", $boat => $pid.heading.integral_share),
            gain!(true, "heading.filter_s", $boat => $pid.heading.filter_s),
            gain!(false, "heading.acceleration_max_radps2", $boat => $pid.heading.acceleration_max_radps2),
            gain!(true, "speed.bandwidth_radps", $boat => $pid.speed.bandwidth_radps),
            gain!(true, "speed.integral_share", $boat => $pid.speed.integral_share),
        ]
    };
}

/// Gains of a line-of-sight guidance.
macro_rules! line_of_sight {
    ($boat:ident => $los:expr) => {
        vec![
            gain!(true, "look_ahead_m", $boat => $los.look_ahead_m),
            gain!(false, "look_ahead_s", $boat => $los.look_ahead_s),
            gain!(true, "adaptation", $boat => $los.adaptation),
            gain!(true, "reference_radps", $boat => $los.reference_radps),
        ]
    };
}

impl Controller {
    /// All gains of this controller.
    #[must_use]
    pub fn gains(self) -> Vec<Gain> {
        match self {
            Self::PiSmc => {
                let mut gains = joined(practical!(b => b.guidance), sliding!(b => b.control));
                gains.extend(observer());
                gains
            }
            Self::PiSmcPaper => joined(
                practical!(b => b.baselines.pi_smc_paper.guidance),
                sliding!(b => b.baselines.pi_smc_paper.control),
            ),
            Self::Pid => joined(practical!(b => b.baselines.pid.guidance), pid!(b => b.baselines.pid)),
            Self::IlosPid => {
                joined(line_of_sight!(b => b.baselines.ilos_pid.los), pid!(b => b.baselines.ilos_pid))
            }
            Self::AlosPid => {
                joined(line_of_sight!(b => b.baselines.alos_pid.los), pid!(b => b.baselines.alos_pid))
            }
            Self::SignSmc => joined(practical!(b => b.baselines.sign_smc.guidance), sign_smc()),
        }
    }
}

fn joined<const N: usize>(mut first: Vec<Gain>, second: [Gain; N]) -> Vec<Gain> {
    first.extend(second);
    first
}

fn observer() -> [Gain; 4] {
    [
        gain!(true, "observer.noise_radps", b => b.observer.noise_radps),
        gain!(true, "observer.noise_mps", b => b.observer.noise_mps),
        gain!(true, "observer.turn_bandwidth_radps", b => b.observer.turn_bandwidth_radps),
        gain!(true, "observer.move_bandwidth_radps", b => b.observer.move_bandwidth_radps),
    ]
}

fn sign_smc() -> [Gain; 9] {
    [
        gain!(true, "heading_gain", b => b.baselines.sign_smc.heading_gain),
        gain!(false, "surge.filter_s", b => b.baselines.sign_smc.surge.filter_s),
        gain!(false, "surge.acceleration_max", b => b.baselines.sign_smc.surge.acceleration_max),
        gain!(true, "surge.reaching_gain", b => b.baselines.sign_smc.surge.reaching_gain),
        gain!(true, "surge.switching_gain", b => b.baselines.sign_smc.surge.switching_gain),
        gain!(true, "yaw.filter_s", b => b.baselines.sign_smc.yaw.filter_s),
        gain!(false, "yaw.acceleration_max", b => b.baselines.sign_smc.yaw.acceleration_max),
        gain!(true, "yaw.reaching_gain", b => b.baselines.sign_smc.yaw.reaching_gain),
        gain!(true, "yaw.switching_gain", b => b.baselines.sign_smc.yaw.switching_gain),
    ]
}

/// Sets the gains of `text` on `boat`.
///
/// # Errors
/// Not TOML, for another boat, an unknown table or key, or a value out of range; the boat may then be half
/// changed and must not be used.
pub fn apply(boat: &mut Boat, text: &str) -> Result<(), GainsError> {
    let table: Table = toml::from_str(text).map_err(Box::new)?;
    for (name, value) in &table {
        match value {
            Value::String(for_boat) if name == "boat" => {
                if *for_boat != boat.name {
                    let (for_boat, boat) = (for_boat.clone(), boat.name.clone());
                    return Err(GainsError::OtherBoat { for_boat, boat });
                }
            }
            _ if NOTES.contains(&name.as_str()) => {}
            Value::Table(gains) => {
                let controller: Controller = name.parse().map_err(|_| GainsError::Table(name.clone()))?;
                apply_table(boat, controller, "", gains)?;
            }
            _ => return Err(GainsError::Table(name.clone())),
        }
    }
    Ok(boat.check()?)
}

fn apply_table(
    boat: &mut Boat,
    controller: Controller,
    prefix: &str,
    table: &Table,
) -> Result<(), GainsError> {
    for (name, value) in table {
        let key = format!("{prefix}{name}");
        if let Value::Table(inner) = value {
            apply_table(boat, controller, &format!("{key}."), inner)?;
            continue;
        }
        let gains = controller.gains();
        let Some(gain) = gains.iter().find(|gain| gain.key == key) else {
            let known = gains.iter().map(|gain| gain.key).collect::<Vec<_>>().join(", ");
            return Err(GainsError::Key { controller, key, known });
        };
        let number = match value {
            Value::Float(number) => *number,
            #[allow(clippy::cast_precision_loss)]
            Value::Integer(number) => *number as f64,
            _ => f64::NAN,
        };
        // NaN is in no range.
        if !(0.0..=MOST).contains(&number) {
            return Err(GainsError::Value { controller, key, value: value.to_string() });
        }
        gain.set(boat, number);
    }
    Ok(())
}

/// The gains of one controller as a table of a gains file.
#[must_use]
pub fn table(boat: &Boat, controller: Controller) -> String {
    let mut text = format!("[{controller}]\n");
    for gain in controller.gains() {
        text.push_str(&format!("{} = {:?}\n", gain.key, gain.get(boat)));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn otter() -> Boat {
        Boat::embedded("otter").unwrap()
    }

    #[test]
    fn every_gain_is_written_and_read_again() {
        for controller in Controller::ALL {
            let mut changed = otter();
            for (index, gain) in controller.gains().iter().enumerate() {
                let value = gain.get(&changed) * (1.0 + 0.001 * index as f64);
                gain.set(&mut changed, value);
            }
            let mut read = otter();
            apply(&mut read, &format!("boat = \"otter\"\n{}", table(&changed, controller))).unwrap();
            assert_eq!(read, changed, "{controller}");
            assert_ne!(read, otter(), "{controller}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, wanted) in [
            ("[pid]\nlead = 3.0", "lead_m"),
            ("[pdi]\nlead_m = 3.0", "pi-smc"),
            ("boat = \"skiff\"", "skiff"),
            ("[pid]\nlead_m = nan", "lead_m"),
            ("[pid]\nlead_m = \"long\"", "lead_m"),
            ("[pi-smc]\nlead_m = 0.0", "guidance.lead_m"),
            ("[pid", "gains file"),
        ] {
            let error = apply(&mut otter(), text).unwrap_err().to_string();
            assert!(error.contains(wanted), "{text}: {error}");
        }
    }

    #[test]
    fn notes_are_not_read() {
        let mut boat = otter();
        apply(&mut boat, "[history]\npid = [[1, 0.5]]\n[tuning]\nbudget = 100").unwrap();
        assert_eq!(boat, otter());
    }
}
