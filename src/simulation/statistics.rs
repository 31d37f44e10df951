//! Means and their confidence over repeated runs.

/// A mean with the half width of its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// Half width of the 95 % confidence interval of the mean (Student's t); zero for a single value.
    pub half_width: f64,
}

/// 97.5 % quantiles of Student's t for 1 to 30 degrees of freedom; beyond, [`NORMAL_QUANTILE`] is near enough.
const T_QUANTILES: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
    2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
];
/// 97.5 % quantile of the normal distribution, rounded up as for 60 degrees of freedom.
const NORMAL_QUANTILE: f64 = 2.0;

impl Mean {
    /// Of these values; of none, zero.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        if values.is_empty() {
            return Self::default();
        }
        let mean = values.iter().sum::<f64>() / count;
        if values.len() == 1 {
            return Self { mean, half_width: 0.0 };
        }
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let quantile = T_QUANTILES.get(values.len() - 2).copied().unwrap_or(NORMAL_QUANTILE);
        Self { mean, half_width: quantile * (variance / count).sqrt() }
    }

    /// Of the differences `ours − theirs`, pair by pair: with the same seeds the sea's share cancels.
    #[must_use]
    pub fn of_differences(ours: &[f64], theirs: &[f64]) -> Self {
        let differences: Vec<f64> = ours.iter().zip(theirs).map(|(ours, theirs)| ours - theirs).collect();
        Self::of(&differences)
    }

    /// The whole interval lies above zero.
    #[must_use]
    pub fn is_above_zero(&self) -> bool {
        self.mean - self.half_width > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_textbook_interval() {
        // Standard deviation √2.5, t(4) = 2.776: 2.776·√(2.5/5) = 1.963.
        let mean = Mean::of(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert!((mean.mean - 3.0).abs() < 1e-12 && (mean.half_width - 1.963).abs() < 1e-3, "{mean:?}");
        assert_eq!(Mean::of(&[2.0]), Mean { mean: 2.0, half_width: 0.0 });
        assert_eq!(Mean::of(&[]), Mean::default());
    }

    #[test]
    fn pairs_see_a_difference_that_the_spread_hides() {
        let theirs: Vec<f64> = (0..10).map(f64::from).collect();
        let ours: Vec<f64> = theirs.iter().map(|value| value + 0.1 + 0.001 * (value % 2.0)).collect();
        assert!(Mean::of_differences(&ours, &theirs).is_above_zero());
        assert!(!Mean::of_differences(&theirs, &ours).is_above_zero());
    }
}
