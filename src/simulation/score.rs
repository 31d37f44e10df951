//! How well a boat followed its mission, measured on its true position.

use helmlink_mission::geodesy::NorthEast;
use serde::Serialize;

use crate::thin::Sampled;

/// Samples this long after a change of leg count as settled, seconds.
const SETTLED_AFTER_S: f64 = 40.0;
/// Samples farther than this from every waypoint count as straight, metres.
const STRAIGHT_BEYOND_M: f64 = 10.0;
/// Errors kept for the percentile at the most: seven hours at ten a second.
const MOST_ERRORS: usize = 1 << 18;

/// Root mean square, mean, 95th percentile and maximum of a set of absolute errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Root mean square.
    pub rms: f64,
    /// Mean.
    pub mean: f64,
    /// 95th percentile (nearest rank).
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

/// The figures of one run; lengths in metres, times in seconds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Score {
    /// Duration from the first waypoint to the end.
    pub duration_s: f64,
    /// Distance driven over ground from the first waypoint on.
    pub distance_m: f64,
    /// Distance to the nearest point of the active leg or its neighbours.
    pub cross_track_m: Option<Spread>,
    /// The same, more than 40 s after a change of leg.
    pub cross_track_settled_m: Option<Spread>,
    /// The same, more than 10 m from every waypoint.
    pub cross_track_straight_m: Option<Spread>,
    /// Distance to the smoothed path that the controller was given.
    pub path_error_m: Option<Spread>,
    /// The same, where that path is straight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path_error_straight_m: Option<Spread>,
    /// How far the flight controller's position is from the boat's own, waves included, across the path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub navigation_error_m: Option<Spread>,
    /// Root mean square of the difference between the speed over ground and the speed wanted, m/s.
    pub speed_error_mps: SpeedError,
    /// Total variation of the steering command (−1…1) per minute.
    pub steering_variation_per_min: f64,
    /// Mean of the squared throttle and steering commands, 0…2.
    pub effort: f64,
}

/// Speed error over the samples of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpeedError {
    /// Root mean square, m/s.
    pub rms: f64,
}

/// One instant of a run, after the first waypoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Simulated time.
    pub time_s: f64,
    /// True position of the hull, wave motion left out.
    pub position: NorthEast,
    /// True speed over ground.
    pub speed_mps: f64,
    /// Index of the leg that is being driven: leg i leads from waypoint i to waypoint i + 1.
    pub leg: usize,
    /// Distance to the smoothed path.
    pub path_error_m: f64,
    /// That path is known to be straight here.
    pub path_is_straight: bool,
    /// Distance across the path from the boat, its wave motion included, to where the flight controller has it; known
    /// in simulation only.
    pub navigation_error_m: Option<f64>,
    /// The speed that the mission wants here.
    pub wanted_speed_mps: f64,
    /// The steering command in force, −1…1.
    pub steering: f64,
    /// The throttle command in force, −1…1.
    pub throttle: f64,
}

/// Collects samples and makes the figures.
#[derive(Debug, Clone)]
pub struct Scorer {
    waypoints: Vec<NorthEast>,
    leg_since: Option<(usize, f64)>,
    first: Option<Sample>,
    last: Option<Sample>,
    distance_m: f64,
    steering_variation: f64,
    squared_effort: f64,
    squared_speed_error: f64,
    whole: Errors,
    settled: Errors,
    straight: Errors,
    path: Errors,
    path_straight: Errors,
    navigation: Errors,
}

impl Scorer {
    /// A scorer for a mission over these waypoints.
    pub fn new(waypoints: Vec<NorthEast>) -> Self {
        Self {
            waypoints,
            leg_since: None,
            first: None,
            last: None,
            distance_m: 0.0,
            steering_variation: 0.0,
            squared_effort: 0.0,
            squared_speed_error: 0.0,
            whole: Errors::default(),
            settled: Errors::default(),
            straight: Errors::default(),
            path: Errors::default(),
            path_straight: Errors::default(),
            navigation: Errors::default(),
        }
    }

    /// Takes one sample; samples come at even intervals.
    pub fn on_sample(&mut self, sample: Sample) {
        let error_m = self.cross_track_m(sample.position, sample.leg);
        self.whole.push(error_m);
        if self.seconds_on_leg(&sample) > SETTLED_AFTER_S {
            self.settled.push(error_m);
        }
        let is_beyond = |waypoint: &NorthEast| {
            let way = *waypoint - sample.position;
            way.dot(way) > STRAIGHT_BEYOND_M * STRAIGHT_BEYOND_M
        };
        if self.waypoints.iter().all(is_beyond) {
            self.straight.push(error_m);
        }
        self.path.push(sample.path_error_m);
        if sample.path_is_straight {
            self.path_straight.push(sample.path_error_m);
        }
        if let Some(error_m) = sample.navigation_error_m {
            self.navigation.push(error_m);
        }
        self.squared_effort += sample.throttle.powi(2) + sample.steering.powi(2);
        self.squared_speed_error += (sample.speed_mps - sample.wanted_speed_mps).powi(2);
        if let Some(last) = self.last {
            self.distance_m += (sample.position - last.position).norm();
            self.steering_variation += (sample.steering - last.steering).abs();
        }
        self.first.get_or_insert(sample);
        self.last = Some(sample);
    }

    /// The figures so far.
    pub fn score(&self) -> Score {
        let duration_s = match (self.first, self.last) {
            (Some(first), Some(last)) => last.time_s - first.time_s,
            _ => 0.0,
        };
        let samples = self.whole.count.max(1) as f64;
        Score {
            duration_s,
            distance_m: self.distance_m,
            cross_track_m: self.whole.spread(),
            cross_track_settled_m: self.settled.spread(),
            cross_track_straight_m: self.straight.spread(),
            path_error_m: self.path.spread(),
            path_error_straight_m: self.path_straight.spread(),
            navigation_error_m: self.navigation.spread(),
            speed_error_mps: SpeedError { rms: (self.squared_speed_error / samples).sqrt() },
            steering_variation_per_min: self.steering_variation / (duration_s / 60.0).max(1.0 / 60.0),
            effort: self.squared_effort / samples,
        }
    }

    /// Distance to the nearest point of the active leg or its neighbours.
    fn cross_track_m(&self, position: NorthEast, leg: usize) -> f64 {
        let nearest = self
            .waypoints
            .windows(2)
            .enumerate()
            .filter(|(index, _)| index.abs_diff(leg) <= 1)
            .map(|(_, ends)| distance_to_segment_m(position, ends[0], ends[1]))
            .fold(f64::INFINITY, f64::min);
        match (nearest.is_finite(), self.waypoints.first()) {
            (true, _) => nearest,
            (false, Some(only)) => (*only - position).norm(),
            (false, None) => 0.0,
        }
    }

    fn seconds_on_leg(&mut self, sample: &Sample) -> f64 {
        match self.leg_since {
            Some((leg, since_s)) if leg == sample.leg => sample.time_s - since_s,
            _ => {
                self.leg_since = Some((sample.leg, sample.time_s));
                0.0
            }
        }
    }
}

/// Distance from a point to a straight segment.
pub fn distance_to_segment_m(point: NorthEast, from: NorthEast, to: NorthEast) -> f64 {
    let along = to - from;
    let length_squared = along.dot(along);
    if length_squared == 0.0 {
        return (point - from).norm();
    }
    let share = ((point - from).dot(along) / length_squared).clamp(0.0, 1.0);
    (point - (from + along * share)).norm()
}

/// Absolute errors. Of more than [`MOST_ERRORS`] the percentile is that of a fair sample; the other figures are of all.
#[derive(Debug, Clone)]
struct Errors {
    kept: Sampled<f64>,
    count: u64,
    sum: f64,
    squares: f64,
    max: f64,
}

impl Default for Errors {
    fn default() -> Self {
        Self { kept: Sampled::new(MOST_ERRORS), count: 0, sum: 0.0, squares: 0.0, max: 0.0 }
    }
}

impl Errors {
    fn push(&mut self, error: f64) {
        self.kept.push(self.count, error);
        self.count += 1;
        self.sum += error;
        self.squares += error * error;
        self.max = self.max.max(error);
    }

    fn spread(&self) -> Option<Spread> {
        let mut sorted: Vec<f64> = self.kept.iter().copied().collect();
        if sorted.is_empty() {
            return None;
        }
        let rank = (0.95 * sorted.len() as f64).ceil() as usize;
        let rank = rank.clamp(1, sorted.len()) - 1;
        let (_, p95, _) = sorted.select_nth_unstable_by(rank, f64::total_cmp);
        let count = self.count as f64;
        Some(Spread { rms: (self.squares / count).sqrt(), mean: self.sum / count, p95: *p95, max: self.max })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(north_m: f64, east_m: f64) -> NorthEast {
        NorthEast { north_m, east_m }
    }

    fn sample(time_s: f64, position: NorthEast, leg: usize, steering: f64) -> Sample {
        Sample {
            time_s,
            position,
            speed_mps: 1.0,
            leg,
            path_error_m: 0.0,
            path_is_straight: true,
            navigation_error_m: None,
            wanted_speed_mps: 1.5,
            steering,
            throttle: 0.5,
        }
    }

    #[test]
    fn figures_of_a_known_run() {
        let mut scorer = Scorer::new(vec![at(0.0, 0.0), at(100.0, 0.0), at(100.0, 100.0)]);
        for second in 0..=100 {
            let steering = if second % 2 == 0 { 0.1 } else { -0.1 };
            scorer.on_sample(sample(f64::from(second), at(f64::from(second), 2.0), 0, steering));
        }
        let score = scorer.score();
        let whole = score.cross_track_m.unwrap();
        // Near the corner the second leg is nearer than the first.
        assert!((whole.max - 2.0).abs() < 1e-12 && whole.rms < 2.0 && whole.rms > 1.9);
        assert_eq!(score.cross_track_settled_m.unwrap().p95, 2.0);
        assert!((score.distance_m - 100.0).abs() < 1e-9);
        assert!((score.steering_variation_per_min - 0.2 * 60.0).abs() < 1e-9);
        assert!((score.speed_error_mps.rms - 0.5).abs() < 1e-12);
        assert!((score.effort - 0.26).abs() < 1e-12);
    }

    #[test]
    fn the_percentile_of_a_long_run_is_that_of_a_part_and_the_rest_is_of_all() {
        let mut errors = Errors::default();
        let count = 3 * MOST_ERRORS;
        (0..count).for_each(|number| errors.push(((number * 7919) % 1000) as f64));
        assert!(errors.kept.iter().count() <= MOST_ERRORS);
        let spread = errors.spread().unwrap();
        assert!((spread.mean - 499.5).abs() < 0.01 && spread.max == 999.0, "{spread:?}");
        assert!((spread.p95 - 949.0).abs() <= 2.0, "{spread:?}");
    }

    #[test]
    fn a_change_of_leg_unsettles() {
        let mut scorer = Scorer::new(vec![at(0.0, 0.0), at(100.0, 0.0), at(100.0, 100.0)]);
        for second in 0..60 {
            scorer.on_sample(sample(f64::from(second), at(50.0, 1.0), usize::from(second >= 30), 0.0));
        }
        assert!(scorer.score().cross_track_settled_m.is_none());
    }

    #[test]
    fn only_the_active_leg_and_its_neighbours_count() {
        let points = vec![at(0.0, 0.0), at(100.0, 0.0), at(100.0, 10.0), at(0.0, 10.0)];
        let scorer = Scorer::new(points);
        assert!((scorer.cross_track_m(at(50.0, 9.0), 0) - 9.0).abs() < 1e-12);
        assert!((scorer.cross_track_m(at(50.0, 9.0), 1) - 1.0).abs() < 1e-12);
    }
}
