use super::*;
use crate::control::Boat;

fn hull() -> Hull {
    Boat::embedded("otter").unwrap().hull
}

fn at_rest() -> VesselState {
    VesselState {
        position: NorthEast { north_m: 0.0, east_m: 0.0 },
        heading_rad: 0.4,
        surge_mps: 0.0,
        sway_mps: 0.0,
        yaw_rate_radps: 0.0,
    }
}

fn moving(state: &VesselState, motion: WaterMotion, current: NorthEast) -> VesselState {
    let bow = unit(state.heading_rad);
    VesselState {
        surge_mps: motion.surge_mps + bow.dot(current),
        sway_mps: motion.sway_mps + bow.cross(current),
        yaw_rate_radps: motion.yaw_rate_radps,
        ..*state
    }
}

/// Forces of tick `i`: a turn that comes and goes.
fn wrench(i: usize) -> Wrench {
    let phase = 0.1 * i as f64;
    Wrench { surge_n: 90.0 + 20.0 * phase.sin(), sway_n: 0.0, yaw_nm: 15.0 * (0.7 * phase).cos() }
}

/// Largest error of the prediction, in position (m) and heading (rad), on a true hull `truth`.
fn worst_error(truth: &Hull, delay_ticks: usize) -> (f64, f64) {
    let (dt_s, current) = (0.05, NorthEast { north_m: 0.2, east_m: -0.1 });
    let mut predictor = Predictor::default();
    predictor.set_delay_s(dt_s * delay_ticks as f64);
    let mut ahead =
        Ahead::from(moving(&at_rest(), WaterMotion::default(), current), WaterMotion::default(), unit(0.0));
    let mut predictions = Vec::new();
    let mut worst = (0.0f64, 0.0f64);
    for i in 0..600 {
        predictor.advance(dt_s);
        let (predicted, _) = predictor.predict(dt_s, &hull(), &ahead.state, ahead.motion, current);
        predictions.push(predicted);
        if i > 300 {
            let earlier = &predictions[i - delay_ticks];
            worst.0 = worst.0.max((earlier.position - ahead.state.position).norm());
            worst.1 = worst.1.max((earlier.heading_rad - ahead.state.heading_rad).abs());
        }
        predictor.push(wrench(i));
        let acting = if i >= delay_ticks { wrench(i - delay_ticks) } else { Wrench::default() };
        ahead.step(dt_s, truth, acting, [0.0; 2], current, 0.0);
    }
    worst
}

#[test]
fn an_exact_model_is_predicted_exactly() {
    for delay_ticks in [1, 6, 20] {
        let (metres, radians) = worst_error(&hull(), delay_ticks);
        assert!(metres < 1.0e-4 && radians < 1.0e-4, "{delay_ticks}: {metres} {radians}");
    }
}

#[test]
fn a_wrong_model_is_predicted_better_than_not_at_all() {
    let mut truth = hull();
    truth.m33_kgm2 *= 1.3;
    truth.yaw_damping[0] *= 0.7;
    let (metres, radians) = worst_error(&truth, 10);
    // Half a second at 1.2 m/s and 0.2 rad/s without prediction: 0.6 m and 0.1 rad.
    assert!(metres < 0.06 && radians < 0.05, "{metres} {radians}");
}

#[test]
fn no_delay_changes_nothing() {
    for delay_s in [0.0, -1.0, f64::NAN] {
        let mut predictor = Predictor::default();
        predictor.set_delay_s(delay_s);
        let motion = WaterMotion { surge_mps: 1.0, sway_mps: 0.1, yaw_rate_radps: 0.2 };
        for i in 0..300 {
            let calm = NorthEast { north_m: 0.0, east_m: 0.0 };
            predictor.advance(0.05);
            assert_eq!(predictor.predict(0.05, &hull(), &at_rest(), motion, calm), (at_rest(), motion));
            predictor.push(wrench(i));
        }
    }
}

#[test]
fn the_store_never_overflows() {
    let mut predictor = Predictor::default();
    predictor.set_delay_s(f64::INFINITY);
    let calm = NorthEast { north_m: 0.0, east_m: 0.0 };
    for i in 0..5000 {
        let dt_s = if i % 7 == 0 { 0.3 } else { 0.001 };
        predictor.advance(dt_s);
        let (state, _) = predictor.predict(dt_s, &hull(), &at_rest(), WaterMotion::default(), calm);
        assert!(state.check().is_ok());
        predictor.push(wrench(i));
        assert!(predictor.count <= CAPACITY);
    }
}
