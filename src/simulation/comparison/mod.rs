//! Controllers side by side: one cell per sea and perturbation, and what all cells say together.

pub mod cells;

use std::str::FromStr;

use serde::Serialize;

pub use cells::{Cell, Verdict, verdict};

use super::score::Score;

/// The error that is compared, root mean square in metres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Metric {
    /// Distance to the legs, from the first waypoint on.
    Whole,
    /// The same, more than 40 s after a change of leg.
    Settled,
    /// The same, more than 10 m from every waypoint.
    Straight,
    /// Distance to the smooth path that the controller was given.
    Path,
    /// The same, where that path is straight.
    #[serde(rename = "path-straight")]
    PathStraight,
    /// Not an error of control: how far the flight controller's position is from the boat's own, across the path.
    Navigation,
}

impl Metric {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Whole, Self::Settled, Self::Straight, Self::Path, Self::PathStraight, Self::Navigation];

    /// The name as it is typed.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::Settled => "settled",
            Self::Straight => "straight",
            Self::Path => "path",
            Self::PathStraight => "path-straight",
            Self::Navigation => "navigation",
        }
    }

    /// Of one run; one that did not complete counts with at least `failed_m`.
    #[must_use]
    pub fn of(self, score: Option<&Score>, completed: bool, failed_m: f64) -> f64 {
        let spread = score.and_then(|score| match self {
            Self::Whole => score.cross_track_m,
            Self::Settled => score.cross_track_settled_m,
            Self::Straight => score.cross_track_straight_m,
            Self::Path => score.path_error_m,
            Self::PathStraight => score.path_error_straight_m,
            Self::Navigation => score.navigation_error_m,
        });
        match (spread, completed) {
            (Some(spread), true) => spread.rms,
            (Some(spread), false) => spread.rms.max(failed_m),
            // A mission without a sample of this kind says nothing; one that never began says all.
            (None, completed) => {
                if completed {
                    0.0
                } else {
                    failed_m
                }
            }
        }
    }
}

/// The text names no metric.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no error that can be compared: choose one of whole, settled, straight, path, \
     path-straight, navigation"
)]
pub struct UnknownMetric(String);

impl FromStr for Metric {
    type Err = UnknownMetric;

    fn from_str(text: &str) -> Result<Self, UnknownMetric> {
        Self::ALL
            .into_iter()
            .find(|metric| metric.as_str() == text)
            .ok_or_else(|| UnknownMetric(text.to_owned()))
    }
}

impl std::fmt::Display for Metric {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}
