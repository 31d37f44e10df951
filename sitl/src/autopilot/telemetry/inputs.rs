//! Messages about radio channels and servo outputs.

use helmlink_wire::dialect::*;

use super::super::Autopilot;
use super::super::parameters::CHANNELS;
use super::super::rc;

/// Channels of the simulated receiver.
const RECEIVER_CHANNELS: u8 = 16;
/// RSSI of a good signal, and of no receiver.
const RSSI: (u8, u8) = (254, 0);

impl Autopilot {
    fn pulse(&self, channel: usize) -> u16 {
        let beyond_receiver = channel > usize::from(RECEIVER_CHANNELS);
        // A receiver says nothing about channels that it lacks.
        if beyond_receiver { 0 } else { self.rc.pulse_us(channel, &self.parameters) }
    }

    fn rssi(&self) -> u8 {
        if rc::has_receiver(&self.parameters) { RSSI.0 } else { RSSI.1 }
    }

    pub(super) fn rc_channels(&self) -> Message {
        let with_input = self.rc.has_input(self.now, &self.parameters);
        Message::RC_CHANNELS(RC_CHANNELS_DATA {
            time_boot_ms: self.boot_ms(),
            chan1_raw: self.pulse(1),
            chan2_raw: self.pulse(2),
            chan3_raw: self.pulse(3),
            chan4_raw: self.pulse(4),
            chan5_raw: self.pulse(5),
            chan6_raw: self.pulse(6),
            chan7_raw: self.pulse(7),
            chan8_raw: self.pulse(8),
            chan9_raw: self.pulse(9),
            chan10_raw: self.pulse(10),
            chan11_raw: self.pulse(11),
            chan12_raw: self.pulse(12),
            chan13_raw: self.pulse(13),
            chan14_raw: self.pulse(14),
            chan15_raw: self.pulse(15),
            chan16_raw: self.pulse(16),
            chan17_raw: self.pulse(17),
            chan18_raw: self.pulse(18),
            chancount: if with_input { RECEIVER_CHANNELS } else { 0 },
            rssi: self.rssi(),
        })
    }

    pub(super) fn rc_channels_raw(&self) -> Message {
        Message::RC_CHANNELS_RAW(RC_CHANNELS_RAW_DATA {
            time_boot_ms: self.boot_ms(),
            chan1_raw: self.pulse(1),
            chan2_raw: self.pulse(2),
            chan3_raw: self.pulse(3),
            chan4_raw: self.pulse(4),
            chan5_raw: self.pulse(5),
            chan6_raw: self.pulse(6),
            chan7_raw: self.pulse(7),
            chan8_raw: self.pulse(8),
            port: 0,
            rssi: self.rssi(),
        })
    }

    pub(super) fn rc_channels_scaled(&self) -> Message {
        /// Full deflection in this message.
        const STEPS: i32 = 10_000;
        let scaled: [i16; CHANNELS] = std::array::from_fn(|index| {
            let pulse_us = self.pulse(index + 1);
            let steps = match pulse_us {
                0 => 0,
                pulse_us => rc::scaled(index + 1, pulse_us, STEPS, &self.parameters),
            };
            i16::try_from(steps).unwrap_or(i16::MAX)
        });
        Message::RC_CHANNELS_SCALED(RC_CHANNELS_SCALED_DATA {
            time_boot_ms: self.boot_ms(),
            chan1_scaled: scaled[0],
            chan2_scaled: scaled[1],
            chan3_scaled: scaled[2],
            chan4_scaled: scaled[3],
            chan5_scaled: scaled[4],
            chan6_scaled: scaled[5],
            chan7_scaled: scaled[6],
            chan8_scaled: scaled[7],
            port: 0,
            rssi: self.rssi(),
        })
    }

    pub(super) fn servo_output(&self) -> Message {
        let pulse = self.outputs.pulses_us();
        Message::SERVO_OUTPUT_RAW(SERVO_OUTPUT_RAW_DATA {
            time_usec: self.boot_us() as u32, // the field wraps after 71 minutes, as MAVLink has it
            servo1_raw: pulse[0],
            servo2_raw: pulse[1],
            servo3_raw: pulse[2],
            servo4_raw: pulse[3],
            servo5_raw: pulse[4],
            servo6_raw: pulse[5],
            servo7_raw: pulse[6],
            servo8_raw: pulse[7],
            port: 0,
            servo9_raw: pulse[8],
            servo10_raw: pulse[9],
            servo11_raw: pulse[10],
            servo12_raw: pulse[11],
            servo13_raw: pulse[12],
            servo14_raw: pulse[13],
            servo15_raw: pulse[14],
            servo16_raw: pulse[15],
        })
    }
}
