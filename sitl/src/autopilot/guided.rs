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
mod tests {
    use helmlink_wire::Message;

    use super::*;
    use crate::autopilot::testing::{Bench, COMPANION, LINK};

    fn guided() -> Bench {
        let mut bench = Bench::ready();
        bench.arm();
        bench.autopilot.enter_mode(Mode::Guided).unwrap();
        bench
    }

    fn attitude_target(type_mask: u8, yaw_rate: f32, thrust: f32) -> Message {
        let half = std::f32::consts::FRAC_PI_4;
        Message::SET_ATTITUDE_TARGET(SET_ATTITUDE_TARGET_DATA {
            q: [half.cos(), 0.0, 0.0, half.sin()],
            body_yaw_rate: yaw_rate,
            thrust,
            target_system: 1,
            target_component: 1,
            type_mask,
            ..SET_ATTITUDE_TARGET_DATA::DEFAULT
        })
    }

    fn velocity_target(type_mask: u16, vx: f32, vy: f32, yaw_rate: f32) -> Message {
        Message::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
            vx,
            vy,
            yaw_rate,
            type_mask,
            target_system: 1,
            target_component: 1,
            coordinate_frame: MAV_FRAME_LOCAL_NED,
            ..SET_POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
        })
    }

    fn drive(bench: &mut Bench, message: &Message, seconds: u32) {
        for _ in 0..2 * seconds {
            bench.send(LINK, COMPANION, message);
            bench.run_s(0.5);
        }
    }

    #[test]
    fn thrust_is_a_share_of_the_default_speed_and_the_yaw_rate_is_kept() {
        let mut bench = guided();
        let full_mps = navigation::default_speed_mps(&bench.autopilot.parameters);
        drive(&mut bench, &attitude_target(0x83, 0.1, 0.5), 30);
        let truth = bench.vessel.truth();
        assert!((truth.hull.u_mps - 0.5 * full_mps).abs() < 0.05 * full_mps, "{truth:?}");
        assert!((truth.hull.r_radps - 0.1).abs() < 0.01, "{truth:?}");
    }

    #[test]
    fn attitude_is_a_heading_when_the_rate_is_ignored() {
        let mut bench = guided();
        drive(&mut bench, &attitude_target(0x07, 0.0, 0.4), 30);
        let heading_deg = bench.vessel.truth().hull.psi_rad.to_degrees();
        assert!((heading_deg - 90.0).abs() < 2.0, "{heading_deg}");
    }

    #[test]
    fn velocity_alone_steers_its_direction_and_is_limited() {
        let mut bench = guided();
        drive(&mut bench, &velocity_target(0xDC7, 0.0, 20.0, 0.0), 40);
        let hull = bench.vessel.truth().hull;
        let full_mps = navigation::default_speed_mps(&bench.autopilot.parameters);
        assert!((hull.psi_rad.to_degrees() - 90.0).abs() < 2.0);
        assert!((hull.u_mps - full_mps).abs() < 0.05 * full_mps, "{hull:?}");
    }

    #[test]
    fn combinations_without_meaning_are_ignored() {
        let mut bench = guided();
        let before = bench.autopilot.guided.target;
        for message in [
            velocity_target(0x1C7, 1.0, 0.0, 0.1),
            velocity_target(0xC07, 1.0, 0.0, 0.0),
            velocity_target(0xDC7, f32::NAN, 0.0, 0.0),
            attitude_target(0x40, 0.1, 0.5),
            attitude_target(0x00, f32::INFINITY, 0.5),
            attitude_target(0x07, 0.0, f32::NAN),
        ] {
            bench.send(LINK, COMPANION, &message);
            bench.run_loops(1);
            assert_eq!(bench.autopilot.guided.target, before, "{message:?}");
        }
    }

    #[test]
    fn targets_are_ignored_outside_guided() {
        let mut bench = guided();
        bench.autopilot.enter_mode(Mode::Hold).unwrap();
        drive(&mut bench, &attitude_target(0x83, 0.1, 0.5), 2);
        assert_eq!(bench.autopilot.command, Default::default());
    }

    #[test]
    fn a_target_lasts_three_seconds_and_then_the_place_is_kept() {
        let mut bench = guided();
        drive(&mut bench, &attitude_target(0x83, 0.0, 0.5), 10);
        bench.send(LINK, COMPANION, &attitude_target(0x83, 0.0, 0.5));
        let held = bench.run_s(2.9);
        assert!(!Bench::texts(&held).iter().any(|text| text.contains("3secs")));
        let stopped = bench.run_s(0.3);
        assert!(Bench::texts(&stopped).iter().any(|text| text.contains("3secs")));
        let there = bench.position();
        bench.run_s(60.0);
        assert!((bench.position() - there).norm() < 8.0);
        assert!(bench.vessel.truth().hull.u_mps.abs() < 0.3);
    }

    #[test]
    fn a_place_is_reached_and_kept() {
        let mut bench = guided();
        let place = NorthEast::new(30.0, 40.0);
        let (lat_int, lon_int) = bench.autopilot.frame.to_geodetic(place).to_e7();
        let target = SET_POSITION_TARGET_GLOBAL_INT_DATA {
            lat_int,
            lon_int,
            type_mask: 0xFF8,
            target_system: 1,
            target_component: 1,
            coordinate_frame: MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
            ..SET_POSITION_TARGET_GLOBAL_INT_DATA::DEFAULT
        };
        bench.send(LINK, COMPANION, &Message::SET_POSITION_TARGET_GLOBAL_INT(target));
        bench.run_s(120.0);
        assert!((bench.position() - place).norm() < 4.0, "{:?}", bench.position());
    }
}
