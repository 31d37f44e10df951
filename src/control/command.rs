//! What the controller asks of the boat.

/// Normalised demand in ArduRover's meaning of throttle and steering.
///
/// On a boat with twin thrusters the autopilot mixes left = throttle + steering and right = throttle −
/// steering; `|throttle| + |steering| ≤ 1` always holds there, so the mixer never clips. On a rudder boat
/// steering +1 is full right turn and the two are independent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Command {
    /// Throttle, −1 (full astern) to 1 (full ahead).
    pub throttle: f64,
    /// Steering, −1 (full left) to 1 (full right).
    pub steering: f64,
}

impl Command {
    /// Everything at rest.
    pub const NEUTRAL: Self = Self { throttle: 0.0, steering: 0.0 };
}

/// Forces on the hull in the plane, body frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wrench {
    /// Surge force τ_u, N, ahead positive.
    pub surge_n: f64,
    /// Side force, N, starboard positive. Never demanded: a by-product of a rudder.
    pub sway_n: f64,
    /// Yaw moment τ_r, N·m, clockwise positive.
    pub yaw_nm: f64,
}
