//! The figures of a replay.

use serde::Serialize;

use crate::simulation::score::Score;

/// How the controller's commands compare with what was put out, over the samples in which both are known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Comparison {
    /// Samples, ten per vehicle second.
    pub samples: u64,
    /// Root mean square of the difference in steering, −1…1 each.
    pub steering_rms: f64,
    /// Root mean square of the difference in throttle.
    pub throttle_rms: f64,
    /// Correlation of the two steerings, −1…1; none where one of them never moved.
    pub steering_correlation: Option<f64>,
}

/// What a log has shown.
#[derive(Debug, Clone, Default, Serialize)]
pub struct WhatIfResult {
    /// Control steps made.
    pub steps: u64,
    /// Vehicle time in the log, seconds.
    pub vehicle_s: f64,
    /// Vehicle time in which the controller was asked, seconds.
    pub driven_s: f64,
    /// Waypoints of the mission.
    pub waypoints: usize,
    /// MISSION_ITEM_REACHED messages in the log.
    pub reached_recorded: u64,
    /// Waypoints passed by the controller's count.
    pub reached_replayed: u64,
    /// Frames that steer.
    pub commands: u64,
    /// SHA-256 of them.
    pub commands_sha256: String,
    /// What was driven, with the outputs that were recorded.
    pub recorded: Option<Score>,
    /// What was driven, with the commands of the controller.
    pub replayed: Option<Score>,
    /// The two commands compared.
    pub difference: Option<Comparison>,
}
