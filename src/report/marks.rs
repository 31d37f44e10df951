//! Small marks on the map, and labels that keep out of each other's way.

use super::map::Projection;
use super::svg::{Anchor, Area, Lettering, Point, Style, Svg};
use super::theme;
use super::{Run, TrackPoint, is_plausible, tables};
use helmlink_mission::geodesy::NorthEast;
use std::f64::consts::{PI, TAU};

/// Of waypoints beyond this number only the legs are drawn.
const MOST_WAYPOINTS: usize = 300;
/// Boats on the map at most, and the track between two of them at least, pixels.
const MOST_BOATS: f64 = 24.0;
const BOAT_SPACING_PX: f64 = 90.0;
/// From a mark to the middle of its label, pixels; the second is tried where the first finds no room.
const LABEL_DISTANCES_PX: [f64; 2] = [14.0, 22.0];

/// A hull seen from above with its bow up, 18 pixels long.
const HULL: &str = "M0-10C2.7-6 3.5-3 3.5 1L3 8H-3L-3.5 1C-3.5-3-2.7-6 0-10Z";
const DIAMOND: &str = "M0-4.5L4.5 0L0 4.5L-4.5 0Z";
const SQUARE: &str = "M-4.5-4.5H4.5V4.5H-4.5Z";

/// A flag on a staff, its foot at the place.
const FLAG: &str = "M0 0V-13L8-10L0-7";

const RALLY_STYLE: Style = Style::filled(theme::PAPER).outlined(theme::BLUE, 1.4);
const HULL_STYLE: Style = Style::filled(theme::PAPER).outlined(theme::INK, 1.1);
const WAYPOINT_STYLE: Style = Style::filled(theme::PAPER).outlined(theme::INK, 1.4);
const EVENT_STYLE: Style = Style::filled(theme::PAPER).outlined(theme::ORANGE, 1.6);
const END_STYLE: Style = Style::filled(theme::INK).outlined(theme::PAPER, 1.5);

/// Draws boats, start and end, waypoints and events; more important labels find their place first.
pub(super) fn draw(svg: &mut Svg, run: &Run, projection: &Projection) {
    let mut labels = Labels { bounds: projection.area, taken: Vec::new() };
    boats(svg, run, projection);
    waypoints(svg, run, projection, &mut labels);
    ends(svg, run, projection, &mut labels);
    rally(svg, run, projection, &mut labels);
    events(svg, run, projection, &mut labels);
}

fn boats(svg: &mut Svg, run: &Run, projection: &Projection) {
    let samples: Vec<(Point, f64)> = run
        .track
        .iter()
        .filter(|sample| is_plausible(sample.position) && sample.heading_rad.is_finite())
        .map(|sample| (projection.point(sample.position), sample.heading_rad))
        .collect();
    let length: f64 = samples.windows(2).map(|pair| pair[0].0.distance(pair[1].0)).sum();
    let spacing = (length / MOST_BOATS).max(BOAT_SPACING_PX);
    // The first boat is half a spacing from the start, so that it does not cover the mark there.
    let mut until_next = spacing / 2.0;
    for pair in samples.windows(2) {
        until_next -= pair[0].0.distance(pair[1].0);
        if until_next <= 0.0 {
            until_next = spacing;
            let (at, heading_rad) = pair[1];
            svg.shape(HULL, at, heading_rad.rem_euclid(TAU).to_degrees(), HULL_STYLE);
        }
    }
}

fn waypoints(svg: &mut Svg, run: &Run, projection: &Projection, labels: &mut Labels) {
    let points: Vec<(usize, Point)> = (1..)
        .zip(&run.mission)
        .filter(|(_, place)| is_plausible(**place))
        .map(|(number, place)| (number, projection.point(*place)))
        .take(MOST_WAYPOINTS)
        .collect();
    for (_, point) in &points {
        svg.circle(*point, 3.4, WAYPOINT_STYLE);
        labels.keep_clear(*point, 5.0);
    }
    let number_style = theme::HEADING.with_halo(theme::WATER);
    for (index, (number, point)) in points.iter().enumerate() {
        let previous = index.checked_sub(1).map(|before| points[before].1);
        let next = points.get(index + 1).map(|(_, after)| *after);
        labels.put(svg, *point, outward(previous, *point, next), &number.to_string(), number_style);
    }
}

/// The side of a corner where its legs are not: the direction away from both neighbours, pixels right and down.
fn outward(previous: Option<Point>, corner: Point, next: Option<Point>) -> Point {
    let away = |neighbour: Option<Point>| {
        let Some(neighbour) = neighbour else { return Point::new(0.0, 0.0) };
        let distance = corner.distance(neighbour).max(1.0);
        Point::new((corner.x - neighbour.x) / distance, (corner.y - neighbour.y) / distance)
    };
    let (before, after) = (away(previous), away(next));
    let sum = before.moved(after.x, after.y);
    // On a straight line the two cancel: go to its side.
    if sum.x.hypot(sum.y) < 0.2 { Point::new(before.y, -before.x) } else { sum }
}

fn ends(svg: &mut Svg, run: &Run, projection: &Projection, labels: &mut Labels) {
    let mut places = run.track.iter().map(|sample| sample.position).filter(|place| is_plausible(*place));
    let Some(first) = places.next() else { return };
    let (start, end) = (projection.point(first), places.next_back().map(|last| projection.point(last)));
    let lettering = theme::SMALL.coloured(theme::INK).with_halo(theme::WATER);
    let (below, above) = (Point::new(0.0, 1.0), Point::new(0.0, -1.0));
    svg.circle(start, 5.0, END_STYLE);
    labels.put(svg, start, below, "start", lettering);
    if let Some(end) = end {
        svg.shape(SQUARE, end, 0.0, END_STYLE);
        labels.put(svg, end, above, "end", lettering);
    }
}

fn rally(svg: &mut Svg, run: &Run, projection: &Projection, labels: &mut Labels) {
    let lettering = theme::SMALL.coloured(theme::BLUE).with_halo(theme::WATER);
    for (number, place) in (1..).zip(&run.rally).filter(|(_, place)| is_plausible(**place)) {
        let point = projection.point(*place);
        svg.shape(FLAG, point, 0.0, RALLY_STYLE);
        labels.put(svg, point, Point::new(1.0, 0.0), &format!("R{number}"), lettering);
    }
}

fn events(svg: &mut Svg, run: &Run, projection: &Projection, labels: &mut Labels) {
    let lettering = theme::SMALL.coloured(theme::ORANGE).bold().with_halo(theme::WATER);
    for (letter, time_s, _) in tables::shown_events(run) {
        let Some(place) = place_at(&run.track, time_s) else { continue };
        let point = projection.point(place);
        svg.shape(DIAMOND, point, 0.0, EVENT_STYLE);
        labels.put(svg, point, Point::new(1.0, -1.0), &letter.to_string(), lettering);
    }
}

/// Where the boat was at the sample nearest to a time within the track.
fn place_at(track: &[TrackPoint], time_s: f64) -> Option<NorthEast> {
    let known = || track.iter().filter(|sample| is_plausible(sample.position));
    let within =
        known().any(|sample| sample.time_s <= time_s) && known().any(|sample| sample.time_s >= time_s);
    let away = |sample: &&TrackPoint| (sample.time_s - time_s).abs();
    known().filter(|_| within).min_by(|a, b| away(a).total_cmp(&away(b))).map(|sample| sample.position)
}

/// The places that labels have taken.
struct Labels {
    bounds: Area,
    taken: Vec<Area>,
}

impl Labels {
    fn keep_clear(&mut self, point: Point, radius: f64) {
        let (left, top) = (point.x - radius, point.y - radius);
        self.taken.push(Area { left, top, width: 2.0 * radius, height: 2.0 * radius });
    }

    /// Writes a label beside a mark, as near to the wanted direction as there is room; without any room it is
    /// left out.
    fn put(&mut self, svg: &mut Svg, mark: Point, direction: Point, text: &str, lettering: Lettering) {
        let (width, height) = (lettering.width(text), lettering.size);
        let wanted = direction.y.atan2(direction.x);
        let turns = [0.0, 0.8, -0.8, 1.6, -1.6, 2.4, -2.4, PI];
        let candidates =
            LABEL_DISTANCES_PX.into_iter().flat_map(|away| turns.map(|turn| (away, wanted + turn)));
        for (away, angle) in candidates {
            let middle =
                mark.moved(angle.cos() * (away + (width - height).max(0.0) / 2.0), angle.sin() * away);
            let area = Area { left: middle.x - width / 2.0, top: middle.y - height / 2.0, width, height };
            if self.bounds.encloses(area) && !self.taken.iter().any(|other| other.overlaps(area)) {
                let baseline = middle.moved(0.0, height * 0.36);
                svg.text(baseline, text, lettering.anchored(Anchor::Middle));
                self.taken.push(area);
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Area = Area { left: 0.0, top: 0.0, width: 100.0, height: 100.0 };

    #[test]
    fn labels_do_not_overlap_and_stop_where_the_room_ends() {
        let mut svg = Svg::new(100.0, 100.0, "", theme::FONT_FAMILY);
        let mut labels = Labels { bounds: BOUNDS, taken: Vec::new() };
        for _ in 0..100 {
            labels.put(&mut svg, Point::new(50.0, 50.0), Point::new(1.0, 0.0), "12", theme::SMALL);
        }
        assert!((4..30).contains(&labels.taken.len()), "{} labels", labels.taken.len());
        for (index, label) in labels.taken.iter().enumerate() {
            assert!(BOUNDS.encloses(*label));
            assert!(labels.taken[..index].iter().all(|other| !other.overlaps(*label)));
        }
        assert_eq!(svg.finish().matches("<text").count(), labels.taken.len());
    }

    #[test]
    fn numbers_stand_outside_a_corner_and_beside_a_straight_line() {
        let corner = Point::new(50.0, 50.0);
        let (left, below, right) = (Point::new(0.0, 50.0), Point::new(50.0, 90.0), Point::new(90.0, 50.0));
        let away = outward(Some(left), corner, Some(below));
        assert!(away.x > 0.0 && away.y < 0.0);
        let beside = outward(Some(left), corner, Some(right));
        assert!(beside.x.abs() < 1e-9 && beside.y.abs() > 0.5);
        assert_eq!(outward(None, corner, None), Point::new(0.0, 0.0));
    }
}
