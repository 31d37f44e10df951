//! The test boat: rigid body and added mass with sway-yaw coupling, linear to cubic damping, cross-flow drag by
//! strips, irrotational current (Fossen 2021, ch. 6 and 8). Integrated at 200 Hz.

use helmlink_mission::geodesy::NorthEast;

use crate::control::allocation::{CircleSettings, RudderSettings};
use crate::control::boat::Actuators;
use crate::control::{Boat, Command, Hull};
use crate::guidance::{VesselState, unit};

const STEP_S: f64 = 0.005;

/// Propulsion and steering of a test boat.
#[derive(Debug, Clone)]
enum Drive {
    Twin { ahead_n: f64, astern_n: f64, arm_m: f64, lag_s: f64, left: f64, right: f64 },
    Rudder { boat: Box<RudderSettings>, shaft: f64, angle_rad: f64 },
    Circle { boat: Box<CircleSettings>, shaft: f64 },
}

#[derive(Debug, Clone)]
pub(crate) struct Plant {
    pub(crate) hull: Hull,
    /// Coupling of sway and yaw inertia m·x_g, kg·m.
    m23: f64,
    /// Cross-flow drag, N/(m/s)² per metre, and hull length, m.
    cross_flow: (f64, f64),
    drive: Drive,
    current: NorthEast,
    /// Constant disturbance: surge N, sway N, yaw N·m.
    pub(crate) push: [f64; 3],
    pub(crate) position: NorthEast,
    pub(crate) heading_rad: f64,
    /// u, v over ground and r.
    pub(crate) nu: [f64; 3],
}

impl Plant {
    pub(crate) fn of(boat: &Boat) -> Self {
        let drive = match &boat.actuators {
            Actuators::TwinThrusters(t) => Drive::Twin {
                ahead_n: t.thrust.ahead_n,
                astern_n: t.thrust.astern_n,
                arm_m: t.arm_m,
                lag_s: t.lag_s,
                left: 0.0,
                right: 0.0,
            },
            Actuators::PropellerRudder(r) => {
                Drive::Rudder { boat: Box::new(r.clone()), shaft: 0.0, angle_rad: 0.0 }
            }
            Actuators::TurningCircle(c) => Drive::Circle { boat: Box::new(c.clone()), shaft: 0.0 },
        };
        Self {
            hull: boat.hull.clone(),
            m23: 0.0,
            cross_flow: (0.0, 0.0),
            drive,
            current: NorthEast { north_m: 0.0, east_m: 0.0 },
            push: [0.0; 3],
            position: NorthEast { north_m: 0.0, east_m: 0.0 },
            heading_rad: 0.0,
            nu: [0.0; 3],
        }
    }

    /// The Otter with everything the controller's model leaves out.
    pub(crate) fn otter() -> Self {
        let mut plant = Self::of(&Boat::embedded("otter").unwrap());
        plant.hull.sway_damping = [162.5, 0.0, 0.0];
        plant.m23 = 12.25;
        plant.cross_flow = (100.0, 2.0);
        plant
    }

    /// In a current (m/s, toward rad), heading `heading_rad`, with `surge_mps` through the water.
    pub(crate) fn under_way(mut self, heading_rad: f64, surge_mps: f64, current: NorthEast) -> Self {
        let bow = unit(heading_rad);
        self.heading_rad = heading_rad;
        self.current = current;
        self.nu = [surge_mps + bow.dot(current), bow.cross(current), 0.0];
        self
    }

    pub(crate) fn state(&self) -> VesselState {
        VesselState {
            position: self.position,
            heading_rad: self.heading_rad,
            surge_mps: self.nu[0],
            sway_mps: self.nu[1],
            yaw_rate_radps: self.nu[2],
        }
    }

    pub(crate) fn advance(&mut self, dt_s: f64, command: Command) {
        let steps = (dt_s / STEP_S).round().max(1.0) as usize;
        let h = dt_s / steps as f64;
        for _ in 0..steps {
            self.step(h, command);
        }
    }

    fn step(&mut self, h: f64, command: Command) {
        let bow = unit(self.heading_rad);
        let (uc, vc) = (bow.dot(self.current), bow.cross(self.current));
        let [ug, vg, r] = self.nu;
        let (u, v) = (ug - uc, vg - vc);
        let tau = self.drive.forces(h, command, u);
        let hull = &self.hull;
        let damp = |d: [f64; 3], w: f64| d[0] * w + d[1] * w.abs() * w + d[2] * w * w * w;
        let (kc, length) = self.cross_flow;
        let (mut cy, mut cn) = (0.0, 0.0);
        if kc > 0.0 {
            let dx = length / 20.0;
            for i in 0..20 {
                let x = -0.5 * length + (f64::from(i) + 0.5) * dx;
                let w = v + x * r;
                cy += kc * w.abs() * w * dx;
                cn += kc * x * w.abs() * w * dx;
            }
        }
        let (m11, m22, m33, m23) = (hull.m11_kg, hull.m22_kg, hull.m33_kgm2, self.m23);
        let fx = tau[0] + (m22 * v + m23 * r) * r - damp(hull.surge_damping, u) + self.push[0];
        let fy = tau[1] - m11 * u * r - damp(hull.sway_damping, v) - cy + self.push[1];
        let fn_ = tau[2] - (m22 - m11) * u * v - m23 * u * r - damp(hull.yaw_damping, r) - cn + self.push[2];
        let det = m22 * m33 - m23 * m23;
        let du = fx / m11;
        let dv = (m33 * fy - m23 * fn_) / det;
        let dr = (m22 * fn_ - m23 * fy) / det;
        if let Drive::Circle { boat, .. } = &self.drive {
            let sine = (command.steering * boat.angle_max_rad).sin() / boat.angle_max_rad.sin();
            let rate = 2.0 / boat.diameter_m * u * sine;
            self.nu = [ug + h * (du - r * v + r * vc), vc, rate];
        } else {
            self.nu = [ug + h * (du + r * vc), vg + h * (dv - r * uc), r + h * dr];
        }
        let bow = unit(self.heading_rad + 0.5 * h * self.nu[2]);
        let side = NorthEast { north_m: -bow.east_m, east_m: bow.north_m };
        self.position = self.position + bow * (self.nu[0] * h) + side * (self.nu[1] * h);
        self.heading_rad += h * self.nu[2];
    }
}

impl Drive {
    fn forces(&mut self, h: f64, command: Command, u: f64) -> [f64; 3] {
        match self {
            Self::Twin { ahead_n, astern_n, arm_m, lag_s, left, right } => {
                let thrust = |n: f64| if n < 0.0 { -n * n * *astern_n } else { n * n * *ahead_n };
                *left += h / *lag_s * ((command.throttle + command.steering).clamp(-1.0, 1.0) - *left);
                *right += h / *lag_s * ((command.throttle - command.steering).clamp(-1.0, 1.0) - *right);
                let (l, r) = (thrust(*left), thrust(*right));
                [l + r, 0.0, *arm_m * (l - r)]
            }
            Self::Rudder { boat, shaft, angle_rad } => {
                *shaft += h / boat.propeller_lag_s * (command.throttle - *shaft);
                let wanted = command.steering * boat.angle_max_rad;
                let limit = boat.angle_rate_radps * h;
                *angle_rad += (h / boat.rudder_lag_s * (wanted - *angle_rad)).clamp(-limit, limit);
                let full = if *shaft < 0.0 { boat.thrust.astern_n } else { boat.thrust.ahead_n };
                let t = full * *shaft * shaft.abs();
                let flow = u.max(0.0).powi(2) + boat.slipstream * t.max(0.0);
                let side = boat.rudder_gain * flow * angle_rad.sin() * angle_rad.cos();
                [t, -side, boat.arm_m * side]
            }
            Self::Circle { boat, shaft } => {
                let limit = boat.throttle_slew_per_s * h;
                *shaft += (command.throttle - *shaft).clamp(-limit, limit);
                [boat.thrust.ahead_n * *shaft, 0.0, 0.0]
            }
        }
    }
}
