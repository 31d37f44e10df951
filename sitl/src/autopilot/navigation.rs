//! From places to go to demands: along a line, to a point, at a point, around a point.
//!
//! A plain autopilot, not the path follower this project is about: line of sight (Fossen 2021, §12.3) with
//! the drift angle taken off, as good as what a flight controller brings along.

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::NorthEast;

use super::motion::{Demand, Motion};
use super::outputs::function;
use super::parameters::*;
use crate::physics::GRAVITY_MPS2;

/// Share of the speed kept however much the heading is off: two thrusters turn best slowly, a rudder needs
/// the stream of the propeller.
const TURNING_SHARE_TWIN: f64 = 0.3;
const TURNING_SHARE_RUDDER: f64 = 0.8;
/// Share of the speed kept up to the last waypoint, so that it is reached.
const CRAWL_SHARE: f64 = 0.15;

/// Share of the allowed deceleration planned for: the rest makes up for the throttle's delay.
const BRAKING_SHARE: f64 = 0.5;

/// A straight piece of route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leg {
    pub(super) from: NorthEast,
    pub(super) to: NorthEast,
}

/// What ground stations are shown about navigation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Report {
    /// Where to.
    pub(super) target: NorthEast,
    pub(super) distance_m: f64,
    /// Bearing of the target.
    pub(super) target_bearing_rad: f64,
    /// Course steered.
    pub(super) course_rad: f64,
    /// Positive right of the line.
    pub(super) cross_track_m: f64,
    /// Speed wanted minus speed made, m/s.
    pub(super) speed_error_mps: f64,
}

impl Leg {
    /// How far along and how far right of the line a point is, m.
    pub(super) fn along_and_right_m(&self, point: NorthEast) -> (f64, f64) {
        let span = self.to - self.from;
        let length_m = span.norm();
        if length_m <= f64::EPSILON {
            return (0.0, 0.0);
        }
        let direction = span * (1.0 / length_m);
        let offset = point - self.from;
        (offset.dot(direction), direction.cross(offset))
    }

    /// Whether a boat is at the end: within `radius_m` of it, or past it.
    pub(super) fn is_done(&self, motion: &Motion, radius_m: f64) -> bool {
        let (along_m, _) = self.along_and_right_m(motion.position);
        let length_m = (self.to - self.from).norm();
        (motion.position - self.to).norm() <= radius_m || (length_m > radius_m && along_m >= length_m)
    }
}

/// Sails along a leg; `stop_at_end` slows down toward its end.
pub(super) fn follow(
    leg: &Leg,
    speed_mps: f64,
    stop_at_end: bool,
    motion: &Motion,
    parameters: &Parameters,
) -> (Demand, Report) {
    let to_target = leg.to - motion.position;
    let (_, right_m) = leg.along_and_right_m(motion.position);
    let line_rad = if (leg.to - leg.from).norm() > 0.1 {
        (leg.to - leg.from).bearing_rad()
    } else {
        to_target.bearing_rad()
    };
    let course_rad = ssa(line_rad - (right_m / parameters.get(WP_LOOKAHEAD)).atan());
    let mut wanted_mps = speed_mps;
    if stop_at_end {
        let braking_mps = (2.0 * BRAKING_SHARE * braking_mps2(parameters) * to_target.norm()).sqrt();
        wanted_mps = wanted_mps.min(braking_mps.max(CRAWL_SHARE * speed_mps));
    }
    let demand = steer_course(course_rad, wanted_mps, motion, parameters);
    let report = Report {
        target: leg.to,
        distance_m: to_target.norm(),
        target_bearing_rad: to_target.bearing_rad(),
        course_rad,
        cross_track_m: right_m,
        speed_error_mps: wanted_mps - motion.forward_mps(),
    };
    (demand, report)
}

/// Stays near a point: drives back, ahead or astern as LOIT_TYPE allows, once it is out of LOIT_RADIUS.
pub(super) fn hold(point: NorthEast, motion: &Motion, parameters: &Parameters) -> (Demand, Report) {
    let to_point = point - motion.position;
    let distance_m = to_point.norm();
    let bearing_rad = to_point.bearing_rad();
    let outside_m = distance_m - parameters.get(LOIT_RADIUS);
    let (demand, wanted_mps) = if outside_m <= 0.0 {
        (Demand::Drive { turn_rate_radps: 0.0, speed_mps: 0.0 }, 0.0)
    } else {
        let limit_mps = default_speed_mps(parameters);
        let speed_mps = (outside_m * parameters.get(LOIT_SPEED_GAIN)).min(limit_mps);
        let error_rad = ssa(bearing_rad - motion.heading_rad);
        // LOIT_TYPE 0: whichever end is nearer; 1: bow first; 2: stern first.
        let astern = match parameters.int(LOIT_TYPE) {
            0 => error_rad.abs() > std::f64::consts::FRAC_PI_2,
            kind => kind == 2,
        };
        let heading_rad = if astern { bearing_rad + std::f64::consts::PI } else { bearing_rad };
        let signed_mps = if astern { -speed_mps } else { speed_mps };
        (steer_heading(heading_rad, signed_mps, motion, parameters), signed_mps)
    };
    let report = Report {
        target: point,
        distance_m,
        target_bearing_rad: bearing_rad,
        course_rad: bearing_rad,
        cross_track_m: 0.0,
        speed_error_mps: wanted_mps - motion.forward_mps(),
    };
    (demand, report)
}

/// Sails around `centre`.
pub(super) fn circle(
    centre: NorthEast,
    clockwise: bool,
    motion: &Motion,
    parameters: &Parameters,
) -> (Demand, Report) {
    let outward = motion.position - centre;
    let outside_m = outward.norm() - parameters.get(CIRC_RADIUS);
    let side = if clockwise { 1.0 } else { -1.0 };
    let inward_rad = (outside_m / parameters.get(WP_LOOKAHEAD)).atan();
    let tangent_rad = outward.bearing_rad() + side * std::f64::consts::FRAC_PI_2;
    let course_rad = ssa(tangent_rad + side * inward_rad);
    let speed_mps = positive_or(parameters.get(CIRC_SPEED), default_speed_mps(parameters));
    let demand = match steer_course(course_rad, speed_mps, motion, parameters) {
        Demand::Drive { turn_rate_radps, speed_mps } => {
            // The turn rate the circle itself needs.
            let along = side * motion.speed_mps() / outward.norm().max(parameters.get(CIRC_RADIUS));
            Demand::Drive { turn_rate_radps: turn_rate_radps + along, speed_mps }
        }
        other => other,
    };
    let report = Report {
        target: centre,
        distance_m: outward.norm(),
        target_bearing_rad: (centre - motion.position).bearing_rad(),
        course_rad,
        cross_track_m: -side * outside_m,
        speed_error_mps: speed_mps - motion.forward_mps(),
    };
    (demand, report)
}

/// Turns the boat so that it moves in the direction `course_rad`.
fn steer_course(course_rad: f64, speed_mps: f64, motion: &Motion, parameters: &Parameters) -> Demand {
    steer_heading(course_rad - motion.drift_rad, speed_mps, motion, parameters)
}

/// Turns the boat to a heading, slower the more it is off.
pub(super) fn steer_heading(
    heading_rad: f64,
    speed_mps: f64,
    motion: &Motion,
    parameters: &Parameters,
) -> Demand {
    let error_rad = ssa(heading_rad - motion.heading_rad);
    let least = if is_twin(parameters) { TURNING_SHARE_TWIN } else { TURNING_SHARE_RUDDER };
    let share = error_rad.cos().max(least);
    let sideways_mps2 = parameters.get(ATC_TURN_MAX_G) * GRAVITY_MPS2;
    let limit_radps = sideways_mps2 / motion.speed_mps().max(0.1);
    let turn_rate_radps = (parameters.get(ATC_STR_ANG_P) * error_rad).clamp(-limit_radps, limit_radps);
    Demand::Drive { turn_rate_radps, speed_mps: speed_mps * share }
}

/// Where a boat that brakes now comes to rest.
pub(super) fn stopping_point(motion: &Motion, parameters: &Parameters) -> NorthEast {
    let speed_mps = motion.speed_mps();
    motion.position + motion.velocity_mps * (speed_mps / (2.0 * braking_mps2(parameters)))
}

/// The speed of autopilot modes unless another one was asked for: WP_SPEED, or CRUISE_SPEED if that is 0.
pub(super) fn default_speed_mps(parameters: &Parameters) -> f64 {
    positive_or(parameters.get(WP_SPEED), parameters.get(CRUISE_SPEED))
}

pub(super) fn positive_or(value: f64, otherwise: f64) -> f64 {
    if value > 0.0 { value } else { otherwise }
}

/// Whether the outputs drive two thrusters.
fn is_twin(parameters: &Parameters) -> bool {
    parameters.int(servo(1, ServoField::Function)) == function::THROTTLE_LEFT
}

fn braking_mps2(parameters: &Parameters) -> f64 {
    parameters.get(ATC_DECEL_MAX).max(0.01)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(north_m: f64, east_m: f64, heading_rad: f64, speed_mps: f64) -> Motion {
        Motion {
            position: NorthEast::new(north_m, east_m),
            velocity_mps: NorthEast::from_polar(speed_mps, heading_rad),
            heading_rad,
            turn_rate_radps: 0.0,
            drift_rad: 0.0,
        }
    }

    fn north(length_m: f64) -> Leg {
        Leg { from: NorthEast::ZERO, to: NorthEast::new(length_m, 0.0) }
    }

    fn turn(demand: Demand) -> f64 {
        match demand {
            Demand::Drive { turn_rate_radps, .. } => turn_rate_radps,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn right_of_the_line_it_turns_left() {
        let parameters = Parameters::new();
        let (demand, report) = follow(&north(100.0), 2.0, false, &at(10.0, 5.0, 0.0, 2.0), &parameters);
        assert_eq!(report.cross_track_m, 5.0);
        assert!(turn(demand) < 0.0);
        let (demand, _) = follow(&north(100.0), 2.0, false, &at(10.0, -5.0, 0.0, 2.0), &parameters);
        assert!(turn(demand) > 0.0);
    }

    #[test]
    fn drift_is_taken_off() {
        let parameters = Parameters::new();
        let crabbing =
            Motion { velocity_mps: NorthEast::new(2.0, 0.0), drift_rad: 0.3, ..at(10.0, 0.0, -0.3, 2.0) };
        let (demand, _) = follow(&north(100.0), 2.0, false, &crabbing, &parameters);
        assert!(turn(demand).abs() < 1e-9, "the boat already moves along the line");
    }

    #[test]
    fn a_leg_ends_within_the_radius_or_beyond_its_end() {
        let leg = north(100.0);
        assert!(!leg.is_done(&at(95.0, 0.0, 0.0, 2.0), 3.0));
        assert!(leg.is_done(&at(98.0, 0.0, 0.0, 2.0), 3.0));
        assert!(leg.is_done(&at(100.5, 30.0, 0.0, 2.0), 3.0));
        let point = Leg { from: NorthEast::ZERO, to: NorthEast::ZERO };
        assert!(point.is_done(&at(0.0, 0.0, 0.0, 0.0), 3.0));
        assert!(!point.is_done(&at(9.0, 0.0, 0.0, 0.0), 3.0));
    }

    #[test]
    fn holding_backs_up_when_the_point_is_astern() {
        let parameters = Parameters::new();
        let (demand, _) = hold(NorthEast::new(-20.0, 0.0), &at(0.0, 0.0, 0.0, 0.0), &parameters);
        assert!(matches!(demand, Demand::Drive { speed_mps, .. } if speed_mps < 0.0), "{demand:?}");
        let (demand, _) = hold(NorthEast::new(1.0, 0.0), &at(0.0, 0.0, 0.0, 0.0), &parameters);
        assert_eq!(demand, Demand::Drive { turn_rate_radps: 0.0, speed_mps: 0.0 });
    }

    #[test]
    fn a_circle_is_entered_tangentially() {
        let parameters = Parameters::new();
        let radius_m = parameters.get(CIRC_RADIUS);
        // East of the centre, heading south: on a clockwise circle already.
        let motion = at(0.0, radius_m, std::f64::consts::PI, 2.0);
        let (demand, report) = circle(NorthEast::ZERO, true, &motion, &parameters);
        assert!(report.cross_track_m.abs() < 1e-9);
        assert!((turn(demand) - 2.0 / radius_m).abs() < 1e-9);
    }
}
