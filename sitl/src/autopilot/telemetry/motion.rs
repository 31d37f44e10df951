//! Messages about where the boat is, how it moves and where it is going.

use helmlink_mission::angle::wrap_positive;
use helmlink_mission::geodesy::NorthEast;
use helmlink_wire::dialect::*;
use helmlink_wire::enums::*;

use super::super::Autopilot;
use super::super::parameters::COMPASS_DEC;
use crate::physics::GRAVITY_MPS2;

/// Horizontal magnetic field along the bow of a boat heading north, and downward, milligauss.
const FIELD_MGAUSS: (f64, f64) = (150.0, 480.0);
/// Air pressure at sea level, hPa.
const PRESSURE_HPA: f32 = 1013.25;
/// Temperature of everything, hundredths of a degree Celsius.
const TEMPERATURE_CDEG: i16 = 2000;
/// Satellites seen while the GPS works.
const SATELLITES: u8 = 12;
/// Position type mask: only the place of a target counts.
const ONLY_PLACE: u16 = 0xFF8;

/// A rotation rate or an acceleration in the thousandths that IMU messages carry.
fn thousandths(value: f64) -> i16 {
    (value * 1000.0) as i16
}

/// One set of IMU readings: milli-g, mrad/s, milligauss.
struct Imu {
    acceleration: [i16; 3],
    rotation: [i16; 3],
    field: [i16; 3],
}

impl Autopilot {
    pub(super) fn attitude(&self) -> Message {
        Message::ATTITUDE(ATTITUDE_DATA {
            time_boot_ms: self.boot_ms(),
            roll: self.estimate.roll_rad as f32,
            pitch: self.estimate.pitch_rad as f32,
            yaw: self.estimate.psi_rad as f32,
            rollspeed: 0.0,
            pitchspeed: 0.0,
            yawspeed: self.estimate.r_radps as f32,
        })
    }

    pub(super) fn attitude_quaternion(&self) -> Message {
        let (sr, cr) = (0.5 * self.estimate.roll_rad).sin_cos();
        let (sp, cp) = (0.5 * self.estimate.pitch_rad).sin_cos();
        let (sy, cy) = (0.5 * self.estimate.psi_rad).sin_cos();
        Message::ATTITUDE_QUATERNION(ATTITUDE_QUATERNION_DATA {
            time_boot_ms: self.boot_ms(),
            q1: (cr * cp * cy + sr * sp * sy) as f32,
            q2: (sr * cp * cy - cr * sp * sy) as f32,
            q3: (cr * sp * cy + sr * cp * sy) as f32,
            q4: (cr * cp * sy - sr * sp * cy) as f32,
            yawspeed: self.estimate.r_radps as f32,
            ..ATTITUDE_QUATERNION_DATA::DEFAULT
        })
    }

    /// Latitude and longitude are 0 until there is a position, as on ArduRover; when it is lost again, dead
    /// reckoning goes on.
    pub(super) fn global_position(&self) -> Message {
        let (lat, lon) = if self.home.is_some() { self.position().to_e7() } else { (0, 0) };
        let centi = |mps: f64| (mps * 100.0).round() as i16;
        Message::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
            time_boot_ms: self.boot_ms(),
            lat,
            lon,
            alt: 0,
            relative_alt: 0,
            vx: centi(self.estimate.north_mps),
            vy: centi(self.estimate.east_mps),
            vz: 0,
            hdg: self.heading_cdeg(),
        })
    }

    /// Heading, hundredths of a degree, 0 to 35999.
    fn heading_cdeg(&self) -> u16 {
        ((wrap_positive(self.estimate.psi_rad).to_degrees() * 100.0).round() as u16) % 36_000
    }

    pub(super) fn local_position(&self) -> Option<Message> {
        self.has_position().then(|| {
            Message::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA {
                time_boot_ms: self.boot_ms(),
                x: self.estimate.north_m as f32,
                y: self.estimate.east_m as f32,
                z: 0.0,
                vx: self.estimate.north_mps as f32,
                vy: self.estimate.east_mps as f32,
                vz: 0.0,
            })
        })
    }

    pub(super) fn gps_raw(&self) -> Message {
        if !self.estimate.has_gps || !self.is_initialised() {
            let nothing = GPS_RAW_INT_DATA {
                time_usec: self.boot_us(),
                eph: u16::MAX,
                epv: u16::MAX,
                fix_type: GPS_FIX_TYPE_NO_FIX,
                ..GPS_RAW_INT_DATA::DEFAULT
            };
            return Message::GPS_RAW_INT(nothing);
        }
        let gps = self.estimate.gps;
        let (lat, lon) = self.frame.to_geodetic(NorthEast::new(gps.north_m, gps.east_m)).to_e7();
        let velocity = NorthEast::new(gps.north_mps, gps.east_mps);
        let course_cdeg = wrap_positive(velocity.bearing_rad()).to_degrees() * 100.0;
        Message::GPS_RAW_INT(GPS_RAW_INT_DATA {
            time_usec: self.boot_us(),
            lat,
            lon,
            alt: 0,
            eph: 80,
            epv: 120,
            vel: (velocity.norm() * 100.0) as u16,
            cog: course_cdeg as u16,
            fix_type: GPS_FIX_TYPE_RTK_FIXED,
            satellites_visible: SATELLITES,
            h_acc: 100,
            v_acc: 200,
            vel_acc: 40,
            ..GPS_RAW_INT_DATA::DEFAULT
        })
    }

    pub(super) fn vfr_hud(&self) -> Message {
        Message::VFR_HUD(VFR_HUD_DATA {
            groundspeed: self.motion().speed_mps() as f32,
            heading: (self.heading_cdeg() / 100) as i16,
            throttle: (self.outputs.throttle().abs() * 100.0).round() as u16,
            ..VFR_HUD_DATA::DEFAULT
        })
    }

    /// Only in modes in which the autopilot navigates.
    pub(super) fn nav_controller_output(&self) -> Option<Message> {
        if !self.mode.is_autopilot() {
            return None;
        }
        let degrees = |rad: f64| rad.to_degrees().round() as i16;
        let output = match self.report {
            None => NAV_CONTROLLER_OUTPUT_DATA::DEFAULT,
            Some(report) => NAV_CONTROLLER_OUTPUT_DATA {
                aspd_error: report.speed_error_mps as f32,
                xtrack_error: report.cross_track_m as f32,
                nav_bearing: degrees(report.course_rad),
                target_bearing: degrees(report.target_bearing_rad),
                wp_dist: report.distance_m as u16,
                ..NAV_CONTROLLER_OUTPUT_DATA::DEFAULT
            },
        };
        Some(Message::NAV_CONTROLLER_OUTPUT(output))
    }

    /// Where the boat is going, in modes in which the autopilot navigates.
    pub(super) fn position_target(&self) -> Option<Message> {
        let target = self.report.filter(|_| self.mode.is_autopilot())?.target;
        let (lat_int, lon_int) = self.frame.to_geodetic(target).to_e7();
        Some(Message::POSITION_TARGET_GLOBAL_INT(POSITION_TARGET_GLOBAL_INT_DATA {
            time_boot_ms: self.boot_ms(),
            lat_int,
            lon_int,
            type_mask: ONLY_PLACE,
            coordinate_frame: MAV_FRAME_GLOBAL,
            ..POSITION_TARGET_GLOBAL_INT_DATA::DEFAULT
        }))
    }

    fn imu(&self) -> Imu {
        // The compass needle points to magnetic north, COMPASS_DEC to the east of the true one.
        let (sin, cos) = (self.estimate.psi_rad - self.parameters.get(COMPASS_DEC)).sin_cos();
        let turning_g = self.motion().forward_mps() * self.estimate.r_radps / GRAVITY_MPS2;
        let (north, down) = FIELD_MGAUSS;
        Imu {
            acceleration: [
                thousandths(self.estimate.pitch_rad.sin()),
                thousandths(turning_g - self.estimate.roll_rad.sin()),
                thousandths(-1.0),
            ],
            rotation: [0, 0, thousandths(self.estimate.r_radps)],
            field: [(north * cos) as i16, (-north * sin) as i16, down as i16],
        }
    }

    pub(super) fn raw_imu(&self) -> Message {
        let Imu { acceleration: [xacc, yacc, zacc], rotation: [xgyro, ygyro, zgyro], field } = self.imu();
        let [xmag, ymag, zmag] = field;
        let time_usec = self.boot_us();
        let temperature = TEMPERATURE_CDEG;
        Message::RAW_IMU(RAW_IMU_DATA {
            time_usec,
            xacc,
            yacc,
            zacc,
            xgyro,
            ygyro,
            zgyro,
            xmag,
            ymag,
            zmag,
            id: 0,
            temperature,
        })
    }

    pub(super) fn scaled_imu(&self) -> Message {
        let Imu { acceleration: [xacc, yacc, zacc], rotation: [xgyro, ygyro, zgyro], field } = self.imu();
        let [xmag, ymag, zmag] = field;
        let time_boot_ms = self.boot_ms();
        let temperature = TEMPERATURE_CDEG;
        Message::SCALED_IMU(SCALED_IMU_DATA {
            time_boot_ms,
            xacc,
            yacc,
            zacc,
            xgyro,
            ygyro,
            zgyro,
            xmag,
            ymag,
            zmag,
            temperature,
        })
    }

    pub(super) fn scaled_imu2(&self) -> Message {
        let Imu { acceleration: [xacc, yacc, zacc], rotation: [xgyro, ygyro, zgyro], field } = self.imu();
        let [xmag, ymag, zmag] = field;
        let time_boot_ms = self.boot_ms();
        let temperature = TEMPERATURE_CDEG;
        Message::SCALED_IMU2(SCALED_IMU2_DATA {
            time_boot_ms,
            xacc,
            yacc,
            zacc,
            xgyro,
            ygyro,
            zgyro,
            xmag,
            ymag,
            zmag,
            temperature,
        })
    }

    pub(super) fn scaled_pressure(&self) -> Message {
        Message::SCALED_PRESSURE(SCALED_PRESSURE_DATA {
            time_boot_ms: self.boot_ms(),
            press_abs: PRESSURE_HPA,
            temperature: TEMPERATURE_CDEG,
            ..SCALED_PRESSURE_DATA::DEFAULT
        })
    }

    pub(super) fn vibration(&self) -> Message {
        Message::VIBRATION(VIBRATION_DATA { time_usec: self.boot_us(), ..VIBRATION_DATA::DEFAULT })
    }

    pub(super) fn ahrs2(&self) -> Message {
        let (lat, lng) = if self.has_position() { self.position().to_e7() } else { (0, 0) };
        Message::AHRS2(AHRS2_DATA {
            roll: self.estimate.roll_rad as f32,
            pitch: self.estimate.pitch_rad as f32,
            yaw: self.estimate.psi_rad as f32,
            altitude: 0.0,
            lat,
            lng,
        })
    }

    /// What really happens, as ArduPilot's simulator tells it; not meant for controllers.
    pub(super) fn simstate(&self) -> Message {
        let place = NorthEast::new(self.truth.north_m, self.truth.east_m);
        let (lat, lng) = self.frame.to_geodetic(place).to_e7();
        Message::SIMSTATE(SIMSTATE_DATA {
            yaw: self.truth.psi_rad as f32,
            zacc: -GRAVITY_MPS2 as f32,
            zgyro: self.truth.r_radps as f32,
            lat,
            lng,
            ..SIMSTATE_DATA::DEFAULT
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autopilot::testing::{Bench, LINK};

    #[test]
    fn attitude_and_position_go_out_together_with_one_time() {
        let mut bench = Bench::ready();
        let sent = bench.run_s(5.0).remove(&LINK).unwrap();
        let mut attitude_ms = None;
        let mut pairs = 0;
        for message in &sent {
            match message {
                Message::ATTITUDE(data) => attitude_ms = Some(data.time_boot_ms),
                Message::GLOBAL_POSITION_INT(data) => {
                    assert_eq!(attitude_ms, Some(data.time_boot_ms));
                    pairs += 1;
                }
                _ => {}
            }
        }
        assert_eq!(pairs, 5);
    }

    #[test]
    fn there_is_no_position_before_there_is_one() {
        let mut bench = Bench::new(Default::default());
        bench.run_loops(3);
        let Message::GLOBAL_POSITION_INT(data) = bench.autopilot.global_position() else { panic!() };
        assert_eq!((data.lat, data.lon), (0, 0));
        assert!(bench.autopilot.local_position().is_none());
        assert!(bench.autopilot.home_position().is_none());
    }

    #[test]
    fn the_quaternion_is_the_attitude() {
        let mut bench = Bench::ready();
        bench.autopilot.estimate.psi_rad = 1.1;
        bench.autopilot.estimate.roll_rad = 0.2;
        let Message::ATTITUDE_QUATERNION(q) = bench.autopilot.attitude_quaternion() else { panic!() };
        let norm = q.q1 * q.q1 + q.q2 * q.q2 + q.q3 * q.q3 + q.q4 * q.q4;
        assert!((norm - 1.0).abs() < 1e-6);
        let yaw = (2.0 * (q.q1 * q.q4 + q.q2 * q.q3)).atan2(1.0 - 2.0 * (q.q3 * q.q3 + q.q4 * q.q4));
        assert!((yaw - 1.1).abs() < 1e-5);
    }
}
