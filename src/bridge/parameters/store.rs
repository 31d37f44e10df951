//! The values, what they may be, and the text they are kept in.

use std::fmt::Write;

use thiserror::Error;

use super::table::{PARAMETERS, Parameter};
use crate::control::{Boat, BoatError};
use crate::pilot::failsafe::{FailsafeError, FailsafeSettings};

/// Everything that parameters change.
#[derive(Debug, Clone, PartialEq)]
pub struct Tunables {
    /// The boat with its gains.
    pub boat: Boat,
    /// The failsafes.
    pub failsafes: FailsafeSettings,
    /// Speed over ground where the mission does not say, m/s; 0 where the user has not said either.
    pub speed_mps: f64,
}

/// Why a parameter is not set.
#[derive(Debug, Error)]
pub enum ParameterError {
    /// There is none of this name.
    #[error("{0}: no such parameter")]
    Unknown(String),
    /// A line of the text is no name and number.
    #[error("line {line}: `{text}` is not NAME VALUE")]
    Syntax {
        /// Counted from 1.
        line: usize,
        /// What stands there.
        text: String,
    },
    /// The speed is beyond the boat's.
    #[error("{value} m/s is outside 0 to {most} m/s")]
    Speed {
        /// What was asked for.
        value: f64,
        /// The boat's limit.
        most: f64,
    },
    /// The number stands for no action.
    #[error("{0} is no action: 0 to 4")]
    Action(f64),
    /// A gain is out of range.
    #[error(transparent)]
    Gain(#[from] BoatError),
    /// A failsafe cannot be set so.
    #[error(transparent)]
    Failsafe(#[from] FailsafeError),
}

impl Tunables {
    /// The parameter of this number.
    pub fn value(&self, index: usize) -> Option<f32> {
        let parameter = PARAMETERS.get(index)?;
        Some(parameter.place.get(&mut self.clone()) as f32)
    }

    /// Sets one parameter by name.
    ///
    /// # Errors
    /// There is none of this name, or the value is not in its range; nothing is changed then.
    pub fn set(&mut self, name: &str, value: f32) -> Result<&'static Parameter, ParameterError> {
        let parameter = PARAMETERS
            .iter()
            .find(|parameter| parameter.name == name)
            .ok_or_else(|| ParameterError::Unknown(name.to_owned()))?;
        let value = decimal(value);
        let mut changed = self.clone();
        if !parameter.place.put(&mut changed, value) {
            return Err(ParameterError::Action(value));
        }
        changed.check()?;
        *self = changed;
        Ok(parameter)
    }

    fn check(&self) -> Result<(), ParameterError> {
        let most = self.boat.limits.speed_max_mps;
        if !(0.0..=most).contains(&self.speed_mps) {
            return Err(ParameterError::Speed { value: self.speed_mps, most });
        }
        self.boat.check()?;
        Ok(self.failsafes.check()?)
    }

    /// The parameters that differ from `factory`, one `NAME VALUE` a line, as ground stations write them.
    pub fn to_text(&self, factory: &Self) -> String {
        let mut text = String::from("# Helmlink's parameters that are not at their factory values\n");
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            let (value, usual) = (self.value(index), factory.value(index));
            if let Some(value) = value.filter(|_| value != usual) {
                // Writing to a string does not fail.
                let _ = writeln!(text, "{} {value}", parameter.name);
            }
        }
        text
    }

    /// Takes over what [`Self::to_text`] has written. What cannot be taken over is left, and told.
    pub fn read(&mut self, text: &str) -> Vec<ParameterError> {
        let mut complaints = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() {
                continue;
            }
            let mut words = line.split([' ', ',', '\t']).filter(|word| !word.is_empty());
            let pair = words.next().zip(words.next().and_then(|word| word.parse::<f32>().ok()));
            let result = match pair {
                Some((name, value)) => self.set(name, value).map(|_| ()),
                None => Err(ParameterError::Syntax { line: index + 1, text: line.to_owned() }),
            };
            complaints.extend(result.err());
        }
        complaints
    }
}

/// The shortest decimal that is this float: 0.1 and not 0.10000000149.
pub(super) fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn factory() -> Tunables {
        let boat = Boat::embedded("otter").unwrap();
        Tunables { boat, failsafes: FailsafeSettings::default(), speed_mps: 0.0 }
    }

    #[test]
    fn names_fit_and_are_unique_and_every_value_can_be_set_to_itself() {
        let mut tunables = factory();
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            assert!(parameter.name.len() <= 16 && !parameter.meaning.is_empty(), "{}", parameter.name);
            assert_eq!(PARAMETERS.iter().filter(|other| other.name == parameter.name).count(), 1);
            let value = tunables.value(index).unwrap();
            tunables.set(parameter.name, value).unwrap();
            assert_eq!(tunables.value(index), Some(value), "{}", parameter.name);
        }
        assert_eq!(tunables.to_text(&factory()).lines().count(), 1, "nothing has changed");
    }

    #[test]
    fn what_is_out_of_range_is_refused_with_the_range() {
        let mut tunables = factory();
        let refusal = |tunables: &mut Tunables, name: &str, value: f32| {
            let text = tunables.set(name, value).unwrap_err().to_string();
            assert_eq!(*tunables, factory(), "{name} {value}");
            text
        };
        assert!(refusal(&mut tunables, "HL_R_K", 1e6).contains("between"));
        assert!(refusal(&mut tunables, "HL_R_K", f32::NAN).contains("between"));
        assert!(refusal(&mut tunables, "HL_SPEED", 99.0).contains("0 to 2.5"));
        assert!(refusal(&mut tunables, "HL_FS_BATT", 101.0).contains("0 to 100"));
        assert!(refusal(&mut tunables, "HL_FSA_POS", 2.0).contains("neutral-and-release"));
        assert!(refusal(&mut tunables, "HL_FSA_POS", 2.5).contains("no action"));
        assert!(refusal(&mut tunables, "NO_SUCH", 0.0).contains("no such"));
    }

    #[test]
    fn every_range_is_the_one_that_is_kept_to() {
        for boat in ["otter", "motorboat", "monohull38", "skiff"] {
            let factory = Tunables { boat: Boat::embedded(boat).unwrap(), ..factory() };
            for (index, parameter) in PARAMETERS.iter().enumerate() {
                let (least, most) = parameter.range(&factory);
                let value = f64::from(factory.value(index).unwrap());
                assert!((least..=most * 1.000_001).contains(&value), "{boat}, {}: {value}", parameter.name);
                for beyond in [least - 0.5, most * 1.001 + 0.5] {
                    let refusal = factory.clone().set(parameter.name, beyond as f32);
                    assert!(refusal.is_err(), "{boat}, {}: {beyond} was taken", parameter.name);
                }
            }
        }
    }

    #[test]
    fn a_damaged_file_costs_only_its_damaged_lines() {
        let mut tunables = factory();
        let complaints =
            tunables.read("# x\nHL_R_K 2.5\nHL_R_K\nOLD_NAME 3\nHL_FS_BATT,30 # comment\n\u{0}\n");
        assert_eq!(complaints.len(), 3, "{complaints:?}");
        assert_eq!(tunables.boat.control.yaw.reaching_gain, 2.5);
        assert_eq!(tunables.failsafes.battery.limit, Some(30.0));
    }

    proptest! {
        #[test]
        fn what_is_set_comes_back_from_the_file(gain in 0.01_f32..40.0, limit in 0.0_f32..100.0) {
            let mut tunables = factory();
            tunables.set("HL_R_K", gain).unwrap();
            tunables.set("HL_FS_BATT", limit).unwrap();
            let mut again = factory();
            prop_assert!(again.read(&tunables.to_text(&factory())).is_empty());
            for index in 0..PARAMETERS.len() {
                prop_assert_eq!(again.value(index), tunables.value(index));
            }
        }
    }
}
