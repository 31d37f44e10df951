//! Curves over one common time axis.

use super::svg::{Anchor, Area, Point, Style, Svg};
use super::theme;
use super::ticks::{self, Range};
use super::{Run, TrackPoint, is_reading, tables};
use crate::thin::keep_extremes;

/// The least height that the charts need together, pixels.
pub(super) const LEAST_HEIGHT: f64 = 450.0;
/// Plots do not grow taller than this, pixels.
const TALLEST_PLOT_PX: f64 = 170.0;
/// Above a plot, for its title, and below the last one, for the time, pixels.
const TITLE_PX: f64 = 38.0;
const TIME_LABELS_PX: f64 = 44.0;
/// The part of `TITLE_PX` that keeps a title away from the plot above it, pixels.
const ABOVE_TITLE_PX: f64 = 12.0;
/// Between the letters of two events at least, pixels.
const LETTER_PX: f64 = 9.0;
/// Left of a plot, for the labels of its axis, pixels.
const AXIS_LABELS_PX: f64 = 34.0;
/// Right of a plot on the page, so that the last letter of an axis is not cut, pixels.
const EDGE_PX: f64 = 8.0;
/// From the start of a title to the names of its curves, pixels.
const TITLE_WIDTH_PX: f64 = 130.0;
/// Between the outermost value and the edge of the plot, as part of the height.
const AIR: f64 = 0.04;
/// Between ticks at least, pixels.
const TIME_TICK_PX: f64 = 56.0;
const VALUE_TICK_PX: f64 = 20.0;
/// The time axis is at least this long, s.
const LEAST_TIME_S: f64 = 1.0;
/// Curves are thinned to the extremes of this many stretches, about one per pixel.
const STRETCHES: usize = 420;

/// One plot: curves of the same unit.
struct Chart {
    /// What its curves have in common, left of their names.
    title: &'static str,
    /// Set small behind the names.
    note: &'static str,
    curves: &'static [Curve],
    /// What the axis shows even where the curves do not reach.
    always: Range,
}

struct Curve {
    name: &'static str,
    value: fn(&TrackPoint) -> f64,
    style: Style,
    colour: &'static str,
}

const CHARTS: [Chart; 5] = [
    Chart {
        title: "Cross-track error",
        note: "m, positive right of the path",
        curves: &[Curve {
            name: "",
            value: |sample| sample.cross_track_m,
            style: Style::stroked(theme::ERROR_COLOURS[0], 1.3),
            colour: theme::ERROR_COLOURS[0],
        }],
        always: Range { low: -0.1, high: 0.1 },
    },
    Chart {
        title: "Speed",
        note: "m/s",
        curves: &[
            Curve {
                name: "wanted",
                value: |sample| sample.wanted_speed_mps,
                style: Style::stroked(theme::ORANGE, 1.3).dashed("5 3"),
                colour: theme::ORANGE,
            },
            Curve {
                name: "driven",
                value: |sample| sample.speed_mps,
                style: Style::stroked(theme::BLUE, 1.3),
                colour: theme::BLUE,
            },
        ],
        always: Range { low: 0.0, high: 0.5 },
    },
    Chart {
        title: "Commands",
        note: "part of full",
        curves: &[
            Curve {
                name: "throttle",
                value: |sample| sample.throttle,
                style: Style::stroked(theme::ORANGE, 1.3),
                colour: theme::ORANGE,
            },
            Curve {
                name: "steering",
                value: |sample| sample.steering,
                style: Style::stroked(theme::BLUE, 1.3),
                colour: theme::BLUE,
            },
        ],
        always: Range { low: -1.0, high: 1.0 },
    },
    Chart {
        title: "Disturbance",
        note: "bounds",
        curves: &[
            Curve {
                name: "yaw, rad/s²",
                value: |sample| sample.disturbances[1],
                style: Style::stroked(theme::ORANGE, 1.3),
                colour: theme::ORANGE,
            },
            Curve {
                name: "surge, m/s²",
                value: |sample| sample.disturbances[0],
                style: Style::stroked(theme::BLUE, 1.3),
                colour: theme::BLUE,
            },
        ],
        always: Range { low: 0.0, high: 0.01 },
    },
    Chart {
        title: "Sliding surfaces",
        note: "",
        curves: &[
            Curve {
                name: "yaw, rad/s",
                value: |sample| sample.surfaces[1],
                style: Style::stroked(theme::ORANGE, 1.3),
                colour: theme::ORANGE,
            },
            Curve {
                name: "surge, m/s",
                value: |sample| sample.surfaces[0],
                style: Style::stroked(theme::BLUE, 1.3),
                colour: theme::BLUE,
            },
        ],
        always: Range { low: -0.05, high: 0.05 },
    },
];
/// So many of the charts, the first ones, are in the picture; all are on the page.
const IN_PICTURE: usize = 3;

/// The shared time axis: what it shows, and in which unit it is labelled.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeAxis {
    range: Range,
    unit: &'static str,
    seconds: f64,
}

impl TimeAxis {
    /// The axis of a run: seconds up to ten minutes, then minutes up to three hours, then hours.
    pub(super) fn of(run: &Run) -> Self {
        Self::covering(run.track.iter().map(|sample| sample.time_s))
    }

    /// An axis that shows these times.
    pub(super) fn covering(times: impl Iterator<Item = f64>) -> Self {
        let times = times.filter(|time_s| is_reading(*time_s));
        let range = Range::covering(times, LEAST_TIME_S);
        let (unit, seconds) = match range.span() {
            ..600.0 => ("s", 1.0),
            ..10_800.0 => ("min", 60.0),
            _ => ("h", 3600.0),
        };
        Self { range, unit, seconds }
    }

    /// A time in the unit of the axis.
    pub(super) fn label(&self, time_s: f64) -> String {
        let decimals = if self.seconds > 1000.0 { 0.01 } else { 0.1 };
        format!("{} {}", ticks::label(time_s / self.seconds, decimals), self.unit)
    }

    fn x(&self, time_s: f64, plot: Area) -> f64 {
        plot.left + plot.width * self.range.fraction(time_s)
    }
}

/// Draws the charts into the upper part of `area` and returns where they end.
pub(super) fn draw(svg: &mut Svg, run: &Run, area: Area) -> f64 {
    let axis = TimeAxis::of(run);
    let count = IN_PICTURE as f64;
    let height = ((area.height - TIME_LABELS_PX) / count - TITLE_PX).min(TALLEST_PLOT_PX);
    let mut plot =
        Area { left: area.left + AXIS_LABELS_PX, top: area.top, width: area.width - AXIS_LABELS_PX, height };
    for (row, chart) in CHARTS.iter().take(IN_PICTURE).enumerate() {
        // The first title stands level with the top of the map.
        plot.top += if row == 0 { TITLE_PX - ABOVE_TITLE_PX } else { TITLE_PX };
        draw_chart(svg, run, chart, &axis, plot);
        if row == 0 {
            event_letters(svg, run, &axis, plot);
        }
        plot.top += height;
    }
    time_labels(svg, &axis, plot);
    plot.top + TIME_LABELS_PX
}

/// Each chart as a picture of its own; those without a reading are left out.
pub(super) fn page_charts(run: &Run, width: f64, height: f64) -> impl Iterator<Item = String> {
    let axis = TimeAxis::of(run);
    CHARTS.iter().filter(|chart| chart.curves.iter().any(|curve| !readings(run, curve).is_empty())).map(
        move |chart| {
            let mut svg = Svg::new(width, height, chart.title, theme::FONT_FAMILY);
            let plot = Area {
                left: AXIS_LABELS_PX,
                top: TITLE_PX - ABOVE_TITLE_PX,
                width: width - AXIS_LABELS_PX - EDGE_PX,
                height: height - TITLE_PX + ABOVE_TITLE_PX - TIME_LABELS_PX,
            };
            draw_chart(&mut svg, run, chart, &axis, plot);
            event_letters(&mut svg, run, &axis, plot);
            time_labels(&mut svg, &axis, Area { top: plot.bottom(), ..plot });
            svg.finish()
        },
    )
}

fn draw_chart(svg: &mut Svg, run: &Run, chart: &Chart, axis: &TimeAxis, plot: Area) {
    title(svg, chart, Point::new(plot.left - AXIS_LABELS_PX, plot.top - 15.0));
    let curves: Vec<(Style, Vec<(f64, f64)>)> =
        chart.curves.iter().map(|curve| (curve.style, readings(run, curve))).collect();
    let events: Vec<f64> = event_times(run, axis).map(|(_, time_s)| time_s).collect();
    draw_curves(svg, &curves, chart.always, axis, &events, plot);
}

/// Draws the grid, the axis of values and the curves of one plot.
pub(super) fn draw_curves(
    svg: &mut Svg,
    curves: &[(Style, Vec<(f64, f64)>)],
    always: Range,
    axis: &TimeAxis,
    events: &[f64],
    plot: Area,
) {
    let values = curves.iter().flat_map(|(_, readings)| readings).map(|(_, value)| *value);
    let range = shown_range(values, always);
    let step = ticks::round_step(range.span(), (plot.height / VALUE_TICK_PX).floor().max(1.0));
    let y = |value: f64| plot.bottom() - plot.height * range.fraction(value);

    svg.area(plot, 0.0, theme::GRID_LINE);
    for time_s in time_ticks(axis, plot) {
        let x = axis.x(time_s, plot);
        svg.line(Point::new(x, plot.top), Point::new(x, plot.bottom()), theme::GRID_LINE);
    }
    for time_s in events {
        let top = Point::new(axis.x(*time_s, plot), plot.top);
        svg.line(top, top.moved(0.0, plot.height), theme::EVENT_LINE);
    }
    for value in ticks::ticks(range, step) {
        let left = Point::new(plot.left, y(value));
        let style = if value.abs() < step / 2.0 { theme::ZERO_LINE } else { theme::GRID_LINE };
        svg.line(left, left.moved(plot.width, 0.0), style);
        let label = ticks::label(value, step);
        svg.text(left.moved(-6.0, 3.5), &label, theme::SMALL.anchored(Anchor::End));
    }
    for (style, readings) in curves {
        let points: Vec<Point> = keep_extremes(readings, STRETCHES, &[|(_, value)| *value])
            .into_iter()
            .map(|index| Point::new(axis.x(readings[index].0, plot), y(readings[index].1)))
            .collect();
        svg.polylines([points.as_slice()], *style);
    }
}

/// What the axis of a chart shows: all values, with a little air beyond what it shows in any case.
fn shown_range(values: impl Iterator<Item = f64>, always: Range) -> Range {
    let tight = Range::covering(values.chain([always.low, always.high]), always.span());
    let air = AIR * tight.span();
    Range {
        low: if tight.low < always.low { tight.low - air } else { tight.low },
        high: if tight.high > always.high { tight.high + air } else { tight.high },
    }
}

/// Writes the title with the names of the curves in their colours.
fn title(svg: &mut Svg, chart: &Chart, mut at: Point) {
    svg.text(at, chart.title, theme::HEADING);
    at = at.moved(TITLE_WIDTH_PX, 0.0);
    for curve in chart.curves.iter().filter(|curve| !curve.name.is_empty()).rev() {
        svg.line(at.moved(0.0, -4.0), at.moved(16.0, -4.0), curve.style);
        let lettering = theme::SMALL.coloured(curve.colour);
        svg.text(at.moved(21.0, 0.0), curve.name, lettering);
        at = at.moved(21.0 + lettering.width(curve.name) + 12.0, 0.0);
    }
    svg.text(at, chart.note, theme::SMALL);
}

/// Times and values of a curve where both are known.
fn readings(run: &Run, curve: &Curve) -> Vec<(f64, f64)> {
    run.track
        .iter()
        .map(|sample| (sample.time_s, (curve.value)(sample)))
        .filter(|(time_s, value)| is_reading(*time_s) && is_reading(*value))
        .collect()
}

fn time_ticks(axis: &TimeAxis, plot: Area) -> Vec<f64> {
    ticks::ticks(axis.range, time_step(axis, plot))
}

/// A step that is round in the unit of the axis, s.
fn time_step(axis: &TimeAxis, plot: Area) -> f64 {
    ticks::round_step(axis.range.span() / axis.seconds, (plot.width / TIME_TICK_PX).floor()) * axis.seconds
}

pub(super) fn time_labels(svg: &mut Svg, axis: &TimeAxis, below: Area) {
    let step = time_step(axis, below);
    let lettering = theme::SMALL.anchored(Anchor::Middle);
    for time_s in time_ticks(axis, below) {
        let label = ticks::label(time_s / axis.seconds, step / axis.seconds);
        svg.text(Point::new(axis.x(time_s, below), below.top + 14.0), &label, lettering);
    }
    let at = Point::new(below.right(), below.top + 27.0);
    svg.text(at, &format!("time, {}", axis.unit), theme::SMALL.anchored(Anchor::End));
}

/// Letters and times of the events within the shown time.
fn event_times(run: &Run, axis: &TimeAxis) -> impl Iterator<Item = (char, f64)> {
    let range = axis.range;
    tables::shown_events(run)
        .map(|(letter, time_s, _)| (letter, time_s))
        .filter(move |(_, time_s)| range.contains(*time_s))
}

/// Writes the letters of the events on top of their lines, side by side where the lines are close together.
fn event_letters(svg: &mut Svg, run: &Run, axis: &TimeAxis, plot: Area) {
    let lettering = theme::SMALL.coloured(theme::ORANGE).bold().anchored(Anchor::Middle);
    let mut free_from = plot.left;
    for (letter, time_s) in event_times(run, axis) {
        let x = axis.x(time_s, plot).max(free_from);
        if x <= plot.right() {
            svg.text(Point::new(x, plot.top - 3.0), &letter.to_string(), lettering);
            free_from = x + LETTER_PX;
        }
    }
}
