//! Curves of several runs over one time axis, for a comparison.

use super::charts::{TimeAxis, draw_curves, time_labels};
use super::is_reading;
use super::svg::{Area, Point, Style, Svg};
use super::theme;
use super::ticks::Range;

/// Colours of the curves, in turn.
const COLOURS: [&str; 4] = [theme::BLUE, theme::ORANGE, theme::MUTED, theme::ERROR_COLOURS[2]];
const WIDTH: f64 = 1200.0;
const MARGIN: f64 = 36.0;
const AXIS_LABELS_PX: f64 = 44.0;
const PLOT_PX: f64 = 150.0;
const TITLE_PX: f64 = 34.0;
const HEADER_PX: f64 = 64.0;
const FOOTER_PX: f64 = 50.0;

/// One quantity over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// What it belongs to.
    pub name: String,
    /// Time in seconds and value, in order of time.
    pub readings: Vec<(f64, f64)>,
}

/// Curves of one unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// What they show, with the unit.
    pub title: String,
    /// The curves, at most four.
    pub curves: Vec<Curve>,
}

/// Draws panels one below the other as a self-contained SVG file 1200 pixels wide.
pub fn curves_svg(title: &str, subtitle: &str, panels: &[Panel]) -> String {
    let height = HEADER_PX + panels.len() as f64 * (TITLE_PX + PLOT_PX) + FOOTER_PX;
    let mut svg = Svg::new(WIDTH, height, title, theme::FONT_FAMILY);
    let sheet = Area { left: 0.5, top: 0.5, width: WIDTH - 1.0, height: height - 1.0 };
    svg.area(sheet, 10.0, Style::filled(theme::PAPER).outlined(theme::RULE, 1.0));
    let room = WIDTH - 2.0 * MARGIN;
    svg.text(Point::new(MARGIN, 38.0), &theme::TITLE.fitted(title, room), theme::TITLE);
    svg.text(Point::new(MARGIN, 58.0), &theme::SUBTITLE.fitted(subtitle, room), theme::SUBTITLE);
    let times = panels.iter().flat_map(|panel| &panel.curves).flat_map(|curve| &curve.readings);
    let axis = TimeAxis::covering(times.map(|(time_s, _)| *time_s));
    let mut plot = Area {
        left: MARGIN + AXIS_LABELS_PX,
        top: HEADER_PX,
        width: WIDTH - 2.0 * MARGIN - AXIS_LABELS_PX,
        height: PLOT_PX,
    };
    for panel in panels {
        plot.top += TITLE_PX;
        draw_panel(&mut svg, panel, &axis, plot);
        plot.top += PLOT_PX;
    }
    time_labels(&mut svg, &axis, plot);
    svg.finish()
}

fn draw_panel(svg: &mut Svg, panel: &Panel, axis: &TimeAxis, plot: Area) {
    let mut at = Point::new(plot.left - AXIS_LABELS_PX, plot.top - 10.0);
    svg.text(at, &panel.title, theme::HEADING);
    at = at.moved(theme::HEADING.width(&panel.title) + 20.0, 0.0);
    let mut curves = Vec::new();
    for (curve, colour) in panel.curves.iter().zip(COLOURS) {
        let style = Style::stroked(colour, 1.3);
        svg.line(at.moved(0.0, -4.0), at.moved(16.0, -4.0), style);
        let lettering = theme::SMALL.coloured(colour);
        svg.text(at.moved(21.0, 0.0), &curve.name, lettering);
        at = at.moved(21.0 + lettering.width(&curve.name) + 14.0, 0.0);
        let readings = curve
            .readings
            .iter()
            .copied()
            .filter(|(time_s, value)| is_reading(*time_s) && is_reading(*value));
        curves.push((style, readings.collect()));
    }
    draw_curves(svg, &curves, Range { low: -0.01, high: 0.01 }, axis, &[], plot);
}
