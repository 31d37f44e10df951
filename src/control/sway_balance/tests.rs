use std::f64::consts::{FRAC_PI_2, PI};

use proptest::prelude::*;

use super::*;

const DT_S: f64 = 0.04;

/// A boat that runs for `seconds` on each heading, in a current, with a wrong compass.
struct Voyage {
    current: NorthEast,
    compass_offset_rad: f64,
}

impl Voyage {
    fn new() -> Self {
        Self { current: NorthEast::new(0.2, -0.15), compass_offset_rad: 0.0 }
    }

    /// Runs a leg; hands every measurement over.
    fn leg(&mut self, heading_rad: f64, seconds: f64, mut take: impl FnMut(&VesselState)) {
        let bow = unit(heading_rad);
        let velocity = bow * 1.2 + self.current;
        for _ in 0..(seconds / DT_S) as u32 {
            let seen = unit(heading_rad + self.compass_offset_rad);
            take(&VesselState {
                heading_rad: heading_rad + self.compass_offset_rad,
                surge_mps: seen.dot(velocity),
                sway_mps: seen.cross(velocity),
                ..VesselState::default()
            });
        }
    }
}

#[test]
fn on_one_course_nothing_is_known_of_the_compass_and_that_is_told() {
    let mut voyage = Voyage { compass_offset_rad: 0.05, ..Voyage::new() };
    let mut compass = SwayBalance::new(0.5);
    voyage.leg(0.4, 600.0, |state| compass.learn(DT_S, state, 0.0));
    let CompassError { offset_rad, deviation_rad } = compass.compass();
    assert!(deviation_rad > 0.8 * START[2], "{deviation_rad}");
    assert!(offset_rad.abs() < 0.05, "not more than its share of what was seen: {offset_rad}");
}

#[test]
fn turns_tell_the_compass_from_the_current() {
    for compass_offset_rad in [0.05, -0.03, 0.0] {
        // There and back is enough; so are three sides of a box.
        for legs in [&[0.4, 0.4 + PI, 0.4][..], &[0.0, FRAC_PI_2, PI]] {
            let mut voyage = Voyage { compass_offset_rad, ..Voyage::new() };
            let mut compass = SwayBalance::new(0.5);
            for heading_rad in legs {
                voyage.leg(*heading_rad, 60.0, |state| compass.learn(DT_S, state, 0.0));
            }
            let CompassError { offset_rad, deviation_rad } = compass.compass();
            assert!(
                (offset_rad - compass_offset_rad).abs() < 2.0 * deviation_rad.max(2.0e-3),
                "{offset_rad}"
            );
            assert!(deviation_rad < 0.02, "{legs:?}: {deviation_rad}");
            // Then course over ground, current and heading belong together.
            let heading_rad = legs[legs.len() - 1];
            let course = (unit(heading_rad) * 1.2 + voyage.current).bearing_rad();
            let told = heading_rad + compass_offset_rad - offset_rad;
            let through_water = unit(told) * 1.2 + compass.current();
            assert!((through_water.bearing_rad() - course).abs() < 0.02, "{legs:?}");
        }
    }
}

/// A box of turns, each as long as its leg, by a hull that sways `1 + excess` times as much as its model.
fn box_of_turns(balance: &mut SwayBalance, excess: f64) {
    let current = NorthEast::new(0.2, -0.15);
    let mut heading_rad: f64 = 0.3;
    for step in 0..(240.0 / DT_S) as u32 {
        let rate_radps = if f64::from(step) * DT_S % 14.0 < 7.0 { 0.0 } else { FRAC_PI_2 / 7.0 };
        heading_rad += rate_radps * DT_S;
        let model_sway_mps = -0.5 * rate_radps;
        let bow = unit(heading_rad);
        let state = VesselState {
            heading_rad,
            surge_mps: 1.2 + bow.dot(current),
            sway_mps: (1.0 + excess) * model_sway_mps + bow.cross(current),
            yaw_rate_radps: rate_radps,
            ..VesselState::default()
        };
        balance.learn(DT_S, &state, model_sway_mps);
    }
}

#[test]
fn turns_tell_how_much_the_hull_skids() {
    for excess in [-0.5, -0.3, 0.0, 0.5] {
        let mut balance = SwayBalance::new(0.5);
        box_of_turns(&mut balance, excess);
        assert!((balance.excess() - excess).abs() < 0.05, "{excess}: {}", balance.excess());
        assert!((balance.current() - NorthEast::new(0.2, -0.15)).norm() < 0.01, "{excess}");
        assert!(balance.compass().offset_rad.abs() < 0.01, "{excess}: {:?}", balance.compass());
    }
}

#[test]
fn without_a_spread_the_model_is_taken_as_it_is() {
    let mut balance = SwayBalance::new(0.0);
    box_of_turns(&mut balance, -0.5);
    assert_eq!(balance.excess(), 0.0);
}

proptest! {
    #[test]
    fn no_sway_teaches_more_than_the_limits(
        seen in prop::collection::vec((-PI..PI, -5.0..5.0f64, -5.0..5.0f64, -3.0..3.0f64, 0.001..1.0f64), 1..200),
    ) {
        let mut balance = SwayBalance::new(2.0);
        for (heading_rad, surge_mps, sway_mps, model_sway_mps, dt_s) in seen {
            let state = VesselState { heading_rad, surge_mps, sway_mps, ..VesselState::default() };
            balance.learn(dt_s, &state, model_sway_mps);
            prop_assert!((EXCESS.0..=EXCESS.1).contains(&balance.excess()));
        }
    }
}
