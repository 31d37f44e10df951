//! A closed loop: helm and plant along a path, scored on the plant's true position.

use std::collections::VecDeque;

use helmlink_mission::path::Path;

use super::Plant;
use super::noise::Noise;
use crate::control::{Boat, Command, Controller, Helm};
use crate::guidance::EndOfPath;
use crate::guidance::progress::project;

/// Time after a bend before the boat counts as settled, s.
const SETTLING_S: f64 = 40.0;
/// A boat that starts far away has found the path when it is this part of its look-ahead from it,
/// and faces along it to within this angle, rad.
const ACQUIRED_PART: f64 = 0.2;
const ACQUIRED_RAD: f64 = 0.3;
/// The last metres before the stop at the end do not count as settled.
const STOPPING_M: f64 = 8.0;

/// What a closed loop did.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Report {
    /// Root mean square of the distance from the path, long after bends and before the final approach.
    pub(crate) settled_rms_m: f64,
    /// Distance from the path, everywhere.
    pub(crate) path_rms_m: f64,
    pub(crate) path_max_m: f64,
    /// Distance from the straight legs between the way-points, everywhere: corners count.
    pub(crate) legs_rms_m: f64,
    /// Total variation of steering per minute, everywhere and settled.
    pub(crate) steering_per_min: f64,
    pub(crate) settled_steering_per_min: f64,
    pub(crate) finished: bool,
}

pub(crate) struct Run<'a> {
    pub(crate) boat: &'a Boat,
    pub(crate) controller: Controller,
    pub(crate) path: &'a Path,
    pub(crate) speed_mps: f64,
    /// Time steps, used in turn, s.
    pub(crate) steps_s: &'a [f64],
    /// Ticks between a command and its effect.
    pub(crate) delay_ticks: usize,
    /// Delay the helm is told, s.
    pub(crate) told_delay_s: f64,
    pub(crate) noise_seed: Option<u64>,
}

impl<'a> Run<'a> {
    pub(crate) fn new(boat: &'a Boat, path: &'a Path, speed_mps: f64) -> Self {
        Self {
            boat,
            controller: Controller::PiSmc,
            path,
            speed_mps,
            steps_s: &[0.05],
            delay_ticks: 0,
            told_delay_s: 0.0,
            noise_seed: None,
        }
    }

    /// Runs to the end of the path, or three times the time it should take.
    pub(crate) fn run(&self, plant: &mut Plant) -> Report {
        let mut helm = Helm::with_controller(self.boat, self.controller, EndOfPath::Stop);
        helm.set_delay_s(self.told_delay_s);
        helm.engage(&plant.state(), 0.0).unwrap();
        let mut noise = self.noise_seed.map(Noise::seeded);
        let mut under_way: VecDeque<Command> = VecDeque::from(vec![Command::NEUTRAL; self.delay_ticks]);
        let mut score = Score::default();
        let mut acquired = false;
        let limit_s = 3.0 * self.path.length_m() / self.speed_mps;
        for dt_s in self.steps_s.iter().copied().cycle() {
            let truth = plant.state();
            let state = noise.as_mut().map_or(truth, |noise| noise.disturb(dt_s, truth));
            let output = helm.step(dt_s, &state, self.path, self.speed_mps).unwrap();
            let progress_m = output.diagnostics.reference.progress_m;
            if output.diagnostics.reference.finished || score.time_s > limit_s {
                score.finished = output.diagnostics.reference.finished;
                break;
            }
            let here = project(self.path, truth.position, progress_m);
            let leg_m = self.path.distance_to_leg(truth.position, self.path.leg_at(progress_m));
            let facing = output.diagnostics.reference.heading_error_rad.abs() < ACQUIRED_RAD;
            acquired |= facing && here.cross_track_m.abs() < ACQUIRED_PART * self.boat.guidance.lead_m;
            let bend = here.foot.curvature_radpm != 0.0 || !acquired;
            let stopping = progress_m > self.path.length_m() - STOPPING_M;
            score.add(dt_s, here.cross_track_m, leg_m, bend, stopping, output.command);
            under_way.push_back(output.command);
            plant.advance(dt_s, under_way.pop_front().unwrap());
        }
        score.report()
    }
}

#[derive(Default)]
struct Score {
    time_s: f64,
    bend_s: f64,
    settled_s: f64,
    path: Squares,
    legs: Squares,
    settled: Squares,
    steering: f64,
    settled_steering: f64,
    last: Option<Command>,
    finished: bool,
}

impl Score {
    fn add(&mut self, dt_s: f64, path_m: f64, leg_m: f64, bend: bool, stopping: bool, command: Command) {
        self.time_s += dt_s;
        if bend {
            self.bend_s = self.time_s;
        }
        let settled = self.time_s - self.bend_s > SETTLING_S && !stopping;
        self.path.add(dt_s, path_m);
        self.legs.add(dt_s, leg_m);
        let change = self.last.map_or(0.0, |last| (command.steering - last.steering).abs());
        self.steering += change;
        self.last = Some(command);
        if settled {
            self.settled_s += dt_s;
            self.settled.add(dt_s, path_m);
            self.settled_steering += change;
        }
    }

    fn report(&self) -> Report {
        Report {
            settled_rms_m: self.settled.root_mean(),
            path_rms_m: self.path.root_mean(),
            path_max_m: self.path.most,
            legs_rms_m: self.legs.root_mean(),
            steering_per_min: 60.0 * self.steering / self.time_s,
            settled_steering_per_min: 60.0 * self.settled_steering / self.settled_s,
            finished: self.finished,
        }
    }
}

#[derive(Default)]
struct Squares {
    sum: f64,
    weight: f64,
    most: f64,
}

impl Squares {
    fn add(&mut self, weight: f64, value: f64) {
        self.sum += weight * value * value;
        self.weight += weight;
        self.most = self.most.max(value.abs());
    }

    /// NaN when nothing was added, so that no test passes on nothing.
    fn root_mean(&self) -> f64 {
        (self.sum / self.weight).sqrt()
    }
}
