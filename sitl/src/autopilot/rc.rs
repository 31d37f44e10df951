//! Radio control: the receiver, and overrides by a ground station.

use std::time::Duration;

use helmlink_wire::dialect::{MANUAL_CONTROL_DATA, RC_CHANNELS_OVERRIDE_DATA};

use super::parameters::*;

/// Channels of the receiver and of RC_CHANNELS_OVERRIDE.
pub(super) const RC_CHANNELS: usize = 18;
/// Without any new radio input for this long the sticks count as released (measured 0.48 s).
pub(super) const INPUT_TIMEOUT: Duration = Duration::from_millis(480);
/// Full steering in ArduPilot's units, hundredths of a degree.
const STEERING_STEPS: i32 = 4500;
/// Full throttle in ArduPilot's units, per cent.
const THROTTLE_STEPS: i32 = 100;
/// A stick in the middle, µs.
const CENTRE_US: u16 = 1500;

/// Input channels. Numbers count from 1.
#[derive(Debug, Clone, Default)]
pub(super) struct RcInput {
    overrides: [Option<Override>; RC_CHANNELS],
    last_override: Option<Duration>,
}

#[derive(Debug, Clone, Copy)]
struct Override {
    pulse_us: u16,
    at: Duration,
}

/// Where the sticks are, each [−1, 1].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Sticks {
    pub(super) steering: f64,
    pub(super) throttle: f64,
}

impl RcInput {
    /// RC_CHANNELS_OVERRIDE. Channels 1 to 8: 0 releases, 65535 leaves as it is. Channels 9 to 18: 0 and
    /// 65535 leave as it is, 65534 releases.
    pub(super) fn take_override(&mut self, data: &RC_CHANNELS_OVERRIDE_DATA, now: Duration) {
        for (index, pulse_us) in pulses(data).into_iter().enumerate() {
            let low = index < 8;
            match pulse_us {
                u16::MAX => {}
                0 if low => self.overrides[index] = None,
                0 => {}
                65534 if !low => self.overrides[index] = None,
                pulse_us => self.overrides[index] = Some(Override { pulse_us, at: now }),
            }
        }
        self.last_override = Some(now);
    }

    /// MANUAL_CONTROL: y steers, z drives, ±1000; 32767 leaves an axis as it is.
    pub(super) fn take_manual(&mut self, data: &MANUAL_CONTROL_DATA, now: Duration, parameters: &Parameters) {
        for (value, map) in [(data.y, RCMAP_ROLL), (data.z, RCMAP_THROTTLE)] {
            if value == i16::MAX {
                continue;
            }
            let channel = mapped(parameters, map);
            let least = parameters.get(rc(channel, RcField::Min));
            let most = parameters.get(rc(channel, RcField::Max));
            let share = f64::from(value.clamp(-1000, 1000)) / 2000.0 + 0.5;
            let pulse_us = (least + share * (most - least)) as u16;
            self.overrides[channel - 1] = Some(Override { pulse_us, at: now });
        }
        self.last_override = Some(now);
    }

    /// Releases every override.
    pub(super) fn clear(&mut self) {
        self.overrides = Default::default();
    }

    /// Drops the overrides older than RC_OVERRIDE_TIME (0 forbids overrides, −1 keeps them for ever).
    pub(super) fn expire(&mut self, now: Duration, parameters: &Parameters) {
        let limit_s = parameters.get(RC_OVERRIDE_TIME);
        for slot in &mut self.overrides {
            let age = slot.map(|each| now.saturating_sub(each.at).as_secs_f64());
            if limit_s >= 0.0 && age.is_some_and(|age_s| age_s >= limit_s) {
                *slot = None;
            }
        }
    }

    /// Whether the receiver or an override has given input of late.
    pub(super) fn has_input(&self, now: Duration, parameters: &Parameters) -> bool {
        let overridden = self.overrides.iter().any(Option::is_some)
            && self.last_override.is_some_and(|at| now.saturating_sub(at) < INPUT_TIMEOUT);
        has_receiver(parameters) || overridden
    }

    /// The pulse of a channel, µs; 0 when there is none.
    pub(super) fn pulse_us(&self, channel: usize, parameters: &Parameters) -> u16 {
        let overridden = self.overrides.get(channel.wrapping_sub(1)).copied().flatten();
        match overridden {
            Some(each) => each.pulse_us,
            None if has_receiver(parameters) => CENTRE_US,
            None => 0,
        }
    }

    /// The throttle channel's pulse, µs; 0 when there is none.
    pub(super) fn throttle_us(&self, parameters: &Parameters) -> u16 {
        self.pulse_us(mapped(parameters, RCMAP_THROTTLE), parameters)
    }

    /// Where the sticks are; in the middle without input.
    pub(super) fn sticks(&self, now: Duration, parameters: &Parameters) -> Sticks {
        if !self.has_input(now, parameters) {
            return Sticks::default();
        }
        let stick = |map: Param, steps: i32| {
            let channel = mapped(parameters, map);
            let pulse_us = self.pulse_us(channel, parameters);
            if pulse_us == 0 {
                return 0.0;
            }
            f64::from(scaled(channel, pulse_us, steps, parameters)) / f64::from(steps)
        };
        Sticks {
            steering: stick(RCMAP_ROLL, STEERING_STEPS),
            throttle: stick(RCMAP_THROTTLE, THROTTLE_STEPS),
        }
    }
}

/// Whether a radio receiver is fitted and works.
pub(super) fn has_receiver(parameters: &Parameters) -> bool {
    parameters.int(SIM_RC_FAIL) == 0
}

/// The channel that an `RCMAP_` parameter names.
fn mapped(parameters: &Parameters, map: Param) -> usize {
    usize::try_from(parameters.int(map)).unwrap_or(1).clamp(1, CHANNELS)
}

/// A pulse as a whole number of `steps` per side: nothing within the dead zone, the rest rescaled
/// (1600 µs is 14 of 100, not 20, as measured on ArduRover 4.6).
pub(super) fn scaled(channel: usize, pulse_us: u16, steps: i32, parameters: &Parameters) -> i32 {
    let channel = channel.clamp(1, CHANNELS);
    let trim = parameters.int(rc(channel, RcField::Trim));
    let dead = parameters.int(rc(channel, RcField::Dz));
    let (least, most) =
        (parameters.int(rc(channel, RcField::Min)), parameters.int(rc(channel, RcField::Max)));
    let pulse = i32::from(pulse_us);
    let value = if pulse > trim + dead && most > trim + dead {
        steps * (pulse - trim - dead) / (most - trim - dead)
    } else if pulse < trim - dead && least < trim - dead {
        steps * (pulse - trim + dead) / (trim - dead - least)
    } else {
        0
    };
    let signed = if parameters.int(rc(channel, RcField::Reversed)) == 1 { -value } else { value };
    signed.clamp(-steps, steps)
}

fn pulses(data: &RC_CHANNELS_OVERRIDE_DATA) -> [u16; RC_CHANNELS] {
    [
        data.chan1_raw,
        data.chan2_raw,
        data.chan3_raw,
        data.chan4_raw,
        data.chan5_raw,
        data.chan6_raw,
        data.chan7_raw,
        data.chan8_raw,
        data.chan9_raw,
        data.chan10_raw,
        data.chan11_raw,
        data.chan12_raw,
        data.chan13_raw,
        data.chan14_raw,
        data.chan15_raw,
        data.chan16_raw,
        data.chan17_raw,
        data.chan18_raw,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Duration = Duration::from_secs(100);

    fn after(ms: u64) -> Duration {
        START + Duration::from_millis(ms)
    }

    fn steering_override(pulse_us: u16) -> RC_CHANNELS_OVERRIDE_DATA {
        RC_CHANNELS_OVERRIDE_DATA {
            chan1_raw: pulse_us,
            chan3_raw: 1700,
            ..RC_CHANNELS_OVERRIDE_DATA::DEFAULT
        }
    }

    #[test]
    fn pulses_are_scaled_as_measured() {
        let parameters = Parameters::new();
        for (pulse, expected) in [(1530, 0), (1470, 0), (1600, 14), (1700, 36), (2000, 100), (1000, -100)] {
            assert_eq!(scaled(3, pulse, THROTTLE_STEPS, &parameters), expected, "{pulse} µs");
        }
        assert_eq!(scaled(1, 1600, STEERING_STEPS, &parameters), 670);
        assert_eq!(scaled(1, 65000, STEERING_STEPS, &parameters), STEERING_STEPS);
    }

    #[test]
    fn an_override_holds_for_its_time_and_then_the_receiver_is_back() {
        let parameters = Parameters::new();
        let mut input = RcInput::default();
        input.take_override(&steering_override(1800), START);
        input.expire(after(2980), &parameters);
        assert_eq!(input.pulse_us(1, &parameters), 1800);
        input.expire(after(3000), &parameters);
        assert_eq!(input.pulse_us(1, &parameters), CENTRE_US);
    }

    #[test]
    fn zero_releases_the_first_eight_and_65534_the_others() {
        let parameters = Parameters::new();
        let mut input = RcInput::default();
        let mut data = RC_CHANNELS_OVERRIDE_DATA { chan9_raw: 1900, ..steering_override(1800) };
        input.take_override(&data, START);
        assert_eq!(input.pulse_us(9, &parameters), 1900);
        data = RC_CHANNELS_OVERRIDE_DATA { chan3_raw: u16::MAX, chan9_raw: 0, ..steering_override(0) };
        input.take_override(&data, START);
        assert_eq!(input.pulse_us(1, &parameters), CENTRE_US);
        assert_eq!(input.pulse_us(3, &parameters), 1700);
        assert_eq!(input.pulse_us(9, &parameters), 1900);
        data.chan9_raw = 65534;
        input.take_override(&data, START);
        assert_eq!(input.pulse_us(9, &parameters), CENTRE_US);
    }

    #[test]
    fn without_a_receiver_the_sticks_return_when_overrides_stop() {
        let mut parameters = Parameters::new();
        parameters.put(SIM_RC_FAIL, 1.0);
        let mut input = RcInput::default();
        assert!(!input.has_input(START, &parameters));
        input.take_override(&steering_override(1800), START);
        assert!(input.sticks(after(460), &parameters).throttle > 0.3);
        assert_eq!(input.sticks(after(500), &parameters), Sticks::default());
    }

    #[test]
    fn manual_control_moves_two_axes() {
        let parameters = Parameters::new();
        let mut input = RcInput::default();
        let data = MANUAL_CONTROL_DATA { y: -1000, z: i16::MAX, ..MANUAL_CONTROL_DATA::DEFAULT };
        input.take_manual(&data, START, &parameters);
        assert_eq!(input.pulse_us(1, &parameters), 1000);
        assert_eq!(input.pulse_us(3, &parameters), CENTRE_US);
        assert_eq!(input.sticks(START, &parameters), Sticks { steering: -1.0, throttle: 0.0 });
    }
}
