//! A sea trial: how a hull answers throttle and steering in calm water.
//!
//! A real boat is tuned the same way before its first mission. The autopilot's gains follow from the answers,
//! so that any hull, built in or from a file, is under control without tuning by hand.

use crate::physics::{ActuatorCommand, Hull, Pose, Sea, SensorSettings, Vessel};

/// Step of the trial, s.
const STEP_S: f64 = 0.02;
/// A run ends when nothing has changed by more than this share over [`SETTLED_S`].
const SETTLED_SHARE: f64 = 0.002;
/// See [`SETTLED_SHARE`], s.
const SETTLED_S: f64 = 2.0;
/// Longest run, s.
const LONGEST_RUN_S: f64 = 400.0;
/// Steering tried, as a share of full.
const STEERING: f64 = 0.2;
/// Throttle of the first run.
const FIRST_THROTTLE: f64 = 0.5;
/// Runs to find the cruise throttle.
const SPEED_RUNS: u32 = 5;
/// Speed grows with a power of the throttle between 1 (quadratic drag) and 2 (linear drag). With this
/// exponent each run takes at least 60 % off the error in either case.
const SPEED_EXPONENT: f64 = 0.7;

/// What the trial found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Trial {
    /// The hull's comfortable speed, m/s.
    pub(crate) cruise_speed_mps: f64,
    /// The throttle that makes it, (0, 1].
    pub(crate) cruise_throttle: f64,
    /// Time to 63 % of the speed from rest, s.
    pub(crate) speed_time_s: f64,
    /// Turn rate per full steering at cruise speed, rad/s.
    pub(crate) turn_gain_radps: f64,
    /// Time to 63 % of the turn rate, s.
    pub(crate) turn_time_s: f64,
    /// The hull's length, m.
    pub(crate) length_m: f64,
}

/// Tries a hull.
pub(crate) fn run(hull: &Hull) -> Trial {
    let cruise_speed_mps = hull.cruise_speed_mps;
    let mut cruise_throttle = FIRST_THROTTLE;
    let mut vessel =
        Vessel::new(hull.clone(), &Sea::default(), &SensorSettings::perfect(), 0, Pose::default());
    let mut speed_time_s = 1.0;
    for attempt in 0..SPEED_RUNS {
        let (speed_mps, time_s) = answer(&mut vessel, cruise_throttle, 0.0, |vessel| vessel.truth().u_r_mps);
        if attempt == 0 {
            speed_time_s = time_s;
        }
        if speed_mps > 0.01 {
            let share = (cruise_speed_mps / speed_mps).powf(SPEED_EXPONENT);
            cruise_throttle = (cruise_throttle * share).clamp(0.02, 1.0);
        }
    }
    let (turn_radps, turn_time_s) =
        answer(&mut vessel, cruise_throttle, STEERING, |vessel| vessel.truth().hull.r_radps);
    Trial {
        cruise_speed_mps,
        cruise_throttle,
        speed_time_s: speed_time_s.max(0.2),
        turn_gain_radps: (turn_radps / STEERING).max(1e-3),
        turn_time_s: turn_time_s.max(0.05),
        length_m: hull.length_m,
    }
}

/// Holds a command until the measured quantity has settled; its value then, and the time to 63 % of the way.
fn answer(vessel: &mut Vessel, throttle: f64, steering: f64, measure: fn(&Vessel) -> f64) -> (f64, f64) {
    let mut values = vec![measure(vessel)];
    let window = (SETTLED_S / STEP_S) as usize;
    let command = ActuatorCommand::ThrottleSteering { throttle, steering };
    while values.len() < (LONGEST_RUN_S / STEP_S) as usize {
        vessel.step(STEP_S, command);
        values.push(measure(vessel));
        let now = values.len() - 1;
        let long_enough = now > 2 * window;
        if long_enough && (values[now] - values[now - window]).abs() < SETTLED_SHARE * values[now].abs() {
            break;
        }
    }
    let first = values.first().copied().unwrap_or_default();
    let last = values.last().copied().unwrap_or_default();
    let share = 1.0 - (-1.0_f64).exp();
    let reached = |value: &f64| (value - first).abs() >= share * (last - first).abs();
    let steps = values.iter().position(reached).unwrap_or(0);
    (last, steps as f64 * STEP_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_hull_makes_its_cruise_speed_and_turns() {
        for name in Hull::names() {
            let hull = Hull::builtin(name).unwrap();
            let trial = run(&hull);
            assert!((0.05..=1.0).contains(&trial.cruise_throttle), "{name}");
            let mut vessel =
                Vessel::new(hull, &Sea::default(), &SensorSettings::perfect(), 0, Pose::default());
            for _ in 0..20_000 {
                let throttle = trial.cruise_throttle;
                vessel.step(STEP_S, ActuatorCommand::ThrottleSteering { throttle, steering: 0.0 });
            }
            let share = vessel.truth().u_r_mps / trial.cruise_speed_mps;
            assert!((0.95..1.05).contains(&share), "{name}: {share} of the cruise speed, {trial:?}");
            assert!(trial.turn_gain_radps > 0.01, "{name}");
        }
    }
}
