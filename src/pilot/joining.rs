//! How a boat that is somewhere beside a leg is led onto it.

use helmlink_mission::geodesy::NorthEast;

use super::stretch::AT_WAYPOINT_M;

/// A boat off its leg comes back to it this many times farther ahead than it is off: at an angle of 27°.
const SLANT: f64 = 2.0;

/// A straight leg between two waypoints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leg {
    start: NorthEast,
    end: NorthEast,
}

impl Leg {
    pub(super) fn new(start: NorthEast, end: NorthEast) -> Self {
        Self { start, end }
    }

    pub(super) fn length_m(&self) -> f64 {
        (self.end - self.start).norm()
    }

    /// Along its direction, which is a number for any leg longer than nothing.
    pub(super) fn direction(&self) -> NorthEast {
        let length_m = self.length_m();
        if length_m > 0.0 { (self.end - self.start) * (1.0 / length_m) } else { NorthEast::new(0.0, 0.0) }
    }

    /// How far along the leg a position is, metres: below zero before its start, above its length past its end.
    pub(super) fn along_m(&self, position: NorthEast) -> f64 {
        (position - self.start).dot(self.direction())
    }

    /// Distance of a position to the nearest point of the leg, metres.
    pub(super) fn distance_m(&self, position: NorthEast) -> f64 {
        (position - self.at(self.along_m(position).clamp(0.0, self.length_m()))).norm()
    }

    fn at(&self, along_m: f64) -> NorthEast {
        self.start + self.direction() * along_m
    }
}

/// The points through which a boat at `position` begins its path to the end of `leg`, which itself is left out:
/// its own position where there is no leg, its foot on the leg where it is on it, else its position and a point
/// ahead on the leg. Where the slant would need more room than the leg has left, that is the straight line.
///
/// `turn_m`: distance within which the boat cannot be expected to make two turns, metres.
pub(super) fn lead(position: NorthEast, leg: Option<&Leg>, turn_m: f64) -> Vec<NorthEast> {
    let Some(leg) = leg else { return vec![position] };
    let along_m = leg.along_m(position);
    let off_m = (position - leg.at(along_m)).norm();
    let length_m = leg.length_m();
    if off_m <= AT_WAYPOINT_M && (0.0..length_m - AT_WAYPOINT_M).contains(&along_m) {
        return vec![leg.at(along_m)];
    }
    let joins_m = (along_m + (SLANT * off_m).max(SLANT * turn_m)).max(0.0);
    if joins_m + turn_m < length_m { vec![position, leg.at(joins_m)] } else { vec![position] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const fn at(north_m: f64, east_m: f64) -> NorthEast {
        NorthEast { north_m, east_m }
    }

    const LEG: Leg = Leg { start: at(0.0, 0.0), end: at(100.0, 0.0) };

    #[test]
    fn on_the_leg_it_begins_where_the_boat_is() {
        assert_eq!(lead(at(40.0, 0.5), Some(&LEG), 4.0), [at(40.0, 0.0)]);
    }

    #[test]
    fn beside_it_the_boat_comes_back_ahead() {
        assert_eq!(lead(at(40.0, -10.0), Some(&LEG), 4.0), [at(40.0, -10.0), at(60.0, 0.0)]);
        assert_eq!(lead(at(40.0, 2.0), Some(&LEG), 4.0), [at(40.0, 2.0), at(48.0, 0.0)]);
        assert_eq!(lead(at(-30.0, 3.0), Some(&LEG), 4.0), [at(-30.0, 3.0), at(0.0, 0.0)], "not before it");
    }

    #[test]
    fn near_its_end_and_without_a_leg_it_goes_straight() {
        assert_eq!(lead(at(90.0, 10.0), Some(&LEG), 4.0), [at(90.0, 10.0)]);
        assert_eq!(lead(at(120.0, 0.0), Some(&LEG), 4.0), [at(120.0, 0.0)]);
        assert_eq!(lead(at(40.0, 10.0), None, 4.0), [at(40.0, 10.0)]);
    }

    proptest! {
        #[test]
        fn it_never_leads_back_nor_off_the_leg(
            north_m in -200.0..200.0f64, east_m in -200.0..200.0f64,
            end_north_m in -300.0..300.0f64, end_east_m in -300.0..300.0f64, turn_m in 0.5..20.0f64,
        ) {
            let leg = Leg::new(at(3.0, -2.0), at(end_north_m, end_east_m));
            prop_assume!(leg.length_m() > 1.0);
            let position = at(north_m, east_m);
            let points = lead(position, Some(&leg), turn_m);
            let last = *points.last().unwrap();
            prop_assert!(points.len() == 1 || points[0] == position);
            prop_assert!(leg.along_m(last) >= leg.along_m(position) - 1e-6, "{points:?}");
            prop_assert!(last == position || leg.distance_m(last) < 1e-6, "{points:?}");
        }
    }
}
