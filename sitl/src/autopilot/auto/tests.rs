use helmlink_mission::geodesy::Geodetic;
use proptest::prelude::*;

use super::*;

/// A boat that is wherever it wants to be at once.
struct Ghost {
    auto: Auto,
    frame: LocalFrame,
    parameters: Parameters,
    items: Vec<Item>,
    position: NorthEast,
    now: Duration,
}

impl Ghost {
    fn new(items: Vec<Item>) -> Self {
        Self {
            auto: Auto::default(),
            frame: LocalFrame::new(Geodetic::new(63.4, 10.4)),
            parameters: Parameters::new(),
            items,
            position: NorthEast::ZERO,
            now: Duration::ZERO,
        }
    }

    /// Runs for so many loops, moving to each leg's end within a loop.
    fn run(&mut self, loops: usize) -> Vec<Event> {
        let mut events = Vec::new();
        for _ in 0..loops {
            self.now += Duration::from_millis(20);
            let situation = Situation {
                items: &self.items,
                motion: Motion { position: self.position, ..Motion::default() },
                frame: &self.frame,
                parameters: &self.parameters,
                home: NorthEast::ZERO,
                now: self.now,
            };
            let (_, report) = self.auto.update(&situation);
            if let Some(report) = report {
                self.position = report.target;
            }
            events.extend(self.auto.take_events());
        }
        events
    }
}

fn command(command: u16, params: [f32; 4]) -> Item {
    Item { command, params, ..Item::waypoint(Geodetic::new(0.0, 0.0)) }
}

fn waypoint(north_m: f64, east_m: f64) -> Item {
    let frame = LocalFrame::new(Geodetic::new(63.4, 10.4));
    Item::waypoint(frame.to_geodetic(NorthEast::new(north_m, east_m)))
}

fn reached(events: &[Event]) -> Vec<u16> {
    let seq = |event: &Event| if let Event::Reached(seq) = event { Some(*seq) } else { None };
    events.iter().filter_map(seq).collect()
}

#[test]
fn every_waypoint_is_reached_and_the_mission_ends_at_the_last() {
    let mut ghost = Ghost::new(vec![waypoint(20.0, 0.0), waypoint(40.0, 0.0), waypoint(40.0, 20.0)]);
    let events = ghost.run(20);
    assert_eq!(reached(&events), [1, 2, 3]);
    assert_eq!(events.last(), Some(&Event::Text("Mission Complete".into())));
    assert_eq!((ghost.auto.progress(), ghost.auto.current()), (Progress::Complete, 3));
    ghost.auto.resume(false);
    assert_eq!(reached(&ghost.run(20)), [1, 2, 3], "a mission that is over begins anew");
}

#[test]
fn jumps_are_made_as_often_as_asked() {
    let jump = command(MAV_CMD_DO_JUMP, [1.0, 2.0, 0.0, 0.0]);
    let mut ghost = Ghost::new(vec![waypoint(20.0, 0.0), waypoint(40.0, 0.0), jump, waypoint(60.0, 0.0)]);
    assert_eq!(reached(&ghost.run(30)), [1, 2, 1, 2, 1, 2, 4]);
}

#[test]
fn jumps_in_a_circle_end_the_mission_instead_of_hanging_it() {
    let mut ghost = Ghost::new(vec![command(MAV_CMD_DO_JUMP, [1.0, -1.0, 0.0, 0.0])]);
    assert!(ghost.run(2).contains(&Event::Complete));
}

#[test]
fn delays_and_stays_take_their_time() {
    let mut stay = waypoint(20.0, 0.0);
    stay.params[0] = 2.0;
    let mut ghost =
        Ghost::new(vec![stay, command(MAV_CMD_NAV_DELAY, [3.0, 0.0, 0.0, 0.0]), waypoint(0.0, 9.0)]);
    assert!(reached(&ghost.run(90)).is_empty());
    assert_eq!(reached(&ghost.run(30)), [1]);
    assert!(reached(&ghost.run(100)).is_empty());
    assert_eq!(reached(&ghost.run(60)), [2, 3]);
}

#[test]
fn speeds_are_taken_in_passing() {
    let faster = command(MAV_CMD_DO_CHANGE_SPEED, [1.0, 3.5, -1.0, 0.0]);
    let mut ghost = Ghost::new(vec![waypoint(20.0, 0.0), faster, waypoint(500.0, 0.0)]);
    ghost.run(2);
    assert_eq!(ghost.auto.speed_mps, Some(3.5));
    assert_eq!(ghost.auto.current(), 3);
}

#[test]
fn a_set_current_goes_there_start_here() {
    let mut ghost = Ghost::new(vec![waypoint(20.0, 0.0), waypoint(40.0, 0.0), waypoint(60.0, 0.0)]);
    ghost.auto.set_current(3);
    assert_eq!(reached(&ghost.run(10)), [3]);
}

#[test]
fn an_unlimited_loiter_never_ends() {
    let loiter = Item { command: MAV_CMD_NAV_LOITER_UNLIM, ..waypoint(20.0, 0.0) };
    let mut ghost = Ghost::new(vec![loiter, waypoint(40.0, 0.0)]);
    assert!(reached(&ghost.run(5000)).is_empty());
    assert_eq!(ghost.auto.current(), 1);
}

proptest! {
    #[test]
    fn any_items_are_survived(
        raw in prop::collection::vec(
            (0u16..700, prop::array::uniform4(any::<f32>()), any::<i32>(), any::<i32>(), 0u8..25), 0..12),
    ) {
        let items = raw.into_iter().map(|(command, params, x, y, frame)| Item {
            command, params, x, y, frame, z: 0.0, autocontinue: true,
        });
        let mut ghost = Ghost::new(items.collect());
        ghost.run(50);
    }
}
