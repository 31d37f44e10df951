//! The fence: where the boat may be, and what happens when it leaves.

use std::time::Duration;

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::plan::Item;
use helmlink_mission::protocol::MissionType;
use helmlink_wire::dialect::{FENCE_STATUS_DATA, Message};
use helmlink_wire::enums::*;

use super::Autopilot;
use super::parameters::*;

/// FENCE_TYPE: a circle of FENCE_RADIUS around home; the polygons and circles that were uploaded.
const TYPE_CIRCLE: i32 = 2;
const TYPE_PLAN: i32 = 4;

/// State of the fence.
#[derive(Debug, Clone, Default)]
pub(super) struct Fence {
    zones: Vec<Zone>,
    breached: bool,
    breaches: u16,
    last_breach: Duration,
}

/// One part of an uploaded fence, in local coordinates.
#[derive(Debug, Clone, PartialEq)]
struct Zone {
    /// Whether the boat must stay inside, not outside.
    inclusion: bool,
    shape: Shape,
}

#[derive(Debug, Clone, PartialEq)]
enum Shape {
    Polygon(Vec<NorthEast>),
    Circle { centre: NorthEast, radius_m: f64 },
}

impl Shape {
    fn contains(&self, place: NorthEast) -> bool {
        match self {
            Self::Circle { centre, radius_m } => (place - *centre).norm() <= *radius_m,
            Self::Polygon(corners) => {
                // A ray to the north crosses the boundary an odd number of times from inside.
                let next = corners.iter().cycle().skip(1);
                let crossings = corners.iter().zip(next).filter(|(a, b)| {
                    let straddles = (a.east_m > place.east_m) != (b.east_m > place.east_m);
                    straddles && {
                        let share = (place.east_m - a.east_m) / (b.east_m - a.east_m);
                        a.north_m + share * (b.north_m - a.north_m) > place.north_m
                    }
                });
                crossings.count() % 2 == 1
            }
        }
    }
}

impl Autopilot {
    /// Takes in an uploaded fence.
    pub(super) fn read_fence(&mut self) {
        let items = self.missions.items(MissionType::Fence);
        let local = |item: &Item| item.position().map(|place| self.frame.to_local(place));
        let mut zones = Vec::new();
        let mut rest = items;
        while let Some(first) = rest.first() {
            let size = match first.command {
                MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION | MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION => {
                    (first.params[0] as usize).clamp(1, rest.len())
                }
                _ => 1,
            };
            let (group, others) = rest.split_at(size);
            rest = others;
            let inclusion = matches!(
                first.command,
                MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION | MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION
            );
            let shape = match first.command {
                MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION | MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION => {
                    Some(Shape::Polygon(group.iter().filter_map(local).collect()))
                }
                MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION | MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION => {
                    local(first).map(|centre| Shape::Circle { centre, radius_m: f64::from(first.params[0]) })
                }
                _ => None, // the return point is of no use to a boat
            };
            zones.extend(shape.map(|shape| Zone { inclusion, shape }));
        }
        self.fence.zones = zones;
    }

    pub(super) fn is_fenced(&self) -> bool {
        self.parameters.int(FENCE_ENABLE) != 0
    }

    pub(super) fn has_breached_fence(&self) -> bool {
        self.fence.breached
    }

    /// Whether the boat is where it must not be.
    pub(super) fn is_outside_fence(&self) -> bool {
        if !self.is_fenced() || !self.has_position() {
            return false;
        }
        let place = self.motion().position;
        let kinds = self.parameters.int(FENCE_TYPE);
        let beyond_circle = kinds & TYPE_CIRCLE != 0
            && (place - self.home_point()).norm() > self.parameters.get(FENCE_RADIUS);
        let violates = |zone: &Zone| zone.shape.contains(place) != zone.inclusion;
        beyond_circle || kinds & TYPE_PLAN != 0 && self.fence.zones.iter().any(violates)
    }

    /// A margin that leaves no room inside a circle; the words are ArduRover's (AC_Fence `pre_arm_check_polygon`
    /// and `pre_arm_check_circle`), which mean the reverse.
    pub(super) fn fence_margin_obstacle(&self) -> Option<&'static str> {
        let kinds = self.parameters.int(FENCE_TYPE);
        if !self.is_fenced() || kinds == 0 {
            return None;
        }
        let margin_m = self.parameters.get(FENCE_MARGIN);
        let has_no_room = |zone: &Zone| matches!(zone.shape, Shape::Circle { radius_m, .. } if zone.inclusion && radius_m < margin_m);
        if kinds & TYPE_PLAN != 0 && self.fence.zones.iter().any(has_no_room) {
            return Some("Margin is less than inclusion circle radius");
        }
        (self.parameters.get(FENCE_RADIUS) < margin_m).then_some("FENCE_MARGIN is less than FENCE_RADIUS")
    }

    /// Acts once each time the boat leaves (FENCE_ACTION).
    pub(super) fn watch_fence(&mut self) {
        let outside = self.is_outside_fence();
        let left = outside && !self.fence.breached;
        self.fence.breached = outside;
        if !left || !self.armed {
            return;
        }
        self.fence.breaches = self.fence.breaches.saturating_add(1);
        self.fence.last_breach = self.since_boot();
        self.links.text(MAV_SEVERITY_CRITICAL, "Fence Breached");
        /// FENCE_ACTION numbers that mean the same as those of FS_ACTION: RTL or HOLD, HOLD, SMART_RTL or RTL
        /// or HOLD, SMART_RTL or HOLD. 0 only reports.
        const ACTIONS: std::ops::RangeInclusive<i32> = 1..=4;
        let action = self.parameters.int(FENCE_ACTION);
        if ACTIONS.contains(&action) {
            self.act_by_number(action);
        }
    }

    /// DO_FENCE_ENABLE; 2 (the floor alone) means nothing to a boat.
    pub(super) fn enable_fence(&mut self, how: Option<i64>) -> u8 {
        match how {
            Some(on @ (0 | 1)) => {
                self.parameters.put(FENCE_ENABLE, on as f32);
                self.announce_parameter(FENCE_ENABLE);
                MAV_RESULT_ACCEPTED
            }
            _ => MAV_RESULT_FAILED,
        }
    }

    /// Only while there is a fence.
    pub(super) fn fence_status(&self) -> Option<Message> {
        self.is_fenced().then(|| {
            Message::FENCE_STATUS(FENCE_STATUS_DATA {
                breach_time: u32::try_from(self.fence.last_breach.as_millis()).unwrap_or(u32::MAX),
                breach_count: self.fence.breaches,
                breach_status: u8::from(self.fence.breached),
                breach_type: if self.fence.breached { FENCE_BREACH_BOUNDARY } else { FENCE_BREACH_NONE },
                ..FENCE_STATUS_DATA::DEFAULT
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use helmlink_mission::geodesy::LocalFrame;

    use super::*;
    use crate::autopilot::modes::Mode;
    use crate::autopilot::testing::{Bench, LINK};

    fn corner(command: u16, count: f32, place: NorthEast, frame: &LocalFrame) -> Item {
        let mut item = Item::waypoint(frame.to_geodetic(place));
        item.command = command;
        item.params[0] = count;
        item
    }

    fn fenced(items: impl Fn(&LocalFrame) -> Vec<Item>, action: f32) -> Bench {
        let mut bench = Bench::ready();
        bench.autopilot.parameters.put(FENCE_ENABLE, 1.0);
        bench.autopilot.parameters.put(FENCE_ACTION, action);
        let items = items(&bench.autopilot.frame);
        bench.autopilot.missions.set_items(MissionType::Fence, &items).unwrap();
        bench.run_loops(2);
        bench.arm();
        bench.autopilot.enter_mode(Mode::Guided).unwrap();
        bench
    }

    fn square(command: u16, centre: NorthEast, half_m: f64, frame: &LocalFrame) -> Vec<Item> {
        [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
            .map(|(north, east)| corner(command, 4.0, centre + NorthEast::new(north, east) * half_m, frame))
            .to_vec()
    }

    #[test]
    fn leaving_a_polygon_a_circle_or_entering_a_forbidden_one_is_a_breach() {
        let ahead = NorthEast::new(40.0, 0.0);
        type Plan = Box<dyn Fn(&LocalFrame) -> Vec<Item>>;
        let plans: [Plan; 4] = [
            Box::new(|frame| {
                square(MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, NorthEast::ZERO, 20.0, frame)
            }),
            Box::new(|frame| vec![corner(MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, 20.0, NorthEast::ZERO, frame)]),
            Box::new(move |frame| square(MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION, ahead, 20.0, frame)),
            Box::new(move |frame| vec![corner(MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION, 20.0, ahead, frame)]),
        ];
        for (number, plan) in plans.into_iter().enumerate() {
            let mut bench = fenced(plan, 2.0);
            bench.go_to(ahead);
            let sent = bench.run_s(40.0);
            assert_eq!(bench.autopilot.mode, Mode::Hold, "plan {number}");
            assert!(Bench::texts(&sent).contains(&"Fence Breached".to_owned()));
            let north_m = bench.position().north_m;
            assert!((19.0..30.0).contains(&north_m), "plan {number}: {north_m} m");
        }
    }

    #[test]
    fn a_margin_that_fills_a_circle_forbids_arming_but_moves_no_breach() {
        let circle = |frame: &LocalFrame| {
            vec![corner(MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, 20.0, NorthEast::ZERO, frame)]
        };
        let mut bench = fenced(circle, 0.0);
        bench.autopilot.parameters.put(FENCE_MARGIN, 19.0);
        bench.go_to(NorthEast::new(10.0, 0.0));
        bench.run_s(20.0);
        assert!(!bench.autopilot.has_breached_fence(), "the margin is no fence: {:?}", bench.position());
        assert!(bench.autopilot.arming_obstacles().is_empty());
        bench.autopilot.parameters.put(FENCE_MARGIN, 21.0);
        let reason = "Margin is less than inclusion circle radius";
        assert_eq!(bench.autopilot.arming_obstacles(), [reason]);
        bench.autopilot.missions.set_items(MissionType::Fence, &[]).unwrap();
        bench.autopilot.parameters.put(FENCE_RADIUS, 20.5);
        bench.run_loops(2);
        assert_eq!(bench.autopilot.arming_obstacles(), ["FENCE_MARGIN is less than FENCE_RADIUS"]);
        bench.autopilot.parameters.put(FENCE_ENABLE, 0.0);
        assert!(bench.autopilot.arming_obstacles().is_empty());
    }

    #[test]
    fn the_circle_around_home_needs_no_plan_and_home_is_a_way_out() {
        let mut bench = fenced(|_| Vec::new(), 1.0);
        bench.autopilot.parameters.put(FENCE_RADIUS, 25.0);
        bench.go_to(NorthEast::new(60.0, 0.0));
        bench.run_s(100.0);
        assert_eq!(bench.autopilot.mode, Mode::Rtl);
        assert!(bench.position().norm() < 6.0, "{:?}", bench.position());
    }

    #[test]
    fn a_breach_can_be_only_told_and_arming_outside_is_refused() {
        let mut bench = fenced(|_| Vec::new(), 0.0);
        bench.autopilot.parameters.put(FENCE_RADIUS, 30.0);
        bench.go_to(NorthEast::new(60.0, 0.0));
        let sent = bench.run_s(60.0);
        assert_eq!(bench.autopilot.mode, Mode::Guided);
        let told = sent[&LINK].iter().rev().find_map(|message| match message {
            Message::FENCE_STATUS(data) => Some((data.breach_status, data.breach_count)),
            _ => None,
        });
        assert_eq!(told, Some((1, 1)));
        bench.autopilot.disarm();
        // Arming moves home, and the circle with it: a polygon stays.
        let frame = bench.autopilot.frame;
        let plan = square(MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, NorthEast::ZERO, 20.0, &frame);
        bench.autopilot.missions.set_items(MissionType::Fence, &plan).unwrap();
        bench.run_loops(2);
        assert!(bench.autopilot.arming_obstacles().contains(&"vehicle outside fence"));
    }
}
