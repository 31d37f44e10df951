//! Finds gains by trying them in simulation: same cost, same seas, same number of tries for every controller.
//!
//! | module | what it does |
//! |---|---|
//! | [`search`] | derivative-free search: a covariance adaptation of the diagonal, in logarithms |
//! | [`cost`] | what one set of gains costs |

pub mod cost;
pub mod search;

pub use cost::{STEERING_COST_PER_LENGTH, cost_m};
pub use search::{Found, Search};

use crate::control::Boat;
use crate::control::gains::Gain;

/// Gains may move this far from where they started, as a factor either way.
const REACH: f64 = 8.0;

/// Logarithms of the gains that tuning may change.
#[must_use]
pub fn start(boat: &Boat, gains: &[Gain]) -> Vec<f64> {
    gains.iter().map(|gain| gain.get(boat).max(f64::MIN_POSITIVE).ln()).collect()
}

/// The boat with its gains at `point`; none where the boat does not allow them.
#[must_use]
pub fn with_gains(boat: &Boat, gains: &[Gain], start: &[f64], point: &[f64]) -> Option<Boat> {
    let mut changed = boat.clone();
    for ((gain, start), value) in gains.iter().zip(start).zip(point) {
        if (value - start).abs() > REACH.ln() {
            return None;
        }
        gain.set(&mut changed, value.exp());
    }
    changed.check().is_ok().then_some(changed)
}
