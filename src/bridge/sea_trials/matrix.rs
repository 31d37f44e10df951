//! The fault matrix: every failsafe × every action it may have × every output × with and without a radio receiver.

use helmlink_mission::protocol::MissionType;
use helmlink_sitl::faults::{Fault, Thrusters};
use helmlink_wire::{Message, enums};

use super::rig::*;
use crate::pilot::failsafe::{Action, DEFINITIONS, Failsafe};
use crate::pilot::supervisor::State;
use crate::vehicle::streams::command_long;
use crate::vehicle::{Mode, OutputKind};

/// Limits short enough for a test, where the default is long.
fn limit(failsafe: Failsafe) -> Option<f64> {
    match failsafe {
        Failsafe::CrossTrack => Some(2.0),
        Failsafe::NoProgress => Some(5.0),
        Failsafe::Saturated => Some(1.0),
        Failsafe::GroundStation => Some(2.0),
        _ => None,
    }
}

/// Time from the fault to the bridge's decision, at most, seconds.
pub(super) fn decision_s(failsafe: Failsafe) -> f64 {
    let limit_s = match failsafe {
        Failsafe::CrossTrack | Failsafe::PositionJump | Failsafe::Fence | Failsafe::Battery => 0.0,
        _ => limit(failsafe).unwrap_or(failsafe.definition().limit),
    };
    limit_s
        + match failsafe {
            // The boat has to get there first, or to lose its way.
            Failsafe::Fence => 25.0,
            Failsafe::NoProgress | Failsafe::Saturated => 15.0,
            // What was changed is told at once, or read within five seconds.
            Failsafe::OutputRefused => 6.0,
            // Told once a second.
            Failsafe::Battery | Failsafe::GroundStation => 2.5,
            // It is silent while it starts.
            Failsafe::Rebooted => 4.5,
            _ => 0.6,
        }
}

fn tampered(change: impl FnMut(&mut Message) -> bool + 'static) -> Option<Tamper> {
    Some(Box::new(change))
}

/// Makes it go wrong.
pub(super) fn break_it(rig: &mut Rig, failsafe: Failsafe) {
    match failsafe {
        Failsafe::LinkLost => rig.cut = true,
        Failsafe::Rebooted => rig.sitl.inject(Fault::Reboot).unwrap(),
        Failsafe::ModeChanged => rig.choose(Mode::HOLD),
        Failsafe::Disarmed => {
            rig.say(&command_long(VEHICLE, enums::MAV_CMD_COMPONENT_ARM_DISARM, [0.0, 21196.0, 0.0]));
        }
        Failsafe::PositionAge => {
            rig.tamper = tampered(|message| !matches!(message, Message::GLOBAL_POSITION_INT(_)));
        }
        Failsafe::HeadingAge => {
            rig.tamper = tampered(|message| !matches!(message, Message::ATTITUDE(_)));
        }
        Failsafe::Estimator => {
            rig.tamper = tampered(|message| {
                if let Message::EKF_STATUS_REPORT(data) = message {
                    data.flags = enums::EKF_CONST_POS_MODE;
                }
                true
            });
        }
        Failsafe::NotANumber => {
            rig.tamper = tampered(|message| {
                if let Message::ATTITUDE(data) = message {
                    data.yaw = f32::NAN;
                }
                true
            });
        }
        // Some 30 m to the north.
        Failsafe::PositionJump => rig.tamper = tampered(|message| move_by(message, 2700, 0)),
        // Some 5 m to the east.
        Failsafe::CrossTrack => rig.tamper = tampered(|message| move_by(message, 0, 1000)),
        Failsafe::GroundStation => rig.station_talks = false,
        Failsafe::Battery => {
            rig.tamper = tampered(|message| {
                if let Message::SYS_STATUS(data) = message {
                    data.battery_remaining = 7;
                }
                true
            });
        }
        Failsafe::NoProgress | Failsafe::Saturated => {
            rig.sitl.inject(Fault::ThrusterWeak { which: Thrusters::All, share: 0.0 }).unwrap();
        }
        Failsafe::LoopLate => {
            let mut left = 60;
            rig.tamper = tampered(move |message| {
                let is_hers = matches!(message, Message::ATTITUDE(_) | Message::GLOBAL_POSITION_INT(_));
                left -= i32::from(is_hers && left > 0);
                !(is_hers && left > 0)
            });
        }
        Failsafe::Recording => {
            let now = rig.now;
            rig.bridge().set_recording_failed(now, true);
        }
        // Somebody takes the right to override.
        Failsafe::OutputRefused => rig.set_parameter("SYSID_MYGCS", 42.0),
        // Its fence ends ahead of the boat: it only has to go on.
        Failsafe::Fence => {}
    }
}

fn move_by(message: &mut Message, north_e7: i32, east_e7: i32) -> bool {
    if let Message::GLOBAL_POSITION_INT(data) = message {
        data.lat += north_e7;
        data.lon += east_e7;
    }
    true
}

/// A boat under way, ready for this fault.
pub(super) fn rig(failsafe: Failsafe, action: Action, setup: Setup) -> Rig {
    let mut rig = Rig::new(setup, |settings| {
        let rule = settings.failsafes.rule_mut(failsafe);
        (rule.limit, rule.action) = (limit(failsafe), Some(action));
        if failsafe == Failsafe::Saturated {
            // Asks for all there is when the boat does not answer.
            settings.boat.control.surge.reaching_gain = 3.0;
        }
    });
    if failsafe == Failsafe::Fence {
        rig.run(2.5);
        let corners = [(12.0, 50.0), (12.0, -50.0), (-50.0, -50.0), (-50.0, 50.0)];
        let mut fence = items(&corners);
        for item in &mut fence {
            item.command = enums::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION;
            item.params[0] = 4.0;
        }
        rig.upload(MissionType::Fence, fence);
    }
    rig.arm_and_engage();
    rig.run(3.0);
    assert_eq!(rig.state(), State::Engaged, "{:?}", rig.texts());
    rig
}

/// What went otherwise than it should.
fn check(failsafe: Failsafe, action: Action, output: OutputKind, receiver: bool) -> Result<(), String> {
    let mut rig = rig(failsafe, action, Setup::new(output, receiver));
    let broken_at = rig.now;
    break_it(&mut rig, failsafe);
    if action == Action::Warn {
        return check_warning(&mut rig, failsafe, broken_at);
    }
    let decided = rig.run_until(decision_s(failsafe), |rig| rig.state() != State::Engaged);
    let said = rig.texts().join("; ");
    let must = |is_so: bool, what: &str| if is_so { Ok(()) } else { Err(format!("{what}: {said}")) };
    must(decided, "does not decide in time")?;
    let last = rig.steering.last().map(|sent| sent.message.clone());
    let is_calm = last.as_ref().is_some_and(|last| is_neutral(last) || is_release(last));
    must(is_calm || (action == Action::LetGo && !output.uses_sticks()), "is not neutral at once")?;
    // The mode may have to be refused first.
    must(rig.run_until(8.0, |rig| rig.state() != State::HandingBack), "does not let go")?;
    rig.run(1.2);
    let silent_since = rig.now;
    rig.run(2.0);
    must(rig.steering.iter().all(|sent| sent.at <= silent_since), "sends after letting go")?;
    let released = rig.steering.last().is_some_and(|sent| is_release(&sent.message));
    must(released || !output.uses_sticks(), "does not release its override")?;
    let mode = match action {
        Action::NeutralAndRelease => Some(Mode::HOLD),
        Action::HoldPosition => Some(Mode::LOITER),
        Action::ReturnToLaunch => Some(Mode::RTL),
        Action::LetGo | Action::Warn => None,
    };
    must(mode.is_none_or(|mode| rig.mode == mode), &format!("leaves the boat in {}", rig.mode))?;
    let holds = rig.state() == State::Holding || action != Action::HoldPosition;
    must(holds, &format!("is {:?} and not holding", rig.state()))
}

fn check_warning(rig: &mut Rig, failsafe: Failsafe, broken_at: std::time::Duration) -> Result<(), String> {
    let says = failsafe.describe(1.0);
    // The words before the figure.
    let head = says.split('1').next().unwrap_or_default().trim().to_owned();
    let told = rig.run_until(decision_s(failsafe), |rig| {
        rig.events.iter().any(|(at, event)| {
            *at >= broken_at && event.severity == enums::MAV_SEVERITY_WARNING && event.text.contains(&head)
        })
    });
    rig.run(0.5);
    match (told, rig.state()) {
        (true, State::Engaged) => Ok(()),
        (told, state) => Err(format!("told {told}, {state:?}: {}", rig.texts().join("; "))),
    }
}

fn check_output(output: OutputKind) {
    let mut faults = Vec::new();
    for definition in &DEFINITIONS {
        for &action in definition.allowed {
            // Setpoints are taken from whoever sends them.
            if definition.failsafe == Failsafe::OutputRefused && !output.uses_sticks() {
                continue;
            }
            for receiver in [true, false] {
                if let Err(fault) = check(definition.failsafe, action, output, receiver) {
                    let receiver = if receiver { "receiver" } else { "no receiver" };
                    faults.push(format!("{}, {action}, {output}, {receiver}: {fault}", definition.key));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

// One test an output, so that they run side by side.

#[test]
fn every_fault_ends_as_it_should_with_overrides() {
    check_output(OutputKind::RcOverride);
}

#[test]
fn every_fault_ends_as_it_should_with_manual_control() {
    check_output(OutputKind::ManualControl);
}

#[test]
fn every_fault_ends_as_it_should_in_guided() {
    check_output(OutputKind::Guided);
}

#[test]
fn every_fault_ends_as_it_should_in_guided_with_velocities() {
    check_output(OutputKind::GuidedVelocity);
}
