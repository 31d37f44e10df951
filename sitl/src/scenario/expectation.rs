//! What must come of a scenario, and whether it has.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use crate::autopilot::{mode_name, mode_number};

/// How things stand, as far as expectations go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Number of the autopilot's mode.
    pub mode: u32,
    /// Whether the motors are armed.
    pub armed: bool,
    /// Whether the autopilot knows its position.
    pub has_position: bool,
    /// Whether the mission has been driven to its end.
    pub mission_complete: bool,
    /// Sequence number of the current item.
    pub mission_item: f64,
    /// True position, metres north of the start.
    pub north_m: f64,
    /// True position, metres east of the start.
    pub east_m: f64,
    /// True distance from home, m.
    pub distance_home_m: f64,
    /// True speed over ground, m/s.
    pub speed_mps: f64,
    /// True heading, degrees, 0 to 360.
    pub heading_deg: f64,
    /// True distance to the nearest leg of the mission on board, m; 0 without one.
    pub cross_track_m: f64,
    /// Distance between true and estimated position, m.
    pub position_error_m: f64,
    /// What is left in the battery, per cent.
    pub battery_percent: f64,
}

/// Something that must come true.
#[derive(Debug, Clone, PartialEq)]
pub struct Expectation {
    pub(super) quantity: Quantity,
    pub(super) test: Test,
    pub(super) window: Window,
}

/// What has become of an expectation.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// The expectation in words.
    pub expectation: String,
    /// Whether it came true; `None` while that is open.
    pub passed: Option<bool>,
    /// What was seen when it was decided.
    pub seen: String,
}

/// What is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Mode,
    Armed,
    HasPosition,
    MissionComplete,
    MissionItem,
    North,
    East,
    DistanceHome,
    Speed,
    Heading,
    CrossTrack,
    PositionError,
    Battery,
}

const QUANTITIES: [(&str, Quantity); 13] = [
    ("mode", Quantity::Mode),
    ("armed", Quantity::Armed),
    ("has_position", Quantity::HasPosition),
    ("mission_complete", Quantity::MissionComplete),
    ("mission_item", Quantity::MissionItem),
    ("north_m", Quantity::North),
    ("east_m", Quantity::East),
    ("distance_home_m", Quantity::DistanceHome),
    ("speed_mps", Quantity::Speed),
    ("heading_deg", Quantity::Heading),
    ("cross_track_m", Quantity::CrossTrack),
    ("position_error_m", Quantity::PositionError),
    ("battery_percent", Quantity::Battery),
];

impl FromStr for Quantity {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = QUANTITIES.iter().find(|(name, _)| *name == text).map(|(_, quantity)| *quantity);
        let names = || QUANTITIES.map(|(name, _)| name).join(", ");
        found.ok_or_else(|| format!("`{text}` must be one of {}", names()))
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = QUANTITIES.iter().find(|(_, quantity)| quantity == self).map_or("", |(name, _)| name);
        f.write_str(name)
    }
}

/// The value of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Value {
    Flag(bool),
    Mode(u32),
    Number(f64),
}

impl Quantity {
    pub(super) fn is_number(self) -> bool {
        !matches!(self, Self::Mode | Self::Armed | Self::HasPosition | Self::MissionComplete)
    }

    /// The test that the quantity has one certain value.
    pub(super) fn is(self, value: &toml::Value) -> Result<Test, String> {
        match (self, value) {
            (Self::Mode, toml::Value::String(name)) => {
                let number = mode_number(name).ok_or_else(|| format!("`{name}` is no mode, such as HOLD"))?;
                Ok(Test::Mode(number, name.to_uppercase()))
            }
            (Self::Mode, _) => Err("a mode is a name, such as \"HOLD\"".to_owned()),
            (Self::Armed | Self::HasPosition | Self::MissionComplete, toml::Value::Boolean(flag)) => {
                Ok(Test::Flag(*flag))
            }
            (Self::Armed | Self::HasPosition | Self::MissionComplete, _) => {
                Err(format!("{self} is true or false"))
            }
            (Self::MissionItem, toml::Value::Integer(number)) => Ok(Test::Number(*number as f64)),
            _ => Err(format!("{self} is a measured number: use below and above")),
        }
    }

    fn of(self, seen: &Observation) -> Value {
        match self {
            Self::Mode => Value::Mode(seen.mode),
            Self::Armed => Value::Flag(seen.armed),
            Self::HasPosition => Value::Flag(seen.has_position),
            Self::MissionComplete => Value::Flag(seen.mission_complete),
            Self::MissionItem => Value::Number(seen.mission_item),
            Self::North => Value::Number(seen.north_m),
            Self::East => Value::Number(seen.east_m),
            Self::DistanceHome => Value::Number(seen.distance_home_m),
            Self::Speed => Value::Number(seen.speed_mps),
            Self::Heading => Value::Number(seen.heading_deg),
            Self::CrossTrack => Value::Number(seen.cross_track_m),
            Self::PositionError => Value::Number(seen.position_error_m),
            Self::Battery => Value::Number(seen.battery_percent),
        }
    }
}

/// What the quantity must be.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Test {
    Flag(bool),
    Mode(u32, String),
    Number(f64),
    Between { above: Option<f64>, below: Option<f64> },
}

/// When it must be so, on the scenario's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Window {
    /// At some time.
    Once { from: Duration, until: Duration },
    /// At every time.
    Always { from: Duration, until: Duration },
}

impl Window {
    pub(super) fn span(self) -> (Duration, Duration) {
        match self {
            Self::Once { from, until } | Self::Always { from, until } => (from, until),
        }
    }
}

impl Expectation {
    /// Decides what can be decided at `now`; `over` says that there will be no further look.
    pub(super) fn judge(&self, verdict: &mut Verdict, seen: &Observation, now: Duration, over: bool) {
        let (from, until) = self.window.span();
        if verdict.passed.is_some() || now < from && !over {
            return;
        }
        let holds = self.holds(seen);
        let ended = over || now >= until;
        let passed = match self.window {
            // An end before the window opens leaves it to the last look.
            Window::Once { .. } if holds && now <= until => Some(true),
            Window::Once { .. } => ended.then_some(false),
            Window::Always { .. } if !holds && now <= until => Some(false),
            Window::Always { .. } => ended.then_some(true),
        };
        if passed.is_some() {
            verdict.passed = passed;
            verdict.seen = format!("{} at {:.1} s", self.in_words(seen), now.as_secs_f64());
        }
    }

    /// In words, if what it looks at is not the boat's motion.
    pub(super) fn looks_at_the_autopilot(&self) -> Option<String> {
        let of_the_boat = matches!(
            self.quantity,
            Quantity::Armed
                | Quantity::North
                | Quantity::East
                | Quantity::DistanceHome
                | Quantity::Speed
                | Quantity::Heading
        );
        (!of_the_boat).then(|| format!("looks at {}", self.quantity))
    }

    fn holds(&self, seen: &Observation) -> bool {
        match (&self.test, self.quantity.of(seen)) {
            (Test::Flag(wanted), Value::Flag(is)) => *wanted == is,
            (Test::Mode(wanted, _), Value::Mode(is)) => *wanted == is,
            (Test::Number(wanted), Value::Number(is)) => *wanted == is,
            (Test::Between { above, below }, Value::Number(is)) => {
                above.is_none_or(|above| is > above) && below.is_none_or(|below| is < below)
            }
            _ => false,
        }
    }

    fn in_words(&self, seen: &Observation) -> String {
        match self.quantity.of(seen) {
            Value::Flag(flag) => format!("{} was {flag}", self.quantity),
            Value::Mode(number) => match mode_name(number) {
                Some(name) => format!("mode was {name}"),
                None => format!("mode was number {number}, which has no name"),
            },
            Value::Number(number) => format!("{} was {number:.2}", self.quantity),
        }
    }
}

impl fmt::Display for Expectation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ", self.quantity)?;
        match &self.test {
            Test::Flag(flag) => write!(f, "is {flag}")?,
            Test::Mode(_, name) => write!(f, "is {name}")?,
            Test::Number(number) => write!(f, "is {number}")?,
            Test::Between { above: Some(above), below: Some(below) } => {
                write!(f, "above {above} and below {below}")?;
            }
            Test::Between { above: Some(above), .. } => write!(f, "above {above}")?,
            Test::Between { below, .. } => write!(f, "below {}", below.unwrap_or_default())?,
        }
        let (from, until) = self.window.span();
        let (from_s, until_s) = (from.as_secs_f64(), until.as_secs_f64());
        match self.window {
            Window::Once { .. } => write!(f, " at some time from {from_s} to {until_s} s"),
            Window::Always { .. } => write!(f, " all the time from {from_s} to {until_s} s"),
        }
    }
}
