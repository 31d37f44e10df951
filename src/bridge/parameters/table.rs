//! Every parameter of the bridge, written once.

use super::store::Tunables;
use crate::control::axis::AxisSettings;
use crate::pilot::failsafe::{Action, Failsafe, Rule};

/// Where a parameter's value lives.
#[derive(Debug, Clone, Copy)]
pub(super) enum Place {
    /// A gain of the controller.
    Gain(fn(&mut Tunables) -> &mut f64),
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
    ($(gain $gain:literal $gain_unit:literal $gain_meaning:literal = $get:expr;)*
     $(speed $speed:literal $speed_unit:literal $speed_meaning:literal;)*
     $(failsafe $limit:literal $action:literal = $failsafe:ident;)*
     $(choice $choice:literal = $choosable:ident;)*) => {
        /// Every parameter, in the order of their numbers.
        pub const PARAMETERS: &[Parameter] = &[
            $(Parameter { name: $gain, unit: $gain_unit, meaning: $gain_meaning, place: Place::Gain($get) },)*
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
    gain "HL_PSI_K" "1/s" "heading gain k_psi" = |t| &mut t.boat.control.heading_gain;
    gain "HL_U_FILT" "s" "surge: command filter T" = |t| &mut surge(t).filter_s;
    gain "HL_U_K" "1/s" "surge: reaching gain k" = |t| &mut surge(t).reaching_gain;
    gain "HL_U_LAMBDA" "1/s" "surge: integral slope lambda" = |t| &mut surge(t).integral_slope;
    gain "HL_U_PHI" "m/s" "surge: boundary layer Phi" = |t| &mut surge(t).boundary;
    gain "HL_U_DMAX" "m/s2" "surge: largest disturbance bound" = |t| &mut surge(t).disturbance_max;
    gain "HL_U_DRATE" "1/s" "surge: adaptation rate of the disturbance bound" = |t| &mut surge(t).disturbance_rate;
    gain "HL_U_PRATE" "" "surge: adaptation rate of the parameters" = |t| &mut surge(t).parameter_rate;
    gain "HL_U_DZ" "m/s" "surge: no adaptation below this S" = |t| &mut surge(t).dead_zone;
    gain "HL_R_FILT" "s" "yaw: command filter T" = |t| &mut yaw(t).filter_s;
    gain "HL_R_K" "1/s" "yaw: reaching gain k" = |t| &mut yaw(t).reaching_gain;
    gain "HL_R_LAMBDA" "1/s" "yaw: integral slope lambda" = |t| &mut yaw(t).integral_slope;
    gain "HL_R_PHI" "rad/s" "yaw: boundary layer Phi" = |t| &mut yaw(t).boundary;
    gain "HL_R_DMAX" "rad/s2" "yaw: largest disturbance bound" = |t| &mut yaw(t).disturbance_max;
    gain "HL_R_DRATE" "1/s" "yaw: adaptation rate of the disturbance bound" = |t| &mut yaw(t).disturbance_rate;
    gain "HL_R_PRATE" "" "yaw: adaptation rate of the parameters" = |t| &mut yaw(t).parameter_rate;
    gain "HL_R_DZ" "rad/s" "yaw: no adaptation below this S" = |t| &mut yaw(t).dead_zone;
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

impl Place {
    pub(super) fn get(&self, tunables: &mut Tunables) -> f64 {
        match self {
            Self::Gain(gain) => *gain(tunables),
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
            Self::Gain(gain) => *gain(tunables) = value,
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
