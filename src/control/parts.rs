//! What a controller is made of, part by part: leave parts out, or give them to another controller, and see in a
//! comparison what each of them is worth.

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::controller::{Controller, Equipment};

/// A part that can be left out or given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Waves and noise taken out of the state.
    Observer,
    /// The state predicted across the known delay.
    Predictor,
    /// The estimate of the current.
    Current,
    /// The rate of the wanted heading fed forward: curvature of the path, plan of the turn.
    FeedForward,
    /// Adaptive parameters and disturbance bounds.
    Adaptation,
}

impl Part {
    /// All of them.
    pub const ALL: [Self; COUNT] =
        [Self::Observer, Self::Predictor, Self::Current, Self::FeedForward, Self::Adaptation];

    /// The name as it is typed.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Observer => "observer",
            Self::Predictor => "predictor",
            Self::Current => "current",
            Self::FeedForward => "feed-forward",
            Self::Adaptation => "adaptation",
        }
    }
}

const COUNT: usize = 5;

/// Parts given to a controller or taken from it. Written as `+observer-predictor`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(try_from = "String", into = "String")]
pub struct PartChanges([Option<bool>; COUNT]);

impl PartChanges {
    /// The controller is as its makers want it.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.0 == [None; COUNT]
    }

    fn set(&mut self, part: Part, given: bool) {
        self.0[part as usize] = Some(given);
    }

    /// What the helm has to do after the changes.
    pub(super) fn applied(self, equipment: Equipment) -> Equipment {
        let [observer, predictor, current, feed_forward, adaptation] = self.0;
        Equipment {
            observes_state: observer.unwrap_or(equipment.observes_state),
            predicts: predictor.unwrap_or(equipment.predicts),
            observes_water: current.unwrap_or(equipment.observes_water),
            feeds_forward: feed_forward.unwrap_or(equipment.feeds_forward),
            adapts: adaptation.unwrap_or(equipment.adapts),
        }
    }
}

impl std::fmt::Display for PartChanges {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for part in Part::ALL {
            if let Some(given) = self.0[part as usize] {
                write!(f, "{}{}", if given { '+' } else { '-' }, part.as_str())?;
            }
        }
        Ok(())
    }
}

/// The text names no part.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "`{0}` is no list of parts: write + or - and one of observer, predictor, current, feed-forward, adaptation, \
     for each part given or taken away; for example -predictor"
)]
pub struct UnknownPart(String);

impl FromStr for PartChanges {
    type Err = UnknownPart;

    fn from_str(text: &str) -> Result<Self, UnknownPart> {
        let mut changes = Self::default();
        let mut rest = text;
        while let Some(sign) = rest.chars().next() {
            let name = rest.strip_prefix(['+', '-']).ok_or_else(|| UnknownPart(text.to_owned()))?;
            let part = Part::ALL.into_iter().find(|part| name.starts_with(part.as_str()));
            let part = part.ok_or_else(|| UnknownPart(text.to_owned()))?;
            changes.set(part, sign == '+');
            rest = &name[part.as_str().len()..];
        }
        Ok(changes)
    }
}

impl TryFrom<String> for PartChanges {
    type Error = UnknownPart;

    fn try_from(text: String) -> Result<Self, UnknownPart> {
        text.parse()
    }
}

impl From<PartChanges> for String {
    fn from(changes: PartChanges) -> Self {
        changes.to_string()
    }
}

/// A controller with parts given or taken away, such as `pi-smc-predictor` or `pid+observer`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// The controller.
    pub controller: Controller,
    /// What differs from it.
    pub parts: PartChanges,
}

impl std::fmt::Display for Variant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", self.controller, self.parts)
    }
}

/// Why a text is no controller with parts.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum VariantError {
    /// It begins with no controller's name.
    #[error(transparent)]
    Controller(#[from] super::controller::UnknownController),
    /// What follows are no parts.
    #[error(transparent)]
    Part(#[from] UnknownPart),
}

impl FromStr for Variant {
    type Err = VariantError;

    fn from_str(text: &str) -> Result<Self, VariantError> {
        let begins = |controller: &Controller| text.starts_with(controller.as_str());
        let longest = Controller::ALL.into_iter().filter(begins).max_by_key(|c| c.as_str().len());
        let Some(controller) = longest else {
            return Err(text.parse::<Controller>().map(|_| UnknownPart(text.to_owned()))?.into());
        };
        Ok(Self { controller, parts: text[controller.as_str().len()..].parse()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_are_read_as_they_are_written() {
        for text in [
            "pi-smc",
            "pi-smc-paper",
            "pi-smc-predictor",
            "pi-smc-paper+observer-feed-forward",
            "pid+observer+predictor",
            "sign-smc-current-adaptation",
        ] {
            let variant: Variant = text.parse().unwrap();
            assert_eq!(variant.to_string(), text);
        }
        for wrong in ["", "pi-sm", "pi-smcx", "pid+", "pid+sail", "pid-observerx", "pid observer"] {
            assert!(wrong.parse::<Variant>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn parts_come_and_go() {
        let equipment = |text: &str| {
            let variant: Variant = text.parse().unwrap();
            variant.parts.applied(variant.controller.equipment())
        };
        assert!(equipment("pi-smc").predicts && !equipment("pi-smc-predictor").predicts);
        assert!(!equipment("pid").observes_state && equipment("pid+observer").observes_state);
        assert!(!equipment("pi-smc-adaptation").adapts && !equipment("pi-smc-feed-forward").feeds_forward);
        assert!(!equipment("pid-current").observes_water);
    }
}
