//! Turns around a place, with clothoids into and out of the circle.

use super::build::Pen;
use super::segment::Shape;
use super::{MIN_LEG_M, Path, PathError, PathLimits, clothoid};
use crate::angle::wrap_positive;
use crate::geodesy::NorthEast;
use std::f64::consts::TAU;

/// The transition into a circle is at most this share of its radius.
const LONGEST_TRANSITION: f64 = 0.75;

/// A circle to be run along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orbit {
    /// Its middle.
    pub centre: NorthEast,
    /// Its radius, metres, above 0.
    pub radius_m: f64,
    /// How many turns at least; the path goes on along the circle until it points where it has to go next.
    pub turns: f64,
    /// To starboard.
    pub clockwise: bool,
}

/// The clothoid between a straight line and a circle.
struct Transition {
    length_m: f64,
    turned_rad: f64,
    /// Length along the line from the clothoid's start to abeam of the centre.
    along_m: f64,
    /// Distance of the centre from the line.
    away_m: f64,
}

impl Transition {
    fn new(orbit: &Orbit, limits: &PathLimits) -> Self {
        let length_m = limits.transition_m.min(LONGEST_TRANSITION * orbit.radius_m);
        let turned_rad = 0.5 * length_m / orbit.radius_m;
        let end = clothoid::displacement(length_m, 1.0 / (orbit.radius_m * length_m));
        Self {
            length_m,
            turned_rad,
            along_m: end.north_m - orbit.radius_m * turned_rad.sin(),
            away_m: end.east_m + orbit.radius_m * turned_rad.cos(),
        }
    }
}

impl Path {
    /// The path through `points` (at least one) and then around `orbit`; afterwards on toward `next`, if there
    /// is one and it lies outside of the circle. [`Path::waypoint_s_m`] after the last point is where the turns
    /// are complete.
    ///
    /// A single point too close to the circle for a way into it makes the path begin on the circle, beside the
    /// point.
    ///
    /// # Errors
    /// As [`Path::through`]; [`PathError::InCircle`] when the last of several points is too close to the circle;
    /// an orbit without a radius.
    pub fn around(
        points: &[NorthEast],
        orbit: &Orbit,
        next: Option<NorthEast>,
        limits: &PathLimits,
    ) -> Result<Self, PathError> {
        limits.check()?;
        let Some(last) = points.last().copied() else { return Err(PathError::TooFewPoints(0)) };
        let is_length = |length_m: f64| length_m.is_finite() && length_m > MIN_LEG_M;
        if !is_length(orbit.radius_m) || !orbit.turns.is_finite() || !orbit.centre.is_finite() {
            return Err(PathError::Orbit(orbit.radius_m));
        }
        let transition = Transition::new(orbit, limits);
        let side = if orbit.clockwise { 1.0 } else { -1.0 };
        let approach = tangent_length_m(last, orbit.centre, transition.away_m)
            .map(|line_m| line_m - transition.along_m)
            .filter(|line_m| *line_m > MIN_LEG_M);
        let (mut path, mut pen) = match approach {
            Some(line_m) => {
                let to_centre = orbit.centre - last;
                let off_rad = (transition.away_m / to_centre.norm()).asin();
                let bearing_rad = to_centre.bearing_rad() - side * off_rad;
                let entry = last + NorthEast::from_polar(line_m, bearing_rad);
                let path = Self::through(&[points, &[entry]].concat(), limits)?;
                let end = path.point(path.length_m);
                let pen = Pen {
                    segments: path.segments.clone(),
                    position: end.position,
                    heading_rad: end.heading_rad,
                    s_m: path.length_m,
                };
                (path, pen)
            }
            None if points.len() == 1 => {
                let bearing_rad = (last - orbit.centre).bearing_rad();
                let start = orbit.centre + NorthEast::from_polar(orbit.radius_m, bearing_rad);
                (Self::without_way(last), Pen::at(start, bearing_rad + side * 0.25 * TAU))
            }
            None => return Err(PathError::InCircle(points.len() - 1)),
        };
        let curvature_radpm = side / orbit.radius_m;
        let sharpness_radpm2 = curvature_radpm / transition.length_m;
        if approach.is_some() {
            pen.draw(transition.length_m, Shape::Entry { sharpness_radpm2 });
        }
        let exit_rad = next.and_then(|next| {
            let out = next - orbit.centre;
            tangent_length_m(next, orbit.centre, transition.away_m)
                .filter(|line_m| *line_m > transition.along_m + MIN_LEG_M)
                .map(|_| out.bearing_rad() + side * (transition.away_m / out.norm()).asin())
        });
        let turned_rad = TAU * orbit.turns.max(0.0);
        let more_rad = exit_rad.map_or(0.0, |exit_rad| {
            let arc_ends_rad = exit_rad - side * transition.turned_rad;
            wrap_positive(side * (arc_ends_rad - pen.heading_rad) - turned_rad)
        });
        pen.draw((turned_rad + more_rad) * orbit.radius_m, Shape::Arc { curvature_radpm });
        let done_s_m = pen.s_m;
        if let (Some(_), Some(next)) = (exit_rad, next) {
            pen.draw(transition.length_m, Shape::Exit { sharpness_radpm2 });
            pen.last_line_to(next);
        } else {
            pen.draw(0.0, Shape::Line);
        }
        let (segments, length_m) = (pen.segments, pen.s_m);
        path.segments = segments;
        path.length_m = length_m;
        // The end of the way into the circle stands for the circle.
        if let (Some(point), Some(s_m), Some(leaving_s_m)) =
            (path.points.last_mut(), path.waypoint_s_m.last_mut(), path.leaving_s_m.last_mut())
        {
            *point = orbit.centre;
            *s_m = done_s_m;
            *leaving_s_m = done_s_m;
        }
        Ok(path)
    }

    /// A path from `place` that is still to be drawn.
    fn without_way(place: NorthEast) -> Self {
        Self {
            points: vec![place; 2],
            segments: Vec::new(),
            corners: Vec::new(),
            waypoint_s_m: vec![0.0; 2],
            leaving_s_m: vec![0.0; 2],
            length_m: 0.0,
        }
    }
}

/// Length of the line from `place` to where it touches a circle; none from within.
fn tangent_length_m(place: NorthEast, centre: NorthEast, radius_m: f64) -> Option<f64> {
    let out = place - centre;
    let square_m2 = out.dot(out) - radius_m * radius_m;
    (square_m2 > 0.0).then(|| square_m2.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LIMITS: PathLimits = PathLimits { min_radius_m: 4.0, transition_m: 3.0, swing: 0.0 };

    fn orbit(radius_m: f64, turns: f64, clockwise: bool) -> Orbit {
        Orbit { centre: NorthEast::new(100.0, 20.0), radius_m, turns, clockwise }
    }

    #[test]
    fn two_turns_and_out_again() {
        let orbit = orbit(10.0, 2.0, true);
        let next = NorthEast::new(100.0, 200.0);
        let points = [NorthEast::ZERO, NorthEast::new(50.0, 0.0)];
        let path = Path::around(&points, &orbit, Some(next), &LIMITS).unwrap();
        let done_m = path.waypoint_s_m(2);
        assert!((path.point(path.length_m()).position - next).norm() < 1e-6);
        let turned_m = done_m - path.waypoint_s_m(1);
        assert!(turned_m > 2.0 * TAU * 10.0 && turned_m < 3.0 * TAU * 10.0 + 60.0, "{turned_m}");
        for share in 0..=20 {
            let place = path.point(done_m - f64::from(share) * TAU * 0.1 * 10.0).position;
            assert!(((place - orbit.centre).norm() - 10.0).abs() < 1e-6, "{place:?}");
        }
        assert!(path.point(done_m - 1.0).curvature_radpm > 0.0, "to starboard");
    }

    #[test]
    fn from_within_it_begins_on_the_circle() {
        let orbit = orbit(10.0, 1.0, false);
        let path = Path::around(&[NorthEast::new(101.0, 20.0)], &orbit, None, &LIMITS).unwrap();
        assert!((path.length_m() - TAU * 10.0).abs() < 1e-9);
        assert_eq!(path.waypoint_s_m(1), path.length_m());
        let two = [NorthEast::ZERO, NorthEast::new(101.0, 20.0)];
        assert_eq!(Path::around(&two, &orbit, None, &LIMITS).unwrap_err(), PathError::InCircle(1));
        let none = Orbit { radius_m: 0.0, ..orbit };
        assert_eq!(Path::around(&two, &none, None, &LIMITS).unwrap_err(), PathError::Orbit(0.0));
    }

    proptest! {
        #[test]
        fn heading_and_curvature_have_no_steps(
            north_m in -200.0..200f64, east_m in -200.0..200f64, radius_m in 2.0..40f64, turns in 0.0..3f64,
            clockwise: bool, next in prop::option::of((-300.0..300f64, -300.0..300f64)),
        ) {
            let orbit = orbit(radius_m, turns, clockwise);
            let next = next.map(|(north_m, east_m)| NorthEast::new(north_m, east_m));
            let path = Path::around(&[NorthEast::new(north_m, east_m)], &orbit, next, &LIMITS).unwrap();
            let starts_outside = path.max_curvature(0.0, 0.0) == 0.0;
            let step_m = 0.01;
            let sharpest = 1.0 / (radius_m * LIMITS.transition_m.min(LONGEST_TRANSITION * radius_m));
            let steps = (path.length_m() / step_m) as usize;
            for step in 0..steps {
                let (s_m, more_m) = (step as f64 * step_m, (step + 1) as f64 * step_m);
                let (here, there) = (path.point(s_m), path.point(more_m));
                prop_assert!(((there.position - here.position).norm() - step_m).abs() < 1e-4, "at {s_m}");
                prop_assert!((there.heading_rad - here.heading_rad).abs() < 1.01 * step_m / radius_m + 1e-9);
                // Without a transition out the path ends in the circle.
                if starts_outside && more_m < path.waypoint_s_m(1) {
                    let change = (there.curvature_radpm - here.curvature_radpm).abs();
                    prop_assert!(change <= 1.01 * sharpest * step_m + 1e-9, "{change} at {s_m}");
                }
            }
        }
    }
}
