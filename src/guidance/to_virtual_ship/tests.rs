use std::f64::consts::PI;

use proptest::prelude::*;

use super::*;
use crate::control::Boat;
use crate::guidance::tests::{H_S, at, bent_path, state};
use crate::guidance::{Water, unit};

fn guidance() -> ToVirtualShip {
    let boat = Boat::embedded("otter").unwrap();
    ToVirtualShip::new(boat.baselines.pi_smc_paper.guidance, boat.limits, EndOfPath::RunThrough)
}

proptest! {
    #[test]
    fn the_turn_fed_forward_is_the_derivative_of_the_azimuth(
        along_m in 5.0..90.0f64, north in -4.0..4.0f64, east in -4.0..4.0f64, heading in -PI..PI,
    ) {
        let path = bent_path();
        let start = state(path.point(along_m).position + at(north, east), heading);
        // Nearer to the centre of a bend the foot's speed is limited, and the aim is not the ship's.
        let foot = project(&path, start.position, along_m);
        prop_assume!(1.0 - foot.foot.curvature_radpm * foot.cross_track_m > 0.35);
        let mut guidance = guidance();
        guidance.engage(&start, along_m);
        let mut look = |time_s: f64| {
            let state = VesselState { position: start.position + start.ground_velocity() * time_s, ..start };
            guidance.step(H_S, &GuidanceInput { state: &state, path: &path, speed_mps: 1.2, water: Water::default() })
        };
        // The first tick takes the place on the path from the boat's, which may move the virtual ship at a jump.
        look(0.0);
        let seen = [look(H_S), look(2.0 * H_S), look(3.0 * H_S)];
        let fed = seen[1].heading_rate_radps;
        // Where the blend's aim passes through zero no direction has a derivative.
        prop_assume!(fed.abs() < 5.0 && (seen[2].lead_m - seen[0].lead_m).abs() < 10.0 * H_S);
        // Where the path's curvature or the blend sets in, the aim turns differently before and after: either is right.
        let before = ssa(seen[1].heading_rad - seen[0].heading_rad) / H_S;
        let after = ssa(seen[2].heading_rad - seen[1].heading_rad) / H_S;
        let tolerance = 5.0e-3 * (1.0 + before.powi(2).max(after.powi(2)));
        let between = before.min(after) - tolerance..before.max(after) + tolerance;
        prop_assert!(between.contains(&fed), "{before} {fed} {after}");
    }

    #[test]
    fn the_speed_wanted_makes_the_distance_go_to_the_lead(
        bearing in -PI..PI, off in -1.0..1.0f64, distance_part in 0.5..1.6f64, sway in -0.2..0.2f64,
    ) {
        let path = bent_path();
        let mut guidance = guidance();
        let lead_m = guidance.settings.lead_at_m(1.2);
        let here = path.point(20.0);
        // Somewhere around the virtual ship; the foot of the boat only moves the ship.
        let position = here.position - unit(bearing) * (distance_part * lead_m);
        let boat = VesselState { sway_mps: sway, ..state(position, bearing + off) };
        guidance.engage(&boat, project(&path, position, 20.0).progress_m);
        let reference =
            guidance.step(H_S, &GuidanceInput { state: &boat, path: &path, speed_mps: 1.2, water: Water::default() });
        prop_assume!(reference.heading_error_rad.cos() > LEAST_COSINE);
        prop_assume!((0.01..guidance.limits.speed_max_mps - 0.01).contains(&reference.speed_mps));
        let velocity = VesselState { surge_mps: reference.speed_mps, ..boat }.ground_velocity();
        let ship = path.point(guidance.ship.progress_m());
        let gap = |t: f64| {
            (ship.position + unit(ship.heading_rad) * (guidance.ship.speed_mps() * t) - position - velocity * t).norm()
        };
        prop_assume!(gap(0.0) > NEAR_PART * lead_m);
        let measured = (gap(H_S) - gap(-H_S)) / (2.0 * H_S);
        let slope = 1.2 / guidance.settings.lead_softness_m;
        prop_assert!((measured + slope * (gap(0.0) - lead_m)).abs() < 1.0e-3, "{measured}");
    }
}
