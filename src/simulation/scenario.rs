//! Named conditions of a published comparison of controllers: what disturbs the boat and what it measures.

use std::str::FromStr;

use helmlink_sitl::physics::sea::Push;
use helmlink_sitl::physics::{Hull, Sea, SeaState, SensorSettings};
use thiserror::Error;

/// A named scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scenario {
    /// Nothing disturbs, everything is measured exactly.
    I,
    /// Constant and sinusoidal forces, exact measurement.
    Ii,
    /// Current, wind with gusts and wave drift, exact measurement without wave motion.
    Iii,
    /// As the last, with wave motion, a 5 Hz GPS (0.3 m white, 0.5 m wandering), compass and gyro errors, and
    /// 0.3 s of delay.
    Iv,
    /// As the last, but with an exact GPS: compass and gyro errors remain.
    IvWithoutGpsNoise,
}

/// The text names no scenario.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("`{0}` is no scenario: choose one of i, ii, iii, iv, iv-exact-gps")]
pub struct UnknownScenario(String);

impl Scenario {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::I, Self::Ii, Self::Iii, Self::Iv, Self::IvWithoutGpsNoise];

    /// The name as it is typed.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::I => "i",
            Self::Ii => "ii",
            Self::Iii => "iii",
            Self::Iv => "iv",
            Self::IvWithoutGpsNoise => "iv-exact-gps",
        }
    }

    /// The sea around `hull`.
    #[must_use]
    pub fn sea(self, hull: &Hull) -> Sea {
        match self {
            Self::I => Sea::default(),
            Self::Ii => Sea { push: Some(Push { share: 1.0 }), ..Sea::default() },
            Self::Iii | Self::Iv | Self::IvWithoutGpsNoise => Sea::preset(SeaState::Moderate, hull),
        }
    }

    /// The sensors.
    #[must_use]
    pub fn sensors(self) -> SensorSettings {
        match self {
            Self::I | Self::Ii | Self::Iii => {
                SensorSettings { without_waves: true, ..SensorSettings::perfect() }
            }
            Self::Iv => SensorSettings::poor(),
            Self::IvWithoutGpsNoise => {
                let mut sensors = SensorSettings::poor();
                if let Some(noise) = &mut sensors.noise {
                    (noise.gps_white_m, noise.gps_wander_m, noise.gps_velocity_mps) = (0.0, 0.0, 0.0);
                }
                sensors
            }
        }
    }

    /// Delay of the commands, s.
    #[must_use]
    pub fn delay_s(self) -> f64 {
        match self {
            Self::I | Self::Ii | Self::Iii => 0.0,
            Self::Iv | Self::IvWithoutGpsNoise => 0.3,
        }
    }
}

impl FromStr for Scenario {
    type Err = UnknownScenario;

    fn from_str(text: &str) -> Result<Self, UnknownScenario> {
        Self::ALL
            .into_iter()
            .find(|scenario| scenario.as_str() == text)
            .ok_or_else(|| UnknownScenario(text.to_owned()))
    }
}
