//! Turns one run of a boat into a picture: a map of the track, curves over time, a table of figures.
//!
//! | module | what it draws or works out |
//! |---|---|
//! | `map` | the water from above: grid, mission, path, track |
//! | `marks` | boats, ends of the track, numbers of waypoints and letters of events |
//! | `legend` | the strip below the map, and which error has which colour |
//! | `charts` | error, speed and commands over time |
//! | `tables` | events and figures |
//! | `html` | the same as a page for browsers |
//! | `curves` | curves of several runs over one time axis |
//! | `theme` | colours and letters |
//! | `ticks` | round numbers |
//! | `comparison` | several runs of one mission in one picture |
//! | `svg` | the file format |
//!
//! Same run, same bytes: nothing here looks at a clock, a file or a typeface.

use std::f64::consts::TAU;

mod charts;
mod comparison;
mod curves;
mod html;
mod legend;
mod map;
mod marks;
mod svg;
mod tables;
mod theme;
mod ticks;

#[cfg(test)]
mod tests;

pub use comparison::{ComparedTrack, comparison_svg};
use helmlink_mission::geodesy::{LocalFrame, NorthEast};
use helmlink_mission::plan::{self, Fence, Outline};
use svg::{Area, Point, Style, Svg};

pub use curves::{Curve, Panel, curves_svg};
pub use html::report_html;

/// Width of the picture, pixels.
const WIDTH: f64 = 1200.0;
/// Height of the picture unless the tables need more, pixels.
const LEAST_HEIGHT: f64 = 900.0;
/// Between the content and the edge of the picture, pixels.
const MARGIN: f64 = 36.0;
/// The part of the width that the map takes with its labels, pixels.
const MAP_WIDTH: f64 = 650.0;
/// Left edge of the charts and tables, pixels.
const SIDE_LEFT: f64 = 724.0;
/// More lines than this below the title are left out.
const MOST_SUBTITLES: usize = 4;
/// Positions farther from the origin than this are taken for faults and left out: half way round the Earth.
const FARTHEST_M: f64 = 2.0e7;
/// Readings and times larger than this, in whatever unit, are taken for faults and left out.
const LARGEST_READING: f64 = 1.0e10;

/// One run of a boat, as much of it as is known; every list may be empty.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Run {
    /// What was run, in a few words.
    pub title: String,
    /// Lines below the title: the boat, the weather, the settings. The first four are shown.
    pub subtitle: Vec<String>,
    /// Waypoints in the order in which they are to be passed.
    pub mission: Vec<NorthEast>,
    /// The smoothed path that the controller was given, as a polyline.
    pub path: Vec<NorthEast>,
    /// Where the boat had to keep in or out of.
    pub fence: Vec<FenceArea>,
    /// Places to return to.
    pub rally: Vec<NorthEast>,
    /// What the boat did, in order of time.
    pub track: Vec<TrackPoint>,
    /// Label and value, with unit, of every figure worth a line in the table.
    pub figures: Vec<(String, String)>,
    /// What happened when: time in seconds, on the clock of the track, and a few words.
    pub events: Vec<(f64, String)>,
    /// Velocity at which the water moves over ground, m/s: it points where the water goes.
    pub current: Option<NorthEast>,
    /// Velocity at which the air moves over ground, m/s: it points where the air goes, so a wind from the
    /// south has a positive north component.
    pub wind: Option<NorthEast>,
}

/// One area of a fence.
#[derive(Debug, Clone, PartialEq)]
pub struct FenceArea {
    /// The boat has to stay inside; otherwise outside.
    pub inclusion: bool,
    /// Corners of its outline, the first one again at the end.
    pub outline: Vec<NorthEast>,
}

impl FenceArea {
    /// Corners of a circle.
    const CIRCLE_CORNERS: usize = 72;

    /// The areas of a fence in a local frame.
    pub fn all_of(fence: &Fence, frame: &LocalFrame) -> Vec<Self> {
        let outline = |outline: &Outline| match outline {
            Outline::Polygon(corners) => {
                corners.iter().chain(corners.first()).map(|corner| frame.to_local(*corner)).collect()
            }
            Outline::Circle { centre, radius_m } => {
                let centre = frame.to_local(*centre);
                let bearing_rad = |corner: usize| TAU * corner as f64 / Self::CIRCLE_CORNERS as f64;
                (0..=Self::CIRCLE_CORNERS)
                    .map(|corner| centre + NorthEast::from_polar(f64::from(*radius_m), bearing_rad(corner)))
                    .collect()
            }
        };
        let area = |area: &plan::Area| Self { inclusion: area.inclusion, outline: outline(&area.outline) };
        fence.areas.iter().map(area).collect()
    }
}

/// One instant of a run. A reading that is not known is NaN and is left out of its curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPoint {
    /// Time since an epoch of the caller's choice, s.
    pub time_s: f64,
    /// Where the boat was.
    pub position: NorthEast,
    /// Where its bow pointed, clockwise from north, rad.
    pub heading_rad: f64,
    /// Cross-track error, m, positive where the boat is right of the path.
    pub cross_track_m: f64,
    /// Speed of the boat, m/s.
    pub speed_mps: f64,
    /// Speed that it was to have, m/s.
    pub wanted_speed_mps: f64,
    /// Steering command, −1 (full left) … 1 (full right).
    pub steering: f64,
    /// Throttle command, −1 (full astern) … 1 (full ahead).
    pub throttle: f64,
    /// Sliding surfaces in surge, m/s, and in yaw, rad/s.
    pub surfaces: [f64; 2],
    /// Estimated disturbance bounds in surge, m/s², and in yaw, rad/s².
    pub disturbances: [f64; 2],
}

impl TrackPoint {
    /// An instant of which nothing is known; fill in what is.
    pub const UNKNOWN: Self = Self {
        time_s: f64::NAN,
        position: NorthEast { north_m: f64::NAN, east_m: f64::NAN },
        heading_rad: f64::NAN,
        cross_track_m: f64::NAN,
        speed_mps: f64::NAN,
        wanted_speed_mps: f64::NAN,
        steering: f64::NAN,
        throttle: f64::NAN,
        surfaces: [f64::NAN; 2],
        disturbances: [f64::NAN; 2],
    };
}

/// Draws a run as a self-contained SVG file of 1200 × 900 pixels, taller where the tables need it.
///
/// North is up on the map, and a metre is as long northwards as eastwards. Long runs are thinned, extremes kept,
/// so that the file stays below half a megabyte. Samples that are not finite numbers are left out; no input
/// makes it fail.
pub fn track_svg(run: &Run) -> String {
    let body_top = header_height(run);
    let side_width = WIDTH - MARGIN - SIDE_LEFT;
    let tables_height = tables::height(run, side_width);
    let body_height = (LEAST_HEIGHT - MARGIN - body_top).max(charts::LEAST_HEIGHT + tables_height);
    let height = body_top + body_height + MARGIN;

    let title = theme::TITLE.fitted(&run.title, WIDTH - 2.0 * MARGIN);
    let mut svg = Svg::new(WIDTH, height, &title, theme::FONT_FAMILY);
    let sheet = Area { left: 0.5, top: 0.5, width: WIDTH - 1.0, height: height - 1.0 };
    svg.area(sheet, 10.0, Style::filled(theme::PAPER).outlined(theme::RULE, 1.0));
    header(&mut svg, &title, run);

    let map_height = body_height - legend::HEIGHT;
    let scale = legend::ErrorScale::of(&run.track);
    map::draw(
        &mut svg,
        run,
        &scale,
        Area { left: MARGIN, top: body_top, width: MAP_WIDTH, height: map_height },
    );
    let strip = Area { left: MARGIN, top: body_top + map_height, width: MAP_WIDTH, height: legend::HEIGHT };
    legend::draw(&mut svg, run, &scale, strip);

    let charts_height = body_height - tables_height;
    let side = Area { left: SIDE_LEFT, top: body_top, width: side_width, height: charts_height };
    // A mission that nobody has driven has nothing over time.
    let charts_bottom = if run.track.is_empty() { body_top } else { charts::draw(&mut svg, run, side) };
    tables::draw(&mut svg, run, Point::new(SIDE_LEFT, charts_bottom), side_width);
    svg.finish()
}

/// Where the content below the title begins, pixels.
fn header_height(run: &Run) -> f64 {
    MARGIN + 46.0 + 18.0 * run.subtitle.len().min(MOST_SUBTITLES) as f64
}

fn header(svg: &mut Svg, title: &str, run: &Run) {
    let width = WIDTH - 2.0 * MARGIN;
    svg.text(Point::new(MARGIN, MARGIN + 20.0), title, theme::TITLE);
    for (row, line) in run.subtitle.iter().take(MOST_SUBTITLES).enumerate() {
        let at = Point::new(MARGIN, MARGIN + 42.0 + 18.0 * row as f64);
        svg.text(at, &theme::SUBTITLE.fitted(line, width), theme::SUBTITLE);
    }
}

/// Whether a position is worth drawing.
fn is_plausible(position: NorthEast) -> bool {
    position.north_m.abs() <= FARTHEST_M && position.east_m.abs() <= FARTHEST_M
}

/// Whether a time or a reading is worth drawing.
fn is_reading(value: f64) -> bool {
    value.abs() <= LARGEST_READING
}
