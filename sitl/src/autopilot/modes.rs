//! The modes of ArduRover, and changing between them.

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::protocol::MissionType;
use helmlink_wire::enums::*;

use super::Autopilot;
use super::motion::Demand;
use super::navigation::{self, Leg, Report};
use super::parameters::*;

/// A mode that this autopilot can be in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Mode {
    /// Sticks to actuators.
    Manual,
    /// Sticks to turn rate and speed.
    Acro,
    /// As Acro, with the turn rate limited by the sideways acceleration.
    Steering,
    /// Motors off.
    Hold,
    /// Keep the place.
    Loiter,
    /// Around a point.
    Circle,
    /// Run the mission.
    Auto,
    /// Straight home, then keep the place.
    Rtl,
    /// Home along the way that was come.
    SmartRtl,
    /// As commanded over MAVLink.
    Guided,
    /// Starting up.
    Initialising,
}

/// The modes of a rover by the names that ground stations give them.
const NAMES: [(&str, u32); 14] = [
    ("MANUAL", ROVER_MODE_MANUAL),
    ("ACRO", ROVER_MODE_ACRO),
    ("STEERING", ROVER_MODE_STEERING),
    ("HOLD", ROVER_MODE_HOLD),
    ("LOITER", ROVER_MODE_LOITER),
    ("FOLLOW", ROVER_MODE_FOLLOW),
    ("SIMPLE", ROVER_MODE_SIMPLE),
    ("DOCK", ROVER_MODE_DOCK),
    ("CIRCLE", ROVER_MODE_CIRCLE),
    ("AUTO", ROVER_MODE_AUTO),
    ("RTL", ROVER_MODE_RTL),
    ("SMART_RTL", ROVER_MODE_SMART_RTL),
    ("GUIDED", ROVER_MODE_GUIDED),
    ("INITIALISING", ROVER_MODE_INITIALIZING),
];

/// The number of the mode with this name, in capitals or not.
pub(crate) fn mode_number(name: &str) -> Option<u32> {
    NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, number)| *number)
}

/// The name of the mode with this number.
pub(crate) fn mode_name(number: u32) -> Option<&'static str> {
    NAMES.iter().find(|(_, known)| *known == number).map(|(name, _)| *name)
}

/// Why a mode was not entered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(super) enum ModeRefusal {
    /// The number is no mode of a rover.
    #[error("No such mode {0}")]
    NoSuchMode(u32),
    /// The mode exists but not here or not now.
    #[error("Flight mode change failed")]
    NotNow,
    /// AUTO without a mission.
    #[error("No Mission. Can't set AUTO.")]
    NoMission,
}

impl Mode {
    /// The mode with this number.
    pub(super) fn from_number(number: u32) -> Result<Self, ModeRefusal> {
        Ok(match number {
            ROVER_MODE_MANUAL => Self::Manual,
            ROVER_MODE_ACRO => Self::Acro,
            ROVER_MODE_STEERING => Self::Steering,
            ROVER_MODE_HOLD => Self::Hold,
            ROVER_MODE_LOITER => Self::Loiter,
            ROVER_MODE_CIRCLE => Self::Circle,
            ROVER_MODE_AUTO => Self::Auto,
            ROVER_MODE_RTL => Self::Rtl,
            ROVER_MODE_SMART_RTL => Self::SmartRtl,
            ROVER_MODE_GUIDED => Self::Guided,
            // Modes of a rover that need what is not simulated: someone to follow, a dock, a second stick.
            ROVER_MODE_FOLLOW | ROVER_MODE_DOCK | ROVER_MODE_SIMPLE | ROVER_MODE_INITIALIZING => {
                return Err(ModeRefusal::NotNow);
            }
            other => return Err(ModeRefusal::NoSuchMode(other)),
        })
    }

    /// Its number in HEARTBEAT.custom_mode.
    pub(super) fn number(self) -> u32 {
        match self {
            Self::Manual => ROVER_MODE_MANUAL,
            Self::Acro => ROVER_MODE_ACRO,
            Self::Steering => ROVER_MODE_STEERING,
            Self::Hold => ROVER_MODE_HOLD,
            Self::Loiter => ROVER_MODE_LOITER,
            Self::Circle => ROVER_MODE_CIRCLE,
            Self::Auto => ROVER_MODE_AUTO,
            Self::Rtl => ROVER_MODE_RTL,
            Self::SmartRtl => ROVER_MODE_SMART_RTL,
            Self::Guided => ROVER_MODE_GUIDED,
            Self::Initialising => ROVER_MODE_INITIALIZING,
        }
    }

    /// Whether the autopilot navigates in it; such modes need a position.
    pub(super) fn is_autopilot(self) -> bool {
        matches!(self, Self::Loiter | Self::Circle | Self::Auto | Self::Rtl | Self::SmartRtl | Self::Guided)
    }

    /// Whether it needs the estimator's velocity at least.
    fn needs_estimate(self) -> bool {
        self.is_autopilot() || matches!(self, Self::Acro | Self::Steering)
    }

    /// Whether the boat may be armed in it.
    pub(super) fn may_arm(self) -> bool {
        !matches!(self, Self::Rtl | Self::SmartRtl | Self::Initialising)
    }

    /// MAV_MODE_FLAG bits of the mode, without the armed bit.
    pub(super) fn base_mode(self) -> u8 {
        MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
            | match self {
                Self::Manual | Self::Acro | Self::Steering | Self::Initialising => {
                    MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
                }
                Self::Hold => 0,
                _ => MAV_MODE_FLAG_GUIDED_ENABLED,
            }
    }
}

/// What the modes without a file of their own keep while they are in use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ModeState {
    /// LOITER: the place to keep. CIRCLE: the centre. RTL: home.
    point: NorthEast,
    /// RTL: the way home.
    leg: Leg,
    /// RTL: whether the boat has arrived.
    arrived: bool,
}

impl Default for ModeState {
    fn default() -> Self {
        let leg = Leg { from: NorthEast::ZERO, to: NorthEast::ZERO };
        Self { point: NorthEast::ZERO, leg, arrived: false }
    }
}

impl Autopilot {
    /// Enters a mode, or says on all links why not.
    pub(super) fn enter_mode_number(&mut self, number: u32) -> Result<(), ModeRefusal> {
        let outcome = Mode::from_number(number).and_then(|mode| self.enter_mode(mode));
        if let Err(refusal) = outcome {
            self.links.text(MAV_SEVERITY_WARNING, &refusal.to_string());
        }
        outcome
    }

    /// Enters a mode. While disarmed every mode of the boat is allowed, as on ArduRover; only AUTO always
    /// needs a mission.
    pub(super) fn enter_mode(&mut self, mode: Mode) -> Result<(), ModeRefusal> {
        if mode == self.mode {
            return Ok(());
        }
        if self.mode == Mode::Initialising && !self.is_initialised() {
            return Err(ModeRefusal::NotNow);
        }
        if self.armed && mode.needs_estimate() && !self.has_position() {
            return Err(ModeRefusal::NotNow);
        }
        if mode == Mode::Auto && self.mission_items().is_empty() {
            return Err(ModeRefusal::NoMission);
        }
        if mode == Mode::SmartRtl && self.armed && self.breadcrumbs.is_empty() {
            return Err(ModeRefusal::NotNow);
        }
        if self.mode == Mode::Auto {
            self.auto.pause();
        }
        self.mode = mode;
        self.report = None;
        self.begin(mode);
        Ok(())
    }

    /// Sets a mode up for where the boat is now.
    fn begin(&mut self, mode: Mode) {
        let motion = self.motion();
        let stop = navigation::stopping_point(&motion, &self.parameters);
        match mode {
            Mode::Loiter => self.mode_state.point = stop,
            Mode::Circle => {
                let radius_m = self.parameters.get(CIRC_RADIUS);
                let ahead = NorthEast::from_polar(radius_m, motion.heading_rad);
                self.mode_state.point = motion.position + ahead;
            }
            Mode::Rtl => {
                let leg = Leg { from: motion.position, to: self.best_rally_or_home() };
                self.mode_state = ModeState { point: leg.to, leg, arrived: false };
            }
            Mode::SmartRtl => {
                let to = self.breadcrumbs.next().unwrap_or_else(|| self.home_point());
                let leg = Leg { from: motion.position, to };
                self.mode_state = ModeState { point: self.home_point(), leg, arrived: false };
            }
            Mode::Guided => self.guided.begin(stop),
            Mode::Auto => self.auto.resume(self.parameters.int(MIS_RESTART) == 1),
            Mode::Manual | Mode::Acro | Mode::Steering | Mode::Hold | Mode::Initialising => {}
        }
    }

    /// What the mode asks of the boat now.
    pub(super) fn demand(&mut self) -> Demand {
        let motion = self.motion();
        let sticks = self.rc.sticks(self.now, &self.parameters);
        let (demand, report) = match self.mode {
            Mode::Manual => (Demand::Direct { steering: sticks.steering, throttle: sticks.throttle }, None),
            Mode::Acro | Mode::Steering => {
                let speed_mps = sticks.throttle * self.stick_speed_mps();
                let rate_radps = sticks.steering * self.parameters.get(ACRO_TURN_RATE).to_radians();
                let limit_radps = self.stick_turn_limit_radps(motion.speed_mps());
                let turn_rate_radps = match self.mode {
                    Mode::Acro => rate_radps,
                    _ => sticks.steering * limit_radps,
                };
                (Demand::Drive { turn_rate_radps, speed_mps }, None)
            }
            Mode::Hold | Mode::Initialising => (Demand::NEUTRAL, None),
            Mode::Loiter => with_report(navigation::hold(self.mode_state.point, &motion, &self.parameters)),
            Mode::Circle => {
                let clockwise = self.parameters.int(CIRC_DIR) == 0;
                with_report(navigation::circle(self.mode_state.point, clockwise, &motion, &self.parameters))
            }
            Mode::Rtl | Mode::SmartRtl => with_report(self.go_home()),
            Mode::Guided => self.guided_demand(),
            Mode::Auto => self.auto_demand(),
        };
        self.report = report;
        demand
    }

    /// The nearest rally point within RALLY_LIMIT_KM, or home if that is nearer and RALLY_INCL_HOME counts it in.
    fn best_rally_or_home(&self) -> NorthEast {
        let here = self.motion().position;
        let distance_m = |place: &NorthEast| (*place - here).norm();
        let limit_m = 1000.0 * self.parameters.get(RALLY_LIMIT_KM);
        let rally = self.missions.items(MissionType::Rally).iter().filter_map(|item| item.position());
        let near = |place: &NorthEast| limit_m == 0.0 || distance_m(place) <= limit_m;
        let home = (self.parameters.int(RALLY_INCL_HOME) == 1).then(|| self.home_point());
        let places = rally.map(|place| self.frame.to_local(place)).filter(near).chain(home);
        let nearest = places.min_by(|a, b| distance_m(a).total_cmp(&distance_m(b)));
        nearest.unwrap_or_else(|| self.home_point())
    }

    fn go_home(&mut self) -> (Demand, Report) {
        let motion = self.motion();
        if self.mode_state.arrived {
            return navigation::hold(self.mode_state.point, &motion, &self.parameters);
        }
        if self.mode_state.leg.is_done(&motion, self.parameters.get(WP_RADIUS)) {
            let next = if self.mode == Mode::SmartRtl { self.breadcrumbs.next() } else { None };
            match next {
                Some(to) => self.mode_state.leg = Leg { from: self.mode_state.leg.to, to },
                None => {
                    self.mode_state.arrived = true;
                    self.mode_state.point = self.mode_state.leg.to;
                    self.links.text(MAV_SEVERITY_INFO, "Reached destination");
                }
            }
        }
        let default_mps = navigation::default_speed_mps(&self.parameters);
        let speed_mps = navigation::positive_or(self.parameters.get(RTL_SPEED), default_mps);
        let last = self.mode == Mode::Rtl || self.breadcrumbs.is_empty();
        navigation::follow(&self.mode_state.leg, speed_mps, last, &motion, &self.parameters)
    }

    /// The speed of full throttle in the stabilised stick modes.
    fn stick_speed_mps(&self) -> f64 {
        self.parameters.get(CRUISE_SPEED) * 100.0 / self.parameters.get(CRUISE_THROTTLE)
    }

    /// The turn rate at which the sideways acceleration reaches ATC_TURN_MAX_G.
    fn stick_turn_limit_radps(&self, speed_mps: f64) -> f64 {
        let sideways_mps2 = self.parameters.get(ATC_TURN_MAX_G) * crate::physics::GRAVITY_MPS2;
        (sideways_mps2 / speed_mps.max(0.1)).min(self.parameters.get(ACRO_TURN_RATE).to_radians())
    }
}

fn with_report((demand, report): (Demand, Report)) -> (Demand, Option<Report>) {
    (demand, Some(report))
}

#[cfg(test)]
mod tests;
