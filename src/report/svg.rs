//! Writes SVG elements, the few that the pictures need. Every number it writes is finite and every text escaped.

use std::fmt::Write as _;

/// Width of an average character as part of the size of the letters: a little generous, so that a text cut to
/// fit also fits in a wide fallback typeface.
const CHARACTER_WIDTH: f64 = 0.58;
/// How much wider bold letters are.
const BOLD_WIDTH: f64 = 1.15;
/// Coordinates beyond this many pixels are drawn at it.
const FARTHEST_PX: f64 = 1e5;

/// A place on the picture in pixels: x to the right, y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    pub(super) x: f64,
    pub(super) y: f64,
}

impl Point {
    pub(super) const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    pub(super) fn moved(self, right: f64, down: f64) -> Self {
        Self::new(self.x + right, self.y + down)
    }

    pub(super) fn distance(self, other: Self) -> f64 {
        (self.x - other.x).hypot(self.y - other.y)
    }
}

/// An upright rectangle in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Area {
    pub(super) fn right(self) -> f64 {
        self.left + self.width
    }

    pub(super) fn bottom(self) -> f64 {
        self.top + self.height
    }

    pub(super) fn middle(self) -> Point {
        Point::new(self.left + self.width / 2.0, self.top + self.height / 2.0)
    }

    pub(super) fn overlaps(self, other: Self) -> bool {
        self.left < other.right()
            && other.left < self.right()
            && self.top < other.bottom()
            && other.top < self.bottom()
    }

    pub(super) fn encloses(self, other: Self) -> bool {
        self.left <= other.left
            && other.right() <= self.right()
            && self.top <= other.top
            && other.bottom() <= self.bottom()
    }
}

/// How a shape is painted. Colours are constants of the program, so they need no escaping.
#[derive(Debug, Clone, Copy)]
pub(super) struct Style {
    fill: &'static str,
    stroke: &'static str,
    width: f64,
    dashes: Option<&'static str>,
}

impl Style {
    pub(super) const fn filled(colour: &'static str) -> Self {
        Self { fill: colour, stroke: "none", width: 0.0, dashes: None }
    }

    pub(super) const fn stroked(colour: &'static str, width: f64) -> Self {
        Self { fill: "none", stroke: colour, width, dashes: None }
    }

    pub(super) const fn outlined(self, colour: &'static str, width: f64) -> Self {
        Self { stroke: colour, width, ..self }
    }

    pub(super) const fn dashed(self, dashes: &'static str) -> Self {
        Self { dashes: Some(dashes), ..self }
    }
}

/// On which side of its point a text stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text is set.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lettering {
    pub(super) size: f64,
    pub(super) colour: &'static str,
    bold: bool,
    anchor: Anchor,
    halo: Option<&'static str>,
}

impl Lettering {
    pub(super) const fn new(size: f64, colour: &'static str) -> Self {
        Self { size, colour, bold: false, anchor: Anchor::Start, halo: None }
    }

    pub(super) const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    pub(super) const fn coloured(self, colour: &'static str) -> Self {
        Self { colour, ..self }
    }

    pub(super) const fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// Surrounds the letters with `colour`, which keeps them legible on top of lines.
    pub(super) const fn with_halo(self, colour: &'static str) -> Self {
        Self { halo: Some(colour), ..self }
    }

    /// The width that `text` takes in pixels, estimated.
    pub(super) fn width(&self, text: &str) -> f64 {
        text.chars().count() as f64 * self.character_width()
    }

    fn character_width(&self) -> f64 {
        self.size * CHARACTER_WIDTH * if self.bold { BOLD_WIDTH } else { 1.0 }
    }

    /// `text`, cut and ended with an ellipsis where it would be wider than `width` pixels.
    pub(super) fn fitted(&self, text: &str, width: f64) -> String {
        if self.width(text) <= width {
            return text.to_owned();
        }
        let room = (width / self.character_width()).floor().max(1.0) as usize;
        let mut cut: String = text.chars().take(room - 1).collect();
        cut.truncate(cut.trim_end().len());
        cut.push('…');
        cut
    }
}

/// A growing SVG document.
#[derive(Debug)]
pub(super) struct Svg {
    text: String,
}

impl Svg {
    /// Starts a picture of `width` by `height` pixels; `title` is what a screen reader says.
    pub(super) fn new(width: f64, height: f64, title: &str, font_family: &'static str) -> Self {
        let mut svg = Self { text: String::new() };
        svg.put("<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\"");
        svg.number("width", width).number("height", height);
        svg.put(" viewBox=\"0 0 ")
            .bare(width)
            .put(" ")
            .bare(height)
            .put("\" font-family=\"")
            .put(font_family);
        svg.put("\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n<title>");
        svg.escaped(title).put("</title>\n");
        svg
    }

    /// Ends the picture.
    pub(super) fn finish(mut self) -> String {
        self.put("</svg>\n");
        self.text
    }

    pub(super) fn line(&mut self, from: Point, to: Point, style: Style) {
        self.put("<line").number("x1", from.x).number("y1", from.y).number("x2", to.x).number("y2", to.y);
        self.style(style).put("/>\n");
    }

    pub(super) fn area(&mut self, area: Area, corner_radius: f64, style: Style) {
        self.put("<rect").number("x", area.left).number("y", area.top);
        self.number("width", area.width).number("height", area.height);
        if corner_radius > 0.0 {
            self.number("rx", corner_radius);
        }
        self.style(style).put("/>\n");
    }

    pub(super) fn circle(&mut self, centre: Point, radius: f64, style: Style) {
        self.put("<circle").number("cx", centre.x).number("cy", centre.y).number("r", radius);
        self.style(style).put("/>\n");
    }

    /// Draws several polylines as one element; a line of a single point is a dot. Nothing at all is no element.
    pub(super) fn polylines<'a>(&mut self, lines: impl IntoIterator<Item = &'a [Point]>, style: Style) {
        let before = self.text.len();
        self.put("<path d=\"");
        let start = self.text.len();
        for line in lines {
            self.polyline(line);
        }
        if self.text.len() == start {
            self.text.truncate(before);
            return;
        }
        self.put("\"").style(style).put("/>\n");
    }

    /// Draws path data of the program's own around `at`, turned clockwise.
    pub(super) fn shape(&mut self, data: &'static str, at: Point, clockwise_deg: f64, style: Style) {
        self.put("<path d=\"")
            .put(data)
            .put("\" transform=\"translate(")
            .bare(at.x)
            .put(" ")
            .bare(at.y)
            .put(")");
        if clockwise_deg != 0.0 {
            self.put(" rotate(").bare(clockwise_deg).put(")");
        }
        self.put("\"").style(style).put("/>\n");
    }

    pub(super) fn text(&mut self, at: Point, text: &str, lettering: Lettering) {
        if let Some(colour) = lettering.halo {
            // Twice, because not every viewer paints the stroke of a text below its filling.
            let around = Style::filled(colour).outlined(colour, 3.0);
            self.letters(at, text, lettering, around);
        }
        self.letters(at, text, lettering, Style::filled(lettering.colour));
    }

    fn letters(&mut self, at: Point, text: &str, lettering: Lettering, style: Style) {
        self.put("<text").number("x", at.x).number("y", at.y).number("font-size", lettering.size);
        if lettering.bold {
            self.put(" font-weight=\"600\"");
        }
        match lettering.anchor {
            Anchor::Start => {}
            Anchor::Middle => _ = self.put(" text-anchor=\"middle\""),
            Anchor::End => _ = self.put(" text-anchor=\"end\""),
        }
        self.style(style).put(">").escaped(text).put("</text>\n");
    }

    /// Path data of one line; points that fall on the pixel tenth of the one before are left out.
    fn polyline(&mut self, line: &[Point]) {
        let mut last = None;
        for point in line {
            let here = (tenths(point.x), tenths(point.y));
            if last == Some(here) {
                continue;
            }
            self.put(if last.is_none() { "M" } else { "L" }).bare(point.x).put(" ").bare(point.y);
            last = Some(here);
        }
        if line.len() == 1 {
            self.put("h0");
        }
    }

    fn style(&mut self, style: Style) -> &mut Self {
        self.put(" fill=\"").put(style.fill).put("\"");
        if style.width > 0.0 {
            self.put(" stroke=\"").put(style.stroke).put("\"").number("stroke-width", style.width);
        }
        if let Some(dashes) = style.dashes {
            self.put(" stroke-dasharray=\"").put(dashes).put("\"");
        }
        self
    }

    fn number(&mut self, name: &str, value: f64) -> &mut Self {
        self.put(" ").put(name).put("=\"").bare(value).put("\"")
    }

    /// A number with at most one decimal.
    fn bare(&mut self, value: f64) -> &mut Self {
        let tenths = tenths(value);
        let sign = if tenths < 0 { "-" } else { "" };
        let (whole, rest) = (tenths.abs() / 10, tenths.abs() % 10);
        // Writing to a string cannot fail.
        _ = match rest {
            0 => write!(self.text, "{sign}{whole}"),
            _ => write!(self.text, "{sign}{whole}.{rest}"),
        };
        self
    }

    fn put(&mut self, text: &str) -> &mut Self {
        self.text.push_str(text);
        self
    }

    fn escaped(&mut self, text: &str) -> &mut Self {
        for character in text.chars() {
            match character {
                '&' => self.text.push_str("&amp;"),
                '<' => self.text.push_str("&lt;"),
                '>' => self.text.push_str("&gt;"),
                '\t' | '\n' | '\r' => self.text.push(' '),
                // Characters that XML 1.0 has no way to write (section 2.2, production Char).
                '\0'..' ' | '\u{fffe}' | '\u{ffff}' => self.text.push('\u{fffd}'),
                _ => self.text.push(character),
            }
        }
        self
    }
}

/// A coordinate in tenths of a pixel; what is not a number is drawn at zero.
fn tenths(value: f64) -> i64 {
    // A saturating cast, which maps NaN to zero.
    (value.clamp(-FARTHEST_PX, FARTHEST_PX) * 10.0).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(write: impl FnOnce(&mut Svg)) -> String {
        let mut svg = Svg { text: String::new() };
        write(&mut svg);
        svg.text
    }

    #[test]
    fn numbers_are_short_and_finite() {
        for (value, text) in [
            (1.0, "1"),
            (-0.04, "0"),
            (-0.25, "-0.3"),
            (12.34, "12.3"),
            (f64::NAN, "0"),
            (f64::INFINITY, "100000"),
            (-1e300, "-100000"),
        ] {
            assert_eq!(written(|svg| _ = svg.bare(value)), text);
        }
    }

    #[test]
    fn texts_are_escaped() {
        assert_eq!(
            written(|svg| _ = svg.escaped("a<b> & \"c\"\n\u{1}\u{ffff}ø")),
            "a&lt;b&gt; &amp; \"c\" \u{fffd}\u{fffd}ø"
        );
    }

    #[test]
    fn a_line_repeats_no_point_and_a_lone_point_is_a_dot() {
        let points = [Point::new(1.0, 2.0), Point::new(1.01, 2.0), Point::new(3.0, 2.0)];
        assert_eq!(written(|svg| svg.polyline(&points)), "M1 2L3 2");
        assert_eq!(written(|svg| svg.polyline(&points[..1])), "M1 2h0");
        assert_eq!(written(|svg| svg.polylines([&points[..0]], Style::filled("red"))), "");
    }

    #[test]
    fn long_texts_are_cut_at_a_character() {
        let lettering = Lettering::new(10.0, "black");
        assert_eq!(lettering.fitted("short", 100.0), "short");
        let cut = lettering.fitted("Überführungsfahrt nach Århus", 60.0);
        assert_eq!(cut, "Überführu…");
        assert!(lettering.width(&cut) <= 60.0);
        assert_eq!(lettering.fitted("x y z", 0.0), "…");
    }
}
