//! What ArduPilot is told: where the boat is and what its sensors feel, as a line of JSON.

use std::fmt::Write;

use crate::physics::{GRAVITY_MPS2, Truth};

/// What ArduPilot's sensors feel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Motion {
    time_s: f64,
    position_m: [f64; 3],
    velocity_mps: [f64; 3],
    attitude_rad: [f64; 3],
    gyro_radps: [f64; 3],
    /// Specific force in body axes.
    force_mps2: [f64; 3],
}

impl Motion {
    pub(super) fn at_rest(truth: &Truth) -> Self {
        let place = Self::place(truth);
        Self { force_mps2: [0.0, 0.0, -GRAVITY_MPS2], ..place }
    }

    /// Position, velocity over ground and attitude, wave motion included.
    fn place(truth: &Truth) -> Self {
        let (wave, hull) = (&truth.wave_motion, &truth.hull);
        let (north_mps, east_mps) = hull.velocity_ned_mps();
        Self {
            time_s: truth.time_s,
            position_m: [hull.north_m + wave.north_m, hull.east_m + wave.east_m, -wave.heave_m],
            velocity_mps: [north_mps + wave.north_mps, east_mps + wave.east_mps, 0.0],
            attitude_rad: [wave.roll_rad, wave.pitch_rad, hull.psi_rad + wave.psi_rad],
            gyro_radps: [0.0, 0.0, hull.r_radps + wave.r_radps],
            force_mps2: [0.0; 3],
        }
    }

    /// The motion one step later; rates that the physics does not give are differences.
    pub(super) fn next(&self, truth: &Truth, dt_s: f64) -> Self {
        let mut now = Self::place(truth);
        now.velocity_mps[2] = (now.position_m[2] - self.position_m[2]) / dt_s;
        let rate = |axis: usize| (now.attitude_rad[axis] - self.attitude_rad[axis]) / dt_s;
        let [roll, pitch, yaw] = now.attitude_rad;
        let (roll_rate, pitch_rate, yaw_rate) = (rate(0), rate(1), now.gyro_radps[2]);
        // Body rates from Euler rates (Fossen 2021, eq. 2.39, inverted).
        now.gyro_radps = [
            roll_rate - yaw_rate * pitch.sin(),
            pitch_rate * roll.cos() + yaw_rate * pitch.cos() * roll.sin(),
            yaw_rate * pitch.cos() * roll.cos() - pitch_rate * roll.sin(),
        ];
        let mut felt: [f64; 3] =
            std::array::from_fn(|axis| (now.velocity_mps[axis] - self.velocity_mps[axis]) / dt_s);
        felt[2] -= GRAVITY_MPS2;
        now.force_mps2 = to_body(felt, roll, pitch, yaw);
        now
    }

    /// The answer. Nine decimals keep what a float can hold.
    pub(super) fn json(&self, truth: &Truth) -> String {
        let mut text = String::with_capacity(512);
        let vector = |values: [f64; 3]| format!("[{:.9},{:.9},{:.9}]", values[0], values[1], values[2]);
        let wind = truth.wind_mps;
        let apparent = (wind.north - self.velocity_mps[0], wind.east - self.velocity_mps[1]);
        let from_rad = (-apparent.1).atan2(-apparent.0) - self.attitude_rad[2];
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "\n{{\"timestamp\":{:.9},\"imu\":{{\"gyro\":{},\"accel_body\":{}}},\"position\":{},\"velocity\":{},\
             \"attitude\":{},\"windvane\":{{\"direction\":{:.6},\"speed\":{:.6}}}}}\n",
            self.time_s,
            vector(self.gyro_radps),
            vector(self.force_mps2),
            vector(self.position_m),
            vector(self.velocity_mps),
            vector(self.attitude_rad),
            from_rad.rem_euclid(std::f64::consts::TAU),
            apparent.0.hypot(apparent.1),
        );
        text
    }
}

/// A vector in NED in body axes (rotation zyx: Fossen 2021, eq. 2.31, transposed).
fn to_body(ned: [f64; 3], roll: f64, pitch: f64, yaw: f64) -> [f64; 3] {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    let [n, e, d] = ned;
    [
        cp * cy * n + cp * sy * e - sp * d,
        (sr * sp * cy - cr * sy) * n + (sr * sp * sy + cr * cy) * e + sr * cp * d,
        (cr * sp * cy + sr * sy) * n + (cr * sp * sy - sr * cy) * e + cr * cp * d,
    ]
}
