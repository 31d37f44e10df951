//! Every failsafe, written once: settings, documentation and parameters are derived from this table.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What is done when a limit is passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// Say so and go on.
    Warn,
    /// Motors neutral, ask for RTL, and let go once the flight controller is in it.
    ReturnToLaunch,
    /// Motors neutral, ask for LOITER, and let go once the flight controller is in it; the place in the mission
    /// is kept.
    HoldPosition,
    /// Motors neutral, ask for HOLD, and let go once the flight controller is in it.
    NeutralAndRelease,
    /// Let go at once and send nothing more: somebody else is in command, or nobody listens.
    LetGo,
}

impl Action {
    /// Every action, the mildest first.
    pub const ALL: [Self; 5] =
        [Self::Warn, Self::ReturnToLaunch, Self::HoldPosition, Self::NeutralAndRelease, Self::LetGo];

    /// The name in configuration files and in the documentation.
    pub fn name(self) -> &'static str {
        match self {
            Self::Warn => "warn",
            Self::ReturnToLaunch => "return-to-launch",
            Self::HoldPosition => "hold-position",
            Self::NeutralAndRelease => "neutral-and-release",
            Self::LetGo => "let-go",
        }
    }
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One failsafe as it is documented and configured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Definition {
    /// Which one.
    pub failsafe: Failsafe,
    /// Its key in the configuration.
    pub key: &'static str,
    /// The limit if the user gives none.
    pub limit: f64,
    /// Least and largest limit that can be set.
    pub range: (f64, f64),
    /// The limit's unit; empty where the limit cannot be set.
    pub unit: &'static str,
    /// What is done if the user does not say.
    pub action: Action,
    /// What can be done.
    pub allowed: &'static [Action],
    /// What it watches, for people.
    pub watches: &'static str,
}

/// The boat can still hold its place and find home.
const ANY: &[Action] =
    &[Action::Warn, Action::HoldPosition, Action::ReturnToLaunch, Action::NeutralAndRelease];
/// No mode that needs a position can be asked for.
const BLIND: &[Action] = &[Action::NeutralAndRelease];
/// The boat obeys modes, but none of the bridge's commands.
const DEAF: &[Action] =
    &[Action::HoldPosition, Action::ReturnToLaunch, Action::NeutralAndRelease, Action::LetGo];
/// There is no choice.
const GONE: &[Action] = &[Action::LetGo];

macro_rules! failsafes {
    ($($(#[$doc:meta])* $field:ident, $name:ident, $key:literal: $limit:literal in $least:literal..$most:literal $unit:literal,
        $action:ident of $allowed:ident, $watches:literal;)*) => {
        /// What can go wrong.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Failsafe {
            $($(#[$doc])* $name,)*
        }

        /// Every failsafe, in the order in which they are looked at.
        pub const DEFINITIONS: [Definition; [$(Failsafe::$name),*].len()] = [
            $(Definition {
                failsafe: Failsafe::$name,
                key: $key,
                limit: $limit,
                range: ($least, $most),
                unit: $unit,
                action: Action::$action,
                allowed: $allowed,
                watches: $watches,
            }),*
        ];

        /// The limits and actions that the user has chosen; what is left out keeps its default.
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
        pub struct FailsafeSettings {
            $($(#[$doc])* pub $field: super::settings::Rule,)*
        }

        impl FailsafeSettings {
            /// What the user has said about one failsafe.
            pub fn rule(&self, failsafe: Failsafe) -> &super::settings::Rule {
                match failsafe { $(Failsafe::$name => &self.$field),* }
            }

            /// The same, to be changed.
            pub fn rule_mut(&mut self, failsafe: Failsafe) -> &mut super::settings::Rule {
                match failsafe { $(Failsafe::$name => &mut self.$field),* }
            }
        }
    };
}

failsafes! {
    /// The flight controller's heartbeat is older than the limit.
    link_lost, LinkLost, "link-lost": 3.0 in 0.5..30.0 "s", LetGo of GONE,
        "age of the flight controller's heartbeat";
    /// The flight controller has restarted.
    rebooted, Rebooted, "rebooted": 0.0 in 0.0..0.0 "", LetGo of GONE,
        "the flight controller has restarted";
    /// The mode is not the one the bridge drives in.
    mode_changed, ModeChanged, "mode-changed": 0.0 in 0.0..0.0 "", LetGo of GONE,
        "the mode was changed by somebody else";
    /// The motors have been disarmed.
    disarmed, Disarmed, "disarmed": 0.0 in 0.0..0.0 "", LetGo of GONE,
        "the motors were disarmed";
    /// The flight controller's parameters no longer let it obey the bridge.
    output_refused, OutputRefused, "output-refused": 0.0 in 0.0..0.0 "", NeutralAndRelease of DEAF,
        "the flight controller no longer obeys overrides (SYSID_MYGCS, RC_OVERRIDE_TIME)";
    /// The last position is older than the limit.
    position_age, PositionAge, "position-age": 3.0 in 0.5..30.0 "s", NeutralAndRelease of BLIND,
        "age of the last valid position";
    /// The last heading is older than the limit.
    heading_age, HeadingAge, "heading-age": 3.0 in 0.5..30.0 "s", NeutralAndRelease of BLIND,
        "age of the last heading";
    /// The flight controller's estimator has not vouched for the position for longer than the limit.
    estimator, Estimator, "estimator": 3.0 in 0.0..30.0 "s", NeutralAndRelease of BLIND,
        "time with bad estimator flags (EKF_STATUS_REPORT)";
    /// Something was not a number for longer than the limit.
    not_a_number, NotANumber, "not-a-number": 0.5 in 0.0..10.0 "s", NeutralAndRelease of BLIND,
        "time with telemetry or a command that is not a number";
    /// The position is farther than the limit from where the last one and its velocity lead.
    position_jump, PositionJump, "position-jump": 10.0 in 1.0..1000.0 "m", NeutralAndRelease of ANY,
        "distance between a position and where the last one leads";
    /// The boat is outside its fence by more than the limit.
    fence, Fence, "fence": 0.0 in 0.0..1000.0 "m", HoldPosition of ANY,
        "distance outside the fence on the flight controller";
    /// The boat is farther from its path than the limit.
    cross_track, CrossTrack, "cross-track": 25.0 in 1.0..1000.0 "m", HoldPosition of ANY,
        "distance from the path";
    /// The ground station has been silent for longer than the limit, having been heard before.
    ground_station, GroundStation, "ground-station": 10.0 in 1.0..3600.0 "s", Warn of ANY,
        "age of the ground station's heartbeat, once heard";
    /// The battery holds less than the limit.
    battery, Battery, "battery": 15.0 in 0.0..100.0 "%", Warn of ANY,
        "battery remaining (SYS_STATUS)";
    /// The way to go has not become shorter for the limit.
    no_progress, NoProgress, "no-progress": 60.0 in 5.0..3600.0 "s", HoldPosition of ANY,
        "time without coming closer along the path";
    /// A motor or the rudder has been at its limit for longer than this limit.
    saturated, Saturated, "saturated": 30.0 in 1.0..3600.0 "s", Warn of ANY,
        "time with an actuator at its limit";
    /// The control loop has not stepped for longer than the limit.
    loop_late, LoopLate, "loop-late": 0.5 in 0.1..10.0 "s", Warn of ANY,
        "time since the last control step";
    /// The recording cannot be written.
    recording, Recording, "recording": 0.0 in 0.0..0.0 "", Warn of ANY,
        "the recording cannot be written (disk full)";
}

/// Number of failsafes.
pub const COUNT: usize = DEFINITIONS.len();

impl Failsafe {
    /// Its row of the table.
    pub fn definition(self) -> &'static Definition {
        &DEFINITIONS[self as usize]
    }

    /// True where the limit is a floor: the battery.
    pub fn trips_below(self) -> bool {
        self == Self::Battery
    }

    /// The loss in words, with the value that passed the limit.
    pub fn describe(self, value: f64) -> String {
        match self {
            Self::LinkLost => format!("no heartbeat of the flight controller for {value:.1} s"),
            Self::Rebooted => "the flight controller has restarted".to_owned(),
            Self::ModeChanged => "the mode was changed".to_owned(),
            Self::Disarmed => "the motors are disarmed".to_owned(),
            Self::OutputRefused => "the flight controller no longer obeys the bridge".to_owned(),
            Self::PositionAge if value.is_infinite() => "no valid position".to_owned(),
            Self::PositionAge => format!("no valid position for {value:.1} s"),
            Self::HeadingAge if value.is_infinite() => "no heading".to_owned(),
            Self::HeadingAge => format!("no heading for {value:.1} s"),
            Self::Estimator => format!("position estimate bad for {value:.1} s"),
            Self::NotANumber => format!("not a number for {value:.1} s"),
            Self::PositionJump => format!("the position jumped by {value:.0} m"),
            Self::Fence => format!("outside the fence by {value:.1} m"),
            Self::CrossTrack => format!("{value:.0} m off the path"),
            Self::GroundStation => format!("ground station silent for {value:.0} s"),
            Self::Battery => format!("battery at {value:.0} %"),
            Self::NoProgress => format!("no progress for {value:.0} s"),
            Self::Saturated => format!("actuators at their limit for {value:.0} s"),
            Self::LoopLate => format!("control loop late by {value:.1} s"),
            Self::Recording => "the recording cannot be written".to_owned(),
        }
    }
}
