//! The bridge dies, or its cable is cut: what the firmware then does, a hundred times for each row of `docs/safety.md`.

use helmlink_wire::enums;

use super::rig::*;
use crate::pilot::supervisor::State;
use crate::vehicle::{Mode, OutputKind};

/// Runs of each row.
const RUNS: u32 = 100;
/// The firmware takes up to a second to bring the throttle to neutral (MOT_SLEWRATE 100 % a second).
const SLEW_S: f64 = 1.05;
/// The boat no longer moves, m/s.
const STILL_MPS: f64 = 0.2;

/// What became of a boat without its bridge; times since it vanished, seconds.
#[derive(Debug)]
struct Aftermath {
    /// Both outputs were neutral for good; infinite where they never were.
    neutral_s: f64,
    /// The hull was still for the first time.
    still_s: f64,
    /// How far it had gone by then, metres.
    gone_m: f64,
    /// How far it moved in the ten seconds before the end, metres.
    drift_m: f64,
    mode: Mode,
}

fn speed_mps(rig: &Rig) -> f64 {
    let hull = rig.sitl.truth().hull;
    hull.u_mps.hypot(hull.v_mps)
}

fn place_m(rig: &Rig) -> (f64, f64) {
    let hull = rig.sitl.truth().hull;
    (hull.north_m, hull.east_m)
}

fn apart_m(one: (f64, f64), other: (f64, f64)) -> f64 {
    (one.0 - other.0).hypot(one.1 - other.1)
}

/// Lets the bridge vanish at another instant in each run: by a cut line in one, by death in the next.
fn vanish(setup: Setup, run: u32, throttle_failsafe: bool) -> Aftermath {
    let mut rig = Rig::under_way(setup, |_| {});
    if throttle_failsafe {
        rig.set_parameter("FS_THR_ENABLE", 1.0);
    }
    let interval = crate::vehicle::streams::command_long(
        VEHICLE,
        enums::MAV_CMD_SET_MESSAGE_INTERVAL,
        [36.0, 20_000.0, 0.0],
    );
    rig.say(&interval);
    rig.run(0.5 + 0.02 * f64::from(run % 50));
    if run.is_multiple_of(2) {
        rig.cut = true;
    } else {
        rig.bridge = None;
    }
    let (gone_at, started_at) = (rig.now, place_m(&rig));
    let mut after = Aftermath {
        neutral_s: f64::INFINITY,
        still_s: f64::INFINITY,
        gone_m: f64::NAN,
        drift_m: f64::NAN,
        mode: Mode(u32::MAX),
    };
    let mut ten_seconds_ago = None;
    while (rig.now - gone_at).as_secs_f64() < LASTS_S {
        rig.step();
        let since_s = (rig.now - gone_at).as_secs_f64();
        if rig.servos_us == [1500, 1500] {
            after.neutral_s = after.neutral_s.min(since_s);
        } else {
            after.neutral_s = f64::INFINITY;
        }
        if speed_mps(&rig) < STILL_MPS && after.still_s.is_infinite() {
            (after.still_s, after.gone_m) = (since_s, apart_m(place_m(&rig), started_at));
        }
        if since_s >= LASTS_S - 10.0 {
            ten_seconds_ago.get_or_insert_with(|| place_m(&rig));
        }
    }
    after.drift_m = apart_m(place_m(&rig), ten_seconds_ago.unwrap());
    after.mode = rig.mode;
    after
}

/// How long a boat is looked at, seconds.
const LASTS_S: f64 = 20.0;

/// Runs of one row, with the worst of each figure printed.
fn row(output: OutputKind, receiver: bool, throttle_failsafe: bool) -> Vec<Aftermath> {
    let runs: Vec<_> =
        (0..RUNS).map(|run| vanish(Setup::new(output, receiver), run, throttle_failsafe)).collect();
    let worst = |of: fn(&Aftermath) -> f64| runs.iter().map(of).fold(0.0, f64::max);
    println!(
        "{output}, receiver {receiver}: neutral after {:.2} s, still after {:.1} s and {:.1} m, then {:.1} m in 10 s, {}",
        worst(|run| run.neutral_s),
        worst(|run| run.still_s),
        worst(|run| run.gone_m),
        worst(|run| run.drift_m),
        runs[0].mode
    );
    runs
}

fn check_sticks_with_receiver(output: OutputKind) {
    for (run, after) in row(output, true, false).iter().enumerate() {
        let is_so = (2.5..=3.1 + SLEW_S).contains(&after.neutral_s) && after.mode == Mode::MANUAL;
        assert!(is_so, "{output}, run {run}: {after:?}");
    }
}

fn check_sticks_without_receiver(output: OutputKind) {
    for (run, after) in row(output, false, true).iter().enumerate() {
        let is_so = after.neutral_s <= 0.55 + SLEW_S && after.mode == Mode::HOLD;
        assert!(is_so, "{output}, run {run}: {after:?}");
    }
}

fn check_guided(output: OutputKind, receiver: bool) {
    for (run, after) in row(output, receiver, false).iter().enumerate() {
        let is_so = after.mode == Mode::GUIDED && after.still_s <= 9.0 && after.drift_m < 5.0;
        assert!(is_so, "{output}, receiver {receiver}, run {run}: {after:?}");
    }
}

#[test]
fn an_overridden_boat_with_a_receiver_is_neutral_three_seconds_after_its_bridge_has_gone() {
    check_sticks_with_receiver(OutputKind::RcOverride);
}

#[test]
fn a_manually_controlled_boat_with_a_receiver_is_neutral_three_seconds_after_its_bridge_has_gone() {
    check_sticks_with_receiver(OutputKind::ManualControl);
}

#[test]
fn an_overridden_boat_without_a_receiver_is_neutral_after_half_a_second_and_then_in_hold() {
    check_sticks_without_receiver(OutputKind::RcOverride);
}

#[test]
fn a_manually_controlled_boat_without_a_receiver_is_neutral_after_half_a_second_and_then_in_hold() {
    check_sticks_without_receiver(OutputKind::ManualControl);
}

#[test]
fn a_boat_in_guided_stops_and_keeps_its_place_after_its_bridge_has_gone() {
    check_guided(OutputKind::Guided, true);
}

#[test]
fn a_boat_guided_by_velocity_stops_and_keeps_its_place_after_its_bridge_has_gone() {
    check_guided(OutputKind::GuidedVelocity, true);
}

#[test]
fn a_boat_in_guided_without_a_receiver_does_the_same_with_the_throttle_failsafe_off() {
    check_guided(OutputKind::Guided, false);
}

#[test]
fn a_boat_in_guided_without_a_receiver_is_in_hold_after_two_seconds_anyway() {
    for output in [OutputKind::Guided, OutputKind::GuidedVelocity] {
        let mut rig = Rig::under_way(Setup::new(output, false), |_| {});
        rig.set_parameter("FS_THR_ENABLE", 1.0);
        assert!(rig.run_until(3.0, |rig| rig.state() != State::Engaged), "the firmware takes over");
        rig.run(1.2);
        assert_eq!(rig.mode, Mode::HOLD, "{output}");
    }
}
