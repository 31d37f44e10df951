//! The latest of each message that matters to steering, with its age.
//!
//! `now` is time at the vehicle's pace, as [`super::VehicleClock`] gives it.

use std::time::Duration;

use helmlink_mission::geodesy::Geodetic;
use helmlink_wire::dialect::{ATTITUDE_DATA, GLOBAL_POSITION_INT_DATA, HEARTBEAT_DATA};
use helmlink_wire::{Identity, Message, enums};

use super::modes::Mode;

/// A value and when it arrived.
#[derive(Debug, Clone, Copy)]
pub struct Stamped<T> {
    /// What was said.
    pub value: T,
    /// When it arrived.
    pub received: Duration,
}

/// What the flight controller's HEARTBEAT says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heartbeat {
    /// MAV_TYPE.
    pub vehicle_type: u8,
    /// MAV_AUTOPILOT.
    pub autopilot: u8,
    /// The flight mode.
    pub mode: Mode,
    /// The motors may turn.
    pub armed: bool,
    /// MAV_STATE.
    pub system_status: u8,
}

/// Heading and turn rate.
#[derive(Debug, Clone, Copy)]
pub struct Attitude {
    /// Vehicle time, seconds since boot.
    pub boot_s: f64,
    /// Heading ψ, radians clockwise from true north, −π to π.
    pub heading_rad: f64,
    /// Yaw rate r, rad/s, positive to starboard.
    pub yaw_rate_radps: f64,
}

/// Position and velocity over ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// Vehicle time, seconds since boot.
    pub boot_s: f64,
    /// Where the boat is.
    pub place: Geodetic,
    /// Velocity over ground toward north, m/s.
    pub north_mps: f64,
    /// Velocity over ground toward east, m/s.
    pub east_mps: f64,
}

/// What one message changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Update {
    /// Nothing that steering needs.
    None,
    /// A new heading, of this vehicle time in seconds since boot.
    Attitude(f64),
    /// A new position, of this vehicle time in seconds since boot.
    Position(f64),
    /// The mode, the arming or another part of the heartbeat is new.
    Heartbeat,
    /// The flight controller has restarted: all that was known before is gone.
    Rebooted,
}

/// Everything known of one vehicle from what it sends.
#[derive(Debug, Clone, Default)]
pub struct Telemetry {
    /// The last HEARTBEAT.
    pub heartbeat: Option<Stamped<Heartbeat>>,
    /// The last ATTITUDE.
    pub attitude: Option<Stamped<Attitude>>,
    /// The last GLOBAL_POSITION_INT that holds a position.
    pub position: Option<Stamped<Position>>,
    /// The flags of the last EKF_STATUS_REPORT.
    pub ekf_flags: Option<Stamped<u16>>,
    /// The sequence number in the last MISSION_CURRENT.
    pub mission_current: Option<Stamped<u16>>,
    /// The newest time stamp, seconds since the flight controller's boot.
    pub boot_s: Option<f64>,
    /// Battery remaining, per cent, where the flight controller knows it.
    pub battery_percent: Option<f64>,
    /// Messages refused because a value in them was not a number.
    pub refused: u64,
    /// The last ATTITUDE was one of them.
    pub attitude_refused: bool,
}

/// A boot time that falls back by more than this means that the flight controller has restarted.
const REBOOT_S: f64 = 1.0;
/// Flags older than this vouch for nothing, seconds. They are asked for twice a second, and come once a second unasked.
const EKF_STALE_S: f64 = 5.0;
/// Estimator flags without which a boat must not be steered by its position: heading and horizontal position.
const EKF_NEEDED: u16 = enums::EKF_ATTITUDE | enums::EKF_POS_HORIZ_ABS;

impl Telemetry {
    /// Takes one message of the vehicle that arrived at `now`. A heading or a position that a newer one has overtaken on
    /// its way tells nothing any more, and is left out.
    pub fn on_message(&mut self, now: Duration, message: &Message) -> Update {
        match message {
            Message::HEARTBEAT(data) => {
                self.heartbeat = Some(Stamped { value: Heartbeat::from(data), received: now });
                Update::Heartbeat
            }
            Message::ATTITUDE(data) => self.on_attitude(now, data),
            Message::GLOBAL_POSITION_INT(data) => self.on_position(now, data),
            Message::EKF_STATUS_REPORT(data) => {
                self.ekf_flags = Some(Stamped { value: data.flags, received: now });
                Update::None
            }
            Message::MISSION_CURRENT(data) => {
                self.mission_current = Some(Stamped { value: data.seq, received: now });
                Update::None
            }
            Message::SYS_STATUS(data) => {
                // −1: the flight controller does not know.
                self.battery_percent =
                    (data.battery_remaining >= 0).then(|| f64::from(data.battery_remaining));
                Update::None
            }
            _ => Update::None,
        }
    }

    fn on_attitude(&mut self, now: Duration, data: &ATTITUDE_DATA) -> Update {
        let (heading_rad, yaw_rate_radps) = (f64::from(data.yaw), f64::from(data.yawspeed));
        self.attitude_refused = !heading_rad.is_finite() || !yaw_rate_radps.is_finite();
        if self.attitude_refused {
            self.refused += 1;
            return Update::None;
        }
        let boot_s = f64::from(data.time_boot_ms) / 1000.0;
        if self.has_rebooted(boot_s) {
            return Update::Rebooted;
        }
        if self.attitude.is_some_and(|known| boot_s < known.value.boot_s) {
            return Update::None;
        }
        self.attitude =
            Some(Stamped { value: Attitude { boot_s, heading_rad, yaw_rate_radps }, received: now });
        Update::Attitude(boot_s)
    }

    fn on_position(&mut self, now: Duration, data: &GLOBAL_POSITION_INT_DATA) -> Update {
        let boot_s = f64::from(data.time_boot_ms) / 1000.0;
        if self.has_rebooted(boot_s) {
            return Update::Rebooted;
        }
        // Before its first fix ArduPilot sends zero degrees for both.
        let place = Geodetic::from_e7(data.lat, data.lon);
        if !place.is_valid() {
            return Update::None;
        }
        if self.position.is_some_and(|known| boot_s < known.value.boot_s) {
            return Update::None;
        }
        let (north_mps, east_mps) = (f64::from(data.vx) / 100.0, f64::from(data.vy) / 100.0);
        self.position =
            Some(Stamped { value: Position { boot_s, place, north_mps, east_mps }, received: now });
        Update::Position(boot_s)
    }

    /// A time stamp far behind the newest one: everything known of the time before is forgotten.
    fn has_rebooted(&mut self, boot_s: f64) -> bool {
        let rebooted = self.boot_s.is_some_and(|newest_s| boot_s < newest_s - REBOOT_S);
        if rebooted {
            *self = Self { heartbeat: self.heartbeat, refused: self.refused, ..Self::default() };
        }
        self.boot_s = Some(self.boot_s.map_or(boot_s, |newest_s| newest_s.max(boot_s)));
        rebooted
    }

    /// Age of the last heartbeat in seconds; infinite before the first.
    pub fn heartbeat_age_s(&self, now: Duration) -> f64 {
        Self::age_s(now, self.heartbeat.map(|heartbeat| heartbeat.received))
    }

    /// Age of the last position in seconds; infinite before the first.
    pub fn position_age_s(&self, now: Duration) -> f64 {
        Self::age_s(now, self.position.map(|position| position.received))
    }

    /// Age of the last heading in seconds; infinite before the first.
    pub fn heading_age_s(&self, now: Duration) -> f64 {
        Self::age_s(now, self.attitude.map(|attitude| attitude.received))
    }

    fn age_s(now: Duration, received: Option<Duration>) -> f64 {
        received.map_or(f64::INFINITY, |then| now.saturating_sub(then).as_secs_f64())
    }

    /// The estimator vouches for heading and absolute position. ArduRover accepts arming some twenty seconds
    /// before it does (measured on 4.6), so the arming state is no substitute.
    pub fn estimator_is_ready(&self, now: Duration) -> bool {
        self.ekf_flags.is_some_and(|flags| {
            let age_s = now.saturating_sub(flags.received).as_secs_f64();
            flags.value & EKF_NEEDED == EKF_NEEDED && age_s <= EKF_STALE_S
        })
    }

    /// The mode of the last heartbeat.
    pub fn mode(&self) -> Option<Mode> {
        self.heartbeat.map(|heartbeat| heartbeat.value.mode)
    }

    /// The last heartbeat said armed.
    pub fn is_armed(&self) -> bool {
        self.heartbeat.is_some_and(|heartbeat| heartbeat.value.armed)
    }
}

impl From<&HEARTBEAT_DATA> for Heartbeat {
    fn from(data: &HEARTBEAT_DATA) -> Self {
        Self {
            vehicle_type: data.mavtype,
            autopilot: data.autopilot,
            mode: Mode(data.custom_mode),
            armed: data.base_mode & enums::MAV_MODE_FLAG_SAFETY_ARMED != 0,
            system_status: data.system_status,
        }
    }
}

/// What a heartbeat says about whether its sender can be steered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sender {
    /// A boat or rover run by ArduPilot.
    Boat,
    /// A flight controller of another kind of vehicle, or of another make: MAV_TYPE and MAV_AUTOPILOT.
    WrongVehicle(u8, u8),
    /// A ground station, a companion, a camera: not a flight controller.
    NotAVehicle,
}

/// Tells a boat's flight controller from everything else on the link.
pub fn classify(from: Identity, heartbeat: &HEARTBEAT_DATA) -> Sender {
    let is_autopilot = heartbeat.autopilot != enums::MAV_AUTOPILOT_INVALID
        && heartbeat.mavtype != enums::MAV_TYPE_GCS
        && from.component == enums::MAV_COMP_ID_AUTOPILOT1;
    let is_boat = matches!(heartbeat.mavtype, enums::MAV_TYPE_SURFACE_BOAT | enums::MAV_TYPE_GROUND_ROVER);
    match (is_autopilot, is_boat && heartbeat.autopilot == enums::MAV_AUTOPILOT_ARDUPILOTMEGA) {
        (false, _) => Sender::NotAVehicle,
        (true, true) => Sender::Boat,
        (true, false) => Sender::WrongVehicle(heartbeat.mavtype, heartbeat.autopilot),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use helmlink_wire::dialect::EKF_STATUS_REPORT_DATA;

    const NOW: Duration = Duration::from_secs(1);

    fn position(lat: i32, lon: i32, time_boot_ms: u32) -> Message {
        let data = GLOBAL_POSITION_INT_DATA {
            lat,
            lon,
            time_boot_ms,
            vx: 100,
            vy: -50,
            ..GLOBAL_POSITION_INT_DATA::DEFAULT
        };
        Message::GLOBAL_POSITION_INT(data)
    }

    fn attitude(yaw: f32, time_boot_ms: u32) -> Message {
        Message::ATTITUDE(ATTITUDE_DATA { yaw, time_boot_ms, ..ATTITUDE_DATA::DEFAULT })
    }

    #[test]
    fn a_position_of_zero_degrees_is_no_position() {
        let mut telemetry = Telemetry::default();
        assert_eq!(telemetry.on_message(NOW, &position(0, 0, 5)), Update::None);
        assert!(telemetry.position_age_s(NOW).is_infinite());
        assert_eq!(
            telemetry.on_message(NOW, &position(634_389_000, 103_990_000, 1500)),
            Update::Position(1.5)
        );
        let known = telemetry.position.unwrap().value;
        assert!((known.north_mps - 1.0).abs() < 1e-9 && (known.east_mps + 0.5).abs() < 1e-9);
    }

    #[test]
    fn a_heading_that_is_not_a_number_never_gets_in() {
        let mut telemetry = Telemetry::default();
        assert_eq!(telemetry.on_message(NOW, &attitude(f32::NAN, 5)), Update::None);
        assert!(telemetry.attitude.is_none());
        assert_eq!(telemetry.refused, 1);
    }

    #[test]
    fn what_was_overtaken_on_its_way_is_left_out() {
        let mut telemetry = Telemetry::default();
        telemetry.on_message(NOW, &attitude(1.0, 5000));
        telemetry.on_message(NOW, &position(634_389_000, 103_990_000, 5000));
        assert_eq!(telemetry.on_message(NOW, &attitude(0.5, 4800)), Update::None);
        assert_eq!(telemetry.on_message(NOW, &position(634_388_000, 103_990_000, 4800)), Update::None);
        let (heading, place) = (telemetry.attitude.unwrap().value, telemetry.position.unwrap().value);
        assert_eq!((heading.heading_rad, heading.boot_s), (1.0, 5.0));
        assert_eq!((place.place, place.boot_s), (Geodetic::from_e7(634_389_000, 103_990_000), 5.0));
    }

    #[test]
    fn a_reboot_forgets_the_old_position() {
        let mut telemetry = Telemetry::default();
        telemetry.on_message(NOW, &position(634_389_000, 103_990_000, 60_000));
        assert_eq!(telemetry.on_message(NOW, &attitude(1.0, 500)), Update::Rebooted);
        assert!(telemetry.position.is_none());
    }

    #[test]
    fn an_estimator_that_has_fallen_silent_vouches_for_nothing() {
        let mut telemetry = Telemetry::default();
        let flags = EKF_NEEDED;
        let report = EKF_STATUS_REPORT_DATA { flags, ..EKF_STATUS_REPORT_DATA::DEFAULT };
        telemetry.on_message(NOW, &Message::EKF_STATUS_REPORT(report));
        assert!(telemetry.estimator_is_ready(NOW + Duration::from_secs(5)));
        assert!(!telemetry.estimator_is_ready(NOW + Duration::from_secs(6)));
    }

    #[test]
    fn tells_a_boat_from_its_company() {
        let heartbeat = |mavtype, autopilot| HEARTBEAT_DATA { mavtype, autopilot, ..HEARTBEAT_DATA::DEFAULT };
        let autopilot = Identity { system: 1, component: 1 };
        assert_eq!(classify(autopilot, &heartbeat(11, 3)), Sender::Boat);
        assert_eq!(classify(autopilot, &heartbeat(10, 3)), Sender::Boat);
        assert_eq!(classify(autopilot, &heartbeat(2, 3)), Sender::WrongVehicle(2, 3));
        assert_eq!(classify(autopilot, &heartbeat(250, 12)), Sender::WrongVehicle(250, 12));
        assert_eq!(classify(Identity { system: 255, component: 190 }, &heartbeat(6, 8)), Sender::NotAVehicle);
        assert_eq!(classify(Identity { system: 1, component: 191 }, &heartbeat(18, 8)), Sender::NotAVehicle);
    }
}
