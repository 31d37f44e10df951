//! A driven track as a mission: simplified to a tolerance, with its speeds and stops.

use crate::geodesy::{Geodetic, LocalFrame, NorthEast};
use crate::plan::fence::distance_to_segment;
use crate::plan::{Item, Mission};

/// Slower than this the boat stands still, m/s.
const STANDING_MPS: f64 = 0.2;
/// A speed is written when it differs by this much from the one before, m/s, or by a tenth of it.
const SPEED_STEP_MPS: f64 = 0.1;
const SPEED_STEP_PART: f64 = 0.1;
/// Speeds are written to this precision, m/s.
const SPEED_GRAIN_MPS: f64 = 0.05;
/// Slowest speed that is written, m/s.
const SLOWEST_MPS: f64 = 0.2;
/// Where the boat was when: so many times the tolerance, and at least so many metres, may be lost of that. Keeps
/// changes of speed on straight legs.
const TIMING_FACTOR: f64 = 5.0;
const TIMING_LEAST_M: f64 = 5.0;

/// Where a boat was at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// Time on any clock that does not go back, seconds.
    pub time_s: f64,
    /// Where.
    pub position: Geodetic,
    /// Speed over ground, m/s.
    pub speed_mps: f64,
}

/// How a track becomes a mission.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackSettings {
    /// No place of the track may be farther from the mission's legs than this, metres, above 0.
    pub tolerance_m: f64,
    /// Standing still at least so long becomes a hold, seconds; none leaves stops out.
    pub stop_s: Option<f64>,
}

/// A mission made from a track.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackMission {
    /// The mission; home is where the track begins.
    pub mission: Mission,
    /// Length of the track, metres, and how long it took, seconds; without standing at its ends.
    pub length_m: f64,
    /// Seconds.
    pub duration_s: f64,
    /// Largest distance of the track from the mission's legs, metres.
    pub deviation_m: f64,
}

/// A fix in the plane, and how long the boat then stood still.
#[derive(Debug, Clone, Copy)]
struct Mark {
    time_s: f64,
    place: NorthEast,
    stood_s: f64,
}

/// The mission of a track; none when the boat has not moved.
pub fn mission_of_track(fixes: &[Fix], settings: &TrackSettings) -> Option<TrackMission> {
    let frame = LocalFrame::new(fixes.first()?.position);
    let marks = moving(fixes, &frame);
    if marks.len() < 2 {
        return None;
    }
    let kept = simplified(&marks, settings);
    let mut items = Vec::new();
    let mut speed_mps = None;
    for (index, mark) in kept.iter().map(|index| (*index, marks[*index])) {
        let before = kept.iter().copied().take_while(|other| *other < index).last();
        if let Some(wanted_mps) = before.and_then(|before| mean_speed_mps(&marks[before..=index])) {
            let differs =
                |known: f64| (wanted_mps - known).abs() >= SPEED_STEP_MPS.max(SPEED_STEP_PART * known);
            if speed_mps.is_none_or(differs) {
                speed_mps = Some(wanted_mps);
                items.push(Item::change_speed(wanted_mps as f32));
            }
        }
        let hold_s = settings.stop_s.filter(|stop_s| mark.stood_s >= *stop_s).map_or(0.0, |_| mark.stood_s);
        let is_last = index + 1 == marks.len();
        let hold_s = if is_last { 0.0 } else { hold_s.round() };
        let place = Item::waypoint(frame.to_geodetic(mark.place));
        items.push(Item { params: [hold_s as f32, 0.0, 0.0, 0.0], ..place });
    }
    let legs_m =
        |marks: &[Mark]| -> f64 { marks.windows(2).map(|leg| (leg[1].place - leg[0].place).norm()).sum() };
    Some(TrackMission {
        mission: Mission { home: Some(frame.to_geodetic(marks[0].place)), items },
        length_m: legs_m(&marks),
        duration_s: marks[marks.len() - 1].time_s - marks[0].time_s,
        deviation_m: deviation_m(&marks, &kept),
    })
}

/// The fixes while the boat moved; standing still is noted with the fix where it began.
fn moving(fixes: &[Fix], frame: &LocalFrame) -> Vec<Mark> {
    let mut marks: Vec<Mark> = Vec::new();
    for fix in fixes.iter().filter(|fix| fix.position.is_valid() && fix.time_s.is_finite()) {
        let place = frame.to_local(fix.position);
        match marks.last_mut() {
            Some(last) if fix.time_s <= last.time_s + last.stood_s => {}
            Some(last) if fix.speed_mps < STANDING_MPS => last.stood_s = fix.time_s - last.time_s,
            Some(_) => marks.push(Mark { time_s: fix.time_s, place, stood_s: 0.0 }),
            // It begins where the boat sets out.
            None if fix.speed_mps >= STANDING_MPS => {
                marks.push(Mark { time_s: fix.time_s, place, stood_s: 0.0 });
            }
            None => {}
        }
    }
    if let Some(last) = marks.last_mut() {
        last.stood_s = 0.0;
    }
    marks
}

/// Indices of the marks that are kept: Ramer, Douglas and Peucker, without recursion; and every long stop.
fn simplified(marks: &[Mark], settings: &TrackSettings) -> Vec<usize> {
    let last = marks.len() - 1;
    let mut kept = vec![false; marks.len()];
    let is_stop = |mark: &Mark| settings.stop_s.is_some_and(|stop_s| mark.stood_s >= stop_s);
    let mut ends: Vec<usize> =
        (0..=last).filter(|index| *index == 0 || *index == last || is_stop(&marks[*index])).collect();
    for end in &ends {
        kept[*end] = true;
    }
    let mut open: Vec<(usize, usize)> = ends.windows(2).map(|pair| (pair[0], pair[1])).collect();
    ends.clear();
    while let Some((from, to)) = open.pop() {
        let worst = (from + 1..to)
            .map(|index| (excess(&marks[from], &marks[index], &marks[to], settings.tolerance_m), index))
            .max_by(|one, other| one.0.total_cmp(&other.0));
        if let Some((_, index)) = worst.filter(|(excess, _)| *excess > 1.0) {
            kept[index] = true;
            open.extend([(from, index), (index, to)]);
        }
    }
    (0..=last).filter(|index| kept[*index]).collect()
}

/// How far a mark is from the leg between two others, as a multiple of what is tolerated: in space, and in time.
fn excess(from: &Mark, mark: &Mark, to: &Mark, tolerance_m: f64) -> f64 {
    let off_m = distance_to_segment(mark.place, from.place, to.place);
    let started_s = from.time_s + from.stood_s;
    let share = ((mark.time_s - started_s) / (to.time_s - started_s)).clamp(0.0, 1.0);
    let then = from.place + (to.place - from.place) * share;
    let late_m = (mark.place - then).norm();
    (off_m / tolerance_m).max(late_m / (TIMING_FACTOR * tolerance_m).max(TIMING_LEAST_M))
}

/// Length over time, rounded; none for no time at all.
fn mean_speed_mps(marks: &[Mark]) -> Option<f64> {
    let length_m: f64 = marks.windows(2).map(|leg| (leg[1].place - leg[0].place).norm()).sum();
    let (first, last) = (marks.first()?, marks.last()?);
    let stood_s: f64 = marks[..marks.len() - 1].iter().map(|mark| mark.stood_s).sum();
    let duration_s = last.time_s - first.time_s - stood_s;
    let speed_mps = (duration_s > 0.0).then(|| length_m / duration_s)?;
    Some(((speed_mps / SPEED_GRAIN_MPS).round() * SPEED_GRAIN_MPS).max(SLOWEST_MPS))
}

fn deviation_m(marks: &[Mark], kept: &[usize]) -> f64 {
    let legs = kept.windows(2);
    legs.flat_map(|leg| {
        let (from, to) = (marks[leg[0]].place, marks[leg[1]].place);
        marks[leg[0]..leg[1]].iter().map(move |mark| distance_to_segment(mark.place, from, to))
    })
    .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use helmlink_wire::enums::*;
    use proptest::prelude::*;

    const HERE: Geodetic = Geodetic { latitude_deg: 59.9, longitude_deg: 10.7 };
    const METRE: TrackSettings = TrackSettings { tolerance_m: 1.0, stop_s: Some(10.0) };

    /// Fixes ten times a second along legs: north, east, speed.
    fn track(legs: &[(f64, f64, f64)]) -> Vec<Fix> {
        let frame = LocalFrame::new(HERE);
        let (mut place, mut time_s, mut fixes) = (NorthEast::ZERO, 0.0, Vec::new());
        let mut push = |time_s: f64, place, speed_mps| {
            fixes.push(Fix { time_s, position: frame.to_geodetic(place), speed_mps });
        };
        for &(north_m, east_m, speed_mps) in legs {
            let to = NorthEast::new(north_m, east_m);
            let duration_s = if to == place { 20.0 } else { (to - place).norm() / speed_mps };
            let count = (10.0 * duration_s).ceil().max(1.0) as usize;
            for step in 1..=count {
                let share = step as f64 / count as f64;
                push(time_s + share * duration_s, place + (to - place) * share, speed_mps);
            }
            time_s += duration_s;
            place = to;
        }
        fixes
    }

    fn commands(mission: &Mission) -> Vec<(u16, f32)> {
        let value = |item: &Item| item.params[usize::from(item.command == MAV_CMD_DO_CHANGE_SPEED)];
        mission.items.iter().map(|item| (item.command, value(item))).collect()
    }

    #[test]
    fn corners_speeds_and_stops_remain() {
        let fixes = track(&[
            (0.0, 0.0, 0.0),
            (50.0, 0.0, 1.0),
            (50.0, 30.0, 1.0),
            (50.0, 30.0, 0.0),
            (100.0, 30.0, 2.0),
        ]);
        let made = mission_of_track(&fixes, &METRE).unwrap();
        let (speed, waypoint) = (MAV_CMD_DO_CHANGE_SPEED, MAV_CMD_NAV_WAYPOINT);
        assert_eq!(
            commands(&made.mission),
            [(waypoint, 0.0), (speed, 1.0), (waypoint, 0.0), (waypoint, 20.0), (speed, 2.0), (waypoint, 0.0)]
        );
        assert!((made.length_m - 130.0).abs() < 0.5 && made.deviation_m < 0.2, "{made:?}");
        assert!((made.duration_s - 125.0).abs() < 0.5, "{}", made.duration_s);
        let without = mission_of_track(&fixes, &TrackSettings { stop_s: None, ..METRE }).unwrap();
        assert!(commands(&without.mission).iter().all(|(command, value)| *command == speed || *value == 0.0));
    }

    #[test]
    fn a_change_of_speed_on_a_straight_leg_remains() {
        let made = mission_of_track(&track(&[(60.0, 0.0, 1.0), (120.0, 0.0, 3.0)]), &METRE).unwrap();
        let speeds: Vec<f32> = commands(&made.mission)
            .into_iter()
            .filter(|(command, _)| *command == MAV_CMD_DO_CHANGE_SPEED)
            .map(|(_, speed)| speed)
            .collect();
        assert!(speeds.first() == Some(&1.0) && *speeds.last().unwrap() > 2.8, "{speeds:?}");
        assert!(made.mission.items.len() < 9);
    }

    #[test]
    fn a_boat_that_has_not_moved_has_no_mission() {
        assert_eq!(mission_of_track(&[], &METRE), None);
        assert_eq!(mission_of_track(&track(&[(0.0, 0.0, 0.0)]), &METRE), None);
    }

    proptest! {
        #[test]
        fn nothing_of_the_track_is_farther_off_than_tolerated(
            turns in prop::collection::vec((-0.6..0.6f64, 0.3..4.0f64), 2..60), tolerance_m in 0.2..6.0f64,
        ) {
            let (mut place, mut course_rad, mut legs) = (NorthEast::ZERO, 0.0, Vec::new());
            for (turn_rad, speed_mps) in turns {
                course_rad += turn_rad;
                place += NorthEast::from_polar(5.0, course_rad);
                legs.push((place.north_m, place.east_m, speed_mps));
            }
            let made = mission_of_track(&track(&legs), &TrackSettings { tolerance_m, stop_s: None }).unwrap();
            prop_assert!(made.deviation_m <= tolerance_m + 1e-6, "{}", made.deviation_m);
            prop_assert!(crate::route::Route::from_mission(&made.mission).is_ok());
        }

        #[test]
        fn any_fixes_make_a_mission_or_none(
            fixes in prop::collection::vec((any::<f64>(), any::<f64>(), any::<f64>(), any::<f64>()), 0..20),
        ) {
            let fixes: Vec<Fix> = fixes.into_iter().map(|(time_s, latitude_deg, longitude_deg, speed_mps)| {
                Fix { time_s, position: Geodetic { latitude_deg, longitude_deg }, speed_mps }
            }).collect();
            let _ = mission_of_track(&fixes, &METRE);
        }
    }
}
