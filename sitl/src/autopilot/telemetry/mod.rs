//! Every message the autopilot can send about itself, made from its state.

mod inputs;
mod motion;
pub(super) mod status;

use std::time::Duration;

use helmlink_wire::dialect::*;

use super::Autopilot;

impl Autopilot {
    /// The message with this id as it is now; `None` if there is nothing to say.
    pub(super) fn telemetry(&self, message_id: u32) -> Option<Message> {
        Some(match message_id {
            HEARTBEAT_DATA::ID => self.heartbeat(),
            SYS_STATUS_DATA::ID => self.sys_status(),
            POWER_STATUS_DATA::ID => Self::power_status(),
            MEMINFO_DATA::ID => Self::meminfo(),
            HWSTATUS_DATA::ID => Self::hwstatus(),
            SYSTEM_TIME_DATA::ID => self.system_time(),
            BATTERY_STATUS_DATA::ID => self.battery_status(),
            AUTOPILOT_VERSION_DATA::ID => Self::autopilot_version(),
            EKF_STATUS_REPORT_DATA::ID => self.ekf_status(),
            EXTENDED_SYS_STATE_DATA::ID => Message::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA::DEFAULT),
            FENCE_STATUS_DATA::ID => self.fence_status()?,
            MISSION_CURRENT_DATA::ID => self.mission_current(self.auto.current()),
            HOME_POSITION_DATA::ID => self.home_position()?,
            GPS_GLOBAL_ORIGIN_DATA::ID => self.global_origin()?,
            ATTITUDE_DATA::ID => self.attitude(),
            ATTITUDE_QUATERNION_DATA::ID => self.attitude_quaternion(),
            GLOBAL_POSITION_INT_DATA::ID => self.global_position(),
            LOCAL_POSITION_NED_DATA::ID => self.local_position()?,
            GPS_RAW_INT_DATA::ID => self.gps_raw(),
            VFR_HUD_DATA::ID => self.vfr_hud(),
            NAV_CONTROLLER_OUTPUT_DATA::ID => self.nav_controller_output()?,
            POSITION_TARGET_GLOBAL_INT_DATA::ID => self.position_target()?,
            RAW_IMU_DATA::ID => self.raw_imu(),
            SCALED_IMU_DATA::ID => self.scaled_imu(),
            SCALED_IMU2_DATA::ID => self.scaled_imu2(),
            SCALED_PRESSURE_DATA::ID => self.scaled_pressure(),
            VIBRATION_DATA::ID => self.vibration(),
            AHRS_DATA::ID => Message::AHRS(AHRS_DATA::DEFAULT),
            AHRS2_DATA::ID => self.ahrs2(),
            SIMSTATE_DATA::ID => self.simstate(),
            RC_CHANNELS_DATA::ID => self.rc_channels(),
            RC_CHANNELS_RAW_DATA::ID => self.rc_channels_raw(),
            RC_CHANNELS_SCALED_DATA::ID => self.rc_channels_scaled(),
            SERVO_OUTPUT_RAW_DATA::ID => self.servo_output(),
            _ => return None,
        })
    }

    /// Sends on every link what is due between the loop at `before` and now.
    pub(super) fn send_due(&mut self, before: Duration) {
        let (before, now) = (before.saturating_sub(self.booted), self.since_boot());
        for link in self.links.ids() {
            let Some(streams) = self.links.streams(link) else { continue };
            for message_id in streams.due(before, now, &self.parameters) {
                if let Some(message) = self.telemetry(message_id) {
                    self.links.send(link, &message);
                }
            }
        }
    }

    /// Milliseconds since the autopilot started, as most messages state the time.
    fn boot_ms(&self) -> u32 {
        u32::try_from(self.since_boot().as_millis()).unwrap_or(u32::MAX)
    }

    fn boot_us(&self) -> u64 {
        u64::try_from(self.since_boot().as_micros()).unwrap_or(u64::MAX)
    }

    /// Nanoseconds since the autopilot started, never zero.
    pub(super) fn boot_nanoseconds(&self) -> i64 {
        i64::try_from(self.since_boot().as_nanos()).unwrap_or(i64::MAX).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autopilot::streams::MESSAGES;
    use crate::autopilot::testing::Bench;

    #[test]
    fn every_message_of_the_table_can_be_made_or_has_a_reason() {
        let bench = Bench::ready();
        for &(id, _) in MESSAGES {
            let made = bench.autopilot.telemetry(id);
            let only_in_autopilot_modes =
                matches!(id, NAV_CONTROLLER_OUTPUT_DATA::ID | POSITION_TARGET_GLOBAL_INT_DATA::ID);
            let only_with_a_fence = id == FENCE_STATUS_DATA::ID;
            assert_eq!(made.is_none(), only_in_autopilot_modes || only_with_a_fence, "message {id}");
            if let Some(message) = made {
                assert_eq!(message.message_id(), id);
            }
        }
    }
}
