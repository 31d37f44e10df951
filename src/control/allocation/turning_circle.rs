//! A boat known by its turning circle: steering sets the circle, speed sets how fast it is run.
//!
//! This is ArduPilot's own simulated motorboat (`SIM_Sailboat.cpp`): r = 2u/d with
//! d = d_min·sin δ_max / sin δ, no inertia in yaw. It is also the honest model of a light planing boat about
//! which nothing else is known. The nominal hull then carries a first-order yaw lag, m33/d_r1, and a moment
//! stands for the yaw rate it settles at: r = N/d_r1.

use serde::{Deserialize, Serialize};

use super::{Allocation, Servo, Situation, ThrustCurve};
use crate::control::command::{Command, Wrench};
use crate::control::model::Hull;

/// Least speed the inverse divides by, m/s.
const MIN_SPEED_MPS: f64 = 0.3;
/// Heading error beyond which a slow boat kicks ahead, rad.
const KICK_HEADING_RAD: f64 = 0.3;

/// Steering by turning circle.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CircleSettings {
    /// Thrust curve.
    pub thrust: ThrustCurve,
    /// Diameter of the turning circle at full steering, m.
    pub diameter_m: f64,
    /// Steering angle at full steering, rad; the circle widens with the sine of the angle.
    pub angle_max_rad: f64,
    /// Full-scale rate of the steering command, 1/s.
    pub steering_slew_per_s: f64,
    /// Full-scale rate of the throttle command, 1/s.
    pub throttle_slew_per_s: f64,
    /// Lag of either command, s.
    pub lag_s: f64,
    /// Boats slower than this may kick ahead to turn, m/s.
    pub kick_below_mps: f64,
    /// Kick, as a part of full thrust ahead.
    pub kick_part: f64,
}

/// Allocator for a boat known by its turning circle.
#[derive(Debug, Clone)]
pub struct TurningCircle {
    settings: CircleSettings,
    /// Moment per yaw rate in the nominal hull, N·m/(rad/s).
    moment_per_rate: f64,
    throttle: Servo,
    steering: Servo,
}

impl TurningCircle {
    /// Actuators at rest on `hull`, whose linear yaw damping turns moments into yaw rates.
    #[must_use]
    pub fn new(settings: CircleSettings, hull: &Hull) -> Self {
        let moment_per_rate = hull.yaw_damping[0];
        Self { settings, moment_per_rate, throttle: Servo::default(), steering: Servo::default() }
    }

    /// Engine stopped, steering amidships.
    pub fn reset(&mut self) {
        self.throttle = Servo::default();
        self.steering = Servo::default();
    }

    /// Chooses throttle and steering and predicts both `dt_s` ahead.
    pub fn allocate(&mut self, dt_s: f64, demand: Wrench, situation: &Situation) -> Allocation {
        let g = &self.settings;
        let speed = situation.motion.surge_mps;
        let off_heading = situation.heading_error_rad.abs() > KICK_HEADING_RAD;
        let limited = g.thrust.limit(demand.surge_n);
        let wanted_n = if off_heading && speed < g.kick_below_mps {
            limited.max(g.kick_part * g.thrust.ahead_n)
        } else {
            limited
        };
        let throttle = g.thrust.command(wanted_n);
        let shaft = self.throttle.step(dt_s, throttle, g.throttle_slew_per_s, g.lag_s);

        let full_sine = g.angle_max_rad.sin();
        let rate_at_full = 2.0 / g.diameter_m;
        let wanted_rate = demand.yaw_nm / self.moment_per_rate;
        // Going astern the same steering turns the boat the other way.
        let divisor = if speed.abs() < MIN_SPEED_MPS { MIN_SPEED_MPS } else { speed };
        let wanted_sine = wanted_rate * full_sine / (rate_at_full * divisor);
        // At a standstill steering turns nothing, and comes amidships.
        let alive = (speed.abs() / MIN_SPEED_MPS).min(1.0);
        let steering = alive * wanted_sine.clamp(-full_sine, full_sine).asin() / g.angle_max_rad;
        let slewing = self.steering.is_slewing(dt_s, steering, g.steering_slew_per_s, g.lag_s);
        let actual = self.steering.step(dt_s, steering, g.steering_slew_per_s, g.lag_s);
        let rate = rate_at_full * speed * (actual * g.angle_max_rad).sin() / full_sine;
        Allocation {
            command: Command { throttle, steering },
            achieved: Wrench {
                surge_n: g.thrust.thrust_n(shaft),
                sway_n: 0.0,
                yaw_nm: rate * self.moment_per_rate,
            },
            surge_saturated: wanted_n != demand.surge_n,
            yaw_saturated: slewing || wanted_sine.abs() > full_sine,
        }
    }
}
