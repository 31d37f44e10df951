//! Ranges of numbers, and round numbers to mark them with.

/// Part of a step by which a tick may miss the end of a range and still count as inside.
const ROUNDING: f64 = 1e-6;
/// No axis has more ticks than this, whatever it is asked for.
const MOST_TICKS: f64 = 200.0;

/// A closed interval of finite numbers that is never empty: `low < high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Range {
    /// The smallest range that holds all finite values, widened about its middle to `least_span` (> 0).
    /// Without a finite value it starts at zero.
    pub(super) fn covering(values: impl Iterator<Item = f64>, least_span: f64) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if low > high {
            return Self { low: 0.0, high: least_span };
        }
        let missing = (least_span - (high - low)).max(0.0);
        Self { low: low - missing / 2.0, high: high + missing / 2.0 }
    }

    pub(super) fn span(self) -> f64 {
        self.high - self.low
    }

    pub(super) fn middle(self) -> f64 {
        self.low + self.span() / 2.0
    }

    pub(super) fn contains(self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Where `value` lies: 0 at the low end, 1 at the high end.
    pub(super) fn fraction(self, value: f64) -> f64 {
        (value - self.low) / self.span()
    }
}

/// The smallest of … 0.1, 0.2, 0.5, 1, 2, 5, 10 … that divides `span` into at most `most` steps.
pub(super) fn round_step(span: f64, most: f64) -> f64 {
    let least = span / most;
    if !least.is_finite() || least < f64::MIN_POSITIVE {
        return 1.0;
    }
    let decade = 10_f64.powi(exponent(least));
    [1.0, 2.0, 5.0]
        .map(|digit| digit * decade)
        .into_iter()
        .find(|step| *step >= least)
        .unwrap_or(10.0 * decade)
}

/// The multiples of `step` inside `range`, ascending.
pub(super) fn ticks(range: Range, step: f64) -> Vec<f64> {
    let first = (range.low / step - ROUNDING).ceil();
    let last = (range.high / step + ROUNDING).floor().min(first + MOST_TICKS);
    std::iter::successors(Some(first), |index| Some(index + 1.0))
        .take_while(|index| *index <= last)
        .map(|index| index * step)
        .collect()
}

/// `value` with the decimals that a multiple of `step` needs, and a true minus sign.
pub(super) fn label(value: f64, step: f64) -> String {
    let decimals = usize::try_from(-exponent(step)).unwrap_or(0).min(9);
    let digits = format!("{:.decimals$}", value.abs());
    let is_zero = digits.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    if value < 0.0 && !is_zero { format!("−{digits}") } else { digits }
}

/// The power of ten of the first digit of a positive number.
fn exponent(value: f64) -> i32 {
    // The sum keeps numbers like 0.001, whose logarithm comes out a hair low, in their own decade.
    (value.log10() + 1e-9).floor() as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn steps_are_one_two_or_five_times_a_power_of_ten() {
        for (span, most, step) in [
            (10.0, 5.0, 2.0),
            (10.0, 4.0, 5.0),
            (10.0, 10.0, 1.0),
            (0.001, 1.0, 0.001),
            (7.3, 4.0, 2.0),
            (0.9, 4.0, 0.5),
            (61_000.0, 6.0, 20_000.0),
        ] {
            assert!((round_step(span, most) / step - 1.0).abs() < 1e-12, "{span} in {most}");
        }
    }

    #[test]
    fn a_step_for_nothing_is_one() {
        for span in [0.0, -3.0, f64::NAN, f64::INFINITY] {
            assert_eq!(round_step(span, 5.0), 1.0);
        }
    }

    #[test]
    fn labels_have_the_decimals_of_their_step() {
        assert_eq!(label(0.30000000000000004, 0.1), "0.3");
        assert_eq!(label(-0.5, 0.5), "−0.5");
        assert_eq!(label(-1e-17, 0.2), "0.0");
        assert_eq!(label(1200.0, 200.0), "1200");
        assert_eq!(label(0.002, 0.001), "0.002");
    }

    #[test]
    fn ticks_include_both_ends() {
        assert_eq!(ticks(Range { low: -1.0, high: 1.0 }, 0.5), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        let tenths = ticks(Range { low: 0.1, high: 0.3 }, 0.1);
        assert_eq!(tenths.len(), 3);
    }

    #[test]
    fn a_range_covers_finite_values_only() {
        let range = Range::covering([f64::NAN, 2.0, f64::INFINITY, 5.0].into_iter(), 1.0);
        assert_eq!(range, Range { low: 2.0, high: 5.0 });
        assert_eq!(Range::covering([4.0].into_iter(), 2.0), Range { low: 3.0, high: 5.0 });
        assert_eq!(Range::covering(std::iter::empty(), 2.0), Range { low: 0.0, high: 2.0 });
    }

    proptest! {
        #[test]
        fn ticks_are_few_even_and_inside(
            low in -1e6..1e6_f64,
            span in 1e-3..1e6_f64,
            most in 2.0..12.0_f64,
        ) {
            let range = Range { low, high: low + span };
            let step = round_step(range.span(), most);
            prop_assert!(range.span() / step <= most * (1.0 + 1e-9));
            let marks = ticks(range, step);
            prop_assert!(marks.len() as f64 <= most + 2.0);
            // A step is at most 2.5 times the smallest one that would do.
            prop_assert!(marks.len() as f64 >= (most / 2.5 - 1.0).floor());
            for mark in &marks {
                let slack = 2.0 * ROUNDING * step;
                prop_assert!((low - slack..=low + span + slack).contains(mark));
                prop_assert!((mark / step - (mark / step).round()).abs() < 1e-6);
            }
            for pair in marks.windows(2) {
                prop_assert!(((pair[1] - pair[0]) / step - 1.0).abs() < 1e-3);
            }
        }
    }
}
