//! A recorded boat through the controller: what would it have commanded?
//!
//! The boat goes where it went, whatever the controller says: this is an open loop. It shows how the controller judges
//! each situation, not how the boat would have moved; for that there is the simulator.

mod marks;
mod moment;
mod result;
mod settings;

use std::collections::VecDeque;

use helmlink_mission::geodesy::{LocalFrame, NorthEast};
use helmlink_mission::plan::Mission;
use helmlink_mission::route::Route;
use helmlink_wire::dialect::PARAM_VALUE_DATA;
use helmlink_wire::{Encoder, Identity, Message, enums};
use sha2::{Digest, Sha256};

use self::marks::{Marks, leg_error_m};
pub use self::moment::{Moment, Sink};
pub use self::result::{Comparison, WhatIfResult};
pub use self::settings::{WhatIfSettings, Window};
use super::missions::Transferred;
use super::proof::hex;
use super::servo::Outputs;
use super::watch::{Sight, Watch};
use crate::bridge::settings::COMPONENT;
use crate::pilot::{MissionRun, RunSettings};
use crate::record::ControlState;
use crate::vehicle::ParameterReader;
use crate::vehicle::estimate::vessel_state;
use crate::vehicle::output::{self, Demand, Output};

/// A place in the mission that differs from the vehicle's own by this many waypoints is given up for the vehicle's.
const OUT_OF_STEP: usize = 2;
/// After so long, vehicle seconds.
const OUT_OF_STEP_S: f64 = 3.0;
/// A command that a bridge has recorded is in force for so long, vehicle seconds.
const COMMAND_AGE_S: f64 = 1.0;

/// Feeds a log to the controller, message by message.
pub struct WhatIf {
    settings: WhatIfSettings,
    vehicle: Identity,
    watch: Option<Watch>,
    /// Missions of the log that have not come into force yet.
    missions: VecDeque<Transferred>,
    run: Option<MissionRun>,
    frame: Option<LocalFrame>,
    output: Output,
    encoder: Encoder,
    commands: Sha256,
    was_driven: bool,
    last_s: Option<f64>,
    first_s: Option<f64>,
    out_of_step_since_s: Option<f64>,
    /// Waypoint that the vehicle is under way to, once it has said so.
    current: Option<usize>,
    recorded_thought: Option<ControlState>,
    marks: Marks,
    speed_mps: f64,
    result: WhatIfResult,
    faults: Vec<String>,
}

impl WhatIf {
    /// A replay of `vehicle`, whose attitude comes every `interval_s` seconds; `missions` and `parameters` are
    /// those that a scan has found in the log.
    pub fn new(
        settings: WhatIfSettings,
        vehicle: Identity,
        interval_s: f64,
        missions: Vec<Transferred>,
        parameters: &[PARAM_VALUE_DATA],
    ) -> Self {
        let mut reader = ParameterReader::new(&output::PARAMETERS);
        for parameter in parameters {
            reader.on_value(parameter);
        }
        let mut output = Output::new(settings.output);
        let faults = output.configure(&reader).err().into_iter().collect();
        let speed_mps = settings
            .speed_mps
            .or_else(|| output::full_speed_mps(&reader))
            .unwrap_or(settings.boat.limits.cruise_mps);
        let mut replay = Self {
            vehicle,
            watch: Some(Watch::new(vehicle, interval_s)),
            missions: missions.into(),
            run: None,
            frame: None,
            output,
            encoder: Encoder::new(),
            commands: Sha256::new(),
            was_driven: false,
            last_s: None,
            first_s: None,
            out_of_step_since_s: None,
            current: None,
            recorded_thought: None,
            marks: Marks::default(),
            speed_mps,
            result: WhatIfResult::default(),
            faults,
            settings,
        };
        // A mission that is in force before it has been seen on the link: given, or downloaded later.
        let first = replay
            .settings
            .mission
            .clone()
            .or_else(|| replay.missions.front().map(|transferred| transferred.mission.clone()));
        if let Some(mission) = first {
            replay.take_mission(&mission);
        }
        replay
    }

    /// Takes one message of the log.
    pub fn on_message(&mut self, time_us: u64, from: Identity, message: &Message, sink: &mut impl Sink) {
        let Some(mut watch) = self.watch.take() else { return };
        watch.on_message(time_us, from, message, &mut |watch, sight| {
            self.on_sight(time_us, watch, sight, sink);
        });
        self.watch = Some(watch);
    }

    fn on_sight(&mut self, time_us: u64, watch: &Watch, sight: Sight, sink: &mut impl Sink) {
        let time_s = watch.time_s();
        match sight {
            Sight::Step => self.on_step(time_us, watch, sink),
            Sight::Mission(transferred) if self.settings.mission.is_none() => {
                self.missions.pop_front();
                self.take_mission(&transferred.mission);
                let count = transferred.mission.items.len();
                sink.event(
                    time_s,
                    &format!("mission of {count} items from system {}", transferred.from.system),
                );
            }
            Sight::Mission(_) => {}
            Sight::Thought(state) => self.recorded_thought = Some(*state),
            Sight::Current(item) => {
                let at = self
                    .run
                    .as_ref()
                    .and_then(|run| run.route().waypoints.iter().position(|waypoint| waypoint.item >= item));
                self.current = at;
            }
            Sight::Reached(item) => {
                self.result.reached_recorded += 1;
                sink.event(time_s, &format!("reached item {item}"));
            }
            Sight::Event(severity, text) => {
                if severity <= enums::MAV_SEVERITY_INFO {
                    sink.event(time_s, &text);
                }
            }
        }
    }

    fn take_mission(&mut self, mission: &Mission) {
        match Route::from_mission(mission) {
            Ok(route) => {
                // The same mission, read again: the place in it is kept.
                if self.run.as_ref().is_some_and(|run| *run.route() == route) {
                    return;
                }
                let settings =
                    RunSettings { speed_mps: self.speed_mps, controller: self.settings.controller };
                let run = MissionRun::new(route, self.settings.boat.clone(), settings);
                self.frame = Some(*run.frame());
                self.result.waypoints = run.waypoints().len();
                self.marks.begin(run.waypoints());
                self.was_driven = false;
                self.run = Some(run);
            }
            Err(error) => self.faults.push(format!("a mission in the log cannot be driven: {error}")),
        }
    }

    fn on_step(&mut self, time_us: u64, watch: &Watch, sink: &mut impl Sink) {
        let Some(place) = watch.place().filter(|_| watch.is_fresh()) else { return };
        let frame = *self.frame.get_or_insert_with(|| LocalFrame::new(place));
        let Some((boot_s, state)) = vessel_state(watch.telemetry(), &frame) else { return };
        let time_s = watch.joined_s(boot_s);
        let since_s = self.last_s.map_or(0.0, |last_s| time_s - last_s);
        self.last_s = Some(time_s);
        let first_s = *self.first_s.get_or_insert(time_s);
        self.result.vehicle_s = time_s - first_s;

        let is_asked = match self.settings.window {
            Window::Driven => watch.is_driven(),
            Window::Armed => watch.is_armed(),
            Window::Any => true,
        };
        let mut moment = Moment {
            time_us,
            time_s,
            place,
            state,
            thought: None,
            outputs: self.recorded_outputs(boot_s, watch),
            recorded: self.recorded_thought,
            leg_error_m: None,
        };
        let demand = if is_asked { self.ask(&mut moment, since_s, sink) } else { None };
        self.was_driven = is_asked;
        if let Some(demand) = demand {
            self.send(time_us, demand, sink);
        }
        self.mark(&mut moment, demand);
        sink.moment(&moment);
    }

    /// What went to motors and rudder: as a bridge has recorded its commands, or as the autopilot put them out.
    fn recorded_outputs(&self, boot_s: f64, watch: &Watch) -> Option<Outputs> {
        let commanded =
            self.recorded_thought.filter(|thought| (boot_s - thought.boot_s).abs() < COMMAND_AGE_S);
        commanded
            .map(|thought| Outputs { steering: thought.steering.into(), throttle: thought.throttle.into() })
            .or_else(|| watch.outputs())
    }

    /// One step of the controller.
    fn ask(&mut self, moment: &mut Moment, since_s: f64, sink: &mut impl Sink) -> Option<Demand> {
        let current = self.current;
        let run = self.run.as_mut()?;
        if !self.was_driven {
            if let Some(waypoint) = current.filter(|waypoint| *waypoint != run.progress().next) {
                run.jump_to(waypoint);
            }
            if let Err(error) = run.engage(&moment.state) {
                sink.event(moment.time_s, &error.to_string());
            }
        }
        keep_in_step(run, current, moment.time_s, &mut self.out_of_step_since_s);
        match run.step(moment.time_s, &moment.state) {
            Ok(step) => {
                self.result.steps += 1;
                self.result.driven_s += since_s;
                self.result.reached_replayed += step.reached.1.saturating_sub(step.reached.0) as u64;
                let progress = run.progress();
                moment.thought = Some(ControlState::new(
                    moment.time_s,
                    &moment.state,
                    &progress,
                    &step.demand,
                    &step.diagnostics,
                ));
                Some(step.demand)
            }
            Err(error) => {
                let text = error.to_string();
                if !self.faults.contains(&text) {
                    self.faults.push(text);
                }
                None
            }
        }
    }

    fn send(&mut self, time_us: u64, demand: Demand, sink: &mut impl Sink) {
        let own = if self.settings.output.needs_ground_station_id() {
            Identity { system: self.settings.ground_station_system, component: COMPONENT }
        } else {
            Identity { system: self.vehicle.system, component: COMPONENT }
        };
        let mut frame = Vec::with_capacity(64);
        let message = self.output.drive(time_us as f64 / 1e6, self.vehicle, demand);
        self.encoder.encode(own, &message, &mut frame);
        self.commands.update(&frame);
        self.result.commands += 1;
        sink.command(time_us, &frame);
    }

    fn mark(&mut self, moment: &mut Moment, demand: Option<Demand>) {
        let Some(run) = &self.run else { return };
        let progress = run.progress();
        let Some(leg) = progress.leg else { return };
        moment.leg_error_m = leg_error_m(moment.state.position, run.waypoints(), leg);
        if let Some(demand) = demand {
            self.marks.on_moment(moment, leg, &progress, &demand);
        }
    }

    /// The figures.
    pub fn finish(mut self) -> (WhatIfResult, Vec<String>) {
        self.marks.tell(&mut self.result);
        self.result.commands_sha256 = hex(&self.commands.finalize());
        if let Some(watch) = self.watch.filter(|watch| watch.stale() > 0) {
            self.faults.push(format!("{} messages came after newer ones and were left out", watch.stale()));
        }
        (self.result, self.faults)
    }

    /// The mission being replayed, in its local frame.
    pub fn waypoints(&self) -> Vec<NorthEast> {
        self.run.as_ref().map(|run| run.waypoints().to_vec()).unwrap_or_default()
    }

    /// The local frame, once there is a mission or a position.
    pub fn frame(&self) -> Option<&LocalFrame> {
        self.frame.as_ref()
    }

    /// The smooth path being followed, and how many there have been.
    pub fn path(&self) -> Option<(usize, &helmlink_mission::path::Path)> {
        self.run.as_ref().and_then(|run| run.path().map(|path| (run.stretches(), path)))
    }
}

/// Goes where the vehicle is on its mission when that is somewhere else for long.
fn keep_in_step(run: &mut MissionRun, current: Option<usize>, time_s: f64, since_s: &mut Option<f64>) {
    let next = run.progress().next;
    match current.filter(|current| current.abs_diff(next) >= OUT_OF_STEP) {
        Some(current) => {
            if time_s - *since_s.get_or_insert(time_s) >= OUT_OF_STEP_S {
                run.jump_to(current);
                *since_s = None;
            }
        }
        None => *since_s = None,
    }
}
