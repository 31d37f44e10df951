//! Messages about the state of the autopilot itself.

use helmlink_mission::geodesy::Geodetic;
use helmlink_wire::dialect::*;
use helmlink_wire::enums::*;

use super::super::Autopilot;
use super::super::battery::Charge;
use super::super::modes::Mode;

/// The unix time at which every simulation starts: 1 January 2026, 00:00 UTC.
pub(in crate::autopilot) const START_UNIX_US: u64 = 1_767_225_600_000_000;
/// 4.6.0, a development version: what the simulated firmware claims to be.
const VERSION: u32 = 0x0406_0000;
/// The first characters of a git hash, in ASCII as ArduPilot has it.
const GIT_HASH: [u8; 8] = *b"helmlink";

const CAPABILITIES: u64 = MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
    | MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
    | MAV_PROTOCOL_CAPABILITY_MISSION_INT
    | MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | MAV_PROTOCOL_CAPABILITY_FTP
    | MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET
    | MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
    | MAV_PROTOCOL_CAPABILITY_COMPASS_CALIBRATION
    | MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    | MAV_PROTOCOL_CAPABILITY_MISSION_RALLY;

/// Sensors and functions as ArduRover 4.6 lists them, measured.
const PRESENT: u32 = 0x1331_DC2F;
const ENABLED: u32 = 0x1221_802F;
const HEALTHY: u32 = 0x1331_812F;
const INERTIAL: u32 =
    MAV_SYS_STATUS_SENSOR_3D_GYRO | MAV_SYS_STATUS_SENSOR_3D_ACCEL | MAV_SYS_STATUS_SENSOR_3D_MAG;

/// EKF_STATUS_REPORT.flags with everything in order: 831, as measured.
const EKF_GOOD: u16 = EKF_ATTITUDE
    | EKF_VELOCITY_HORIZ
    | EKF_VELOCITY_VERT
    | EKF_POS_HORIZ_REL
    | EKF_POS_HORIZ_ABS
    | EKF_POS_VERT_ABS
    | EKF_PRED_POS_HORIZ_REL
    | EKF_PRED_POS_HORIZ_ABS;
/// The same without a position.
const EKF_NO_POSITION: u16 = EKF_ATTITUDE | EKF_VELOCITY_VERT | EKF_POS_VERT_ABS | EKF_CONST_POS_MODE;
/// Variances of an estimator that has given up; above 1 its readings are rejected.
const FAILED_VARIANCE: f32 = 1.6;

impl Autopilot {
    /// MAV_STATE: standby in HOLD, active in every other mode, critical while a failsafe persists.
    pub(in crate::autopilot) fn system_status(&self) -> u8 {
        match self.mode {
            _ if self.failsafe.is_active() => MAV_STATE_CRITICAL,
            Mode::Initialising => MAV_STATE_CALIBRATING,
            Mode::Hold => MAV_STATE_STANDBY,
            _ => MAV_STATE_ACTIVE,
        }
    }

    pub(super) fn heartbeat(&self) -> Message {
        let armed = if self.armed { MAV_MODE_FLAG_SAFETY_ARMED } else { 0 };
        Message::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: self.mode.number(),
            mavtype: MAV_TYPE_SURFACE_BOAT,
            autopilot: MAV_AUTOPILOT_ARDUPILOTMEGA,
            base_mode: self.mode.base_mode() | armed,
            system_status: self.system_status(),
            mavlink_version: 3,
        })
    }

    pub(super) fn sys_status(&self) -> Message {
        let mut health = HEALTHY;
        let fence = if self.is_fenced() { MAV_SYS_STATUS_GEOFENCE } else { 0 };
        let enabled = ENABLED | fence;
        if self.has_breached_fence() {
            health &= !MAV_SYS_STATUS_GEOFENCE;
        }
        if self.battery.state() != Charge::Good {
            health &= !MAV_SYS_STATUS_SENSOR_BATTERY;
        }
        if !self.is_initialised() {
            health &= !INERTIAL;
        }
        if !self.has_position() {
            health &= !(MAV_SYS_STATUS_SENSOR_GPS | MAV_SYS_STATUS_AHRS);
        }
        if !self.rc.has_input(self.now, &self.parameters) {
            health &= !MAV_SYS_STATUS_SENSOR_RC_RECEIVER;
        }
        if !self.armed && !self.arming_obstacles().is_empty() {
            health &= !MAV_SYS_STATUS_PREARM_CHECK;
        }
        Message::SYS_STATUS(SYS_STATUS_DATA {
            onboard_control_sensors_present: PRESENT,
            onboard_control_sensors_enabled: enabled,
            onboard_control_sensors_health: health,
            load: 50,
            voltage_battery: self.voltage_mv(),
            current_battery: self.current_ca(),
            battery_remaining: self.battery_percent(),
            ..SYS_STATUS_DATA::DEFAULT
        })
    }

    pub(super) fn power_status() -> Message {
        Message::POWER_STATUS(POWER_STATUS_DATA { Vcc: 5000, Vservo: 5000, flags: 0 })
    }

    pub(super) fn hwstatus() -> Message {
        Message::HWSTATUS(HWSTATUS_DATA { Vcc: 5000, I2Cerr: 0 })
    }

    pub(super) fn meminfo() -> Message {
        Message::MEMINFO(MEMINFO_DATA { brkval: 0, freemem: u16::MAX, freemem32: 131_072 })
    }

    pub(in crate::autopilot) fn system_time(&self) -> Message {
        let since_start_us = u64::try_from(self.now.as_micros()).unwrap_or(u64::MAX);
        let time_unix_usec = START_UNIX_US.saturating_add(since_start_us);
        Message::SYSTEM_TIME(SYSTEM_TIME_DATA { time_unix_usec, time_boot_ms: self.boot_ms() })
    }

    pub(super) fn battery_status(&self) -> Message {
        let mut voltages = [u16::MAX; 10];
        voltages[0] = self.voltage_mv();
        Message::BATTERY_STATUS(BATTERY_STATUS_DATA {
            current_consumed: self.battery.consumed_mah() as i32,
            energy_consumed: -1,
            temperature: i16::MAX,
            voltages,
            current_battery: self.current_ca(),
            battery_remaining: self.battery_percent(),
            charge_state: match self.battery.state() {
                Charge::Good => MAV_BATTERY_CHARGE_STATE_OK,
                Charge::Low => MAV_BATTERY_CHARGE_STATE_LOW,
                Charge::Critical => MAV_BATTERY_CHARGE_STATE_CRITICAL,
            },
            ..BATTERY_STATUS_DATA::DEFAULT
        })
    }

    /// Current, hundredths of an ampere.
    fn current_ca(&self) -> i16 {
        (self.battery.current_a() * 100.0) as i16
    }

    fn voltage_mv(&self) -> u16 {
        (1000.0 * self.battery_voltage_v()).round() as u16
    }

    fn battery_percent(&self) -> i8 {
        (100.0 * self.battery_left()) as i8
    }

    pub(super) fn autopilot_version() -> Message {
        let mut uid2 = [0; 18];
        uid2[..13].copy_from_slice(b"helmlink-sitl");
        Message::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
            capabilities: CAPABILITIES,
            flight_sw_version: VERSION,
            flight_custom_version: GIT_HASH,
            uid2,
            ..AUTOPILOT_VERSION_DATA::DEFAULT
        })
    }

    pub(super) fn ekf_status(&self) -> Message {
        let flags = match (self.is_initialised(), self.has_position()) {
            (false, _) => EKF_UNINITIALIZED,
            (true, _) if self.has_failed_estimator() => EKF_ATTITUDE,
            (true, false) => EKF_NO_POSITION,
            (true, true) => EKF_GOOD,
        };
        let variance = |usual: f32| if self.has_failed_estimator() { FAILED_VARIANCE } else { usual };
        Message::EKF_STATUS_REPORT(EKF_STATUS_REPORT_DATA {
            velocity_variance: variance(0.02),
            pos_horiz_variance: variance(0.02),
            pos_vert_variance: 0.01,
            compass_variance: variance(0.02),
            flags,
            ..EKF_STATUS_REPORT_DATA::DEFAULT
        })
    }

    pub(super) fn home_position(&self) -> Option<Message> {
        let home = self.home?;
        let (latitude, longitude) = home.to_e7();
        let local = self.frame.to_local(home);
        Some(Message::HOME_POSITION(HOME_POSITION_DATA {
            latitude,
            longitude,
            x: local.north_m as f32,
            y: local.east_m as f32,
            q: [1.0, 0.0, 0.0, 0.0],
            time_usec: self.boot_us(),
            ..HOME_POSITION_DATA::DEFAULT
        }))
    }

    /// Tells everyone where home is, if there is one.
    pub(in crate::autopilot) fn send_home(&mut self) {
        if let Some(message) = self.home_position() {
            self.links.broadcast(&message);
        }
    }

    pub(super) fn global_origin(&self) -> Option<Message> {
        self.home?;
        let origin: Geodetic = self.frame.origin();
        let (latitude, longitude) = origin.to_e7();
        Some(Message::GPS_GLOBAL_ORIGIN(GPS_GLOBAL_ORIGIN_DATA {
            latitude,
            longitude,
            time_usec: self.boot_us(),
            ..GPS_GLOBAL_ORIGIN_DATA::DEFAULT
        }))
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::autopilot::testing::Bench;

    fn health(bench: &Bench) -> u32 {
        let Message::SYS_STATUS(status) = bench.autopilot.sys_status() else { panic!() };
        status.onboard_control_sensors_health
    }

    fn ekf_flags(bench: &Bench) -> u16 {
        let Message::EKF_STATUS_REPORT(report) = bench.autopilot.ekf_status() else { panic!() };
        report.flags
    }

    #[test]
    fn everything_is_healthy_when_ready_and_little_before() {
        let mut bench = Bench::new(Default::default());
        bench.run_loops(5);
        assert_eq!(health(&bench) & (INERTIAL | MAV_SYS_STATUS_SENSOR_GPS | MAV_SYS_STATUS_PREARM_CHECK), 0);
        assert_eq!(ekf_flags(&bench), EKF_UNINITIALIZED);
        let Message::HEARTBEAT(early) = bench.autopilot.heartbeat() else { panic!() };
        assert_eq!((early.custom_mode, early.base_mode, early.system_status), (16, 65, 2));
        bench.run_until(Duration::from_millis(2100));
        assert_eq!(health(&bench), HEALTHY);
        assert_eq!(health(&bench) & 0x1001_0027, 0x1001_0027, "what MAVSDK asks for");
        assert_eq!(ekf_flags(&bench), 831);
        let Message::HEARTBEAT(ready) = bench.autopilot.heartbeat() else { panic!() };
        assert_eq!((ready.custom_mode, ready.base_mode, ready.system_status), (0, 65, 4));
        assert_eq!((ready.mavtype, ready.autopilot), (11, 3));
    }

    #[test]
    fn capabilities_are_ardurovers() {
        assert_eq!(CAPABILITIES, 61935);
        assert_eq!(EKF_GOOD, 831);
    }

    #[test]
    fn a_lost_gps_shows() {
        let mut bench = Bench::ready();
        bench.inject(crate::faults::Fault::GpsLoss).unwrap();
        bench.run_loops(2);
        assert_eq!(health(&bench) & MAV_SYS_STATUS_SENSOR_GPS, 0);
        assert_eq!(ekf_flags(&bench) & EKF_POS_HORIZ_ABS, 0);
    }
}
