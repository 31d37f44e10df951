//! The area to stay in or out of.

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_mission::plan::Item;
use helmlink_wire::enums;

/// Corners that a polygon needs.
const LEAST_CORNERS: usize = 3;

/// One part of a fence.
#[derive(Debug, Clone, PartialEq)]
struct Zone {
    shape: Shape,
    /// The boat has to stay inside, rather than outside.
    inclusion: bool,
}

#[derive(Debug, Clone, PartialEq)]
enum Shape {
    Polygon(Vec<NorthEast>),
    Circle { centre: NorthEast, radius_m: f64 },
}

/// A fence as the flight controller keeps it: polygons and circles to stay inside of, all of them at once, and
/// polygons and circles to stay out of.
#[derive(Debug, Clone)]
pub struct Fence {
    frame: LocalFrame,
    zones: Vec<Zone>,
}

impl Fence {
    /// The fence in the items of a fence plan (MAV_MISSION_TYPE_FENCE); `None` when there is none in them.
    ///
    /// Items that are no part of a fence, polygons with less than three corners and circles without radius are
    /// passed over; the return point is not a fence.
    pub fn from_items(items: &[Item]) -> Option<Self> {
        let origin = items.iter().find_map(Item::position)?;
        let frame = LocalFrame::new(origin);
        let mut zones = Vec::new();
        let mut rest = items;
        while let Some((first, others)) = rest.split_first() {
            let (zone, used) = match first.command {
                enums::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION => polygon(&frame, rest, true),
                enums::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION => polygon(&frame, rest, false),
                enums::MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION => (circle(&frame, first, true), 1),
                enums::MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION => (circle(&frame, first, false), 1),
                _ => (None, 1),
            };
            zones.extend(zone);
            rest = rest.get(used..).unwrap_or(others);
        }
        (!zones.is_empty()).then_some(Self { frame, zones })
    }

    /// How far a position is on the wrong side of the fence, metres; zero where it may be.
    pub fn breach_m(&self, position: Geodetic) -> f64 {
        let place = self.frame.to_local(position);
        self.zones.iter().map(|zone| zone.breach_m(place)).fold(0.0, f64::max)
    }
}

impl Zone {
    fn breach_m(&self, place: NorthEast) -> f64 {
        let inside_m = match &self.shape {
            Shape::Polygon(corners) => depth_in_polygon_m(corners, place),
            Shape::Circle { centre, radius_m } => radius_m - (place - *centre).norm(),
        };
        if self.inclusion { -inside_m } else { inside_m }.max(0.0)
    }
}

/// The polygon that starts with the first of `items`, and how many of them it takes.
fn polygon(frame: &LocalFrame, items: &[Item], inclusion: bool) -> (Option<Zone>, usize) {
    let command = items[0].command;
    // Every corner names the number of corners.
    let count = items[0].params[0].max(1.0) as usize;
    let corners: Vec<NorthEast> = items
        .iter()
        .take(count)
        .take_while(|item| item.command == command)
        .filter_map(Item::position)
        .map(|position| frame.to_local(position))
        .collect();
    let used = corners.len().max(1);
    let is_whole = corners.len() == count && count >= LEAST_CORNERS;
    (is_whole.then_some(Zone { shape: Shape::Polygon(corners), inclusion }), used)
}

fn circle(frame: &LocalFrame, item: &Item, inclusion: bool) -> Option<Zone> {
    let radius_m = f64::from(item.params[0]);
    let centre = frame.to_local(item.position()?);
    (radius_m > 0.0).then_some(Zone { shape: Shape::Circle { centre, radius_m }, inclusion })
}

/// Distance to the nearest edge: positive inside, negative outside.
fn depth_in_polygon_m(corners: &[NorthEast], place: NorthEast) -> f64 {
    let mut inside = false;
    let mut nearest_m = f64::INFINITY;
    for (index, &from) in corners.iter().enumerate() {
        let to = corners[(index + 1) % corners.len()];
        nearest_m = nearest_m.min(distance_to_edge_m(place, from, to));
        // Even-odd rule: count the edges that a line to the east crosses.
        if (from.north_m > place.north_m) != (to.north_m > place.north_m) {
            let share = (place.north_m - from.north_m) / (to.north_m - from.north_m);
            if place.east_m < from.east_m + share * (to.east_m - from.east_m) {
                inside = !inside;
            }
        }
    }
    if inside { nearest_m } else { -nearest_m }
}

fn distance_to_edge_m(place: NorthEast, from: NorthEast, to: NorthEast) -> f64 {
    let along = to - from;
    let length_squared = along.dot(along);
    let share = if length_squared > 0.0 { (place - from).dot(along) / length_squared } else { 0.0 };
    (place - (from + along * share.clamp(0.0, 1.0))).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CENTRE: Geodetic = Geodetic { latitude_deg: 63.44, longitude_deg: 10.4 };

    fn at(north_m: f64, east_m: f64) -> Geodetic {
        LocalFrame::new(CENTRE).to_geodetic(NorthEast::new(north_m, east_m))
    }

    fn item(command: u16, first: f32, north_m: f64, east_m: f64) -> Item {
        Item { command, params: [first, 0.0, 0.0, 0.0], ..Item::waypoint(at(north_m, east_m)) }
    }

    fn square(command: u16, half_m: f64) -> Vec<Item> {
        [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
            .map(|(n, e)| item(command, 4.0, n * half_m, e * half_m))
            .to_vec()
    }

    #[test]
    fn inside_of_one_and_outside_of_another() {
        let mut items = square(enums::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, 100.0);
        items.push(item(enums::MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION, 20.0, 50.0, 0.0));
        let fence = Fence::from_items(&items).unwrap();
        let close = |place: Geodetic, expected: f64| {
            let found = fence.breach_m(place);
            assert!((found - expected).abs() < 0.05, "{found} instead of {expected}");
        };
        close(at(0.0, 0.0), 0.0);
        close(at(130.0, 0.0), 30.0);
        close(at(-103.0, 104.0), 5.0);
        close(at(55.0, 0.0), 15.0);
        close(at(75.0, 0.0), 0.0);
    }

    #[test]
    fn what_is_no_fence_is_none() {
        assert!(Fence::from_items(&[]).is_none());
        let line = [1, 2].map(|_| item(enums::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, 2.0, 0.0, 0.0));
        assert!(Fence::from_items(&line).is_none());
        let mut cut_off = square(enums::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, 100.0);
        cut_off.pop();
        assert!(Fence::from_items(&cut_off).is_none());
        assert!(Fence::from_items(&[item(enums::MAV_CMD_NAV_WAYPOINT, 0.0, 0.0, 0.0)]).is_none());
    }

    proptest! {
        #[test]
        fn a_polygon_of_many_corners_is_its_circle(north in -200.0..200.0, east in -200.0..200.0) {
            let corners = 90;
            let ring: Vec<Item> = (0..corners)
                .map(|index| {
                    let place = NorthEast::from_polar(100.0, f64::from(index) * std::f64::consts::TAU / 90.0);
                    let command = enums::MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION;
                    item(command, corners as f32, place.north_m, place.east_m)
                })
                .collect();
            let found = Fence::from_items(&ring).unwrap().breach_m(at(north, east));
            let expected = (f64::hypot(north, east) - 100.0).max(0.0);
            prop_assert!((found - expected).abs() < 0.1, "{found} instead of {expected}");
        }
    }
}
