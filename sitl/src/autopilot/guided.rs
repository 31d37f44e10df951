//! GUIDED: driving on orders over MAVLink.

use std::time::Duration;

use helmlink_mission::angle::ssa;
use helmlink_mission::geodesy::{Geodetic, NorthEast};
use helmlink_wire::dialect::{
    SET_ATTITUDE_TARGET_DATA, SET_POSITION_TARGET_GLOBAL_INT_DATA, SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use helmlink_wire::enums::*;

use super::Autopilot;
use super::modes::Mode;
use super::motion::Demand;
use super::navigation::{self, Leg, Report};
use super::parameters::*;

/// A target for speed or turn rate holds this long, then the boat keeps its place.
pub(super) const TARGET_TIMEOUT: Duration = Duration::from_secs(3);

/// What GUIDED drives for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Target {
    /// Keep a place.
    Hold(NorthEast),
    /// Go along a leg, then keep its end.
    Leg { leg: Leg, arrived: bool },
    /// A heading, and a speed that may be astern.
    Heading { heading_rad: f64, speed_mps: f64, since: Duration },
    /// A turn rate, and a speed that may be astern.
    TurnRate { turn_rate_radps: f64, speed_mps: f64, since: Duration },
}

/// State of GUIDED.
#[derive(Debug, Clone)]
pub(super) struct Guided {
    target: Target,
    /// The speed toward a place that was asked for.
    speed_mps: Option<f64>,
}

impl Default for Guided {
    fn default() -> Self {
        Self { target: Target::Hold(NorthEast::ZERO), speed_mps: None }
    }
}

impl Guided {
    /// Starts by keeping a place.
    pub(super) fn begin(&mut self, place: NorthEast) {
        *self = Self { target: Target::Hold(place), speed_mps: None };
    }

    pub(super) fn set_speed(&mut self, speed_mps: f64) {
        self.speed_mps = Some(speed_mps);
    }
}

/// The parts of a SET_POSITION_TARGET message that matter to a boat; `None` where the mask says ignore.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PositionTarget {
    place: Option<NorthEast>,
    /// Velocity, north and east or forward and right, m/s.
    velocity_mps: Option<NorthEast>,
    yaw_rad: Option<f64>,
    yaw_rate_radps: Option<f64>,
    /// Whether velocity and yaw count from the bow.
    from_bow: bool,
}

impl Autopilot {
    /// SET_ATTITUDE_TARGET: thrust is a share of the default speed; a body yaw rate wins over the attitude.
    pub(super) fn take_attitude_target(&mut self, data: &SET_ATTITUDE_TARGET_DATA) {
        let ignored = |bit: u8| data.type_mask & bit != 0;
        if self.mode != Mode::Guided || ignored(ATTITUDE_TARGET_TYPEMASK_THROTTLE_IGNORE) {
            return;
        }
        let thrust = f64::from(data.thrust);
        if !thrust.is_finite() {
            return;
        }
        let speed_mps = thrust.clamp(-1.0, 1.0) * navigation::default_speed_mps(&self.parameters);
        if !ignored(ATTITUDE_TARGET_TYPEMASK_BODY_YAW_RATE_IGNORE) {
            self.set_turn_rate(f64::from(data.body_yaw_rate), speed_mps);
        } else if !ignored(ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE)
            && let Some(heading_rad) = yaw_of(data.q)
        {
            self.set_heading(heading_rad, speed_mps);
        }
    }

    /// SET_POSITION_TARGET_LOCAL_NED in the frames LOCAL_NED, LOCAL_OFFSET_NED, BODY_NED, BODY_OFFSET_NED.
    pub(super) fn take_local_target(&mut self, data: &SET_POSITION_TARGET_LOCAL_NED_DATA) {
        let from_bow = match data.coordinate_frame {
            MAV_FRAME_LOCAL_NED | MAV_FRAME_LOCAL_OFFSET_NED => false,
            MAV_FRAME_BODY_NED | MAV_FRAME_BODY_OFFSET_NED => true,
            _ => return,
        };
        let offset = NorthEast::new(f64::from(data.x), f64::from(data.y));
        let motion = self.motion();
        let place = match data.coordinate_frame {
            MAV_FRAME_LOCAL_NED => offset,
            MAV_FRAME_LOCAL_OFFSET_NED => motion.position + offset,
            _ => motion.position + offset.rotated(motion.heading_rad),
        };
        let velocity = NorthEast::new(f64::from(data.vx), f64::from(data.vy));
        let (yaw, yaw_rate) = (f64::from(data.yaw), f64::from(data.yaw_rate));
        self.take_position_target(data.type_mask, place, velocity, yaw, yaw_rate, from_bow);
    }

    /// SET_POSITION_TARGET_GLOBAL_INT in any global frame; the altitude does not matter.
    pub(super) fn take_global_target(&mut self, data: &SET_POSITION_TARGET_GLOBAL_INT_DATA) {
        if !is_global_frame(data.coordinate_frame) {
            return;
        }
        let place = Geodetic::from_e7(data.lat_int, data.lon_int);
        let wants_place = data.type_mask & PLACE_IGNORED == 0;
        if wants_place && !is_usable(place) {
            return;
        }
        let velocity = NorthEast::new(f64::from(data.vx), f64::from(data.vy));
        let (yaw, yaw_rate) = (f64::from(data.yaw), f64::from(data.yaw_rate));
        let place = if wants_place { self.frame.to_local(place) } else { NorthEast::ZERO };
        self.take_position_target(data.type_mask, place, velocity, yaw, yaw_rate, false);
    }

    fn take_position_target(
        &mut self,
        mask: u16,
        place: NorthEast,
        velocity: NorthEast,
        yaw_rad: f64,
        yaw_rate_radps: f64,
        from_bow: bool,
    ) {
        let wanted = |bits: u16| mask & bits == 0;
        let wants_acceleration = mask & ACCELERATION_IGNORED == 0;
        if self.mode != Mode::Guided || wants_acceleration {
            return;
        }
        self.follow_position_target(PositionTarget {
            place: wanted(PLACE_IGNORED).then_some(place),
            velocity_mps: wanted(VELOCITY_IGNORED).then_some(velocity),
            yaw_rad: wanted(POSITION_TARGET_TYPEMASK_YAW_IGNORE).then_some(yaw_rad),
            yaw_rate_radps: wanted(POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE).then_some(yaw_rate_radps),
            from_bow,
        });
    }

    /// What is done with which combination, as measured on ArduRover 4.6: a place wins; a velocity alone
    /// steers its direction; with a yaw or a yaw rate only its size and the sign of its first component
    /// count; yaw and yaw rate together are ignored.
    fn follow_position_target(&mut self, target: PositionTarget) {
        if let Some(place) = target.place {
            self.go_to(place);
            return;
        }
        let bow_rad = if target.from_bow { self.motion().heading_rad } else { 0.0 };
        let speed = |velocity: NorthEast| velocity.norm();
        let signed = |velocity: NorthEast| velocity.norm().copysign(velocity.north_m + 0.0);
        match (target.velocity_mps, target.yaw_rad, target.yaw_rate_radps) {
            (Some(velocity), None, None) => {
                self.set_heading(velocity.bearing_rad() + bow_rad, speed(velocity));
            }
            (Some(velocity), Some(yaw_rad), None) => self.set_heading(yaw_rad + bow_rad, signed(velocity)),
            (Some(velocity), None, Some(rate)) => self.set_turn_rate(rate, signed(velocity)),
            (None, Some(yaw_rad), None) => self.set_heading(yaw_rad + bow_rad, 0.0),
            (None, None, Some(rate)) => self.set_turn_rate(rate, 0.0),
            (_, Some(_), Some(_)) | (None, None, None) => {}
        }
    }

    /// GUIDED: goes to a place and keeps it.
    pub(super) fn go_to(&mut self, place: NorthEast) {
        if place.is_finite() {
            let leg = Leg { from: self.motion().position, to: place };
            self.guided.target = Target::Leg { leg, arrived: false };
        }
    }

    /// GUIDED: a heading and a speed, for [`TARGET_TIMEOUT`].
    pub(super) fn set_heading(&mut self, heading_rad: f64, speed_mps: f64) {
        if heading_rad.is_finite() && speed_mps.is_finite() {
            let speed_mps = self.within_default_speed(speed_mps);
            let heading_rad = ssa(heading_rad);
            self.guided.target = Target::Heading { heading_rad, speed_mps, since: self.now };
        }
    }

    fn set_turn_rate(&mut self, turn_rate_radps: f64, speed_mps: f64) {
        if turn_rate_radps.is_finite() && speed_mps.is_finite() {
            let speed_mps = self.within_default_speed(speed_mps);
            self.guided.target = Target::TurnRate { turn_rate_radps, speed_mps, since: self.now };
        }
    }

    fn within_default_speed(&self, speed_mps: f64) -> f64 {
        let limit_mps = navigation::default_speed_mps(&self.parameters);
        speed_mps.clamp(-limit_mps, limit_mps)
    }

    pub(super) fn guided_demand(&mut self) -> (Demand, Option<Report>) {
        let motion = self.motion();
        self.drop_old_target();
        match self.guided.target {
            Target::Hold(place) => {
                let (demand, report) = navigation::hold(place, &motion, &self.parameters);
                (demand, Some(report))
            }
            Target::Leg { leg, arrived } => {
                let radius_m = self.parameters.get(WP_RADIUS);
                if arrived || leg.is_done(&motion, radius_m) {
                    self.guided.target = Target::Leg { leg, arrived: true };
                    let (demand, report) = navigation::hold(leg.to, &motion, &self.parameters);
                    return (demand, Some(report));
                }
                let default_mps = navigation::default_speed_mps(&self.parameters);
                let speed_mps = self.guided.speed_mps.unwrap_or(default_mps);
                let (demand, report) = navigation::follow(&leg, speed_mps, true, &motion, &self.parameters);
                (demand, Some(report))
            }
            Target::Heading { heading_rad, speed_mps, .. } => {
                (navigation::steer_heading(heading_rad, speed_mps, &motion, &self.parameters), None)
            }
            Target::TurnRate { turn_rate_radps, speed_mps, .. } => {
                (Demand::Drive { turn_rate_radps, speed_mps }, None)
            }
        }
    }

    fn drop_old_target(&mut self) {
        let since = match self.guided.target {
            Target::Heading { since, .. } | Target::TurnRate { since, .. } => since,
            Target::Hold(_) | Target::Leg { .. } => return,
        };
        if self.now.saturating_sub(since) >= TARGET_TIMEOUT {
            let stop = navigation::stopping_point(&self.motion(), &self.parameters);
            self.guided.target = Target::Hold(stop);
            self.links.text(MAV_SEVERITY_WARNING, "target not received last 3secs, stopping");
        }
    }
}

const PLACE_IGNORED: u16 = POSITION_TARGET_TYPEMASK_X_IGNORE | POSITION_TARGET_TYPEMASK_Y_IGNORE;
const VELOCITY_IGNORED: u16 = POSITION_TARGET_TYPEMASK_VX_IGNORE | POSITION_TARGET_TYPEMASK_VY_IGNORE;
const ACCELERATION_IGNORED: u16 = POSITION_TARGET_TYPEMASK_AX_IGNORE
    | POSITION_TARGET_TYPEMASK_AY_IGNORE
    | POSITION_TARGET_TYPEMASK_AZ_IGNORE;

/// Whether a MAV_FRAME holds latitude and longitude.
pub(super) fn is_global_frame(frame: u8) -> bool {
    matches!(
        frame,
        MAV_FRAME_GLOBAL
            | MAV_FRAME_GLOBAL_RELATIVE_ALT
            | MAV_FRAME_GLOBAL_INT
            | MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
            | MAV_FRAME_GLOBAL_TERRAIN_ALT
            | MAV_FRAME_GLOBAL_TERRAIN_ALT_INT
    )
}

/// Whether a position may be driven to: on the globe, and not the 0/0 of unset fields.
pub(super) fn is_usable(position: Geodetic) -> bool {
    position.is_valid() && position.to_e7() != (0, 0)
}

/// Yaw of an attitude quaternion (w, x, y, z); `None` if it is no rotation.
fn yaw_of(q: [f32; 4]) -> Option<f64> {
    let [w, x, y, z] = q.map(f64::from);
    let norm = w * w + x * x + y * y + z * z;
    let valid = norm.is_finite() && norm > 0.1;
    valid.then(|| (2.0 * (w * z + x * y)).atan2(w * w + x * x - y * y - z * z))
}

#[cfg(test)]
mod tests;
