//! Where a boat may and may not go: fences, and places to return to.

use helmlink_wire::enums::*;

use super::Item;
use super::error::Fault;
use crate::geodesy::{Geodetic, LocalFrame, NorthEast};

/// A fence: areas that a boat keeps inside of or out of.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fence {
    /// The areas, in the order of the source.
    pub areas: Vec<Area>,
    /// Where to go when the fence has been crossed, if the plan says so.
    pub return_point: Option<RallyPoint>,
}

/// One area of a fence.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// The boat has to stay inside; otherwise outside.
    pub inclusion: bool,
    /// Its outline.
    pub outline: Outline,
}

/// The outline of an area.
#[derive(Debug, Clone, PartialEq)]
pub enum Outline {
    /// At least three corners; the last is joined to the first.
    Polygon(Vec<Geodetic>),
    /// All places within a distance.
    Circle {
        /// Its middle.
        centre: Geodetic,
        /// Its radius, metres, above 0.
        radius_m: f32,
    },
}

/// A place to return to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RallyPoint {
    /// Where it is.
    pub position: Geodetic,
    /// Altitude above home, metres. A boat ignores it.
    pub altitude_m: f32,
}

/// Whether an item belongs to a fence.
pub(super) fn is_fence_item(command: u16) -> bool {
    matches!(
        command,
        MAV_CMD_NAV_FENCE_RETURN_POINT
            | MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
            | MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION
            | MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION
            | MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION
    )
}

impl RallyPoint {
    /// The MAVLink item that carries it.
    pub fn to_item(self) -> Item {
        Item { command: MAV_CMD_NAV_RALLY_POINT, z: self.altitude_m, ..Item::waypoint(self.position) }
    }

    /// A rally point out of its item.
    ///
    /// # Errors
    /// Another command, or no position.
    pub fn from_item(item: &Item) -> Result<Self, Fault> {
        if item.command != MAV_CMD_NAV_RALLY_POINT {
            return Err(Fault::Described(format!(
                "{} among the rally points: expected MAV_CMD_NAV_RALLY_POINT (5100)",
                super::CommandName(item.command)
            )));
        }
        Ok(Self { position: place_of(item)?, altitude_m: item.z })
    }
}

impl Fence {
    /// Nothing at all.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty() && self.return_point.is_none()
    }

    /// The MAVLink items that carry it: one a corner of a polygon, one a circle.
    pub fn to_items(&self) -> Vec<Item> {
        let mut items = Vec::new();
        if let Some(place) = self.return_point {
            items.push(Item { command: MAV_CMD_NAV_FENCE_RETURN_POINT, ..place.to_item() });
        }
        for area in &self.areas {
            match &area.outline {
                Outline::Polygon(corners) => items.extend(corners.iter().map(|corner| Item {
                    command: if area.inclusion {
                        MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
                    } else {
                        MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION
                    },
                    params: [corners.len() as f32, 0.0, 0.0, 0.0],
                    ..Item::waypoint(*corner)
                })),
                Outline::Circle { centre, radius_m } => items.push(Item {
                    command: if area.inclusion {
                        MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION
                    } else {
                        MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION
                    },
                    params: [*radius_m, 0.0, 0.0, 0.0],
                    ..Item::waypoint(*centre)
                }),
            }
        }
        items
    }

    /// A fence out of its MAVLink items.
    ///
    /// # Errors
    /// An item that belongs to no fence, has no position, or a polygon with corners missing.
    pub fn from_items(items: &[Item]) -> Result<Self, Fault> {
        let mut fence = Self::default();
        let mut rest = items;
        while let Some(first) = rest.first() {
            let inclusion = matches!(
                first.command,
                MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION | MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION
            );
            match first.command {
                MAV_CMD_NAV_FENCE_RETURN_POINT => {
                    fence.return_point = Some(RallyPoint { position: place_of(first)?, altitude_m: first.z });
                    rest = &rest[1..];
                }
                MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION | MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION => {
                    let corners = corners_of(rest)?;
                    rest = &rest[corners.len()..];
                    fence.areas.push(Area { inclusion, outline: Outline::Polygon(corners) });
                }
                MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION | MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION => {
                    let (centre, radius_m) = (place_of(first)?, first.params[0]);
                    fence.areas.push(Area { inclusion, outline: Outline::circle(centre, radius_m)? });
                    rest = &rest[1..];
                }
                other => {
                    return Err(Fault::Described(format!(
                        "{} belongs to no fence: expected corners (5001, 5002) or circles (5003, 5004)",
                        super::CommandName(other)
                    )));
                }
            }
        }
        Ok(fence)
    }

    /// The number of the first area, from 1, that the straight way between two places does not respect:
    /// leaves, when it is to stay inside, or enters, when it is to stay outside.
    pub fn crossed_by(&self, from: Geodetic, to: Geodetic) -> Option<usize> {
        let frame = LocalFrame::new(from);
        let way = [NorthEast::ZERO, frame.to_local(to)];
        self.areas.iter().position(|area| !area.respects(&frame, way)).map(|index| index + 1)
    }
}

impl Outline {
    /// A circle.
    ///
    /// # Errors
    /// A radius that is not a number above 0.
    pub fn circle(centre: Geodetic, radius_m: f32) -> Result<Self, Fault> {
        if radius_m.is_finite() && radius_m > 0.0 {
            Ok(Self::Circle { centre, radius_m })
        } else {
            Err(Fault::Described(format!(
                "the radius of a fence circle is {radius_m}, expected metres above 0"
            )))
        }
    }

    /// A polygon; a last corner that repeats the first is left out.
    ///
    /// # Errors
    /// Fewer than three corners, or one that is no position.
    pub fn polygon(mut corners: Vec<Geodetic>) -> Result<Self, Fault> {
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        for corner in &corners {
            corner.check()?;
        }
        if corners.len() < 3 {
            return Err(Fault::Described(format!(
                "a fence polygon has {} corners, expected at least 3",
                corners.len()
            )));
        }
        Ok(Self::Polygon(corners))
    }
}

impl Area {
    fn respects(&self, frame: &LocalFrame, [from, to]: [NorthEast; 2]) -> bool {
        match &self.outline {
            Outline::Circle { centre, radius_m } => {
                let centre = frame.to_local(*centre);
                let radius_m = f64::from(*radius_m);
                if self.inclusion {
                    // A circle is convex: both ends inside is enough.
                    [from, to].iter().all(|end| (*end - centre).norm() <= radius_m)
                } else {
                    distance_to_segment(centre, from, to) > radius_m
                }
            }
            Outline::Polygon(corners) => {
                let corners: Vec<NorthEast> = corners.iter().map(|corner| frame.to_local(*corner)).collect();
                let crosses = edges(&corners).any(|(a, b)| segments_cross([from, to], [a, b]));
                !crosses && is_inside(&corners, from) == self.inclusion
            }
        }
    }
}

fn corners_of(items: &[Item]) -> Result<Vec<Geodetic>, Fault> {
    let Some(first) = items.first() else { return Ok(Vec::new()) };
    let count = first.params[0];
    let wrong = |found: usize| {
        Fault::Described(format!("a fence polygon of {count} corners has {found} of them: was an item lost?"))
    };
    if !(3.0..=65535.0).contains(&count) || count.fract() != 0.0 {
        return Err(Fault::Described(format!(
            "a fence polygon says that it has {count} corners, expected a whole number from 3 up"
        )));
    }
    let same = items
        .iter()
        .take(count as usize)
        .take_while(|item| item.command == first.command && item.params[0] == count)
        .count();
    if same != count as usize {
        return Err(wrong(same));
    }
    items[..same].iter().map(place_of).collect()
}

fn place_of(item: &Item) -> Result<Geodetic, Fault> {
    let [latitude_deg, longitude_deg] = item.coordinates();
    let place = Geodetic { latitude_deg, longitude_deg };
    if !item.has_global_frame() {
        return Err(Fault::Frame(item.frame));
    }
    place.check()?;
    Ok(place)
}

fn edges(corners: &[NorthEast]) -> impl Iterator<Item = (NorthEast, NorthEast)> + '_ {
    let next = corners.iter().cycle().skip(1);
    corners.iter().copied().zip(next.copied())
}

/// By the number of edges between the place and far east of it.
fn is_inside(corners: &[NorthEast], place: NorthEast) -> bool {
    let crossings = edges(corners)
        .filter(|(a, b)| (a.north_m > place.north_m) != (b.north_m > place.north_m))
        .filter(|(a, b)| {
            let share = (place.north_m - a.north_m) / (b.north_m - a.north_m);
            a.east_m + share * (b.east_m - a.east_m) > place.east_m
        })
        .count();
    crossings % 2 == 1
}

/// Whether two segments have a point in common; touching counts.
fn segments_cross([a, b]: [NorthEast; 2], [c, d]: [NorthEast; 2]) -> bool {
    let side = |p: NorthEast, q: NorthEast, r: NorthEast| (q - p).cross(r - p);
    let between = |p: NorthEast, q: NorthEast, r: NorthEast| (r - p).dot(r - q) <= 0.0;
    let (c_side, d_side) = (side(a, b, c), side(a, b, d));
    let (a_side, b_side) = (side(c, d, a), side(c, d, b));
    if ((c_side > 0.0 && d_side < 0.0) || (c_side < 0.0 && d_side > 0.0))
        && ((a_side > 0.0 && b_side < 0.0) || (a_side < 0.0 && b_side > 0.0))
    {
        return true;
    }
    (c_side == 0.0 && between(a, b, c))
        || (d_side == 0.0 && between(a, b, d))
        || (a_side == 0.0 && between(c, d, a))
        || (b_side == 0.0 && between(c, d, b))
}

/// Shortest distance from a place to a segment, metres.
pub(crate) fn distance_to_segment(place: NorthEast, from: NorthEast, to: NorthEast) -> f64 {
    let along = to - from;
    let square = along.dot(along);
    let share = if square > 0.0 { ((place - from).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (place - from - along * share).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HERE: Geodetic = Geodetic { latitude_deg: 59.9, longitude_deg: 10.7 };

    fn at(north_m: f64, east_m: f64) -> Geodetic {
        LocalFrame::new(HERE).to_geodetic(NorthEast::new(north_m, east_m))
    }

    fn harbour() -> Outline {
        // An L: the corner in the north-east is missing.
        Outline::polygon(
            [(0.0, 0.0), (100.0, 0.0), (100.0, 50.0), (50.0, 50.0), (50.0, 100.0), (0.0, 100.0)]
                .map(|(north_m, east_m)| at(north_m, east_m))
                .to_vec(),
        )
        .unwrap()
    }

    fn fence(inclusion: bool, outline: Outline) -> Fence {
        Fence { areas: vec![Area { inclusion, outline }], return_point: None }
    }

    #[test]
    fn notices_what_leaves_an_area_and_what_enters_one() {
        let inside = fence(true, harbour());
        assert_eq!(inside.crossed_by(at(10.0, 10.0), at(40.0, 90.0)), None);
        assert_eq!(inside.crossed_by(at(90.0, 40.0), at(40.0, 90.0)), Some(1), "across the missing corner");
        assert_eq!(inside.crossed_by(at(120.0, 10.0), at(130.0, 10.0)), Some(1), "never inside");
        let outside = fence(false, harbour());
        assert_eq!(outside.crossed_by(at(-10.0, -10.0), at(-10.0, 200.0)), None);
        assert_eq!(outside.crossed_by(at(-10.0, 50.0), at(200.0, 50.0)), Some(1));
        assert_eq!(outside.crossed_by(at(10.0, 10.0), at(20.0, 20.0)), Some(1), "already inside");
        let rock = fence(false, Outline::circle(at(0.0, 0.0), 10.0).unwrap());
        assert_eq!(rock.crossed_by(at(-50.0, 9.0), at(50.0, 9.0)), Some(1));
        assert_eq!(rock.crossed_by(at(-50.0, 11.0), at(50.0, 11.0)), None);
    }

    #[test]
    fn refuses_what_is_no_fence() {
        let corners = fence(true, harbour()).to_items();
        assert!(Fence::from_items(&corners[1..]).is_err(), "a corner is missing");
        assert!(Fence::from_items(&[Item::waypoint(HERE)]).is_err());
        assert!(Outline::polygon(vec![HERE, at(1.0, 1.0), HERE]).is_err());
        assert!(Outline::circle(HERE, f32::NAN).is_err());
        assert!(RallyPoint::from_item(&Item::waypoint(HERE)).is_err());
    }

    fn any_outline() -> impl Strategy<Value = Outline> {
        let place = || {
            (-900..900i32, -900..900i32)
                .prop_map(|(x, y)| Geodetic::from_e7(599_000_000 + x, y + 107_000_000))
        };
        prop_oneof![
            prop::collection::vec(place(), 4..9)
                .prop_filter_map("closed", |corners| { Outline::polygon(corners).ok() }),
            (place(), 0.1..500f32).prop_map(|(centre, radius_m)| Outline::Circle { centre, radius_m }),
        ]
    }

    proptest! {
        #[test]
        fn goes_through_its_items_unchanged(areas in prop::collection::vec((any::<bool>(), any_outline()), 0..6)) {
            let areas = areas.into_iter().map(|(inclusion, outline)| Area { inclusion, outline }).collect();
            let fence = Fence { areas, return_point: Some(RallyPoint { position: HERE, altitude_m: 3.0 }) };
            // Compared as items: degrees have digits beyond MAVLink's.
            let again = Fence::from_items(&fence.to_items()).unwrap();
            prop_assert_eq!(again.to_items(), fence.to_items());
        }

        #[test]
        fn a_way_is_as_good_in_both_directions(
            outline in any_outline(), inclusion: bool, one in (-99.0..99f64, -99.0..99f64), other in (-99.0..99f64, -99.0..99f64),
        ) {
            let fence = fence(inclusion, outline);
            let (one, other) = (at(one.0, one.1), at(other.0, other.1));
            prop_assert_eq!(fence.crossed_by(one, other).is_some(), fence.crossed_by(other, one).is_some());
        }

        #[test]
        fn any_items_are_read_or_refused(items in prop::collection::vec((5000u16..5006, any::<u8>(), any::<f32>(), any::<i32>()), 0..9)) {
            let items: Vec<Item> = items.into_iter().map(|(command, frame, p1, x)| Item {
                command, frame, params: [p1, 0.0, 0.0, 0.0], x, y: x, z: 0.0, autocontinue: true,
            }).collect();
            let _ = Fence::from_items(&items);
        }
    }
}
