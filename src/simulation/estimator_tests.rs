//! How well the boat's motion is known, against the simulator's truth.

use std::time::Duration;

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::{LocalFrame, NorthEast};
use helmlink_mission::plan::Mission;
use helmlink_mission::route::Route;
use helmlink_sitl::faults::Fault;
use helmlink_sitl::physics::{Hull, Sea, SeaState, SensorSettings};

use super::{ClosedLoop, Trial};
use crate::control::{Boat, Controller};
use crate::guidance::VesselState;
use crate::pilot::supervisor::State;
use crate::vehicle::OutputKind;

fn trial(seed: u64) -> Trial {
    let mission: Mission = include_str!("../../mission/plans/harbour-survey.waypoints").parse().unwrap();
    Trial {
        boat: Boat::embedded("otter").unwrap(),
        controller: Controller::PiSmc,
        output: OutputKind::RcOverride,
        speed_mps: None,
        interval_s: 0.04,
        hull: Hull::builtin("otter").unwrap(),
        sea: Sea { current: Some("0.3@60".parse().unwrap()), ..Sea::default() },
        sensors: SensorSettings::typical(),
        seed,
        delay_s: 0.0,
        route: Route::from_mission(&mission).unwrap(),
        home: mission.home.unwrap(),
        heading_rad: 0.0,
        mission,
    }
}

/// Sums of squared errors.
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    position: f64,
    velocity: f64,
    heading: f64,
    rate: f64,
    count: f64,
}

impl Errors {
    fn add(&mut self, believed: &VesselState, truth: &VesselState) {
        self.position += (believed.position - truth.position).norm().powi(2);
        self.velocity += (believed.ground_velocity() - truth.ground_velocity()).norm().powi(2);
        self.heading += ssa(believed.heading_rad - truth.heading_rad).powi(2);
        self.rate += (believed.yaw_rate_radps - truth.yaw_rate_radps).powi(2);
        self.count += 1.0;
    }

    fn rms(&self) -> [f64; 4] {
        [self.position, self.velocity, self.heading, self.rate].map(|sum| (sum / self.count).sqrt())
    }
}

/// Errors of what the flight controller says, carried to the moment, and of the estimate.
fn errors(trial: &Trial, seconds: u64, mut weather: impl FnMut(&mut ClosedLoop)) -> ([f64; 4], [f64; 4]) {
    let mut run = trial.closed_loop().unwrap();
    let sitl_frame = LocalFrame::new(trial.home);
    let mut truths = Vec::new();
    let (mut raw, mut seen, mut steps) = (Errors::default(), Errors::default(), 0);
    while run.now() < Duration::from_secs(seconds) {
        weather(&mut run);
        run.step();
        let hull = run.sitl().truth().hull;
        truths.push(hull);
        let status = run.bridge().status();
        if status.steps == steps || status.state != State::Engaged || run.now() < Duration::from_secs(30) {
            steps = status.steps;
            continue;
        }
        steps = status.steps;
        let thought = run.bridge().thought().unwrap();
        let hull = truths[((thought.boot_s / 0.02).round() as usize).saturating_sub(1)];
        let frame = run.bridge().run().unwrap().frame();
        let truth = VesselState {
            position: frame.to_local(sitl_frame.to_geodetic(NorthEast::new(hull.north_m, hull.east_m))),
            heading_rad: hull.psi_rad,
            surge_mps: hull.u_mps,
            sway_mps: hull.v_mps,
            yaw_rate_radps: hull.r_radps,
        };
        let said = VesselState {
            position: NorthEast::new(f64::from(thought.north_m), f64::from(thought.east_m)),
            heading_rad: f64::from(thought.heading_rad),
            surge_mps: f64::from(thought.surge_mps),
            sway_mps: f64::from(thought.sway_mps),
            yaw_rate_radps: f64::from(thought.yaw_rate_radps),
        };
        raw.add(&said, &truth);
        seen.add(&status.diagnostics.observed, &truth);
    }
    (raw.rms(), seen.rms())
}

/// What is done to the telemetry before the boat is looked at.
type Weather = fn(&mut ClosedLoop);

fn fair(_: &mut ClosedLoop) {}

fn once(run: &mut ClosedLoop, at_s: u64, fault: Fault) {
    if run.now() == Duration::from_secs(at_s) {
        run.sitl_mut().inject(fault).unwrap();
    }
}

fn lossy(run: &mut ClosedLoop) {
    once(run, 20, Fault::LinkLoss { share: 0.2 });
}

/// Every fifth frame is overtaken by those of up to 200 ms after it.
fn disordered(run: &mut ClosedLoop) {
    once(run, 20, Fault::LinkReordering { share: 0.2 });
}

/// Nothing for two seconds, three times.
fn interrupted(run: &mut ClosedLoop) {
    for start_s in [100, 150, 200] {
        once(run, start_s, Fault::LinkLoss { share: 1.0 });
        once(run, start_s + 2, Fault::LinkLoss { share: 0.0 });
    }
}

/// The mean over the seeds of estimated over raw error, in position, velocity, heading and yaw rate.
fn improvement(name: &str, change: impl Fn(&mut Trial), weather: Weather) -> [f64; 4] {
    let seeds = [31, 32, 33];
    let mut sums = [0.0; 4];
    for seed in seeds {
        let mut trial = trial(seed);
        change(&mut trial);
        let (raw, seen) = errors(&trial, 240, weather);
        println!("{name:12} seed {seed}: said {raw:.4?}, estimated {seen:.4?} (m, m/s, rad, rad/s)");
        for (sum, (raw, seen)) in sums.iter_mut().zip(raw.into_iter().zip(seen)) {
            *sum += seen / raw / seeds.len() as f64;
        }
    }
    println!("{name:12} estimated over said: {sums:.3?}");
    sums
}

#[test]
fn the_estimate_beats_what_the_flight_controller_says() {
    let [position, velocity, ..] = improvement("typical", |_| {}, fair);
    assert!(position < 1.0 && velocity < 0.9, "{position} {velocity}");
    let [position, velocity, ..] = improvement("poor", |trial| trial.sensors = SensorSettings::poor(), fair);
    assert!(position < 1.0 && velocity < 0.85, "{position} {velocity}");
    let moderate = |trial: &mut Trial| trial.sea = Sea::preset(SeaState::Moderate, &trial.hull);
    let [position, velocity, heading, rate] = improvement("moderate", moderate, fair);
    assert!(position < 1.0 && velocity < 0.8 && heading < 1.0 && rate < 0.8);
}

#[test]
fn slow_lost_late_and_missing_samples_do_not_spoil_it() {
    let slow = improvement("5 Hz", |trial| trial.interval_s = 0.2, fair);
    let lossy = improvement("a fifth lost", |_| {}, lossy);
    let late = improvement("disordered", |_| {}, disordered);
    let gaps = improvement("gaps of 2 s", |_| {}, interrupted);
    for [position, velocity, heading, rate] in [slow, lossy, late, gaps] {
        assert!(position < 1.0 && velocity < 0.95, "{position} {velocity}");
        assert!(heading < 1.01 && rate < 1.01, "{heading} {rate}");
    }
}

#[test]
fn the_delay_of_the_loop_is_measured_on_the_boats_answer() {
    for (name, within_s) in [("otter", 0.06), ("motorboat", 0.12)] {
        for delay_s in [0.2, 0.5, 1.0] {
            let (boat, hull) = (Boat::embedded(name).unwrap(), Hull::builtin(name).unwrap());
            let mut run = Trial { boat, hull, delay_s, ..trial(31) }.closed_loop().unwrap();
            run.run(Duration::from_secs(200));
            let status = run.bridge().status();
            let answer = status.answer_delay.unwrap();
            println!("{name} {delay_s} s: {answer:.3?}, round trip {:?}", status.round_trip_s);
            assert!((answer.delay_s - delay_s).abs() < within_s, "{name} {delay_s}: {answer:?}");
            // The messages' way explains it: that is what is predicted across.
            assert!((status.round_trip_s.unwrap() - delay_s).abs() < 0.03, "{name}: {status:?}");
            assert!((status.delay_s - delay_s).abs() < 0.03, "{name} {delay_s}: {status:?}");
        }
    }
}

/// The compass offset as the boat has found it out, and as it is.
#[test]
fn a_wrong_compass_is_found_out_in_the_turns() {
    for (seed, offset_deg) in [(31, 5.0), (32, -5.0), (33, 3.0)] {
        let mut run = trial(seed).closed_loop().unwrap();
        let offset_rad = f64::to_radians(offset_deg);
        run.sitl_mut().inject(Fault::CompassOffset { offset_rad }).unwrap();
        run.run(Duration::from_secs(240));
        let compass = run.bridge().run().unwrap().helm().compass_error();
        println!("seed {seed}: {:.4} rad, found {compass:.4?}", offset_rad);
        // The compass of these sensors is 0.7 degrees off by itself.
        assert!((compass.offset_rad - offset_rad).abs() < 0.03, "{offset_rad}: {compass:?}");
        assert!(compass.deviation_rad < 0.01, "{compass:?}");
    }
}
