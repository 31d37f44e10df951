use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::Path;

use super::Plant;
use crate::control::{Boat, Helm};
use crate::guidance::EndOfPath;

/// Time after a bend before the boat counts as settled, s.
const SETTLING_S: f64 = 40.0;

/// What a closed loop did.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Report {
    pub(crate) settled_rms_m: f64,
    pub(crate) settled_max_m: f64,
    pub(crate) path_rms_m: f64,
    pub(crate) path_max_m: f64,
    pub(crate) whole_rms_m: f64,
    pub(crate) whole_max_m: f64,
    pub(crate) steering_per_min: f64,
    pub(crate) throttle_per_min: f64,
    pub(crate) settled_steering_per_min: f64,
    pub(crate) duration_s: f64,
    pub(crate) finished: bool,
}

pub(crate) struct Run<'a> {
    pub(crate) boat: &'a Boat,
    pub(crate) path: &'a Path,
    pub(crate) points: &'a [NorthEast],
    pub(crate) speed_mps: f64,
    pub(crate) rate_hz: f64,
    pub(crate) delay_ticks: usize,
    /// 1.0: 5 cm Gauss-Markov position, 0.5 deg heading, 0.3 deg/s yaw rate, 3 cm/s velocity noise.
    pub(crate) noise: f64,
    pub(crate) trace: bool,
}

impl Run<'_> {
    pub(crate) fn run(&self, plant: &mut Plant) -> Report {
        let mut helm = Helm::new(self.boat, EndOfPath::Stop);
        helm.engage(&plant.state(), 0.0).unwrap();
        let dt = 1.0 / self.rate_hz;
        let limit = (3.0 * self.path.length_m() / self.speed_mps / dt) as usize;
        let mut sums = [Sum::default(), Sum::default(), Sum::default()];
        let (mut steering, mut throttle, mut settled_steering) = (0.0, 0.0, 0.0);
        let mut last: Option<crate::control::Command> = None;
        let mut bend_s = 0.0;
        let mut settled_s = 0.0;
        let mut queue = std::collections::VecDeque::new();
        let mut report = Report::default();
        let mut noise = Noise::new(self.noise);
        for tick in 0..limit {
            let time_s = tick as f64 * dt;
            let truth = plant.state();
            let state = noise.disturb(dt, truth);
            let output = helm.step(dt, &state, self.path, self.speed_mps).unwrap();
            let reference = output.diagnostics.reference;
            if reference.finished {
                report.finished = true;
                break;
            }
            if self.path.point(reference.progress_m.max(0.0)).curvature_radpm.abs() > 1e-6 {
                bend_s = time_s;
            }
            let e = if self.noise == 0.0 { reference.cross_track_m } else { crate::guidance::progress::project(self.path, truth.position, reference.progress_m).cross_track_m };
            sums[1].add(e);
            sums[2].add(polyline_distance(self.points, truth.position));
            let settled = time_s - bend_s > SETTLING_S;
            if settled {
                sums[0].add(e);
                settled_s += dt;
            }
            if let Some(last) = last {
                let change = (output.command.steering - last.steering).abs();
                steering += change;
                throttle += (output.command.throttle - last.throttle).abs();
                if settled {
                    settled_steering += change;
                }
            }
            last = Some(output.command);
            if self.trace && tick % (self.rate_hz as usize / 2) == 0 {
                let d = output.diagnostics;
                println!(
                    "{time_s:7.1} s {:7.2} k {:6.3} e {e:7.3} pe {:6.3} u {:5.2}/{:5.2} r {:6.3}/{:6.3} Su {:6.3} Sr {:6.3} dh {:.3} {:.3} st {:6.3} th {:6.3} lead {:.2} vm {:.3} v {:.3} W {:.2} {:.2} sat {} {}",
                    reference.progress_m, self.path.point(reference.progress_m).curvature_radpm, reference.heading_error_rad, state.surge_mps, d.law.alpha_u_mps,
                    state.yaw_rate_radps, d.law.alpha_r_radps, d.law.surface_u, d.law.surface_r, d.law.disturbance_u, d.law.disturbance_r,
                    output.command.steering, output.command.throttle, reference.lead_m, d.water.sway_mps, state.sway_mps,
                    d.water.current.north_m, d.water.current.east_m, d.surge_saturated, d.yaw_saturated
                );
            }
            queue.push_back(output.command);
            let command =
                if queue.len() > self.delay_ticks { queue.pop_front().unwrap() } else { Default::default() };
            plant.advance(dt, command);
            report.duration_s = time_s;
        }
        report.settled_rms_m = sums[0].rms();
        report.settled_max_m = sums[0].max;
        report.path_rms_m = sums[1].rms();
        report.path_max_m = sums[1].max;
        report.whole_rms_m = sums[2].rms();
        report.whole_max_m = sums[2].max;
        report.steering_per_min = steering / report.duration_s * 60.0;
        report.throttle_per_min = throttle / report.duration_s * 60.0;
        report.settled_steering_per_min = settled_steering / settled_s.max(1.0) * 60.0;
        report
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    squares: f64,
    count: f64,
    max: f64,
}

impl Sum {
    fn add(&mut self, e: f64) {
        self.squares += e * e;
        self.count += 1.0;
        self.max = self.max.max(e.abs());
    }

    fn rms(&self) -> f64 {
        if self.count > 0.0 { (self.squares / self.count).sqrt() } else { f64::NAN }
    }
}

fn polyline_distance(points: &[NorthEast], position: NorthEast) -> f64 {
    points
        .windows(2)
        .map(|leg| {
            let along = leg[1] - leg[0];
            let part = ((position - leg[0]).dot(along) / along.dot(along)).clamp(0.0, 1.0);
            (position - leg[0] - along * part).norm()
        })
        .fold(f64::INFINITY, f64::min)
}

/// The way-points of Fossen's Otter example, in local metres.
pub(crate) fn box_points() -> Vec<NorthEast> {
    [(0.0, 0.0), (0.0, 200.0), (149.0, 200.0), (149.0, -50.0), (-100.0, -50.0), (-100.0, 250.0), (200.0, 250.0)]
        .map(|(north_m, east_m)| NorthEast { north_m, east_m })
        .to_vec()
}

pub(crate) fn box_path() -> Path {
    Path::through(&box_points(), &helmlink_mission::path::PathLimits::new(4.0, 3.0)).unwrap()
}

struct Noise { size: f64, rng: rand_chacha::ChaCha8Rng, bias: [f64; 2] }

impl Noise {
    fn new(size: f64) -> Self {
        use rand_chacha::rand_core::SeedableRng;
        Self { size, rng: rand_chacha::ChaCha8Rng::seed_from_u64(7), bias: [0.0; 2] }
    }
    fn normal(&mut self) -> f64 {
        use rand_chacha::rand_core::Rng;
        (0..12).map(|_| f64::from(self.rng.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0
    }
    fn disturb(&mut self, dt: f64, mut state: crate::guidance::VesselState) -> crate::guidance::VesselState {
        if self.size == 0.0 { return state; }
        for i in 0..2 {
            let w = self.normal();
            self.bias[i] += -self.bias[i] * dt / 2.0 + 0.05 * (2.0 * dt / 2.0).sqrt() * w;
        }
        let k = self.size;
        state.position.north_m += k * (self.bias[0] + 0.01 * self.normal());
        state.position.east_m += k * (self.bias[1] + 0.01 * self.normal());
        state.heading_rad += k * 0.006 * self.normal();
        state.yaw_rate_radps += k * 0.005 * self.normal();
        state.surge_mps += k * 0.03 * self.normal();
        state.sway_mps += k * 0.03 * self.normal();
        state
    }
}
