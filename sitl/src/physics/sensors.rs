//! From the true motion to what the flight controller's sensors deliver.

use super::dynamics::wrap;
use super::estimator::{Estimator, Inertial};
use super::faults::{GpsFaults, VesselFaults};
use super::random::{GaussMarkov, Source, Stream};

/// How good the sensors are.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SensorSettings {
    /// `None` reports the truth exactly, wave motion included.
    pub noise: Option<SensorNoise>,
    /// Leaves the first-order wave motion out, as an ideal wave filter would.
    pub without_waves: bool,
}

/// Errors of real sensors; every standard deviation is of white noise unless it says otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorNoise {
    /// Position fixes per second.
    pub gps_rate_hz: f64,
    /// White position noise per axis, m.
    pub gps_white_m: f64,
    /// Standard deviation of the slowly wandering position error per axis, m.
    pub gps_wander_m: f64,
    /// Time constant of that wander, s.
    pub gps_wander_time_s: f64,
    /// Doppler velocity noise per axis, m/s.
    pub gps_velocity_mps: f64,
    /// Compass noise at 50 Hz, rad.
    pub compass_white_rad: f64,
    /// Constant compass error; its sign depends on the seed, rad.
    pub compass_bias_rad: f64,
    /// Rate gyro noise at 50 Hz, rad/s.
    pub gyro_white_radps: f64,
    /// Constant gyro error; its sign depends on the seed, rad/s.
    pub gyro_bias_radps: f64,
    /// Accelerometer noise at 50 Hz per axis, m/s².
    pub accelerometer_white_mps2: f64,
    /// Constant accelerometer error per axis; its sign depends on the seed, m/s².
    pub accelerometer_bias_mps2: f64,
}

impl SensorSettings {
    /// The estimate is the truth.
    pub fn perfect() -> SensorSettings {
        SensorSettings { noise: None, without_waves: false }
    }

    /// A good flight controller with a multi-band GPS: position good to about 0.1 m.
    pub fn typical() -> SensorSettings {
        SensorSettings {
            noise: Some(SensorNoise {
                gps_rate_hz: 5.0,
                gps_white_m: 0.15,
                gps_wander_m: 0.08,
                gps_wander_time_s: 60.0,
                gps_velocity_mps: 0.04,
                compass_white_rad: 0.3f64.to_radians(),
                compass_bias_rad: 0.7f64.to_radians(),
                gyro_white_radps: 0.03f64.to_radians(),
                gyro_bias_radps: 0.01f64.to_radians(),
                accelerometer_white_mps2: 0.05,
                accelerometer_bias_mps2: 0.02,
            }),
            without_waves: false,
        }
    }

    /// A single-band GPS and a compass near iron: position good to about 0.7 m.
    pub fn poor() -> SensorSettings {
        SensorSettings {
            noise: Some(SensorNoise {
                gps_rate_hz: 5.0,
                gps_white_m: 0.3,
                gps_wander_m: 0.5,
                gps_wander_time_s: 60.0,
                gps_velocity_mps: 0.06,
                compass_white_rad: 0.5f64.to_radians(),
                compass_bias_rad: 1.5f64.to_radians(),
                gyro_white_radps: 0.05f64.to_radians(),
                gyro_bias_radps: 0.02f64.to_radians(),
                accelerometer_white_mps2: 0.1,
                accelerometer_bias_mps2: 0.05,
            }),
            without_waves: false,
        }
    }
}

impl std::str::FromStr for SensorSettings {
    type Err = UnknownSensors;

    fn from_str(text: &str) -> Result<SensorSettings, UnknownSensors> {
        match text {
            "perfect" => Ok(SensorSettings::perfect()),
            "typical" => Ok(SensorSettings::typical()),
            "poor" => Ok(SensorSettings::poor()),
            other => Err(UnknownSensors(other.to_owned())),
        }
    }
}

/// Not a known set of sensors.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no set of sensors: choose one of perfect, typical, poor")]
pub struct UnknownSensors(String);

/// What the flight controller believes about the boat, wave motion included.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// Time of validity since the start, s.
    pub time_s: f64,
    /// Metres north of the local origin.
    pub north_m: f64,
    /// Metres east of the local origin.
    pub east_m: f64,
    /// Heading, (−π, π].
    pub psi_rad: f64,
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
    /// Velocity over ground to the north, m/s.
    pub north_mps: f64,
    /// Velocity over ground to the east, m/s.
    pub east_mps: f64,
    /// Yaw rate, rad/s.
    pub r_radps: f64,
    /// False while the GPS delivers nothing; the rest is then dead reckoning.
    pub has_gps: bool,
    /// What the GPS itself said last.
    pub gps: GpsFix,
}

/// One GPS fix.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GpsFix {
    /// Metres north of the local origin.
    pub north_m: f64,
    /// Metres east of the local origin.
    pub east_m: f64,
    /// Velocity to the north, m/s.
    pub north_mps: f64,
    /// Velocity to the east, m/s.
    pub east_mps: f64,
}

/// The true motion of the sensors, wave motion included.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct TrueMotion {
    pub(super) north_m: f64,
    pub(super) east_m: f64,
    pub(super) psi_rad: f64,
    pub(super) roll_rad: f64,
    pub(super) pitch_rad: f64,
    pub(super) north_mps: f64,
    pub(super) east_mps: f64,
    pub(super) r_radps: f64,
}

/// Rate of inertial sensors, compass and estimator, Hz.
const INERTIAL_RATE_HZ: f64 = 50.0;
/// Slack in comparing times, s: far below a step, far above the rounding of hours of summed steps.
const TIME_SLACK_S: f64 = 1e-6;

/// The sensors of one boat and the estimator behind them.
#[derive(Debug, Clone)]
pub(super) struct Sensors {
    noisy: Option<Noisy>,
    estimate: Estimate,
    last_time_s: f64,
    /// How far the GPS has run away so far, m.
    drifted_m: [f64; 2],
}

impl Sensors {
    pub(super) fn new(settings: &SensorSettings, length_m: f64, seed: u64, motion: &TrueMotion) -> Sensors {
        Sensors {
            noisy: settings.noise.map(|noise| Noisy::new(noise, length_m, seed, motion)),
            estimate: exact(0.0, motion, &VesselFaults::default(), [0.0; 2], fix_of(motion, [0.0; 2])),
            last_time_s: 0.0,
            drifted_m: [0.0; 2],
        }
    }

    /// Takes in the true motion at `time_s`.
    pub(super) fn step(&mut self, time_s: f64, motion: &TrueMotion, faults: &VesselFaults) {
        let offset_m = self.gps_offset_m(time_s - self.last_time_s, &faults.gps);
        self.last_time_s = time_s;
        self.estimate = match &mut self.noisy {
            None => exact(time_s, motion, faults, offset_m, self.estimate.gps),
            Some(noisy) => noisy.step(time_s, motion, faults, offset_m).unwrap_or(self.estimate),
        };
    }

    /// Changes the rate of the fixes.
    pub(super) fn set_gps_rate(&mut self, rate_hz: f64) {
        if let Some(noisy) = self.noisy.as_mut().filter(|noisy| noisy.noise.gps_rate_hz != rate_hz) {
            noisy.noise.gps_rate_hz = rate_hz.clamp(1.0, INERTIAL_RATE_HZ);
        }
    }

    /// How far the GPS is off by its faults.
    fn gps_offset_m(&mut self, dt_s: f64, gps: &GpsFaults) -> [f64; 2] {
        let (jump, drift) = (gps.jump_m, gps.drift_mps);
        if drift == Default::default() {
            self.drifted_m = [0.0; 2];
            return [jump.north, jump.east];
        }
        self.drifted_m[0] += dt_s * drift.north;
        self.drifted_m[1] += dt_s * drift.east;
        [jump.north + self.drifted_m[0], jump.east + self.drifted_m[1]]
    }

    pub(super) fn estimate(&self) -> Estimate {
        self.estimate
    }
}

/// The truth, as far as the faults let it through; `last` is the fix that a frozen GPS repeats.
fn exact(
    time_s: f64,
    motion: &TrueMotion,
    faults: &VesselFaults,
    offset_m: [f64; 2],
    last: GpsFix,
) -> Estimate {
    let gps = if faults.gps.frozen { last } else { fix_of(motion, offset_m) };
    Estimate {
        time_s,
        north_m: gps.north_m,
        east_m: gps.east_m,
        psi_rad: if faults.compass_offset_rad == 0.0 {
            motion.psi_rad
        } else {
            wrap(motion.psi_rad + faults.compass_offset_rad)
        },
        roll_rad: motion.roll_rad,
        pitch_rad: motion.pitch_rad,
        north_mps: gps.north_mps,
        east_mps: gps.east_mps,
        r_radps: motion.r_radps,
        has_gps: !faults.gps.lost,
        gps,
    }
}

/// A fix without noise.
fn fix_of(motion: &TrueMotion, offset_m: [f64; 2]) -> GpsFix {
    GpsFix {
        north_m: motion.north_m + offset_m[0],
        east_m: motion.east_m + offset_m[1],
        north_mps: motion.north_mps,
        east_mps: motion.east_mps,
    }
}

/// Sensors with errors.
#[derive(Debug, Clone)]
struct Noisy {
    noise: SensorNoise,
    gps: Stream,
    compass: Stream,
    inertial: Stream,
    wander: [GaussMarkov; 2],
    compass_bias_rad: f64,
    gyro_bias_radps: f64,
    accelerometer_bias_mps2: [f64; 2],
    next_inertial_s: f64,
    next_fix_s: f64,
    last_time_s: f64,
    last_velocity_mps: [f64; 2],
    last_fix: GpsFix,
    estimator: Estimator,
}

impl Noisy {
    fn new(noise: SensorNoise, length_m: f64, seed: u64, motion: &TrueMotion) -> Noisy {
        let mut gps = Stream::new(seed, Source::Gps);
        let mut compass = Stream::new(seed, Source::Compass);
        let mut inertial = Stream::new(seed, Source::Inertial);
        let wander = std::array::from_fn(|_| GaussMarkov::new(noise.gps_wander_time_s, &mut gps));
        Noisy {
            compass_bias_rad: compass.sign() * noise.compass_bias_rad,
            gyro_bias_radps: inertial.sign() * noise.gyro_bias_radps,
            accelerometer_bias_mps2: std::array::from_fn(|_| inertial.sign() * noise.accelerometer_bias_mps2),
            estimator: Estimator::new(length_m, motion),
            noise,
            gps,
            compass,
            inertial,
            wander,
            next_inertial_s: 1.0 / INERTIAL_RATE_HZ,
            next_fix_s: 1.0 / noise.gps_rate_hz,
            last_time_s: 0.0,
            last_velocity_mps: [motion.north_mps, motion.east_mps],
            last_fix: fix_of(motion, [0.0; 2]),
        }
    }

    /// The new estimate, when it is time for one.
    fn step(
        &mut self,
        time_s: f64,
        motion: &TrueMotion,
        faults: &VesselFaults,
        offset_m: [f64; 2],
    ) -> Option<Estimate> {
        if time_s + TIME_SLACK_S < self.next_inertial_s {
            return None;
        }
        self.next_inertial_s += 1.0 / INERTIAL_RATE_HZ;
        let dt_s = time_s - self.last_time_s;
        let mut inertial = self.inertial(dt_s, motion);
        inertial.compass_rad += faults.compass_offset_rad;
        self.estimator.predict(dt_s, &inertial);
        self.last_time_s = time_s;
        self.last_velocity_mps = [motion.north_mps, motion.east_mps];
        if time_s + TIME_SLACK_S >= self.next_fix_s {
            self.next_fix_s += 1.0 / self.noise.gps_rate_hz;
            // Drawn even in an outage, so that an outage leaves the later noise as it was.
            let fix = self.fix(motion, offset_m);
            if !faults.gps.frozen {
                self.last_fix = fix;
            }
            if !faults.gps.lost {
                self.estimator.correct(&self.last_fix);
            }
        }
        let estimate = self.estimator.estimate();
        Some(Estimate {
            time_s,
            roll_rad: motion.roll_rad,
            pitch_rad: motion.pitch_rad,
            has_gps: !faults.gps.lost,
            gps: self.last_fix,
            ..estimate
        })
    }

    /// Inertial sensors and compass over the last `dt_s`.
    fn inertial(&mut self, dt_s: f64, motion: &TrueMotion) -> Inertial {
        let north_mps2 = (motion.north_mps - self.last_velocity_mps[0]) / dt_s;
        let east_mps2 = (motion.east_mps - self.last_velocity_mps[1]) / dt_s;
        let (sin, cos) = motion.psi_rad.sin_cos();
        let noise = &self.noise;
        let mut body = |true_mps2: f64, bias_mps2: f64| {
            true_mps2 + bias_mps2 + noise.accelerometer_white_mps2 * self.inertial.normal()
        };
        let forward_mps2 = body(north_mps2 * cos + east_mps2 * sin, self.accelerometer_bias_mps2[0]);
        let starboard_mps2 = body(east_mps2 * cos - north_mps2 * sin, self.accelerometer_bias_mps2[1]);
        Inertial {
            r_radps: motion.r_radps + self.gyro_bias_radps + noise.gyro_white_radps * self.inertial.normal(),
            forward_mps2,
            starboard_mps2,
            compass_rad: motion.psi_rad
                + self.compass_bias_rad
                + noise.compass_white_rad * self.compass.normal(),
        }
    }

    fn fix(&mut self, motion: &TrueMotion, offset_m: [f64; 2]) -> GpsFix {
        let noise = &self.noise;
        let interval_s = 1.0 / noise.gps_rate_hz;
        let mut position = |axis: usize, true_m: f64| {
            let wander = self.wander[axis].step(interval_s, &mut self.gps);
            true_m + noise.gps_wander_m * wander + noise.gps_white_m * self.gps.normal()
        };
        let (north_m, east_m) =
            (position(0, motion.north_m + offset_m[0]), position(1, motion.east_m + offset_m[1]));
        let mut velocity = |true_mps: f64| true_mps + noise.gps_velocity_mps * self.gps.normal();
        GpsFix { north_m, east_m, north_mps: velocity(motion.north_mps), east_mps: velocity(motion.east_mps) }
    }
}
