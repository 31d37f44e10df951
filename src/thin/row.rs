//! Samples of a log of any length in bounded memory.

use super::keep_extremes;

/// The first stretches that a long row is thinned to, seconds.
const FIRST_STRETCH_S: f64 = 2.0;

/// Samples in order of time, all of them while they are few. Where they become too many, every stretch of time keeps its
/// first sample, its last, and for each measure the smallest and the largest; the stretches grow with the row.
#[derive(Debug)]
pub(crate) struct Thinned<T: 'static> {
    kept: Vec<T>,
    /// The samples of the stretch under way, once there are stretches.
    open: Vec<T>,
    stretch_s: Option<f64>,
    most: usize,
    time_s: fn(&T) -> f64,
    measures: &'static [fn(&T) -> f64],
}

impl<T: Clone> Thinned<T> {
    /// An empty row that keeps about `most` samples, a few more while a stretch is under way.
    pub(crate) fn new(most: usize, time_s: fn(&T) -> f64, measures: &'static [fn(&T) -> f64]) -> Self {
        Self { kept: Vec::new(), open: Vec::new(), stretch_s: None, most, time_s, measures }
    }

    /// Appends a sample.
    pub(crate) fn push(&mut self, sample: T) {
        let Some(stretch_s) = self.stretch_s else {
            self.kept.push(sample);
            if self.kept.len() > self.most {
                self.widen();
            }
            return;
        };
        let stretch = |of: &T| ((self.time_s)(of) / stretch_s).floor();
        if self.open.first().is_some_and(|first| stretch(first) != stretch(&sample)) {
            let closed = std::mem::take(&mut self.open);
            self.kept.extend(self.thin(&closed));
            if self.kept.len() > self.most {
                self.widen();
            }
        }
        self.open.push(sample);
    }

    /// The samples kept.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.kept.iter().chain(&self.open)
    }

    /// The latest sample.
    pub(crate) fn last(&self) -> Option<&T> {
        self.open.last().or(self.kept.last())
    }

    /// Longer stretches, until half of the room is free again.
    fn widen(&mut self) {
        while self.kept.len() > self.most / 2 {
            let stretch_s = self.stretch_s.map_or(FIRST_STRETCH_S, |before_s| 2.0 * before_s);
            self.stretch_s = Some(stretch_s);
            let stretch = |of: &T| ((self.time_s)(of) / stretch_s).floor();
            let thinned = self
                .kept
                .chunk_by(|a, b| stretch(a) == stretch(b))
                .flat_map(|part| self.thin(part))
                .collect();
            self.kept = thinned;
        }
    }

    fn thin(&self, stretch: &[T]) -> Vec<T> {
        keep_extremes(stretch, 1, self.measures).into_iter().map(|index| stretch[index].clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Sample = (f64, f64);

    fn row(count: u32) -> Thinned<Sample> {
        let mut row: Thinned<Sample> = Thinned::new(1000, |sample| sample.0, &[|sample| sample.1]);
        for number in 0..count {
            let peak = if number % 5003 == 77 { f64::from(number) } else { 0.0 };
            row.push((0.1 * f64::from(number), peak));
        }
        row
    }

    #[test]
    fn a_short_row_stays_as_it_is() {
        assert_eq!(row(1000).iter().count(), 1000);
    }

    #[test]
    fn a_long_row_keeps_its_peaks_and_its_end_in_little_room() {
        let row = row(300_000);
        assert!(row.kept.capacity() + row.open.capacity() < 20_000);
        let kept: Vec<Sample> = row.iter().copied().collect();
        assert!(kept.len() > 300 && kept.is_sorted_by(|a, b| a.0 < b.0));
        let peaks = kept.iter().filter(|sample| sample.1 > 0.0).count();
        assert!(peaks >= 20, "{peaks}");
        assert!(kept.iter().any(|sample| sample.1 > 295_000.0), "the largest of all");
        assert_eq!(row.last(), Some(&(0.1 * 299_999.0, 0.0)));
    }
}
