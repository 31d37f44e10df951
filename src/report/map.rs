//! The water from above: north up, a metre equally long in all directions.

use super::legend::ErrorScale;
use super::marks;
use super::svg::{Anchor, Area, Point, Style, Svg};
use super::theme;
use super::ticks::{self, Range};
use super::{Run, TrackPoint, is_plausible};
use crate::thin::keep_extremes;
use helmlink_mission::geodesy::NorthEast;

/// Left and below the map, for the labels of the grid, pixels.
const LABEL_WIDTH: f64 = 40.0;
const LABEL_HEIGHT: f64 = 22.0;
/// Between what is drawn and the edge of the map, pixels.
const PADDING: f64 = 44.0;
/// A map shows at least this much water, metres.
const LEAST_EXTENT_M: f64 = 10.0;
/// Between lines of the grid at least, pixels.
const GRID_PX: f64 = 60.0;
/// The longest scale bar, pixels.
const SCALE_BAR_PX: f64 = 165.0;
/// Long lines are thinned to the extremes of this many stretches.
const STRETCHES: usize = 800;

/// Where places on the water lie on the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    centre: NorthEast,
    pixels_per_m: f64,
    pub(super) area: Area,
}

impl Projection {
    /// The largest equal scale at which everything plausible of a run fits into `area`.
    pub(super) fn fitting(run: &Run, area: Area) -> Self {
        let places = || {
            let track = run.track.iter().map(|sample| sample.position);
            let fence = run.fence.iter().flat_map(|area| &area.outline);
            let given = run.mission.iter().chain(&run.path).chain(fence).chain(&run.rally);
            given.copied().chain(track).filter(|place| is_plausible(*place))
        };
        let north = Range::covering(places().map(|place| place.north_m), LEAST_EXTENT_M);
        let east = Range::covering(places().map(|place| place.east_m), LEAST_EXTENT_M);
        let along_width = (area.width - 2.0 * PADDING) / east.span();
        let along_height = (area.height - 2.0 * PADDING) / north.span();
        Self {
            centre: NorthEast::new(north.middle(), east.middle()),
            pixels_per_m: along_width.min(along_height),
            area,
        }
    }

    pub(super) fn point(&self, place: NorthEast) -> Point {
        let from_centre = (place - self.centre) * self.pixels_per_m;
        self.area.middle().moved(from_centre.east_m, -from_centre.north_m)
    }

    /// The part of one axis that `pixels` show around the centre.
    fn shown(&self, middle_m: f64, pixels: f64) -> Range {
        let half_m = pixels / self.pixels_per_m / 2.0;
        Range { low: middle_m - half_m, high: middle_m + half_m }
    }
}

/// Draws the map with the labels of its grid into `outer`.
pub(super) fn draw(svg: &mut Svg, run: &Run, scale: &ErrorScale, outer: Area) {
    let area = Area {
        left: outer.left + LABEL_WIDTH,
        top: outer.top,
        width: outer.width - LABEL_WIDTH,
        height: outer.height - LABEL_HEIGHT,
    };
    let projection = Projection::fitting(run, area);
    svg.area(area, 0.0, Style::filled(theme::WATER));
    grid(svg, &projection);
    fence(svg, run, &projection);
    mission_and_path(svg, run, &projection);
    track(svg, run, scale, &projection);
    marks::draw(svg, run, &projection);
    if [run.mission.is_empty(), run.path.is_empty(), run.track.is_empty(), run.fence.is_empty()] == [true; 4]
    {
        svg.text(
            area.middle(),
            "no positions",
            theme::SUBTITLE.anchored(Anchor::Middle).with_halo(theme::WATER),
        );
    }
    scale_bar(svg, &projection);
    north_arrow(svg, Point::new(area.right() - 24.0, area.top + 30.0));
    svg.area(area, 0.0, Style::stroked(theme::RULE, 1.0));
}

fn grid(svg: &mut Svg, projection: &Projection) {
    let area = projection.area;
    let step = ticks::round_step(area.width / projection.pixels_per_m, (area.width / GRID_PX).floor());
    let (unit, metres) = if step >= 1000.0 { ("km", 1000.0) } else { ("m", 1.0) };
    let label = |value: f64| ticks::label(value / metres, step / metres);

    let centred = theme::SMALL.anchored(Anchor::Middle);
    for east_m in ticks::ticks(projection.shown(projection.centre.east_m, area.width), step) {
        let x = projection.point(NorthEast::new(projection.centre.north_m, east_m)).x;
        svg.line(Point::new(x, area.top), Point::new(x, area.bottom()), theme::GRID_LINE);
        if x < area.right() - 50.0 {
            svg.text(Point::new(x, area.bottom() + 15.0), &label(east_m), centred);
        }
    }
    let before = theme::SMALL.anchored(Anchor::End);
    for north_m in ticks::ticks(projection.shown(projection.centre.north_m, area.height), step) {
        let y = projection.point(NorthEast::new(north_m, projection.centre.east_m)).y;
        svg.line(Point::new(area.left, y), Point::new(area.right(), y), theme::GRID_LINE);
        svg.text(Point::new(area.left - 6.0, y + 3.5), &label(north_m), before);
    }
    svg.text(Point::new(area.right(), area.bottom() + 15.0), &format!("east, {unit}"), before);
    let inside = theme::SMALL.with_halo(theme::WATER);
    svg.text(Point::new(area.left + 7.0, area.top + 15.0), &format!("north, {unit}"), inside);
}

fn fence(svg: &mut Svg, run: &Run, projection: &Projection) {
    for area in &run.fence {
        let places = area.outline.iter().filter(|place| is_plausible(**place));
        let outline: Vec<Point> = places.map(|place| projection.point(*place)).collect();
        let style = if area.inclusion { theme::KEEP_IN_LINE } else { theme::KEEP_OUT_LINE };
        svg.polylines([outline.as_slice()], style);
    }
}

pub(super) fn mission_and_path(svg: &mut Svg, run: &Run, projection: &Projection) {
    let line = |places: &[NorthEast]| -> Vec<Point> {
        let points: Vec<Point> = places
            .iter()
            .filter(|place| is_plausible(**place))
            .map(|place| projection.point(*place))
            .collect();
        keep_extremes(&points, STRETCHES, &[|point| point.x, |point| point.y])
            .into_iter()
            .map(|index| points[index])
            .collect()
    };
    svg.polylines([line(&run.path).as_slice()], theme::PATH_LINE);
    svg.polylines([line(&run.mission).as_slice()], theme::LEG_LINE);
}

/// Draws the track in one path for every colour, larger errors above smaller ones.
fn track(svg: &mut Svg, run: &Run, scale: &ErrorScale, projection: &Projection) {
    let samples: Vec<&TrackPoint> = run.track.iter().filter(|sample| is_plausible(sample.position)).collect();
    let kept = keep_extremes(
        &samples,
        STRETCHES,
        &[
            |sample| sample.position.north_m,
            |sample| sample.position.east_m,
            |sample| sample.cross_track_m.abs(),
        ],
    );
    let points: Vec<Point> = kept.iter().map(|index| projection.point(samples[*index].position)).collect();
    // A segment has the class of the sample that it leads to.
    let classes: Vec<Option<usize>> =
        kept.iter().skip(1).map(|index| scale.class(samples[*index].cross_track_m)).collect();

    for class in std::iter::once(None).chain((0..theme::ERROR_COLOURS.len()).map(Some)) {
        let mut lines = Vec::new();
        let mut start = 0;
        for stretch in classes.chunk_by(|a, b| a == b) {
            if stretch[0] == class {
                lines.push(&points[start..=start + stretch.len()]);
            }
            start += stretch.len();
        }
        svg.polylines(lines, Style::stroked(scale.colour(class), 2.4));
    }
}

pub(super) fn scale_bar(svg: &mut Svg, projection: &Projection) {
    let longest_m = SCALE_BAR_PX / projection.pixels_per_m;
    // The largest round length that fits: round lengths are at most 2.5 times apart, so the last one always does.
    let length_m = [1.0, 2.0, 3.0]
        .map(|parts| ticks::round_step(longest_m, parts))
        .into_iter()
        .find(|length_m| *length_m <= longest_m)
        .unwrap_or(longest_m);
    let length_px = length_m * projection.pixels_per_m;
    let text = match length_m >= 1000.0 {
        true => format!("{} km", ticks::label(length_m / 1000.0, length_m / 1000.0)),
        false => format!("{} m", ticks::label(length_m, length_m)),
    };
    let left = Point::new(projection.area.left + 16.0, projection.area.bottom() - 14.0);
    let right = left.moved(length_px, 0.0);
    let bar = [left.moved(0.0, -5.0), left, right, right.moved(0.0, -5.0)];
    svg.polylines([bar.as_slice()], Style::stroked(theme::WATER, 5.0));
    svg.polylines([bar.as_slice()], Style::stroked(theme::INK, 1.3));
    let lettering = theme::SMALL.coloured(theme::INK).anchored(Anchor::Middle).with_halo(theme::WATER);
    svg.text(left.moved(length_px / 2.0, -6.0), &text, lettering);
}

pub(super) fn north_arrow(svg: &mut Svg, middle: Point) {
    svg.shape("M0-12L5 10L0 6L-5 10Z", middle.moved(0.0, 6.0), 0.0, Style::filled(theme::INK));
    let lettering = theme::HEADING.anchored(Anchor::Middle).with_halo(theme::WATER);
    svg.text(middle.moved(0.0, -10.0), "N", lettering);
}
