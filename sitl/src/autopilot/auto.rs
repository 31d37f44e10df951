//! AUTO: carrying out a mission, item by item.
//!
//! Commands that move the boat are done one after the other; those in between are done in passing. What this
//! boat has no use for (cameras, landing gear) is passed over.

use std::collections::BTreeMap;
use std::time::Duration;

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::{LocalFrame, NorthEast};
use helmlink_mission::plan::Item;
use helmlink_wire::enums::*;

use super::guided::is_usable;
use super::motion::{Demand, Motion};
use super::navigation::{self, Leg, Report};
use super::parameters::*;

/// A waypoint at which the boat stops counts as reached this close, m (or beyond it).
const STOP_RADIUS_M: f64 = 0.5;
/// Commands done in passing at once, so that jumps in a circle cannot hang the autopilot.
const COMMANDS_AT_ONCE: usize = 2000;

/// How far the mission is (MISSION_CURRENT.mission_state).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Progress {
    #[default]
    Stopped,
    Running,
    Complete,
}

/// Something that ground stations are told.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Event {
    /// MISSION_ITEM_REACHED.
    Reached(u16),
    /// STATUSTEXT.
    Text(String),
    /// The last item is done.
    Complete,
}

/// All that the mission depends on, apart from its own state.
pub(super) struct Situation<'a> {
    /// Item `n` has sequence number `n + 1`.
    pub(super) items: &'a [Item],
    pub(super) motion: Motion,
    pub(super) frame: &'a LocalFrame,
    pub(super) parameters: &'a Parameters,
    pub(super) home: NorthEast,
    pub(super) now: Duration,
}

/// What the boat is doing for the current item.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    /// Nothing yet.
    Begin,
    /// On its way; then staying for a while, or for ever (`None`).
    Leg { leg: Leg, stop: bool, stay_s: Option<f64> },
    /// Staying.
    Stay { place: NorthEast, until: Option<Duration> },
    /// Around a point for so many radians more.
    Circle { centre: NorthEast, clockwise: bool, left_rad: f64, bearing_rad: f64 },
    /// Waiting without moving.
    Wait { until: Duration },
    /// All done.
    Done { place: NorthEast },
}

/// State of the mission.
#[derive(Debug, Clone)]
pub(super) struct Auto {
    progress: Progress,
    /// Sequence number of the current item; 0 before the first start.
    current: u16,
    step: Step,
    /// Where the leg to the current item starts: the place before it.
    last_place: Option<NorthEast>,
    speed_mps: Option<f64>,
    /// Jumps made, by sequence number of the jump.
    jumps: BTreeMap<u16, u32>,
    events: Vec<Event>,
}

impl Default for Auto {
    fn default() -> Self {
        Self {
            progress: Progress::Stopped,
            current: 0,
            step: Step::Begin,
            last_place: None,
            speed_mps: None,
            jumps: BTreeMap::new(),
            events: Vec::new(),
        }
    }
}

impl Auto {
    pub(super) fn progress(&self) -> Progress {
        self.progress
    }

    /// Sequence number of the current item.
    pub(super) fn current(&self) -> u16 {
        self.current
    }

    /// Begins at the current item, or at the first if the mission is over or `restart` says so.
    pub(super) fn resume(&mut self, restart: bool) {
        if restart || self.progress == Progress::Complete {
            *self = Self { events: std::mem::take(&mut self.events), ..Self::default() };
        }
        self.progress = Progress::Stopped;
        self.start_here();
    }

    /// Stops where it is; [`Auto::resume`] goes on with the current item.
    pub(super) fn pause(&mut self) {
        if self.progress == Progress::Running {
            self.progress = Progress::Stopped;
        }
        self.speed_mps = None;
    }

    /// Makes an item the current one.
    pub(super) fn set_current(&mut self, seq: u16) {
        self.current = seq;
        self.jumps.clear();
        self.progress = Progress::Stopped;
        self.start_here();
    }

    /// The items have been replaced; true if that changes what the boat is doing.
    pub(super) fn items_changed(&mut self, count: usize) -> bool {
        let was_running = self.progress == Progress::Running;
        self.jumps.clear();
        if usize::from(self.current) > count {
            self.current = 0;
        }
        self.progress = Progress::Stopped;
        self.start_here();
        was_running
    }

    /// The speed toward waypoints from now on.
    pub(super) fn set_speed(&mut self, speed_mps: f64) {
        self.speed_mps = Some(speed_mps);
    }

    /// What has happened since the last call.
    pub(super) fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    fn start_here(&mut self) {
        self.step = Step::Begin;
        self.last_place = None;
    }

    /// One loop of the mission. Call only while armed.
    pub(super) fn update(&mut self, situation: &Situation) -> (Demand, Option<Report>) {
        if self.progress != Progress::Complete {
            self.progress = Progress::Running;
        }
        if self.step == Step::Begin {
            self.start_from(self.current, situation);
        }
        self.check_step(situation);
        self.demand(situation)
    }

    /// Does the commands from `seq` on up to the next one that moves the boat, and starts that one.
    fn start_from(&mut self, seq: u16, situation: &Situation) {
        let mut seq = seq.max(1);
        for _ in 0..COMMANDS_AT_ONCE {
            let Some(item) = item(situation.items, seq) else { break };
            match item.command {
                MAV_CMD_DO_JUMP => {
                    seq = if self.takes_jump(seq, item) { item.params[0] as u16 } else { seq + 1 };
                    continue;
                }
                MAV_CMD_DO_CHANGE_SPEED if item.params[1] > 0.0 => {
                    self.speed_mps = Some(f64::from(item.params[1]));
                }
                _ => {}
            }
            if let Some(step) = self.step_for(seq, item, situation) {
                self.current = seq;
                self.step = step;
                return;
            }
            seq = seq.saturating_add(1);
        }
        self.complete(situation);
    }

    fn complete(&mut self, situation: &Situation) {
        let place = navigation::stopping_point(&situation.motion, situation.parameters);
        self.step = Step::Done { place };
        self.progress = Progress::Complete;
        self.events.push(Event::Complete);
        self.events.push(Event::Text("Mission Complete".to_owned()));
    }

    /// Counts a jump; false when it has been made often enough. A negative number is for ever.
    fn takes_jump(&mut self, seq: u16, item: &Item) -> bool {
        let made = self.jumps.entry(seq).or_insert(0);
        let often = f64::from(*made) < f64::from(item.params[1]) || item.params[1] < 0.0;
        if often {
            *made = made.saturating_add(1);
        }
        often
    }

    /// How the boat carries out an item; `None` if the item does not move it.
    fn step_for(&mut self, seq: u16, item: &Item, situation: &Situation) -> Option<Step> {
        let here = situation.motion.position;
        let place = item.position().filter(|place| is_usable(*place));
        let place = place.map_or(here, |place| situation.frame.to_local(place));
        let from = self.last_place.unwrap_or(here);
        let seconds = f64::from(item.params[0]).clamp(0.0, 1e6); // NaN stays NaN: no time at all
        let leg = |stop: bool, stay_s: Option<f64>| Step::Leg { leg: Leg { from, to: place }, stop, stay_s };
        let step = match item.command {
            MAV_CMD_NAV_WAYPOINT | MAV_CMD_NAV_SPLINE_WAYPOINT => {
                let stop = seconds > 0.0 || self.is_last_place(seq, situation.items);
                leg(stop, Some(seconds))
            }
            MAV_CMD_NAV_LOITER_UNLIM => leg(true, None),
            MAV_CMD_NAV_LOITER_TIME => leg(true, Some(seconds)),
            MAV_CMD_NAV_LOITER_TURNS => Step::Circle {
                centre: place,
                // A negative radius circles the other way.
                clockwise: item.params[2].is_nan() || item.params[2] >= 0.0,
                left_rad: f64::from(item.params[0]).max(0.0) * std::f64::consts::TAU,
                bearing_rad: (here - place).bearing_rad(),
            },
            MAV_CMD_NAV_RETURN_TO_LAUNCH => {
                Step::Leg { leg: Leg { from: here, to: situation.home }, stop: true, stay_s: Some(0.0) }
            }
            MAV_CMD_NAV_DELAY => Step::Wait { until: situation.now + duration(seconds) },
            _ => return None,
        };
        if let Step::Leg { leg, .. } = step {
            self.last_place = Some(leg.to);
        }
        Some(step)
    }

    /// Whether the boat does not go on to another waypoint right after this one.
    fn is_last_place(&self, seq: u16, items: &[Item]) -> bool {
        let mut next = seq.saturating_add(1);
        while let Some(item) = item(items, next) {
            match item.command {
                MAV_CMD_NAV_WAYPOINT | MAV_CMD_NAV_SPLINE_WAYPOINT | MAV_CMD_NAV_LOITER_TURNS => {
                    return false;
                }
                MAV_CMD_NAV_LOITER_UNLIM
                | MAV_CMD_NAV_LOITER_TIME
                | MAV_CMD_NAV_RETURN_TO_LAUNCH
                | MAV_CMD_NAV_DELAY => return true,
                MAV_CMD_DO_JUMP => {
                    let made = self.jumps.get(&next).copied().unwrap_or(0);
                    if item.params[1] < 0.0 || f64::from(made) < f64::from(item.params[1]) {
                        return false;
                    }
                }
                _ => {}
            }
            next = next.saturating_add(1);
        }
        true
    }

    /// Goes on when the current step is done.
    fn check_step(&mut self, situation: &Situation) {
        let (motion, now) = (&situation.motion, situation.now);
        match &mut self.step {
            Step::Leg { leg, stop, stay_s } => {
                let radius_m = situation.parameters.get(WP_RADIUS);
                let radius_m = if *stop { radius_m.min(STOP_RADIUS_M) } else { radius_m };
                if !leg.is_done(motion, radius_m) {
                    return;
                }
                let (place, stay_s) = (leg.to, *stay_s);
                match stay_s {
                    Some(seconds) if seconds > 0.0 => {
                        let text =
                            format!("Reached waypoint #{}. Loiter for {seconds:.0} seconds", self.current);
                        self.events.push(Event::Text(text));
                        self.step = Step::Stay { place, until: Some(now + duration(seconds)) };
                    }
                    Some(_) => {
                        self.events.push(Event::Text(format!("Reached waypoint #{}", self.current)));
                        self.finish_item(situation);
                    }
                    None => self.step = Step::Stay { place, until: None },
                }
            }
            Step::Stay { until: Some(until), .. } | Step::Wait { until } if now >= *until => {
                self.finish_item(situation);
            }
            Step::Circle { centre, clockwise, left_rad, bearing_rad } => {
                let bearing_now_rad = (motion.position - *centre).bearing_rad();
                let turned_rad = ssa(bearing_now_rad - *bearing_rad);
                *left_rad -= if *clockwise { turned_rad } else { -turned_rad };
                *bearing_rad = bearing_now_rad;
                if *left_rad <= 0.0 {
                    self.last_place = None;
                    self.finish_item(situation);
                }
            }
            Step::Begin | Step::Stay { .. } | Step::Wait { .. } | Step::Done { .. } => {}
        }
    }

    fn finish_item(&mut self, situation: &Situation) {
        self.events.push(Event::Reached(self.current));
        self.start_from(self.current.saturating_add(1), situation);
    }

    fn demand(&self, situation: &Situation) -> (Demand, Option<Report>) {
        let (motion, parameters) = (&situation.motion, situation.parameters);
        let speed_mps = self.speed_mps.unwrap_or_else(|| navigation::default_speed_mps(parameters));
        let (demand, report) = match self.step {
            Step::Leg { leg, stop, .. } => navigation::follow(&leg, speed_mps, stop, motion, parameters),
            Step::Stay { place, .. } => navigation::hold(place, motion, parameters),
            Step::Circle { centre, clockwise, .. } => {
                navigation::circle(centre, clockwise, motion, parameters)
            }
            // MIS_DONE_BEHAVE: 1 keeps the place, all others stop.
            Step::Done { place } if parameters.int(MIS_DONE_BEHAVE) == 1 => {
                navigation::hold(place, motion, parameters)
            }
            Step::Begin | Step::Wait { .. } | Step::Done { .. } => return (Demand::Stop, None),
        };
        (demand, Some(report))
    }
}

/// The item with sequence number `seq`.
fn item(items: &[Item], seq: u16) -> Option<&Item> {
    items.get(usize::from(seq).checked_sub(1)?)
}

/// Seconds as a duration; nothing for what is no length of time.
fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or_default()
}

#[cfg(test)]
mod tests;
