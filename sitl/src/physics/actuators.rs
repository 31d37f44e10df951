//! From normalised commands to forces: propeller revolutions, thrust, rudder and outboard.

use super::dynamics::BodyForce;
use super::hull::{HullDynamics, Propulsion, SteeredDrive, TwinThrusters};

/// What an autopilot puts out, normalised to [−1, 1]; values outside are clipped, NaN counts as neutral.
///
/// Either form suits every boat: twin thrusters given throttle and steering mix them, a steered boat given
/// left and right takes their mean and half their difference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ActuatorCommand {
    /// One command per propeller. ±1 is full revolutions ahead or astern; thrust grows with the square.
    TwinThrusters {
        /// Left (port) propeller.
        left: f64,
        /// Right (starboard) propeller.
        right: f64,
    },
    /// One throttle, one steering command.
    ThrottleSteering {
        /// Revolutions: +1 full ahead, −1 full astern.
        throttle: f64,
        /// +1 turns hard to starboard when making way ahead.
        steering: f64,
    },
}

impl ActuatorCommand {
    /// Everything at rest.
    pub const NEUTRAL: ActuatorCommand = ActuatorCommand::ThrottleSteering { throttle: 0.0, steering: 0.0 };

    /// As (left, right). Steering has priority: the throttle gives way where both do not fit.
    pub fn left_right(self) -> (f64, f64) {
        match self {
            ActuatorCommand::TwinThrusters { left, right } => (normalised(left), normalised(right)),
            ActuatorCommand::ThrottleSteering { throttle, steering } => {
                let steering = normalised(steering);
                let room = 1.0 - steering.abs();
                let throttle = normalised(throttle).clamp(-room, room);
                (throttle + steering, throttle - steering)
            }
        }
    }

    /// As (throttle, steering).
    pub fn throttle_steering(self) -> (f64, f64) {
        match self {
            ActuatorCommand::TwinThrusters { left, right } => {
                let (left, right) = (normalised(left), normalised(right));
                (0.5 * (left + right), 0.5 * (left - right))
            }
            ActuatorCommand::ThrottleSteering { throttle, steering } => {
                (normalised(throttle), normalised(steering))
            }
        }
    }
}

fn normalised(command: f64) -> f64 {
    if command.is_nan() { 0.0 } else { command.clamp(-1.0, 1.0) }
}

/// Where the actuators really are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ActuatorState {
    /// Shaft speeds of two propellers, rad/s.
    TwinThrusters {
        /// Left shaft, rad/s.
        left_radps: f64,
        /// Right shaft, rad/s.
        right_radps: f64,
    },
    /// A propeller and a steered foil.
    ThrottleSteering {
        /// Revolutions as a share of full, [−1, 1].
        throttle: f64,
        /// Steering angle, positive turns to starboard, rad.
        steering_rad: f64,
    },
}

impl ActuatorState {
    /// Actuators of this boat, at rest.
    pub fn at_rest(dynamics: &HullDynamics) -> ActuatorState {
        match dynamics {
            HullDynamics::Maneuvering(_, Propulsion::TwinThrusters(_)) => {
                ActuatorState::TwinThrusters { left_radps: 0.0, right_radps: 0.0 }
            }
            _ => ActuatorState::ThrottleSteering { throttle: 0.0, steering_rad: 0.0 },
        }
    }
}

/// Moves the actuators toward `command` for `dt_s` and returns their new state and the force they exert on a
/// hull that makes `u_r_mps` through the water.
pub fn step(
    propulsion: &Propulsion,
    state: ActuatorState,
    command: ActuatorCommand,
    u_r_mps: f64,
    dt_s: f64,
) -> (ActuatorState, BodyForce) {
    match propulsion {
        Propulsion::TwinThrusters(twin) => step_twin(twin, state, command, dt_s),
        Propulsion::PropellerRudder(drive) => {
            let (throttle, steering_rad) = step_steered(drive, state, command, dt_s);
            let thrust_n = propeller_thrust_n(drive, throttle);
            let force = foil_force(drive, steering_rad.sin_cos(), thrust_n, u_r_mps);
            let force = BodyForce { surge_n: force.surge_n + thrust_n, ..force };
            (ActuatorState::ThrottleSteering { throttle, steering_rad }, force)
        }
        Propulsion::Outboard(drive) => {
            let (throttle, steering_rad) = step_steered(drive, state, command, dt_s);
            let thrust_n = propeller_thrust_n(drive, throttle);
            let (sin, cos) = steering_rad.sin_cos();
            let vectored = BodyForce {
                surge_n: thrust_n * cos,
                sway_n: -thrust_n * sin,
                yaw_nm: drive.arm_m * thrust_n * sin,
            };
            let force = vectored + foil_force(drive, (sin, cos), thrust_n, u_r_mps);
            (ActuatorState::ThrottleSteering { throttle, steering_rad }, force)
        }
    }
}

/// Shaft speed follows with a first-order lag, then T = k·n·|n| (Fossen 2021, §9.3; otter.m).
fn step_twin(
    twin: &TwinThrusters,
    state: ActuatorState,
    command: ActuatorCommand,
    dt_s: f64,
) -> (ActuatorState, BodyForce) {
    let (left, right) = command.left_right();
    let (left_radps, right_radps) = match state {
        ActuatorState::TwinThrusters { left_radps, right_radps } => (left_radps, right_radps),
        ActuatorState::ThrottleSteering { .. } => (0.0, 0.0),
    };
    let share = lag_share(twin.lag_s, dt_s);
    let left_radps = left_radps + share * (shaft_speed_radps(twin, left) - left_radps);
    let right_radps = right_radps + share * (shaft_speed_radps(twin, right) - right_radps);
    let (left_n, right_n) = (shaft_thrust_n(twin, left_radps), shaft_thrust_n(twin, right_radps));
    let force = BodyForce { surge_n: left_n + right_n, sway_n: 0.0, yaw_nm: twin.arm_m * (left_n - right_n) };
    (ActuatorState::TwinThrusters { left_radps, right_radps }, force)
}

/// Shaft speed at a command, rad/s: full command is the speed that gives the thrust limit.
fn shaft_speed_radps(twin: &TwinThrusters, command: f64) -> f64 {
    if command >= 0.0 {
        command * (twin.ahead_limit_n / twin.ahead_n_per_radps2).sqrt()
    } else {
        command * (twin.astern_limit_n / twin.astern_n_per_radps2).sqrt()
    }
}

fn shaft_thrust_n(twin: &TwinThrusters, n_radps: f64) -> f64 {
    let k = if n_radps >= 0.0 { twin.ahead_n_per_radps2 } else { twin.astern_n_per_radps2 };
    k * n_radps * n_radps.abs()
}

/// New (throttle, steering angle): revolutions lag, the steering gear moves at a limited rate.
fn step_steered(
    drive: &SteeredDrive,
    state: ActuatorState,
    command: ActuatorCommand,
    dt_s: f64,
) -> (f64, f64) {
    let (throttle, steering_rad) = match state {
        ActuatorState::ThrottleSteering { throttle, steering_rad } => (throttle, steering_rad),
        ActuatorState::TwinThrusters { .. } => (0.0, 0.0),
    };
    let (wanted_throttle, steering) = command.throttle_steering();
    let throttle = throttle + lag_share(drive.throttle_lag_s, dt_s) * (wanted_throttle - throttle);
    let travel = drive.steering_rate_radps * dt_s;
    let turn = (steering * drive.steering_limit_rad - steering_rad).clamp(-travel, travel);
    (throttle, steering_rad + turn)
}

/// Thrust of the single propeller, N: quadratic in the revolutions.
fn propeller_thrust_n(drive: &SteeredDrive, throttle: f64) -> f64 {
    let limit_n = if throttle >= 0.0 { drive.ahead_limit_n } else { drive.astern_limit_n };
    limit_n * throttle * throttle.abs()
}

/// Normal force of a rudder (or of an outboard's leg) F_N = ½ρA f_α U_R² sin δ, resolved into drag, side force
/// and yaw moment about midship (Fossen 2021, §9.5). The squared inflow speed is that of the advance ahead
/// plus what the propeller adds; astern, neither reaches the foil and it does nothing.
fn foil_force(drive: &SteeredDrive, (sin, cos): (f64, f64), thrust_n: f64, u_r_mps: f64) -> BodyForce {
    let advance_mps = u_r_mps.max(0.0);
    let inflow_m2ps2 = advance_mps * advance_mps + drive.slipstream_m2ps2_per_n * thrust_n.max(0.0);
    let normal_n = drive.foil_n_per_mps2 * inflow_m2ps2 * sin;
    BodyForce { surge_n: -normal_n * sin, sway_n: -normal_n * cos, yaw_nm: drive.arm_m * normal_n * cos }
}

/// Share of the remaining way a first-order lag covers in `dt_s`.
fn lag_share(lag_s: f64, dt_s: f64) -> f64 {
    if lag_s > 0.0 { -(-dt_s / lag_s).exp_m1() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::hull::Hull;

    fn settled(name: &str, command: ActuatorCommand, u_r_mps: f64) -> BodyForce {
        let hull = Hull::builtin(name).unwrap();
        let HullDynamics::Maneuvering(_, propulsion) = hull.dynamics else {
            panic!("{name} has no actuators")
        };
        let mut state = ActuatorState::at_rest(&hull.dynamics);
        let mut force = BodyForce::default();
        for _ in 0..6000 {
            (state, force) = step(&propulsion, state, command, u_r_mps, 0.01);
        }
        force
    }

    #[test]
    fn the_otter_pulls_its_published_bollard_thrust() {
        let ahead = settled("otter", ActuatorCommand::TwinThrusters { left: 1.0, right: 1.0 }, 0.0);
        assert!((ahead.surge_n - 24.4 * 9.81).abs() < 0.01, "{ahead:?}");
        let astern = settled("otter", ActuatorCommand::TwinThrusters { left: -1.0, right: -1.0 }, 0.0);
        assert!((astern.surge_n + 13.6 * 9.81).abs() < 0.01, "{astern:?}");
        let spin = settled("otter", ActuatorCommand::TwinThrusters { left: 1.0, right: -1.0 }, 0.0);
        assert!((spin.yaw_nm - 0.395 * (119.682 + 66.708)).abs() < 0.01, "{spin:?}");
    }

    #[test]
    fn steering_to_starboard_turns_to_starboard_and_pushes_the_stern_to_port() {
        for name in ["monohull38", "skiff"] {
            let force =
                settled(name, ActuatorCommand::ThrottleSteering { throttle: 0.7, steering: 0.5 }, 1.0);
            assert!(force.yaw_nm > 0.0 && force.sway_n < 0.0, "{name}: {force:?}");
        }
    }

    #[test]
    fn a_rudder_bites_in_the_slipstream_only_ahead() {
        let ahead =
            settled("monohull38", ActuatorCommand::ThrottleSteering { throttle: 0.5, steering: 1.0 }, 0.0);
        let astern =
            settled("monohull38", ActuatorCommand::ThrottleSteering { throttle: -0.5, steering: 1.0 }, -1.0);
        assert!(ahead.yaw_nm > 1e4, "{ahead:?}");
        assert_eq!(astern.yaw_nm, 0.0);
    }

    #[test]
    fn the_rudder_of_the_ship_takes_seven_seconds_hard_over() {
        let hull = Hull::builtin("monohull38").unwrap();
        let HullDynamics::Maneuvering(_, propulsion) = hull.dynamics else { panic!() };
        let mut state = ActuatorState::at_rest(&hull.dynamics);
        let command = ActuatorCommand::ThrottleSteering { throttle: 0.0, steering: 1.0 };
        for _ in 0..600 {
            (state, _) = step(&propulsion, state, command, 0.0, 0.01);
        }
        let ActuatorState::ThrottleSteering { steering_rad, .. } = state else { panic!() };
        assert!((steering_rad.to_degrees() - 30.0).abs() < 1e-6);
    }

    #[test]
    fn mixing_keeps_the_steering_and_clips_the_throttle() {
        let command = ActuatorCommand::ThrottleSteering { throttle: 1.0, steering: 0.4 };
        let (left, right) = command.left_right();
        assert!((left - 1.0).abs() < 1e-12 && (right - 0.2).abs() < 1e-12);
    }

    #[test]
    fn nonsense_commands_are_neutral_or_clipped() {
        let command = ActuatorCommand::TwinThrusters { left: f64::NAN, right: f64::INFINITY };
        assert_eq!(command.left_right(), (0.0, 1.0));
    }
}
