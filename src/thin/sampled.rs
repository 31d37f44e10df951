//! A fair sample of a row of any length.

/// Numbered values, all of them while there is room. Of a longer row every second, fourth, … number stays, whatever the
/// values are: two rows of the same numbers keep the same ones.
#[derive(Debug, Clone)]
pub(crate) struct Sampled<T> {
    kept: Vec<(u64, T)>,
    /// One in two to the power of so many is kept.
    halvings: u32,
    most: usize,
}

impl<T> Sampled<T> {
    /// An empty row that keeps at most `most` values.
    pub(crate) fn new(most: usize) -> Self {
        Self { kept: Vec::new(), halvings: 0, most }
    }

    /// Appends a value; numbers rise, but some may be missing.
    pub(crate) fn push(&mut self, number: u64, value: T) {
        while self.keeps(number) && self.kept.len() >= self.most.max(1) {
            self.halvings += 1;
            let every = self.every();
            self.kept.retain(|(number, _)| number.is_multiple_of(every));
        }
        if self.keeps(number) {
            self.kept.push((number, value));
        }
    }

    /// The values kept.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.kept.iter().map(|(_, value)| value)
    }

    fn keeps(&self, number: u64) -> bool {
        number.is_multiple_of(self.every())
    }

    fn every(&self) -> u64 {
        1_u64.checked_shl(self.halvings).unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn two_rows_of_the_same_numbers_keep_the_same_ones(
            steps in prop::collection::vec(1..50_u64, 0..2000), most in 1..100_usize,
        ) {
            let (mut one, mut other) = (Sampled::new(most), Sampled::new(most));
            let mut number = 0;
            for step in &steps {
                number += step;
                one.push(number, number);
                other.push(number, number as f64);
                prop_assert!(one.kept.len() <= most);
            }
            let numbers: Vec<u64> = one.iter().copied().collect();
            prop_assert_eq!(&numbers, &other.iter().map(|value| *value as u64).collect::<Vec<_>>());
            if steps.len() <= most {
                prop_assert_eq!(numbers.len(), steps.len());
            }
        }

        #[test]
        fn half_of_the_room_at_least_is_used_of_a_row_without_gaps(count in 1..5000_u64, most in 2..100_usize) {
            let mut row = Sampled::new(most);
            (0..count).for_each(|number| row.push(number, ()));
            prop_assert!(row.iter().count() as u64 >= count.min(most as u64 / 2));
        }
    }
}
