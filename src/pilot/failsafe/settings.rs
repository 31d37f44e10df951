//! What the user may change about the failsafes.

use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use super::table::FailsafeSettings;
use super::table::{Action, DEFINITIONS, Definition, Failsafe};

/// One failsafe as the user wants it; what is left out keeps its default.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rule {
    /// The limit, in the failsafe's own unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// What is done when it is passed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub action: Option<Action>,
}

/// A failsafe that cannot be set so.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FailsafeError {
    /// The limit is out of range.
    #[error("failsafe {key}: a limit of {limit} {unit} is outside {least} to {most} {unit}")]
    Limit {
        /// The failsafe's key.
        key: &'static str,
        /// What was asked for.
        limit: f64,
        /// Its unit.
        unit: &'static str,
        /// Least value.
        least: f64,
        /// Largest value.
        most: f64,
    },
    /// The action cannot be taken.
    #[error("failsafe {key}: `{action}` is not possible then; use {allowed}")]
    Action {
        /// The failsafe's key.
        key: &'static str,
        /// What was asked for.
        action: Action,
        /// What could be.
        allowed: String,
    },
}

impl FailsafeSettings {
    /// The limit in force.
    pub fn limit(&self, failsafe: Failsafe) -> f64 {
        self.rule(failsafe).limit.unwrap_or(failsafe.definition().limit)
    }

    /// The action in force.
    pub fn action(&self, failsafe: Failsafe) -> Action {
        self.rule(failsafe).action.unwrap_or(failsafe.definition().action)
    }

    /// Sets one failsafe.
    ///
    /// # Errors
    /// A limit or an action that this failsafe cannot have; nothing is changed then.
    pub fn set(&mut self, failsafe: Failsafe, rule: Rule) -> Result<(), FailsafeError> {
        check(failsafe.definition(), &rule)?;
        *self.rule_mut(failsafe) = rule;
        Ok(())
    }

    /// Checks everything.
    ///
    /// # Errors
    /// The first limit or action that cannot be, with what could.
    pub fn check(&self) -> Result<(), FailsafeError> {
        DEFINITIONS.iter().try_for_each(|definition| check(definition, self.rule(definition.failsafe)))
    }
}

fn check(definition: &Definition, rule: &Rule) -> Result<(), FailsafeError> {
    let &Definition { key, unit, range: (least, most), allowed, .. } = definition;
    if let Some(limit) = rule.limit.filter(|limit| !(least..=most).contains(limit)) {
        return Err(FailsafeError::Limit { key, limit, unit, least, most });
    }
    match rule.action.filter(|action| !allowed.contains(action)) {
        None => Ok(()),
        Some(action) => {
            let allowed = allowed.iter().map(|action| action.name()).collect::<Vec<_>>().join(", ");
            Err(FailsafeError::Action { key, action, allowed })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_sound() {
        for (index, definition) in DEFINITIONS.iter().enumerate() {
            assert_eq!(definition.failsafe as usize, index);
            assert!((definition.range.0..=definition.range.1).contains(&definition.limit), "{definition:?}");
            assert!(definition.allowed.contains(&definition.action), "{definition:?}");
        }
        FailsafeSettings::default().check().unwrap();
    }

    #[test]
    fn every_key_can_be_set_in_a_file_and_comes_back() {
        for definition in DEFINITIONS {
            let text = format!("[{}]\naction = \"{}\"\n", definition.key, definition.action);
            let settings: FailsafeSettings = toml::from_str(&text).unwrap();
            assert_eq!(settings.rule(definition.failsafe).action, Some(definition.action));
            assert_eq!(settings.limit(definition.failsafe), definition.limit);
            let again: FailsafeSettings = toml::from_str(&toml::to_string(&settings).unwrap()).unwrap();
            assert_eq!(again, settings);
        }
        assert!(toml::from_str::<FailsafeSettings>("[battery]\nlimits = 1\n").is_err());
    }

    #[test]
    fn what_cannot_be_is_refused_with_what_can() {
        let mut settings = FailsafeSettings::default();
        let blind = Rule { action: Some(Action::HoldPosition), ..Rule::default() };
        let error = settings.set(Failsafe::PositionAge, blind).unwrap_err().to_string();
        assert!(error.contains("position-age") && error.contains("neutral-and-release"), "{error}");
        let absurd = Rule { limit: Some(f64::NAN), ..Rule::default() };
        assert!(settings.set(Failsafe::Battery, absurd).unwrap_err().to_string().contains("0 to 100 %"));
        assert_eq!(settings, FailsafeSettings::default());
    }
}
