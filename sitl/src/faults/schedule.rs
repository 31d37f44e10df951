//! Faults that begin and end at given times.

use std::str::FromStr;
use std::time::Duration;

use super::{Fault, FaultTextError};

/// A fault with its times, counted from the start of the simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedFault {
    /// What fails.
    pub fault: Fault,
    /// From when on.
    pub from: Duration,
    /// Until when; `None` to the end.
    pub until: Option<Duration>,
}

/// Why a text is no timed fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScheduleError {
    /// The fault itself.
    #[error(transparent)]
    Fault(#[from] FaultTextError),
    /// The times.
    #[error("`{0}`: give the times in seconds as FAULT@FROM or FAULT@FROM..UNTIL, such as gps-loss@60..90")]
    Times(String),
}

impl FromStr for TimedFault {
    type Err = ScheduleError;

    /// Reads `FAULT`, `FAULT@FROM` or `FAULT@FROM..UNTIL`, in seconds.
    fn from_str(text: &str) -> Result<Self, ScheduleError> {
        let (fault, times) = match text.split_once('@') {
            Some((fault, times)) => (fault, Some(times)),
            None => (text, None),
        };
        let fault = fault.parse()?;
        let Some(times) = times else { return Ok(Self { fault, from: Duration::ZERO, until: None }) };
        let wrong = || ScheduleError::Times(text.to_owned());
        let seconds = |text: &str| {
            let number: f64 = text.trim().parse().map_err(|_| wrong())?;
            Duration::try_from_secs_f64(number).map_err(|_| wrong())
        };
        let (from, until) = match times.split_once("..") {
            Some((from, until)) => (seconds(from)?, Some(seconds(until)?)),
            None => (seconds(times)?, None),
        };
        if until.is_some_and(|until| until <= from) {
            return Err(wrong());
        }
        Ok(Self { fault, from, until })
    }
}

/// What a schedule does next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Turn {
    /// The fault begins.
    Begin(Fault),
    /// The fault ends.
    End(Fault),
}

/// Faults to come.
#[derive(Debug, Clone, Default)]
pub(crate) struct Schedule {
    /// Begins and ends, by time, the next one last.
    turns: Vec<(Duration, Turn)>,
}

impl Schedule {
    /// Adds a fault.
    pub(crate) fn add(&mut self, timed: TimedFault) {
        self.turns.push((timed.from, Turn::Begin(timed.fault)));
        if let Some(until) = timed.until {
            self.turns.push((until, Turn::End(timed.fault)));
        }
        // Stable, so of two turns at one time the one added first comes first.
        self.turns.sort_by_key(|(at, _)| std::cmp::Reverse(*at));
    }

    /// The next turn that is due; call it until there is none.
    pub(crate) fn due(&mut self, now: Duration) -> Option<Turn> {
        let (at, _) = self.turns.last()?;
        if *at > now {
            return None;
        }
        self.turns.pop().map(|(_, turn)| turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_and_nonsense_is_not() {
        let timed: TimedFault = "gps-jump=20,0@60..90.5".parse().unwrap();
        assert_eq!(timed.fault, Fault::GpsJump { north_m: 20.0, east_m: 0.0 });
        assert_eq!((timed.from, timed.until), (Duration::from_secs(60), Some(Duration::from_millis(90_500))));
        assert_eq!("gps-loss".parse::<TimedFault>().unwrap().from, Duration::ZERO);
        assert_eq!("gps-loss@5".parse::<TimedFault>().unwrap().until, None);
        for wrong in ["gps-loss@", "gps-loss@x", "gps-loss@9..3", "gps-loss@-1", "gps-loss@nan..3", "@3"] {
            assert!(wrong.parse::<TimedFault>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn turns_come_in_order_of_time() {
        let mut schedule = Schedule::default();
        for text in ["gps-loss@10..20", "reboot@5", "ekf-failure@10"] {
            schedule.add(text.parse().unwrap());
        }
        let mut taken = |second: u64| {
            let mut all = Vec::new();
            while let Some(turn) = schedule.due(Duration::from_secs(second)) {
                all.push(turn);
            }
            all
        };
        assert_eq!(taken(4), []);
        assert_eq!(taken(5), [Turn::Begin(Fault::Reboot)]);
        let both = taken(19);
        assert!(
            both.contains(&Turn::Begin(Fault::GpsLoss)) && both.contains(&Turn::Begin(Fault::EkfFailure))
        );
        assert_eq!(taken(20), [Turn::End(Fault::GpsLoss)]);
    }
}
