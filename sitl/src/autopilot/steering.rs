//! The innermost controllers: turn rate to steering, speed to throttle.
//!
//! Both are a feed forward with proportional and integral action on top. Their gains are parameters; the
//! defaults come from a trial of the hull (see [`crate::trial`]).

use super::motion::{Demand, Motion};
use super::parameters::*;

/// Below this share of the cruise speed a rudder is no longer given more deflection for the same turn rate.
const LEAST_SPEED_SHARE: f64 = 0.3;
/// Way astern, as a share of the cruise speed, from which on a rudder works the other way round.
const ASTERN_SHARE: f64 = 0.05;

/// A boat brakes down to this share of ATC_STOP_SPEED, and again once it makes more than the whole of it.
const LET_GO_SHARE: f64 = 0.3;

/// Turn-rate and speed controller.
#[derive(Debug, Clone, Default)]
pub(super) struct Steering {
    rate_integral: f64,
    speed_integral: f64,
    last_rate_radps: f64,
    /// The speed asked of the throttle now, which moves toward the demanded one at the allowed acceleration.
    ramped_mps: Option<f64>,
    /// Whether the boat has been brought to a stop and the motors have been let go.
    let_go: bool,
}

/// A steering and a throttle command, each [−1, 1].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Command {
    pub(super) steering: f64,
    pub(super) throttle: f64,
}

impl Steering {
    /// The command that fulfils a demand, one loop of `dt_s` after the last.
    ///
    /// `twin` says that two thrusters steer, so that turning needs no way on.
    pub(super) fn command(
        &mut self,
        demand: Demand,
        motion: &Motion,
        parameters: &Parameters,
        twin: bool,
        dt_s: f64,
    ) -> Command {
        match demand {
            Demand::Direct { steering, throttle } => {
                *self = Self::default();
                Command { steering: clip(steering), throttle: clip(throttle) }
            }
            Demand::Drive { turn_rate_radps, speed_mps } => {
                self.let_go = false;
                Command {
                    steering: self.steer(turn_rate_radps, motion, parameters, twin, dt_s),
                    throttle: self.accelerate(speed_mps, motion, parameters, dt_s),
                }
            }
            Demand::Stop => self.stop(motion, parameters, twin, dt_s),
        }
    }

    fn stop(&mut self, motion: &Motion, parameters: &Parameters, twin: bool, dt_s: f64) -> Command {
        let stop_mps = parameters.get(ATC_STOP_SPEED);
        let limit_mps = if self.let_go { stop_mps } else { LET_GO_SHARE * stop_mps };
        self.let_go = motion.forward_mps().abs() <= limit_mps;
        if self.let_go {
            *self = Self { let_go: true, ..Self::default() };
            return Command::default();
        }
        Command {
            steering: self.steer(0.0, motion, parameters, twin, dt_s),
            throttle: self.accelerate(0.0, motion, parameters, dt_s),
        }
    }

    fn steer(
        &mut self,
        turn_rate_radps: f64,
        motion: &Motion,
        parameters: &Parameters,
        twin: bool,
        dt_s: f64,
    ) -> f64 {
        let limit = parameters.get(ATC_STR_RAT_MAX).to_radians();
        let wanted = if limit > 0.0 { turn_rate_radps.clamp(-limit, limit) } else { turn_rate_radps };
        let error = wanted - motion.turn_rate_radps;
        let damping = (motion.turn_rate_radps - self.last_rate_radps) / dt_s;
        self.last_rate_radps = motion.turn_rate_radps;
        let reply = parameters.get(ATC_STR_RAT_FF) * wanted + parameters.get(ATC_STR_RAT_P) * error
            - parameters.get(ATC_STR_RAT_D) * damping;
        let authority = if twin { 1.0 } else { rudder_authority(motion.forward_mps(), parameters) };
        let unlimited = (reply + self.rate_integral) / authority;
        let steering = clip(unlimited);
        let growth = parameters.get(ATC_STR_RAT_I) * error * dt_s;
        let saturated = unlimited != steering && growth.signum() == (reply + self.rate_integral).signum();
        if !saturated {
            let limit = parameters.get(ATC_STR_RAT_IMAX);
            self.rate_integral = (self.rate_integral + growth).clamp(-limit, limit);
        }
        steering
    }

    fn accelerate(&mut self, speed_mps: f64, motion: &Motion, parameters: &Parameters, dt_s: f64) -> f64 {
        let forward_mps = motion.forward_mps();
        let from_mps = self.ramped_mps.unwrap_or(forward_mps);
        let up = rate_or_free(parameters.get(ATC_ACCEL_MAX)) * dt_s;
        let down = rate_or_free(parameters.get(ATC_DECEL_MAX)) * dt_s;
        let ramped_mps = if speed_mps.abs() > from_mps.abs() {
            speed_mps.clamp(from_mps - up, from_mps + up)
        } else {
            speed_mps.clamp(from_mps - down, from_mps + down)
        };
        self.ramped_mps = Some(ramped_mps);

        let cruise = parameters.get(CRUISE_THROTTLE) / 100.0 / parameters.get(CRUISE_SPEED);
        let error = ramped_mps - forward_mps;
        let unlimited = cruise * ramped_mps + parameters.get(ATC_SPEED_P) * error + self.speed_integral;
        let throttle = clip(unlimited);
        let growth = parameters.get(ATC_SPEED_I) * error * dt_s;
        if unlimited == throttle || growth.signum() != unlimited.signum() {
            let limit = parameters.get(ATC_SPEED_IMAX);
            self.speed_integral = (self.speed_integral + growth).clamp(-limit, limit);
        }
        throttle
    }
}

/// Share of its effect at cruise speed that a rudder has at this speed; negative astern.
fn rudder_authority(forward_mps: f64, parameters: &Parameters) -> f64 {
    let share = forward_mps / parameters.get(CRUISE_SPEED);
    let magnitude = share.abs().max(LEAST_SPEED_SHARE);
    if share < -ASTERN_SHARE { -magnitude } else { magnitude }
}

/// An acceleration limit, where zero means none.
fn rate_or_free(limit_mps2: f64) -> f64 {
    if limit_mps2 > 0.0 { limit_mps2 } else { f64::MAX }
}

fn clip(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.clamp(-1.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use helmlink_mission::geodesy::NorthEast;
    use proptest::prelude::*;

    use super::*;

    const DT_S: f64 = 0.02;

    fn moving(forward_mps: f64, turn_rate_radps: f64) -> Motion {
        Motion { velocity_mps: NorthEast::new(forward_mps, 0.0), turn_rate_radps, ..Motion::default() }
    }

    #[test]
    fn astern_the_rudder_is_put_the_other_way() {
        let parameters = Parameters::new();
        let demand = Demand::Drive { turn_rate_radps: 0.2, speed_mps: 1.0 };
        let ahead = Steering::default().command(demand, &moving(2.0, 0.0), &parameters, false, DT_S);
        let astern = Steering::default().command(demand, &moving(-2.0, 0.0), &parameters, false, DT_S);
        assert!(ahead.steering > 0.0 && astern.steering < 0.0);
        let twin = Steering::default().command(demand, &moving(-2.0, 0.0), &parameters, true, DT_S);
        assert!(twin.steering > 0.0);
    }

    #[test]
    fn a_stop_brakes_lets_go_and_brakes_again() {
        let parameters = Parameters::new();
        let mut steering = Steering::default();
        let mut throttle = |forward_mps: f64| {
            let demand = Demand::Stop;
            let mut last = 0.0;
            for _ in 0..100 {
                last = steering.command(demand, &moving(forward_mps, 0.0), &parameters, false, DT_S).throttle;
            }
            last
        };
        assert!(throttle(2.0) < 0.0);
        assert_eq!(throttle(0.02), 0.0);
        assert_eq!(throttle(0.08), 0.0, "still slow enough");
        assert!(throttle(0.2) < 0.0);
        assert!(throttle(-0.2) > 0.0);
    }

    proptest! {
        #[test]
        fn commands_stay_within_their_limits(
            turn_rate_radps in -100.0..100.0, speed_mps in -100.0..100.0,
            forward_mps in -20.0..20.0, r in -5.0..5.0, twin in any::<bool>(),
        ) {
            let parameters = Parameters::new();
            let mut steering = Steering::default();
            for _ in 0..50 {
                let demand = Demand::Drive { turn_rate_radps, speed_mps };
                let command = steering.command(demand, &moving(forward_mps, r), &parameters, twin, DT_S);
                prop_assert!(command.steering.abs() <= 1.0 && command.throttle.abs() <= 1.0);
            }
        }
    }
}
