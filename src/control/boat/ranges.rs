//! Ranges of every value of a boat file, written once.

use super::{Actuators, Boat, BoatError};
use crate::control::allocation::ThrustCurve;
use crate::control::axis::AxisSettings;

/// Key, value, least, most, meaning.
type Rule = (&'static str, f64, f64, f64, &'static str);

/// Smallest positive value of anything that is divided by.
const TINY: f64 = 1.0e-6;

impl Boat {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// The first value outside its range, with key, range and meaning.
    pub fn check(&self) -> Result<(), BoatError> {
        check(&self.hull_rules())?;
        check(&self.actuator_rules())?;
        check(&self.limit_rules())?;
        check(&self.observer_rules())?;
        check(&self.guidance_rules())?;
        check(&self.control_rules())
    }

    /// Least and largest value of a limit or a gain by its key in the boat file, such as `guidance.lead_m`; some of them
    /// depend on other values of this boat. None for keys of other parts.
    pub fn range(&self, key: &str) -> Option<(f64, f64)> {
        let rules = [&self.limit_rules()[..], &self.guidance_rules(), &self.control_rules()].concat();
        rules.iter().find(|rule| rule.0 == key).map(|&(_, _, least, most, _)| (least, most))
    }

    fn control_rules(&self) -> Vec<Rule> {
        let heading = ("control.heading_gain", self.control.heading_gain, TINY, 10.0, "k_psi, 1/s");
        let mut rules = vec![heading];
        rules.extend(axis_rules(&self.control.surge, &SURGE_KEYS));
        rules.extend(axis_rules(&self.control.yaw, &YAW_KEYS));
        rules
    }

    fn hull_rules(&self) -> [Rule; 12] {
        let h = &self.hull;
        let [u1, u2, u3] = h.surge_damping;
        let [v1, v2, v3] = h.sway_damping;
        let [r1, r2, r3] = h.yaw_damping;
        let big = 1.0e12;
        [
            ("hull.m11_kg", h.m11_kg, TINY, big, "mass in surge, kg"),
            ("hull.m22_kg", h.m22_kg, TINY, big, "mass in sway, kg"),
            ("hull.m33_kgm2", h.m33_kgm2, TINY, big, "inertia in yaw, kg m2"),
            ("hull.surge_damping[0]", u1, 0.0, big, "N/(m/s)"),
            ("hull.surge_damping[1]", u2, 0.0, big, "N/(m/s)^2"),
            ("hull.surge_damping[2]", u3, 0.0, big, "N/(m/s)^3"),
            ("hull.sway_damping[0]", v1, 0.0, big, "N/(m/s)"),
            ("hull.sway_damping[1]", v2, 0.0, big, "N/(m/s)^2"),
            ("hull.sway_damping[2]", v3, 0.0, big, "N/(m/s)^3"),
            ("hull.yaw_damping[0]", r1, TINY, big, "N m/(rad/s)"),
            ("hull.yaw_damping[1]", r2, 0.0, big, "N m/(rad/s)^2"),
            ("hull.yaw_damping[2]", r3, 0.0, big, "N m/(rad/s)^3"),
        ]
    }

    fn limit_rules(&self) -> [Rule; 8] {
        let l = &self.limits;
        let rate = l.yaw_rate_max_radps;
        [
            ("limits.cruise_mps", l.cruise_mps, 0.1, l.speed_max_mps, "usual speed over ground, m/s"),
            ("limits.turn_radius_m", l.turn_radius_m, 0.1, 5000.0, "radius of the path's corners, m"),
            ("limits.speed_max_mps", l.speed_max_mps, 0.1, 40.0, "largest speed through the water, m/s"),
            ("limits.steerage_mps", l.steerage_mps, 0.0, l.speed_max_mps, "least steerage speed, m/s"),
            ("limits.yaw_rate_max_radps", rate, 0.001, 5.0, "largest yaw rate asked for, rad/s"),
            ("limits.turn_rate_radps", l.turn_rate_radps, 0.001, rate, "yaw rate planned for a turn, rad/s"),
            ("limits.lateral_acceleration_mps2", l.lateral_acceleration_mps2, 0.001, 20.0, "m/s2"),
            ("limits.deceleration_mps2", l.deceleration_mps2, 0.001, 5.0, "m/s2"),
        ]
    }

    fn guidance_rules(&self) -> [Rule; 8] {
        let g = &self.guidance;
        [
            ("guidance.lead_m", g.lead_m, 0.1, 1000.0, "look-ahead at low speed, m"),
            ("guidance.lead_time_s", g.lead_time_s, 0.0, 120.0, "look-ahead per speed, s"),
            (
                "guidance.lead_softness_m",
                g.lead_softness_m,
                0.1,
                5000.0,
                "lead error that stops the virtual ship, m",
            ),
            ("guidance.drift_time_s", g.drift_time_s, 0.05, 600.0, "time constant of the drift estimate, s"),
            ("guidance.sway_spread", g.sway_spread, 0.0, 2.0, "deviation of the sway from its model, a part"),
            ("guidance.preview_s", g.preview_s, 0.0, 30.0, "curvature preview, s"),
            ("guidance.speed_preview_s", g.speed_preview_s, 0.0, 60.0, "speed preview, s"),
            ("guidance.creep_mps", g.creep_mps, 0.01, 5.0, "least speed of the final approach, m/s"),
        ]
    }

    fn observer_rules(&self) -> [Rule; 4] {
        let o = &self.observer;
        let bandwidth = "bandwidth, rad/s";
        [
            ("observer.noise_radps", o.noise_radps, TINY, 10.0, "noise in yaw rate, rad/s"),
            ("observer.noise_mps", o.noise_mps, TINY, 10.0, "noise in speed, m/s"),
            ("observer.turn_bandwidth_radps", o.turn_bandwidth_radps, 0.001, 50.0, bandwidth),
            ("observer.move_bandwidth_radps", o.move_bandwidth_radps, 0.001, 50.0, bandwidth),
        ]
    }

    fn actuator_rules(&self) -> Vec<Rule> {
        let slew = "normalised command per second, 1/s";
        match &self.actuators {
            Actuators::TwinThrusters(a) => {
                let mut rules = thrust_rules(&a.thrust);
                rules.extend([
                    ("actuators.arm_m", a.arm_m, 0.01, 100.0, "thruster to centre line, m"),
                    ("actuators.lag_s", a.lag_s, 0.0, 30.0, "shaft time constant, s"),
                    ("actuators.slew_per_s", a.slew_per_s, 0.01, 1000.0, slew),
                ]);
                rules
            }
            Actuators::PropellerRudder(a) => {
                let mut rules = thrust_rules(&a.thrust);
                rules.extend([
                    ("actuators.arm_m", a.arm_m, 0.01, 500.0, "rudder behind the centre of gravity, m"),
                    ("actuators.rudder_gain", a.rudder_gain, TINY, 1.0e9, "N/(m/s)^2"),
                    ("actuators.slipstream", a.slipstream, 0.0, 1.0e3, "(m/s)^2/N"),
                    ("actuators.angle_max_rad", a.angle_max_rad, 0.05, 1.2, "largest rudder angle, rad"),
                    ("actuators.angle_rate_radps", a.angle_rate_radps, 0.001, 100.0, "rudder rate, rad/s"),
                    ("actuators.rudder_lag_s", a.rudder_lag_s, 0.0, 30.0, "rudder time constant, s"),
                    ("actuators.propeller_lag_s", a.propeller_lag_s, 0.0, 60.0, "propeller time constant, s"),
                    ("actuators.kick_below_mps", a.kick_below_mps, 0.0, 40.0, "kick ahead below this, m/s"),
                    ("actuators.kick_part", a.kick_part, 0.0, 1.0, "part of full thrust"),
                ]);
                rules
            }
            Actuators::TurningCircle(a) => {
                let mut rules = thrust_rules(&a.thrust);
                rules.extend([
                    ("actuators.diameter_m", a.diameter_m, 0.1, 5000.0, "turning circle, m"),
                    ("actuators.angle_max_rad", a.angle_max_rad, 0.05, 1.5, "angle at full steering, rad"),
                    ("actuators.steering_slew_per_s", a.steering_slew_per_s, 0.01, 1000.0, slew),
                    ("actuators.throttle_slew_per_s", a.throttle_slew_per_s, 0.01, 1000.0, slew),
                    ("actuators.lag_s", a.lag_s, 0.0, 30.0, "command lag, s"),
                    ("actuators.kick_below_mps", a.kick_below_mps, 0.0, 40.0, "kick ahead below this, m/s"),
                    ("actuators.kick_part", a.kick_part, 0.0, 1.0, "part of full thrust"),
                ]);
                rules
            }
        }
    }
}

fn thrust_rules(thrust: &ThrustCurve) -> Vec<Rule> {
    vec![
        ("actuators.thrust.ahead_n", thrust.ahead_n, TINY, 1.0e9, "full thrust ahead, N"),
        ("actuators.thrust.astern_n", thrust.astern_n, TINY, 1.0e9, "full thrust astern, N"),
        ("actuators.thrust.exponent", thrust.exponent, 1.0, 3.0, "thrust over command"),
    ]
}

/// Keys of the surge axis, in the order of [`axis_rules`].
const SURGE_KEYS: [&str; 14] = [
    "control.surge.filter_s",
    "control.surge.acceleration_max",
    "control.surge.reaching_gain",
    "control.surge.integral_slope",
    "control.surge.boundary",
    "control.surge.disturbance_max",
    "control.surge.disturbance_rate",
    "control.surge.disturbance_leak",
    "control.surge.parameter_rate",
    "control.surge.parameter_leak",
    "control.surge.dead_zone",
    "control.surge.integral_max",
    "control.surge.typical_rate",
    "control.surge.damping_at_command",
];

/// Keys of the yaw axis, in the order of [`axis_rules`].
const YAW_KEYS: [&str; 14] = [
    "control.yaw.filter_s",
    "control.yaw.acceleration_max",
    "control.yaw.reaching_gain",
    "control.yaw.integral_slope",
    "control.yaw.boundary",
    "control.yaw.disturbance_max",
    "control.yaw.disturbance_rate",
    "control.yaw.disturbance_leak",
    "control.yaw.parameter_rate",
    "control.yaw.parameter_leak",
    "control.yaw.dead_zone",
    "control.yaw.integral_max",
    "control.yaw.typical_rate",
    "control.yaw.damping_at_command",
];

fn axis_rules(a: &AxisSettings, keys: &[&'static str; 14]) -> [Rule; 14] {
    [
        (keys[0], a.filter_s, 0.001, 60.0, "command filter time constant, s"),
        (keys[1], a.acceleration_max, TINY, 100.0, "largest rate of the filtered command"),
        (keys[2], a.reaching_gain, TINY, 50.0, "k, 1/s"),
        (keys[3], a.integral_slope, 0.0, 20.0, "lambda, 1/s"),
        (keys[4], a.boundary, TINY, 20.0, "boundary layer Phi"),
        (keys[5], a.disturbance_max, 0.0, 100.0, "largest disturbance bound"),
        (keys[6], a.disturbance_rate, 0.0, 100.0, "gamma, 1/s"),
        (keys[7], a.disturbance_leak, 0.0, 100.0, "sigma_d"),
        (keys[8], a.parameter_rate, 0.0, 100.0, "g_T"),
        (keys[9], a.parameter_leak, 0.0, 10.0, "sigma_T, 1/s"),
        (keys[10], a.dead_zone, 0.0, 10.0, "no adaptation below this |S|"),
        (keys[11], a.integral_max, 0.0, 1000.0, "largest integral"),
        (keys[12], a.typical_rate, 0.001, 40.0, "typical speed or yaw rate"),
        (keys[13], a.damping_at_command, 0.0, 1.0, "part"),
    ]
}

pub(super) fn check(rules: &[Rule]) -> Result<(), BoatError> {
    for &(key, value, least, most, meaning) in rules {
        // NaN is in no range.
        if !(least..=most).contains(&value) {
            return Err(BoatError::Range { key, value, least, most, meaning });
        }
    }
    Ok(())
}
