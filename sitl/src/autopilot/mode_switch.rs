//! The mode switch of a radio: six positions of one channel (MODE_CH), each with its mode (MODE1 to MODE6).

use std::time::Duration;

use super::Autopilot;
use super::parameters::*;

/// Pulses from which on the second to the sixth position are meant, µs (ArduPilot's documents, "RC Transmitter Flight
/// Mode Configuration").
const POSITIONS_US: [u16; 5] = [1231, 1361, 1491, 1621, 1750];
/// Pulses outside these are no position of a switch, µs.
const PULSES_US: std::ops::Range<u16> = 901..2200;
/// A switch must rest for so long in a new position.
const REST: Duration = Duration::from_millis(200);

const MODES: [Param; 6] = [MODE1, MODE2, MODE3, MODE4, MODE5, MODE6];

/// Where the switch is. A mode is chosen by moving it: where it lies at the start means nothing.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ModeSwitch {
    rests_at: Option<usize>,
    moved_to: Option<(usize, Duration)>,
}

impl ModeSwitch {
    /// The position, 0 to 5, that the switch has been moved to and left in; told once.
    fn moved(&mut self, pulse_us: u16, now: Duration) -> Option<usize> {
        if !PULSES_US.contains(&pulse_us) {
            return None;
        }
        let position = POSITIONS_US.iter().filter(|from_us| pulse_us >= **from_us).count();
        let rests_at = *self.rests_at.get_or_insert(position);
        match self.moved_to {
            _ if position == rests_at => self.moved_to = None,
            Some((wanted, since)) if wanted == position => {
                if now.saturating_sub(since) >= REST {
                    *self = Self { rests_at: Some(position), moved_to: None };
                    return Some(position);
                }
            }
            _ => self.moved_to = Some((position, now)),
        }
        None
    }
}

impl Autopilot {
    /// Enters the mode that the switch has been moved to.
    pub(super) fn watch_mode_switch(&mut self) {
        let channel = usize::try_from(self.parameters.int(MODE_CH)).unwrap_or_default();
        if channel == 0 || !self.is_initialised() || !self.rc.has_input(self.now, &self.parameters) {
            return;
        }
        let pulse_us = self.rc.pulse_us(channel, &self.parameters);
        let mode = self.mode_switch.moved(pulse_us, self.now).and_then(|position| MODES.get(position));
        if let Some(mode) = mode {
            self.order_mode(u32::try_from(self.parameters.int(*mode)).unwrap_or_default());
        }
    }
}

#[cfg(test)]
mod tests {
    use helmlink_wire::Message;
    use helmlink_wire::dialect::RC_CHANNELS_OVERRIDE_DATA;

    use super::*;
    use crate::autopilot::modes::Mode;
    use crate::autopilot::testing::{Bench, GCS, LINK};

    /// The mode after the switch has been held so for a while.
    fn switched(bench: &mut Bench, pulse_us: u16, loops: u32) -> Mode {
        let switch = RC_CHANNELS_OVERRIDE_DATA { chan8_raw: pulse_us, ..RC_CHANNELS_OVERRIDE_DATA::DEFAULT };
        bench.send(LINK, GCS, &Message::RC_CHANNELS_OVERRIDE(switch));
        bench.run_loops(loops);
        bench.autopilot.mode
    }

    #[test]
    fn a_mode_is_chosen_by_moving_the_switch() {
        let mut bench = Bench::ready();
        bench.autopilot.parameters.put(MODE2, 4.0);
        bench.autopilot.parameters.put(MODE6, 5.0);
        assert_eq!(bench.autopilot.mode, Mode::Manual);
        assert_eq!(switched(&mut bench, 1300, 5), Mode::Manual, "not at rest yet");
        assert_eq!(switched(&mut bench, 1300, 10), Mode::Hold);
        // An order stands until the switch is moved again.
        bench.autopilot.order_mode(5);
        assert_eq!(switched(&mut bench, 1350, 20), Mode::Loiter);
        assert_eq!(switched(&mut bench, 1800, 20), Mode::Loiter);
        // The receiver's own switch is in the middle; what is no pulse of a switch is none.
        assert_eq!(switched(&mut bench, 0, 20), Mode::Manual);
        assert_eq!(switched(&mut bench, 2300, 20), Mode::Manual);
        bench.autopilot.parameters.put(MODE_CH, 0.0);
        assert_eq!(switched(&mut bench, 1300, 20), Mode::Manual);
    }
}
