//! The safety state machine: when the bridge drives, and why it stops.
//!
//! ```text
//! Waiting ──► Ready ──► Engaging ──► Engaged ──► HandingBack ──► Ready | Holding | Finished | Stopped
//!    ▲ │        │                       │ pilot took over, disarmed, link lost, reboot: release at once
//!    │ └► Shadow                        │
//!    └──────────┴───────────────────────┘
//! ```
//!
//! Doing nothing is the default. The machine leaves `Ready` only by an explicit act: a command to the bridge,
//! a configured mode chosen by the pilot, or the user's own `--engage`. Times are seconds of vehicle time.
//!
//! | module | what it holds |
//! |---|---|
//! | [`state`] | the states, and what the bridge has to do in each |
//! | [`reason`] | requests, and why states are left |
//! | [`conditions`] | what is allowed, and what is looked at |

pub mod conditions;
pub mod reason;
pub mod state;

use std::collections::VecDeque;

pub use conditions::{Conditions, Limits, Policy};
pub use reason::{Reason, Request, Transition};
pub use state::{Duty, Lack, State};

use crate::pilot::failsafe::Action;
use crate::vehicle::Mode;

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
    /// When somebody last asked to engage.
    told_s: f64,
    ending: Ending,
    waiting_request: bool,
    changed_mode: bool,
    seen_mode: Option<Mode>,
    steady: bool,
    /// Asked to end for good.
    ended: bool,
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
            told_s: 0.0,
            ending: Ending { mode: None, then: State::Ready },
            waiting_request: false,
            changed_mode: false,
            seen_mode: None,
            steady: false,
            ended: false,
            let_go: false,
            transitions: VecDeque::new(),
        }
    }

    /// The mode to leave the boat in when the mission is complete, where the mission itself has a say in it.
    pub fn set_end_mode(&mut self, mode: Mode) {
        self.policy.end_mode = mode;
    }

    /// The present state.
    pub fn state(&self) -> State {
        self.state
    }

    /// What to send at this control step. Without a fresh position and heading an engaged boat is neutral.
    pub fn duty(&self) -> Duty {
        match self.state {
            State::Engaged if self.steady => Duty::Drive,
            State::Engaged | State::HandingBack => Duty::Neutral,
            _ => Duty::Nothing,
        }
    }

    /// The mode that the vehicle should be asked for now, if it is in another one.
    pub fn wanted_mode(&self, conditions: &Conditions) -> Option<Mode> {
        let wanted = match self.state {
            // Not before the mission is known: there may be no reason to change anything.
            State::Engaging if conditions.mission_current => Some(self.policy.drive_mode),
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
    pub fn request(&mut self, now_s: f64, request: Request, conditions: &Conditions) -> Result<(), String> {
        match request {
            Request::Engage { patient } => self.request_engaging(now_s, patient, conditions),
            Request::Pause => self.request_pause(now_s),
            Request::LetGo => {
                self.request_end(now_s);
                Ok(())
            }
            Request::Stop => {
                self.ended = true;
                self.request_end(now_s);
                Ok(())
            }
        }
    }

    fn request_engaging(&mut self, now_s: f64, patient: bool, conditions: &Conditions) -> Result<(), String> {
        if matches!(self.state, State::Engaged | State::Engaging) {
            return Ok(());
        }
        if self.ended || self.policy.shadow {
            let why = if self.ended { "the bridge has been stopped" } else { "the bridge runs in shadow" };
            return Err(why.to_owned());
        }
        match self.refusal(conditions) {
            None => self.engage(now_s),
            Some(_) if patient => self.waiting_request = true,
            Some(text) => return Err(text),
        }
        Ok(())
    }

    /// What stands against engaging now.
    fn refusal(&self, conditions: &Conditions) -> Option<String> {
        if self.state == State::HandingBack {
            return Some("the bridge is just letting go: try again in a moment".to_owned());
        }
        // The mission is read once more after the request.
        let settled = Conditions { mission_current: true, ..*conditions };
        if let Some(lack) = settled.lack(&self.policy.limits) {
            return Some(format!("not ready: {lack}"));
        }
        if matches!(self.state, State::Waiting(_)) {
            return Some("not ready: try again in a moment".to_owned());
        }
        if let Some(trip) = conditions.trip {
            return Some(trip.to_string());
        }
        let cannot_arm = !conditions.armed && !self.policy.may_arm;
        cannot_arm.then(|| "the boat is not armed: arm it first".to_owned())
    }

    fn request_pause(&mut self, now_s: f64) -> Result<(), String> {
        self.waiting_request = false;
        match self.state {
            State::Engaged | State::Engaging => {
                let ending = Ending { mode: Some(Mode::HOLD), then: State::Holding };
                self.hand_back(now_s, ending, Reason::Paused);
                Ok(())
            }
            State::Holding => Ok(()),
            _ => Err("the bridge is not driving".to_owned()),
        }
    }

    fn request_end(&mut self, now_s: f64) {
        self.waiting_request = false;
        match self.state {
            State::Engaged | State::Engaging => {
                // A pilot who chose the mode keeps it; a mode that the bridge chose must not outlive it.
                let mode = self.changed_mode.then_some(Mode::HOLD);
                self.hand_back(now_s, Ending { mode, then: State::Stopped }, Reason::StopRequested);
            }
            // The mode that was on its way stays so.
            State::HandingBack => self.ending.then = State::Stopped,
            _ => self.enter(now_s, State::Stopped, Reason::StopRequested),
        }
    }

    /// Looks at the conditions; call it after every message and at every tick.
    pub fn update(&mut self, now_s: f64, conditions: &Conditions) {
        let chosen = self.pilot_chose_engage_mode(conditions);
        self.steady = conditions.steady;
        match self.state {
            State::Stopped => {}
            State::Waiting(_) => self.when_waiting(now_s, conditions),
            State::Shadow => self.when_shadow(now_s, conditions),
            State::Ready | State::Holding | State::Finished => self.when_idle(now_s, chosen, conditions),
            State::Engaging => self.when_engaging(now_s, conditions),
            State::Engaged => self.when_engaged(now_s, conditions),
            State::HandingBack => self.when_handing_back(now_s, conditions),
        }
    }

    fn when_waiting(&mut self, now_s: f64, conditions: &Conditions) {
        match conditions.lack(&self.policy.limits) {
            Some(lack) => self.enter(now_s, State::Waiting(lack), Reason::Lacking(lack)),
            None if self.policy.shadow => self.enter(now_s, State::Shadow, Reason::AllThere),
            None => {
                let unarmed = self.waiting_request && !conditions.armed && !self.policy.may_arm;
                let reason = if unarmed { Reason::UntilArmed } else { Reason::AllThere };
                self.enter(now_s, State::Ready, reason);
            }
        }
    }

    fn when_shadow(&mut self, now_s: f64, conditions: &Conditions) {
        if let Some(lack) = conditions.lasting_lack(&self.policy.limits) {
            self.enter(now_s, State::Waiting(lack), Reason::Lacking(lack));
        }
    }

    fn when_idle(&mut self, now_s: f64, chosen: bool, conditions: &Conditions) {
        if let Some(lack) = conditions.lasting_lack(&self.policy.limits) {
            // A finished or paused bridge stays so while the position comes and goes.
            if self.state == State::Ready || lack == Lack::Vehicle {
                self.enter(now_s, State::Waiting(lack), Reason::Lacking(lack));
            }
        } else if (chosen || self.waiting_request) && self.refusal(conditions).is_none() {
            self.engage(now_s);
        }
    }

    fn when_engaging(&mut self, now_s: f64, conditions: &Conditions) {
        let in_mode = conditions.mode == Some(self.policy.drive_mode);
        if !conditions.mission_current && now_s - self.told_s <= self.policy.limits.arming_s {
            // The clocks for mode and arming start when the mission has been read.
            self.since_s = now_s;
        }
        let waited_s = now_s - self.since_s;
        self.changed_mode |= !in_mode;
        if conditions.heartbeat_age_s > self.policy.limits.heartbeat_s {
            self.enter(now_s, State::Waiting(Lack::Vehicle), Reason::LinkLost);
        } else if conditions.rebooted {
            self.enter(now_s, State::Waiting(Lack::Position), Reason::Rebooted);
        } else if let Some(trip) = conditions.trip {
            self.enter(now_s, State::Ready, Reason::Failsafe(trip));
        } else if !conditions.mission_there || !conditions.output_ready {
            let lack = if conditions.output_ready { Lack::Mission } else { Lack::Parameters };
            self.enter(now_s, State::Waiting(lack), Reason::Lacking(lack));
        } else if in_mode && conditions.armed && conditions.mission_current && conditions.steady {
            self.enter(now_s, State::Engaged, Reason::InControl);
        } else if !in_mode && waited_s > self.policy.limits.mode_change_s {
            self.enter(now_s, State::Ready, Reason::ModeRefused(self.policy.drive_mode));
        } else if !conditions.armed && !self.policy.may_arm {
            self.enter(now_s, State::Ready, Reason::Disarmed);
        } else if waited_s > self.policy.limits.arming_s {
            self.enter(now_s, State::Ready, Reason::ArmingRefused);
        }
    }

    fn when_engaged(&mut self, now_s: f64, conditions: &Conditions) {
        if conditions.heartbeat_age_s > self.policy.limits.heartbeat_s {
            return self.release(now_s, State::Waiting(Lack::Vehicle), Reason::LinkLost);
        }
        if conditions.rebooted || conditions.mode == Some(Mode::INITIALISING) {
            return self.release(now_s, State::Waiting(Lack::Position), Reason::Rebooted);
        }
        if let Some(mode) = conditions.mode.filter(|mode| *mode != self.policy.drive_mode) {
            return self.release(now_s, State::Ready, Reason::PilotTookOver(mode));
        }
        if !conditions.armed {
            return self.release(now_s, State::Ready, Reason::Disarmed);
        }
        if let Some(trip) = conditions.trip {
            return self.obey(now_s, trip.action, Reason::Failsafe(trip));
        }
        if !conditions.mission_there {
            return self.obey(now_s, Action::HoldPosition, Reason::MissionGone);
        }
        if conditions.mission_complete {
            let ending = Ending { mode: Some(self.policy.end_mode), then: State::Finished };
            self.hand_back(now_s, ending, Reason::MissionComplete);
        }
    }

    /// Ends a drive as a failsafe demands.
    fn obey(&mut self, now_s: f64, action: Action, reason: Reason) {
        let (mode, then) = match action {
            // Warnings never get this far.
            Action::Warn => return,
            Action::LetGo => return self.release(now_s, State::Ready, reason),
            Action::NeutralAndRelease => (Mode::HOLD, State::Ready),
            Action::HoldPosition => (Mode::LOITER, State::Holding),
            Action::ReturnToLaunch => (Mode::RTL, State::Ready),
        };
        self.hand_back(now_s, Ending { mode: Some(mode), then }, reason);
    }

    fn when_handing_back(&mut self, now_s: f64, conditions: &Conditions) {
        let gone = conditions.heartbeat_age_s > self.policy.limits.heartbeat_s || conditions.rebooted;
        let confirmed = self.ending.mode.is_none_or(|mode| conditions.mode == Some(mode));
        let elsewhere = conditions.mode.is_some_and(|mode| mode != self.policy.drive_mode);
        let waited = now_s - self.since_s > self.policy.limits.mode_change_s;
        if gone || confirmed || elsewhere || !conditions.armed {
            self.release(now_s, self.ending.then, Reason::LetGo);
        } else if waited && self.ending.mode.is_some_and(|mode| mode != Mode::HOLD) {
            // A mode that needs a position was refused. HOLD never is.
            self.ending.mode = Some(Mode::HOLD);
            self.since_s = now_s;
        } else if waited {
            self.release(now_s, self.ending.then, Reason::LetGo);
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
        self.told_s = now_s;
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

#[cfg(test)]
mod every_event;
#[cfg(test)]
mod tests;
