//! Equations of motion in surge, sway and yaw, and their integration.
//!
//! `M ν̇_r + C(ν_r)ν_r + D(ν_r)ν_r = τ`, ν_r = ν − R(ψ)ᵀV_c (Fossen 2021, eq. 6.1 and §10.3). The current is
//! irrotational, so the velocity over ground obeys `ν̇ = ν̇_r + [r·v_c, −r·u_c, 0]`.

use super::angles::{turned, unit};
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
        let velocity = NedVector::of_body(self.u_mps, self.v_mps, self.bow());
        (velocity.north, velocity.east)
    }

    /// The unit vector along the bow.
    pub fn bow(&self) -> NedVector {
        unit(self.psi_rad)
    }

    /// Velocity through the water in body axes, m/s: (surge, sway), given the current and the unit vector along
    /// the bow.
    #[inline]
    pub fn through_water_mps(&self, bow: NedVector, current: NedVector) -> (f64, f64) {
        let (u_c, v_c) = current.in_body(bow);
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
    /// The vector with these components forward and to starboard of a boat whose bow points along `bow`.
    #[inline]
    pub fn of_body(forward: f64, starboard: f64, bow: NedVector) -> NedVector {
        NedVector {
            north: forward * bow.north - starboard * bow.east,
            east: forward * bow.east + starboard * bow.north,
        }
    }

    /// Components (forward, to starboard) for a boat whose bow points along the unit vector `bow`.
    #[inline]
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

/// The angle in (−π, π].
#[inline]
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
/// Stations on either side of the middle one.
const CROSS_FLOW_HALF: f64 = 10.0;

/// For each number of stations on the negative side, counted from the stern: the sums of all stations' places to
/// the powers 0 to 3, those on the negative side with a minus. In spacings from amidships: whole numbers, so exact.
const SIGNED_SUMS: [[f64; 4]; CROSS_FLOW_STATIONS + 1] = {
    let mut sums = [[0.0; 4]; CROSS_FLOW_STATIONS + 1];
    let mut negative = 0;
    while negative <= CROSS_FLOW_STATIONS {
        let mut i = 0;
        while i < CROSS_FLOW_STATIONS {
            let sign = if i < negative { -1.0 } else { 1.0 };
            let x = i as f64 - CROSS_FLOW_HALF;
            let [count, first, second, third] = sums[negative];
            sums[negative] =
                [count + sign, first + sign * x, second + sign * x * x, third + sign * x * x * x];
            i += 1;
        }
        negative += 1;
    }
    sums
};

/// The sums with the signs that the cross flow has at each station now: it changes its sign at one place at most.
fn signed_sums(cross_flow: &CrossFlow, v_mps: f64, r_radps: f64) -> [f64; 4] {
    let per_station_mps = r_radps * spacing_m(cross_flow);
    // Without a turn the place is beyond bow or stern, as the signs have it; in still water it does not matter.
    let place = CROSS_FLOW_HALF - v_mps / per_station_mps;
    // A station in the very place counts for nothing.
    let stations_astern = (place + 1.0).clamp(0.0, CROSS_FLOW_STATIONS as f64) as u8;
    let sign_ahead = 1f64.copysign(per_station_mps);
    SIGNED_SUMS[usize::from(stations_astern)].map(|sum| sign_ahead * sum)
}

fn spacing_m(cross_flow: &CrossFlow) -> f64 {
    cross_flow.length_m / (CROSS_FLOW_STATIONS - 1) as f64
}

/// Sway force and yaw moment of the cross flow, N and N·m (Fossen 2021, eq. 6.92 and 6.93).
///
/// The flow at station x is v + x·r, and its pressure the flow times its magnitude: with known signs the sums over
/// the stations are polynomials in v and r.
#[inline]
fn cross_flow_drag(cross_flow: &CrossFlow, signed: [f64; 4], v_mps: f64, r_radps: f64) -> (f64, f64) {
    let spacing_m = spacing_m(cross_flow);
    let per_station_mps = r_radps * spacing_m;
    let (constant, linear, square) =
        (v_mps * v_mps, 2.0 * v_mps * per_station_mps, per_station_mps * per_station_mps);
    let pressure = constant * signed[0] + linear * signed[1] + square * signed[2];
    let moment = constant * signed[1] + linear * signed[2] + square * signed[3];
    let strip = cross_flow.strip_n_per_m_mps2 * spacing_m;
    (-strip * pressure, -strip * spacing_m * moment)
}

/// A hull under forces that are constant for a step.
struct Pushed<'a> {
    hull: &'a Maneuvering,
    tau: BodyForce,
    current: NedVector,
    per_m11: f64,
    per_determinant: f64,
    /// Signs of the cross flow at the start of the step: a station where they change within it has next to none.
    signed: [f64; 4],
}

impl<'a> Pushed<'a> {
    fn new(hull: &'a Maneuvering, state: &State, bow: NedVector, tau: BodyForce, current: NedVector) -> Self {
        let (_, v_r_mps) = state.through_water_mps(bow, current);
        let signed = hull.cross_flow.map_or([0.0; 4], |strips| signed_sums(&strips, v_r_mps, state.r_radps));
        let determinant = hull.m22_kg * hull.m33_kgm2 - hull.m23_kgm * hull.m23_kgm;
        Self { hull, tau, current, per_m11: 1.0 / hull.m11_kg, per_determinant: 1.0 / determinant, signed }
    }

    /// Accelerations relative to the water, (m/s², m/s², rad/s²), for velocities relative to the water.
    #[inline]
    fn acceleration(&self, [u, v, r]: [f64; 3]) -> [f64; 3] {
        let (hull, tau) = (self.hull, self.tau);
        let (cross_sway_n, cross_yaw_nm) =
            hull.cross_flow.as_ref().map_or((0.0, 0.0), |strips| cross_flow_drag(strips, self.signed, v, r));
        // C(ν)ν of a symmetric M (Fossen 2021, eq. 3.64): includes the Munk moment (m22 − m11)·u·v.
        let momentum_sway = hull.m22_kg * v + hull.m23_kgm * r;
        let momentum_surge = hull.m11_kg * u;
        let surge_n = tau.surge_n + momentum_sway * r - hull.surge.force(u);
        let sway_n = tau.sway_n - momentum_surge * r - hull.sway.force(v) + cross_sway_n;
        let yaw_nm = tau.yaw_nm - momentum_sway * u + momentum_surge * v - hull.yaw.force(r) + cross_yaw_nm;
        [
            surge_n * self.per_m11,
            (hull.m33_kgm2 * sway_n - hull.m23_kgm * yaw_nm) * self.per_determinant,
            (hull.m22_kg * yaw_nm - hull.m23_kgm * sway_n) * self.per_determinant,
        ]
    }

    /// Time derivative of [north, east, psi, u, v, r] with the bow along the unit vector `bow`.
    #[inline]
    fn derivative(&self, [_, _, _, u, v, r]: [f64; 6], bow: NedVector) -> [f64; 6] {
        let (u_c, v_c) = self.current.in_body(bow);
        let [du, dv, dr] = self.acceleration([u - u_c, v - v_c, r]);
        let over_ground = NedVector::of_body(u, v, bow);
        [over_ground.north, over_ground.east, r, du + r * v_c, dv - r * u_c, dr]
    }
}

#[inline]
fn advanced(x: [f64; 6], dt_s: f64, rate: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|i| x[i] + dt_s * rate[i])
}

/// Of each slope: how far along the one before it is taken, as a share of the step, and its weight in the mean.
const RUNGE_KUTTA: [(f64, f64); 4] = [(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)];

/// One fourth-order Runge–Kutta step with the force held constant; `bow` is the unit vector of the state's heading.
pub fn step_maneuvering(
    hull: &Maneuvering,
    state: State,
    bow: NedVector,
    tau: BodyForce,
    current: NedVector,
    dt_s: f64,
) -> State {
    let body = Pushed::new(hull, &state, bow, tau, current);
    let x = [state.north_m, state.east_m, state.psi_rad, state.u_mps, state.v_mps, state.r_radps];
    let (mut rate, mut mean) = ([0.0; 6], [0.0; 6]);
    for (reach, weight) in RUNGE_KUTTA {
        let reach_s = reach * dt_s;
        rate = body.derivative(advanced(x, reach_s, rate), turned(bow, reach_s * rate[2]));
        mean = advanced(mean, weight, rate);
    }
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
    bow: NedVector,
    throttle: f64,
    steering: f64,
    current: NedVector,
    dt_s: f64,
) -> State {
    let (u_r, _) = state.through_water_mps(bow, current);
    let thrust_n = boat.thrust_limit_n * throttle;
    let speed = |u: f64| (thrust_n - boat.drag_n_per_mps2 * u.abs() * u) / boat.mass_kg;
    // Heun's method: drag is smooth and slow against a step of milliseconds.
    let first = speed(u_r);
    let next_u_r = u_r + 0.5 * dt_s * (first + speed(u_r + dt_s * first));
    let mean_u_r = 0.5 * (u_r + next_u_r);
    let curvature_per_m = 2.0 * (boat.steering_limit_rad * steering).sin()
        / (boat.turning_circle_m * boat.steering_limit_rad.sin());
    let turn_rad = mean_u_r * curvature_per_m * dt_s;
    let midway = turned(bow, 0.5 * turn_rad);
    let (u_c, v_c) = current.in_body(turned(bow, turn_rad));
    State {
        north_m: state.north_m + dt_s * (mean_u_r * midway.north + current.north),
        east_m: state.east_m + dt_s * (mean_u_r * midway.east + current.east),
        psi_rad: wrap(state.psi_rad + turn_rad),
        u_mps: next_u_r + u_c,
        v_mps: v_c,
        r_radps: next_u_r * curvature_per_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The sum station by station.
    fn summed(cross_flow: &CrossFlow, v_mps: f64, r_radps: f64) -> (f64, f64) {
        let spacing_m = cross_flow.length_m / 20.0;
        let strip = cross_flow.strip_n_per_m_mps2 * spacing_m;
        (0..21).map(|i| f64::from(i - 10) * spacing_m).fold((0.0, 0.0), |(force, moment), x_m| {
            let flow = v_mps + x_m * r_radps;
            let pressure = strip * flow.abs() * flow;
            (force - pressure, moment - x_m * pressure)
        })
    }

    fn agrees(v_mps: f64, r_radps: f64) -> bool {
        let cross_flow = CrossFlow { length_m: 2.0, strip_n_per_m_mps2: 300.0 };
        let signed = signed_sums(&cross_flow, v_mps, r_radps);
        let found = cross_flow_drag(&cross_flow, signed, v_mps, r_radps);
        let expected = summed(&cross_flow, v_mps, r_radps);
        let size = 1e-9 * (1.0 + 1e4 * (v_mps * v_mps + r_radps * r_radps));
        (found.0 - expected.0).abs() < size && (found.1 - expected.1).abs() < size
    }

    #[test]
    fn cross_flow_without_turn_drift_or_both_is_that_of_the_sum() {
        for (v_mps, r_radps) in [(0.0, 0.0), (0.3, 0.0), (-0.3, 0.0), (0.3, -0.0), (-0.3, -0.0), (0.0, 0.2)] {
            assert!(agrees(v_mps, r_radps), "{v_mps} {r_radps}");
        }
        assert!(agrees(0.1, 0.1) && agrees(-0.1, 0.1) && agrees(0.1, -0.1) && agrees(-0.1, -0.1));
    }

    proptest! {
        #[test]
        fn cross_flow_is_that_of_the_sum_of_its_stations(v_mps in -3.0f64..3.0, r_radps in -2.0f64..2.0) {
            prop_assert!(agrees(v_mps, r_radps));
        }
    }
}
