//! Propeller and rudder; or an outboard, whose turned jet is the "rudder".
//!
//! The rudder feels U_R² = max(u, 0)² + c_T·max(T, 0): the advance of the hull and the propeller's
//! slipstream (Fossen 2021, ch. 9). Its moment is l_R K U_R² sin δ cos δ and its side force the moment over
//! −l_R. Without flow it is dead, and the only way to turn is to kick ahead.

use serde::{Deserialize, Serialize};

use super::{Allocation, Servo, Situation, ThrustCurve};
use crate::control::command::{Command, Wrench};

/// Least U_R² the inverse divides by, (m/s)²: below it the rudder does nothing worth computing.
const MIN_FLOW_M2PS2: f64 = 0.3;
/// Largest sin 2δ asked of the inverse.
const MAX_SINE: f64 = 0.94;
/// Heading error beyond which a slow boat kicks ahead, rad.
const KICK_HEADING_RAD: f64 = 0.3;

/// A propeller with a rudder in its slipstream.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RudderSettings {
    /// Thrust curve of the propeller.
    pub thrust: ThrustCurve,
    /// Distance of the rudder behind the centre of gravity l_R, m.
    pub arm_m: f64,
    /// Rudder force per dynamic pressure K = ½ρ A_R f_α, N/(m/s)².
    pub rudder_gain: f64,
    /// Slipstream coefficient c_T: U_R² gained per thrust, (m/s)²/N.
    pub slipstream: f64,
    /// Largest rudder angle, rad.
    pub angle_max_rad: f64,
    /// Rudder rate, rad/s.
    pub angle_rate_radps: f64,
    /// Time constant of the rudder servo, s.
    pub rudder_lag_s: f64,
    /// Time constant of the propeller, s.
    pub propeller_lag_s: f64,
    /// Boats slower than this may kick ahead to turn, m/s.
    pub kick_below_mps: f64,
    /// Largest kick, as a part of full thrust ahead.
    pub kick_part: f64,
}

/// Allocator for propeller and rudder.
#[derive(Debug, Clone)]
pub struct PropellerRudder {
    settings: RudderSettings,
    propeller: Servo,
    rudder: Servo,
}

impl PropellerRudder {
    /// Actuators at rest.
    #[must_use]
    pub fn new(settings: RudderSettings) -> Self {
        Self { settings, propeller: Servo::default(), rudder: Servo::default() }
    }

    /// Propeller stopped, rudder amidships.
    pub fn reset(&mut self) {
        self.propeller = Servo::default();
        self.rudder = Servo::default();
    }

    /// Chooses thrust and rudder angle and predicts both `dt_s` ahead.
    pub fn allocate(&mut self, dt_s: f64, demand: Wrench, situation: &Situation) -> Allocation {
        let g = &self.settings;
        let advance = situation.motion.surge_mps.max(0.0).powi(2);
        let limited = g.thrust.limit(demand.surge_n);
        let wanted_n = self.kick_ahead(limited, demand.yaw_nm, advance, situation);

        let throttle = g.thrust.command(wanted_n);
        let shaft = self.propeller.step(dt_s, throttle, f64::INFINITY, g.propeller_lag_s);
        let thrust_n = g.thrust.thrust_n(shaft);
        let flow = advance + g.slipstream * thrust_n.max(0.0);
        let gain = g.arm_m * g.rudder_gain;
        // The schedule with speed: divide by the flow that is there, never by less than the floor. A rudder that the
        // flow has left comes amidships: swinging it to and fro moves nothing but the gear.
        let alive = (flow / MIN_FLOW_M2PS2).min(1.0);
        let wanted_sine = 2.0 * demand.yaw_nm / (gain * flow.max(MIN_FLOW_M2PS2));
        let angle = alive
            * (0.5 * wanted_sine.clamp(-MAX_SINE, MAX_SINE).asin()).clamp(-g.angle_max_rad, g.angle_max_rad);
        let slewing = self.rudder.is_slewing(dt_s, angle, g.angle_rate_radps, g.rudder_lag_s);
        let actual = self.rudder.step(dt_s, angle, g.angle_rate_radps, g.rudder_lag_s);
        let yaw_nm = gain * flow * actual.sin() * actual.cos();
        let reachable = (2.0 * g.angle_max_rad).sin().min(MAX_SINE);
        Allocation {
            command: Command { throttle, steering: angle / g.angle_max_rad },
            achieved: Wrench { surge_n: thrust_n, sway_n: -yaw_nm / g.arm_m, yaw_nm },
            surge_saturated: wanted_n != demand.surge_n,
            yaw_saturated: slewing || wanted_sine.abs() > reachable,
        }
    }

    /// Thrust (N) after the kick-ahead rule: a boat far off its heading, too slow for its rudder, puts flow
    /// over it. Also the astern rule: thrust astern gives no steering, so it waits until the heading is right.
    fn kick_ahead(&self, thrust_n: f64, yaw_nm: f64, advance: f64, situation: &Situation) -> f64 {
        let g = &self.settings;
        let off_heading = situation.heading_error_rad.abs() > KICK_HEADING_RAD;
        if !off_heading {
            return thrust_n;
        }
        if situation.motion.surge_mps >= g.kick_below_mps {
            return thrust_n.max(0.0);
        }
        let required = 2.0 * yaw_nm.abs() / (g.arm_m * g.rudder_gain * (2.0 * g.angle_max_rad).sin());
        let kick = (required - advance) / g.slipstream.max(1.0e-9);
        thrust_n.max(kick.clamp(0.0, g.kick_part * g.thrust.ahead_n))
    }
}
