//! Every state under every event: the whole table, written out.

use super::*;
use crate::pilot::failsafe::{Failsafe, Trip};

const POLICY: Policy = Policy {
    drive_mode: Mode::MANUAL,
    engage_mode: Some(Mode::GUIDED),
    may_arm: false,
    end_mode: Mode::HOLD,
    shadow: false,
    limits: Limits { stale_s: 1.0, heartbeat_s: 3.0, mode_change_s: 3.0, arming_s: 30.0 },
};

const GOOD: Conditions = Conditions {
    heartbeat_age_s: 0.1,
    steady: true,
    mode: Some(Mode::MANUAL),
    armed: true,
    rebooted: false,
    mission_there: true,
    mission_current: true,
    output_ready: true,
    mission_complete: false,
    trip: None,
};

/// What can happen to a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Event {
    Nothing,
    LinkLost,
    Rebooted,
    OtherMode,
    EngageMode,
    Disarmed,
    Unsteady,
    NoMission,
    MissionBeingRead,
    NoParameters,
    Complete,
    Trip(Action),
    TimePasses,
    Engage,
    EngagePatiently,
    Pause,
    LetGo,
    Stop,
}

use Event::*;

const EVENTS: [Event; 22] = [
    Nothing,
    LinkLost,
    Rebooted,
    OtherMode,
    EngageMode,
    Disarmed,
    Unsteady,
    NoMission,
    MissionBeingRead,
    NoParameters,
    Complete,
    Trip(Action::LetGo),
    Trip(Action::NeutralAndRelease),
    Trip(Action::HoldPosition),
    Trip(Action::ReturnToLaunch),
    TimePasses,
    Engage,
    EngagePatiently,
    Pause,
    LetGo,
    Stop,
    Trip(Action::Warn),
];

/// A machine in the wanted state, reached as it is reached at sea, and the time it is there.
fn machine(state: State) -> Supervisor {
    let policy = Policy { shadow: state == State::Shadow, ..POLICY };
    let mut machine = Supervisor::new(policy);
    let conditions = |lack| match lack {
        Lack::Vehicle => Conditions { heartbeat_age_s: f64::INFINITY, mode: None, ..GOOD },
        Lack::Parameters => Conditions { output_ready: false, ..GOOD },
        Lack::Mission => Conditions { mission_there: false, ..GOOD },
        Lack::Position => Conditions { steady: false, ..GOOD },
    };
    if let State::Waiting(lack) = state {
        machine.update(0.0, &conditions(lack));
        return machine;
    }
    machine.update(0.0, &GOOD);
    if matches!(state, State::Ready | State::Shadow) {
        return machine;
    }
    machine.request(0.0, Request::Engage { patient: false }, &GOOD).unwrap();
    let hold = Conditions { mode: Some(Mode::HOLD), ..GOOD };
    if state == State::Engaging {
        machine.update(0.0, &hold);
        return machine;
    }
    machine.update(0.0, &GOOD);
    match state {
        State::HandingBack | State::Holding => machine.request(0.0, Request::Pause, &GOOD).unwrap(),
        State::Finished => machine.update(0.0, &Conditions { mission_complete: true, ..GOOD }),
        State::Stopped => machine.request(0.0, Request::LetGo, &GOOD).unwrap(),
        _ => {}
    }
    if !matches!(state, State::Engaged | State::HandingBack) {
        machine.update(0.0, if state == State::Stopped { &GOOD } else { &hold });
    }
    machine
}

/// The conditions that each state is found in when nothing happens.
fn usual(state: State) -> Conditions {
    match state {
        State::Waiting(Lack::Vehicle) => Conditions { heartbeat_age_s: f64::INFINITY, mode: None, ..GOOD },
        State::Waiting(Lack::Parameters) => Conditions { output_ready: false, ..GOOD },
        State::Waiting(Lack::Mission) => Conditions { mission_there: false, ..GOOD },
        State::Waiting(Lack::Position) => Conditions { steady: false, ..GOOD },
        State::Engaging | State::Holding | State::Finished => Conditions { mode: Some(Mode::HOLD), ..GOOD },
        _ => GOOD,
    }
}

fn apply(machine: &mut Supervisor, event: Event) -> Conditions {
    let usual = usual(machine.state());
    let trip = |action| Some(super::every_event::Trip { failsafe: Failsafe::Fence, action, value: 3.0 });
    let conditions = match event {
        LinkLost => Conditions { heartbeat_age_s: 9.0, ..usual },
        Rebooted => Conditions { rebooted: true, steady: false, output_ready: false, ..usual },
        OtherMode => Conditions { mode: Some(Mode::AUTO), ..usual },
        EngageMode => Conditions { mode: Some(Mode::GUIDED), ..usual },
        Disarmed => Conditions { armed: false, ..usual },
        Unsteady => Conditions { steady: false, ..usual },
        NoMission => Conditions { mission_there: false, ..usual },
        MissionBeingRead => Conditions { mission_current: false, ..usual },
        NoParameters => Conditions { output_ready: false, ..usual },
        Complete => Conditions { mission_complete: true, ..usual },
        Event::Trip(action) => Conditions { trip: trip(action).filter(|_| action != Action::Warn), ..usual },
        _ => usual,
    };
    let now_s = if event == TimePasses { 40.0 } else { 0.5 };
    let request = match event {
        Engage => Some(Request::Engage { patient: false }),
        EngagePatiently => Some(Request::Engage { patient: true }),
        Pause => Some(Request::Pause),
        LetGo => Some(Request::LetGo),
        Stop => Some(Request::Stop),
        _ => None,
    };
    if let Some(request) = request {
        machine.request(now_s, request, &conditions).ok();
    } else {
        machine.update(now_s, &conditions);
    }
    conditions
}

/// Where each event leads from each state; what is not listed stays where it is.
fn expected(state: State, event: Event) -> State {
    use State::*;
    let waiting = |lack| Waiting(lack);
    match (state, event) {
        // Asked to end: always obeyed, by way of neutral where the boat is being driven.
        (Engaging | Engaged, Event::LetGo | Event::Stop | Event::Pause) => HandingBack,
        (HandingBack, Event::LetGo | Event::Stop) => HandingBack,
        (_, Event::LetGo | Event::Stop) => Stopped,
        // Asked to drive: only from where everything is there.
        (Ready | Holding | Finished | Stopped, Engage | EngagePatiently) => Engaging,
        (Ready | Holding | Finished, EngageMode) => Engaging,
        // Nobody there, or somebody else in command: at once.
        (Ready | Shadow | Holding | Finished | Engaging | Engaged, LinkLost) => waiting(Lack::Vehicle),
        (Waiting(_), LinkLost) => waiting(Lack::Vehicle),
        (Engaging | Engaged, Rebooted) => waiting(Lack::Position),
        (Engaging | Engaged, Disarmed) => Ready,
        (Engaged, OtherMode | EngageMode) => Ready,
        // A restart makes the parameters unknown.
        (Ready | Shadow, Rebooted | NoParameters) => waiting(Lack::Parameters),
        (Engaging, NoParameters) => waiting(Lack::Parameters),
        (Waiting(Lack::Mission | Lack::Position | Lack::Parameters), Rebooted | NoParameters) => {
            waiting(Lack::Parameters)
        }
        (Waiting(Lack::Mission | Lack::Position), NoMission) => waiting(Lack::Mission),
        (Waiting(Lack::Position), MissionBeingRead) => waiting(Lack::Mission),
        (Ready | Shadow | Engaging, NoMission) => waiting(Lack::Mission),
        (Ready | Shadow, MissionBeingRead) => waiting(Lack::Mission),
        // The end of a drive.
        (Engaged, NoMission | Complete) => HandingBack,
        (Engaged, Event::Trip(Action::LetGo)) => Ready,
        (Engaged, Event::Trip(Action::Warn)) => Engaged,
        (Engaged, Event::Trip(_)) => HandingBack,
        (Engaging, Event::Trip(action)) if action != Action::Warn => Ready,
        (Engaging, TimePasses) => Ready,
        // The flight controller is gone, in another mode, or does not answer: the boat is let go.
        (HandingBack, LinkLost | Rebooted | OtherMode | EngageMode | Disarmed | TimePasses) => Holding,
        (state, _) => state,
    }
}

#[test]
fn every_event_in_every_state_leads_where_it_should() {
    for state in State::ALL {
        for event in EVENTS {
            let mut machine = machine(state);
            assert_eq!(machine.state(), state, "the machine can be brought there");
            let conditions = apply(&mut machine, event);
            assert_eq!(machine.state(), expected(state, event), "{state:?} under {event:?}");
            check_promises(&mut machine, &conditions, state, event);
        }
    }
}

/// What must hold whatever happens.
fn check_promises(machine: &mut Supervisor, conditions: &Conditions, before: State, event: Event) {
    let case = format!("{before:?} under {event:?}");
    let after = machine.state();
    let drives = machine.duty() == Duty::Drive;
    let is_told = matches!(event, Engage | EngagePatiently | EngageMode);
    assert!(!drives || before == State::Engaged, "{case}: nothing drives that did not before");
    assert!(!drives || conditions.steady, "{case}: never on an old position");
    assert!(after != State::Engaging || before == State::Engaging || is_told, "{case}: only when told");
    assert!(!machine.wants_arming(conditions), "{case}: never arms unless allowed");
    let is_idle = !matches!(after, State::Engaging | State::HandingBack);
    assert!(!is_idle || machine.wanted_mode(conditions).is_none(), "{case}: leaves the mode alone");
    if before == State::Engaged && !matches!(after, State::Engaged | State::HandingBack) {
        assert!(machine.take_release(), "{case}: lets go of what it held");
    }
    let transition = std::iter::from_fn(|| machine.poll_transition()).last();
    if before != after {
        let transition = transition.unwrap_or_else(|| panic!("{case}: says why"));
        assert_eq!(transition.to, after);
        assert!(!transition.describe().is_empty());
    }
}

#[test]
fn after_any_three_events_a_machine_told_to_stop_ends_up_letting_go() {
    for first in EVENTS {
        for second in EVENTS {
            for third in EVENTS {
                let mut machine = machine(State::Engaged);
                for event in [first, second, third] {
                    apply(&mut machine, event);
                }
                machine.request(41.0, Request::Stop, &GOOD).unwrap();
                for step in 0..100 {
                    machine.update(41.0 + f64::from(step) * 0.1, &GOOD);
                }
                let case = format!("{first:?}, {second:?}, {third:?}");
                assert_eq!((machine.state(), machine.duty()), (State::Stopped, Duty::Nothing), "{case}");
                let again = machine.request(60.0, Request::Engage { patient: true }, &GOOD);
                assert!(again.is_err(), "{case}: stopped for good");
            }
        }
    }
}

#[test]
fn a_shadow_never_engages() {
    let mut machine = machine(State::Shadow);
    for patient in [false, true] {
        assert!(machine.request(0.5, Request::Engage { patient }, &GOOD).is_err());
    }
    for step in 0..50 {
        let mode = if step % 2 == 0 { Mode::GUIDED } else { Mode::MANUAL };
        machine.update(f64::from(step), &Conditions { mode: Some(mode), ..GOOD });
        assert_eq!((machine.state(), machine.duty()), (State::Shadow, Duty::Nothing));
    }
}
