//! One control step: supervise, compute, send.

use helmlink_mission::plan::CommandName;
use helmlink_mission::route::Action;
use helmlink_wire::{Message, enums};

use super::pace::Pace;
use super::{Bridge, CHANGE_LIMIT, REQUEST_REPEAT, Status, Vehicle, controller_state};
use crate::control::Diagnostics;
use crate::pilot::MissionRun;
use crate::pilot::supervisor::{Conditions, Duty, Reason, State, Transition};
use crate::record::ControlState;
use crate::vehicle::estimate::vessel_state;
use crate::vehicle::output::Demand;
use crate::vehicle::streams::{command_long, set_mode};

/// How many frames let go of the boat: an override that outlives its sender is worse than a frame too many.
const RELEASE_FRAMES: usize = 2;
/// The boat hears from the bridge at least this often while it is driven, seconds.
const REPEAT_S: f64 = 0.09;

/// What the last control steps gave.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steering {
    pub(super) demand: Demand,
    pub(super) diagnostics: Diagnostics,
    pub(super) steps: u64,
    pub(super) thought: Option<ControlState>,
    pub(super) pace: Pace,
    /// Driving is interrupted until a fresh position comes.
    coasting: bool,
}

impl Default for Steering {
    fn default() -> Self {
        Self {
            demand: Demand::NEUTRAL,
            diagnostics: Diagnostics::default(),
            steps: 0,
            thought: None,
            pace: Pace::default(),
            coasting: false,
        }
    }
}

impl Bridge {
    /// Lets the state machine look at the conditions, and does at once what it decides.
    pub(super) fn supervise(&mut self) {
        self.look_out();
        let now_s = self.now.as_secs_f64();
        let conditions = self.conditions();
        self.observer.rebooted = false;
        self.supervisor.update(now_s, &conditions);
        while let Some(transition) = self.supervisor.poll_transition() {
            self.on_transition(transition);
        }
        let Some(vehicle) = self.vehicle else { return };
        if self.supervisor.take_release() {
            self.let_go(vehicle);
        }
        self.prepare(vehicle, &conditions);
    }

    fn on_transition(&mut self, transition: Transition) {
        let severity = match transition.to {
            _ if matches!(transition.reason, Reason::Failsafe(_)) => enums::MAV_SEVERITY_CRITICAL,
            State::Waiting(_) if transition.from == State::Engaged => enums::MAV_SEVERITY_CRITICAL,
            State::HandingBack if transition.reason == Reason::MissionComplete => enums::MAV_SEVERITY_INFO,
            State::HandingBack | State::Ready if transition.from == State::Engaged => {
                enums::MAV_SEVERITY_WARNING
            }
            _ => enums::MAV_SEVERITY_INFO,
        };
        self.event(severity, transition.describe());
        self.reason = Some(transition.reason);
        if self.changes.len() >= CHANGE_LIMIT {
            self.changes.pop_front();
        }
        self.changes.push_back(Status { state: transition.to, ..self.status() });
        if let Some(failsafe) = transition.reason.failsafe().filter(|_| transition.from == State::Engaged) {
            self.counts.on_failsafe(failsafe);
        }
        match transition.to {
            State::Engaging => self.begin_again_if_complete(),
            State::Engaged => {
                self.observer.last_step = Some(self.now);
                self.steering.coasting = false;
                self.observer.rival_told = false;
                self.watch.on_new_way();
                self.engage_run();
            }
            State::HandingBack => self.send_demand(Demand::NEUTRAL),
            _ => {}
        }
        if transition.to != State::Engaged {
            self.current.clear();
        }
        if transition.from == State::Engaged && transition.reason != Reason::MissionComplete {
            self.actions.clear();
        }
        if !matches!(transition.to, State::Engaged | State::HandingBack) {
            self.steering.pace.pause();
        }
    }

    fn begin_again_if_complete(&mut self) {
        if let Some(run) = self.run.as_mut().filter(|run| run.progress().complete) {
            run.jump_to(0);
        }
    }

    pub(super) fn engage_run(&mut self) {
        let Some(run) = &mut self.run else { return };
        if let Some((_, state)) = vessel_state(&self.telemetry, run.frame())
            && let Err(error) = run.engage(&state)
        {
            self.event(enums::MAV_SEVERITY_ERROR, error.to_string());
        }
    }

    /// Asks for the mode and the arming that the state machine wants.
    fn prepare(&mut self, vehicle: Vehicle, conditions: &Conditions) {
        let message = if let Some(mode) = self.supervisor.wanted_mode(conditions) {
            set_mode(vehicle.id, mode)
        } else if self.supervisor.wants_arming(conditions) {
            command_long(vehicle.id, enums::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0])
        } else {
            self.last_request = None;
            return;
        };
        if self.last_request.is_none_or(|then| self.now.saturating_sub(then) >= REQUEST_REPEAT) {
            self.last_request = Some(self.now);
            let own = self.own(vehicle.id);
            self.links.send(vehicle.link, own, &message);
        }
    }

    /// New telemetry is there: one turn of the control loop.
    pub(super) fn control_step(&mut self) {
        self.supervise();
        match self.supervisor.duty() {
            Duty::Drive => self.drive(),
            Duty::Neutral => {
                self.steering.coasting |= self.supervisor.state() == State::Engaged;
                self.send_demand(Demand::NEUTRAL);
            }
            Duty::Nothing if self.settings.shadow => {
                self.compute();
            }
            Duty::Nothing => {}
        }
    }

    fn drive(&mut self) {
        if std::mem::take(&mut self.steering.coasting) {
            // What the law has integrated belongs to the time before the gap.
            self.engage_run();
        }
        let demand = self.compute().unwrap_or(Demand::NEUTRAL);
        self.send_demand(demand);
        if let Some(item) = self.run.as_ref().and_then(current_item) {
            self.current.set(item);
        }
        // The last waypoint may have been reached with this very step.
        self.supervise();
    }

    /// What the pilot wants now; `None` when it cannot say.
    fn compute(&mut self) -> Option<Demand> {
        self.observer.last_step = Some(self.now);
        let run = self.run.as_mut()?;
        let (boot_s, state) = vessel_state(&self.telemetry, run.frame())?;
        match run.step(boot_s, &state) {
            Ok(step) => {
                self.observer.step_failed = false;
                self.steering.demand = step.demand;
                self.steering.diagnostics = step.diagnostics;
                self.steering.steps += 1;
                let progress = run.progress();
                let thought = ControlState::new(boot_s, &state, &progress, &step.demand, &step.diagnostics);
                self.steering.thought = Some(thought);
                self.record(|journal| {
                    let named = controller_state::messages(boot_s, &step.diagnostics, &step.demand);
                    journal.stepped(&thought, named);
                });
                for index in step.reached.0..step.reached.1 {
                    // A mission that repeats itself has a longer way to go again.
                    self.watch.on_new_way();
                    self.on_waypoint_reached(index);
                }
                self.pass_on_tasks();
                Some(step.demand)
            }
            Err(error) => {
                self.observer.step_failed = true;
                self.counts.controller_errors += 1;
                let text = error.to_string();
                if self.reporter.is_new_problem(&text) {
                    self.event(enums::MAV_SEVERITY_ERROR, text);
                }
                None
            }
        }
    }

    /// Hands what the mission asks of the flight controller here to those who send it.
    fn pass_on_tasks(&mut self) {
        while let Some(task) = self.run.as_mut().and_then(MissionRun::pop_due_task) {
            let Action::Command(command) = task.action else { continue };
            if self.settings.shadow {
                let name = CommandName(command.command);
                self.event(enums::MAV_SEVERITY_INFO, format!("item {}: {name} would be sent", task.item));
            } else {
                self.actions.push(task.item, command);
            }
        }
    }

    pub(super) fn send_demand(&mut self, demand: Demand) {
        let Some(vehicle) = self.vehicle else { return };
        self.steering.demand = demand;
        self.steering.pace.on_frame(self.now);
        let message = self.output.drive(self.now.as_secs_f64(), vehicle.id, demand);
        self.send_command(vehicle, &message);
    }

    /// Repeats the last command when no telemetry has come to compute another one from: a flight controller
    /// without a radio receiver lets an override fall after half a second. The state machine ends it in time.
    pub(super) fn keep_sending(&mut self) {
        let is_due = self.steering.pace.age_s(self.now).is_none_or(|age_s| age_s >= REPEAT_S);
        match self.supervisor.duty() {
            Duty::Drive if is_due && self.steering.pace.age_s(self.now).is_some() => {
                self.send_demand(self.steering.demand);
            }
            Duty::Neutral if is_due => {
                self.steering.coasting |= self.supervisor.state() == State::Engaged;
                self.send_demand(Demand::NEUTRAL);
            }
            _ => {}
        }
    }

    pub(super) fn let_go(&mut self, vehicle: Vehicle) {
        self.steering.demand = Demand::NEUTRAL;
        if let Some(message) = self.output.release(vehicle.id) {
            for _ in 0..RELEASE_FRAMES {
                self.send_command(vehicle, &message);
            }
        }
    }

    fn send_command(&mut self, vehicle: Vehicle, message: &Message) {
        let from = self.settings.steering_identity(self.own(vehicle.id));
        self.links.command(vehicle.link, from, message);
    }
}

/// The mission item that the boat is under way to.
pub(super) fn current_item(run: &MissionRun) -> Option<u16> {
    run.route().waypoints.get(run.progress().next).map(|waypoint| waypoint.item)
}
