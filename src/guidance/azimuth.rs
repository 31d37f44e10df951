//! Azimuth from the boat to the virtual ship, the bias of the chord, and their exact rates.

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::PathPoint;

/// An angle and its rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angle {
    /// Radians.
    pub rad: f64,
    /// Radians per second.
    pub radps: f64,
}

/// Azimuth ψ_r from `boat` to the virtual ship (Eq. 3), defined everywhere.
///
/// The printed arctangent with signs is wrong on the axes; this is atan2. Closer than `near_m` the virtual
/// ship's own direction is blended in, so that z_e → 0 gives ψ_d, as the paper's special case says. `velocity`
/// is the boat's over ground, `speed_mps` the virtual ship's u_d.
#[must_use]
pub fn azimuth(boat: NorthEast, velocity: NorthEast, ship: &PathPoint, speed_mps: f64, near_m: f64) -> Angle {
    let tangent = ship.tangent;
    let normal = tangent.starboard();
    let gap = ship.position - boat;
    let gap_rate = tangent * speed_mps - velocity;
    let distance = gap.norm();
    let blend = (near_m - distance).max(0.0);
    let blend_rate = if blend > 0.0 && distance > 0.0 { -gap.dot(gap_rate) / distance } else { 0.0 };
    let aim = gap + tangent * blend;
    let aim_rate = gap_rate + tangent * blend_rate + normal * (blend * ship.curvature_radpm * speed_mps);
    direction(aim, aim_rate, ship.heading_rad)
}

/// Bias γ_c of the chord from the boat's foot on the path to the virtual ship, against the path's direction at
/// the foot. Chasing a point around a bend at a distance cuts the bend; subtracting this does not.
///
/// `foot_mps` is ṡ_p, `ship_mps` is u_d.
#[must_use]
pub fn chord_bias(foot: &PathPoint, foot_mps: f64, ship: &PathPoint, ship_mps: f64) -> Angle {
    let chord = ship.position - foot.position;
    let chord_rate = ship.tangent * ship_mps - foot.tangent * foot_mps;
    let chord = direction(chord, chord_rate, foot.heading_rad);
    Angle { rad: ssa(chord.rad - foot.heading_rad), radps: chord.radps - foot.curvature_radpm * foot_mps }
}

/// Direction of a vector and its rate; of a vector without length, `fallback_rad`.
fn direction(vector: NorthEast, rate: NorthEast, fallback_rad: f64) -> Angle {
    /// Shortest vector that has a direction, m.
    const SHORTEST_M: f64 = 1.0e-3;
    let length = vector.norm();
    if length < SHORTEST_M {
        return Angle { rad: fallback_rad, radps: 0.0 };
    }
    Angle { rad: vector.bearing_rad(), radps: vector.cross(rate) / (length * length) }
}
