//! Whether a hull that is positive definite can also be steered, driven and integrated.

use super::WATER_DENSITY_KGPM3;
use super::hull::{Damping, Hull, HullDynamics, HullError, Maneuvering, Propulsion};

/// Fastest settling the integration follows safely at its longest step of 20 ms, 1/s: fourth-order
/// Runge–Kutta is stable up to 2.78 per step.
const FASTEST_SETTLING_PER_S: f64 = 50.0;

/// Refuses what would fly apart numerically or could not reach its own cruise speed.
pub(super) fn check(hull: &Hull) -> Result<(), HullError> {
    match &hull.dynamics {
        HullDynamics::Maneuvering(body, drive) => {
            floats(hull, body)?;
            let thrust_n = ahead_limit_n(drive);
            let (sway, yaw) = with_cross_flow(body);
            // What is left of the inertias when the coupled motion is free to give way.
            let coupling = body.m23_kgm * body.m23_kgm;
            let (sway_kg, yaw_kgm2) =
                (body.m22_kg - coupling / body.m33_kgm2, body.m33_kgm2 - coupling / body.m22_kg);
            settles("damping.surge", &body.surge, "inertia.m11_kg", body.m11_kg, thrust_n)?;
            settles("damping.sway", &sway, "inertia.m22_kg", sway_kg, thrust_n)?;
            settles("damping.yaw", &yaw, "inertia.m33_kgm2", yaw_kgm2, thrust_n * arm_m(drive))?;
        }
        HullDynamics::Motorboat(boat) => {
            let drag = Damping { quadratic: boat.drag_n_per_mps2, ..Damping::default() };
            settles(
                "motorboat.drag_n_per_mps2",
                &drag,
                "motorboat.mass_kg",
                boat.mass_kg,
                boat.thrust_limit_n,
            )?;
        }
    }
    let top_mps = hull.top_speed_mps();
    if hull.cruise_speed_mps > top_mps {
        return Err(HullError::Layout(format!(
            "hull key `cruise_speed_mps` is {}, but full thrust reaches only {top_mps:.2} m/s: lower the cruise \
             speed or the surge damping, or raise the thrust limit",
            hull.cruise_speed_mps
        )));
    }
    match &hull.dynamics {
        HullDynamics::Maneuvering(body, _) => keeps_straight(hull, body),
        HullDynamics::Motorboat(_) => Ok(()),
    }
}

/// Least and greatest mean draught m11/(ρ·L·B), as a share of the beam, that mass, length and beam of one and
/// the same boat can give.
const DRAUGHT_PER_BEAM: (f64, f64) = (0.005, 2.0);
/// Greatest windage, as a multiple of beam² from ahead and of length² from the side.
const WINDAGE: f64 = 3.0;

/// Mass, size and windage must belong to one boat: wind and waves are scaled with the size.
fn floats(hull: &Hull, body: &Maneuvering) -> Result<(), HullError> {
    let draught_m = body.m11_kg / (WATER_DENSITY_KGPM3 * hull.length_m * hull.beam_m);
    let (least_m, greatest_m) = (DRAUGHT_PER_BEAM.0 * hull.beam_m, DRAUGHT_PER_BEAM.1 * hull.beam_m);
    if !(least_m..=greatest_m).contains(&draught_m) {
        return Err(HullError::Layout(format!(
            "a hull of {} m by {} m and {} kg would draw {draught_m:.2e} m, outside {least_m:.2e} to \
             {greatest_m:.2e} m: `length_m`, `beam_m` and `inertia.m11_kg` do not fit each other",
            hull.length_m, hull.beam_m, body.m11_kg
        )));
    }
    let Some(wind) = &hull.wind else { return Ok(()) };
    let limit = |key: &str, area_m2: f64, side_m: f64| {
        let most_m2 = WINDAGE * side_m * side_m;
        if area_m2 <= most_m2 {
            return Ok(());
        }
        let allowed = format!("at most {most_m2:.2} m² on a hull of this size");
        Err(HullError::OutOfRange { key: key.to_owned(), line: None, value: area_m2, allowed })
    };
    limit("wind.frontal_area_m2", wind.frontal_area_m2, hull.beam_m)?;
    limit("wind.lateral_area_m2", wind.lateral_area_m2, hull.length_m)
}

/// Fastest growth of a swerve that a helmsman can follow, as e-folds per length travelled. Ships that are
/// called unstable reach a half, the Otter 0.4.
const FASTEST_SWERVE: f64 = 1.0;

/// In still water at cruise speed and with the helm amidships, sway and yaw must not run away from each other:
/// straight-line stability (Fossen 2021, §15.1), with some room for hulls that need a helmsman.
fn keeps_straight(hull: &Hull, body: &Maneuvering) -> Result<(), HullError> {
    let u = hull.cruise_speed_mps;
    let determinant = body.m22_kg * body.m33_kgm2 - body.m23_kgm * body.m23_kgm;
    // Forces per sway speed and yaw rate, linearised; the Munk moment is (m11 − m22)·u·v.
    let (sway_v, sway_r) = (-body.sway.linear, -body.m11_kg * u);
    let (yaw_v, yaw_r) = ((body.m11_kg - body.m22_kg) * u, -body.m23_kgm * u - body.yaw.linear);
    let sway = |sway: f64, yaw: f64| (body.m33_kgm2 * sway - body.m23_kgm * yaw) / determinant;
    let turn = |sway: f64, yaw: f64| (body.m22_kg * yaw - body.m23_kgm * sway) / determinant;
    let trace = sway(sway_v, yaw_v) + turn(sway_r, yaw_r);
    let product = sway(sway_v, yaw_v) * turn(sway_r, yaw_r) - sway(sway_r, yaw_r) * turn(sway_v, yaw_v);
    let growth_per_s = 0.5 * trace + (0.25 * trace * trace - product).max(0.0).sqrt();
    let growth = growth_per_s * hull.length_m / u;
    if growth <= FASTEST_SWERVE {
        return Ok(());
    }
    Err(HullError::Layout(format!(
        "the hull is unstable in still water: at {u} m/s a swerve grows {:.1}-fold over each length travelled, \
         faster than any helm can follow (at most {:.1}-fold); raise `damping.sway.linear` or \
         `damping.yaw.linear`, or bring `inertia.m22_kg` closer to `inertia.m11_kg`",
        growth.exp(),
        FASTEST_SWERVE.exp()
    )))
}

/// Largest thrust ahead of the whole drive, N.
pub(super) fn ahead_limit_n(drive: &Propulsion) -> f64 {
    match drive {
        Propulsion::TwinThrusters(twin) => 2.0 * twin.ahead_limit_n,
        Propulsion::PropellerRudder(drive) | Propulsion::Outboard(drive) => drive.ahead_limit_n,
    }
}

fn arm_m(drive: &Propulsion) -> f64 {
    match drive {
        Propulsion::TwinThrusters(twin) => twin.arm_m,
        Propulsion::PropellerRudder(drive) | Propulsion::Outboard(drive) => drive.arm_m,
    }
}

/// Sway and yaw damping including the cross flow: its strips give k·L·|v|v and k·L⁴/32·|r|r.
fn with_cross_flow(body: &Maneuvering) -> (Damping, Damping) {
    let (mut sway, mut yaw) = (body.sway, body.yaw);
    if let Some(strips) = &body.cross_flow {
        sway.quadratic += strips.strip_n_per_m_mps2 * strips.length_m;
        yaw.quadratic += strips.strip_n_per_m_mps2 * strips.length_m.powi(4) / 32.0;
    }
    (sway, yaw)
}

fn settles(
    drag_key: &str,
    damping: &Damping,
    inertia_key: &str,
    inertia: f64,
    force: f64,
) -> Result<(), HullError> {
    let x = terminal_velocity(damping, force);
    if x.is_infinite() {
        return Err(HullError::Layout(format!("`{drag_key}` never balances full thrust: raise it")));
    }
    let slope = damping.linear + 2.0 * damping.quadratic * x + 3.0 * damping.cubic * x * x;
    let rate_per_s = slope / inertia;
    if rate_per_s <= FASTEST_SETTLING_PER_S {
        return Ok(());
    }
    Err(HullError::Layout(format!(
        "at full thrust this hull settles in {:.1e} s, faster than the simulation can follow ({} s): lower \
         `{drag_key}` or the thrust limit, or raise `{inertia_key}`",
        1.0 / rate_per_s,
        1.0 / FASTEST_SETTLING_PER_S
    )))
}

/// Velocity at which `damping` balances `force` > 0; infinite without damping.
pub(super) fn terminal_velocity(damping: &Damping, force: f64) -> f64 {
    /// No boat is faster, m/s or rad/s.
    const BEYOND: f64 = 1e6;
    if damping.force(BEYOND) < force {
        return f64::INFINITY;
    }
    let (mut low, mut high) = (0.0, BEYOND);
    // Each bisection gains one bit; a double has no more than these.
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if damping.force(middle) < force { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::{ActuatorCommand, Pose, STEP_S, Sea, SeaState, SensorSettings, Vessel};
    use proptest::prelude::*;

    #[test]
    fn a_hull_too_stiff_to_integrate_is_refused() {
        let text = Hull::builtin_text("otter").unwrap().replace("linear = 162.5", "linear = 162500");
        let message = Hull::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains("damping.sway") && message.contains("inertia.m22_kg"), "{message}");
    }

    #[test]
    fn an_unreachable_cruise_speed_is_refused() {
        let text =
            Hull::builtin_text("otter").unwrap().replace("cruise_speed_mps = 1.5", "cruise_speed_mps = 4");
        let message = Hull::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains("3.09 m/s"), "{message}");
    }

    #[test]
    fn a_hull_whose_size_does_not_fit_its_mass_is_refused() {
        let text =
            Hull::builtin_text("otter").unwrap().replace("length_m = 2.0\nbeam", "length_m = 320.0\nbeam");
        let message = Hull::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains("320 m by 1.08 m and 85.5 kg"), "{message}");
        let text =
            Hull::builtin_text("otter").unwrap().replace("lateral_area_m2 = 0.6", "lateral_area_m2 = 60");
        assert!(Hull::from_toml(&text).unwrap_err().to_string().contains("at most 12.00 m²"));
    }

    #[test]
    fn a_hull_without_drag_is_refused() {
        let text = Hull::builtin_text("otter").unwrap().replace("linear = 77.554", "linear = 0");
        assert!(Hull::from_toml(&text).unwrap_err().to_string().contains("`damping.surge` never balances"));
    }

    #[test]
    fn a_hull_that_no_helm_can_follow_is_refused() {
        let text = Hull::builtin_text("otter").unwrap();
        let text = text.replace("m22_kg = 162.5", "m22_kg = 562.5").replace("linear = 162.5", "linear = 16");
        let message = Hull::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains("unstable in still water"), "{message}");
        assert!(message.contains("damping.yaw.linear"), "{message}");
    }

    #[test]
    fn a_figure_out_of_its_range_names_its_line() {
        let text = Hull::builtin_text("otter").unwrap().replace("m11_kg = 85.5", "m11_kg = -85.5");
        let line = text.lines().position(|line| line.starts_with("m11_kg")).unwrap() + 1;
        let message = Hull::from_toml(&text).unwrap_err().to_string();
        let expected = format!("`inertia.m11_kg` (line {line}) is -85.5: it must be between");
        assert!(message.contains(&expected), "{message}");
    }

    #[test]
    fn a_boat_without_drag_has_no_top_speed() {
        assert_eq!(terminal_velocity(&Damping::default(), 1.0), f64::INFINITY);
        assert!(
            (terminal_velocity(&Damping { quadratic: 2.0, ..Damping::default() }, 18.0) - 3.0).abs() < 1e-9
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// A hull file with any one number replaced is refused or gives a boat whose motion stays finite.
        #[test]
        fn no_number_in_a_hull_file_breaks_the_simulation(
            index in 0usize..4,
            line in 0usize..60,
            value in prop_oneof![any::<f64>(), -1e3f64..1e3, 0.0f64..1.0],
        ) {
            let text = Hull::builtin_text(Hull::names().nth(index).unwrap()).unwrap();
            let mutated: Vec<String> = text.lines().enumerate().map(|(i, original)| {
                match original.split_once(" = ") {
                    Some((key, _)) if i == line && !original.starts_with('#') => format!("{key} = {value:?}"),
                    _ => original.to_owned(),
                }
            }).collect();
            if let Ok(hull) = Hull::from_toml(&mutated.join("\n")) {
                let sea = Sea { depth_m: Some(0.5), ..Sea::preset(SeaState::Slight, &hull) };
                let mut vessel = Vessel::new(hull, &sea, &SensorSettings::perfect(), 1, Pose::default());
                let command = ActuatorCommand::ThrottleSteering { throttle: 0.8, steering: 0.3 };
                for _ in 0..500 {
                    vessel.step(STEP_S, command);
                }
                let state = vessel.truth().hull;
                prop_assert!(state.north_m.is_finite() && state.v_mps.is_finite() && state.r_radps.is_finite());
            }
        }
    }
}
