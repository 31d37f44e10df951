//! One boat on one sea: the whole of the physics behind two calls, `step` and `estimate`.

use super::STEP_S;
use super::actuators::{self, ActuatorCommand, ActuatorState};
use super::dynamics::{NedVector, State, step_maneuvering, step_motorboat, wrap};
use super::environment::{Conditions, Environment};
use super::faults::{FaultyBoat, VesselFaults};
use super::hull::{Hull, HullDynamics};
use super::sea::Sea;
use super::sensors::{Estimate, SensorSettings, Sensors, TrueMotion};
use super::shallow::Shoal;
use super::waves::WaveMotion;

/// Longest step the equations are integrated with, s; [`Vessel::step`] divides longer spans.
const LONGEST_STEP_S: f64 = 2.0 * STEP_S;
/// Longest span one call simulates, s: a guard against a caller whose clock jumped.
const LONGEST_SPAN_S: f64 = 60.0;

/// Where and which way a boat lies.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Metres north of the local origin.
    pub north_m: f64,
    /// Metres east of the local origin.
    pub east_m: f64,
    /// Heading, clockwise from north, rad.
    pub psi_rad: f64,
}

/// What really happens, for scoring and plots; never for the controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Time since the start, s.
    pub time_s: f64,
    /// The hull's low-frequency motion: what tracking is scored on.
    pub hull: State,
    /// Speed through the water along the bow, m/s.
    pub u_r_mps: f64,
    /// Speed through the water to starboard, m/s.
    pub v_r_mps: f64,
    /// First-order wave motion, to be added to `hull` for what a camera would see.
    pub wave_motion: WaveMotion,
    /// Velocity of the water over ground, m/s.
    pub current_mps: NedVector,
    /// Velocity of the air over ground, m/s.
    pub wind_mps: NedVector,
    /// Where propellers and rudder are.
    pub actuators: ActuatorState,
}

/// A boat with its actuators and sensors on its sea. Clone it to branch a simulation.
#[derive(Debug, Clone)]
pub struct Vessel {
    hull: Hull,
    environment: Environment,
    sensors: Sensors,
    /// Whether the sensors see the first-order wave motion.
    sees_waves: bool,
    time_s: f64,
    state: State,
    /// Unit vector along the state's heading.
    bow: NedVector,
    actuators: ActuatorState,
    conditions: Conditions,
    moored: bool,
    /// The bottom, where it is near enough to matter.
    shoal: Option<Shoal>,
    faulty: FaultyBoat,
    seed: u64,
}

impl Vessel {
    /// A boat at `pose`, adrift: at rest through the water, so moving with the current.
    ///
    /// The seed decides gusts, waves and sensor noise. A pose that is not finite is taken as the origin.
    pub fn new(hull: Hull, sea: &Sea, sensors: &SensorSettings, seed: u64, pose: Pose) -> Vessel {
        let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
        let psi_rad = wrap(finite(pose.psi_rad));
        let mut environment = Environment::new(sea, &hull, seed);
        let berth =
            State { north_m: finite(pose.north_m), east_m: finite(pose.east_m), psi_rad, ..State::default() };
        // A step of no time asks the sea how things stand without moving it.
        let bow = berth.bow();
        let conditions = environment.step(0.0, &berth, bow);
        let state = adrift(berth, bow, conditions.current_mps);
        let sees_waves = !sensors.without_waves;
        let motion = true_motion(&state, bow, &seen(&conditions, sees_waves));
        Vessel {
            sees_waves,
            sensors: Sensors::new(sensors, hull.length_m, seed, &motion),
            actuators: ActuatorState::at_rest(&hull.dynamics),
            shoal: shoal(sea, &hull),
            hull,
            environment,
            time_s: 0.0,
            state,
            bow,
            conditions,
            moored: false,
            faulty: FaultyBoat::default(),
            seed,
        }
    }

    /// Simulates `dt_s` with the command held. Meant for steps of [`STEP_S`] or shorter; longer spans are
    /// divided into equal steps of at most 20 ms. Spans that are not positive are ignored, and none is longer
    /// than a minute.
    pub fn step(&mut self, dt_s: f64, command: ActuatorCommand) {
        if dt_s.is_nan() || dt_s <= 0.0 {
            return;
        }
        if dt_s <= LONGEST_STEP_S {
            return self.advance(dt_s, command);
        }
        let span_s = dt_s.min(LONGEST_SPAN_S);
        let count = (span_s / LONGEST_STEP_S - 1e-9).ceil().max(1.0);
        for _ in 0..count as u32 {
            self.advance(span_s / count, command);
        }
    }

    fn advance(&mut self, dt_s: f64, command: ActuatorCommand) {
        let command = self.faulty.effective(&self.hull, command);
        self.conditions = self.environment.step(dt_s, &self.state, self.bow);
        let current = self.conditions.current_mps;
        if self.moored {
            self.state = State { u_mps: 0.0, v_mps: 0.0, r_radps: 0.0, ..self.state };
        } else {
            self.state = match &self.hull.dynamics {
                HullDynamics::Maneuvering(hull, propulsion) => {
                    let (u_r_mps, _) = self.state.through_water_mps(self.bow, current);
                    let (moved, thrust) = actuators::step(propulsion, self.actuators, command, u_r_mps, dt_s);
                    self.actuators = moved;
                    let force = thrust + self.conditions.force;
                    let slowed = self.shoal.map(|shoal| shoal.slowed(hull, u_r_mps));
                    let hull = slowed.as_ref().unwrap_or(hull);
                    step_maneuvering(hull, self.state, self.bow, force, current, dt_s)
                }
                HullDynamics::Motorboat(boat) => {
                    let (throttle, steering) = command.throttle_steering();
                    let steering_rad = steering * boat.steering_limit_rad;
                    self.actuators = ActuatorState::ThrottleSteering { throttle, steering_rad };
                    step_motorboat(boat, self.state, self.bow, throttle, steering, current, dt_s)
                }
            };
            self.bow = self.state.bow();
        }
        self.time_s += dt_s;
        let motion = true_motion(&self.state, self.bow, &seen(&self.conditions, self.sees_waves));
        self.sensors.step(self.time_s, &motion, &self.faulty.faults);
    }

    /// Holds the boat at its place (true) or sets it adrift (false). Waves still move a moored boat.
    pub fn set_moored(&mut self, moored: bool) {
        if self.moored && !moored {
            self.state = adrift(self.state, self.bow, self.conditions.current_mps);
            self.actuators = ActuatorState::at_rest(&self.hull.dynamics);
        }
        self.moored = moored;
    }

    /// Sets what is wrong with sensors and actuators from now on, in place of what was.
    pub fn set_faults(&mut self, faults: VesselFaults) {
        self.faulty.set(faults, &self.hull, self.actuators);
    }

    /// What is wrong with sensors and actuators.
    pub fn faults(&self) -> &VesselFaults {
        &self.faulty.faults
    }

    /// The sea as it was asked for.
    pub fn sea(&self) -> &Sea {
        self.environment.sea()
    }

    /// Has the GPS deliver so many fixes per second from now on, 1 to 50.
    pub fn set_gps_rate(&mut self, rate_hz: f64) {
        self.sensors.set_gps_rate(rate_hz);
    }

    /// Changes the sea from now on. What stays the same goes on as it was: the randomness of a part starts
    /// anew only where its mean has changed.
    pub fn set_sea(&mut self, sea: &Sea) {
        self.shoal = shoal(sea, &self.hull);
        self.environment.change(sea, &self.hull, self.seed);
        self.conditions = self.environment.step(0.0, &self.state, self.bow);
    }

    /// What the flight controller knows. With perfect sensors new at every step, else at 50 Hz.
    pub fn estimate(&self) -> Estimate {
        self.sensors.estimate()
    }

    /// What really happens.
    pub fn truth(&self) -> Truth {
        let (u_r_mps, v_r_mps) = self.state.through_water_mps(self.bow, self.conditions.current_mps);
        Truth {
            time_s: self.time_s,
            hull: self.state,
            u_r_mps,
            v_r_mps,
            wave_motion: self.conditions.wave_motion,
            current_mps: self.conditions.current_mps,
            wind_mps: self.conditions.wind_mps,
            actuators: self.actuators,
        }
    }

    /// The boat.
    pub fn hull(&self) -> &Hull {
        &self.hull
    }

    /// Time simulated since the start, s.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }
}

/// The bottom under a hull that feels it.
fn shoal(sea: &Sea, hull: &Hull) -> Option<Shoal> {
    sea.depth_m.zip(hull.shallow_water).map(|(depth_m, size)| Shoal::new(&size, depth_m))
}

/// The same place with no speed through the water.
fn adrift(state: State, bow: NedVector, current: NedVector) -> State {
    let (u_mps, v_mps) = current.in_body(bow);
    State { u_mps, v_mps, r_radps: 0.0, ..state }
}

/// The wave motion that the sensors see.
fn seen(conditions: &Conditions, sees_waves: bool) -> WaveMotion {
    if sees_waves { conditions.wave_motion } else { WaveMotion::default() }
}

/// Low-frequency and wave motion together: what the sensors feel.
fn true_motion(state: &State, bow: NedVector, wave: &WaveMotion) -> TrueMotion {
    let velocity_mps = NedVector::of_body(state.u_mps, state.v_mps, bow);
    TrueMotion {
        north_m: state.north_m + wave.north_m,
        east_m: state.east_m + wave.east_m,
        psi_rad: wrap(state.psi_rad + wave.psi_rad),
        roll_rad: wave.roll_rad,
        pitch_rad: wave.pitch_rad,
        north_mps: velocity_mps.north + wave.north_mps,
        east_mps: velocity_mps.east + wave.east_mps,
        r_radps: state.r_radps + wave.r_radps,
    }
}
