//! What the user may change about the failsafes.

use std::str::FromStr;

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

/// One failsafe's rule as a word: `KEY=LIMIT`, `KEY=ACTION` or `KEY=LIMIT:ACTION`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FailsafeOption(pub Failsafe, pub Rule);

impl FromStr for FailsafeOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let help = || {
            let keys = DEFINITIONS.map(|definition| definition.key).join(", ");
            format!("`{text}` is not KEY=LIMIT, KEY=ACTION or KEY=LIMIT:ACTION with a key of {keys}")
        };
        let (key, value) = text.split_once('=').ok_or_else(help)?;
        let definition = DEFINITIONS.iter().find(|definition| definition.key == key).ok_or_else(help)?;
        let mut rule = Rule::default();
        for word in value.split(':') {
            if let Ok(limit) = word.parse() {
                rule.limit = Some(limit);
            } else {
                let action = Action::ALL.into_iter().find(|action| action.name() == word);
                rule.action = Some(action.ok_or_else(|| {
                    let actions = Action::ALL.map(Action::name).join(", ");
                    format!("`{word}` is neither a limit nor one of {actions}")
                })?);
            }
        }
        check(definition, &rule).map_err(|error| error.to_string())?;
        Ok(Self(definition.failsafe, rule))
    }
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
    fn the_documentation_tells_the_truth() {
        let documentation = include_str!("../../../docs/safety.md");
        for Definition { key, limit, unit, action, allowed, watches, .. } in DEFINITIONS {
            let limit = if unit.is_empty() { "none".to_owned() } else { format!("{limit} {unit}") };
            let others: Vec<_> = allowed.iter().filter(|other| **other != action).map(|a| a.name()).collect();
            let others = if others.is_empty() { "none".to_owned() } else { others.join(", ") };
            let row = format!("| `{key}` | {watches} | {limit} | {action} | {others} |");
            assert!(documentation.contains(&row), "docs/safety.md needs the line\n{row}");
        }
    }

    #[test]
    fn a_rule_can_be_given_as_a_word() {
        let read = |text: &str| text.parse::<FailsafeOption>();
        let rule = |limit, action| Rule { limit, action };
        let expected = rule(Some(20.0), Some(Action::ReturnToLaunch));
        assert_eq!(read("battery=20:return-to-launch"), Ok(FailsafeOption(Failsafe::Battery, expected)));
        let expected = rule(None, Some(Action::HoldPosition));
        assert_eq!(read("ground-station=hold-position").unwrap().1, expected);
        assert_eq!(read("cross-track=8").unwrap().1, rule(Some(8.0), None));
        for wrong in ["battery", "batery=3", "battery=maybe", "battery=101", "position-age=warn", "battery="]
        {
            assert!(!read(wrong).unwrap_err().is_empty(), "{wrong}");
        }
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
