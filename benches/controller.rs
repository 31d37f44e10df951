//! Time of one control step: prediction across 0.3 s, guidance, law and allocation.

// A benchmark that cannot be set up may stop.
#![allow(clippy::unwrap_used)]

use divan::{Bencher, black_box};
use helmlink::control::{Boat, Helm};
use helmlink::guidance::{EndOfPath, VesselState};
use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::{Path, PathLimits};

fn main() {
    divan::main();
}

/// Where everything ahead is straight, m.
const LEG_M: f64 = 100.0;
/// In the middle of a turn, m.
const TURN_M: f64 = 197.0;

/// Steps before the first one that is timed: everything that is learned on the way is being learned by then.
const WARM_STEPS: usize = 3000;
/// Steps timed as one: some work is done once in twenty only.
const STEPS: u32 = 100;
/// Steps after which the boat's motion repeats itself.
const PERIOD: usize = 251;

#[divan::bench(args = ["otter", "monohull38", "motorboat", "skiff"], sample_size = STEPS)]
fn step_on_a_leg(bencher: Bencher, name: &str) {
    bench_at(bencher, name, LEG_M);
}

#[divan::bench(args = ["otter", "monohull38", "motorboat", "skiff"], sample_size = STEPS)]
fn step_in_a_turn(bencher: Bencher, name: &str) {
    bench_at(bencher, name, TURN_M);
}

fn bench_at(bencher: Bencher, name: &str, progress_m: f64) {
    let points = [(0.0, 0.0), (0.0, 200.0), (150.0, 200.0), (150.0, 0.0)]
        .map(|(north_m, east_m)| NorthEast { north_m, east_m });
    let path = Path::through(&points, &PathLimits::new(8.0, 6.0)).unwrap();
    let boat = Boat::embedded(name).unwrap();
    let mut helm = Helm::new(&boat, EndOfPath::Stop);
    let states = states_near(&path, progress_m);
    helm.set_delay_s(0.3);
    helm.engage(&states[0], progress_m).unwrap();
    let mut states = states.iter().cycle();
    let mut step = || {
        let state = states.next().unwrap();
        helm.step(black_box(0.05), black_box(state), black_box(&path), black_box(1.3))
    };
    for _ in 0..WARM_STEPS {
        step().unwrap();
    }
    bencher.bench_local(step);
}

/// A boat that is never still, as in noise and waves, beside one place of the path.
fn states_near(path: &Path, progress_m: f64) -> Vec<VesselState> {
    let place = path.point(progress_m);
    let state = |step: usize| {
        let phase = step as f64 / PERIOD as f64 * std::f64::consts::TAU;
        let wave = |cycles: f64| (cycles * phase).sin();
        VesselState {
            position: place.position + NorthEast::new(0.1 + 0.05 * wave(3.0), 0.1 + 0.05 * wave(7.0)),
            heading_rad: place.heading_rad + 0.1 + 0.03 * wave(5.0),
            surge_mps: 1.2 + 0.05 * wave(2.0),
            sway_mps: 0.1 + 0.03 * wave(11.0),
            yaw_rate_radps: 0.02 + 0.03 * wave(13.0),
        }
    };
    (0..PERIOD).map(state).collect()
}
