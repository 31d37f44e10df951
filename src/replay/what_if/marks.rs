//! How well what was driven was driven, and how the commands of the controller compare with those put out.

use helmlink_mission::geodesy::NorthEast;

use super::{Comparison, Moment, WhatIfResult};
use crate::pilot::Progress;
use crate::replay::servo::Outputs;
use crate::simulation::score::{Sample, Scorer, distance_to_segment_m};
use crate::vehicle::output::Demand;

/// Samples of the score come at this interval of vehicle time, seconds.
const SAMPLE_S: f64 = 0.1;

/// Scores both sides of a replay over one mission.
#[derive(Debug, Default)]
pub(super) struct Marks {
    /// With the outputs recorded, with the commands replayed; none until there is a mission.
    scorers: Option<[Scorer; 2]>,
    sums: Sums,
    sampled_s: Option<f64>,
}

impl Marks {
    /// From here on another mission is driven.
    pub(super) fn begin(&mut self, waypoints: &[NorthEast]) {
        let scorer = Scorer::new(waypoints.to_vec());
        self.scorers = Some([scorer.clone(), scorer]);
    }

    /// Takes an instant at which the controller has commanded `demand`.
    pub(super) fn on_moment(&mut self, moment: &Moment, leg: usize, progress: &Progress, demand: &Demand) {
        let is_due = self.sampled_s.is_none_or(|then_s| moment.time_s >= then_s + SAMPLE_S - 1e-9);
        let Some([recorded, replayed]) = self.scorers.as_mut().filter(|_| is_due) else { return };
        self.sampled_s = Some(moment.time_s);
        let path_error_m = moment.thought.map_or(0.0, |thought| f64::from(thought.cross_track_m).abs());
        let sample = |steering, throttle| Sample {
            time_s: moment.time_s,
            position: moment.state.position,
            speed_mps: progress.speed_mps,
            leg,
            path_error_m,
            path_is_straight: false,
            navigation_error_m: None,
            wanted_speed_mps: progress.wanted_speed_mps,
            steering,
            throttle,
        };
        replayed.on_sample(sample(demand.steering, demand.throttle));
        if let Some(outputs) = moment.outputs {
            recorded.on_sample(sample(outputs.steering, outputs.throttle));
            self.sums.add(&outputs, demand);
        }
    }

    /// Puts the figures into `result`.
    pub(super) fn tell(&self, result: &mut WhatIfResult) {
        let Some([recorded, replayed]) = self.scorers.as_ref().filter(|_| self.sampled_s.is_some()) else {
            return;
        };
        result.recorded = (self.sums.count > 0).then(|| recorded.score());
        result.replayed = Some(replayed.score());
        result.difference = self.sums.comparison();
    }
}

#[derive(Debug, Default)]
struct Sums {
    count: u64,
    steering: [f64; 5],
    throttle_squared: f64,
}

impl Sums {
    fn add(&mut self, recorded: &Outputs, replayed: &Demand) {
        let (a, b) = (recorded.steering, replayed.steering);
        self.count += 1;
        for (sum, value) in self.steering.iter_mut().zip([a, b, a * a, b * b, a * b]) {
            *sum += value;
        }
        self.throttle_squared += (recorded.throttle - replayed.throttle).powi(2);
    }

    fn comparison(&self) -> Option<Comparison> {
        let n = self.count as f64;
        let [a, b, aa, bb, ab] = self.steering.map(|sum| sum / n);
        let spread = (aa - a * a) * (bb - b * b);
        (self.count > 0).then(|| Comparison {
            samples: self.count,
            steering_rms: (aa + bb - 2.0 * ab).max(0.0).sqrt(),
            throttle_rms: (self.throttle_squared / n).sqrt(),
            steering_correlation: (spread > 1e-12).then(|| (ab - a * b) / spread.sqrt()),
        })
    }
}

/// Distance to the right of the nearest of a leg and its neighbours, metres, as the score measures it.
pub(super) fn leg_error_m(position: NorthEast, waypoints: &[NorthEast], leg: usize) -> Option<f64> {
    waypoints
        .windows(2)
        .enumerate()
        .filter(|(index, _)| index.abs_diff(leg) <= 1)
        .map(|(_, ends)| {
            let distance_m = distance_to_segment_m(position, ends[0], ends[1]);
            distance_m.copysign(signed_distance_m(position, ends[0], ends[1]))
        })
        .min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// Distance to the right of the straight line from `from` to `to`, metres.
fn signed_distance_m(point: NorthEast, from: NorthEast, to: NorthEast) -> f64 {
    let along = to - from;
    let length_m = along.norm();
    if length_m == 0.0 { (point - from).norm() } else { along.cross(point - from) / length_m }
}
