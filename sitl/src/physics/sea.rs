//! The sea as a description: current, wind and waves, from a named state or from explicit figures.

use super::hull::Hull;

/// Mean conditions around the boat. Directions in degrees true.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sea {
    /// Water that moves; `None` is slack water.
    pub current: Option<Current>,
    /// Air that moves; `None` is a calm.
    pub wind: Option<Wind>,
    /// Waves; `None` is flat water.
    pub waves: Option<Waves>,
    /// Slow forces without a cause, as the path-following literature has them; see [`Push`].
    pub push: Option<Push>,
    /// Depth of the water, m; `None` is deep water. Only hulls that say how large they are under water feel it.
    pub depth_m: Option<f64>,
}

/// Constant and slowly varying forces on the hull: for the 38 m ship (10, 20 and 30 kN or kN·m) times
/// 1.5 + sin 0.1t + cos 0.01t (in sway and yaw with sine and cosine exchanged, in yaw with a minus), as the public
/// simulation files of Do and Pan's followers have it; scaled to other hulls by Froude's law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Push {
    /// 1 for the forces of the literature.
    pub share: f64,
}

/// A current of uniform velocity around the boat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Current {
    /// Mean speed, m/s.
    pub speed_mps: f64,
    /// Direction it flows toward, ° true.
    pub toward_deg: f64,
    /// 0 is perfectly steady; 1 lets speed and direction wander as a Gauss–Markov process with standard
    /// deviations 15 % (200 s) and 15° (300 s).
    pub variability: f64,
}

/// Wind at the height of the boat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wind {
    /// Mean speed over ground, m/s.
    pub speed_mps: f64,
    /// Direction it blows from, ° true.
    pub from_deg: f64,
    /// 0 is perfectly steady; 1 has gusts with a standard deviation of 15 % (8 s).
    pub gustiness: f64,
}

/// A long-crested irregular sea.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waves {
    /// Significant height H_s, m.
    pub height_m: f64,
    /// Peak period T_p, s.
    pub period_s: f64,
    /// Direction the waves come from, ° true.
    pub from_deg: f64,
}

/// Named sea states, scaled to the boat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeaState {
    /// No current, wind or waves.
    Calm,
    /// A good day.
    Slight,
    /// A day on which work is still done.
    Moderate,
    /// The limit of what the boat can work in.
    Rough,
}

/// Why a sea was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SeaError {
    /// Not a named sea state.
    #[error("`{0}` is no sea state: choose one of calm, slight, moderate, rough")]
    UnknownState(String),
    /// The text does not have the expected form.
    #[error("`{text}` is no {what}: write {form}, for example {example}")]
    Form {
        /// What was given.
        text: String,
        /// What it should describe.
        what: &'static str,
        /// The expected form.
        form: &'static str,
        /// A correct example.
        example: &'static str,
    },
    /// A number outside its range.
    #[error("{what} is {value}: it must be between {min} and {max} {unit}")]
    OutOfRange {
        /// The quantity.
        what: &'static str,
        /// What was given.
        value: String,
        /// Least allowed value.
        min: String,
        /// Greatest allowed value.
        max: String,
        /// Unit of all three.
        unit: &'static str,
    },
}

impl std::str::FromStr for SeaState {
    type Err = SeaError;

    fn from_str(text: &str) -> Result<SeaState, SeaError> {
        match text {
            "calm" => Ok(SeaState::Calm),
            "slight" => Ok(SeaState::Slight),
            "moderate" => Ok(SeaState::Moderate),
            "rough" => Ok(SeaState::Rough),
            other => Err(SeaError::UnknownState(other.to_owned())),
        }
    }
}

impl SeaState {
    /// Shares of the moderate (current, wind, height, period).
    fn shares(self) -> Option<(f64, f64, f64, f64)> {
        match self {
            SeaState::Calm => None,
            SeaState::Slight => Some((0.5, 0.6, 0.4, 0.8)),
            SeaState::Moderate => Some((1.0, 1.0, 1.0, 1.0)),
            SeaState::Rough => Some((1.6, 1.5, 1.7, 1.15)),
        }
    }
}

/// Directions of the named sea states: wind and waves nearly together, the current across them, and none
/// along a compass axis, so that no leg of a usual survey gets off lightly.
const PRESET_CURRENT_TOWARD_DEG: f64 = 60.0;
const PRESET_WIND_FROM_DEG: f64 = 200.0;
const PRESET_WAVES_FROM_DEG: f64 = 215.0;

impl Sea {
    /// A named sea state for this boat.
    ///
    /// Moderate is a current of 0.35 m/s, wind of 7 m/s and waves of 0.35 m and 2.8 s for a boat of 2 m, and
    /// 0.6 m/s, 12 m/s, 1.5 m and 7 s for one of 38 m; other lengths follow the power law through the two.
    pub fn preset(state: SeaState, hull: &Hull) -> Sea {
        let Some((current, wind, height, period)) = state.shares() else { return Sea::default() };
        let scale = |at_2_m: f64, at_38_m: f64| {
            let exponent = (at_38_m / at_2_m).ln() / (38.0f64 / 2.0).ln();
            at_2_m * (hull.length_m / 2.0).powf(exponent)
        };
        Sea {
            current: Some(Current {
                speed_mps: current * scale(0.35, 0.6),
                toward_deg: PRESET_CURRENT_TOWARD_DEG,
                variability: 1.0,
            }),
            wind: Some(Wind {
                speed_mps: wind * scale(7.0, 12.0),
                from_deg: PRESET_WIND_FROM_DEG,
                gustiness: 1.0,
            }),
            waves: Some(Waves {
                height_m: height * scale(0.35, 1.5),
                period_s: period * scale(2.8, 7.0),
                from_deg: PRESET_WAVES_FROM_DEG,
            }),
            push: None,
            depth_m: None,
        }
    }

    /// The same sea with wandering current and gusty wind (1), or perfectly steady ones (0). Values outside
    /// 0 to 2 are clipped; NaN counts as steady.
    #[must_use]
    pub fn with_variability(mut self, variability: f64) -> Sea {
        let variability = if variability.is_nan() { 0.0 } else { variability.clamp(0.0, 2.0) };
        if let Some(current) = &mut self.current {
            current.variability = variability;
        }
        if let Some(wind) = &mut self.wind {
            wind.gustiness = variability;
        }
        self
    }
}

impl std::str::FromStr for Current {
    type Err = SeaError;

    /// Reads `SPEED@TOWARD` (m/s, ° true) as a steady current.
    fn from_str(text: &str) -> Result<Current, SeaError> {
        let form = Form { text, what: "current", form: "SPEED@TOWARD in m/s and degrees", example: "0.3@90" };
        let (speed, toward) = form.split(text, '@')?;
        Ok(Current {
            speed_mps: within("the speed of the current", form.number(speed)?, 0.0, 10.0, "m/s")?,
            toward_deg: bearing("the direction of the current", form.number(toward)?)?,
            variability: 0.0,
        })
    }
}

impl std::str::FromStr for Wind {
    type Err = SeaError;

    /// Reads `SPEED@FROM` (m/s, ° true) as a steady wind.
    fn from_str(text: &str) -> Result<Wind, SeaError> {
        let form = Form { text, what: "wind", form: "SPEED@FROM in m/s and degrees", example: "8@225" };
        let (speed, from) = form.split(text, '@')?;
        Ok(Wind {
            speed_mps: within("the speed of the wind", form.number(speed)?, 0.0, 60.0, "m/s")?,
            from_deg: bearing("the direction of the wind", form.number(from)?)?,
            gustiness: 0.0,
        })
    }
}

impl std::str::FromStr for Waves {
    type Err = SeaError;

    /// Reads `HS:TP@FROM` (m, s, ° true).
    fn from_str(text: &str) -> Result<Waves, SeaError> {
        let form = Form { text, what: "sea", form: "HS:TP@FROM in m, s and degrees", example: "0.4:3@270" };
        let (shape, from) = form.split(text, '@')?;
        let (height, period) = form.split(shape, ':')?;
        let waves = Waves {
            height_m: within("the significant wave height", form.number(height)?, 0.0, 20.0, "m")?,
            period_s: within("the peak wave period", form.number(period)?, 0.5, 30.0, "s")?,
            from_deg: bearing("the direction of the waves", form.number(from)?)?,
        };
        // Waves steeper than H_s/λ_p ≈ 1/10 break before they get there.
        let steepest_m = 0.1 * 1.56 * waves.period_s * waves.period_s;
        within("the significant wave height for this period", waves.height_m, 0.0, steepest_m, "m")?;
        Ok(waves)
    }
}

/// A depth of water in range.
///
/// # Errors
/// It is not between 0.1 and 1000 m.
pub fn checked_depth_m(depth_m: f64) -> Result<f64, SeaError> {
    within("the depth of the water", depth_m, 0.1, 1000.0, "m")
}

/// What a text should have looked like, for the error.
#[derive(Clone, Copy)]
struct Form<'a> {
    text: &'a str,
    what: &'static str,
    form: &'static str,
    example: &'static str,
}

impl Form<'_> {
    fn error(self) -> SeaError {
        SeaError::Form { text: self.text.to_owned(), what: self.what, form: self.form, example: self.example }
    }

    fn split(self, text: &str, separator: char) -> Result<(&str, &str), SeaError> {
        text.split_once(separator).ok_or_else(|| self.error())
    }

    fn number(self, text: &str) -> Result<f64, SeaError> {
        text.trim().parse().map_err(|_| self.error())
    }
}

fn within(what: &'static str, value: f64, min: f64, max: f64, unit: &'static str) -> Result<f64, SeaError> {
    if (min..=max).contains(&value) {
        return Ok(value);
    }
    let text = |number: f64| format!("{}", (number * 1000.0).round() / 1000.0);
    Err(SeaError::OutOfRange { what, value: text(value), min: text(min), max: text(max), unit })
}

fn bearing(what: &'static str, degrees: f64) -> Result<f64, SeaError> {
    within(what, degrees, -360.0, 360.0, "°")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn explicit_parts_are_steady() {
        let current: Current = "0.3@30".parse().unwrap();
        assert_eq!(current, Current { speed_mps: 0.3, toward_deg: 30.0, variability: 0.0 });
        let wind: Wind = "8@225".parse().unwrap();
        assert_eq!(wind, Wind { speed_mps: 8.0, from_deg: 225.0, gustiness: 0.0 });
        let waves: Waves = "0.4:3@270".parse().unwrap();
        assert_eq!(waves, Waves { height_m: 0.4, period_s: 3.0, from_deg: 270.0 });
    }

    #[test]
    fn errors_show_the_form_and_an_example() {
        for text in ["", "0.3", "0.3@", "@30", "a@b", "0.3@30@40"] {
            let message = text.parse::<Current>().unwrap_err().to_string();
            assert!(message.contains("SPEED@TOWARD") && message.contains("0.3@90"), "{text}: {message}");
        }
        assert!("0.4@270".parse::<Waves>().unwrap_err().to_string().contains("HS:TP@FROM"));
    }

    #[test]
    fn impossible_figures_are_refused_with_their_range() {
        assert!("nan@30".parse::<Current>().unwrap_err().to_string().contains("between 0 and 10 m/s"));
        assert!("-1@30".parse::<Wind>().is_err());
        assert!("8@400".parse::<Wind>().is_err());
        let message = "3:2@0".parse::<Waves>().unwrap_err().to_string();
        assert!(message.contains("for this period") && message.contains("0.624"), "{message}");
    }

    #[test]
    fn moderate_fits_the_two_reference_boats() {
        let of = |name| Sea::preset(SeaState::Moderate, &Hull::builtin(name).unwrap());
        let (otter, ship) = (of("otter"), of("monohull38"));
        assert!((otter.waves.unwrap().height_m - 0.35).abs() < 1e-9);
        assert!((ship.waves.unwrap().height_m - 1.5).abs() < 1e-9);
        assert!((ship.wind.unwrap().speed_mps - 12.0).abs() < 1e-9);
        assert!((otter.current.unwrap().speed_mps - 0.35).abs() < 1e-9);
    }

    #[test]
    fn sea_states_rise_in_order() {
        let hull = Hull::builtin("skiff").unwrap();
        let height = |state| Sea::preset(state, &hull).waves.map_or(0.0, |waves| waves.height_m);
        let heights = [SeaState::Calm, SeaState::Slight, SeaState::Moderate, SeaState::Rough].map(height);
        assert!(heights.windows(2).all(|pair| pair[0] < pair[1]), "{heights:?}");
        assert_eq!("rough".parse(), Ok(SeaState::Rough));
        assert!("stormy".parse::<SeaState>().unwrap_err().to_string().contains("slight"));
    }
}
