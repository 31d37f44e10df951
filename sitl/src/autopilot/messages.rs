//! What the autopilot does with each message for it. Everything else is ignored.

use std::time::Duration;

use helmlink_wire::dialect::*;
use helmlink_wire::enums::{MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, MAV_SEVERITY_WARNING};
use helmlink_wire::signing::{Signing, SigningKey, Timestamp};
use helmlink_wire::{Identity, LinkId};

use super::Autopilot;
use super::commands::Command;
use super::parameters::*;
use super::telemetry::status::START_UNIX_US;

impl Autopilot {
    /// Acts on a message of `from`, which arrived on `link` and is meant for this autopilot.
    pub(super) fn on_message(&mut self, link: LinkId, from: Identity, message: &Message) {
        let is_own_station = i32::from(from.system) == self.parameters.int(SYSID_MYGCS);
        if self.parameters.int(SYSID_ENFORCE) == 1 && !is_own_station {
            return;
        }
        if self.missions.on_message(self.now, link, from, self.links.own, message) {
            return;
        }
        match message {
            Message::HEARTBEAT(_) if is_own_station => self.failsafe.hear_ground_station(self.now),
            Message::COMMAND_LONG(data) => self.take_command(link, from, &Command::from_long(data)),
            Message::COMMAND_INT(data) => self.take_command(link, from, &Command::from_int(data)),
            Message::SET_MODE(data) => self.take_set_mode(data),
            Message::PARAM_REQUEST_LIST(_) => self.start_parameter_list(link),
            Message::PARAM_REQUEST_READ(data) => self.read_parameter(link, from, data),
            Message::PARAM_SET(data) => self.set_parameter(link, from, data),
            Message::REQUEST_DATA_STREAM(data) => self.take_stream_request(link, data),
            Message::MISSION_SET_CURRENT(data) if self.set_current_item(data.seq) => {
                self.links.send(link, &self.mission_current(data.seq));
            }
            Message::RC_CHANNELS_OVERRIDE(data) if is_own_station => {
                self.rc.take_override(data, self.now);
                self.failsafe.hear_ground_station(self.now);
            }
            Message::MANUAL_CONTROL(data) if is_own_station => {
                self.rc.take_manual(data, self.now, &self.parameters);
                self.failsafe.hear_ground_station(self.now);
            }
            Message::SET_ATTITUDE_TARGET(data) => self.take_attitude_target(data),
            Message::SET_POSITION_TARGET_LOCAL_NED(data) => self.take_local_target(data),
            Message::SET_POSITION_TARGET_GLOBAL_INT(data) => self.take_global_target(data),
            Message::SYSTEM_TIME(data) => self.take_lockstep_answer(link, data),
            Message::TIMESYNC(data) => self.answer_timesync(link, from, data),
            Message::SETUP_SIGNING(data) => self.setup_signing(data),
            Message::PING(data) => self.answer_ping(link, from, data),
            Message::FILE_TRANSFER_PROTOCOL(data) => {
                for answer in self.ftp.answers(link, from, data, &self.parameters) {
                    self.links.send(link, &Message::FILE_TRANSFER_PROTOCOL(answer));
                }
            }
            Message::LOG_REQUEST_LIST(_) => {
                self.links.send(link, &Message::LOG_ENTRY(LOG_ENTRY_DATA::DEFAULT));
            }
            Message::LOG_REQUEST_DATA(data) => {
                let nothing = LOG_DATA_DATA { id: data.id, ofs: data.ofs, ..LOG_DATA_DATA::DEFAULT };
                self.links.send(link, &Message::LOG_DATA(nothing));
            }
            _ => {}
        }
    }

    /// The old way to set a mode. It is never acknowledged; the heartbeat shows what became of it.
    fn take_set_mode(&mut self, data: &SET_MODE_DATA) {
        if data.base_mode & MAV_MODE_FLAG_CUSTOM_MODE_ENABLED != 0 {
            // A refusal has been told as STATUSTEXT.
            let _ = self.enter_mode_number(data.custom_mode);
        }
    }

    fn take_stream_request(&mut self, link: LinkId, data: &REQUEST_DATA_STREAM_DATA) {
        let rate_hz = match data.start_stop {
            0 => 0,
            1 => data.req_message_rate,
            _ => return,
        };
        if let Some(streams) = self.links.streams(link) {
            streams.set_group(data.req_stream_id, rate_hz);
        }
    }

    /// A client in lockstep sends SYSTEM_TIME back once it has seen all up to then.
    fn take_lockstep_answer(&mut self, link: LinkId, data: &SYSTEM_TIME_DATA) {
        let seen_us = data.time_unix_usec.saturating_sub(START_UNIX_US);
        self.clock.answer(link, Duration::from_micros(seen_us));
    }

    fn answer_timesync(&mut self, link: LinkId, from: Identity, data: &TIMESYNC_DATA) {
        if data.tc1 == 0 {
            let answer = TIMESYNC_DATA {
                tc1: self.boot_nanoseconds(),
                ts1: data.ts1,
                target_system: from.system,
                target_component: from.component,
            };
            self.links.send(link, &Message::TIMESYNC(answer));
        }
    }

    /// SETUP_SIGNING: a new key, or none if it is all zeroes. Not while armed, as on ArduRover.
    fn setup_signing(&mut self, data: &SETUP_SIGNING_DATA) {
        if self.armed {
            self.links.text(MAV_SEVERITY_WARNING, "ERROR: Won't setup signing when armed");
            return;
        }
        self.signing_since = Timestamp::from_units(data.initial_timestamp);
        let key = SigningKey::from_bytes(data.secret_key).ok();
        self.links.set_signing(key.map(|key| Signing::new(key, self.signing_since)));
        self.signing_started = self.now;
    }

    fn answer_ping(&mut self, link: LinkId, from: Identity, data: &PING_DATA) {
        if data.target_system == 0 {
            let answer =
                PING_DATA { target_system: from.system, target_component: from.component, ..data.clone() };
            self.links.send(link, &Message::PING(answer));
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::autopilot::modes::Mode;
    use crate::autopilot::testing::{Bench, COMPANION, GCS, LINK};

    fn sticks(steering_us: u16, throttle_us: u16) -> Message {
        Message::RC_CHANNELS_OVERRIDE(RC_CHANNELS_OVERRIDE_DATA {
            chan1_raw: steering_us,
            chan3_raw: throttle_us,
            target_system: 1,
            target_component: 1,
            ..RC_CHANNELS_OVERRIDE_DATA::DEFAULT
        })
    }

    #[test]
    fn overrides_are_obeyed_from_the_ground_station_only_and_last_three_seconds() {
        let mut bench = Bench::with_hull("skiff");
        bench.arm();
        bench.send(LINK, COMPANION, &sticks(1600, 1700));
        bench.run_loops(3);
        assert_eq!(bench.autopilot.outputs.pulses_us()[0], 1500);
        bench.send(LINK, GCS, &sticks(1600, 1700));
        bench.run_s(2.9);
        let pulses = *bench.autopilot.outputs.pulses_us();
        assert_eq!((pulses[0], pulses[2]), (1574, 1680), "as measured on ArduRover");
        bench.run_s(0.4);
        assert_eq!(bench.autopilot.outputs.pulses_us()[0], 1500);
    }

    #[test]
    fn another_ground_station_can_be_chosen() {
        let mut bench = Bench::with_hull("skiff");
        bench.autopilot.parameters.put(SYSID_MYGCS, 1.0);
        bench.arm();
        bench.send(LINK, GCS, &sticks(1600, 1700));
        bench.run_loops(2);
        assert_eq!(bench.autopilot.outputs.pulses_us()[0], 1500);
        bench.send(LINK, COMPANION, &sticks(1600, 1700));
        bench.run_loops(2);
        assert_eq!(bench.autopilot.outputs.pulses_us()[0], 1574);
    }

    #[test]
    fn enforcing_silences_everybody_else() {
        let mut bench = Bench::ready();
        bench.autopilot.parameters.put(SYSID_ENFORCE, 1.0);
        let list = Message::PARAM_REQUEST_LIST(PARAM_REQUEST_LIST_DATA::DEFAULT);
        let has_values = |sent: &[Message]| sent.iter().any(|each| matches!(each, Message::PARAM_VALUE(_)));
        bench.send(LINK, COMPANION, &list);
        assert!(!has_values(&bench.run_loops(1)[&LINK]));
        bench.send(LINK, GCS, &list);
        assert!(has_values(&bench.run_loops(1)[&LINK]));
    }

    #[test]
    fn time_is_told_and_pings_come_back() {
        let mut bench = Bench::ready();
        bench.send(LINK, GCS, &Message::TIMESYNC(TIMESYNC_DATA { ts1: 77, ..TIMESYNC_DATA::DEFAULT }));
        bench.send(LINK, GCS, &Message::PING(PING_DATA { seq: 5, ..PING_DATA::DEFAULT }));
        let sent = bench.run_loops(1).remove(&LINK).unwrap();
        assert!(sent.iter().any(|each| matches!(each,
            Message::TIMESYNC(data) if data.ts1 == 77 && data.tc1 > 0 && data.target_system == 255)));
        assert!(sent.iter().any(|each| matches!(each,
            Message::PING(data) if data.seq == 5 && data.target_system == 255)));
    }

    #[test]
    fn the_old_mode_message_works_without_an_answer() {
        let mut bench = Bench::ready();
        let message = SET_MODE_DATA { custom_mode: 4, target_system: 1, base_mode: 1 };
        bench.send(LINK, GCS, &Message::SET_MODE(message));
        let sent = bench.run_loops(1);
        assert_eq!(bench.autopilot.mode, Mode::Hold);
        assert!(!sent[&LINK].iter().any(|each| matches!(each, Message::COMMAND_ACK(_))));
    }

    #[test]
    fn the_log_list_is_empty() {
        let mut bench = Bench::ready();
        bench.send(LINK, GCS, &Message::LOG_REQUEST_LIST(LOG_REQUEST_LIST_DATA::DEFAULT));
        let sent = bench.run_loops(1);
        assert!(
            sent[&LINK].iter().any(|each| matches!(each, Message::LOG_ENTRY(data) if data.num_logs == 0))
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn any_payload_of_any_message_is_survived(
            seed in any::<u64>(), fills in prop::collection::vec(any::<u8>(), 1..64), armed in any::<bool>(),
        ) {
            let mut bench = Bench::ready();
            if armed {
                bench.arm();
            }
            // Each message once, its payload made of the drawn bytes; the seed chooses where they start.
            for (number, &id) in Message::all_ids().iter().enumerate() {
                let at = |place: usize| fills[(place + number + seed as usize % 61) % fills.len()];
                let payload: Vec<u8> = (0..255).map(at).collect();
                let Ok(message) = Message::parse(MavlinkVersion::V2, id, &payload) else { continue };
                bench.autopilot.on_message(LINK, GCS, &message);
                if number % 10 == 0 {
                    bench.run_loops(1);
                }
            }
            bench.run_s(4.0);
            let hull = bench.vessel.truth().hull;
            prop_assert!(hull.north_m.is_finite() && hull.psi_rad.is_finite());
        }
    }
}
