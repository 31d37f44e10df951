//! Each failsafe trips by its own fault, at its own limit, and by nothing else.

use super::*;

fn fine(now_s: f64) -> Observation {
    let velocity = NorthEast::new(1.0, 0.0);
    Observation {
        position_age_s: 0.1,
        heading_age_s: 0.1,
        estimator_ready: true,
        output_refused: false,
        fix: Some(PositionFix { boot_s: now_s, place: velocity * now_s, velocity }),
        ground_station_age_s: Some(1.0),
        battery_percent: Some(80.0),
        fence_breach_m: Some(0.0),
        not_a_number: false,
        recording_failed: false,
        driving: true,
        cross_track_m: 0.1,
        to_go_m: Some(10_000.0 - now_s),
        saturated: false,
        since_step_s: 0.04,
    }
}

/// Puts the fault of one failsafe into an observation; `passed` is by how much the limit is passed or, below
/// zero, missed.
fn broken(failsafe: Failsafe, mut seen: Observation, limit: f64, passed: f64) -> Observation {
    let value = limit + passed;
    match failsafe {
        Failsafe::OutputRefused => seen.output_refused = true,
        Failsafe::PositionAge => seen.position_age_s = value,
        Failsafe::HeadingAge => seen.heading_age_s = value,
        Failsafe::Estimator => seen.estimator_ready = false,
        Failsafe::NotANumber => seen.not_a_number = true,
        Failsafe::PositionJump => {
            if let Some(fix) = &mut seen.fix {
                fix.place += NorthEast::new(0.0, value);
            }
        }
        Failsafe::Fence => seen.fence_breach_m = Some(value.max(0.0)),
        Failsafe::CrossTrack => seen.cross_track_m = -value,
        Failsafe::GroundStation => seen.ground_station_age_s = Some(value),
        Failsafe::Battery => seen.battery_percent = Some(limit - passed),
        Failsafe::NoProgress => seen.to_go_m = Some(5000.0),
        Failsafe::Saturated => seen.saturated = true,
        Failsafe::LoopLate => seen.since_step_s = value,
        Failsafe::Recording => seen.recording_failed = true,
        Failsafe::LinkLost | Failsafe::Rebooted | Failsafe::ModeChanged | Failsafe::Disarmed => {}
    }
    seen
}

const SEEN_ELSEWHERE: [Failsafe; 4] =
    [Failsafe::LinkLost, Failsafe::Rebooted, Failsafe::ModeChanged, Failsafe::Disarmed];

/// Time is what passes the limit of these.
const LASTING: [Failsafe; 4] =
    [Failsafe::Estimator, Failsafe::NotANumber, Failsafe::NoProgress, Failsafe::Saturated];

#[test]
fn every_fault_trips_its_own_failsafe_with_every_action_it_may_have() {
    for definition in DEFINITIONS.iter().filter(|row| !SEEN_ELSEWHERE.contains(&row.failsafe)) {
        let failsafe = definition.failsafe;
        for &action in definition.allowed {
            let mut settings = FailsafeSettings::default();
            settings.rule_mut(failsafe).action = Some(action);
            let mut watch = Watch::new(settings);
            let lasts_s = if LASTING.contains(&failsafe) { definition.limit + 0.2 } else { 0.1 };
            let mut found = Verdict::default();
            watch.look(0.0, &fine(0.0));
            let steps = (lasts_s / 0.1).ceil() as u32 + 1;
            for step in 1..=steps {
                let now_s = f64::from(step) * 0.1;
                found = watch.look(now_s, &broken(failsafe, fine(now_s), definition.limit, 0.5));
                if found != Verdict::default() {
                    break;
                }
            }
            let trip = if action == Action::Warn { found.warning } else { found.trip };
            let trip = trip.unwrap_or_else(|| panic!("{failsafe:?} {action:?}: {found:?}"));
            assert_eq!((trip.failsafe, trip.action), (failsafe, action));
            assert!(!trip.to_string().is_empty());
        }
    }
}

#[test]
fn nothing_trips_below_its_limit() {
    for definition in DEFINITIONS.iter().filter(|row| row.range.1 > 0.0 && row.limit > 0.0) {
        let mut watch = Watch::new(FailsafeSettings::default());
        for step in 0..=3_u32 {
            let now_s = f64::from(step) * 0.1;
            let seen = if step == 0 {
                fine(0.0)
            } else {
                broken(definition.failsafe, fine(now_s), definition.limit, -0.1)
            };
            let jumped_back = definition.failsafe == Failsafe::PositionJump && step > 1;
            if !jumped_back {
                assert_eq!(watch.look(now_s, &seen), Verdict::default(), "{:?}", definition.failsafe);
            }
        }
    }
}

#[test]
fn a_warning_is_given_once_and_again_after_it_has_passed() {
    let mut watch = Watch::new(FailsafeSettings::default());
    let low = |now_s| Observation { battery_percent: Some(3.0), ..fine(now_s) };
    assert!(watch.look(0.0, &low(0.0)).warning.is_some());
    assert!(watch.look(0.1, &low(0.1)).warning.is_none());
    assert!(watch.look(0.2, &fine(0.2)).warning.is_none());
    assert!(watch.look(0.3, &low(0.3)).warning.is_some());
}

#[test]
fn the_strongest_action_wins() {
    let mut watch = Watch::new(FailsafeSettings::default());
    let both = Observation { fence_breach_m: Some(3.0), position_age_s: 9.0, ..fine(0.0) };
    assert_eq!(watch.look(0.0, &both).trip.unwrap().failsafe, Failsafe::PositionAge);
}

#[test]
fn what_is_unknown_or_not_being_done_cannot_trip() {
    let mut watch = Watch::new(FailsafeSettings::default());
    for step in 0..2000_u32 {
        let seen = Observation {
            fix: None,
            ground_station_age_s: None,
            battery_percent: None,
            fence_breach_m: None,
            driving: false,
            cross_track_m: 1e6,
            to_go_m: Some(100.0),
            saturated: true,
            since_step_s: 1e6,
            ..fine(0.0)
        };
        assert_eq!(watch.look(f64::from(step) * 0.1, &seen), Verdict::default());
    }
}

#[test]
fn a_wait_at_a_waypoint_and_a_new_way_are_no_lack_of_progress() {
    let mut watch = Watch::new(FailsafeSettings::default());
    for step in 0..3000_u32 {
        let now_s = f64::from(step) * 0.1;
        let to_go_m = (step % 500 > 50).then_some(300.0);
        if step % 500 == 51 {
            watch.on_new_way();
        }
        let verdict = watch.look(now_s, &Observation { to_go_m, ..fine(now_s) });
        assert_eq!(verdict.trip, None, "at {now_s} s");
    }
}
