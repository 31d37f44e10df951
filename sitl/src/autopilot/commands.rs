//! COMMAND_LONG and COMMAND_INT: every command is acknowledged once, to its sender, on the link it came on
//! (<https://mavlink.io/en/services/command.html>).

use std::time::Duration;

use helmlink_mission::geodesy::Geodetic;
use helmlink_wire::dialect::*;
use helmlink_wire::enums::*;
use helmlink_wire::{Identity, LinkId};

use super::Autopilot;
use super::arming::FORCE;
use super::guided::{is_global_frame, is_usable};
use super::modes::Mode;
use super::navigation;
use super::streams;
use crate::clock::ClockOrder;

/// A command in either form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Command {
    number: u16,
    /// Parameters 1 to 4.
    params: [f32; 4],
    /// Parameters 5 and 6 as a position, whatever they are.
    position: Geodetic,
    /// Whether the frame holds latitudes and longitudes. COMMAND_LONG has no frame; they are meant there.
    global: bool,
}

impl Command {
    /// Reads COMMAND_LONG, where positions are degrees.
    pub(super) fn from_long(data: &COMMAND_LONG_DATA) -> Self {
        Self {
            number: data.command,
            params: [data.param1, data.param2, data.param3, data.param4],
            position: Geodetic::new(f64::from(data.param5), f64::from(data.param6)),
            global: true,
        }
    }

    /// Reads COMMAND_INT, where positions are 1e-7 degrees.
    pub(super) fn from_int(data: &COMMAND_INT_DATA) -> Self {
        Self {
            number: data.command,
            params: [data.param1, data.param2, data.param3, data.param4],
            position: Geodetic::from_e7(data.x, data.y),
            global: is_global_frame(data.frame),
        }
    }

    /// A parameter as a whole number; `None` if it is none, as NaN is not.
    fn whole(&self, index: usize) -> Option<i64> {
        let value = self.params.get(index).copied().unwrap_or_default();
        (value.is_finite() && value.fract() == 0.0).then_some(value as i64)
    }

    fn position(&self) -> Option<Geodetic> {
        (self.global && is_usable(self.position)).then_some(self.position)
    }
}

/// Whether something was done.
fn done(worked: bool) -> u8 {
    if worked { MAV_RESULT_ACCEPTED } else { MAV_RESULT_FAILED }
}

impl Autopilot {
    /// Carries out a command and acknowledges it.
    pub(super) fn take_command(&mut self, link: LinkId, from: Identity, command: &Command) {
        let result = self.execute(link, command);
        let ack = COMMAND_ACK_DATA {
            command: command.number,
            result,
            target_system: from.system,
            target_component: from.component,
            ..COMMAND_ACK_DATA::DEFAULT
        };
        self.links.send(link, &Message::COMMAND_ACK(ack));
        self.answer_requests(link);
        // The boat restarts only after the acknowledgement is on its way.
        if command.number == MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN && result == MAV_RESULT_ACCEPTED {
            self.reboot();
        }
    }

    fn execute(&mut self, link: LinkId, command: &Command) -> u8 {
        match command.number {
            MAV_CMD_COMPONENT_ARM_DISARM => self.command_arm(command),
            MAV_CMD_RUN_PREARM_CHECKS => self.command_check(),
            MAV_CMD_DO_SET_MODE => self.command_mode(command),
            MAV_CMD_NAV_RETURN_TO_LAUNCH => done(self.enter_mode_number(Mode::Rtl.number()).is_ok()),
            MAV_CMD_MISSION_START => done(self.enter_mode_number(Mode::Auto.number()).is_ok()),
            MAV_CMD_DO_SET_MISSION_CURRENT => self.command_current(command),
            MAV_CMD_DO_REPOSITION => self.command_reposition(command),
            MAV_CMD_DO_CHANGE_SPEED => self.command_speed(command),
            MAV_CMD_NAV_SET_YAW_SPEED => self.command_yaw_speed(command),
            MAV_CMD_DO_SET_HOME => self.command_home(command),
            MAV_CMD_DO_SET_SERVO => self.command_servo(command),
            MAV_CMD_SET_MESSAGE_INTERVAL => self.command_interval(link, command),
            MAV_CMD_GET_MESSAGE_INTERVAL => self.command_get_interval(link, command),
            MAV_CMD_REQUEST_MESSAGE => self.command_request(command),
            MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES => self.request(AUTOPILOT_VERSION_DATA::ID),
            MAV_CMD_GET_HOME_POSITION => self.request(HOME_POSITION_DATA::ID),
            MAV_CMD_DO_FENCE_ENABLE => self.enable_fence(command.whole(0)),
            MAV_CMD_USER_1 => self.command_clock(link, command),
            MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN => {
                // 1 restarts, 3 restarts into the boot loader; a shutdown is not simulated.
                done(!self.armed && matches!(command.whole(0), Some(1 | 3)))
            }
            MAV_CMD_PREFLIGHT_CALIBRATION | MAV_CMD_PREFLIGHT_STORAGE => done(!self.armed),
            _ => MAV_RESULT_UNSUPPORTED,
        }
    }

    /// The simulator's own command: parameter 1 is 0 to let time pass, 1 to stop it, 2 to run so many loops of
    /// 20 ms (parameter 2), 3 to go in lockstep in beats of so many ms (parameter 2), 4 to end that.
    fn command_clock(&mut self, link: LinkId, command: &Command) -> u8 {
        let count = command.whole(1).and_then(|count| u32::try_from(count).ok()).unwrap_or(0);
        let order = match command.whole(0) {
            Some(0) => ClockOrder::Resume,
            Some(1) => ClockOrder::Pause,
            Some(2) => ClockOrder::Step(count.max(1)),
            Some(3) => ClockOrder::Join(Duration::from_millis(count.into())),
            Some(4) => ClockOrder::Leave,
            _ => return MAV_RESULT_DENIED,
        };
        self.clock.obey(link, order, self.now);
        MAV_RESULT_ACCEPTED
    }

    fn command_arm(&mut self, command: &Command) -> u8 {
        let forced = FORCE.contains(&command.params[1]);
        match command.whole(0) {
            Some(1) => done(self.arm(forced)),
            Some(0) => {
                self.disarm();
                MAV_RESULT_ACCEPTED
            }
            _ => MAV_RESULT_UNSUPPORTED,
        }
    }

    /// Says what stands in the way of arming.
    fn command_check(&mut self) -> u8 {
        if self.armed {
            return MAV_RESULT_TEMPORARILY_REJECTED;
        }
        for obstacle in self.arming_obstacles() {
            self.links.text(MAV_SEVERITY_CRITICAL, &format!("PreArm: {obstacle}"));
        }
        MAV_RESULT_ACCEPTED
    }

    fn command_mode(&mut self, command: &Command) -> u8 {
        let custom = i64::from(MAV_MODE_FLAG_CUSTOM_MODE_ENABLED);
        if command.whole(0).is_none_or(|base_mode| base_mode & custom == 0) {
            return MAV_RESULT_DENIED;
        }
        let number = command.whole(1).and_then(|number| u32::try_from(number).ok());
        done(number.is_some_and(|number| self.enter_mode_number(number).is_ok()))
    }

    fn command_current(&mut self, command: &Command) -> u8 {
        let seq = command.whole(0).and_then(|seq| u16::try_from(seq).ok());
        match seq {
            Some(seq) if self.set_current_item(seq) => MAV_RESULT_ACCEPTED,
            _ => MAV_RESULT_DENIED,
        }
    }

    fn command_reposition(&mut self, command: &Command) -> u8 {
        let flags = command.whole(1).unwrap_or(0);
        let may_change = flags & i64::from(MAV_DO_REPOSITION_FLAGS_CHANGE_MODE) != 0;
        let Some(place) = command.position() else { return MAV_RESULT_DENIED };
        if self.mode != Mode::Guided {
            if !may_change {
                return MAV_RESULT_DENIED;
            }
            if self.enter_mode_number(Mode::Guided.number()).is_err() {
                return MAV_RESULT_FAILED;
            }
        }
        if command.params[0] > 0.0 {
            self.set_speed(f64::from(command.params[0]));
        }
        self.go_to(self.frame.to_local(place));
        MAV_RESULT_ACCEPTED
    }

    /// The kind of speed (parameter 1) does not matter to a boat.
    fn command_speed(&mut self, command: &Command) -> u8 {
        let speed_mps = f64::from(command.params[1]);
        // Written so that NaN is refused too.
        if !(0.0..1e3).contains(&speed_mps) {
            return MAV_RESULT_FAILED;
        }
        done(self.set_speed(speed_mps))
    }

    /// The speed of the mode; false if it has none to set.
    fn set_speed(&mut self, speed_mps: f64) -> bool {
        match self.mode {
            Mode::Auto => self.auto.set_speed(speed_mps),
            Mode::Guided => self.guided.set_speed(speed_mps),
            _ => return false,
        }
        true
    }

    /// A turn by parameter 1 degrees, at the share of the default speed in parameter 2.
    fn command_yaw_speed(&mut self, command: &Command) -> u8 {
        let [angle_deg, share, ..] = command.params;
        if self.mode != Mode::Guided || !angle_deg.is_finite() || !share.is_finite() {
            return MAV_RESULT_FAILED;
        }
        let heading_rad = self.motion().heading_rad + f64::from(angle_deg).to_radians();
        let full_mps = navigation::default_speed_mps(&self.parameters);
        self.set_heading(heading_rad, f64::from(share).clamp(-1.0, 1.0) * full_mps);
        MAV_RESULT_ACCEPTED
    }

    fn command_home(&mut self, command: &Command) -> u8 {
        let here = command.whole(0) == Some(1);
        let place = if here && self.has_position() {
            self.position()
        } else if here {
            return MAV_RESULT_FAILED;
        } else if let Some(place) = command.position() {
            place
        } else {
            return MAV_RESULT_FAILED;
        };
        self.home_locked = true;
        self.set_home(place);
        MAV_RESULT_ACCEPTED
    }

    fn command_servo(&mut self, command: &Command) -> u8 {
        let output = command.whole(0).and_then(|output| usize::try_from(output).ok());
        let pulse_us = command.whole(1).and_then(|pulse| u16::try_from(pulse).ok());
        let (Some(output), Some(pulse_us)) = (output, pulse_us) else { return MAV_RESULT_FAILED };
        let worked = self.outputs.set(output, pulse_us, &self.parameters);
        if !worked {
            let text = format!("ServoRelayEvent: Channel {output} is already in use");
            self.links.text(MAV_SEVERITY_WARNING, &text);
        }
        done(worked)
    }

    fn command_interval(&mut self, link: LinkId, command: &Command) -> u8 {
        let message_id = command.whole(0).and_then(|id| u32::try_from(id).ok());
        let Some(message_id) = message_id.filter(|id| streams::is_known(*id)) else {
            return MAV_RESULT_DENIED;
        };
        let interval_us = f64::from(command.params[1]);
        let interval = if interval_us < 0.0 {
            Some(Duration::ZERO)
        } else if interval_us >= 1.0 {
            Duration::try_from_secs_f64(interval_us * 1e-6).ok()
        } else {
            None // zero asks for the default, and so is read what is no number
        };
        if let Some(streams) = self.links.streams(link) {
            streams.set(message_id, interval);
        }
        MAV_RESULT_ACCEPTED
    }

    fn command_get_interval(&mut self, link: LinkId, command: &Command) -> u8 {
        let message_id = command.whole(0).and_then(|id| u16::try_from(id).ok());
        let Some(message_id) = message_id else { return MAV_RESULT_FAILED };
        let known = streams::is_known(u32::from(message_id));
        let Some(streams) = self.links.streams(link) else { return MAV_RESULT_FAILED };
        let interval = streams.interval(u32::from(message_id), &self.parameters);
        let interval_us = match (known, interval.is_zero()) {
            (false, _) => 0, // "not available"
            (true, true) => -1,
            (true, false) => i32::try_from(interval.as_micros()).unwrap_or(i32::MAX),
        };
        let answer = MESSAGE_INTERVAL_DATA { interval_us, message_id };
        self.links.send(link, &Message::MESSAGE_INTERVAL(answer));
        MAV_RESULT_ACCEPTED
    }

    fn command_request(&mut self, command: &Command) -> u8 {
        match command.whole(0).and_then(|id| u32::try_from(id).ok()) {
            Some(message_id) => self.request(message_id),
            None => MAV_RESULT_FAILED,
        }
    }

    /// Has a message sent after the acknowledgement; FAILED if there is nothing to send. Clients that are told
    /// ACCEPTED wait for the message, for as long as five seconds.
    fn request(&mut self, message_id: u32) -> u8 {
        let message = if streams::is_known(message_id) { self.telemetry(message_id) } else { None };
        let found = message.is_some();
        self.requested = message;
        done(found)
    }

    fn answer_requests(&mut self, link: LinkId) {
        if let Some(message) = self.requested.take() {
            self.links.send(link, &message);
        }
    }
}

#[cfg(test)]
mod tests;
