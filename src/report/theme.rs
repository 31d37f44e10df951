//! Colours, letters and lines of the picture, in one place.
//!
//! The colours of the curves are those of Okabe and Ito (2008), which stay apart for colour-blind readers; the
//! error scale also grows steadily lighter, so it survives a black-and-white print.

use super::svg::{Lettering, Style};

pub(super) const FONT_FAMILY: &str = "Inter, 'Helvetica Neue', Helvetica, Arial, 'DejaVu Sans', sans-serif";

pub(super) const PAPER: &str = "#fdfcf9";
pub(super) const WATER: &str = "#f1f5f6";
pub(super) const RULE: &str = "#dde3e5";
pub(super) const INK: &str = "#1d2933";
pub(super) const MUTED: &str = "#66737d";
pub(super) const BLUE: &str = "#0072b2";
pub(super) const ORANGE: &str = "#d55e00";

/// Colours of small to large cross-track errors; the last one is for everything beyond the scale.
pub(super) const ERROR_COLOURS: [&str; 5] = ["#1f2f6f", "#70348f", "#b84a7a", "#e27a4a", "#f0b429"];
/// Colour of the track where no cross-track error is known.
pub(super) const UNKNOWN: &str = "#7d8890";

pub(super) const TITLE: Lettering = Lettering::new(24.0, INK).bold();
pub(super) const SUBTITLE: Lettering = Lettering::new(13.0, MUTED);
pub(super) const HEADING: Lettering = Lettering::new(12.5, INK).bold();
pub(super) const BODY: Lettering = Lettering::new(12.0, INK);
pub(super) const SMALL: Lettering = Lettering::new(10.5, MUTED);

pub(super) const GRID_LINE: Style = Style::stroked(RULE, 1.0);
pub(super) const ZERO_LINE: Style = Style::stroked("#aab4ba", 1.0);
pub(super) const LEG_LINE: Style = Style::stroked("#4f5d68", 1.0).dashed("5 4");
pub(super) const PATH_LINE: Style = Style::stroked("#bcd3df", 7.0);
pub(super) const KEEP_IN_LINE: Style = Style::stroked("#009e73", 1.6).dashed("9 4");
pub(super) const KEEP_OUT_LINE: Style = Style::stroked(ORANGE, 1.6).dashed("9 4");
pub(super) const EVENT_LINE: Style = Style::stroked(MUTED, 0.8).dashed("1.5 3");
