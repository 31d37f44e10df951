//! Equations of motion in surge, sway and yaw, and their integration.
//!
//! `M ν̇_r + C(ν_r)ν_r + D(ν_r)ν_r = τ`, ν_r = ν − R(ψ)ᵀV_c (Fossen 2021, eq. 6.1 and §10.3). The current is
//! irrotational, so the velocity over ground obeys `ν̇ = ν̇_r + [r·v_c, −r·u_c, 0]`.

use super::hull::{CrossFlow, Maneuvering, Motorboat};

/// Position, heading and velocity over ground of the hull (without wave-frequency motion).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Metres north of the local origin.
    pub north_m: f64,
    /// Metres east of the local origin.
    pub east_m: f64,
    /// Heading, clockwise from north, in (−π, π].
    pub psi_rad: f64,
    /// Speed over ground along the bow, m/s.
    pub u_mps: f64,
    /// Speed over ground to starboard, m/s.
    pub v_mps: f64,
    /// Yaw rate, positive to starboard, rad/s.
    pub r_radps: f64,
}

impl State {
    /// Velocity over ground in NED, m/s: (north, east).
    pub fn velocity_ned_mps(&self) -> (f64, f64) {
        to_ned(self.psi_rad, self.u_mps, self.v_mps)
    }

    /// Velocity through the water in body axes, m/s: (surge, sway), given the current.
    pub fn through_water_mps(&self, current: NedVector) -> (f64, f64) {
        let (u_c, v_c) = to_body(self.psi_rad, current.north, current.east);
        (self.u_mps - u_c, self.v_mps - v_c)
    }
}

/// A horizontal vector in NED.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NedVector {
    /// Northward component.
    pub north: f64,
    /// Eastward component.
    pub east: f64,
}

impl NedVector {
    /// Components (forward, to starboard) for a boat whose bow points along the unit vector `bow`.
    pub fn in_body(self, bow: NedVector) -> (f64, f64) {
        (self.north * bow.north + self.east * bow.east, self.east * bow.north - self.north * bow.east)
    }
}

/// A generalised force in body axes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyForce {
    /// Forward, N.
    pub surge_n: f64,
    /// To starboard, N.
    pub sway_n: f64,
    /// Yaw moment, positive to starboard, N·m.
    pub yaw_nm: f64,
}

impl std::ops::Add for BodyForce {
    type Output = BodyForce;

    fn add(self, other: BodyForce) -> BodyForce {
        BodyForce {
            surge_n: self.surge_n + other.surge_n,
            sway_n: self.sway_n + other.sway_n,
            yaw_nm: self.yaw_nm + other.yaw_nm,
        }
    }
}

/// Rotates body components into NED.
pub fn to_ned(psi_rad: f64, forward: f64, starboard: f64) -> (f64, f64) {
    let (sin, cos) = psi_rad.sin_cos();
    (forward * cos - starboard * sin, forward * sin + starboard * cos)
}

/// Rotates NED components into body axes.
pub fn to_body(psi_rad: f64, north: f64, east: f64) -> (f64, f64) {
    let (sin, cos) = psi_rad.sin_cos();
    NedVector { north, east }.in_body(NedVector { north: cos, east: sin })
}

/// The angle in (−π, π].
pub(super) fn wrap(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    let turned = angle_rad.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

/// Strips of the cross-flow integral: Fossen's `crossFlowDrag` sums 21 stations from stern to bow, each
/// weighted with a twentieth of the length. Kept so, that the model is the published one.
const CROSS_FLOW_STATIONS: usize = 21;

/// Sway force and yaw moment of the cross flow, N and N·m (Fossen 2021, eq. 6.92 and 6.93).
fn cross_flow_drag(cross_flow: &CrossFlow, v_mps: f64, r_radps: f64) -> (f64, f64) {
    let spacing_m = cross_flow.length_m / (CROSS_FLOW_STATIONS - 1) as f64;
    let (mut force, mut moment) = (0.0, 0.0);
    let mut x_m = -0.5 * cross_flow.length_m;
    for _ in 0..CROSS_FLOW_STATIONS {
        let speed = v_mps + x_m * r_radps;
        let pressure = speed.abs() * speed;
        force -= pressure;
        moment -= x_m * pressure;
        x_m += spacing_m;
    }
    let strip = cross_flow.strip_n_per_m_mps2 * spacing_m;
    (strip * force, strip * moment)
}

/// Accelerations relative to the water, (m/s², m/s², rad/s²), for velocities relative to the water.
fn acceleration(hull: &Maneuvering, nu_r: [f64; 3], tau: BodyForce) -> [f64; 3] {
    let [u, v, r] = nu_r;
    let (cross_sway_n, cross_yaw_nm) =
        hull.cross_flow.as_ref().map_or((0.0, 0.0), |strips| cross_flow_drag(strips, v, r));
    // C(ν)ν of a symmetric M (Fossen 2021, eq. 3.64): includes the Munk moment (m22 − m11)·u·v.
    let momentum_sway = hull.m22_kg * v + hull.m23_kgm * r;
    let momentum_surge = hull.m11_kg * u;
    let surge_n = tau.surge_n + momentum_sway * r - hull.surge.force(u);
    let sway_n = tau.sway_n - momentum_surge * r - hull.sway.force(v) + cross_sway_n;
    let yaw_nm = tau.yaw_nm - momentum_sway * u + momentum_surge * v - hull.yaw.force(r) + cross_yaw_nm;
    let determinant = hull.m22_kg * hull.m33_kgm2 - hull.m23_kgm * hull.m23_kgm;
    [
        surge_n / hull.m11_kg,
        (hull.m33_kgm2 * sway_n - hull.m23_kgm * yaw_nm) / determinant,
        (hull.m22_kg * yaw_nm - hull.m23_kgm * sway_n) / determinant,
    ]
}

/// Time derivative of [north, east, psi, u, v, r].
fn derivative(hull: &Maneuvering, x: [f64; 6], tau: BodyForce, current: NedVector) -> [f64; 6] {
    let [_, _, psi, u, v, r] = x;
    let (sin, cos) = psi.sin_cos();
    let u_c = current.north * cos + current.east * sin;
    let v_c = current.east * cos - current.north * sin;
    let [du, dv, dr] = acceleration(hull, [u - u_c, v - v_c, r], tau);
    [u * cos - v * sin, u * sin + v * cos, r, du + r * v_c, dv - r * u_c, dr]
}

fn advanced(x: [f64; 6], dt_s: f64, rate: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|i| x[i] + dt_s * rate[i])
}

/// One fourth-order Runge–Kutta step with the force held constant.
pub fn step_maneuvering(
    hull: &Maneuvering,
    state: State,
    tau: BodyForce,
    current: NedVector,
    dt_s: f64,
) -> State {
    let x = [state.north_m, state.east_m, state.psi_rad, state.u_mps, state.v_mps, state.r_radps];
    let k1 = derivative(hull, x, tau, current);
    let k2 = derivative(hull, advanced(x, 0.5 * dt_s, k1), tau, current);
    let k3 = derivative(hull, advanced(x, 0.5 * dt_s, k2), tau, current);
    let k4 = derivative(hull, advanced(x, dt_s, k3), tau, current);
    let mean: [f64; 6] = std::array::from_fn(|i| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0);
    let [north_m, east_m, psi, u_mps, v_mps, r_radps] = advanced(x, dt_s, mean);
    State { north_m, east_m, psi_rad: wrap(psi), u_mps, v_mps, r_radps }
}

/// One step of the kinematic motor boat.
///
/// `throttle` and `steering` are in [−1, 1]. The yaw rate is 2u/d with d = circle·sin(limit)/sin(limit·steering),
/// where u is the speed through the water (ArduPilot SIM_Sailboat.cpp, `get_yaw_rate`); the boat never slips
/// sideways through the water, and the current is added to its velocity.
pub fn step_motorboat(
    boat: &Motorboat,
    state: State,
    throttle: f64,
    steering: f64,
    current: NedVector,
    dt_s: f64,
) -> State {
    let (u_r, _) = state.through_water_mps(current);
    let thrust_n = boat.thrust_limit_n * throttle;
    let speed = |u: f64| (thrust_n - boat.drag_n_per_mps2 * u.abs() * u) / boat.mass_kg;
    // Heun's method: drag is smooth and slow against a step of milliseconds.
    let first = speed(u_r);
    let next_u_r = u_r + 0.5 * dt_s * (first + speed(u_r + dt_s * first));
    let mean_u_r = 0.5 * (u_r + next_u_r);
    let curvature_per_m = 2.0 * (boat.steering_limit_rad * steering).sin()
        / (boat.turning_circle_m * boat.steering_limit_rad.sin());
    let turn_rad = mean_u_r * curvature_per_m * dt_s;
    let (north_mps, east_mps) = to_ned(state.psi_rad + 0.5 * turn_rad, mean_u_r, 0.0);
    let psi_rad = wrap(state.psi_rad + turn_rad);
    let (u_c, v_c) = to_body(psi_rad, current.north, current.east);
    State {
        north_m: state.north_m + dt_s * (north_mps + current.north),
        east_m: state.east_m + dt_s * (east_mps + current.east),
        psi_rad,
        u_mps: next_u_r + u_c,
        v_mps: v_c,
        r_radps: next_u_r * curvature_per_m,
    }
}
