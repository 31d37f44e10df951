//! Whether a hull that is positive definite can also be steered, driven and integrated.

use super::hull::{Damping, Hull, HullDynamics, HullError, Maneuvering, Propulsion};

/// Fastest settling the integration follows safely at its longest step of 20 ms, 1/s: fourth-order
/// Runge–Kutta is stable up to 2.78 per step.
const FASTEST_SETTLING_PER_S: f64 = 50.0;

/// Refuses what would fly apart numerically or could not reach its own cruise speed.
pub(super) fn check(hull: &Hull) -> Result<(), HullError> {
    if let HullDynamics::Maneuvering(body, drive) = &hull.dynamics {
        let thrust_n = ahead_limit_n(drive);
        let (sway, yaw) = with_cross_flow(body);
        settles("surge", &body.surge, "inertia.m11_kg", body.m11_kg, thrust_n)?;
        settles("sway", &sway, "inertia.m22_kg", body.m22_kg, thrust_n)?;
        settles("yaw", &yaw, "inertia.m33_kgm2", body.m33_kgm2, thrust_n * arm_m(drive))?;
    }
    let top_mps = hull.top_speed_mps();
    if hull.cruise_speed_mps > top_mps {
        return Err(HullError::Layout(format!(
            "hull key `cruise_speed_mps` is {}, but full thrust reaches only {top_mps:.2} m/s: lower the cruise \
             speed or the surge damping, or raise the thrust limit",
            hull.cruise_speed_mps
        )));
    }
    Ok(())
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
    motion: &str,
    damping: &Damping,
    inertia_key: &str,
    inertia: f64,
    force: f64,
) -> Result<(), HullError> {
    let x = terminal_velocity(damping, force);
    let slope = damping.linear + 2.0 * damping.quadratic * x + 3.0 * damping.cubic * x * x;
    let rate_per_s = slope / inertia;
    if rate_per_s <= FASTEST_SETTLING_PER_S {
        return Ok(());
    }
    Err(HullError::Layout(format!(
        "the {motion} of this hull settles in {:.1e} s, faster than the simulation can follow ({} s): lower \
         `damping.{motion}` or the thrust limit, or raise `{inertia_key}`",
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
        assert!(message.contains("sway") && message.contains("inertia.m22_kg"), "{message}");
    }

    #[test]
    fn an_unreachable_cruise_speed_is_refused() {
        let text =
            Hull::builtin_text("otter").unwrap().replace("cruise_speed_mps = 1.5", "cruise_speed_mps = 4");
        let message = Hull::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains("3.09 m/s"), "{message}");
    }

    #[test]
    fn a_boat_without_drag_has_no_top_speed() {
        assert_eq!(terminal_velocity(&Damping::default(), 1.0), f64::INFINITY);
        assert!(
            (terminal_velocity(&Damping { quadratic: 2.0, ..Damping::default() }, 18.0) - 3.0).abs() < 1e-9
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

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
                let sea = Sea::preset(SeaState::Slight, &hull);
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
