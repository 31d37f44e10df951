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
            MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN => {
                // 1 restarts, 3 restarts into the boot loader; a shutdown is not simulated.
                done(!self.armed && matches!(command.whole(0), Some(1 | 3)))
            }
            MAV_CMD_PREFLIGHT_CALIBRATION | MAV_CMD_PREFLIGHT_STORAGE => done(!self.armed),
            _ => MAV_RESULT_UNSUPPORTED,
        }
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
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::autopilot::testing::{Bench, COMPANION, GCS, LINK, OTHER_LINK};

    fn long(command: u16, params: [f32; 7]) -> Message {
        let [param1, param2, param3, param4, param5, param6, param7] = params;
        Message::COMMAND_LONG(COMMAND_LONG_DATA {
            param1,
            param2,
            param3,
            param4,
            param5,
            param6,
            param7,
            command,
            target_system: 1,
            target_component: 1,
            confirmation: 0,
        })
    }

    fn simple(command: u16, param1: f32, param2: f32) -> Message {
        long(command, [param1, param2, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    fn int(command: u16, params: [f32; 4], x: i32, y: i32, frame: u8) -> Message {
        let [param1, param2, param3, param4] = params;
        Message::COMMAND_INT(COMMAND_INT_DATA {
            param1,
            param2,
            param3,
            param4,
            x,
            y,
            command,
            target_system: 1,
            target_component: 1,
            frame,
            ..COMMAND_INT_DATA::DEFAULT
        })
    }

    fn acks(messages: &[Message]) -> Vec<COMMAND_ACK_DATA> {
        let ack = |message: &Message| match message {
            Message::COMMAND_ACK(data) => Some(data.clone()),
            _ => None,
        };
        messages.iter().filter_map(ack).collect()
    }

    /// The result of a command, and the messages that came with it.
    fn result(bench: &mut Bench, command: &Message) -> (u8, Vec<Message>) {
        bench.send(LINK, GCS, command);
        let mut sent = bench.run_loops(1);
        let acks = acks(&sent[&LINK]);
        assert_eq!(acks.len(), 1, "{command:?}");
        assert_eq!((acks[0].target_system, acks[0].target_component), (GCS.system, GCS.component));
        (acks[0].result, sent.remove(&LINK).unwrap())
    }

    #[test]
    fn results_are_those_measured_on_ardurover() {
        let mut bench = Bench::ready();
        for (command, param1, param2, expected) in [
            (MAV_CMD_COMPONENT_ARM_DISARM, 2.0, 0.0, MAV_RESULT_UNSUPPORTED),
            (MAV_CMD_COMPONENT_ARM_DISARM, f32::NAN, 0.0, MAV_RESULT_UNSUPPORTED),
            (MAV_CMD_DO_SET_MODE, 1.0, 4.0, MAV_RESULT_ACCEPTED),
            (MAV_CMD_DO_SET_MODE, 129.0, 0.0, MAV_RESULT_ACCEPTED),
            (MAV_CMD_DO_SET_MODE, 0.0, 4.0, MAV_RESULT_DENIED),
            (MAV_CMD_DO_SET_MODE, 1.0, 99.0, MAV_RESULT_FAILED),
            (MAV_CMD_DO_SET_MODE, 1.0, 6.0, MAV_RESULT_FAILED),
            (MAV_CMD_DO_SET_MODE, 1.0, f32::NAN, MAV_RESULT_FAILED),
            (MAV_CMD_MISSION_START, 0.0, 0.0, MAV_RESULT_FAILED),
            (MAV_CMD_DO_PAUSE_CONTINUE, 0.0, 0.0, MAV_RESULT_UNSUPPORTED),
            (MAV_CMD_NAV_TAKEOFF, 0.0, 0.0, MAV_RESULT_UNSUPPORTED),
            (MAV_CMD_NAV_LAND, 0.0, 0.0, MAV_RESULT_UNSUPPORTED),
            (9999, 0.0, 0.0, MAV_RESULT_UNSUPPORTED),
            (MAV_CMD_DO_SET_SERVO, 1.0, 1600.0, MAV_RESULT_FAILED),
            (MAV_CMD_DO_SET_SERVO, 9.0, 1600.0, MAV_RESULT_ACCEPTED),
            (MAV_CMD_REQUEST_MESSAGE, 435.0, 0.0, MAV_RESULT_FAILED),
            (MAV_CMD_REQUEST_MESSAGE, 397.0, 0.0, MAV_RESULT_FAILED),
            (MAV_CMD_SET_MESSAGE_INTERVAL, 230.0, 1e6, MAV_RESULT_DENIED),
            (MAV_CMD_SET_MESSAGE_INTERVAL, 30.0, f32::NAN, MAV_RESULT_ACCEPTED),
            (MAV_CMD_DO_SET_MISSION_CURRENT, 7.0, 0.0, MAV_RESULT_DENIED),
            (MAV_CMD_NAV_RETURN_TO_LAUNCH, 0.0, 0.0, MAV_RESULT_ACCEPTED),
        ] {
            let found = result(&mut bench, &simple(command, param1, param2)).0;
            assert_eq!(found, expected, "command {command} ({param1}, {param2})");
        }
    }

    #[test]
    fn both_forms_arm_and_the_ack_goes_to_the_sender_alone() {
        let mut bench = Bench::ready();
        bench.send(LINK, COMPANION, &int(MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0, 0.0], 0, 0, 0));
        let sent = bench.run_loops(1);
        assert!(bench.autopilot.armed);
        assert_eq!(acks(&sent[&LINK])[0].target_component, COMPANION.component);
        assert!(acks(&sent[&OTHER_LINK]).is_empty());
        result(&mut bench, &simple(MAV_CMD_COMPONENT_ARM_DISARM, 0.0, 21196.0));
        assert!(!bench.autopilot.armed);
    }

    #[test]
    fn every_repetition_is_acknowledged() {
        let mut bench = Bench::ready();
        for _ in 0..20 {
            bench.send(LINK, GCS, &simple(MAV_CMD_DO_SET_MODE, 1.0, 4.0));
        }
        assert_eq!(acks(&bench.run_loops(1)[&LINK]).len(), 20);
    }

    #[test]
    fn other_systems_commands_are_not_answered_and_unknown_components_are_the_autopilot() {
        let mut bench = Bench::ready();
        let to = |system, component| {
            let Message::COMMAND_LONG(data) = simple(MAV_CMD_DO_SET_MODE, 1.0, 4.0) else { panic!() };
            Message::COMMAND_LONG(COMMAND_LONG_DATA {
                target_system: system,
                target_component: component,
                ..data
            })
        };
        for (system, component, answers) in [(77, 1, 0), (1, 55, 1), (1, 0, 1), (0, 0, 1)] {
            bench.send(LINK, GCS, &to(system, component));
            assert_eq!(acks(&bench.run_loops(1)[&LINK]).len(), answers, "{system}/{component}");
        }
    }

    #[test]
    fn requested_messages_follow_their_acknowledgement() {
        let mut bench = Bench::ready();
        let (found, sent) = result(&mut bench, &simple(MAV_CMD_REQUEST_MESSAGE, 148.0, 0.0));
        assert_eq!(found, MAV_RESULT_ACCEPTED);
        let Some(Message::AUTOPILOT_VERSION(version)) = sent.last() else { panic!("{sent:?}") };
        assert_eq!(version.capabilities, 0xF1EF);
        let old = result(&mut bench, &simple(MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1.0, 0.0)).1;
        assert!(matches!(old.last(), Some(Message::AUTOPILOT_VERSION(_))));
        let home = result(&mut bench, &simple(MAV_CMD_REQUEST_MESSAGE, 242.0, 0.0)).1;
        assert!(matches!(home.last(), Some(Message::HOME_POSITION(_))));
    }

    #[test]
    fn intervals_are_set_and_told_per_link() {
        let mut bench = Bench::ready();
        assert_eq!(
            result(&mut bench, &simple(MAV_CMD_SET_MESSAGE_INTERVAL, 30.0, 1e5)).0,
            MAV_RESULT_ACCEPTED
        );
        let interval = |bench: &mut Bench| {
            let (_, sent) = result(bench, &simple(MAV_CMD_GET_MESSAGE_INTERVAL, 30.0, 0.0));
            sent.iter().find_map(|message| match message {
                Message::MESSAGE_INTERVAL(data) => Some(data.interval_us),
                _ => None,
            })
        };
        assert_eq!(interval(&mut bench), Some(100_000));
        let sent = bench.run_s(2.0);
        let count =
            |link| sent[&link].iter().filter(|message| matches!(message, Message::ATTITUDE(_))).count();
        assert_eq!((count(LINK), count(OTHER_LINK)), (20, 2));
        result(&mut bench, &simple(MAV_CMD_SET_MESSAGE_INTERVAL, 30.0, -1.0));
        assert_eq!(interval(&mut bench), Some(-1));
        result(&mut bench, &simple(MAV_CMD_SET_MESSAGE_INTERVAL, 30.0, 0.0));
        assert_eq!(interval(&mut bench), Some(1_000_000));
    }

    #[test]
    fn a_reposition_changes_the_mode_only_when_told_to() {
        let mut bench = Bench::ready();
        bench.arm();
        let (x, y) = (bench.autopilot.position().to_e7().0 + 1000, bench.autopilot.position().to_e7().1);
        let refused = int(MAV_CMD_DO_REPOSITION, [-1.0, 0.0, 0.0, 0.0], x, y, MAV_FRAME_GLOBAL_INT);
        assert_eq!(result(&mut bench, &refused).0, MAV_RESULT_DENIED);
        let nowhere = int(MAV_CMD_DO_REPOSITION, [-1.0, 1.0, 0.0, 0.0], i32::MAX, y, MAV_FRAME_GLOBAL);
        assert_eq!(result(&mut bench, &nowhere).0, MAV_RESULT_DENIED);
        let accepted = int(MAV_CMD_DO_REPOSITION, [-1.0, 1.0, 0.0, f32::NAN], x, y, MAV_FRAME_GLOBAL);
        assert_eq!(result(&mut bench, &accepted).0, MAV_RESULT_ACCEPTED);
        assert_eq!(bench.autopilot.mode, Mode::Guided);
        assert_eq!(result(&mut bench, &simple(MAV_CMD_DO_CHANGE_SPEED, 1.0, 0.5)).0, MAV_RESULT_ACCEPTED);
    }

    #[test]
    fn home_can_be_set_here_or_there() {
        let mut bench = Bench::ready();
        let there = long(MAV_CMD_DO_SET_HOME, [0.0, 0.0, 0.0, 0.0, 50.0, 6.0, 0.0]);
        assert_eq!(result(&mut bench, &there).0, MAV_RESULT_ACCEPTED);
        let home = bench.autopilot.home.unwrap();
        assert!((home.latitude_deg - 50.0).abs() < 1e-6);
        bench.arm();
        assert_eq!(bench.autopilot.home, Some(home), "arming does not move a home that was set");
        let nowhere = long(MAV_CMD_DO_SET_HOME, [0.0, 0.0, 0.0, 0.0, f32::NAN, 6.0, 0.0]);
        assert_eq!(result(&mut bench, &nowhere).0, MAV_RESULT_FAILED);
        assert_eq!(result(&mut bench, &simple(MAV_CMD_DO_SET_HOME, 1.0, 0.0)).0, MAV_RESULT_ACCEPTED);
    }

    #[test]
    fn a_restart_starts_the_clock_again_and_keeps_the_parameters() {
        let mut bench = Bench::ready();
        bench.autopilot.parameters.put(super::super::parameters::SYSID_MYGCS, 42.0);
        bench.arm();
        assert_eq!(
            result(&mut bench, &simple(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0, 0.0)).0,
            MAV_RESULT_FAILED
        );
        bench.autopilot.disarm();
        assert_eq!(
            result(&mut bench, &simple(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0, 0.0)).0,
            MAV_RESULT_ACCEPTED
        );
        assert!(bench.autopilot.since_boot() < Duration::from_millis(100));
        assert_eq!(bench.autopilot.parameters.int(super::super::parameters::SYSID_MYGCS), 42);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_command_is_acknowledged_once(
            commands in prop::collection::vec(
                (prop_oneof![0u16..700, any::<u16>()], prop::array::uniform7(any::<f32>())), 1..20),
        ) {
            let mut bench = Bench::ready();
            for (command, params) in commands {
                bench.send(LINK, GCS, &long(command, params));
                prop_assert_eq!(acks(&bench.run_loops(1)[&LINK]).len(), 1);
            }
        }
    }
}
