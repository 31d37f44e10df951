//! The strip below the map: what its colours, lines and arrows mean.

use super::svg::{Anchor, Area, Point, Style, Svg};
use super::theme;
use super::ticks;
use super::{Run, TrackPoint, is_reading};
use helmlink_mission::geodesy::NorthEast;

/// Height of the strip, pixels.
pub(super) const HEIGHT: f64 = 56.0;
/// Classes of equal width; one more holds what is beyond them.
const CLASSES: usize = theme::ERROR_COLOURS.len() - 1;
/// The classes reach to at least this part of all errors.
const COVERED: f64 = 0.95;
/// Width of one colour in the legend, pixels.
const SWATCH_PX: f64 = 42.0;
/// Height for all lines of the legend where they are many, pixels.
const ROWS_PX: f64 = 52.0;
/// Currents and winds slower than this have no direction worth drawing, m/s.
const CALM_MPS: f64 = 0.005;

/// Which cross-track error has which colour.
#[derive(Debug, Clone, Copy)]
pub(super) struct ErrorScale {
    /// Width of a class, m.
    step_m: f64,
}

impl ErrorScale {
    /// The finest round scale that covers 95 % of the errors of a track; the rest has the last colour.
    pub(super) fn of(track: &[TrackPoint]) -> Self {
        let mut errors: Vec<f64> = track
            .iter()
            .map(|sample| sample.cross_track_m.abs())
            .filter(|error| is_reading(*error))
            .collect();
        errors.sort_unstable_by(f64::total_cmp);
        let rank = (COVERED * errors.len() as f64) as usize;
        let most_m = errors.get(rank.min(errors.len().saturating_sub(1))).copied().unwrap_or(1.0);
        Self { step_m: ticks::round_step(most_m.max(0.04), CLASSES as f64) }
    }

    /// The class of an error, or `None` where it is not known.
    pub(super) fn class(&self, cross_track_m: f64) -> Option<usize> {
        let class = (cross_track_m.abs() / self.step_m).min(CLASSES as f64);
        is_reading(cross_track_m).then_some(class as usize)
    }

    /// The colour of a class.
    pub(super) fn colour(&self, class: Option<usize>) -> &'static str {
        class.and_then(|class| theme::ERROR_COLOURS.get(class)).copied().unwrap_or(theme::UNKNOWN)
    }
}

/// Draws the strip: error colours, then lines, then the arrows of current and wind.
pub(super) fn draw(svg: &mut Svg, run: &Run, scale: &ErrorScale, area: Area) {
    let top_left = Point::new(area.left + 40.0, area.top + 14.0);
    if !run.track.is_empty() {
        error_colours(svg, scale, top_left);
    }
    lines(svg, run, top_left.moved(256.0, 0.0));
    let flows = [("current", run.current, theme::BLUE), ("wind", run.wind, theme::INK)];
    let mut at = top_left.moved(404.0, 0.0);
    for (name, velocity, colour) in flows {
        let Some(velocity) = velocity.filter(|flow| is_reading(flow.north_m) && is_reading(flow.east_m))
        else {
            continue;
        };
        flow(svg, name, velocity, at, colour);
        at = at.moved(106.0, 0.0);
    }
}

fn error_colours(svg: &mut Svg, scale: &ErrorScale, at: Point) {
    svg.text(at.moved(0.0, 6.0), "distance off the path, m", theme::SMALL);
    let centred = theme::SMALL.anchored(Anchor::Middle);
    for (class, colour) in theme::ERROR_COLOURS.into_iter().enumerate() {
        let left = at.moved(class as f64 * SWATCH_PX, 14.0);
        svg.area(
            Area { left: left.x, top: left.y, width: SWATCH_PX, height: 7.0 },
            0.0,
            Style::filled(colour),
        );
        let text = match class {
            CLASSES => "more".to_owned(),
            _ => ticks::label((class + 1) as f64 * scale.step_m, scale.step_m),
        };
        let to_middle = if class == CLASSES { SWATCH_PX * 0.7 } else { SWATCH_PX };
        svg.text(left.moved(to_middle, 20.0), &text, centred);
    }
    svg.text(at.moved(0.0, 34.0), "0", centred);
}

fn lines(svg: &mut Svg, run: &Run, at: Point) {
    let mut keys = Vec::new();
    let mut key = |present: bool, style: Style, text: &'static str| {
        if present {
            keys.push((style, text));
        }
    };
    key(run.mission.len() > 1, theme::LEG_LINE, "mission");
    key(!run.path.is_empty(), theme::PATH_LINE, "smoothed path");
    key(!run.track.is_empty(), Style::stroked(theme::ERROR_COLOURS[0], 2.4), "driven track");
    let has = |inclusion: bool| run.fence.iter().any(|area| area.inclusion == inclusion);
    key(has(true), theme::KEEP_IN_LINE, "keep inside");
    key(has(false), theme::KEEP_OUT_LINE, "keep outside");
    let row_px = if keys.len() > 3 { ROWS_PX / keys.len() as f64 } else { 15.0 };
    for (row, (style, text)) in keys.into_iter().enumerate() {
        let left = at.moved(0.0, 2.0 + row_px * row as f64);
        svg.line(left, left.moved(26.0, 0.0), style);
        svg.text(left.moved(36.0, 3.5), text, theme::SMALL);
    }
}

/// An arrow that points where the water or the air goes, with its speed.
fn flow(svg: &mut Svg, name: &str, velocity: NorthEast, at: Point, colour: &'static str) {
    let bearing_deg = velocity.bearing_rad().rem_euclid(std::f64::consts::TAU).to_degrees();
    let middle = at.moved(15.0, 16.0);
    if velocity.norm() < CALM_MPS {
        svg.circle(middle, 4.0, Style::stroked(colour, 1.6));
    } else {
        svg.shape("M0 14V-12M-5-6L0-14L5-6", middle, bearing_deg, Style::stroked(colour, 1.8));
    }
    svg.text(at.moved(38.0, 12.0), name, theme::SMALL);
    let speed = format!("{:.2} m/s", velocity.norm());
    svg.text(at.moved(38.0, 27.0), &speed, theme::SMALL.coloured(theme::INK));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_fits_most_errors_and_ignores_a_bad_start() {
        let errors = (0..1000).map(|n| if n < 20 { 30.0 } else { f64::from(n % 10) * -0.1 });
        let track: Vec<TrackPoint> = errors
            .map(|cross_track_m| TrackPoint { cross_track_m, ..TrackPoint::UNKNOWN })
            .chain([TrackPoint::UNKNOWN])
            .collect();
        let scale = ErrorScale::of(&track);
        assert_eq!(scale.step_m, 0.5);
        let classes = [0.0, -0.49, 0.51, -1.2, 1.9, 2.1, -30.0].map(|error_m| scale.class(error_m));
        assert_eq!(classes, [0, 0, 1, 2, 3, 4, 4].map(Some));
        assert_eq!(scale.class(f64::NAN), None);
    }

    #[test]
    fn a_track_without_errors_has_a_scale() {
        assert_eq!(ErrorScale::of(&[]).step_m, 0.5);
        let still = TrackPoint { cross_track_m: 0.0, ..TrackPoint::UNKNOWN };
        assert!(ErrorScale::of(&[still]).step_m > 0.0);
    }
}
