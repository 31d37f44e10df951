//! The sea at work: how current, gusts and wave drift vary, and what they do to the hull.

use super::angles::{turned, unit};
use super::dynamics::{BodyForce, NedVector, State};
use super::hull::{Hull, HullDynamics, WindLoads};
use super::random::{GaussMarkov, Source, Stream};
use super::sea::{Current, Push, Sea, Wind};
use super::waves::{WaveField, WaveMotion};
use super::{AIR_DENSITY_KGPM3, GRAVITY_MPS2, WATER_DENSITY_KGPM3};

/// Wander of the current's speed: standard deviation as a share of the mean, and time constant, s.
const CURRENT_SPEED_WANDER: (f64, f64) = (0.15, 200.0);
/// Wander of the current's direction: standard deviation, °, and time constant, s.
const CURRENT_DIRECTION_WANDER: (f64, f64) = (15.0, 300.0);
/// Gusts: standard deviation as a share of the mean wind, and time constant, s.
const GUST: (f64, f64) = (0.15, 8.0);
/// Slow variation of the wave drift (wave groups): standard deviation as a share, and time constant, s.
const DRIFT_WANDER: (f64, f64) = (0.5, 20.0);
/// Mean drift coefficients in surge, sway and (times length) yaw. The mean force on a hull that reflected
/// every wave would be ½ρg·L·(H_s/4)²; small hulls let most of a wave pass. Estimates.
const DRIFT_COEFFICIENTS: (f64, f64, f64) = (0.08, 0.20, 0.02);

/// What acts on the hull at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Conditions {
    /// Velocity of the water over ground, m/s.
    pub current_mps: NedVector,
    /// Velocity of the air over ground, m/s (the way it goes, not where it comes from).
    pub wind_mps: NedVector,
    /// Force of wind and wave drift on the hull.
    pub force: BodyForce,
    /// First-order wave motion.
    pub wave_motion: WaveMotion,
}

/// The sea around one boat, with its own randomness.
#[derive(Debug, Clone)]
pub struct Environment {
    sea: Sea,
    current: Option<MovingCurrent>,
    wind: Option<GustyWind>,
    waves: Option<Seaway>,
    push: Option<SlowPush>,
    time_s: f64,
}

impl Environment {
    /// The sea around `hull`. The same seed gives the same gusts and waves whatever the boat does.
    pub fn new(sea: &Sea, hull: &Hull, seed: u64) -> Environment {
        Environment {
            sea: *sea,
            current: sea.current.map(|mean| MovingCurrent::new(mean, seed)),
            wind: sea.wind.map(|mean| GustyWind::new(mean, hull, seed)),
            waves: sea.waves.zip(hull.waves).map(|(waves, response)| {
                let mut phases = Stream::new(seed, Source::WavePhases);
                let mut stream = Stream::new(seed, Source::WaveDrift);
                Seaway {
                    field: WaveField::new(&waves, response, hull, &mut phases),
                    reflection_n: reflection_n(waves.height_m, hull.length_m),
                    length_m: hull.length_m,
                    groups: GaussMarkov::new(DRIFT_WANDER.1, &mut stream),
                    stream,
                }
            }),
            push: sea.push.and_then(|push| SlowPush::new(push, hull)),
            time_s: 0.0,
        }
    }

    pub(super) fn sea(&self) -> &Sea {
        &self.sea
    }

    /// Changes to another sea; the parts that are the same go on as they were.
    pub(super) fn change(&mut self, sea: &Sea, hull: &Hull, seed: u64) {
        let new = Environment::new(sea, hull, seed);
        if sea.current != self.sea.current {
            self.current = new.current;
        }
        if sea.wind != self.sea.wind {
            self.wind = new.wind;
        }
        if sea.waves != self.sea.waves {
            self.waves = new.waves;
        }
        if sea.push != self.sea.push {
            self.push = new.push;
        }
        self.sea = *sea;
    }

    /// Advances by `dt_s` and returns what acts on a hull in this state, whose bow points along the unit vector
    /// `bow`.
    pub fn step(&mut self, dt_s: f64, hull: &State, bow: NedVector) -> Conditions {
        let mut conditions = Conditions::default();
        if let Some(current) = &mut self.current {
            conditions.current_mps = current.step(dt_s);
        }
        if let Some(wind) = &mut self.wind {
            conditions.wind_mps = wind.step(dt_s);
            if let Some(loads) = &wind.loads {
                conditions.force =
                    conditions.force + wind_force(loads, wind.length_m, conditions.wind_mps, hull, bow);
            }
        }
        if let Some(waves) = &mut self.waves {
            conditions.force = conditions.force + waves.drift(dt_s, bow);
            let velocity_mps = NedVector::of_body(hull.u_mps, hull.v_mps, bow);
            conditions.wave_motion = waves.field.step(dt_s, bow, velocity_mps);
        }
        self.time_s += dt_s;
        if let Some(push) = &self.push {
            conditions.force = conditions.force + push.force(self.time_s);
        }
        conditions
    }
}

/// A current that wanders about its mean.
#[derive(Debug, Clone)]
struct MovingCurrent {
    mean: Current,
    speed: GaussMarkov,
    direction: GaussMarkov,
    stream: Stream,
    steady_mps: NedVector,
}

impl MovingCurrent {
    fn new(mean: Current, seed: u64) -> MovingCurrent {
        let mut stream = Stream::new(seed, Source::Current);
        MovingCurrent {
            mean,
            speed: GaussMarkov::new(CURRENT_SPEED_WANDER.1, &mut stream),
            direction: GaussMarkov::new(CURRENT_DIRECTION_WANDER.1, &mut stream),
            stream,
            steady_mps: along(mean.toward_deg, mean.speed_mps),
        }
    }

    fn step(&mut self, dt_s: f64) -> NedVector {
        if self.mean.variability == 0.0 {
            return self.steady_mps;
        }
        let speed = self.mean.variability * CURRENT_SPEED_WANDER.0 * self.speed.step(dt_s, &mut self.stream);
        let turn_deg =
            self.mean.variability * CURRENT_DIRECTION_WANDER.0 * self.direction.step(dt_s, &mut self.stream);
        let share = (1.0 + speed).max(0.0);
        let flow = turned(self.steady_mps, turn_deg.to_radians());
        NedVector { north: share * flow.north, east: share * flow.east }
    }
}

/// A wind with gusts along its mean direction.
#[derive(Debug, Clone)]
struct GustyWind {
    mean: Wind,
    loads: Option<WindLoads>,
    length_m: f64,
    gust: GaussMarkov,
    stream: Stream,
    steady_mps: NedVector,
}

impl GustyWind {
    fn new(mean: Wind, hull: &Hull, seed: u64) -> GustyWind {
        let mut stream = Stream::new(seed, Source::Gust);
        GustyWind {
            mean,
            loads: hull.wind,
            length_m: hull.length_m,
            gust: GaussMarkov::new(GUST.1, &mut stream),
            stream,
            steady_mps: along(mean.from_deg + 180.0, mean.speed_mps),
        }
    }

    fn step(&mut self, dt_s: f64) -> NedVector {
        if self.mean.gustiness == 0.0 {
            return self.steady_mps;
        }
        let share = (1.0 + self.mean.gustiness * GUST.0 * self.gust.step(dt_s, &mut self.stream)).max(0.0);
        NedVector { north: share * self.steady_mps.north, east: share * self.steady_mps.east }
    }
}

/// Waves: their first-order motion and their mean drift.
#[derive(Debug, Clone)]
struct Seaway {
    field: WaveField,
    reflection_n: f64,
    length_m: f64,
    groups: GaussMarkov,
    stream: Stream,
}

impl Seaway {
    /// Second-order drift, which pushes the hull along with the waves and turns it broadside to them.
    fn drift(&mut self, dt_s: f64, bow: NedVector) -> BodyForce {
        let share = (1.0 + DRIFT_WANDER.0 * self.groups.step(dt_s, &mut self.stream)).max(0.0);
        let (cos_mu, sin_mu) = self.field.toward().in_body(bow);
        let force_n = share * self.reflection_n;
        BodyForce {
            surge_n: force_n * DRIFT_COEFFICIENTS.0 * cos_mu,
            sway_n: force_n * DRIFT_COEFFICIENTS.1 * sin_mu,
            yaw_nm: -force_n * DRIFT_COEFFICIENTS.2 * self.length_m * 2.0 * sin_mu * cos_mu,
        }
    }
}

/// Slow forces without a cause, scaled to one hull.
#[derive(Debug, Clone, Copy)]
struct SlowPush {
    force: BodyForce,
    frequency_scale: f64,
}

/// Length of the ship that the forces of [`Push`] are given for, m.
const PUSHED_LENGTH_M: f64 = 38.0;
/// Its accelerations in surge, sway (m/s²) and yaw (rad/s²) per unit of the slow factor.
const PUSH_ACCELERATIONS: (f64, f64, f64) = (1.0e4 / 120.0e3, 2.0e4 / 177.9e3, 3.0e4 / 636.0e5);

impl SlowPush {
    /// By Froude's law accelerations are alike, angular ones grow as 1/length, frequencies as 1/√length.
    fn new(push: Push, hull: &Hull) -> Option<SlowPush> {
        let HullDynamics::Maneuvering(body, _) = &hull.dynamics else { return None };
        let scale = PUSHED_LENGTH_M / hull.length_m;
        let force = BodyForce {
            surge_n: push.share * PUSH_ACCELERATIONS.0 * body.m11_kg,
            sway_n: push.share * PUSH_ACCELERATIONS.1 * body.m22_kg,
            yaw_nm: push.share * PUSH_ACCELERATIONS.2 * scale * body.m33_kgm2,
        };
        Some(SlowPush { force, frequency_scale: scale.sqrt() })
    }

    fn force(&self, time_s: f64) -> BodyForce {
        let t = self.frequency_scale * time_s;
        let (fast, slow) = ((0.1 * t).sin_cos(), (0.01 * t).sin_cos());
        BodyForce {
            surge_n: self.force.surge_n * (1.5 + fast.0 + slow.1),
            sway_n: self.force.sway_n * (1.5 + fast.1 + slow.0),
            yaw_nm: self.force.yaw_nm * (1.5 - fast.0 + slow.1),
        }
    }
}

/// Mean force of waves that are wholly reflected by the length of the hull, ½ρg·L·(H_s/4)², N
/// (Maruo's formula with the variance of an irregular sea).
fn reflection_n(height_m: f64, length_m: f64) -> f64 {
    let sigma_m = 0.25 * height_m;
    0.5 * WATER_DENSITY_KGPM3 * GRAVITY_MPS2 * length_m * sigma_m * sigma_m
}

/// Wind load on a moving hull (Fossen 2021, eq. 10.5 to 10.7): X and Y along the relative wind's components,
/// N = ½ρ C_N A_L L V² sin 2γ, which turns the bow away from a wind ahead of the beam.
fn wind_force(
    loads: &WindLoads,
    length_m: f64,
    wind_mps: NedVector,
    hull: &State,
    bow: NedVector,
) -> BodyForce {
    let (forward, starboard) = wind_mps.in_body(bow);
    let (forward, starboard) = (forward - hull.u_mps, starboard - hull.v_mps);
    let speed = (forward * forward + starboard * starboard).sqrt();
    let half_density = 0.5 * AIR_DENSITY_KGPM3;
    BodyForce {
        surge_n: half_density * loads.cx * loads.frontal_area_m2 * speed * forward,
        sway_n: half_density * loads.cy * loads.lateral_area_m2 * speed * starboard,
        yaw_nm: -half_density * loads.cn * loads.lateral_area_m2 * length_m * 2.0 * forward * starboard,
    }
}

/// A vector of this length toward this bearing.
fn along(toward_deg: f64, length: f64) -> NedVector {
    let direction = unit(toward_deg.to_radians());
    NedVector { north: length * direction.north, east: length * direction.east }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::sea::{SeaState, Waves};

    fn otter() -> Hull {
        Hull::builtin("otter").unwrap()
    }

    fn wind_from(deg: f64) -> BodyForce {
        let loads = otter().wind.unwrap();
        wind_force(&loads, 2.0, along(deg + 180.0, 10.0), &State::default(), along(0.0, 1.0))
    }

    #[test]
    fn a_wind_from_ahead_to_starboard_pushes_astern_to_port_and_turns_the_bow_off() {
        let force = wind_from(45.0);
        assert!(force.surge_n < 0.0 && force.sway_n < 0.0 && force.yaw_nm < 0.0, "{force:?}");
        // From astern on the same side it pushes the stern off, and the bow to starboard.
        assert!(wind_from(135.0).yaw_nm > 0.0);
        assert!((wind_from(0.0).surge_n + 0.5 * 1.224 * 0.5 * 0.3 * 100.0).abs() < 1e-9);
    }

    #[test]
    fn an_explicit_current_is_perfectly_steady() {
        let sea = Sea { current: Some("0.3@30".parse().unwrap()), ..Sea::default() };
        let mut environment = Environment::new(&sea, &otter(), 1);
        for _ in 0..1000 {
            let flow = environment.step(0.01, &State::default(), unit(0.0)).current_mps;
            assert!((flow.north - 0.3 * 30f64.to_radians().cos()).abs() < 1e-15);
            assert!((flow.east - 0.15).abs() < 1e-15);
        }
    }

    #[test]
    fn a_wandering_current_has_the_stated_spread() {
        let sea = Sea { current: Some("0.4@0".parse().unwrap()), ..Sea::default() }.with_variability(1.0);
        let mut environment = Environment::new(&sea, &otter(), 4);
        let speeds: Vec<f64> = (0..400_000)
            .map(|_| environment.step(1.0, &State::default(), unit(0.0)).current_mps)
            .map(|flow| flow.north.hypot(flow.east))
            .collect();
        let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
        let deviation = (speeds.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / speeds.len() as f64).sqrt();
        assert!((mean - 0.4).abs() < 0.01, "{mean}");
        assert!((deviation - 0.06).abs() < 0.006, "{deviation}");
    }

    #[test]
    fn wave_drift_is_that_of_the_formula_in_the_mean() {
        let waves: Waves = "0.35:2.8@180".parse().unwrap();
        let sea = Sea { waves: Some(waves), ..Sea::default() };
        let mut environment = Environment::new(&sea, &otter(), 2);
        let count = 100_000;
        let sum: f64 =
            (0..count).map(|_| environment.step(0.2, &State::default(), unit(0.0)).force.surge_n).sum();
        let expected = 0.08 * 0.5 * 1025.0 * 9.81 * 2.0 * (0.35f64 / 4.0).powi(2);
        // Clipping the drift at zero raises its mean by less than 1 %.
        assert!((sum / count as f64 / expected - 1.0).abs() < 0.06, "{} {expected}", sum / count as f64);
    }

    #[test]
    fn the_push_of_the_literature_is_that_of_its_own_ship_and_smaller_for_a_smaller_one() {
        let force = |name: &str| {
            let hull = Hull::builtin(name).unwrap();
            let sea = Sea { push: Some(Push { share: 1.0 }), ..Sea::default() };
            Environment::new(&sea, &hull, 1).step(0.0, &State::default(), unit(0.0)).force
        };
        let ship = force("monohull38");
        assert!((ship.surge_n - 2.5e4).abs() < 1e-6, "{ship:?}");
        assert!((ship.sway_n - 2.0 * 2.5e4).abs() < 1e-6 && (ship.yaw_nm - 3.0 * 2.5e4).abs() < 1e-6);
        let otter = force("otter");
        assert!(otter.surge_n > 10.0 && otter.surge_n < 30.0, "{otter:?}");
    }

    #[test]
    fn the_kinematic_boat_feels_current_only() {
        let motorboat = Hull::builtin("motorboat").unwrap();
        let sea = Sea::preset(SeaState::Moderate, &motorboat);
        let conditions = Environment::new(&sea, &motorboat, 1).step(0.01, &State::default(), unit(0.0));
        assert_eq!(conditions.force, BodyForce::default());
        assert_eq!(conditions.wave_motion, WaveMotion::default());
        assert_ne!(conditions.current_mps, NedVector::default());
    }
}
