//! What the bridge makes of what it is told: values that are no numbers, and delays that nobody tells it of.

use helmlink_sitl::faults::Fault;
use helmlink_wire::Message;
use helmlink_wire::dialect::{ATTITUDE_DATA, EKF_STATUS_REPORT_DATA, LOCAL_POSITION_NED_DATA, VFR_HUD_DATA};

use super::rig::*;
use crate::control::Controller;
use crate::pilot::supervisor::State;
use crate::vehicle::OutputKind;

type Spoil = fn(&mut Message) -> bool;

macro_rules! fields {
    ($($kind:ident $data:ident: $($field:ident)+;)+) => {
        /// Puts something that is no number into one field of a message; false for every other message.
        const FIELDS: &[(&str, Spoil)] = &[$($((
            concat!(stringify!($kind), ".", stringify!($field)),
            |message| match message {
                Message::$kind($data { $field, .. }) => {
                    *$field = f32::NAN;
                    true
                }
                _ => false,
            },
        ),)+)+];
    };
}

fields! {
    ATTITUDE ATTITUDE_DATA: roll pitch yaw rollspeed pitchspeed yawspeed;
    EKF_STATUS_REPORT EKF_STATUS_REPORT_DATA:
        velocity_variance pos_horiz_variance pos_vert_variance compass_variance terrain_alt_variance;
    LOCAL_POSITION_NED LOCAL_POSITION_NED_DATA: x y z vx vy vz;
    VFR_HUD VFR_HUD_DATA: airspeed groundspeed alt climb;
}

/// Every number in a steering frame is one, and within its range.
fn is_sound(message: &Message) -> bool {
    let pulse = |us: u16| us == 0 || us == u16::MAX || (1000..=2000).contains(&us);
    match message {
        Message::RC_CHANNELS_OVERRIDE(data) => pulse(data.chan1_raw) && pulse(data.chan3_raw),
        Message::MANUAL_CONTROL(data) => {
            // i16::MAX stands for an axis that is not used.
            [data.x, data.y, data.z, data.r].iter().all(|axis| axis.abs() <= 1000 || *axis == i16::MAX)
        }
        Message::SET_ATTITUDE_TARGET(data) => {
            data.thrust.abs() <= 1.0
                && data.body_yaw_rate.is_finite()
                && data.q.iter().all(|part| part.is_finite())
        }
        Message::SET_POSITION_TARGET_LOCAL_NED(data) => data.vx.is_finite() && data.yaw_rate.is_finite(),
        _ => false,
    }
}

#[test]
fn what_is_no_number_reaches_no_output() {
    for (number, (field, spoil)) in FIELDS.iter().enumerate() {
        for (index, controller) in Controller::ALL.into_iter().enumerate() {
            let output = OutputKind::ALL[(number + index) % OutputKind::ALL.len()];
            let mut rig =
                Rig::under_way(Setup::new(output, true), |settings| settings.controller = controller);
            // Not every message is sent unasked: the first attitude of each period becomes one of them.
            let mut count = 0;
            rig.tamper = Some(Box::new(move |message| {
                if let Message::ATTITUDE(data) = &*message {
                    count += 1;
                    let time_boot_ms = data.time_boot_ms;
                    if count % 5 == 0 {
                        *message = match field.split('.').next() {
                            Some("EKF_STATUS_REPORT") => Message::EKF_STATUS_REPORT(EKF_STATUS_REPORT_DATA {
                                flags: u16::MAX,
                                ..EKF_STATUS_REPORT_DATA::DEFAULT
                            }),
                            Some("LOCAL_POSITION_NED") => {
                                Message::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA {
                                    time_boot_ms,
                                    ..LOCAL_POSITION_NED_DATA::DEFAULT
                                })
                            }
                            Some("VFR_HUD") => Message::VFR_HUD(VFR_HUD_DATA::DEFAULT),
                            _ => message.clone(),
                        };
                        assert!(spoil(message), "{field}");
                    }
                }
                true
            }));
            let before = rig.steering.len();
            rig.run(1.0);
            let after = &rig.steering[before..];
            assert!(after.len() > 5, "{field}, {controller}, {output}: {} frames", after.len());
            for sent in after {
                assert!(is_sound(&sent.message), "{field}, {controller}: {:?}", sent.message);
            }
        }
    }
}

/// A boat on a zigzag whose commands and telemetry are late by so much in all, over a link that answers no TIMESYNC.
fn untold(delay_s: f64) -> Rig {
    let waypoints = vec![(20.0, 0.0), (45.0, 15.0), (70.0, 0.0), (95.0, 15.0), (120.0, 0.0), (400.0, 0.0)];
    let setup = Setup { waypoints, ..Setup::new(OutputKind::RcOverride, true) };
    let mut rig = Rig::new(setup, |_| {});
    rig.tamper = Some(Box::new(|message| !matches!(message, Message::TIMESYNC(_))));
    rig.arm_and_engage();
    rig.sitl.inject(Fault::LinkDelay { delay_s: 0.5 * delay_s, jitter_s: 0.0 }).unwrap();
    rig.run(110.0);
    assert_eq!(rig.state(), State::Engaged, "{:?}", rig.texts());
    rig
}

#[test]
fn a_delay_that_nobody_tells_is_found_out_and_predicted_across() {
    let status = untold(0.6).bridge().status();
    let answer = status.answer_delay.unwrap();
    println!("0.6 s untold: {answer:.3?}, predicted across {:.3} s", status.delay_s);
    // A boat that has rung saturates its thrusters: less exact than in a quiet drive.
    assert!((answer.delay_s - 0.6).abs() < 0.2, "{answer:?}");
    assert_eq!(status.delay_s, answer.delay_s);
}

#[test]
fn a_boat_that_rings_too_much_tells_nothing_rather_than_something_wrong() {
    let status = untold(1.0).bridge().status();
    println!("1 s untold: {:.3?}", status.answer_delay);
    assert!(status.answer_delay.is_none_or(|answer| (answer.delay_s - 1.0).abs() < 0.2), "{status:?}");
}

#[test]
fn a_delay_that_is_told_is_left_as_it_is() {
    let mut rig = Rig::under_way(Setup::new(OutputKind::RcOverride, true), |_| {});
    rig.sitl.inject(Fault::LinkDelay { delay_s: 0.2, jitter_s: 0.0 }).unwrap();
    rig.run(60.0);
    let status = rig.bridge().status();
    assert!((status.delay_s - 0.4).abs() < 0.05, "{:?}", status.delay_s);
}
