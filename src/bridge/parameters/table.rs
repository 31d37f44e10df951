//! Every parameter of the bridge, written once.

use super::store::Tunables;
use crate::control::axis::AxisSettings;
use crate::pilot::failsafe::{Action, Failsafe, Rule};

/// Where a parameter's value lives.
#[derive(Debug, Clone, Copy)]
pub(super) enum Place {
    /// A gain or a limit of the boat, by its key in the boat file.
    Gain(&'static str, fn(&mut Tunables) -> &mut f64),
    /// The speed over ground where the mission does not say; 0 leaves it to the vehicle.
    Speed,
    /// The limit of a failsafe.
    Limit(Failsafe),
    /// The action of a failsafe, as its number.
    Action(Failsafe),
}

/// One parameter.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// At most 16 characters.
    pub name: &'static str,
    /// Unit, for people.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
    pub(super) place: Place,
}

fn surge(tunables: &mut Tunables) -> &mut AxisSettings {
    &mut tunables.boat.control.surge
}

fn yaw(tunables: &mut Tunables) -> &mut AxisSettings {
    &mut tunables.boat.control.yaw
}

macro_rules! table {
    ($(gain $gain:literal at $key:literal: $gain_unit:literal $gain_meaning:literal = $get:expr;)*
     $(speed $speed:literal $speed_unit:literal $speed_meaning:literal;)*
     $(failsafe $limit:literal $action:literal = $failsafe:ident;)*
     $(choice $choice:literal = $choosable:ident;)*) => {
        /// Every parameter, in the order of their numbers.
        pub const PARAMETERS: &[Parameter] = &[
            $(Parameter { name: $gain, unit: $gain_unit, meaning: $gain_meaning, place: Place::Gain($key, $get) },)*
            $(Parameter { name: $speed, unit: $speed_unit, meaning: $speed_meaning, place: Place::Speed },)*
            $(Parameter {
                name: $limit,
                unit: crate::pilot::failsafe::DEFINITIONS[Failsafe::$failsafe as usize].unit,
                meaning: crate::pilot::failsafe::DEFINITIONS[Failsafe::$failsafe as usize].watches,
                place: Place::Limit(Failsafe::$failsafe),
            },
            Parameter {
                name: $action,
                unit: ACTIONS,
                meaning: crate::pilot::failsafe::DEFINITIONS[Failsafe::$failsafe as usize].watches,
                place: Place::Action(Failsafe::$failsafe),
            },)*
            $(Parameter {
                name: $choice,
                unit: ACTIONS,
                meaning: crate::pilot::failsafe::DEFINITIONS[Failsafe::$choosable as usize].watches,
                place: Place::Action(Failsafe::$choosable),
            },)*
        ];
    };
}

/// The numbers of the actions.
const ACTIONS: &str = "0 warn, 1 return-to-launch, 2 hold-position, 3 neutral-and-release, 4 let-go";

table! {
    gain "HL_PSI_K" at "control.heading_gain": "1/s" "heading gain k_psi" = |t| &mut t.boat.control.heading_gain;
    gain "HL_U_FILT" at "control.surge.filter_s": "s" "surge: command filter T" = |t| &mut surge(t).filter_s;
    gain "HL_U_K" at "control.surge.reaching_gain": "1/s" "surge: reaching gain k" = |t| &mut surge(t).reaching_gain;
    gain "HL_U_LAMBDA" at "control.surge.integral_slope": "1/s" "surge: integral slope lambda" = |t| &mut surge(t).integral_slope;
    gain "HL_U_PHI" at "control.surge.boundary": "m/s" "surge: boundary layer Phi" = |t| &mut surge(t).boundary;
    gain "HL_U_DMAX" at "control.surge.disturbance_max": "m/s2" "surge: largest disturbance bound" = |t| &mut surge(t).disturbance_max;
    gain "HL_U_DRATE" at "control.surge.disturbance_rate": "1/s" "surge: adaptation rate of the disturbance bound" = |t| &mut surge(t).disturbance_rate;
    gain "HL_U_PRATE" at "control.surge.parameter_rate": "" "surge: adaptation rate of the parameters" = |t| &mut surge(t).parameter_rate;
    gain "HL_U_DZ" at "control.surge.dead_zone": "m/s" "surge: no adaptation below this S" = |t| &mut surge(t).dead_zone;
    gain "HL_R_FILT" at "control.yaw.filter_s": "s" "yaw: command filter T" = |t| &mut yaw(t).filter_s;
    gain "HL_R_K" at "control.yaw.reaching_gain": "1/s" "yaw: reaching gain k" = |t| &mut yaw(t).reaching_gain;
    gain "HL_R_LAMBDA" at "control.yaw.integral_slope": "1/s" "yaw: integral slope lambda" = |t| &mut yaw(t).integral_slope;
    gain "HL_R_PHI" at "control.yaw.boundary": "rad/s" "yaw: boundary layer Phi" = |t| &mut yaw(t).boundary;
    gain "HL_R_DMAX" at "control.yaw.disturbance_max": "rad/s2" "yaw: largest disturbance bound" = |t| &mut yaw(t).disturbance_max;
    gain "HL_R_DRATE" at "control.yaw.disturbance_rate": "1/s" "yaw: adaptation rate of the disturbance bound" = |t| &mut yaw(t).disturbance_rate;
    gain "HL_R_PRATE" at "control.yaw.parameter_rate": "" "yaw: adaptation rate of the parameters" = |t| &mut yaw(t).parameter_rate;
    gain "HL_R_DZ" at "control.yaw.dead_zone": "rad/s" "yaw: no adaptation below this S" = |t| &mut yaw(t).dead_zone;
    gain "HL_G_LEAD" at "guidance.lead_m": "m" "guidance: look-ahead at low speed" = |t| &mut t.boat.guidance.lead_m;
    gain "HL_G_LEADT" at "guidance.lead_time_s": "s" "guidance: look-ahead per speed" = |t| &mut t.boat.guidance.lead_time_s;
    gain "HL_G_SOFT" at "guidance.lead_softness_m": "m" "guidance: lead error that stops the virtual ship" = |t| &mut t.boat.guidance.lead_softness_m;
    gain "HL_G_DRIFT" at "guidance.drift_time_s": "s" "guidance: time constant of the drift estimate" = |t| &mut t.boat.guidance.drift_time_s;
    gain "HL_G_PREV" at "guidance.preview_s": "s" "guidance: how far ahead the path's curvature is read" = |t| &mut t.boat.guidance.preview_s;
    gain "HL_G_SPREV" at "guidance.speed_preview_s": "s" "guidance: how far ahead the speed is read" = |t| &mut t.boat.guidance.speed_preview_s;
    gain "HL_G_CREEP" at "guidance.creep_mps": "m/s" "guidance: least speed of the final approach" = |t| &mut t.boat.guidance.creep_mps;
    gain "HL_L_TURN" at "limits.turn_radius_m": "m" "radius of the path's corners, from the next stretch on" = |t| &mut t.boat.limits.turn_radius_m;
    gain "HL_L_VMAX" at "limits.speed_max_mps": "m/s" "largest speed through the water" = |t| &mut t.boat.limits.speed_max_mps;
    gain "HL_L_STEER" at "limits.steerage_mps": "m/s" "least speed through the water for steering" = |t| &mut t.boat.limits.steerage_mps;
    gain "HL_L_RMAX" at "limits.yaw_rate_max_radps": "rad/s" "largest yaw rate asked for" = |t| &mut t.boat.limits.yaw_rate_max_radps;
    gain "HL_L_RTURN" at "limits.turn_rate_radps": "rad/s" "yaw rate planned for a turn" = |t| &mut t.boat.limits.turn_rate_radps;
    gain "HL_L_ALAT" at "limits.lateral_acceleration_mps2": "m/s2" "lateral acceleration planned for a turn" = |t| &mut t.boat.limits.lateral_acceleration_mps2;
    gain "HL_L_DECEL" at "limits.deceleration_mps2": "m/s2" "deceleration planned before a turn or a stop" = |t| &mut t.boat.limits.deceleration_mps2;
    speed "HL_SPEED" "m/s" "speed over ground on legs for which the mission gives none; 0: as started";
    failsafe "HL_FS_POS" "HL_FSA_POS" = PositionAge;
    failsafe "HL_FS_HDG" "HL_FSA_HDG" = HeadingAge;
    failsafe "HL_FS_EKF" "HL_FSA_EKF" = Estimator;
    failsafe "HL_FS_NAN" "HL_FSA_NAN" = NotANumber;
    failsafe "HL_FS_JUMP" "HL_FSA_JUMP" = PositionJump;
    failsafe "HL_FS_FENCE" "HL_FSA_FENCE" = Fence;
    failsafe "HL_FS_XTRACK" "HL_FSA_XTRACK" = CrossTrack;
    failsafe "HL_FS_GCS" "HL_FSA_GCS" = GroundStation;
    failsafe "HL_FS_BATT" "HL_FSA_BATT" = Battery;
    failsafe "HL_FS_PROG" "HL_FSA_PROG" = NoProgress;
    failsafe "HL_FS_SAT" "HL_FSA_SAT" = Saturated;
    failsafe "HL_FS_LATE" "HL_FSA_LATE" = LoopLate;
    choice "HL_FSA_REC" = Recording;
    choice "HL_FSA_OUT" = OutputRefused;
}

impl Parameter {
    /// Least and largest value that can be set while the others are as in `tunables`.
    pub fn range(&self, tunables: &Tunables) -> (f64, f64) {
        match self.place {
            Place::Gain(key, _) => tunables.boat.range(key).unwrap_or((f64::MIN, f64::MAX)),
            Place::Speed => (0.0, tunables.boat.limits.speed_max_mps),
            Place::Limit(failsafe) => failsafe.definition().range,
            Place::Action(_) => (0.0, (Action::ALL.len() - 1) as f64),
        }
    }
}

impl Place {
    pub(super) fn get(&self, tunables: &mut Tunables) -> f64 {
        match self {
            Self::Gain(_, gain) => *gain(tunables),
            Self::Speed => tunables.speed_mps,
            Self::Limit(failsafe) => tunables.failsafes.limit(*failsafe),
            Self::Action(failsafe) => {
                let action = tunables.failsafes.action(*failsafe);
                Action::ALL.iter().position(|known| *known == action).unwrap_or_default() as f64
            }
        }
    }

    /// Puts a value in; the whole is checked afterwards. False for a number that stands for nothing.
    pub(super) fn put(&self, tunables: &mut Tunables, value: f64) -> bool {
        match self {
            Self::Gain(_, gain) => *gain(tunables) = value,
            Self::Speed => tunables.speed_mps = value,
            Self::Limit(failsafe) => tunables.failsafes.rule_mut(*failsafe).limit = Some(value),
            Self::Action(failsafe) => {
                let known = Action::ALL.iter().enumerate().find(|(number, _)| *number as f64 == value);
                let Some((_, action)) = known else { return false };
                let limit = tunables.failsafes.rule(*failsafe).limit;
                *tunables.failsafes.rule_mut(*failsafe) = Rule { limit, action: Some(*action) };
            }
        }
        true
    }
}
