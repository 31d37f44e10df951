//! What may differ from what the controller was made for.

use std::str::FromStr;

use helmlink_sitl::physics::hull::{Damping, HullDynamics, Propulsion};
use thiserror::Error;

use super::trial::Trial;

/// One thing that differs from the nominal case.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Perturbation {
    /// Nothing.
    #[default]
    Nominal,
    /// All masses and inertias, added ones included, times this.
    Mass(f64),
    /// All damping, cross-flow drag included, times this.
    Damping(f64),
    /// The bridge's bytes take this long, s.
    Delay(f64),
    /// Rate of the steering gear times this, lags of shafts divided by it.
    Actuators(f64),
    /// Position and velocity noise of the GPS times this.
    Gps(f64),
    /// Speed of current and wind times this.
    Sea(f64),
    /// The control loop runs at this rate, Hz.
    Rate(f64),
}

/// The text names no perturbation.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "`{0}` is no perturbation: write nominal, mass*F, damping*F, actuators*F, gps*F, sea*F with a factor F from \
     0.05 to 20, delay=S with 0 to 1.5 seconds, or rate=HZ with 2 to 50 Hz; for example mass*1.5"
)]
pub struct UnknownPerturbation(String);

impl Perturbation {
    /// The grid of the comparison: mass and damping ±30 % and ±50 %, delay to 1 s, slow actuators, GPS noise,
    /// stronger current and wind, rates of control.
    pub const GRID: [Self; 20] = [
        Self::Nominal,
        Self::Mass(0.5),
        Self::Mass(0.7),
        Self::Mass(1.3),
        Self::Mass(1.5),
        Self::Damping(0.5),
        Self::Damping(0.7),
        Self::Damping(1.3),
        Self::Damping(1.5),
        Self::Delay(0.2),
        Self::Delay(0.5),
        Self::Delay(0.7),
        Self::Delay(1.0),
        Self::Actuators(0.5),
        Self::Gps(3.0),
        Self::Sea(1.4),
        Self::Rate(5.0),
        Self::Rate(10.0),
        Self::Rate(20.0),
        Self::Rate(50.0),
    ];

    /// Changes the trial; the controller is not told.
    pub fn apply(self, trial: &mut Trial) {
        match self {
            Self::Nominal => {}
            Self::Mass(factor) => scale_mass(&mut trial.hull.dynamics, factor),
            Self::Damping(factor) => scale_damping(&mut trial.hull.dynamics, factor),
            Self::Delay(seconds) => trial.delay_s = seconds,
            Self::Actuators(factor) => scale_actuators(&mut trial.hull.dynamics, factor),
            Self::Gps(factor) => {
                if let Some(noise) = &mut trial.sensors.noise {
                    noise.gps_white_m *= factor;
                    noise.gps_wander_m *= factor;
                    noise.gps_velocity_mps *= factor;
                }
            }
            Self::Sea(factor) => {
                if let Some(current) = &mut trial.sea.current {
                    current.speed_mps *= factor;
                }
                if let Some(wind) = &mut trial.sea.wind {
                    wind.speed_mps *= factor;
                }
            }
            Self::Rate(rate_hz) => trial.interval_s = 1.0 / rate_hz,
        }
    }
}

fn scale_mass(dynamics: &mut HullDynamics, factor: f64) {
    match dynamics {
        HullDynamics::Maneuvering(body, _) => {
            for mass in [&mut body.m11_kg, &mut body.m22_kg, &mut body.m23_kgm, &mut body.m33_kgm2] {
                *mass *= factor;
            }
        }
        HullDynamics::Motorboat(boat) => boat.mass_kg *= factor,
    }
}

fn scale_damping(dynamics: &mut HullDynamics, factor: f64) {
    let scale = |damping: &mut Damping| {
        damping.linear *= factor;
        damping.quadratic *= factor;
        damping.cubic *= factor;
    };
    match dynamics {
        HullDynamics::Maneuvering(body, _) => {
            scale(&mut body.surge);
            scale(&mut body.sway);
            scale(&mut body.yaw);
            if let Some(strips) = &mut body.cross_flow {
                strips.strip_n_per_m_mps2 *= factor;
            }
        }
        HullDynamics::Motorboat(boat) => boat.drag_n_per_mps2 *= factor,
    }
}

fn scale_actuators(dynamics: &mut HullDynamics, factor: f64) {
    let HullDynamics::Maneuvering(_, propulsion) = dynamics else { return };
    match propulsion {
        Propulsion::TwinThrusters(twin) => twin.lag_s /= factor,
        Propulsion::PropellerRudder(drive) | Propulsion::Outboard(drive) => {
            drive.steering_rate_radps *= factor;
            drive.throttle_lag_s /= factor;
        }
    }
}

impl std::fmt::Display for Perturbation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Nominal => write!(f, "nominal"),
            Self::Mass(factor) => write!(f, "mass*{factor}"),
            Self::Damping(factor) => write!(f, "damping*{factor}"),
            Self::Delay(seconds) => write!(f, "delay={seconds}"),
            Self::Actuators(factor) => write!(f, "actuators*{factor}"),
            Self::Gps(factor) => write!(f, "gps*{factor}"),
            Self::Sea(factor) => write!(f, "sea*{factor}"),
            Self::Rate(rate_hz) => write!(f, "rate={rate_hz}"),
        }
    }
}

impl FromStr for Perturbation {
    type Err = UnknownPerturbation;

    fn from_str(text: &str) -> Result<Self, UnknownPerturbation> {
        let fault = || UnknownPerturbation(text.to_owned());
        if text == "nominal" {
            return Ok(Self::Nominal);
        }
        let (name, number) = text.split_once(['*', '=']).ok_or_else(fault)?;
        let value: f64 = number.parse().map_err(|_| fault())?;
        let (parsed, range) = match name {
            "mass" => (Self::Mass(value), 0.05..=20.0),
            "damping" => (Self::Damping(value), 0.05..=20.0),
            "actuators" => (Self::Actuators(value), 0.05..=20.0),
            "gps" => (Self::Gps(value), 0.05..=20.0),
            "sea" => (Self::Sea(value), 0.05..=20.0),
            "delay" => (Self::Delay(value), 0.0..=1.5),
            "rate" => (Self::Rate(value), 2.0..=50.0),
            _ => return Err(fault()),
        };
        let is_written_so = parsed.to_string() == format!("{name}{}{value}", &text[name.len()..=name.len()]);
        if range.contains(&value) && is_written_so { Ok(parsed) } else { Err(fault()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_perturbation_of_the_grid_is_read_as_it_is_written() {
        for perturbation in Perturbation::GRID {
            assert_eq!(perturbation.to_string().parse(), Ok(perturbation));
        }
        for wrong in ["", "mass", "mass=1.5", "mass*0", "delay*1", "delay=9", "rate=nan", "wind*2"] {
            let error = wrong.parse::<Perturbation>().unwrap_err().to_string();
            assert!(error.contains("mass*F"), "{wrong}: {error}");
        }
    }

    #[test]
    fn masses_and_damping_are_scaled_and_nothing_else() {
        let otter = helmlink_sitl::physics::Hull::builtin("otter").unwrap();
        let (mut heavy, mut sluggish) = (otter.dynamics, otter.dynamics);
        scale_mass(&mut heavy, 1.5);
        scale_damping(&mut sluggish, 0.5);
        let HullDynamics::Maneuvering(before, _) = otter.dynamics else { panic!("the Otter manoeuvres") };
        let HullDynamics::Maneuvering(heavy, _) = heavy else { panic!("so does a heavy one") };
        let HullDynamics::Maneuvering(sluggish, _) = sluggish else { panic!("so does a smooth one") };
        assert_eq!((heavy.m33_kgm2, heavy.yaw), (1.5 * before.m33_kgm2, before.yaw));
        assert_eq!((sluggish.m33_kgm2, sluggish.yaw.linear), (before.m33_kgm2, 0.5 * before.yaw.linear));
    }
}
