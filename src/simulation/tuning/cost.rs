//! What one set of gains costs.

use crate::simulation::comparison::Metric;
use crate::simulation::{Outcome, Trial};

/// Steering variation of one per minute costs as much error as this many metres per metre of boat.
pub const STEERING_COST_PER_LENGTH: f64 = 0.002;
/// A run that fails counts with this many lengths of the boat.
const FAILED_LENGTHS: f64 = 5.0;

/// Cost of one run in metres: the root mean square of the error against the smooth path, and the wear of the
/// steering on top.
#[must_use]
pub fn cost_m(trial: &Trial, outcome: &Outcome) -> f64 {
    let length_m = trial.hull.length_m;
    let score = outcome.score.as_ref();
    let error_m = Metric::Path.of(score, outcome.completed, FAILED_LENGTHS * length_m);
    let steering = score.map_or(0.0, |score| score.steering_variation_per_min);
    error_m + STEERING_COST_PER_LENGTH * length_m * steering
}
