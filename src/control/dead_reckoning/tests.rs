use std::f64::consts::{FRAC_PI_2, PI};

use proptest::prelude::*;

use super::*;
use crate::control::testing::Noise;

const DT_S: f64 = 0.04;
const CURRENT: NorthEast = NorthEast { north_m: 0.2, east_m: -0.15 };

/// A boat that is watched by wrong sensors.
struct Voyage {
    position: NorthEast,
    /// Error of the velocity toward bow and starboard.
    velocity_offset: [f64; 2],
    /// Error of the position.
    position_error: NorthEast,
}

impl Voyage {
    fn new() -> Self {
        Self { position: NorthEast::ZERO, velocity_offset: [0.0; 2], position_error: NorthEast::ZERO }
    }

    /// Runs a leg; hands every measurement over.
    fn leg(&mut self, heading_rad: f64, seconds: f64, mut take: impl FnMut(&mut Self, &VesselState)) {
        let bow = unit(heading_rad);
        let velocity = bow * 1.2 + CURRENT;
        for _ in 0..(seconds / DT_S) as u32 {
            self.position += velocity * DT_S;
            let state = VesselState {
                position: self.position + self.position_error,
                heading_rad,
                surge_mps: bow.dot(velocity) + self.velocity_offset[0],
                sway_mps: bow.cross(velocity) + self.velocity_offset[1],
                yaw_rate_radps: 0.0,
            };
            take(self, &state);
        }
    }
}

#[test]
fn a_velocity_that_is_off_is_found_out_by_the_position() {
    let mut voyage = Voyage { velocity_offset: [0.02, -0.016], ..Voyage::new() };
    let mut reckoning = DeadReckoning::default();
    let mut better = VesselState::default();
    for leg in 0..4 {
        voyage.leg(FRAC_PI_2 * f64::from(leg), 60.0, |_, state| better = reckoning.correct(DT_S, state));
    }
    let [forward, right] = reckoning.offset_mps();
    assert!((forward - 0.02).abs() < 2.0e-3 && (right + 0.016).abs() < 2.0e-3, "{forward} {right}");
    let truth = unit(3.0 * FRAC_PI_2) * 1.2 + CURRENT;
    assert!((better.ground_velocity() - truth).norm() < 3.0e-3);
}

#[test]
fn a_position_without_noise_is_taken_as_it_is() {
    let mut voyage = Voyage { velocity_offset: [0.02, -0.016], ..Voyage::new() };
    let mut reckoning = DeadReckoning::default();
    voyage.leg(0.4, 300.0, |_, state| {
        let better = reckoning.correct(DT_S, state);
        assert!((better.position - state.position).norm() < 1.0e-3);
    });
}

/// Root mean square of the position's error as it is told and as it is believed, after the first minute, m.
fn position_errors(white_m: f64, wander_m: f64) -> (f64, f64) {
    let mut noise = Noise::seeded(7);
    let (mut told_m2, mut believed_m2, mut count) = (0.0, 0.0, 0.0);
    for _ in 0..20 {
        let mut voyage = Voyage::new();
        let mut reckoning = DeadReckoning::default();
        let memory = (-DT_S / 60.0f64).exp();
        let mut wander = NorthEast::new(noise.normal(), noise.normal()) * wander_m;
        let mut elapsed_s = 0.0;
        for heading_rad in [0.4, 0.4 + FRAC_PI_2, 0.4 + PI] {
            voyage.leg(heading_rad, 80.0, |voyage, state| {
                let normal = NorthEast::new(noise.normal(), noise.normal());
                wander = wander * memory + normal * (wander_m * (1.0 - memory * memory).sqrt());
                voyage.position_error = wander + NorthEast::new(noise.normal(), noise.normal()) * white_m;
                let believed = reckoning.correct(DT_S, state).position;
                elapsed_s += DT_S;
                if elapsed_s > 60.0 {
                    told_m2 += (state.position - voyage.position).norm().powi(2);
                    believed_m2 += (believed - voyage.position).norm().powi(2);
                    count += 1.0;
                }
            });
        }
    }
    (f64::sqrt(told_m2 / count), f64::sqrt(believed_m2 / count))
}

#[test]
fn a_wandering_position_is_put_right_by_the_velocity() {
    let (told_m, believed_m) = position_errors(0.1, 0.5);
    println!("told {told_m:.3} m, believed {believed_m:.3} m");
    assert!(believed_m < 0.9 * told_m, "{told_m} {believed_m}");
    let (told_m, believed_m) = position_errors(0.02, 0.05);
    assert!(believed_m < 1.02 * told_m, "{told_m} {believed_m}");
}

#[test]
fn a_jump_of_the_position_teaches_no_velocity() {
    let mut voyage = Voyage::new();
    let mut reckoning = DeadReckoning::default();
    voyage.leg(0.3, 30.0, |_, state| _ = reckoning.correct(DT_S, state));
    voyage.position += NorthEast::new(0.0, 25.0);
    voyage.leg(0.3, 60.0, |_, state| _ = reckoning.correct(DT_S, state));
    assert!(reckoning.offset_mps().iter().all(|part| part.abs() < 1.0e-6), "{reckoning:?}");
}

proptest! {
    #[test]
    fn no_position_makes_the_state_worse_than_the_limits(
        places in prop::collection::vec((-30.0..30.0f64, -30.0..30.0f64, -PI..PI, 0.001..1.0f64), 1..200),
    ) {
        let mut reckoning = DeadReckoning::default();
        for (north, east, heading, dt_s) in places {
            let position = NorthEast::new(0.1 * north, 0.1 * east);
            let state = VesselState { position, heading_rad: heading, ..VesselState::default() };
            let better = reckoning.correct(dt_s, &state);
            prop_assert!(better.surge_mps.abs() <= MOST_OFFSET_MPS && better.sway_mps.abs() <= MOST_OFFSET_MPS);
            prop_assert!((better.position - position).norm() <= JUMP_M);
            prop_assert!(reckoning.covariance.diagonal().iter().all(|variance| variance.re >= 0.0));
        }
    }
}
