//! The gains of all baselines of a boat.
//!
//! Each starts from a rule, the same for every boat: a heading loop of its own frequency, a look-ahead of the
//! boat's own lead. What tuning found for a boat stands in its gains file (`src/control/gains/`).

use serde::{Deserialize, Serialize};

use super::pid::{HeadingPidSettings, SpeedPiSettings};
use super::sign_smc::SignAxisSettings;
use crate::control::axis::AxisSettings;
use crate::control::boat::ControlSettings;
use crate::guidance::GuidanceSettings;
use crate::guidance::line_of_sight::{LineOfSightKind, LineOfSightSettings};

/// Gains of every baseline.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Baselines {
    /// PI sliding mode in the paper's guidance.
    pub pi_smc_paper: PaperGains,
    /// PID in the practical guidance.
    pub pid: PidGains,
    /// Integral line of sight.
    pub ilos_pid: LosPidGains,
    /// Adaptive line of sight.
    pub alos_pid: LosPidGains,
    /// Sign function in the practical guidance.
    pub sign_smc: SignGains,
}

/// Gains of `pi-smc-paper`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PaperGains {
    /// Guidance; the lead is the paper's δ.
    pub guidance: GuidanceSettings,
    /// The law.
    pub control: ControlSettings,
}

/// Gains of `pid`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PidGains {
    /// Guidance.
    pub guidance: GuidanceSettings,
    /// Heading.
    pub heading: HeadingPidSettings,
    /// Speed.
    pub speed: SpeedPiSettings,
}

/// Gains of `ilos-pid` and `alos-pid`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LosPidGains {
    /// Guidance.
    pub los: LineOfSightSettings,
    /// Heading.
    pub heading: HeadingPidSettings,
    /// Speed.
    pub speed: SpeedPiSettings,
}

/// Gains of `sign-smc`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SignGains {
    /// Guidance.
    pub guidance: GuidanceSettings,
    /// Heading gain k_ψ, 1/s.
    pub heading_gain: f64,
    /// Surge.
    pub surge: SignAxisSettings,
    /// Yaw.
    pub yaw: SignAxisSettings,
}

impl Baselines {
    /// Baselines that match the gains of the boat's own controller: the same look-ahead, filters and bandwidth.
    #[must_use]
    pub fn matching(guidance: &GuidanceSettings, control: &ControlSettings) -> Self {
        // The yaw loop of the sliding mode has poles near k_ψ and λ + k_ψ: a PID of the same speed.
        let frequency = (control.heading_gain * control.yaw.reaching_gain).sqrt();
        let heading = HeadingPidSettings {
            frequency_radps: frequency,
            damping_ratio: 1.0,
            integral_share: 0.1,
            filter_s: control.yaw.filter_s,
            acceleration_max_radps2: control.yaw.acceleration_max,
        };
        let speed = SpeedPiSettings { bandwidth_radps: control.surge.reaching_gain, integral_share: 0.25 };
        let line_of_sight = |kind, adaptation| LosPidGains {
            los: LineOfSightSettings {
                kind,
                look_ahead_m: guidance.lead_m,
                look_ahead_s: guidance.lead_time_s,
                adaptation,
                reference_radps: frequency,
                creep_mps: guidance.creep_mps,
            },
            heading: heading.clone(),
            speed: speed.clone(),
        };
        Self {
            pi_smc_paper: PaperGains { guidance: guidance.clone(), control: control.clone() },
            pid: PidGains { guidance: guidance.clone(), heading: heading.clone(), speed: speed.clone() },
            // Fossen's choices for the Otter, made independent of its look-ahead of 5 m.
            ilos_pid: line_of_sight(LineOfSightKind::Integral, 0.1),
            alos_pid: line_of_sight(LineOfSightKind::Adaptive, 0.1),
            sign_smc: SignGains {
                guidance: guidance.clone(),
                heading_gain: control.heading_gain,
                surge: sign_axis(&control.surge),
                yaw: sign_axis(&control.yaw),
            },
        }
    }
}

fn sign_axis(axis: &AxisSettings) -> SignAxisSettings {
    SignAxisSettings {
        filter_s: axis.filter_s,
        acceleration_max: axis.acceleration_max,
        reaching_gain: axis.reaching_gain,
        switching_gain: axis.disturbance_max,
    }
}
