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

#[divan::bench(args = ["otter", "monohull38", "motorboat", "skiff"])]
fn step_on_a_leg(bencher: Bencher, name: &str) {
    bench_at(bencher, name, LEG_M);
}

#[divan::bench(args = ["otter", "monohull38", "motorboat", "skiff"])]
fn step_in_a_turn(bencher: Bencher, name: &str) {
    bench_at(bencher, name, TURN_M);
}

fn bench_at(bencher: Bencher, name: &str, progress_m: f64) {
    let points = [(0.0, 0.0), (0.0, 200.0), (150.0, 200.0), (150.0, 0.0)]
        .map(|(north_m, east_m)| NorthEast { north_m, east_m });
    let path = Path::through(&points, &PathLimits::new(8.0, 6.0)).unwrap();
    let boat = Boat::embedded(name).unwrap();
    let mut helm = Helm::new(&boat, EndOfPath::Stop);
    let place = path.point(progress_m);
    let state = VesselState {
        position: place.position + NorthEast { north_m: 0.1, east_m: 0.1 },
        heading_rad: place.heading_rad + 0.1,
        surge_mps: 1.2,
        sway_mps: 0.1,
        yaw_rate_radps: 0.02,
    };
    helm.set_delay_s(0.3);
    helm.engage(&state, progress_m).unwrap();
    bencher.bench_local(|| helm.step(black_box(0.05), black_box(&state), black_box(&path), black_box(1.3)));
}
