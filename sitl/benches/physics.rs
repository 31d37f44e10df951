//! Speed of the physics: how many times faster than real time one core simulates each boat at 100 Hz.
//!
//! Run with `cargo bench -p helmlink-sitl --bench physics`. An item is one simulated second, so items per
//! second is the factor over real time.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use helmlink_sitl::physics::{ActuatorCommand, Hull, Pose, STEP_S, Sea, SeaState, SensorSettings, Vessel};

fn main() {
    divan::main();
}

const BOATS: [&str; 4] = ["otter", "monohull38", "skiff", "motorboat"];
const STEPS_PER_SECOND: u32 = 100;

fn simulate(bencher: Bencher, name: &str, state: SeaState, sensors: SensorSettings) {
    let Ok(hull) = Hull::builtin(name) else { return };
    let sea = Sea::preset(state, &hull);
    let mut vessel = Vessel::new(hull, &sea, &sensors, 1, Pose::default());
    let command = ActuatorCommand::ThrottleSteering { throttle: 0.6, steering: 0.1 };
    bencher.counter(ItemsCount::new(1usize)).bench_local(|| {
        for _ in 0..STEPS_PER_SECOND {
            vessel.step(STEP_S, black_box(command));
        }
        vessel.estimate()
    });
}

/// Flat water, perfect sensors.
#[divan::bench(args = BOATS)]
fn calm_perfect(bencher: Bencher, name: &str) {
    simulate(bencher, name, SeaState::Calm, SensorSettings::perfect());
}

/// Current, gusts, waves and noisy sensors: everything at once.
#[divan::bench(args = BOATS)]
fn moderate_typical(bencher: Bencher, name: &str) {
    simulate(bencher, name, SeaState::Moderate, SensorSettings::typical());
}
