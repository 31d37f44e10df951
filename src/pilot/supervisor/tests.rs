//! The state machine under the conditions that matter at sea.

use super::*;
use crate::pilot::failsafe::{Failsafe, Trip};

const GUIDED_BY_PILOT: Policy = Policy {
    drive_mode: Mode::MANUAL,
    engage_mode: None,
    may_arm: false,
    end_mode: Mode::HOLD,
    shadow: false,
    limits: Limits { stale_s: 1.0, heartbeat_s: 3.0, mode_change_s: 3.0, arming_s: 30.0 },
};

fn good() -> Conditions {
    Conditions {
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
    }
}

fn engaged(policy: Policy) -> Supervisor {
    let mut supervisor = Supervisor::new(policy);
    supervisor.update(0.0, &good());
    assert_eq!(supervisor.state(), State::Ready);
    supervisor.request(0.0, Request::Engage { patient: false }, &good()).unwrap();
    supervisor.update(0.0, &good());
    assert_eq!((supervisor.state(), supervisor.duty()), (State::Engaged, Duty::Drive));
    supervisor
}

#[test]
fn does_nothing_unless_told_to() {
    let mut supervisor = Supervisor::new(GUIDED_BY_PILOT);
    for step in 0..1000 {
        let mut conditions = good();
        conditions.mode = Some(if step % 7 == 0 { Mode::HOLD } else { Mode::GUIDED });
        supervisor.update(f64::from(step), &conditions);
        assert_eq!(supervisor.duty(), Duty::Nothing);
        assert_eq!(supervisor.wanted_mode(&conditions), None);
        assert!(!supervisor.wants_arming(&conditions) && !supervisor.take_release());
    }
}

#[test]
fn the_pilot_takes_over_at_once() {
    let mut supervisor = engaged(GUIDED_BY_PILOT);
    supervisor.update(1.0, &Conditions { mode: Some(Mode::HOLD), ..good() });
    assert_eq!((supervisor.state(), supervisor.duty()), (State::Ready, Duty::Nothing));
    assert!(supervisor.take_release() && !supervisor.take_release());
    // Back in the drive mode: still nothing, until told again.
    supervisor.update(2.0, &good());
    assert_eq!(supervisor.duty(), Duty::Nothing);
}

#[test]
fn every_loss_ends_the_drive() {
    let trip = Trip { failsafe: Failsafe::PositionAge, action: Action::NeutralAndRelease, value: 3.1 };
    let losses = [
        (Conditions { heartbeat_age_s: 3.1, ..good() }, Duty::Nothing),
        (Conditions { armed: false, ..good() }, Duty::Nothing),
        (Conditions { rebooted: true, ..good() }, Duty::Nothing),
        (Conditions { trip: Some(trip), ..good() }, Duty::Neutral),
        (Conditions { mission_there: false, ..good() }, Duty::Neutral),
    ];
    for (conditions, duty) in losses {
        let mut supervisor = engaged(GUIDED_BY_PILOT);
        supervisor.update(1.0, &conditions);
        assert_eq!(supervisor.duty(), duty, "{conditions:?}");
        // Whatever happens next, it lets go in the end and does not drive again by itself.
        for step in 0..100 {
            supervisor.update(1.0 + f64::from(step) * 0.1, &good());
            assert_ne!(supervisor.duty(), Duty::Drive);
        }
        assert_eq!(supervisor.duty(), Duty::Nothing);
        assert!(supervisor.take_release());
    }
}

#[test]
fn a_short_gap_in_the_position_is_waited_out_with_motors_neutral() {
    let mut supervisor = engaged(GUIDED_BY_PILOT);
    supervisor.update(1.0, &Conditions { steady: false, ..good() });
    assert_eq!((supervisor.state(), supervisor.duty()), (State::Engaged, Duty::Neutral));
    supervisor.update(2.0, &good());
    assert_eq!(supervisor.duty(), Duty::Drive);
}

#[test]
fn a_refused_loiter_becomes_hold() {
    let mut supervisor = engaged(GUIDED_BY_PILOT);
    let trip = Some(Trip { failsafe: Failsafe::Fence, action: Action::HoldPosition, value: 1.0 });
    supervisor.update(1.0, &Conditions { trip, ..good() });
    assert_eq!(supervisor.wanted_mode(&good()), Some(Mode::LOITER));
    supervisor.update(4.1, &good());
    assert_eq!((supervisor.wanted_mode(&good()), supervisor.duty()), (Some(Mode::HOLD), Duty::Neutral));
    supervisor.update(4.5, &Conditions { mode: Some(Mode::HOLD), ..good() });
    assert_eq!((supervisor.state(), supervisor.duty()), (State::Holding, Duty::Nothing));
}

#[test]
fn the_mission_is_read_again_before_the_mode_is_changed() {
    let mut supervisor = Supervisor::new(GUIDED_BY_PILOT);
    let reading = Conditions { mode: Some(Mode::HOLD), mission_current: false, ..good() };
    supervisor.update(0.0, &good());
    supervisor.request(0.0, Request::Engage { patient: false }, &reading).unwrap();
    supervisor.update(5.0, &reading);
    assert_eq!((supervisor.state(), supervisor.wanted_mode(&reading)), (State::Engaging, None));
    let read = Conditions { mission_current: true, ..reading };
    supervisor.update(5.1, &read);
    assert_eq!(supervisor.wanted_mode(&read), Some(Mode::MANUAL));
    supervisor.update(5.2, &good());
    assert_eq!(supervisor.state(), State::Engaged);
}

#[test]
fn a_complete_mission_ends_in_hold() {
    let mut supervisor = engaged(GUIDED_BY_PILOT);
    let complete = Conditions { mission_complete: true, ..good() };
    supervisor.update(1.0, &complete);
    assert_eq!((supervisor.duty(), supervisor.wanted_mode(&complete)), (Duty::Neutral, Some(Mode::HOLD)));
    supervisor.update(1.2, &Conditions { mode: Some(Mode::HOLD), ..complete });
    assert_eq!(supervisor.state(), State::Finished);
    assert!(supervisor.take_release());
}

#[test]
fn a_pause_keeps_the_mission_and_resumes_when_told() {
    let mut supervisor = engaged(GUIDED_BY_PILOT);
    supervisor.request(1.0, Request::Pause, &good()).unwrap();
    assert_eq!(supervisor.duty(), Duty::Neutral);
    let held = Conditions { mode: Some(Mode::HOLD), ..good() };
    supervisor.update(1.1, &held);
    assert_eq!(supervisor.state(), State::Holding);
    supervisor.request(2.0, Request::Engage { patient: false }, &held).unwrap();
    assert_eq!(supervisor.wanted_mode(&held), Some(Mode::MANUAL));
    supervisor.update(2.1, &good());
    assert_eq!(supervisor.state(), State::Engaged);
}

#[test]
fn stopping_leaves_the_pilots_own_mode_alone() {
    let mut supervisor = engaged(GUIDED_BY_PILOT);
    supervisor.request(1.0, Request::Stop, &good()).unwrap();
    assert_eq!((supervisor.duty(), supervisor.wanted_mode(&good())), (Duty::Neutral, None));
    supervisor.update(1.1, &good());
    assert_eq!(supervisor.state(), State::Stopped);
    assert!(supervisor.take_release());
    assert!(supervisor.request(2.0, Request::Engage { patient: false }, &good()).is_err());
}

#[test]
fn stopping_does_not_leave_a_mode_behind_that_the_bridge_chose() {
    let mut supervisor = Supervisor::new(GUIDED_BY_PILOT);
    let hold = Conditions { mode: Some(Mode::HOLD), ..good() };
    supervisor.update(0.0, &hold);
    supervisor.request(0.0, Request::Engage { patient: false }, &hold).unwrap();
    supervisor.update(0.0, &hold);
    supervisor.update(0.1, &good());
    assert_eq!(supervisor.state(), State::Engaged);
    supervisor.request(1.0, Request::Stop, &good()).unwrap();
    assert_eq!(supervisor.wanted_mode(&good()), Some(Mode::HOLD));
}

#[test]
fn arms_only_where_allowed() {
    let disarmed = Conditions { armed: false, ..good() };
    let mut supervisor = Supervisor::new(GUIDED_BY_PILOT);
    supervisor.update(0.0, &disarmed);
    assert!(supervisor.request(0.0, Request::Engage { patient: false }, &disarmed).is_err());
    supervisor.request(0.0, Request::Engage { patient: true }, &disarmed).unwrap();
    supervisor.update(1.0, &disarmed);
    assert_eq!((supervisor.state(), supervisor.wants_arming(&disarmed)), (State::Ready, false));
    supervisor.update(2.0, &good());
    assert_eq!(supervisor.state(), State::Engaging);

    let mut supervisor = Supervisor::new(Policy { may_arm: true, ..GUIDED_BY_PILOT });
    supervisor.update(0.0, &disarmed);
    supervisor.request(0.0, Request::Engage { patient: false }, &disarmed).unwrap();
    assert!(supervisor.wants_arming(&disarmed));
    supervisor.update(31.0, &disarmed);
    assert_eq!(supervisor.state(), State::Ready, "gave up");
}

#[test]
fn says_that_it_waits_for_the_boat_to_be_armed() {
    let disarmed = Conditions { armed: false, ..good() };
    for (may_arm, reason) in [(false, Reason::UntilArmed), (true, Reason::AllThere)] {
        let mut supervisor = Supervisor::new(Policy { may_arm, ..GUIDED_BY_PILOT });
        supervisor.request(0.0, Request::Engage { patient: true }, &disarmed).unwrap();
        supervisor.update(0.0, &disarmed);
        let told = std::iter::from_fn(|| supervisor.poll_transition()).last().unwrap();
        assert_eq!((told.to, told.reason), (State::Ready, reason));
    }
}

#[test]
fn a_chosen_mode_engages_only_when_it_is_chosen() {
    let policy = Policy { drive_mode: Mode::GUIDED, engage_mode: Some(Mode::GUIDED), ..GUIDED_BY_PILOT };
    let guided = Conditions { mode: Some(Mode::GUIDED), ..good() };
    let mut supervisor = Supervisor::new(policy);
    supervisor.update(0.0, &guided);
    supervisor.update(1.0, &guided);
    assert_eq!(supervisor.state(), State::Ready, "found in the mode, not told to");
    supervisor.update(2.0, &good());
    supervisor.update(3.0, &guided);
    supervisor.update(3.1, &guided);
    assert_eq!(supervisor.state(), State::Engaged);
}

#[test]
fn transitions_are_reported_in_order() {
    let mut supervisor = engaged(GUIDED_BY_PILOT);
    supervisor.update(1.0, &Conditions { mode: Some(Mode::AUTO), ..good() });
    let reasons: Vec<Reason> =
        std::iter::from_fn(|| supervisor.poll_transition()).map(|t| t.reason).collect();
    let expected = [Reason::AllThere, Reason::ToldTo, Reason::InControl, Reason::PilotTookOver(Mode::AUTO)];
    assert_eq!(reasons, expected);
}
