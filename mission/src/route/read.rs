//! From mission items to a route: every item is understood first, then the mission is walked through.

use std::collections::HashMap;

use helmlink_wire::enums::*;

use super::walk::Walk;
use super::{Action, Circle, DEFAULT_CIRCLE_RADIUS_M, Route, RouteError};
use crate::geodesy::Geodetic;
use crate::plan::{CommandName, Item, Mission};

/// Commands that are passed on to the flight controller at their place in the mission.
const PASSED_ON: [u16; 25] = [
    MAV_CMD_DO_SET_HOME,
    MAV_CMD_DO_SET_RELAY,
    MAV_CMD_DO_REPEAT_RELAY,
    MAV_CMD_DO_SET_SERVO,
    MAV_CMD_DO_REPEAT_SERVO,
    MAV_CMD_DO_SET_ROI_LOCATION,
    MAV_CMD_DO_SET_ROI_NONE,
    MAV_CMD_DO_SET_ROI,
    MAV_CMD_DO_DIGICAM_CONFIGURE,
    MAV_CMD_DO_DIGICAM_CONTROL,
    MAV_CMD_DO_MOUNT_CONTROL,
    MAV_CMD_DO_SET_CAM_TRIGG_DIST,
    MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL,
    MAV_CMD_DO_FENCE_ENABLE,
    MAV_CMD_DO_GRIPPER,
    MAV_CMD_DO_SPRAYER,
    MAV_CMD_DO_SEND_SCRIPT_MESSAGE,
    MAV_CMD_DO_AUX_FUNCTION,
    MAV_CMD_DO_ENGINE_CONTROL,
    MAV_CMD_DO_WINCH,
    MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW,
    MAV_CMD_IMAGE_START_CAPTURE,
    MAV_CMD_IMAGE_STOP_CAPTURE,
    MAV_CMD_VIDEO_START_CAPTURE,
    MAV_CMD_VIDEO_STOP_CAPTURE,
];

/// Speeds of MAV_CMD_DO_CHANGE_SPEED with a meaning of their own.
const KEEP_SPEED: f32 = -1.0;
const USE_DEFAULT_SPEED: f32 = -2.0;
/// Repetitions of MAV_CMD_DO_JUMP that never end.
const FOR_EVER: f32 = -1.0;
/// More turns than this around a place are a slip of the keyboard.
const MOST_TURNS: f32 = 1000.0;
/// Circles smaller than this cannot be told from a point, metres.
const LEAST_RADIUS_M: f64 = 0.5;

impl Route {
    /// What `mission` means to a boat. `docs/missions.md` lists every command; yaw, altitude and autocontinue
    /// mean nothing to a boat, and ArduPilot's own boats ignore them.
    ///
    /// # Errors
    /// The first item that cannot be carried out, and what to do about it.
    pub fn from_mission(mission: &Mission) -> Result<Self, RouteError> {
        let count = mission.items.len();
        let tags = tags(&mission.items);
        let mut steps = Vec::with_capacity(count);
        for (index, item) in mission.items.iter().enumerate() {
            let number = u16::try_from(index + 1).map_err(|_| RouteError::TooLong(count))?;
            let here = Here { number, item };
            steps.push((here.command(), here.step(count, &tags)?));
        }
        Walk::through(mission.home.filter(|home| home.is_valid()), &steps)
    }
}

/// What one item asks for, checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    /// Go to a place; the place of the waypoint before where there is none.
    Visit(Visit),
    /// This speed from now on; none for the vehicle's own.
    Speed(Option<f64>),
    /// Wait, seconds.
    Delay(f64),
    /// Stern first from now on, or bow first.
    Reverse(bool),
    /// Something on the way.
    Do(Action),
    /// Go on with another item, so many times; none for ever.
    Jump { to: u16, times: Option<u32> },
    /// Nothing by itself.
    Nothing,
    /// Keep the position for ever, at a place or where the boat then is.
    Stay(Option<Geodetic>),
    /// Go home.
    Home,
}

/// Going to a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Visit {
    pub(super) place: Option<Geodetic>,
    pub(super) radius_m: Option<f64>,
    pub(super) hold_s: f64,
    pub(super) circle: Option<Circle>,
}

/// Sequence number of every tag.
fn tags(items: &[Item]) -> HashMap<u32, u16> {
    let numbered = (1..=u16::MAX).zip(items);
    numbered
        .filter(|(_, item)| item.command == MAV_CMD_JUMP_TAG)
        .map(|(number, item)| (item.params[0].to_bits(), number))
        .collect()
}

/// The item being read.
#[derive(Clone, Copy)]
struct Here<'a> {
    number: u16,
    item: &'a Item,
}

impl Here<'_> {
    fn step(self, count: usize, tags: &HashMap<u32, u16>) -> Result<Step, RouteError> {
        match self.item.command {
            MAV_CMD_NAV_WAYPOINT => self.waypoint(),
            MAV_CMD_NAV_LOITER_TIME => self.loiter_time(),
            MAV_CMD_NAV_LOITER_TURNS => self.loiter_turns(),
            MAV_CMD_NAV_LOITER_UNLIM => Ok(Step::Stay(self.place_or_here()?)),
            MAV_CMD_NAV_RETURN_TO_LAUNCH => Ok(Step::Home),
            MAV_CMD_NAV_DELAY => self.delay("delays until a time of day are not supported").map(Step::Delay),
            MAV_CMD_DO_CHANGE_SPEED => self.change_speed(),
            MAV_CMD_DO_SET_REVERSE => self.reverse(),
            MAV_CMD_CONDITION_DELAY => {
                self.delay("a condition cannot wait for the past").map(|s| Step::Do(Action::Delay(s)))
            }
            MAV_CMD_CONDITION_DISTANCE => {
                self.duration_or_length(0, "the distance").map(|m| Step::Do(Action::Distance(m)))
            }
            MAV_CMD_DO_JUMP => self.jump(count),
            MAV_CMD_DO_JUMP_TAG => self.jump_to_tag(tags),
            MAV_CMD_JUMP_TAG => Ok(Step::Nothing),
            command if PASSED_ON.contains(&command) => Ok(Step::Do(Action::Command(*self.item))),
            _ => Err(RouteError::Unsupported { item: self.number, command: self.command() }),
        }
    }

    fn waypoint(self) -> Result<Step, RouteError> {
        Ok(Step::Visit(Visit {
            place: Some(self.position()?),
            radius_m: Some(self.duration_or_length(1, "the acceptance radius")?).filter(|m| *m > 0.0),
            hold_s: self.duration_or_length(0, "the hold time")?,
            circle: None,
        }))
    }

    fn loiter_time(self) -> Result<Step, RouteError> {
        let hold_s = self.duration_or_length(0, "the time")?;
        Ok(Step::Visit(Visit { place: self.place_or_here()?, radius_m: None, hold_s, circle: None }))
    }

    fn loiter_turns(self) -> Result<Step, RouteError> {
        let turns = self.duration_or_length(0, "the number of turns")?;
        if turns > f64::from(MOST_TURNS) {
            return Err(self.fault("the number of turns", self.item.params[0], "at most 1000"));
        }
        let radius = self.item.params[2];
        if radius.is_infinite() {
            return Err(self.fault("the radius", radius, "metres, negative for turns to port"));
        }
        let radius_m =
            if radius.is_nan() || radius == 0.0 { DEFAULT_CIRCLE_RADIUS_M } else { f64::from(radius.abs()) };
        if radius_m < LEAST_RADIUS_M {
            return Err(self.fault("the radius", radius, "0 (the usual one) or at least 0.5 m"));
        }
        let clockwise = radius.is_nan() || radius >= 0.0;
        let circle = (turns > 0.0).then_some(Circle { radius_m, turns, clockwise });
        Ok(Step::Visit(Visit { place: self.place_or_here()?, radius_m: None, hold_s: 0.0, circle }))
    }

    fn change_speed(self) -> Result<Step, RouteError> {
        let [kind, speed_mps, ..] = self.item.params;
        let kinds = [SPEED_TYPE_AIRSPEED, SPEED_TYPE_GROUNDSPEED].map(f32::from);
        if !kinds.contains(&kind) {
            return Err(self.fault("the speed type", kind, "0 or 1: a boat has no climb or descent speed"));
        }
        if speed_mps > 0.0 && speed_mps.is_finite() {
            Ok(Step::Speed(Some(f64::from(speed_mps))))
        } else if speed_mps == USE_DEFAULT_SPEED {
            Ok(Step::Speed(None))
        } else if speed_mps == KEEP_SPEED {
            Ok(Step::Nothing)
        } else {
            let expected = "a speed above 0 m/s (−1 keeps the speed, −2 is the vehicle's own)";
            Err(self.fault("the speed", speed_mps, expected))
        }
    }

    fn reverse(self) -> Result<Step, RouteError> {
        match self.item.params[0] {
            0.0 => Ok(Step::Reverse(false)),
            1.0 => Ok(Step::Reverse(true)),
            other => Err(self.fault("the direction", other, "0 (bow first) or 1 (stern first)")),
        }
    }

    fn delay(self, why_not: &'static str) -> Result<f64, RouteError> {
        if self.item.params[0] < 0.0 {
            return Err(RouteError::Delay {
                item: self.number,
                command: self.command(),
                value: self.item.params[0],
                why_not,
            });
        }
        self.duration_or_length(0, "the delay")
    }

    fn jump(self, count: usize) -> Result<Step, RouteError> {
        let target = self.item.params[0];
        let exists = target.fract() == 0.0 && target >= 1.0 && f64::from(target) <= count as f64;
        if !exists || target == f32::from(self.number) {
            return Err(self.fault("the target", target, "the number of another item of this mission"));
        }
        Ok(Step::Jump { to: target as u16, times: self.times(1)? })
    }

    fn jump_to_tag(self, tags: &HashMap<u32, u16>) -> Result<Step, RouteError> {
        let tag = self.item.params[0];
        let to = tags.get(&tag.to_bits());
        let to = to.ok_or_else(|| self.fault("the tag", tag, "that of a MAV_CMD_JUMP_TAG (600)"))?;
        Ok(Step::Jump { to: *to, times: self.times(1)? })
    }

    fn times(self, index: usize) -> Result<Option<u32>, RouteError> {
        let times = self.item.params[index];
        if times == FOR_EVER {
            Ok(None)
        } else if times >= 0.0 && times.fract() == 0.0 && times <= 65535.0 {
            Ok(Some(times as u32))
        } else {
            Err(self.fault("the number of repetitions", times, "a whole number from 0 up, or −1 for ever"))
        }
    }

    fn command(self) -> CommandName {
        CommandName(self.item.command)
    }

    /// None at 0, 0: where the boat then is.
    fn place_or_here(self) -> Result<Option<Geodetic>, RouteError> {
        if self.item.x == 0 && self.item.y == 0 { Ok(None) } else { self.position().map(Some) }
    }

    fn position(self) -> Result<Geodetic, RouteError> {
        let [latitude_deg, longitude_deg] = self.item.coordinates();
        self.item.position().ok_or(RouteError::NoPosition {
            item: self.number,
            command: self.command(),
            frame: self.item.frame,
            latitude_deg,
            longitude_deg,
        })
    }

    /// A parameter of seconds, metres or turns, NaN meaning 0.
    fn duration_or_length(self, index: usize, parameter: &'static str) -> Result<f64, RouteError> {
        let value = self.item.params[index];
        if value.is_nan() {
            Ok(0.0)
        } else if value.is_finite() && value >= 0.0 {
            Ok(f64::from(value))
        } else {
            Err(self.fault(parameter, value, "a number from 0 up"))
        }
    }

    fn fault(self, parameter: &'static str, value: f32, expected: &'static str) -> RouteError {
        RouteError::Parameter { item: self.number, command: self.command(), parameter, value, expected }
    }
}
