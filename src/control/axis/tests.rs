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

/// The axis in surge or yaw of every boat that comes with Helmlink, as analysed.
fn axes(damping_at_command: f64) -> Vec<(SlidingAxis, f64)> {
    let boats = crate::control::Boat::names().map(|name| crate::control::Boat::embedded(name).unwrap());
    let analysed = |settings: AxisSettings, nominal, effect| {
        let settings = AxisSettings { dead_zone: 0.0, damping_at_command, disturbance_max: 1.0, ..settings };
        let coupling = 0.2 * settings.typical_rate;
        (SlidingAxis::new(settings, nominal, coupling), effect)
    };
    boats
        .flat_map(|boat| {
            let (hull, control) = (&boat.hull, boat.control.clone());
            [
                analysed(control.surge, hull.surge_parameters(), hull.surge_effect()),
                analysed(control.yaw, hull.yaw_parameters(), hull.yaw_effect()),
            ]
        })
        .collect()
}

proptest! {
    #[test]
    fn the_lyapunov_function_falls_outside_its_bound(
        which in 0..8usize, rate in -2.5..2.5f64, command in -2.5..2.5f64, coupling in -1.5..1.5f64,
        integral in -1.0..1.0f64, bound in 0.0..0.9f64, disturbance in -TRUE_BOUND..TRUE_BOUND,
        true_part in prop::array::uniform4(-0.5..0.5f64), estimate_part in prop::array::uniform4(-0.5..0.5f64),
    ) {
        let (mut axis, effect) = axes(0.0).swap_remove(which);
        let size = axis.settings.typical_rate;
        let (rate, command, coupling) = (size * rate, size * command, 0.2 * size * coupling);
        let integral = integral * axis.settings.integral_max;
        let truth = axis.nominal + axis.freedom.component_mul(&Vector4::from(true_part));
        axis.parameters = axis.nominal + axis.freedom.component_mul(&Vector4::from(estimate_part));
        axis.filter = CommandFilter::starting_at(command);
        (axis.integral, axis.disturbance) = (integral, bound);
        let (fall, floor) = lyapunov_bounds(&axis, &truth);

        // V is taken where S is: at the demand. The estimates it belongs to are those before settling.
        let at = |actual| AxisInput { target: command, actual, drift: 0.0, coupling, effect };
        let mut probe = axis.clone();
        probe.demand(DT_S, &at(rate));
        let before = lyapunov(&probe, &truth);
        let moved = step(&mut axis, DT_S, &at(rate), &truth, disturbance);
        axis.demand(DT_S, &at(moved));
        let after = lyapunov(&axis, &truth);

        let slope = (after - before) / DT_S;
        prop_assert!(slope <= -fall * before + floor + 1.0e-3 * (1.0 + before), "{slope} at V = {before}");
    }

    /// With damping at the command S is driven by the hull's own damping too. For linear damping d the function
    /// V + ½dλξ² pays for it: what is added to its slope is −d e².
    #[test]
    fn damping_at_the_command_only_adds_to_the_fall(
        which in 0..8usize, rate in -2.5..2.5f64, command in -2.5..2.5f64, integral in -1.0..1.0f64,
        bound in 0.0..0.9f64, disturbance in -TRUE_BOUND..TRUE_BOUND, damping_part in 0.4..1.6f64, off_part in -0.5..0.5f64,
    ) {
        let (mut axis, effect) = axes(1.0).swap_remove(which);
        let size = axis.settings.typical_rate;
        let (rate, command, integral) = (size * rate, size * command, integral * axis.settings.integral_max);
        // A hull of linear damping, known up to its size.
        axis.nominal.fill(0.0);
        axis.nominal[1] = -0.5;
        axis.freedom.fill(PROJECTION_PART * 0.5);
        (axis.parameters, axis.filter) = (axis.nominal, CommandFilter::starting_at(command));
        axis.parameters[1] *= 1.0 + off_part;
        (axis.integral, axis.disturbance) = (integral, bound);
        let truth = axis.nominal * damping_part;
        let (damping, slope) = (-truth[1], axis.settings.integral_slope);
        let energy = |axis: &SlidingAxis| lyapunov(axis, &truth) + 0.5 * damping * slope * axis.integral.powi(2);
        let (fall, floor) = lyapunov_bounds(&axis, &truth);

        let at = |actual| AxisInput { target: command, actual, drift: 0.0, coupling: 0.0, effect };
        let mut probe = axis.clone();
        probe.demand(DT_S, &at(rate));
        let (before, pure) = (energy(&probe), lyapunov(&probe, &truth));
        // The hull's own damping acts at its own rate, whatever the law believes.
        let acceleration = -damping * rate + effect * axis.demand(DT_S, &at(rate)) + disturbance;
        let outcome = perfect(&axis);
        axis.settle(DT_S, &at(rate), outcome);
        axis.demand(DT_S, &at(rate + DT_S * acceleration));
        let bonus = damping * (command - rate).powi(2);
        // At its limit ξ rests, and its share of the function with it.
        prop_assume!(axis.integral.abs() < axis.settings.integral_max);
        let slope = (energy(&axis) - before) / DT_S;
        prop_assert!(slope <= -fall * pure + floor - bonus + 1.0e-3 * (1.0 + before), "{slope} at V = {before}");
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

/// The axis after ten minutes at its command, with a measurement that shakes by `shake` and no real error.
fn shaken(settings: AxisSettings, shake: f64) -> SlidingAxis {
    let mut axis = SlidingAxis::new(settings, nominal(), 0.3);
    axis.engage(0.2);
    for tick in 0..12_000 {
        let noise = shake * (1.7 * f64::from(tick)).sin();
        axis.demand(0.05, &input(0.2, 0.2 + noise, 0.05));
        let outcome = perfect(&axis);
        axis.settle(0.05, &input(0.2, 0.2 + noise, 0.05), outcome);
    }
    axis
}

#[test]
fn without_leakage_noise_alone_drives_the_estimates_to_their_limits() {
    let kept = AxisSettings { disturbance_max: 0.134, ..settings() };
    let leaky = AxisSettings { disturbance_leak: 0.0, ..kept.clone() };
    let shake = 0.03;
    assert!(shaken(kept.clone(), shake).disturbance < 0.5 * kept.disturbance_max);
    assert!(shaken(leaky.clone(), shake).disturbance > 0.999 * kept.disturbance_max, "it only ever grows");
    // The dead zone does the same below its width.
    let rested = AxisSettings { dead_zone: 0.1, ..leaky };
    assert_eq!(shaken(rested, shake).disturbance, 0.0);
}

#[test]
fn without_leakage_parameters_keep_what_an_old_disturbance_taught_them() {
    // A push for a minute in one turn; then nothing to learn from for ten minutes.
    let offset_after = |leak: f64| {
        let quick =
            AxisSettings { parameter_rate: 2.0, parameter_leak: leak, disturbance_max: 0.0, ..settings() };
        let mut axis = SlidingAxis::new(quick, nominal(), 0.3);
        let mut actual = 0.0;
        for tick in 0..13_200 {
            let (target, push) = if tick < 1200 { (0.3, -0.2) } else { (0.0, 0.0) };
            actual = step(&mut axis, 0.05, &input(target, actual, 0.0), &nominal(), push);
        }
        (axis.parameters - axis.nominal).component_div(&axis.freedom).amax()
    };
    let (kept, lost) = (offset_after(0.005), offset_after(0.0));
    assert!(lost > 0.1, "{lost}");
    assert!(kept < 0.1 * lost, "{kept} {lost}");
}

/// A boat whose moment is limited to `most` and moves by at most `rate` a second, at the command of each moment: its
/// yaw rate, tick by tick. Anti-windup is told what acts, or that everything does.
fn limited(most: f64, rate: f64, told: bool, command: impl Fn(f64) -> f64) -> Vec<f64> {
    let strong = AxisSettings { acceleration_max: 10.0, filter_s: 0.05, integral_max: 100.0, ..settings() };
    let mut axis = SlidingAxis::new(strong, nominal(), 0.3);
    axis.engage(0.0);
    let (mut actual, mut acting) = (0.0, 0.0f64);
    (0..1200)
        .map(|tick| {
            let input = input(command(0.05 * f64::from(tick)), actual, 0.0);
            let demand = axis.demand(0.05, &input);
            acting += (demand.clamp(-most, most) - acting).clamp(-0.05 * rate, 0.05 * rate);
            let outcome = AxisOutcome { achieved: acting, saturated: (demand - acting).abs() > 1.0e-9 };
            let blind = AxisOutcome { achieved: demand, saturated: false };
            axis.settle(0.05, &input, if told { outcome } else { blind });
            actual += 0.05 * (nominal().dot(&regressor(0.0, actual)) + acting / 42.65);
            actual
        })
        .collect()
}

#[test]
fn an_actuator_that_is_slow_does_not_wind_up() {
    for (most, rate) in [(100.0, 12.0), (80.0, 20.0), (200.0, 20.0), (200.0, 40.0)] {
        let overshoot = |told| limited(most, rate, told, |_| 0.3).into_iter().fold(0.0, f64::max) - 0.3;
        let (told, blind) = (overshoot(true), overshoot(false));
        assert!(told < 0.05, "{most} {rate}: {told}");
        assert!(blind > 1.5 * told, "{most} {rate}: told {told}, blind {blind}");
    }
}

#[test]
fn an_actuator_that_is_weak_does_not_wind_up() {
    // 0.3 rad/s is out of reach for twenty seconds; then 0.1 is wanted.
    let command = |time_s: f64| if time_s < 20.0 { 0.3 } else { 0.1 };
    let seconds_late = |told| {
        let late =
            limited(45.0, 1.0e6, told, command).into_iter().skip(400).filter(|rate| *rate > 0.12).count();
        0.05 * late as f64
    };
    let (told, blind) = (seconds_late(true), seconds_late(false));
    assert!(told < 3.0, "{told}");
    assert!(blind > 2.0 * told, "told {told}, blind {blind}");
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
