//! What can be wrong with the boat itself: its GPS, its compass, its rudder, its thrusters.

use super::actuators::{ActuatorCommand, ActuatorState};
use super::dynamics::NedVector;
use super::hull::{Hull, HullDynamics, Propulsion};

/// Faults of sensors and actuators. The default is a sound boat.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VesselFaults {
    /// The GPS receiver.
    pub gps: GpsFaults,
    /// Error of the compass on top of its own, positive to starboard, rad.
    pub compass_offset_rad: f64,
    /// The rudder, or the leg of an outboard.
    pub rudder: ActuatorFault,
    /// The left (or only) and the right thruster.
    pub thrusters: [ActuatorFault; 2],
}

/// Faults of the GPS receiver.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GpsFaults {
    /// It has no fix.
    pub lost: bool,
    /// It repeats its last fix.
    pub frozen: bool,
    /// Its position is off by this, m.
    pub jump_m: NedVector,
    /// Its position runs away at this speed, m/s; back at once when the fault is lifted.
    pub drift_mps: NedVector,
}

/// What is wrong with one actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActuatorFault {
    /// It no longer moves.
    pub stuck: Option<Stuck>,
    /// Share of its effect that is left: 1 all, 0 none.
    pub share: f64,
}

/// Where an actuator is stuck.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stuck {
    /// Where it was when the fault began.
    WhereItIs,
    /// At this command, [−1, 1].
    At(f64),
}

impl Default for ActuatorFault {
    fn default() -> Self {
        Self { stuck: None, share: 1.0 }
    }
}

impl VesselFaults {
    /// Whether rudder and thrusters do as they are told.
    fn actuators_are_sound(&self) -> bool {
        let sound = ActuatorFault::default();
        self.rudder == sound && self.thrusters == [sound; 2]
    }
}

/// The faults of one boat at work.
#[derive(Debug, Clone, Default)]
pub(super) struct FaultyBoat {
    pub(super) faults: VesselFaults,
    /// Throttle and steering, or left and right thruster, when the faults were set.
    held: (f64, f64),
    last: Option<ActuatorCommand>,
    /// Whether rudder or thrusters do not do as they are told.
    impaired: bool,
}

impl FaultyBoat {
    /// Sets the faults of a boat whose actuators are at `state`. What was stuck already stays where it was.
    pub(super) fn set(&mut self, faults: VesselFaults, hull: &Hull, state: ActuatorState) {
        let before = std::mem::replace(&mut self.faults, faults);
        self.impaired = !faults.actuators_are_sound();
        let now = self.position(hull, state);
        let is_twin = hull.has_twin_thrusters();
        let second =
            if is_twin { (before.thrusters[1], faults.thrusters[1]) } else { (before.rudder, faults.rudder) };
        if is_new(before.thrusters[0], faults.thrusters[0]) {
            self.held.0 = now.0;
        }
        if is_new(second.0, second.1) {
            self.held.1 = now.1;
        }
    }

    /// What the actuators do when they are told `command`.
    pub(super) fn effective(&mut self, hull: &Hull, command: ActuatorCommand) -> ActuatorCommand {
        let effective = if self.impaired { self.faulty(hull, command) } else { command };
        self.last = Some(effective);
        effective
    }

    fn faulty(&self, hull: &Hull, command: ActuatorCommand) -> ActuatorCommand {
        let [first, second] = self.faults.thrusters;
        if hull.has_twin_thrusters() {
            let (left, right) = command.left_right();
            return ActuatorCommand::TwinThrusters {
                left: at(first, left, self.held.0, share_of_revolutions(hull, first.share)),
                right: at(second, right, self.held.1, share_of_revolutions(hull, second.share)),
            };
        }
        let (throttle, steering) = command.throttle_steering();
        ActuatorCommand::ThrottleSteering {
            throttle: at(first, throttle, self.held.0, share_of_revolutions(hull, first.share)),
            steering: at(self.faults.rudder, steering, self.held.1, self.faults.rudder.share),
        }
    }

    /// Where the actuators are, as commands.
    fn position(&self, hull: &Hull, state: ActuatorState) -> (f64, f64) {
        let last = self.last.unwrap_or(ActuatorCommand::NEUTRAL);
        match (state, &hull.dynamics) {
            (
                ActuatorState::ThrottleSteering { throttle, steering_rad },
                HullDynamics::Maneuvering(
                    _,
                    Propulsion::PropellerRudder(drive) | Propulsion::Outboard(drive),
                ),
            ) => (throttle, steering_rad / drive.steering_limit_rad),
            (ActuatorState::ThrottleSteering { .. }, _) => last.throttle_steering(),
            (ActuatorState::TwinThrusters { .. }, _) => last.left_right(),
        }
    }
}

fn is_new(before: ActuatorFault, now: ActuatorFault) -> bool {
    now.stuck.is_some() && before.stuck.is_none()
}

fn at(fault: ActuatorFault, wanted: f64, held: f64, share: f64) -> f64 {
    match fault.stuck {
        Some(Stuck::WhereItIs) => held,
        Some(Stuck::At(position)) => position,
        None => wanted * share,
    }
}

/// Thrust grows with the square of the revolutions, save on the kinematic motor boat.
fn share_of_revolutions(hull: &Hull, share_of_thrust: f64) -> f64 {
    match hull.dynamics {
        HullDynamics::Maneuvering(..) => share_of_thrust.max(0.0).sqrt(),
        HullDynamics::Motorboat(_) => share_of_thrust,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Pose, Sea, SensorSettings, Vessel};
    use super::*;

    const AHEAD: ActuatorCommand = ActuatorCommand::ThrottleSteering { throttle: 0.6, steering: 0.0 };
    const STARBOARD: ActuatorCommand = ActuatorCommand::ThrottleSteering { throttle: 0.6, steering: 0.5 };

    fn vessel(name: &str, sensors: &SensorSettings) -> Vessel {
        Vessel::new(Hull::builtin(name).unwrap(), &Sea::default(), sensors, 1, Pose::default())
    }

    fn run(vessel: &mut Vessel, seconds: u32, command: ActuatorCommand) {
        (0..seconds * 100).for_each(|_| vessel.step(0.01, command));
    }

    #[test]
    fn a_stuck_rudder_stays_where_it_was_and_then_obeys_again() {
        for name in ["skiff", "monohull38", "motorboat"] {
            let mut boat = vessel(name, &SensorSettings::perfect());
            run(&mut boat, 30, STARBOARD);
            let stuck = ActuatorFault { stuck: Some(Stuck::WhereItIs), share: 1.0 };
            boat.set_faults(VesselFaults { rudder: stuck, ..VesselFaults::default() });
            run(&mut boat, 30, AHEAD);
            assert!(boat.truth().hull.r_radps > 0.01, "{name}: {:?}", boat.truth().hull);
            boat.set_faults(VesselFaults::default());
            run(&mut boat, 60, AHEAD);
            assert!(boat.truth().hull.r_radps.abs() < 0.01, "{name}: {:?}", boat.truth().hull);
        }
    }

    #[test]
    fn a_weak_thruster_pulls_the_boat_to_its_side_and_a_dead_one_more() {
        let turn = |share: f64| {
            let mut boat = vessel("otter", &SensorSettings::perfect());
            let weak = ActuatorFault { stuck: None, share };
            boat.set_faults(VesselFaults {
                thrusters: [weak, ActuatorFault::default()],
                ..Default::default()
            });
            run(&mut boat, 30, AHEAD);
            boat.truth().hull.r_radps
        };
        assert!(turn(1.0).abs() < 1e-9);
        assert!(turn(0.5) < -0.02 && turn(0.0) < 1.3 * turn(0.5), "{} {}", turn(0.5), turn(0.0));
    }

    #[test]
    fn half_the_thrust_is_left_of_a_weak_propeller() {
        for name in ["skiff", "motorboat"] {
            let full = ActuatorCommand::ThrottleSteering { throttle: 1.0, steering: 0.0 };
            let top = |share: f64| {
                let mut boat = vessel(name, &SensorSettings::perfect());
                let weak = ActuatorFault { stuck: None, share };
                boat.set_faults(VesselFaults { thrusters: [weak; 2], ..Default::default() });
                run(&mut boat, 120, full);
                boat.truth().u_r_mps
            };
            // Drag grows with the speed or with its square.
            let ratio = top(0.5) / top(1.0);
            assert!((0.45..0.85).contains(&ratio), "{name}: {ratio}");
        }
    }

    #[test]
    fn gps_faults_show_in_the_estimate_with_any_sensors() {
        for sensors in [SensorSettings::perfect(), SensorSettings::typical()] {
            let mut boat = vessel("otter", &sensors);
            run(&mut boat, 20, AHEAD);
            let error = |boat: &Vessel| {
                let (truth, estimate) = (boat.truth().hull, boat.estimate());
                (estimate.north_m - truth.north_m, estimate.east_m - truth.east_m)
            };
            let jump_m = NedVector { north: 0.0, east: 20.0 };
            boat.set_faults(VesselFaults {
                gps: GpsFaults { jump_m, ..Default::default() },
                ..Default::default()
            });
            run(&mut boat, 20, AHEAD);
            assert!((error(&boat).1 - 20.0).abs() < 1.0, "{:?}", error(&boat));
            let drift_mps = NedVector { north: 0.5, east: 0.0 };
            boat.set_faults(VesselFaults {
                gps: GpsFaults { drift_mps, ..Default::default() },
                ..Default::default()
            });
            run(&mut boat, 40, AHEAD);
            // The velocity that the GPS reports stays right, so the estimate follows with a lag.
            assert!((15.0..21.0).contains(&error(&boat).0), "{:?}", error(&boat));
            boat.set_faults(VesselFaults::default());
            run(&mut boat, 30, AHEAD);
            boat.set_faults(VesselFaults {
                gps: GpsFaults { frozen: true, ..Default::default() },
                ..Default::default()
            });
            run(&mut boat, 20, AHEAD);
            assert!(error(&boat).0 < -10.0, "{:?}", error(&boat));
            assert!(boat.estimate().has_gps);
            boat.set_faults(VesselFaults::default());
            run(&mut boat, 30, AHEAD);
            assert!(error(&boat).0.hypot(error(&boat).1) < 1.0, "{:?}", error(&boat));
        }
    }

    #[test]
    fn the_compass_can_be_off() {
        for sensors in [SensorSettings::perfect(), SensorSettings::typical()] {
            let mut boat = vessel("otter", &sensors);
            boat.set_faults(VesselFaults { compass_offset_rad: 0.3, ..Default::default() });
            run(&mut boat, 30, ActuatorCommand::NEUTRAL);
            let error = boat.estimate().psi_rad - boat.truth().hull.psi_rad;
            assert!((error - 0.3).abs() < 0.03, "{error}");
        }
    }
}
