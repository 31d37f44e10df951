use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use proptest::prelude::*;

use super::*;

fn at(north_m: f64, east_m: f64) -> NorthEast {
    NorthEast::new(north_m, east_m)
}

fn path(points: &[(f64, f64)], limits: &PathLimits) -> Path {
    let points: Vec<NorthEast> = points.iter().map(|(north_m, east_m)| at(*north_m, *east_m)).collect();
    Path::through(&points, limits).unwrap()
}

/// Points some legs of 5 to 150 m apart, at any course change, reversals included.
fn any_points() -> impl Strategy<Value = Vec<NorthEast>> {
    let turn = prop_oneof![
        4 => -PI..PI,
        1 => prop_oneof![Just(0.0), Just(PI), Just(-PI), Just(FRAC_PI_2), Just(1e-7), Just(PI - 1e-7), Just(HAIRPIN_RAD)],
    ];
    let legs = prop::collection::vec((5.0..150.0, turn), 1..12);
    (-PI..PI, legs).prop_map(|(mut bearing_rad, legs)| {
        let mut points = vec![at(-30.0, 70.0)];
        for (length_m, turn_rad) in legs {
            let last = points[points.len() - 1];
            points.push(last + NorthEast::from_polar(length_m, bearing_rad));
            bearing_rad += turn_rad;
        }
        points
    })
}

fn any_limits() -> impl Strategy<Value = PathLimits> {
    let swing = prop_oneof![3 => Just(0.0), 1 => Just(1.0), 1 => 0.0..1.0];
    (0.5..15.0, 0.05..4.0, swing).prop_map(|(min_radius_m, transition_share, swing)| PathLimits {
        min_radius_m,
        transition_m: min_radius_m * transition_share,
        swing,
    })
}

fn any_path() -> impl Strategy<Value = (Path, PathLimits)> {
    (any_points(), any_limits())
        .prop_map(|(points, limits)| (Path::through(&points, &limits).unwrap(), limits))
}

#[test]
fn a_right_angle_by_hand() {
    // With a short transition the turn is close to an arc: tangent R, cut R(√2 − 1).
    let path = path(&[(0.0, 0.0), (50.0, 0.0), (50.0, 50.0)], &PathLimits::new(10.0, 0.01));
    let corner = path.corners()[0];
    assert!((corner.tangent_m - 10.0).abs() < 0.01, "{corner:?}");
    assert!((corner.cut_m - 10.0 * (2f64.sqrt() - 1.0)).abs() < 0.01);
    assert!((corner.radius_m - 10.0).abs() < 1e-12 && corner.scale == 1.0);
    assert!((path.length_m() - (80.0 + 5.0 * PI)).abs() < 0.02);
    let middle = path.point(path.waypoint_s_m(1));
    assert!((middle.heading_rad - FRAC_PI_4).abs() < 1e-12);
    assert!(
        (middle.position - at(50.0 - corner.cut_m / 2f64.sqrt(), corner.cut_m / 2f64.sqrt())).norm() < 1e-9
    );
}

#[test]
fn a_turn_too_wide_for_its_legs_is_drawn_smaller() {
    let lanes = [(0.0, 0.0), (60.0, 0.0), (60.0, 6.0), (0.0, 6.0)];
    let path = path(&lanes, &PathLimits::new(4.0, 2.0));
    for corner in path.corners() {
        assert!((corner.tangent_m - 3.0).abs() < 1e-9, "{corner:?}");
        assert!(corner.scale < 1.0 && (corner.radius_m - 4.0 * corner.scale).abs() < 1e-9);
    }
}

#[test]
fn an_exact_reversal_turns_through_the_waypoint() {
    let limits = PathLimits::new(4.0, 1.5);
    let path = path(&[(0.0, 0.0), (80.0, 0.0), (0.0, 0.0)], &limits);
    let corner = path.corners()[0];
    assert_eq!((corner.cut_m, corner.scale), (0.0, 1.0));
    assert!((path.point(path.waypoint_s_m(1)).position - at(80.0, 0.0)).norm() < 1e-9);
    for i in 0..=2000 {
        let position = path.point(path.length_m() * f64::from(i) / 2000.0).position;
        assert!(
            position.north_m < 80.0 + 1e-9 && position.east_m.abs() < limits.min_radius_m + 1.0,
            "{position:?}"
        );
    }
}

#[test]
fn a_swing_halves_the_distance_from_the_legs() {
    let largest_m = |swing| {
        let limits = PathLimits::new(5.0, 1.0).with_swing(swing);
        let path = path(&[(0.0, 0.0), (60.0, 0.0), (60.0, 60.0)], &limits);
        (0..4000)
            .map(|i| path.point(path.length_m() * f64::from(i) / 4000.0).position)
            .map(|position| path.distance_to_leg(position, 0).min(path.distance_to_leg(position, 1)))
            .fold(0.0, f64::max)
    };
    assert!((largest_m(0.5) / largest_m(0.0) - 0.5).abs() < 0.05, "{} {}", largest_m(0.5), largest_m(0.0));
}

#[test]
fn goes_straight_on_before_and_after() {
    let path = path(&[(0.0, 0.0), (0.0, 20.0), (20.0, 20.0)], &PathLimits::new(3.0, 1.0));
    assert!((path.point(-7.0).position - at(0.0, -7.0)).norm() < 1e-12);
    assert!((path.point(path.length_m() + 5.0).position - at(25.0, 20.0)).norm() < 1e-9);
    assert_eq!((path.leg_at(-7.0), path.leg_at(path.length_m() + 5.0)), (0, 1));
    assert!((path.project(at(3.0, -9.0), 1.0) - -9.0).abs() < 1e-9);
    assert!((path.project(at(29.0, 21.0), path.length_m()) - (path.length_m() + 9.0)).abs() < 1e-9);
}

#[test]
fn starboard_is_positive() {
    let path = path(&[(0.0, 0.0), (100.0, 0.0)], &PathLimits::new(5.0, 1.0));
    assert_eq!(path.cross_track_m(at(20.0, 3.0), 20.0), 3.0);
    assert_eq!(path.cross_track_m(at(20.0, -3.0), 20.0), -3.0);
    assert_eq!(path.distance_to_leg(at(20.0, -3.0), 0), 3.0);
    assert_eq!(path.distance_to_leg(at(104.0, 3.0), 99), 5.0);
}

#[test]
fn the_projection_stays_on_its_lane() {
    let lanes = [(0.0, 0.0), (60.0, 0.0), (60.0, 6.0), (0.0, 6.0)];
    let path = path(&lanes, &PathLimits::new(3.0, 1.0));
    // Nearer to the second lane, but on the way up the first.
    assert!((path.project(at(30.0, 5.0), 28.0) - 30.0).abs() < 1e-9);
    // A boat swept past the corner waits at the turn, then follows it round.
    let swept = |angle_rad| at(60.0, 3.0) + NorthEast::from_polar(5.0, angle_rad - FRAC_PI_2);
    let mut s_m = path.project(swept(0.0), 55.0);
    for i in 0..200 {
        let position = swept(PI * f64::from(i) / 199.0);
        let next_s_m = path.project(position, s_m);
        assert!(next_s_m >= s_m - 1e-9 && next_s_m - s_m < 1.0, "{s_m} to {next_s_m}");
        s_m = next_s_m;
    }
    assert_eq!(path.leg_at(s_m), 2);
}

#[test]
fn refuses_what_cannot_be_drawn_and_says_why() {
    let limits = PathLimits::new(3.0, 1.0);
    let refuse = |points: &[NorthEast], limits: PathLimits| Path::through(points, &limits).unwrap_err();
    let two = [at(0.0, 0.0), at(9.0, 0.0)];
    assert_eq!(refuse(&two[..1], limits), PathError::TooFewPoints(1));
    assert_eq!(refuse(&[two[0], two[1], two[1]], limits), PathError::Coincident(1));
    assert_eq!(refuse(&[two[0], at(f64::NAN, 0.0)], limits), PathError::NotLocal(1));
    assert_eq!(refuse(&two, PathLimits::new(0.0, 1.0)), LimitsError::Radius(0.0).into());
    assert_eq!(refuse(&two, PathLimits::new(1.0, -1.0)), LimitsError::Transition(-1.0).into());
    assert_eq!(refuse(&two, limits.with_swing(1.5)), LimitsError::Swing(1.5).into());
    assert!(refuse(&[two[0], two[0]], limits).to_string().contains("points 0 and 1"));
}

#[test]
fn nothing_that_is_not_a_number_panics() {
    let path = path(&[(0.0, 0.0), (0.0, 20.0), (20.0, 20.0)], &PathLimits::new(3.0, 1.0));
    assert!(!path.point(f64::NAN).position.is_finite());
    assert_eq!(path.project(at(f64::NAN, 1.0), 4.0), 4.0);
    assert!(path.project(at(1.0, 1.0), f64::NAN).is_nan());
    path.max_curvature(f64::NAN, f64::INFINITY);
    path.leg_at(f64::NAN);
    assert!((path.project(at(1e9, -1e9), 4.0) - 4.0).abs() <= PROJECTION_WINDOW_M + 1e-9);
}

proptest! {
    #[test]
    fn segments_join_in_position_heading_and_curvature((path, _) in any_path()) {
        for pair in path.segments.windows(2) {
            let (before, after) = (pair[0].point(pair[0].length_m), pair[1].point(0.0));
            prop_assert!((before.position - after.position).norm() < 1e-8, "{before:?} {after:?}");
            prop_assert!((before.heading_rad - after.heading_rad).abs() < 1e-8);
            prop_assert!((before.curvature_radpm - after.curvature_radpm).abs() < 1e-8);
            prop_assert!((pair[0].end_s_m() - pair[1].start_s_m).abs() < 1e-8);
        }
        let (first, last) = (path.points()[0], path.points()[path.leg_count()]);
        prop_assert!((path.point(0.0).position - first).norm() < 1e-9);
        prop_assert!((path.point(path.length_m()).position - last).norm() < 1e-8);
    }

    #[test]
    fn the_direction_is_that_of_the_point((path, _) in any_path(), share in -0.1..1.1) {
        let s_m = share * path.length_m();
        let (point, direction) = (path.point(s_m), path.direction(s_m));
        prop_assert_eq!(
            (direction.heading_rad, direction.curvature_radpm),
            (point.heading_rad, point.curvature_radpm)
        );
    }

    #[test]
    fn heading_and_curvature_are_the_derivatives((path, _) in any_path(), share in 0.0..1.0) {
        let s_m = share * path.length_m();
        let sharpest = path.corners().iter().map(|corner| 1.0 / corner.radius_m).fold(0.0, f64::max);
        let step_m = 1e-4 / sharpest.max(1.0);
        let (before, here, after) = (path.point(s_m - step_m), path.point(s_m), path.point(s_m + step_m));
        let moved = after.position - before.position;
        prop_assert!((moved - NorthEast::from_polar(2.0 * step_m, here.heading_rad)).norm() < 1e-3 * step_m);
        let turned_rad = after.heading_rad - before.heading_rad;
        // The mean curvature over the step differs from that in its middle by no more than the curvature does.
        let ends = [before, after].map(|end| (end.curvature_radpm - here.curvature_radpm).abs());
        let peak = path.max_curvature(s_m - step_m, s_m + step_m) - here.curvature_radpm.abs();
        let bound = ends[0].max(ends[1]).max(peak) + 1e-6 * sharpest.max(1.0);
        prop_assert!((turned_rad / (2.0 * step_m) - here.curvature_radpm).abs() < bound);
    }

    #[test]
    fn curvature_keeps_the_limit_where_the_corner_fits((path, limits) in any_path()) {
        for corner in path.corners() {
            let s_m = path.waypoint_s_m(corner.waypoint);
            let reach_m = 0.5 * corner.tangent_m;
            let largest = path.max_curvature(s_m - reach_m, s_m + reach_m);
            if corner.scale == 1.0 {
                prop_assert!(corner.radius_m > limits.min_radius_m * (1.0 - 1e-9));
            } else {
                prop_assert!(corner.scale < 1.0 && corner.radius_m >= limits.min_radius_m * corner.scale * (1.0 - 1e-9));
            }
            prop_assert!(largest <= (1.0 + 1e-9) / corner.radius_m, "{largest} {corner:?}");
        }
        let sharpest = path.corners().iter().map(|corner| 1.0 / corner.radius_m).fold(0.0, f64::max);
        prop_assert!(path.max_curvature(-5.0, path.length_m() + 5.0) <= sharpest * (1.0 + 1e-9));
    }

    #[test]
    fn corners_are_where_they_say((path, _) in any_path()) {
        for corner in path.corners() {
            let waypoint = path.points()[corner.waypoint];
            let leg_m = [-1isize, 1].map(|side| {
                (path.points()[corner.waypoint.wrapping_add_signed(side)] - waypoint).norm()
            });
            prop_assert!(corner.tangent_m <= 0.5 * leg_m[0].min(leg_m[1]) + 1e-9);
            let s_m = path.waypoint_s_m(corner.waypoint);
            prop_assert!(((path.point(s_m).position - waypoint).norm() - corner.cut_m).abs() < 1e-7, "{corner:?}");
            prop_assert!(corner.cut_m >= 0.0 && corner.cut_m <= corner.tangent_m);
            prop_assert_eq!(path.leg_at(s_m + 1e-6), corner.waypoint);
            prop_assert_eq!(path.leg_at(s_m - 1e-6), corner.waypoint - 1);
        }
    }

    #[test]
    fn never_further_from_its_legs_than_a_turn_needs((path, limits) in any_path(), share in 0.0..1.0) {
        let s_m = share * path.length_m();
        let leg = path.leg_at(s_m);
        let position = path.point(s_m).position;
        let distance_m = path.distance_to_leg(position, leg)
            .min(path.distance_to_leg(position, leg + 1))
            .min(path.distance_to_leg(position, leg.saturating_sub(1)));
        prop_assert!(distance_m <= 1.1 * limits.min_radius_m + limits.transition_m, "{distance_m}");
    }

    #[test]
    fn projects_its_own_points_on_themselves((path, _) in any_path(), share in -0.1..1.1, offset in -1.0..1.0) {
        let s_m = share * path.length_m();
        let sharpest = path.corners().iter().map(|corner| 1.0 / corner.radius_m).fold(0.01_f64, f64::max);
        // From within half a radian of turning the path does not come back on itself.
        let near_s_m = s_m + 0.5 * offset / sharpest;
        prop_assert!((path.project(path.point(s_m).position, near_s_m) - s_m).abs() < 1e-6);
    }

    #[test]
    fn the_projection_of_a_point_beside_the_path_is_its_foot(
        (path, _) in any_path(), share in 0.0..1.0, side in -0.7..0.7_f64, offset in -1.0..1.0,
    ) {
        let s_m = share * path.length_m();
        let sharpest = path.corners().iter().map(|corner| 1.0 / corner.radius_m).fold(0.01_f64, f64::max);
        let point = path.point(s_m);
        let starboard = NorthEast::from_polar(1.0, point.heading_rad).starboard();
        let position = point.position + starboard * (side / sharpest);
        let foot_s_m = path.project(position, s_m + 0.1 * offset / sharpest);
        prop_assert!((foot_s_m - s_m).abs() < 1e-6, "{foot_s_m} for {s_m}");
        prop_assert!((path.cross_track_m(position, foot_s_m) - side / sharpest).abs() < 1e-6);
    }

    #[test]
    fn the_projection_of_anything_is_a_foot_or_the_window(
        (path, _) in any_path(), share in 0.0..1.0, north_m in -500.0..500.0, east_m in -500.0..500.0,
    ) {
        let near_s_m = share * path.length_m();
        let position = at(north_m, east_m);
        let foot_s_m = path.project(position, near_s_m);
        let distance_m = |s_m: f64| (path.point(s_m).position - position).norm();
        prop_assert!((foot_s_m - near_s_m).abs() <= PROJECTION_WINDOW_M + 1e-9);
        prop_assert!(distance_m(foot_s_m) <= distance_m(near_s_m) + 1e-9);
        if (foot_s_m - near_s_m).abs() < PROJECTION_WINDOW_M - 1e-6 {
            let tangent = NorthEast::from_polar(1.0, path.point(foot_s_m).heading_rad);
            prop_assert!((position - path.point(foot_s_m).position).dot(tangent).abs() < 1e-5);
        }
    }
}
