//! First-order wave motion: a long-crested JONSWAP sea as a sum of sines, met at the hull's own place.
//!
//! The motion is an oscillation about the low-frequency position of the hull. It is added to what the sensors
//! see and never to the hull state itself (Fossen 2021, §8.2 and §10.2: superposition of wave-frequency and
//! low-frequency motion).

use super::GRAVITY_MPS2;
use super::angles::{Pair, SMALL_ANGLE_RAD, small_sin_cos};
use super::dynamics::NedVector;
use super::hull::{Hull, WaveResponse};
use super::random::Stream;
use super::sea::Waves;
use std::f64::consts::TAU;

/// Number of sines. Their frequencies are drawn at random within equal bands, so the sum does not repeat.
const COMPONENTS: usize = 25;
/// Band of frequencies, as multiples of the peak frequency: holds 98 % of the energy of the spectrum.
const BAND: (f64, f64) = (0.6, 3.0);
/// JONSWAP peak enhancement (Hasselmann et al. 1973; MSS waveSpectrum.m).
const PEAK_ENHANCEMENT: f64 = 3.3;
/// Yaw that a real, short-crested sea excites whatever the heading, as a share of that in quartering seas.
const SHORT_CRESTED_YAW: f64 = 0.35;
/// The sines go in pairs, which processors work on at once; the last of an odd number has one without height.
const PAIRS: usize = COMPONENTS.div_ceil(2);

/// Wave-frequency motion of the hull about its low-frequency position.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WaveMotion {
    /// Offset to the north, m.
    pub north_m: f64,
    /// Offset to the east, m.
    pub east_m: f64,
    /// Offset upward, m.
    pub heave_m: f64,
    /// Offset of the heading, rad.
    pub psi_rad: f64,
    /// Roll, positive to starboard, rad.
    pub roll_rad: f64,
    /// Pitch, positive bow up, rad.
    pub pitch_rad: f64,
    /// Velocity to the north, m/s.
    pub north_mps: f64,
    /// Velocity to the east, m/s.
    pub east_mps: f64,
    /// Yaw rate, rad/s.
    pub r_radps: f64,
    /// Elevation of the undisturbed water at the hull, m.
    pub elevation_m: f64,
}

/// One sine: wave of amplitude a at phase θ = ωt − kx + φ.
#[derive(Debug, Clone, Copy, Default)]
struct Component {
    amplitude_m: f64,
    /// Amplitude after averaging over the hull's length, m.
    felt_m: f64,
    omega_radps: f64,
    wavenumber_per_m: f64,
    cos: f64,
    sin: f64,
}

/// Two of them, figure by figure.
#[derive(Debug, Clone, Copy)]
struct TwoComponents {
    amplitude_m: Pair,
    felt_m: Pair,
    omega_radps: Pair,
    wavenumber_per_m: Pair,
    cos: Pair,
    sin: Pair,
}

/// The waves around one hull.
#[derive(Debug, Clone)]
pub(super) struct WaveField {
    pairs: [TwoComponents; PAIRS],
    /// The highest frequency and its wavenumber.
    highest: (f64, f64),
    response: WaveResponse,
    /// Unit vector the waves run along.
    toward: NedVector,
}

/// What the sines make together.
#[derive(Clone, Copy, Default)]
struct Sums<T> {
    /// Elevation of the undisturbed water, m.
    elevation: T,
    /// Heave of the hull, m, and its rate, m/s.
    heave: T,
    heave_rate: T,
    slope: T,
    /// Shift along the waves, m, and its rate, m/s: water particles in deep water move on circles.
    shift: T,
    shift_rate: T,
}

impl WaveField {
    pub(super) fn new(waves: &Waves, response: WaveResponse, hull: &Hull, stream: &mut Stream) -> WaveField {
        let (east, north) = (waves.from_deg + 180.0).to_radians().sin_cos();
        let peak_radps = TAU / waves.period_s;
        let width_radps = (BAND.1 - BAND.0) * peak_radps / COMPONENTS as f64;
        let mut components = [Component { cos: 1.0, ..Component::default() }; 2 * PAIRS];
        let mut energy = 0.0;
        for (i, component) in components.iter_mut().take(COMPONENTS).enumerate() {
            let omega_radps = BAND.0 * peak_radps + (i as f64 + stream.uniform()) * width_radps;
            let (sin, cos) = (TAU * stream.uniform()).sin_cos();
            let wavenumber_per_m = omega_radps * omega_radps / GRAVITY_MPS2;
            let amplitude_m = jonswap_shape(omega_radps / peak_radps).sqrt();
            energy += 0.5 * amplitude_m * amplitude_m;
            *component = Component { amplitude_m, felt_m: 0.0, omega_radps, wavenumber_per_m, cos, sin };
        }
        // H_s = 4σ: the elevation has exactly the variance asked for.
        let scale = 0.25 * waves.height_m / energy.sqrt();
        for component in &mut components {
            component.amplitude_m *= scale;
            // Mean of the wave over the length, sin(kL/2)/(kL/2) ≈ exp(−(kL)²/24).
            let span = component.wavenumber_per_m * hull.length_m;
            component.felt_m = component.amplitude_m * (-span * span / 24.0).exp();
        }
        let highest = &components[COMPONENTS - 1];
        WaveField {
            pairs: std::array::from_fn(|i| TwoComponents::of(&components[2 * i], &components[2 * i + 1])),
            highest: (highest.omega_radps, highest.wavenumber_per_m),
            response,
            toward: NedVector { north, east },
        }
    }

    /// Advances by `dt_s` at the hull's velocity over ground and returns the motion of a hull whose bow points
    /// along the unit vector `bow`.
    ///
    /// The phase of each sine turns at its frequency of encounter ω − k·U, U the speed along the waves.
    pub(super) fn step(&mut self, dt_s: f64, bow: NedVector, velocity_mps: NedVector) -> WaveMotion {
        let along_mps = velocity_mps.north * self.toward.north + velocity_mps.east * self.toward.east;
        let is_short = dt_s * (self.highest.0 + self.highest.1 * along_mps.abs()) < SMALL_ANGLE_RAD;
        let mut sums = Sums::default();
        for pair in &mut self.pairs {
            let encounter_radps = pair.omega_radps - pair.wavenumber_per_m * Pair::both(along_mps);
            pair.turn(encounter_radps * Pair::both(dt_s), is_short);
            pair.add_to(&mut sums, encounter_radps);
        }
        let Sums { elevation, heave, heave_rate, slope, shift, shift_rate } = sums.of_both();
        let (cos_mu, sin_mu) = self.toward.in_body(bow);
        let quartering = 2.0 * (sin_mu * cos_mu).abs();
        let yaw = self.response.yaw_rad_per_m * (SHORT_CRESTED_YAW + (1.0 - SHORT_CRESTED_YAW) * quartering);
        WaveMotion {
            north_m: shift * self.toward.north,
            east_m: shift * self.toward.east,
            heave_m: heave,
            psi_rad: yaw * heave,
            roll_rad: -self.response.roll_factor * slope * sin_mu,
            pitch_rad: self.response.pitch_factor * slope * cos_mu,
            north_mps: shift_rate * self.toward.north,
            east_mps: shift_rate * self.toward.east,
            r_radps: yaw * heave_rate,
            elevation_m: elevation,
        }
    }

    /// Unit vector the waves run along.
    pub(super) fn toward(&self) -> NedVector {
        self.toward
    }
}

impl TwoComponents {
    fn of(a: &Component, b: &Component) -> TwoComponents {
        let pair = |figure: fn(&Component) -> f64| Pair([figure(a), figure(b)]);
        TwoComponents {
            amplitude_m: pair(|component| component.amplitude_m),
            felt_m: pair(|component| component.felt_m),
            omega_radps: pair(|component| component.omega_radps),
            wavenumber_per_m: pair(|component| component.wavenumber_per_m),
            cos: pair(|component| component.cos),
            sin: pair(|component| component.sin),
        }
    }

    /// Turns the phasors. Steps are short, so a series does without the library's sine.
    #[inline]
    fn turn(&mut self, angle_rad: Pair, is_short: bool) {
        let (sin, cos) = if is_short { small_sin_cos(angle_rad) } else { angle_rad.sin_cos() };
        (self.cos, self.sin) = (self.cos * cos - self.sin * sin, self.sin * cos + self.cos * sin);
    }

    #[inline]
    fn add_to(&self, sums: &mut Sums<Pair>, encounter_radps: Pair) {
        let (felt_cos, felt_sin) = (self.felt_m * self.cos, self.felt_m * self.sin);
        sums.elevation = sums.elevation + self.amplitude_m * self.cos;
        sums.heave = sums.heave + felt_cos;
        sums.heave_rate = sums.heave_rate - encounter_radps * felt_sin;
        sums.slope = sums.slope + self.wavenumber_per_m * felt_sin;
        sums.shift = sums.shift + felt_sin;
        sums.shift_rate = sums.shift_rate + encounter_radps * felt_cos;
    }
}

impl Sums<Pair> {
    fn of_both(self) -> Sums<f64> {
        Sums {
            elevation: self.elevation.sum(),
            heave: self.heave.sum(),
            heave_rate: self.heave_rate.sum(),
            slope: self.slope.sum(),
            shift: self.shift.sum(),
            shift_rate: self.shift_rate.sum(),
        }
    }
}

/// JONSWAP spectrum over the relative frequency ω/ω_p, without its scale (Fossen 2021, eq. 10.54).
fn jonswap_shape(ratio: f64) -> f64 {
    let sigma = if ratio <= 1.0 { 0.07 } else { 0.09 };
    let peak = (-((ratio - 1.0) / sigma).powi(2) / 2.0).exp();
    ratio.powi(-5) * (-1.25 * ratio.powi(-4)).exp() * PEAK_ENHANCEMENT.powf(peak)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::random::Source;

    const NORTH: NedVector = NedVector { north: 1.0, east: 0.0 };

    fn field(text: &str, seed: u64) -> WaveField {
        let hull = Hull::builtin("otter").unwrap();
        let mut stream = Stream::new(seed, Source::WavePhases);
        WaveField::new(&text.parse().unwrap(), hull.waves.unwrap(), &hull, &mut stream)
    }

    fn elevations(field: &mut WaveField, north_mps: f64) -> Vec<f64> {
        (0..200_000)
            .map(|_| field.step(0.01, NORTH, NedVector { north: north_mps, east: 0.0 }).elevation_m)
            .collect()
    }

    /// Mean period of the upward zero crossings, s.
    fn crossing_period_s(samples: &[f64]) -> f64 {
        let ups = samples.windows(2).filter(|pair| pair[0] < 0.0 && pair[1] >= 0.0).count();
        samples.len() as f64 * 0.01 / ups as f64
    }

    #[test]
    fn significant_height_is_four_standard_deviations() {
        for seed in 1..4 {
            let samples = elevations(&mut field("0.35:2.8@0", seed), 0.0);
            let variance = samples.iter().map(|eta| eta * eta).sum::<f64>() / samples.len() as f64;
            let height_m = 4.0 * variance.sqrt();
            assert!((height_m / 0.35 - 1.0).abs() < 0.03, "seed {seed}: {height_m}");
        }
    }

    #[test]
    fn periods_are_those_of_jonswap_and_shorten_against_the_waves() {
        // T_z ≈ 0.78·T_p for γ = 3.3 (Fossen 2021, table 10.2 gives T_z = 0.777·T_p).
        let still = crossing_period_s(&elevations(&mut field("0.35:2.8@0", 5), 0.0));
        assert!((still / 2.8 - 0.78).abs() < 0.06, "{still}");
        let against = crossing_period_s(&elevations(&mut field("0.35:2.8@0", 5), 1.5));
        let with = crossing_period_s(&elevations(&mut field("0.35:2.8@180", 5), 1.5));
        assert!(against < 0.8 * still && with > 1.2 * still, "{against} {still} {with}");
    }

    #[test]
    fn rates_are_the_derivatives_of_the_motion() {
        let mut field = field("0.35:2.8@40", 2);
        let velocity_mps = NedVector { north: 0.5, east: 0.2 };
        let mut last = field.step(0.01, NORTH, velocity_mps);
        for _ in 0..1000 {
            let next = field.step(0.01, NORTH, velocity_mps);
            let mean = |a: f64, b: f64| 0.5 * (a + b);
            assert!(
                ((next.north_m - last.north_m) / 0.01 - mean(next.north_mps, last.north_mps)).abs() < 2e-3
            );
            assert!(((next.psi_rad - last.psi_rad) / 0.01 - mean(next.r_radps, last.r_radps)).abs() < 2e-3);
            last = next;
        }
    }

    #[test]
    fn phasors_keep_their_length_over_an_hour() {
        let mut field = field("0.35:2.8@0", 9);
        for _ in 0..360_000 {
            field.step(0.01, NORTH, NORTH);
        }
        for pair in field.pairs {
            let length = pair.cos * pair.cos + pair.sin * pair.sin;
            assert!(length.0.iter().all(|length| (length - 1.0).abs() < 1e-9));
        }
    }
}
