//! A scenario under way.

use std::time::Duration;

use super::{Event, Happening, Observation, Scenario, ScenarioClock, Verdict};
use crate::Sitl;
use crate::physics::{Hull, Sea};

/// A boat that scenarios can be played with.
pub(crate) trait Stage {
    /// Simulated time since the start.
    fn now(&self) -> Duration;
    fn is_armed(&self) -> bool;
    fn hull(&self) -> &Hull;
    fn sea(&self) -> &Sea;
    fn set_sea(&mut self, sea: Sea);
    /// Anything but a change of the sea.
    fn happen(&mut self, what: &Happening);
    fn observe(&self) -> Observation;
}

/// A scenario with how far it is.
#[derive(Debug, Clone)]
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
    pub(crate) fn step(&mut self, boat: &mut impl Stage) {
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
    pub(crate) fn end(&mut self, boat: &impl Stage) {
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

fn happen(boat: &mut impl Stage, what: &Happening) {
    let mut sea = *boat.sea();
    match what {
        Happening::Sea(state) => sea = Sea { depth_m: sea.depth_m, ..Sea::preset(*state, boat.hull()) },
        Happening::Current(current) => sea.current = Some(*current),
        Happening::Wind(wind) => sea.wind = Some(*wind),
        Happening::Waves(waves) => sea.waves = Some(*waves),
        Happening::DepthM(depth_m) => sea.depth_m = Some(*depth_m),
        other => boat.happen(other),
    }
    if sea != *boat.sea() {
        boat.set_sea(sea);
    }
}

impl Stage for Sitl {
    fn now(&self) -> Duration {
        self.now()
    }

    fn is_armed(&self) -> bool {
        self.is_armed()
    }

    fn hull(&self) -> &Hull {
        self.hull()
    }

    fn sea(&self) -> &Sea {
        self.sea()
    }

    fn set_sea(&mut self, sea: Sea) {
        self.set_sea(sea);
    }

    fn happen(&mut self, what: &Happening) {
        match what {
            Happening::Fail(fault) => self.autopilot.put_fault(fault),
            Happening::Repair(fault) => self.autopilot.lift_fault(fault),
            Happening::Parameter { name, value } => self.autopilot.set_known_parameter(name, *value),
            Happening::Arm => {
                self.autopilot.arm(false);
            }
            Happening::Disarm => self.autopilot.disarm(),
            Happening::Mode(number) => self.autopilot.order_mode(*number),
            Happening::Sea(_)
            | Happening::Current(_)
            | Happening::Wind(_)
            | Happening::Waves(_)
            | Happening::DepthM(_) => {}
        }
    }

    fn observe(&self) -> Observation {
        self.observe()
    }
}
