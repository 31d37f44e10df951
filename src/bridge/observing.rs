//! What the failsafes see, gathered from everything the bridge hears.

use std::time::Duration;

use helmlink_mission::geodesy::LocalFrame;
use helmlink_wire::dialect::HEARTBEAT_DATA;
use helmlink_wire::{Identity, Message, enums};

use super::Bridge;
use super::fence::FenceKeeper;
use crate::control::Boat;
use crate::pilot::MissionRun;
use crate::pilot::failsafe::{Action, Failsafe, FailsafeSettings, Observation, PositionFix, Trip};
use crate::pilot::supervisor::{Conditions, State};
use crate::vehicle::ParameterReader;
use crate::vehicle::telemetry::{Position, Stamped};

/// What the bridge has noticed beside the telemetry.
#[derive(Debug, Default)]
pub(super) struct Observer {
    ground_station_heard: Option<Duration>,
    pub(super) fence: FenceKeeper,
    frame: Option<LocalFrame>,
    recording_failed: bool,
    /// The flight controller's parameters stand against steering it by the chosen output.
    pub(super) output_refused: bool,
    /// The last control step gave no number.
    pub(super) step_failed: bool,
    /// The flight controller has restarted, and the state machine has not been told yet.
    pub(super) rebooted: bool,
    /// When the control loop last stepped, or the drive began.
    pub(super) last_step: Option<Duration>,
    /// It has been said in this drive that somebody else steers too.
    pub(super) rival_told: bool,
    /// The limit passed at the last look.
    trip: Option<Trip>,
    /// The last position, and what became of it: looked at several times before the next one comes.
    fix: Option<(Position, PositionFix)>,
}

impl Observer {
    /// Notes a ground station's heartbeat, from whichever link.
    pub(super) fn on_heartbeat(&mut self, now: Duration, heartbeat: &HEARTBEAT_DATA) {
        if heartbeat.mavtype == enums::MAV_TYPE_GCS {
            self.ground_station_heard = Some(now);
        }
    }

    /// Another flight controller, or the same one restarted: positions and fences of before mean nothing.
    pub(super) fn forget_vehicle(&mut self) {
        self.fence.forget();
        self.frame = None;
        self.fix = None;
        self.last_step = None;
        self.output_refused = false;
    }

    fn fix(&mut self, position: Option<Stamped<Position>>) -> Option<PositionFix> {
        let position = position?.value;
        if let Some((known, fix)) = self.fix
            && known == position
        {
            return Some(fix);
        }
        let frame = self.frame.get_or_insert_with(|| LocalFrame::new(position.place));
        let velocity = helmlink_mission::geodesy::NorthEast::new(position.north_mps, position.east_mps);
        let fix = PositionFix { boot_s: position.boot_s, place: frame.to_local(position.place), velocity };
        self.fix = Some((position, fix));
        Some(fix)
    }
}

impl Bridge {
    /// The recording cannot be written any more; call it with `false` when it can again.
    pub fn set_recording_failed(&mut self, now: Duration, failed: bool) {
        self.record(|journal| journal.recording_failed(now, failed));
        self.advance(now);
        self.observer.recording_failed = failed;
        self.supervise();
    }

    /// Says once a drive that somebody else sends the boat the same kind of commands, as a ground station with a joystick
    /// does: it would obey both in turn.
    pub(super) fn watch_for_rivals(&mut self, from: Identity, message: &Message) {
        let output = self.settings.output;
        let steers = match message {
            Message::RC_CHANNELS_OVERRIDE(_) | Message::MANUAL_CONTROL(_) => {
                output.uses_sticks() && from.system == self.settings.ground_station_system
            }
            Message::SET_ATTITUDE_TARGET(_)
            | Message::SET_POSITION_TARGET_LOCAL_NED(_)
            | Message::SET_POSITION_TARGET_GLOBAL_INT(_) => !output.uses_sticks(),
            _ => false,
        };
        if !steers || self.supervisor.state() != State::Engaged {
            return;
        }
        if !std::mem::replace(&mut self.observer.rival_told, true) {
            let text = format!(
                "{from} steers the boat too, and it obeys both in turn: switch that off (a joystick in the ground \
                 station?), or change the mode to take over"
            );
            self.event(enums::MAV_SEVERITY_WARNING, text);
        }
    }

    /// Lets the failsafes look at everything.
    pub(super) fn look_out(&mut self) {
        let seen = self.observation();
        let verdict = self.watch.look(self.now.as_secs_f64(), &seen);
        self.observer.trip = verdict.trip;
        if let Some(warning) = verdict.warning {
            self.counts.on_failsafe(warning.failsafe);
            self.event(enums::MAV_SEVERITY_WARNING, warning.to_string());
        }
    }

    fn observation(&mut self) -> Observation {
        let now = self.now;
        let age_s = |then: Option<Duration>| then.map(|then| now.saturating_sub(then).as_secs_f64());
        let driving = self.supervisor.state() == State::Engaged;
        let diagnostics = &self.steering.diagnostics;
        let under_way = self.run.as_ref().filter(|run| run.path().is_some()).map(MissionRun::progress);
        let place = self.telemetry.position.map(|position| position.value.place);
        Observation {
            position_age_s: self.telemetry.position_age_s(now),
            heading_age_s: self.telemetry.heading_age_s(now),
            estimator_ready: self.telemetry.estimator_is_ready(now),
            output_refused: self.observer.output_refused,
            fix: self.observer.fix(self.telemetry.position),
            ground_station_age_s: age_s(self.observer.ground_station_heard),
            battery_percent: self.telemetry.battery_percent,
            fence_breach_m: place.and_then(|place| self.observer.fence.breach_m(place)),
            not_a_number: self.telemetry.attitude_refused || (driving && self.observer.step_failed),
            recording_failed: self.observer.recording_failed,
            driving,
            cross_track_m: under_way.map_or(0.0, |progress| progress.cross_track_m),
            to_go_m: under_way.map(|progress| progress.to_go_m),
            saturated: diagnostics.surge_saturated || diagnostics.yaw_saturated,
            since_step_s: age_s(self.observer.last_step).unwrap_or(0.0),
        }
    }

    /// The failsafes that hold for this boat on this vehicle.
    pub(super) fn failsafes_in_force(&self) -> FailsafeSettings {
        effective_failsafes(&self.settings.failsafes, &self.settings.boat, &self.parameters)
    }

    /// The control loop has not stepped in time.
    pub(super) fn loop_is_late(&self) -> bool {
        let limit_s = self.watch.settings().limit(Failsafe::LoopLate);
        let since = self.observer.last_step.map(|then| self.now.saturating_sub(then).as_secs_f64());
        since.is_some_and(|since_s| since_s > limit_s)
    }

    pub(super) fn conditions(&self) -> Conditions {
        let stale_s = self.settings.limits.stale_s;
        let fresh = self.telemetry.position_age_s(self.now) <= stale_s
            && self.telemetry.heading_age_s(self.now) <= stale_s;
        Conditions {
            heartbeat_age_s: self.telemetry.heartbeat_age_s(self.now),
            steady: fresh && self.telemetry.estimator_is_ready(self.now),
            mode: self.telemetry.mode(),
            armed: self.telemetry.is_armed(),
            rebooted: self.observer.rebooted,
            mission_there: self.run.is_some(),
            mission_current: self.mission.is_ready(),
            output_ready: self.output_ready,
            mission_complete: self.run.as_ref().is_some_and(|run| run.progress().complete),
            trip: self.observer.trip,
        }
    }
}

/// The failsafes, fitted to the boat and to what its owner has told the flight controller.
///
/// A large boat may be as far off its path as its turning radius.
///
/// The firmware's own check of the ground station's heartbeat (FS_GCS_ENABLE) counts override frames as one, so the
/// bridge's frames put it out of action. The bridge then watches in its place, unless the user has set the action.
fn effective_failsafes(
    settings: &FailsafeSettings,
    boat: &Boat,
    parameters: &ParameterReader,
) -> FailsafeSettings {
    let mut settings = settings.clone();
    if settings.cross_track.limit.is_none() {
        let usual_m = settings.limit(Failsafe::CrossTrack);
        settings.cross_track.limit = Some(usual_m.max(boat.limits.turn_radius_m));
    }
    let enabled = parameters.value("FS_GCS_ENABLE").is_some_and(|value| value > 0.0);
    if enabled && settings.ground_station.action.is_none() {
        settings.ground_station.action = Some(Action::HoldPosition);
        let timeout_s = parameters.value("FS_GCS_TIMEOUT").unwrap_or(f64::INFINITY);
        let (least_s, _) = Failsafe::GroundStation.definition().range;
        let limit_s = settings.limit(Failsafe::GroundStation).min(timeout_s).max(least_s);
        settings.ground_station.limit = Some(limit_s);
    }
    settings
}
