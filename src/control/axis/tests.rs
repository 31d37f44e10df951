use proptest::prelude::*;

use super::*;

const DT_S: f64 = 1.0e-6;
/// True disturbance bound δ* of the tests.
const TRUE_BOUND: f64 = 0.1;

/// The Otter's yaw axis, without dead zone and with damping at the measured rate: the law as analysed.
fn settings() -> AxisSettings {
    let boat = crate::control::Boat::embedded("otter").unwrap();
    AxisSettings { dead_zone: 0.0, damping_at_command: 0.0, disturbance_max: 1.0, ..boat.control.yaw }
}

fn nominal() -> Vector4<f64> {
    crate::control::Boat::embedded("otter").unwrap().hull.yaw_parameters()
}

fn axis() -> SlidingAxis {
    SlidingAxis::new(settings(), nominal(), 0.3)
}

fn input(target: f64, actual: f64, coupling: f64) -> AxisInput {
    AxisInput { target, actual, drift: 0.0, coupling, effect: 1.0 / 42.65 }
}

/// What the actuators made of it: everything.
fn perfect(axis: &SlidingAxis) -> AxisOutcome {
    AxisOutcome { achieved: axis.demand, saturated: false }
}

/// V₁ = ½S² + ½Θ̃ᵀΓ⁻¹Θ̃ + ½γ⁻¹δ̃².
fn lyapunov(axis: &SlidingAxis, truth: &Vector4<f64>) -> f64 {
    let off = axis.parameters - truth;
    let bound_off = axis.disturbance - TRUE_BOUND;
    0.5 * axis.surface.powi(2)
        + 0.5 * off.component_div(&axis.adaptation).dot(&off)
        + 0.5 * bound_off.powi(2) / axis.settings.disturbance_rate
}

/// c₁ and C₁ of V̇₁ ≤ −c₁V₁ + C₁.
fn lyapunov_bounds(axis: &SlidingAxis, truth: &Vector4<f64>) -> (f64, f64) {
    let g = &axis.settings;
    let off = truth - axis.nominal;
    let rate = (2.0 * g.reaching_gain).min(g.parameter_leak).min(g.disturbance_rate * g.disturbance_leak);
    let floor = 0.2785 * g.boundary * TRUE_BOUND
        + 0.5 * g.disturbance_leak * TRUE_BOUND.powi(2)
        + 0.5 * g.parameter_leak * off.component_div(&axis.adaptation).dot(&off);
    (rate, floor)
}

/// One step of the axis on its true hull; returns the measured rate after it.
fn step(axis: &mut SlidingAxis, dt_s: f64, input: &AxisInput, truth: &Vector4<f64>, disturbance: f64) -> f64 {
    axis.demand(dt_s, input);
    let acceleration = truth.dot(&axis.regressor) + input.effect * axis.demand + disturbance;
    let outcome = perfect(axis);
    axis.settle(dt_s, input, outcome);
    input.actual + dt_s * acceleration
}

proptest! {
    #[test]
    fn the_lyapunov_function_falls_outside_its_bound(
        rate in -0.5..0.5f64, command in -0.5..0.5f64, coupling in -0.4..0.4f64, integral in -0.5..0.5f64,
        true_part in prop::array::uniform4(-0.5..0.5f64), estimate_part in prop::array::uniform4(-0.5..0.5f64),
        bound in 0.0..0.9f64, disturbance in -TRUE_BOUND..TRUE_BOUND,
    ) {
        let mut axis = axis();
        let truth = axis.nominal + axis.freedom.component_mul(&Vector4::from(true_part));
        axis.parameters = axis.nominal + axis.freedom.component_mul(&Vector4::from(estimate_part));
        axis.filter = CommandFilter::starting_at(command);
        (axis.integral, axis.disturbance) = (integral, bound);
        let (fall, floor) = lyapunov_bounds(&axis, &truth);

        // V is taken where S is: at the demand. The estimates it belongs to are those before settling.
        let mut probe = axis.clone();
        probe.demand(DT_S, &input(command, rate, coupling));
        let before = lyapunov(&probe, &truth);
        let moved = step(&mut axis, DT_S, &input(command, rate, coupling), &truth, disturbance);
        axis.demand(DT_S, &input(command, moved, coupling));
        let after = lyapunov(&axis, &truth);

        let slope = (after - before) / DT_S;
        prop_assert!(slope <= -fall * before + floor + 1.0e-3 * (1.0 + before), "{slope} at V = {before}");
    }

    #[test]
    fn estimates_stay_within_their_projection(
        errors in prop::collection::vec((-3.0..3.0f64, -2.0..2.0f64, 0.005..0.5f64), 1..200)
    ) {
        let mut axis = axis();
        for (target, actual, dt_s) in errors {
            let input = input(target, actual, target * actual);
            axis.demand(dt_s, &input);
            let outcome = perfect(&axis);
            axis.settle(dt_s, &input, outcome);
            let off = axis.parameters - axis.nominal;
            for (moved, limit) in off.iter().zip(axis.freedom.iter()) {
                prop_assert!(moved.abs() <= limit * (1.0 + 1.0e-12));
            }
            prop_assert!((0.0..=axis.settings.disturbance_max).contains(&axis.disturbance));
            prop_assert!(axis.integral.abs() <= axis.settings.integral_max);
            prop_assert!(axis.demand.is_finite());
        }
    }
}

/// The sign of the parameter law, checked against what it is for: S Θ̃ᵀf in V̇ is cancelled.
#[test]
fn parameter_adaptation_cancels_its_term() {
    for (rate, command) in [(0.2, 0.4), (0.4, 0.2), (-0.2, -0.4), (-0.3, 0.3)] {
        let mut axis = axis();
        axis.settings.parameter_leak = 0.0;
        axis.filter = CommandFilter::starting_at(command);
        let input = input(command, rate, 0.1);
        let truth = axis.nominal * 1.2;
        axis.demand(DT_S, &input);
        let (surface, before) = (axis.surface, axis.parameters);
        let outcome = perfect(&axis);
        axis.settle(DT_S, &input, outcome);
        let learned = (axis.parameters - before) / DT_S;
        let cross = surface * (before - truth).dot(&axis.regressor);
        let paid = (before - truth).component_div(&axis.adaptation).dot(&learned);
        assert!((cross + paid).abs() < 1.0e-6 * cross.abs(), "{cross} {paid}");
    }
}

/// The sign of the disturbance law: a surface off zero on either side raises the bound.
#[test]
fn disturbance_bound_grows_with_the_surface_and_leaks() {
    for command in [0.4, -0.4] {
        let mut axis = axis();
        axis.filter = CommandFilter::starting_at(command);
        let input = input(command, 0.0, 0.0);
        axis.demand(0.05, &input);
        let outcome = perfect(&axis);
        axis.settle(0.05, &input, outcome);
        assert!(axis.disturbance > 0.0);
        axis.surface = 0.0;
        let grown = axis.disturbance;
        axis.adapt(0.05);
        assert!(axis.disturbance < grown);
    }
}

fn error_after(mut axis: SlidingAxis, seconds: f64) -> f64 {
    let truth = axis.nominal.component_mul(&Vector4::new(1.0, 1.3, 1.3, 1.0));
    let mut actual = 0.0;
    let mut worst_late = 0.0f64;
    let steps = (seconds / 0.05) as usize;
    for tick in 0..steps {
        let target = 0.25 * (0.2 * tick as f64 * 0.05).sin();
        actual = step(&mut axis, 0.05, &input(target, actual, 0.2), &truth, 0.05);
        if tick > steps / 2 {
            let error = (axis.filtered() - actual).abs();
            worst_late = worst_late.max(if error.is_finite() { error } else { f64::INFINITY });
        }
    }
    worst_late
}

#[test]
fn the_wrong_sign_of_adaptation_drives_the_error_up() {
    // Little feedback, so that adaptation decides.
    let quick = AxisSettings {
        parameter_rate: 2.0,
        disturbance_max: 0.0,
        reaching_gain: 0.3,
        integral_slope: 0.0,
        ..settings()
    };
    let right = SlidingAxis::new(quick.clone(), nominal(), 0.3);
    let mut wrong = right.clone();
    wrong.adaptation = -wrong.adaptation;
    let mut still = right.clone();
    still.adaptation *= 0.0;
    let (right, wrong, still) =
        (error_after(right, 400.0), error_after(wrong, 400.0), error_after(still, 400.0));
    assert!(right < 0.7 * still, "adapting {right}, not adapting {still}");
    assert!(wrong > 1.3 * still, "wrong sign {wrong}, not adapting {still}");
}

#[test]
fn a_constant_disturbance_leaves_no_error() {
    let mut axis = axis();
    let mut actual = 0.0;
    for _ in 0..2000 {
        actual = step(&mut axis, 0.05, &input(0.2, actual, 0.0), &nominal(), 0.05);
    }
    assert!((actual - 0.2).abs() < 1.0e-4, "{actual}");
}

#[test]
fn saturation_neither_winds_up_nor_adapts() {
    let mut axis = axis();
    let mut actual = 0.0;
    let blocked = AxisOutcome { achieved: 0.0, saturated: true };
    for _ in 0..2000 {
        let input = input(0.3, actual, 0.0);
        axis.demand(0.05, &input);
        axis.settle(0.05, &input, blocked);
    }
    assert!(axis.integral.abs() < 1.0e-9);
    assert_eq!(axis.parameters, axis.nominal);
    assert_eq!(axis.disturbance, 0.0);
    // Freed, it comes to the command without a large overshoot.
    let mut most = 0.0f64;
    for _ in 0..400 {
        actual = step(&mut axis, 0.05, &input(0.3, actual, 0.0), &nominal(), 0.0);
        most = most.max(actual);
    }
    assert!((actual - 0.3).abs() < 1.0e-2, "{actual}");
    assert!(most < 0.36, "{most}");
}

#[test]
fn nothing_is_learned_inside_the_dead_zone() {
    let mut axis = SlidingAxis::new(AxisSettings { dead_zone: 0.05, ..settings() }, nominal(), 0.3);
    axis.engage(0.2);
    let input = input(0.2, 0.19, 0.1);
    axis.demand(0.05, &input);
    let outcome = perfect(&axis);
    axis.settle(0.05, &input, outcome);
    assert_eq!(axis.parameters, axis.nominal);
    assert_eq!(axis.disturbance, 0.0);
}

#[test]
fn engaging_does_not_jump() {
    let mut axis = axis();
    axis.engage(0.2);
    let demand = axis.demand(0.05, &input(0.2, 0.2, 0.0));
    let holding = -42.65 * nominal().dot(&regressor(0.0, 0.2));
    assert!((demand - holding).abs() < 1.0e-9, "{demand} {holding}");
}

#[test]
fn the_filter_is_stable_at_any_step() {
    for dt_s in [0.001, 0.02, 0.05, 0.2, 1.0] {
        let mut axis = axis();
        let mut last = 0.0;
        for _ in 0..200 {
            axis.demand(dt_s, &input(0.3, 0.0, 0.0));
            assert!(axis.filtered() >= last - 1.0e-12 && axis.filtered() <= 0.3 + 1.0e-12);
            last = axis.filtered();
        }
    }
}
