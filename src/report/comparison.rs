//! Several runs of the same mission in one picture: their tracks on one map, their errors below each other.

use super::map::{self, Projection};
use super::svg::{Anchor, Area, Point, Style, Svg};
use super::ticks::{self, Range};
use super::{MARGIN, Run, TrackPoint, WIDTH, header, header_height, is_plausible, is_reading, theme};
use crate::thin::keep_extremes;

/// Colours of the runs, in their order: those of Okabe and Ito (2008).
const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
/// The part of the width that the map takes, pixels.
const MAP_WIDTH: f64 = 620.0;
/// Height of the error plot of one run, pixels.
const PLOT_HEIGHT: f64 = 96.0;
/// Above a plot for its name, pixels.
const NAME_HEIGHT: f64 = 26.0;
/// Lines are thinned to the extremes of this many stretches.
const STRETCHES: usize = 450;
/// Ticks are at least this far apart, pixels.
const TICK_PX: f64 = 26.0;

/// The track of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedTrack {
    /// What it is called.
    pub name: String,
    /// What the boat did.
    pub track: Vec<TrackPoint>,
}

/// Draws several tracks over one mission, with the cross-track error of each over time. `ground` gives title,
/// mission and path.
pub fn comparison_svg(ground: &Run, tracks: &[ComparedTrack]) -> String {
    let top = header_height(ground);
    let body = (tracks.len() as f64 * (PLOT_HEIGHT + NAME_HEIGHT) + 30.0).max(640.0);
    let title = theme::TITLE.fitted(&ground.title, WIDTH - 2.0 * MARGIN);
    let height = top + body + MARGIN;
    let mut svg = Svg::new(WIDTH, height, &title, theme::FONT_FAMILY);
    let sheet = Area { left: 0.5, top: 0.5, width: WIDTH - 1.0, height: height - 1.0 };
    svg.area(sheet, 10.0, Style::filled(theme::PAPER).outlined(theme::RULE, 1.0));
    header(&mut svg, &title, ground);
    draw_map(&mut svg, ground, tracks, Area { left: MARGIN, top, width: MAP_WIDTH, height: body });
    let left = MARGIN + MAP_WIDTH + 70.0;
    let side = Area { left, top, width: WIDTH - MARGIN - left, height: body };
    draw_errors(&mut svg, tracks, side);
    svg.finish()
}

fn draw_map(svg: &mut Svg, ground: &Run, tracks: &[ComparedTrack], area: Area) {
    let everything =
        Run { track: tracks.iter().flat_map(|run| run.track.iter().copied()).collect(), ..ground.clone() };
    let projection = Projection::fitting(&everything, area);
    svg.area(area, 0.0, Style::filled(theme::WATER));
    map::mission_and_path(svg, ground, &projection);
    for (run, colour) in tracks.iter().zip(COLOURS.iter().cycle()) {
        let places: Vec<Point> = run
            .track
            .iter()
            .filter(|sample| is_plausible(sample.position))
            .map(|sample| projection.point(sample.position))
            .collect();
        let kept = keep_extremes(&places, STRETCHES, &[|point| point.x, |point| point.y]);
        let line: Vec<Point> = kept.into_iter().map(|index| places[index]).collect();
        svg.polylines([line.as_slice()], Style::stroked(colour, 1.4));
    }
    map::scale_bar(svg, &projection);
    map::north_arrow(svg, Point::new(area.right() - 24.0, area.top + 30.0));
    svg.area(area, 0.0, Style::stroked(theme::RULE, 1.0));
}

/// One plot per run, all with the same axes.
fn draw_errors(svg: &mut Svg, tracks: &[ComparedTrack], side: Area) {
    let samples = || {
        let all = tracks.iter().flat_map(|run| &run.track);
        all.filter(|sample| is_reading(sample.time_s) && is_reading(sample.cross_track_m))
    };
    let time = Range::covering(samples().map(|sample| sample.time_s), 1.0);
    let error = Range::covering(samples().map(|sample| sample.cross_track_m).chain([-0.1, 0.1]), 0.2);
    for (row, (run, colour)) in tracks.iter().zip(COLOURS.iter().cycle()).enumerate() {
        let top = side.top + row as f64 * (PLOT_HEIGHT + NAME_HEIGHT) + NAME_HEIGHT;
        let plot = Area { left: side.left, top, width: side.width, height: PLOT_HEIGHT };
        svg.text(Point::new(plot.left, top - 7.0), &run.name, theme::HEADING.coloured(colour));
        if row == 0 {
            let note = theme::SMALL.anchored(Anchor::End);
            svg.text(Point::new(plot.right(), top - 7.0), "cross-track error, m, right positive", note);
        }
        let x = |time_s: f64| plot.left + (time_s - time.low) / time.span() * plot.width;
        let y = |error_m: f64| plot.bottom() - (error_m - error.low) / error.span() * plot.height;
        let step = ticks::round_step(error.span(), (PLOT_HEIGHT / TICK_PX).floor());
        for value in ticks::ticks(error, step) {
            let (left, right) = (Point::new(plot.left, y(value)), Point::new(plot.right(), y(value)));
            svg.line(left, right, theme::GRID_LINE);
            let label = theme::SMALL.anchored(Anchor::End);
            svg.text(left.moved(-6.0, 3.5), &ticks::label(value, step), label);
        }
        let curve: Vec<&TrackPoint> = run
            .track
            .iter()
            .filter(|sample| is_reading(sample.time_s) && is_reading(sample.cross_track_m))
            .collect();
        let kept = keep_extremes(&curve, STRETCHES, &[|sample| sample.cross_track_m]);
        let line: Vec<Point> = kept
            .into_iter()
            .map(|index| Point::new(x(curve[index].time_s), y(curve[index].cross_track_m)))
            .collect();
        svg.polylines([line.as_slice()], Style::stroked(colour, 1.1));
        svg.area(plot, 0.0, Style::stroked(theme::RULE, 1.0));
    }
    let step = ticks::round_step(time.span(), 6.0);
    let bottom = side.top + tracks.len() as f64 * (PLOT_HEIGHT + NAME_HEIGHT) + 15.0;
    for value in ticks::ticks(time, step) {
        let at = Point::new(side.left + (value - time.low) / time.span() * side.width, bottom);
        svg.text(at, &format!("{} s", ticks::label(value, step)), theme::SMALL.anchored(Anchor::Middle));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use helmlink_mission::geodesy::NorthEast;

    #[test]
    fn every_track_is_drawn_in_its_colour_under_its_name() {
        let track = |right_m: f64| -> Vec<TrackPoint> {
            (0..50)
                .map(|second| TrackPoint {
                    time_s: f64::from(second),
                    position: NorthEast::new(f64::from(second), right_m),
                    cross_track_m: right_m,
                    ..TrackPoint::UNKNOWN
                })
                .collect()
        };
        let ground = Run {
            title: "two boats".to_owned(),
            mission: vec![NorthEast::new(0.0, 0.0), NorthEast::new(50.0, 0.0)],
            ..Run::default()
        };
        let tracks = [("one & only", 0.2), ("other", -0.4)]
            .map(|(name, right_m)| ComparedTrack { name: name.to_owned(), track: track(right_m) });
        let svg = comparison_svg(&ground, &tracks);
        for expected in ["two boats", "one &amp; only", "other", COLOURS[0], COLOURS[1]] {
            assert!(svg.contains(expected), "{expected}");
        }
        assert!(comparison_svg(&Run::default(), &[]).starts_with("<svg"));
    }
}
