//! Lines in a terminal, drawn with the dots of Braille characters: two across and four down in each.

use helmlink_mission::geodesy::NorthEast;

/// The first Braille character; its dots are the bits of the number added to it.
const BLANK: u32 = 0x2800;
/// Bits of the dots, by row and column within a character.
const DOTS: [[u8; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];
/// At most so many lines of text.
const MOST_ROWS: usize = 60;
/// Between what is drawn and the edge, dots.
const MARGIN: f64 = 4.0;
/// Dots between those of a dotted line.
const DOTTED: usize = 3;
/// A picture shows at least this much water, metres.
const LEAST_EXTENT_M: f64 = 1.0;

/// A picture of water, north up.
pub(super) struct Canvas {
    columns: usize,
    rows: usize,
    dots: Vec<u8>,
    labels: Vec<(usize, usize, String)>,
    west_m: f64,
    north_m: f64,
    dots_per_m: f64,
}

impl Canvas {
    /// A canvas of so many columns that shows all `places`.
    pub(super) fn around(places: impl Iterator<Item = NorthEast>, columns: usize) -> Self {
        let (mut low, mut high) = (NorthEast::new(f64::MAX, f64::MAX), NorthEast::new(f64::MIN, f64::MIN));
        for place in places.filter(|place| place.is_finite()) {
            low = NorthEast::new(low.north_m.min(place.north_m), low.east_m.min(place.east_m));
            high = NorthEast::new(high.north_m.max(place.north_m), high.east_m.max(place.east_m));
        }
        if low.north_m > high.north_m {
            (low, high) = (NorthEast::ZERO, NorthEast::ZERO);
        }
        let north_m = (high.north_m - low.north_m).max(LEAST_EXTENT_M);
        let east_m = (high.east_m - low.east_m).max(LEAST_EXTENT_M);
        let across = (2 * columns) as f64 - 2.0 * MARGIN;
        let down = (4 * MOST_ROWS) as f64 - 2.0 * MARGIN;
        // A character is about twice as high as wide, so its dots are equally far apart both ways.
        let dots_per_m = (across / east_m).min(down / north_m);
        let rows = ((north_m * dots_per_m + 2.0 * MARGIN) / 4.0).ceil() as usize;
        Self {
            columns,
            rows,
            dots: vec![0; columns * rows],
            labels: Vec::new(),
            west_m: low.east_m - MARGIN / dots_per_m,
            north_m: high.north_m + MARGIN / dots_per_m,
            dots_per_m,
        }
    }

    /// A line through places.
    pub(super) fn line(&mut self, places: &[NorthEast]) {
        self.trace(places, 1);
    }

    /// A dotted line through places.
    pub(super) fn dots(&mut self, places: &[NorthEast]) {
        self.trace(places, DOTTED);
    }

    fn trace(&mut self, places: &[NorthEast], every: usize) {
        let mut count = 0;
        for pair in places.windows(2) {
            let ([x0, y0], [x1, y1]) = (self.dot(pair[0]), self.dot(pair[1]));
            let steps = (x1 - x0).abs().max((y1 - y0).abs()).ceil().clamp(1.0, 10_000.0) as usize;
            for step in 0..=steps {
                let share = step as f64 / steps as f64;
                if count % every == 0 {
                    self.set((x0 + share * (x1 - x0)).round(), (y0 + share * (y1 - y0)).round());
                }
                count += 1;
            }
        }
    }

    /// A few letters at a place.
    pub(super) fn label(&mut self, place: NorthEast, text: &str) {
        let [x, y] = self.dot(place);
        if x >= 0.0 && y >= 0.0 {
            self.labels.push(((x / 2.0) as usize, (y / 4.0) as usize, text.to_owned()));
        }
    }

    /// The lines of text, with a scale.
    pub(super) fn finish(self) -> String {
        let mut lines: Vec<Vec<char>> = self
            .dots
            .chunks(self.columns.max(1))
            .map(|row| {
                let character = |dots: &u8| match dots {
                    0 => ' ',
                    dots => char::from_u32(BLANK + u32::from(*dots)).unwrap_or(' '),
                };
                row.iter().map(character).collect()
            })
            .collect();
        for (column, row, text) in &self.labels {
            if let Some(line) = lines.get_mut(*row) {
                // The last columns have room only to the left.
                let start = (*column).min(line.len().saturating_sub(text.chars().count()));
                for (cell, letter) in line.iter_mut().skip(start).zip(text.chars()) {
                    *cell = letter;
                }
            }
        }
        let mut text: Vec<String> = lines
            .into_iter()
            .map(|line| line.into_iter().collect::<String>().trim_end().to_owned())
            .collect();
        let (length_m, columns) = self.scale();
        text.push(format!("├{}┤ {length_m} m, north is up", "─".repeat(columns.saturating_sub(2))));
        text.join("\n")
    }

    /// A round length of about a quarter of the width, metres, and its columns.
    fn scale(&self) -> (f64, usize) {
        let quarter_m = 0.5 * self.columns as f64 / self.dots_per_m;
        let magnitude = 10f64.powf(quarter_m.log10().floor());
        let length_m = [5.0, 2.0, 1.0]
            .iter()
            .map(|part| part * magnitude)
            .find(|m| *m <= quarter_m)
            .unwrap_or(magnitude);
        (length_m, (length_m * self.dots_per_m / 2.0).round() as usize)
    }

    fn dot(&self, place: NorthEast) -> [f64; 2] {
        let (east_m, south_m) = (place.east_m - self.west_m, self.north_m - place.north_m);
        [(east_m * self.dots_per_m).round(), (south_m * self.dots_per_m).round()]
    }

    fn set(&mut self, x: f64, y: f64) {
        if x < 0.0 || y < 0.0 {
            return;
        }
        let (x, y) = (x as usize, y as usize);
        let (column, row) = (x / 2, y / 4);
        if column < self.columns && row < self.rows {
            self.dots[row * self.columns + column] |= DOTS[y % 4][x % 2];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_a_square() {
        let corners = [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0), (0.0, 0.0)]
            .map(|(north_m, east_m)| NorthEast::new(north_m, east_m));
        let mut canvas = Canvas::around(corners.iter().copied(), 40);
        canvas.line(&corners);
        canvas.label(corners[1], "12");
        let text = canvas.finish();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 21, "{text}");
        assert!(lines.iter().all(|line| line.chars().count() <= 40));
        assert!(lines[1].starts_with("  12⠉"), "{text}");
        assert!(lines[20].ends_with("┤ 20 m, north is up"), "{text}");
    }

    #[test]
    fn nothing_and_a_point_can_be_drawn() {
        assert!(Canvas::around(std::iter::empty(), 30).finish().contains("north is up"));
        let mut canvas = Canvas::around(std::iter::once(NorthEast::ZERO), 30);
        canvas.line(&[NorthEast::ZERO, NorthEast::ZERO]);
        canvas.label(NorthEast::ZERO, "1");
        assert!(canvas.finish().contains('1'));
        let mut far = Canvas::around([NorthEast::ZERO, NorthEast::new(1e6, 1.0)].into_iter(), 30);
        far.line(&[NorthEast::new(-1e9, 0.0), NorthEast::new(1e9, f64::NAN)]);
        far.finish();
    }
}
