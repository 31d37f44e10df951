//! The safety state machine: when the bridge drives, and why it stops.
//!
//! ```text
//! Waiting ──► Ready ──► Engaging ──► Engaged ──► HandingBack ──► Ready | Holding | Finished | Stopped
//!    ▲          │                       │ pilot took over, disarmed, link lost, reboot: release at once
//!    └──────────┴───────────────────────┘
//! ```
//!
//! Doing nothing is the default. The machine leaves `Ready` only by an explicit act: a command to the bridge,
//! a configured mode chosen by the pilot, or the user's own `--engage`. Times are seconds of vehicle time.

use std::collections::VecDeque;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::vehicle::Mode;

/// Age limits and waiting times, in seconds of vehicle time.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
pub struct Limits {
    /// A flight controller whose heartbeat is older than this is gone.
    pub heartbeat_s: f64,
    /// A position older than this must not steer.
    pub position_s: f64,
    /// A heading older than this must not steer.
    pub heading_s: f64,
    /// How long a requested mode may take before the bridge gives up.
    pub mode_change_s: f64,
    /// How long the bridge waits for the motors to be armed when it was told to arm them.
    pub arming_s: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { heartbeat_s: 3.0, position_s: 1.0, heading_s: 1.0, mode_change_s: 3.0, arming_s: 30.0 }
    }
}

/// What the user allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Policy {
    /// The mode in which the chosen output is obeyed.
    pub drive_mode: Mode,
    /// Engage when the pilot changes into this mode.
    pub engage_mode: Option<Mode>,
    /// Arm the motors when engaging; never otherwise.
    pub may_arm: bool,
    /// The mode to leave the boat in when the mission is complete.
    pub end_mode: Mode,
    /// Age limits.
    pub limits: Limits,
}

/// Everything the machine looks at, at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Age of the last heartbeat, seconds; infinite before the first.
    pub heartbeat_age_s: f64,
    /// Age of the last position, seconds.
    pub position_age_s: f64,
    /// Age of the last heading, seconds.
    pub heading_age_s: f64,
    /// The flight controller's estimator vouches for position and heading.
    pub estimator_ready: bool,
    /// The mode of the last heartbeat.
    pub mode: Option<Mode>,
    /// The motors may turn.
    pub armed: bool,
    /// A mission has been read and can be driven.
    pub mission_ready: bool,
    /// The vehicle's parameters have been read, and the output can be used with them.
    pub output_ready: bool,
    /// The last waypoint has been reached.
    pub mission_complete: bool,
}

/// What somebody asks of the bridge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
pub enum Request {
    /// Drive the mission; waits for readiness and arming where `patient`.
    Engage {
        /// Keep the request until it can be carried out.
        patient: bool,
    },
    /// Stop the boat and keep the place in the mission.
    Pause,
    /// Stop the boat, let go, and end.
    Stop,
}

/// Where the machine is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// No flight controller, no position, or no mission yet.
    Waiting(Lack),
    /// Everything is there; the bridge sends no command.
    Ready,
    /// Told to drive: the mode or the motors are being prepared.
    Engaging,
    /// Driving.
    Engaged,
    /// Motors neutral until the final mode is confirmed, then release.
    HandingBack,
    /// Paused on request; the place in the mission is kept.
    Holding,
    /// The mission is complete and the boat has been let go.
    Finished,
    /// Ended on request.
    Stopped,
}

/// What the machine is waiting for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lack {
    /// A heartbeat of a boat's flight controller.
    Vehicle,
    /// The vehicle's parameters.
    Parameters,
    /// A mission.
    Mission,
    /// A valid position and heading.
    Position,
}

/// Why a state was left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reason {
    /// Something that was missing is still missing, or is missing again.
    Lacking(Lack),
    /// Everything needed is there.
    AllThere,
    /// A command, a mode or the user's flag said so.
    ToldTo,
    /// Mode and motors are as they must be.
    InControl,
    /// The mode was changed by somebody else.
    PilotTookOver(Mode),
    /// The motors were disarmed.
    Disarmed,
    /// The flight controller's heartbeat stopped.
    LinkLost,
    /// No valid position for too long; its age in seconds.
    PositionLost(f64),
    /// No heading for too long; its age in seconds.
    HeadingLost(f64),
    /// The flight controller's estimator no longer vouches for position or heading.
    EstimatorFailed,
    /// The mode was not changed in time.
    ModeRefused(Mode),
    /// The motors were not armed in time.
    ArmingRefused,
    /// The last waypoint was reached.
    MissionComplete,
    /// Asked to pause.
    Paused,
    /// Asked to stop.
    StopRequested,
    /// The boat has been let go.
    LetGo,
}

/// One change of state, for the log and the ground station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transition {
    /// The state that was left.
    pub from: State,
    /// The state that was entered.
    pub to: State,
    /// Why.
    pub reason: Reason,
}

/// What the bridge has to do now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Duty {
    /// Send no command at all.
    Nothing,
    /// Send what the controller wants.
    Drive,
    /// Send neutral.
    Neutral,
}

/// What a handing back leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Ending {
    mode: Option<Mode>,
    then: State,
}

/// The state machine.
#[derive(Debug, Clone)]
pub struct Supervisor {
    policy: Policy,
    state: State,
    since_s: f64,
    ending: Ending,
    waiting_request: bool,
    changed_mode: bool,
    seen_mode: Option<Mode>,
    let_go: bool,
    transitions: VecDeque<Transition>,
}

impl Supervisor {
    /// A machine that waits for a vehicle.
    pub fn new(policy: Policy) -> Self {
        Self {
            policy,
            state: State::Waiting(Lack::Vehicle),
            since_s: 0.0,
            ending: Ending { mode: None, then: State::Ready },
            waiting_request: false,
            changed_mode: false,
            seen_mode: None,
            let_go: false,
            transitions: VecDeque::new(),
        }
    }

    /// The present state.
    pub fn state(&self) -> State {
        self.state
    }

    /// What to send at this control step.
    pub fn duty(&self) -> Duty {
        match self.state {
            State::Engaged => Duty::Drive,
            State::HandingBack => Duty::Neutral,
            _ => Duty::Nothing,
        }
    }

    /// The mode that the vehicle should be asked for now, if it is in another one.
    pub fn wanted_mode(&self, conditions: &Conditions) -> Option<Mode> {
        let wanted = match self.state {
            State::Engaging => Some(self.policy.drive_mode),
            State::HandingBack => self.ending.mode,
            _ => None,
        };
        wanted.filter(|mode| conditions.mode != Some(*mode))
    }

    /// The motors should be asked to arm now.
    pub fn wants_arming(&self, conditions: &Conditions) -> bool {
        let in_mode = conditions.mode == Some(self.policy.drive_mode);
        self.state == State::Engaging && in_mode && self.policy.may_arm && !conditions.armed
    }

    /// The next change of state that has not been reported yet.
    pub fn poll_transition(&mut self) -> Option<Transition> {
        self.transitions.pop_front()
    }

    /// True once after the machine has decided to let go: the output's release must be sent.
    pub fn take_release(&mut self) -> bool {
        std::mem::take(&mut self.let_go)
    }

    /// Takes a request. The answer says whether it will be carried out.
    ///
    /// # Errors
    /// Why not, in words for the user.
    pub fn request(
        &mut self,
        now_s: f64,
        request: Request,
        conditions: &Conditions,
    ) -> Result<(), &'static str> {
        match request {
            Request::Engage { patient } => {
                let may_start = matches!(self.state, State::Ready | State::Holding | State::Finished);
                let refusal = match self.state {
                    State::Engaged | State::Engaging => return Ok(()),
                    State::Stopped => Some("the bridge has been stopped"),
                    State::HandingBack => Some("the bridge is just letting go: try again in a moment"),
                    _ if !may_start => Some("not ready: a vehicle, its mission or its position is missing"),
                    _ if !conditions.armed && !self.policy.may_arm => {
                        Some("the boat is not armed: arm it first")
                    }
                    _ => None,
                };
                match refusal {
                    None => self.engage(now_s),
                    Some(_) if patient => self.waiting_request = true,
                    Some(text) => return Err(text),
                }
                Ok(())
            }
            Request::Pause => {
                self.waiting_request = false;
                match self.state {
                    State::Engaged | State::Engaging => {
                        let ending = Ending { mode: Some(Mode::HOLD), then: State::Holding };
                        self.hand_back(now_s, ending, Reason::Paused);
                        Ok(())
                    }
                    State::Holding => Ok(()),
                    _ => Err("the bridge is not driving"),
                }
            }
            Request::Stop => {
                self.waiting_request = false;
                match self.state {
                    State::Engaged | State::Engaging | State::HandingBack => {
                        // A pilot who chose the mode keeps it; a mode that the bridge chose must not outlive it.
                        let mode = self.changed_mode.then_some(Mode::HOLD);
                        self.hand_back(now_s, Ending { mode, then: State::Stopped }, Reason::StopRequested);
                    }
                    _ => self.enter(now_s, State::Stopped, Reason::StopRequested),
                }
                Ok(())
            }
        }
    }

    /// Looks at the conditions; call it after every message and at every tick.
    pub fn update(&mut self, now_s: f64, conditions: &Conditions) {
        let chosen = self.pilot_chose_engage_mode(conditions);
        match self.state {
            State::Stopped => {}
            State::Waiting(_) => self.when_waiting(now_s, conditions),
            State::Ready | State::Holding | State::Finished => self.when_idle(now_s, chosen, conditions),
            State::Engaging => self.when_engaging(now_s, conditions),
            State::Engaged => self.when_engaged(now_s, conditions),
            State::HandingBack => self.when_handing_back(now_s, conditions),
        }
    }

    fn when_waiting(&mut self, now_s: f64, conditions: &Conditions) {
        match self.lack(conditions) {
            Some(lack) => self.enter(now_s, State::Waiting(lack), Reason::Lacking(lack)),
            None => self.enter(now_s, State::Ready, Reason::AllThere),
        }
    }

    fn when_idle(&mut self, now_s: f64, chosen: bool, conditions: &Conditions) {
        if let Some(lack) = self.lack(conditions) {
            // A finished or paused bridge stays so while the position comes and goes.
            if self.state == State::Ready || lack == Lack::Vehicle {
                self.enter(now_s, State::Waiting(lack), Reason::Lacking(lack));
            }
        } else if (chosen || self.waiting_request) && (conditions.armed || self.policy.may_arm) {
            self.engage(now_s);
        }
    }

    fn when_engaging(&mut self, now_s: f64, conditions: &Conditions) {
        let in_mode = conditions.mode == Some(self.policy.drive_mode);
        let waited_s = now_s - self.since_s;
        self.changed_mode |= !in_mode;
        if let Some(lack) = self.lack(conditions) {
            self.enter(now_s, State::Waiting(lack), Reason::Lacking(lack));
        } else if in_mode && conditions.armed {
            self.enter(now_s, State::Engaged, Reason::InControl);
        } else if !conditions.armed && !self.policy.may_arm {
            self.enter(now_s, State::Ready, Reason::Disarmed);
        } else if !in_mode && waited_s > self.policy.limits.mode_change_s {
            self.enter(now_s, State::Ready, Reason::ModeRefused(self.policy.drive_mode));
        } else if in_mode && waited_s > self.policy.limits.arming_s {
            self.enter(now_s, State::Ready, Reason::ArmingRefused);
        }
    }

    fn when_engaged(&mut self, now_s: f64, conditions: &Conditions) {
        let limits = self.policy.limits;
        if conditions.heartbeat_age_s > limits.heartbeat_s {
            return self.release(now_s, State::Waiting(Lack::Vehicle), Reason::LinkLost);
        }
        if let Some(mode) = conditions.mode.filter(|mode| *mode != self.policy.drive_mode) {
            return self.release(now_s, State::Ready, Reason::PilotTookOver(mode));
        }
        if !conditions.armed {
            return self.release(now_s, State::Ready, Reason::Disarmed);
        }
        if let Some(reason) = self.navigation_failure(conditions) {
            return self.hand_back(now_s, Ending { mode: Some(Mode::HOLD), then: State::Ready }, reason);
        }
        if conditions.mission_complete {
            let ending = Ending { mode: Some(self.policy.end_mode), then: State::Finished };
            self.hand_back(now_s, ending, Reason::MissionComplete);
        }
    }

    fn when_handing_back(&mut self, now_s: f64, conditions: &Conditions) {
        let gone = conditions.heartbeat_age_s > self.policy.limits.heartbeat_s;
        let confirmed = self.ending.mode.is_none_or(|mode| conditions.mode == Some(mode));
        let elsewhere = conditions.mode.is_some_and(|mode| mode != self.policy.drive_mode);
        let waited = now_s - self.since_s > self.policy.limits.mode_change_s;
        if gone || confirmed || elsewhere || waited {
            self.release(now_s, self.ending.then, Reason::LetGo);
        }
    }

    fn navigation_failure(&self, conditions: &Conditions) -> Option<Reason> {
        let limits = self.policy.limits;
        if conditions.position_age_s > limits.position_s {
            Some(Reason::PositionLost(conditions.position_age_s))
        } else if conditions.heading_age_s > limits.heading_s {
            Some(Reason::HeadingLost(conditions.heading_age_s))
        } else {
            (!conditions.estimator_ready).then_some(Reason::EstimatorFailed)
        }
    }

    fn lack(&self, conditions: &Conditions) -> Option<Lack> {
        let limits = self.policy.limits;
        if conditions.heartbeat_age_s > limits.heartbeat_s {
            Some(Lack::Vehicle)
        } else if !conditions.output_ready {
            Some(Lack::Parameters)
        } else if !conditions.mission_ready {
            Some(Lack::Mission)
        } else {
            self.navigation_failure(conditions).map(|_| Lack::Position)
        }
    }

    /// A change into the configured mode, seen as a change: a boat found in that mode has not been told anything.
    fn pilot_chose_engage_mode(&mut self, conditions: &Conditions) -> bool {
        let before = std::mem::replace(&mut self.seen_mode, conditions.mode);
        let changed = before.is_some() && before != conditions.mode;
        changed && self.policy.engage_mode.is_some() && conditions.mode == self.policy.engage_mode
    }

    fn engage(&mut self, now_s: f64) {
        self.waiting_request = false;
        self.changed_mode = false;
        self.enter(now_s, State::Engaging, Reason::ToldTo);
    }

    fn hand_back(&mut self, now_s: f64, ending: Ending, reason: Reason) {
        self.ending = ending;
        self.enter(now_s, State::HandingBack, reason);
    }

    fn release(&mut self, now_s: f64, to: State, reason: Reason) {
        self.let_go = true;
        self.enter(now_s, to, reason);
    }

    fn enter(&mut self, now_s: f64, to: State, reason: Reason) {
        if self.state != to {
            self.transitions.push_back(Transition { from: self.state, to, reason });
            self.state = to;
            self.since_s = now_s;
        }
    }
}

impl fmt::Display for Lack {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Vehicle => "waiting for a flight controller's heartbeat",
            Self::Parameters => "reading the flight controller's parameters",
            Self::Mission => "waiting for a mission",
            Self::Position => "waiting for a valid position and heading",
        })
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waiting(lack) => lack.fmt(f),
            Self::Ready => f.write_str("ready, not driving"),
            Self::Engaging => f.write_str("engaging"),
            Self::Engaged => f.write_str("driving the mission"),
            Self::HandingBack => f.write_str("stopping the boat"),
            Self::Holding => f.write_str("paused"),
            Self::Finished => f.write_str("mission complete"),
            Self::Stopped => f.write_str("stopped"),
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lacking(lack) => lack.fmt(f),
            Self::AllThere => f.write_str("vehicle, mission and position are there"),
            Self::ToldTo => f.write_str("told to engage"),
            Self::InControl => f.write_str("mode and motors are ready"),
            Self::PilotTookOver(mode) => write!(f, "the pilot took over ({mode})"),
            Self::Disarmed => f.write_str("the motors are disarmed"),
            Self::LinkLost => f.write_str("the flight controller's heartbeat stopped"),
            Self::PositionLost(age_s) => write!(f, "no valid position for {age_s:.1} s"),
            Self::HeadingLost(age_s) => write!(f, "no heading for {age_s:.1} s"),
            Self::EstimatorFailed => f.write_str("the flight controller's position estimate failed"),
            Self::ModeRefused(mode) => write!(f, "the flight controller did not change to {mode}"),
            Self::ArmingRefused => {
                f.write_str("the motors were not armed: see the flight controller's messages")
            }
            Self::MissionComplete => f.write_str("the last waypoint was reached"),
            Self::Paused => f.write_str("asked to pause"),
            Self::StopRequested => f.write_str("asked to stop"),
            Self::LetGo => f.write_str("the boat has been let go"),
        }
    }
}

#[cfg(test)]
#[path = "supervisor_tests.rs"]
mod tests;
