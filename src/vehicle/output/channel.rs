//! One radio channel as the firmware reads it: dead zone, trim, end points, reversal, whole steps.

use crate::vehicle::parameters::ParameterReader;

/// Pulse widths that a receiver or an override may ever carry.
const PULSE_RANGE_US: (f64, f64) = (800.0, 2200.0);
/// Channels that an override of the first eight reaches.
pub(super) const CHANNELS: usize = 8;

macro_rules! channel_names {
    ($($number:literal),*) => {
        [$([
            concat!("RC", $number, "_MIN"),
            concat!("RC", $number, "_TRIM"),
            concat!("RC", $number, "_MAX"),
            concat!("RC", $number, "_DZ"),
            concat!("RC", $number, "_REVERSED"),
        ]),*]
    };
}

/// Names of the parameters of channel 1, 2, …
pub(super) const NAMES: [[&str; 5]; CHANNELS] = channel_names!(1, 2, 3, 4, 5, 6, 7, 8);

/// How the firmware turns pulse widths of one channel into −1…1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Channel {
    /// 1 to 8.
    pub(super) number: usize,
    pub(super) min_us: f64,
    pub(super) trim_us: f64,
    pub(super) max_us: f64,
    pub(super) dead_zone_us: f64,
    pub(super) reversed: bool,
    /// The firmware cuts the value to this many whole steps a side.
    pub(super) steps: f64,
}

impl Channel {
    /// ArduRover's defaults: 1100–1500–1900 µs, dead zone 30 µs.
    pub(super) fn new(number: usize, steps: f64) -> Self {
        Self {
            number,
            min_us: 1100.0,
            trim_us: 1500.0,
            max_us: 1900.0,
            dead_zone_us: 30.0,
            reversed: false,
            steps,
        }
    }

    /// Takes over what is known of the vehicle's calibration; one that makes no sense is left.
    pub(super) fn calibrate(&mut self, parameters: &ParameterReader) {
        let [min, trim, max, dead_zone, reversed] =
            NAMES[self.number.clamp(1, CHANNELS) - 1].map(|name| parameters.value(name));
        let candidate = Self {
            min_us: min.unwrap_or(self.min_us),
            trim_us: trim.unwrap_or(self.trim_us),
            max_us: max.unwrap_or(self.max_us),
            dead_zone_us: dead_zone.unwrap_or(self.dead_zone_us),
            reversed: reversed.map_or(self.reversed, |value| value != 0.0),
            ..*self
        };
        let room_us = candidate.dead_zone_us.max(0.0);
        let is_sound = candidate.dead_zone_us >= 0.0
            && candidate.min_us + room_us < candidate.trim_us
            && candidate.trim_us + room_us < candidate.max_us;
        if is_sound {
            *self = candidate;
        }
    }

    /// The pulse width, whole microseconds, that the firmware reads as `value` (−1…1) cut to a whole step, and the
    /// value that it then reads.
    pub(super) fn pulse(&self, value: f64) -> (u16, f64) {
        let step = (value.clamp(-1.0, 1.0) * self.steps).round();
        if step == 0.0 {
            return (self.trim_us as u16, 0.0);
        }
        let ahead = (step > 0.0) != self.reversed;
        let span_us = if ahead { self.max_us - self.trim_us } else { self.trim_us - self.min_us };
        let span_us = span_us - self.dead_zone_us;
        // The firmware cuts off what is less than a step, so the pulse must lie on the far side of it.
        let wanted_us = (step.abs() * span_us / self.steps - 1e-9).ceil().min(span_us);
        let offset_us = self.dead_zone_us + wanted_us;
        let pulse_us = if ahead { self.trim_us + offset_us } else { self.trim_us - offset_us };
        let pulse_us = pulse_us.clamp(PULSE_RANGE_US.0, PULSE_RANGE_US.1);
        let read = (wanted_us / span_us * self.steps + 1e-9).trunc() / self.steps;
        (pulse_us.round() as u16, read.copysign(value))
    }

    /// The same as MANUAL_CONTROL's ±1000 from end to end of the channel, which the firmware turns back into whole
    /// microseconds, cut off.
    pub(super) fn stick(&self, value: f64) -> (i16, f64) {
        let (pulse_us, read) = self.pulse(value);
        let ratio = (f64::from(pulse_us) - self.min_us) / (self.max_us - self.min_us);
        let stick = (ratio * 2000.0 - 1e-9).ceil() - 1000.0;
        (stick.clamp(-1000.0, 1000.0) as i16, read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the firmware makes of a pulse, in its whole numbers.
    fn firmware_reads(channel: &Channel, pulse_us: u16) -> f64 {
        let whole = |value: f64| value as i32;
        let (trim, dead) = (whole(channel.trim_us), whole(channel.dead_zone_us));
        let (least, most, steps) = (whole(channel.min_us), whole(channel.max_us), whole(channel.steps));
        let pulse = i32::from(pulse_us);
        let value = if pulse > trim + dead {
            steps * (pulse - trim - dead) / (most - trim - dead)
        } else if pulse < trim - dead {
            steps * (pulse - trim + dead) / (trim - dead - least)
        } else {
            0
        };
        let value = f64::from(value.clamp(-steps, steps)) / f64::from(steps);
        if channel.reversed { -value } else { value }
    }

    proptest! {
        #[test]
        fn the_firmware_reads_what_we_say_it_does(
            value in -1.0..=1.0_f64,
            reversed: bool,
            dead in 0..60_u16,
            min in 950..1200_u16,
            trim in 1400..1600_u16,
            max in 1750..2050_u16,
            throttle: bool,
        ) {
            let channel = Channel {
                min_us: f64::from(min),
                trim_us: f64::from(trim),
                max_us: f64::from(max),
                dead_zone_us: f64::from(dead),
                reversed,
                ..Channel::new(1, if throttle { 100.0 } else { 4500.0 })
            };
            let (pulse_us, read) = channel.pulse(value);
            let found = firmware_reads(&channel, pulse_us);
            prop_assert!((found - read).abs() < 1e-9, "{pulse_us} us: {found} instead of {read}");
            // Half a step of rounding, and then a step, or a microsecond where that is coarser.
            let coarse = 0.5 / channel.steps
                + 1.0 / channel.steps.min(f64::from(max - trim - dead).min(f64::from(trim - dead - min)));
            prop_assert!((found - value).abs() <= coarse + 1e-9, "{found} for {value}");
            let (stick, _) = channel.stick(value);
            let pulse = min + (u32::from(max - min) as f64 * (f64::from(stick) + 1000.0) / 2000.0) as u16;
            prop_assert_eq!(pulse, pulse_us);
        }
    }
}
