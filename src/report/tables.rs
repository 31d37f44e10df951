//! The lists below the charts: what happened, and the figures of the run.

use super::charts::TimeAxis;
use super::svg::{Anchor, Point, Svg};
use super::theme;
use super::{Run, is_reading};

/// Figures beyond this number are left out.
const MOST_FIGURES: usize = 60;
/// Between rows, pixels.
const ROW_PX: f64 = 19.0;
/// A heading with the space around it, pixels.
const HEADING_PX: f64 = 28.0;
/// Between two columns, pixels.
const GUTTER_PX: f64 = 26.0;
/// From the left edge to the time and to the words of an event, pixels.
const EVENT_TIME_PX: f64 = 66.0;
const EVENT_TEXT_PX: f64 = 76.0;

/// The events of a run that are shown, in order of time, each with its letter; there are no more than letters.
pub(super) fn shown_events(run: &Run) -> impl Iterator<Item = (char, f64, &str)> {
    let mut events: Vec<(f64, &str)> = run
        .events
        .iter()
        .filter(|(time_s, _)| is_reading(*time_s))
        .map(|(t, text)| (*t, text.as_str()))
        .collect();
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    ('A'..='Z').zip(events).map(|(letter, (time_s, text))| (letter, time_s, text))
}

/// The height that the lists of a run take, pixels.
pub(super) fn height(run: &Run, width: f64) -> f64 {
    let list = |list: Option<List>| list.map_or(0.0, |list| list.height());
    list(events(run, width)) + list(figures(run, width))
}

/// Draws the lists from `top_left` downwards.
pub(super) fn draw(svg: &mut Svg, run: &Run, top_left: Point, width: f64) {
    let mut at = top_left;
    if let Some(list) = events(run, width) {
        svg.text(at.moved(0.0, 12.0), "Events", theme::HEADING);
        let axis = TimeAxis::of(run);
        for ((letter, time_s, text), cell) in shown_events(run).zip(list.cells(at)) {
            let letters = theme::BODY.coloured(theme::ORANGE).bold();
            svg.text(cell, &letter.to_string(), letters);
            let time = theme::BODY.coloured(theme::MUTED).anchored(Anchor::End);
            svg.text(cell.moved(EVENT_TIME_PX, 0.0), &axis.label(time_s), time);
            let text = theme::BODY.fitted(text, list.column_width() - EVENT_TEXT_PX);
            svg.text(cell.moved(EVENT_TEXT_PX, 0.0), &text, theme::BODY);
        }
        at = at.moved(0.0, list.height());
    }
    if let Some(list) = figures(run, width) {
        svg.text(at.moved(0.0, 12.0), "Figures", theme::HEADING);
        for ((label, value), cell) in run.figures.iter().zip(list.cells(at)) {
            figure(svg, label, value, cell, list.column_width());
        }
    }
}

fn figure(svg: &mut Svg, label: &str, value: &str, cell: Point, width: f64) {
    let value = theme::BODY.fitted(value, 0.6 * width);
    let room = width - theme::BODY.width(&value) - 8.0;
    let label_style = theme::BODY.coloured(theme::MUTED);
    svg.text(cell, &label_style.fitted(label, room), label_style);
    svg.text(cell.moved(width, 0.0), &value, theme::BODY.anchored(Anchor::End));
    svg.line(cell.moved(0.0, 5.5), cell.moved(width, 5.5), theme::GRID_LINE);
}

/// Rows in one or two columns below a heading, filled column by column.
struct List {
    count: usize,
    columns: usize,
    width: f64,
}

impl List {
    /// Two columns where every row fits into half the width, else one; no list without rows.
    fn new(widths: impl Iterator<Item = f64>, width: f64) -> Option<Self> {
        let (count, widest) =
            widths.fold((0, 0.0_f64), |(count, widest), width| (count + 1, widest.max(width)));
        let columns = if count > 1 && widest <= (width - GUTTER_PX) / 2.0 { 2 } else { 1 };
        (count > 0).then_some(Self { count, columns, width })
    }

    fn rows(&self) -> usize {
        self.count.div_ceil(self.columns)
    }

    fn height(&self) -> f64 {
        HEADING_PX + ROW_PX * self.rows() as f64 + 8.0
    }

    fn column_width(&self) -> f64 {
        (self.width - GUTTER_PX * (self.columns - 1) as f64) / self.columns as f64
    }

    /// The left end of the base line of every row.
    fn cells(&self, top_left: Point) -> impl Iterator<Item = Point> {
        let (rows, step) = (self.rows(), self.column_width() + GUTTER_PX);
        (0..self.count).map(move |index| {
            let (column, row) = (index / rows, index % rows);
            top_left.moved(column as f64 * step, HEADING_PX + 6.0 + ROW_PX * row as f64)
        })
    }
}

fn events(run: &Run, width: f64) -> Option<List> {
    List::new(shown_events(run).map(|(_, _, text)| EVENT_TEXT_PX + theme::BODY.width(text)), width)
}

fn figures(run: &Run, width: f64) -> Option<List> {
    let shown = run.figures.iter().take(MOST_FIGURES);
    List::new(shown.map(|(label, value)| theme::BODY.width(label) + theme::BODY.width(value) + 8.0), width)
}
