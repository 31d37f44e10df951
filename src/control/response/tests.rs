use super::*;
use crate::control::{Boat, command::Wrench};

const DT_S: f64 = 0.04;

/// The delay told by a boat whose hull differs from the model by `change`, steered one way and the other with
/// irregular strength, its yaw rate measured with noise; the moment acts `delay_s` late.
fn told(
    name: &str,
    delay_s: f64,
    dt_s: f64,
    noise_radps: f64,
    change: impl Fn(&mut Hull),
) -> Option<MeasuredDelay> {
    let boat = Boat::embedded(name).unwrap();
    let mut hull = boat.hull.clone();
    change(&mut hull);
    let mut response = YawResponse::new(&boat.hull);
    let yaw_s = boat.hull.m33_kgm2 / boat.hull.yaw_damping[0];
    let strength = 0.7 * boat.limits.turn_rate_radps * boat.hull.yaw_damping[0];
    // The boat steers about as quickly as it can turn.
    let pace = 1.0 / yaw_s.max(0.5);
    let moment = |t: f64| {
        if t < 0.0 { 0.0 } else { strength * ((0.4 * pace * t).sin() + (0.93 * pace * t).sin().signum()) }
    };
    let (mut motion, mut last) =
        (WaterMotion { surge_mps: boat.limits.cruise_mps, ..WaterMotion::default() }, 0.0);
    let mut noise = 0.0f64;
    let end_s = (40.0 * yaw_s).max(90.0);
    let fine_s = 0.01;
    let mut t = 0.0;
    while t < end_s {
        noise = (noise * 9301.0 + 0.49297).fract();
        let measured =
            WaterMotion { yaw_rate_radps: motion.yaw_rate_radps + noise_radps * (noise - 0.5), ..motion };
        response.step(dt_s, &measured, last);
        last = moment(t);
        for part in 0..(dt_s / fine_s).round() as u32 {
            let acting = moment_held(&moment, t + f64::from(part) * fine_s - delay_s, dt_s);
            let wrench = Wrench { yaw_nm: acting, ..Wrench::default() };
            let next = hull.after(fine_s, motion, wrench, [0.0, 0.01 * strength / hull.m33_kgm2]);
            motion = WaterMotion { surge_mps: motion.surge_mps, ..next };
        }
        t += dt_s;
    }
    response.delay()
}

/// The command in force at `t`: the one made at the last tick.
fn moment_held(moment: &impl Fn(f64) -> f64, t: f64, dt_s: f64) -> f64 {
    moment((t / dt_s + 1.0e-9).floor() * dt_s)
}

#[test]
fn every_delay_is_measured_on_every_boat() {
    for name in Boat::names() {
        for delay_s in [0.0, 0.2, 0.5, 1.0] {
            let measured = told(name, delay_s, DT_S, 0.0, |_| ()).unwrap();
            println!("{name} {delay_s}: {measured:.3?}");
            assert!((measured.delay_s - delay_s).abs() < 0.05, "{name} {delay_s}: {measured:?}");
        }
    }
}

#[test]
fn a_wrong_hull_does_not_pass_for_delay() {
    for factor in [0.5, 1.5] {
        for delay_s in [0.0, 0.5] {
            let mass = told("otter", delay_s, DT_S, 0.0, |hull| hull.m33_kgm2 *= factor).unwrap();
            let damping = told("otter", delay_s, DT_S, 0.0, |hull| {
                hull.yaw_damping.iter_mut().for_each(|d| *d *= factor);
            });
            let damping = damping.unwrap();
            println!("{factor} {delay_s}: {mass:.3?} {damping:.3?}");
            assert!((mass.delay_s - delay_s).abs() < 0.05, "{factor} {delay_s}: {mass:?}");
            assert!((damping.delay_s - delay_s).abs() < 0.05, "{factor} {delay_s}: {damping:?}");
        }
    }
}

#[test]
fn slow_telemetry_and_noise_cost_little_and_are_told() {
    for (dt_s, noise_radps) in [(0.02, 0.005), (0.1, 0.01), (0.2, 0.01)] {
        let measured = told("otter", 0.5, dt_s, noise_radps, |_| ()).unwrap();
        let quiet = told("otter", 0.5, dt_s, 0.0, |_| ()).unwrap();
        println!("{dt_s} {noise_radps}: {measured:.4?} {quiet:.4?}");
        assert!((measured.delay_s - 0.5).abs() < 0.07, "{dt_s}: {measured:?}");
        assert!(measured.deviation_s > quiet.deviation_s, "{dt_s}: {measured:?} {quiet:?}");
    }
}

#[test]
fn a_boat_that_does_not_answer_tells_nothing() {
    // Much noise and no effect: an engine that is off.
    assert_eq!(told("otter", 0.5, DT_S, 0.05, |hull| hull.m33_kgm2 *= 1.0e6), None);
    let mut response = YawResponse::new(&Boat::embedded("otter").unwrap().hull);
    for _ in 0..5000 {
        response.step(DT_S, &WaterMotion { surge_mps: 1.2, ..WaterMotion::default() }, 0.0);
    }
    assert_eq!(response.delay(), None, "straight on");
}

#[test]
fn the_boats_answer_counts_where_the_messages_way_does_not_explain_it() {
    let seen = |delay_s| Some(MeasuredDelay { delay_s, deviation_s: 0.01, explained: 0.9 });
    let mut choice = DelayChoice::default();
    assert_eq!(choice.choose(None, None), None);
    assert_eq!(choice.choose(Some(0.2), None), Some(0.2));
    assert_eq!(choice.choose(Some(0.2), seen(0.1)), Some(0.2), "sooner than can be");
    assert_eq!(choice.choose(Some(0.2), seen(0.3)), Some(0.2), "about as expected");
    assert_eq!(choice.choose(Some(0.2), seen(0.6)), Some(0.6));
    assert_eq!(choice.choose(Some(0.2), seen(0.3)), Some(0.3), "no hurry to change back");
    assert_eq!(choice.choose(Some(0.2), seen(0.22)), Some(0.2));
    assert_eq!(choice.choose(Some(0.2), seen(0.3)), Some(0.2), "nor forth");
    assert_eq!(choice.choose(None, seen(0.5)), Some(0.5));
    let vague = Some(MeasuredDelay { delay_s: 0.9, deviation_s: 0.2, explained: 0.9 });
    assert_eq!(choice.choose(Some(0.2), vague), Some(0.2));
}
