//! Hulls as data: masses, damping, propulsion, windage and response to waves.
//!
//! A hull is a TOML file (see `hulls/`); the ones that come with Helmlink are built in. [`Hull::from_toml`]
//! reads another one and refuses what cannot float.

use super::{hull_check, hull_file};
use crate::toml_place::in_words;

/// One boat, validated. All quantities SI, about an origin amidships on the centre line, body axes
/// x forward, y to starboard, yaw positive to starboard.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    /// Short name as used on the command line.
    pub name: String,
    /// One line for lists and reports.
    pub summary: String,
    /// Length, m. Sea states are scaled with it.
    pub length_m: f64,
    /// Beam, m.
    pub beam_m: f64,
    /// A comfortable speed through the water, m/s.
    pub cruise_speed_mps: f64,
    /// How the hull moves.
    pub dynamics: HullDynamics,
    /// Windage; `None` when the wind has no hold on the boat.
    pub wind: Option<WindLoads>,
    /// Motion in waves; `None` when waves do not move the boat.
    pub waves: Option<WaveResponse>,
    /// Size under water; `None` when the bottom does not slow the boat.
    pub shallow_water: Option<ShallowWater>,
}

/// The two kinds of boat the simulator knows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HullDynamics {
    /// Surge, sway and yaw with added mass, damping and an actuator model (Fossen 2021, ch. 6).
    Maneuvering(Maneuvering, Propulsion),
    /// The kinematic motor boat of ArduPilot's simulator.
    Motorboat(Motorboat),
}

/// Inertia and damping of the three-degree-of-freedom model `M ν̇ + C(ν)ν + D(ν)ν = τ`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Maneuvering {
    /// Mass plus added mass in surge, kg.
    pub m11_kg: f64,
    /// Mass plus added mass in sway, kg.
    pub m22_kg: f64,
    /// Sway–yaw coupling, kg·m (mass times x_g when added mass is diagonal).
    pub m23_kgm: f64,
    /// Moment of inertia plus added inertia in yaw, kg·m².
    pub m33_kgm2: f64,
    /// Surge drag, N per (m/s), (m/s)², (m/s)³.
    pub surge: Damping,
    /// Sway drag, N per (m/s), (m/s)², (m/s)³.
    pub sway: Damping,
    /// Yaw drag, N·m per (rad/s), (rad/s)², (rad/s)³.
    pub yaw: Damping,
    /// Cross-flow drag over the length, if modelled apart from the above.
    pub cross_flow: Option<CrossFlow>,
}

/// Drag `linear·x + quadratic·|x|x + cubic·x³`, every coefficient ≥ 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Damping {
    /// Coefficient of x.
    pub linear: f64,
    /// Coefficient of |x|·x.
    pub quadratic: f64,
    /// Coefficient of x³.
    pub cubic: f64,
}

impl Damping {
    /// The resisting force (or moment) at velocity `x`, with the sign of `x`.
    #[inline]
    pub fn force(&self, x: f64) -> f64 {
        (self.linear + self.quadratic * x.abs() + self.cubic * x * x) * x
    }
}

/// Strip theory for the cross flow (Fossen 2021, §6.4.4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossFlow {
    /// Length over which the strips lie, m, centred amidships.
    pub length_m: f64,
    /// Force per metre of hull and squared cross-flow speed, ½·ρ·T·C_d, N/m/(m/s)².
    pub strip_n_per_m_mps2: f64,
}

/// What drives and steers the boat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Propulsion {
    /// Two fixed propellers side by side; steering by difference.
    TwinThrusters(TwinThrusters),
    /// One propeller ahead of a rudder.
    PropellerRudder(SteeredDrive),
    /// One propeller that turns with its leg.
    Outboard(SteeredDrive),
}

/// Two fixed propellers with thrust `k·n·|n|` each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwinThrusters {
    /// Centre line to propeller, m.
    pub arm_m: f64,
    /// k ahead, N/(rad/s)².
    pub ahead_n_per_radps2: f64,
    /// k astern, N/(rad/s)².
    pub astern_n_per_radps2: f64,
    /// Largest thrust ahead of one propeller, N.
    pub ahead_limit_n: f64,
    /// Largest thrust astern of one propeller, N (positive number).
    pub astern_limit_n: f64,
    /// Time constant of the shaft speed, s.
    pub lag_s: f64,
}

/// One propeller and one steered foil: a rudder, or the leg of an outboard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteeredDrive {
    /// Largest thrust ahead, N.
    pub ahead_limit_n: f64,
    /// Largest thrust astern, N (positive number).
    pub astern_limit_n: f64,
    /// Time constant of the revolutions, s.
    pub throttle_lag_s: f64,
    /// Midship aft to the foil (and the outboard's propeller), m.
    pub arm_m: f64,
    /// ½·ρ·A·f_α of the foil, N/(m/s)².
    pub foil_n_per_mps2: f64,
    /// Rise of the squared inflow speed per newton of thrust ahead, (m/s)²/N.
    pub slipstream_m2ps2_per_n: f64,
    /// Largest steering angle to either side, rad.
    pub steering_limit_rad: f64,
    /// Fastest steering motion, rad/s.
    pub steering_rate_radps: f64,
}

/// ArduPilot's kinematic motor boat (SIM_Sailboat.cpp, SIM_MotorBoat.h).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motorboat {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Thrust at full throttle, ahead as astern, N.
    pub thrust_limit_n: f64,
    /// Drag per squared speed, N/(m/s)².
    pub drag_n_per_mps2: f64,
    /// Diameter of the turning circle at full steering, m.
    pub turning_circle_m: f64,
    /// Steering angle at full command, rad.
    pub steering_limit_rad: f64,
}

/// Windage after Blendermann 1994, first harmonics only (Fossen 2021, §10.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindLoads {
    /// Projected area seen from ahead, m².
    pub frontal_area_m2: f64,
    /// Projected area seen from the side, m².
    pub lateral_area_m2: f64,
    /// Drag coefficient of a head wind.
    pub cx: f64,
    /// Drag coefficient of a beam wind.
    pub cy: f64,
    /// Amplitude of the yaw coefficient C_N·sin 2γ.
    pub cn: f64,
}

/// First-order response to waves. Horizontally the hull follows the water, averaged over its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaveResponse {
    /// Yaw amplitude per wave amplitude in quartering seas, rad/m.
    pub yaw_rad_per_m: f64,
    /// Share of the transverse wave slope that appears as roll.
    pub roll_factor: f64,
    /// Share of the longitudinal wave slope that appears as pitch.
    pub pitch_factor: f64,
}

/// What of the hull is under water, for its drag over a near bottom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShallowWater {
    /// Immersed midship section, m².
    pub midship_area_m2: f64,
    /// Draught, m.
    pub draft_m: f64,
}

impl ShallowWater {
    /// The least depth in which the drag is known, m: a keel clearance of a fifth of the draught, below which the
    /// water is "very shallow" (PIANC 1992), and no more midship section than the depth squared.
    pub fn least_depth_m(&self) -> f64 {
        self.midship_area_m2.sqrt().max(1.2 * self.draft_m)
    }
}

/// Why a hull was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HullError {
    /// No built-in hull of that name.
    #[error("there is no built-in hull `{name}`: choose one of {known}, or give the path of a hull file")]
    Unknown {
        /// The name asked for.
        name: String,
        /// The built-in names, comma separated.
        known: String,
    },
    /// The text is not TOML of the right form; the message shows the line.
    #[error("the hull file cannot be read: {0}")]
    Syntax(String),
    /// A number outside its range.
    #[error("hull key `{key}`{} is {value}: it must be {allowed}", in_words(*.line))]
    OutOfRange {
        /// Dotted key in the file.
        key: String,
        /// Its line in the file, from 1.
        line: Option<usize>,
        /// What the file says.
        value: f64,
        /// The allowed range in words, with unit.
        allowed: String,
    },
    /// Tables missing or in contradiction.
    #[error("{0}")]
    Layout(String),
    /// The mass matrix cannot belong to a body.
    #[error(
        "the mass matrix is not positive definite: m22·m33 = {m22_m33} must exceed m23² = {m23_squared}; \
         reduce `inertia.m23_kgm` below {limit_kgm} in magnitude, or raise m22 or m33"
    )]
    NotPositiveDefinite {
        /// Product of the diagonal terms, kg²·m².
        m22_m33: f64,
        /// Square of the coupling, kg²·m².
        m23_squared: f64,
        /// Largest coupling the diagonal allows, kg·m.
        limit_kgm: f64,
    },
}

/// Name and text of every built-in hull.
const BUILTIN: [(&str, &str); 4] = [
    ("otter", include_str!("../../hulls/otter.toml")),
    ("monohull38", include_str!("../../hulls/monohull38.toml")),
    ("skiff", include_str!("../../hulls/skiff.toml")),
    ("motorboat", include_str!("../../hulls/motorboat.toml")),
];

impl Hull {
    /// The names [`Hull::builtin`] knows, in the order they are listed to users.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|(name, _)| *name)
    }

    /// The built-in hull `name`.
    ///
    /// # Errors
    /// [`HullError::Unknown`] when there is none of that name.
    pub fn builtin(name: &str) -> Result<Hull, HullError> {
        match BUILTIN.iter().find(|(known, _)| *known == name) {
            Some((_, text)) => Hull::from_toml(text),
            None => Err(HullError::Unknown {
                name: name.to_owned(),
                known: Hull::names().collect::<Vec<_>>().join(", "),
            }),
        }
    }

    /// The TOML text of the built-in hull `name`, as a pattern for one's own.
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        BUILTIN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// Reads a hull file.
    ///
    /// # Errors
    /// [`HullError`] names the key, the line or the contradiction.
    pub fn from_toml(text: &str) -> Result<Hull, HullError> {
        hull_file::parse(text)
    }

    /// Steady speed through the water at full throttle on a straight course, m/s.
    pub fn top_speed_mps(&self) -> f64 {
        match &self.dynamics {
            HullDynamics::Maneuvering(body, drive) => {
                hull_check::terminal_velocity(&body.surge, hull_check::ahead_limit_n(drive))
            }
            HullDynamics::Motorboat(boat) => (boat.thrust_limit_n / boat.drag_n_per_mps2).sqrt(),
        }
    }

    /// True when the boat steers by two thrusters rather than by a rudder or a leg.
    pub fn has_twin_thrusters(&self) -> bool {
        matches!(self.dynamics, HullDynamics::Maneuvering(_, Propulsion::TwinThrusters(_)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_builtin_hull_loads_under_its_own_name() {
        for name in Hull::names() {
            let hull = Hull::builtin(name).unwrap();
            assert_eq!(hull.name, name);
        }
    }

    #[test]
    fn an_unknown_name_lists_the_known_ones() {
        let message = Hull::builtin("dreadnought").unwrap_err().to_string();
        assert!(message.contains("otter") && message.contains("skiff"), "{message}");
    }

    #[test]
    fn a_key_that_does_not_exist_is_refused_with_its_line() {
        let text = Hull::builtin_text("otter").unwrap().replace("beam_m", "beem_m");
        let message = Hull::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains("beem_m") && message.contains("line"), "{message}");
    }

    #[test]
    fn a_negative_mass_is_refused_with_key_and_range() {
        let text = Hull::builtin_text("otter").unwrap().replace("m11_kg = 85.5", "m11_kg = -85.5");
        let message = Hull::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains("inertia.m11_kg") && message.contains("-85.5"), "{message}");
    }

    #[test]
    fn not_a_number_is_refused() {
        let text = Hull::builtin_text("otter").unwrap().replace("m11_kg = 85.5", "m11_kg = nan");
        assert!(matches!(Hull::from_toml(&text), Err(HullError::OutOfRange { .. })));
    }

    #[test]
    fn a_mass_matrix_that_is_not_positive_definite_is_refused() {
        let text = Hull::builtin_text("otter").unwrap().replace("m23_kgm = 12.25", "m23_kgm = 90.0");
        let message = Hull::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains("positive definite") && message.contains("83.2"), "{message}");
    }

    #[test]
    fn a_boat_needs_exactly_one_drive() {
        let otter = Hull::builtin_text("otter").unwrap();
        let without = otter.split("[twin_thrusters]").next().unwrap();
        assert!(matches!(Hull::from_toml(without), Err(HullError::Layout(_))));
        let with_two = format!(
            "{otter}\n[motorboat]\nmass_kg = 2.0\nthrust_limit_n = 50.0\ndrag_n_per_mps2 = 0.5\nturning_circle_m = 1.8\nsteering_limit_deg = 35.0\n"
        );
        assert!(matches!(Hull::from_toml(&with_two), Err(HullError::Layout(_))));
    }
}
