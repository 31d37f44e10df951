use std::f64::consts::PI;

use helmlink_mission::path::PathLimits;
use proptest::prelude::*;

use super::*;

/// The speed with every place of the horizon looked at in full.
fn every_place(
    limits: &SpeedLimits,
    path: &Path,
    progress_m: f64,
    speed_mps: f64,
    current: NorthEast,
) -> f64 {
    let step_m = 0.5 * speed_mps * speed_mps / limits.deceleration_mps2 / (SAMPLES - 1) as f64;
    let allowed_squared = (0..SAMPLES).fold(speed_mps * speed_mps, |allowed_squared, sample| {
        let ahead_m = sample as f64 * step_m;
        let there = limits.bend_speed_mps(path.direction(progress_m + ahead_m), current).min(speed_mps);
        allowed_squared.min(there * there + 2.0 * limits.deceleration_mps2 * ahead_m)
    });
    let creep_mps = limits.creep_mps.max(CREEP_PER_CURRENT * current.norm());
    allowed_squared.sqrt().max(creep_mps.min(speed_mps))
}

proptest! {
    #[test]
    fn places_that_are_passed_over_change_nothing(
        progress_m in -5.0..120.0f64, speed_mps in 0.2..4.0f64, current_mps in 0.0..2.0f64, toward in -PI..PI,
        turn_rate_radps in 0.02..1.0f64, lateral_acceleration_mps2 in 0.05..2.0f64,
        deceleration_mps2 in 0.05..1.0f64, still in any::<bool>(),
    ) {
        let points = [(0.0, 0.0), (40.0, 0.0), (40.0, 30.0), (10.0, 40.0)].map(|(n, e)| NorthEast::new(n, e));
        let path = Path::through(&points, &PathLimits::new(6.0, 4.0)).unwrap();
        let limits =
            SpeedLimits { turn_rate_radps, lateral_acceleration_mps2, deceleration_mps2, creep_mps: 0.1 };
        let current = unit(toward) * if still { 0.0 } else { current_mps };
        let speed = limits.speed_mps(&path, progress_m, speed_mps, current, EndOfPath::RunThrough);
        prop_assert_eq!(speed, every_place(&limits, &path, progress_m, speed_mps, current));
    }
}
