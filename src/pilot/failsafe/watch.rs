//! Compares what is observed with the limits.

use helmlink_mission::geodesy::NorthEast;

use super::settings::FailsafeSettings;
use super::table::{Action, COUNT, DEFINITIONS, Failsafe};

/// Coming closer by less than this is no progress, metres: position noise is of that size.
const PROGRESS_STEP_M: f64 = 1.0;
/// A boat may have changed its speed this fast since the last position, m/s²: no jump.
const ACCELERATION_MPS2: f64 = 1.5;
/// Positions farther apart in time than this say nothing about a jump, seconds.
const LONGEST_GAP_S: f64 = 10.0;

/// A position with its time and velocity, in any frame that stays the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionFix {
    /// Vehicle time, seconds since boot.
    pub boot_s: f64,
    /// Place, metres.
    pub place: NorthEast,
    /// Velocity over ground, m/s.
    pub velocity: NorthEast,
}

/// Everything the failsafes look at, at one instant. What is unknown cannot trip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Age of the last valid position, seconds; infinite before the first.
    pub position_age_s: f64,
    /// Age of the last heading, seconds; infinite before the first.
    pub heading_age_s: f64,
    /// The estimator vouches for heading and position.
    pub estimator_ready: bool,
    /// The flight controller no longer takes the commands of the chosen output.
    pub output_refused: bool,
    /// The last position.
    pub fix: Option<PositionFix>,
    /// Age of the ground station's heartbeat, seconds; none while it has never been heard.
    pub ground_station_age_s: Option<f64>,
    /// Battery remaining, per cent.
    pub battery_percent: Option<f64>,
    /// Distance outside the fence, metres; zero inside; none without fence or position.
    pub fence_breach_m: Option<f64>,
    /// The last telemetry or command was not a number.
    pub not_a_number: bool,
    /// The recording cannot be written.
    pub recording_failed: bool,
    /// The bridge is driving; what follows counts only then.
    pub driving: bool,
    /// Distance from the path, metres.
    pub cross_track_m: f64,
    /// Way to go, metres; none while the boat waits at a waypoint.
    pub to_go_m: Option<f64>,
    /// An actuator is at its limit.
    pub saturated: bool,
    /// Time since the last control step, seconds.
    pub since_step_s: f64,
}

/// A limit that has been passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trip {
    /// Which one.
    pub failsafe: Failsafe,
    /// What is to be done.
    pub action: Action,
    /// The value that passed it.
    pub value: f64,
}

impl std::fmt::Display for Trip {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.failsafe.describe(self.value))
    }
}

/// What one look gave.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Verdict {
    /// The limit passed whose action is the strongest, warnings left out.
    pub trip: Option<Trip>,
    /// A limit passed just now about which only a warning is given.
    pub warning: Option<Trip>,
}

/// Keeps what a look needs to know of earlier ones.
#[derive(Debug, Clone)]
pub struct Watch {
    settings: FailsafeSettings,
    since_s: [Option<f64>; COUNT],
    warned: [bool; COUNT],
    last_fix: Option<PositionFix>,
    jump_m: f64,
    closest_m: Option<f64>,
}

impl Watch {
    /// A watch that has seen nothing.
    pub fn new(settings: FailsafeSettings) -> Self {
        Self {
            settings,
            since_s: [None; COUNT],
            warned: [false; COUNT],
            last_fix: None,
            jump_m: 0.0,
            closest_m: None,
        }
    }

    /// The settings in force.
    pub fn settings(&self) -> &FailsafeSettings {
        &self.settings
    }

    /// Other settings, from now on.
    pub fn configure(&mut self, settings: FailsafeSettings) {
        self.settings = settings;
    }

    /// The way to go is another one: progress is measured anew.
    pub fn on_new_way(&mut self) {
        self.closest_m = None;
        self.since_s[Failsafe::NoProgress as usize] = None;
    }

    /// Positions of the time before say nothing any more: the flight controller has restarted.
    pub fn forget_position(&mut self) {
        (self.last_fix, self.jump_m) = (None, 0.0);
    }

    /// Looks at everything at `now_s`. Warnings are given one a look, each once until it has passed.
    pub fn look(&mut self, now_s: f64, seen: &Observation) -> Verdict {
        self.note_fix(seen.fix);
        let mut verdict = Verdict::default();
        for definition in &DEFINITIONS {
            let failsafe = definition.failsafe;
            let limit = self.settings.limit(failsafe);
            let action = self.settings.action(failsafe);
            let tripped = self
                .measure(now_s, failsafe, seen)
                .filter(|value| if failsafe.trips_below() { *value < limit } else { *value > limit });
            let index = failsafe as usize;
            let Some(value) = tripped else {
                self.warned[index] = false;
                continue;
            };
            let trip = Trip { failsafe, action, value };
            if action != Action::Warn {
                verdict.trip = strongest(verdict.trip, trip);
            } else if verdict.warning.is_none() && !self.warned[index] {
                self.warned[index] = true;
                verdict.warning = Some(trip);
            }
        }
        verdict
    }

    /// The value to compare with the limit; none where it does not apply.
    fn measure(&mut self, now_s: f64, failsafe: Failsafe, seen: &Observation) -> Option<f64> {
        match failsafe {
            // The state machine sees these for itself, at once.
            Failsafe::LinkLost | Failsafe::Rebooted | Failsafe::ModeChanged | Failsafe::Disarmed => None,
            Failsafe::OutputRefused => seen.output_refused.then_some(f64::INFINITY),
            Failsafe::PositionAge => Some(seen.position_age_s),
            Failsafe::HeadingAge => Some(seen.heading_age_s),
            Failsafe::Estimator => self.lasting(now_s, failsafe, !seen.estimator_ready),
            Failsafe::NotANumber => self.lasting(now_s, failsafe, seen.not_a_number),
            Failsafe::PositionJump => seen.driving.then_some(self.jump_m),
            Failsafe::Fence => seen.fence_breach_m,
            Failsafe::CrossTrack => seen.driving.then_some(seen.cross_track_m.abs()),
            Failsafe::GroundStation => seen.ground_station_age_s,
            Failsafe::Battery => seen.battery_percent,
            Failsafe::NoProgress => self.without_progress_s(now_s, seen),
            Failsafe::Saturated => self.lasting(now_s, failsafe, seen.driving && seen.saturated),
            Failsafe::LoopLate => seen.driving.then_some(seen.since_step_s),
            Failsafe::Recording => seen.recording_failed.then_some(f64::INFINITY),
        }
    }

    /// For how long something has been so.
    fn lasting(&mut self, now_s: f64, failsafe: Failsafe, is_so: bool) -> Option<f64> {
        let since_s = &mut self.since_s[failsafe as usize];
        if is_so {
            Some(now_s - *since_s.get_or_insert(now_s))
        } else {
            *since_s = None;
            None
        }
    }

    fn without_progress_s(&mut self, now_s: f64, seen: &Observation) -> Option<f64> {
        let to_go_m = seen.to_go_m.filter(|_| seen.driving);
        let has_come_closer = match (to_go_m, self.closest_m) {
            (Some(to_go_m), Some(closest_m)) => to_go_m < closest_m - PROGRESS_STEP_M,
            _ => true,
        };
        if has_come_closer {
            self.closest_m = to_go_m;
            self.since_s[Failsafe::NoProgress as usize] = None;
        }
        self.lasting(now_s, Failsafe::NoProgress, to_go_m.is_some())
    }

    fn note_fix(&mut self, fix: Option<PositionFix>) {
        if let (Some(fix), Some(last)) = (fix, self.last_fix)
            && fix.boot_s > last.boot_s
        {
            let dt_s = fix.boot_s - last.boot_s;
            let led_to = last.place + (last.velocity + fix.velocity) * (0.5 * dt_s);
            let off_m = (fix.place - led_to).norm() - 0.5 * ACCELERATION_MPS2 * dt_s * dt_s;
            self.jump_m = if dt_s < LONGEST_GAP_S { off_m.max(0.0) } else { 0.0 };
        }
        self.last_fix = fix.or(self.last_fix);
    }
}

fn strongest(known: Option<Trip>, other: Trip) -> Option<Trip> {
    let rank = |trip: &Trip| trip.action as usize;
    match known {
        Some(known) if rank(&known) >= rank(&other) => Some(known),
        _ => Some(other),
    }
}

#[cfg(test)]
#[path = "watch_tests.rs"]
mod tests;
