//! A scenario under way.

use std::time::Duration;

use super::{Event, Happening, Observation, Scenario, ScenarioClock, Verdict};
use crate::Sitl;

/// A scenario with how far it is.
#[derive(Debug)]
pub(crate) struct Play {
    scenario: Scenario,
    /// When its clock started.
    started: Option<Duration>,
    next_event: usize,
    verdicts: Vec<Verdict>,
    over: bool,
}

impl Play {
    pub(crate) fn new(scenario: Scenario) -> Self {
        let open = |expectation: &super::Expectation| Verdict {
            expectation: expectation.to_string(),
            passed: None,
            seen: String::new(),
        };
        let verdicts = scenario.expectations.iter().map(open).collect();
        Self { scenario, started: None, next_event: 0, verdicts, over: false }
    }

    pub(crate) fn verdicts(&self) -> &[Verdict] {
        &self.verdicts
    }

    pub(crate) fn is_over(&self) -> bool {
        self.over
    }

    /// One loop: what is due happens, and what can be judged is.
    pub(crate) fn step(&mut self, boat: &mut Sitl) {
        if self.over {
            return;
        }
        let waits = self.scenario.clock == ScenarioClock::Armed && !boat.is_armed();
        if self.started.is_none() && !waits {
            self.started = Some(boat.now());
        }
        let Some(started) = self.started else { return };
        let now = boat.now().saturating_sub(started);
        while let Some(Event { at, what }) = self.scenario.events.get(self.next_event) {
            if *at > now {
                break;
            }
            happen(boat, what);
            self.next_event += 1;
        }
        self.over = now >= self.scenario.duration;
        self.judge(&boat.observe(), now);
    }

    /// There is nothing more to come: open expectations are decided by how things stand.
    pub(crate) fn end(&mut self, boat: &Sitl) {
        if !self.over {
            self.over = true;
            let now = self.started.map_or(Duration::ZERO, |started| boat.now().saturating_sub(started));
            self.judge(&boat.observe(), now);
        }
    }

    fn judge(&mut self, seen: &Observation, now: Duration) {
        for (expectation, verdict) in self.scenario.expectations.iter().zip(&mut self.verdicts) {
            expectation.judge(verdict, seen, now, self.over);
        }
    }
}

fn happen(boat: &mut Sitl, what: &Happening) {
    let mut sea = *boat.sea();
    match what {
        Happening::Fail(fault) => boat.autopilot.put_fault(fault),
        Happening::Repair(fault) => boat.autopilot.lift_fault(fault),
        Happening::Sea(state) => sea = crate::physics::Sea::preset(*state, boat.hull()),
        Happening::Current(current) => sea.current = Some(*current),
        Happening::Wind(wind) => sea.wind = Some(*wind),
        Happening::Waves(waves) => sea.waves = Some(*waves),
        Happening::Parameter { name, value } => boat.autopilot.set_known_parameter(name, *value),
        Happening::Arm => {
            boat.autopilot.arm(false);
        }
        Happening::Disarm => boat.autopilot.disarm(),
        Happening::Mode(number) => boat.autopilot.order_mode(*number),
    }
    if sea != *boat.sea() {
        boat.set_sea(sea);
    }
}
