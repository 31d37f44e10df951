//! Leaves out most samples of a long run without losing what an eye would see.

/// Indices of the samples to draw, ascending: all of them where they are few, otherwise of each of `stretches`
/// equal stretches the first sample and, for every measure, the samples where it is smallest and largest among
/// the finite ones. The very last sample stays as well.
pub(crate) fn keep_extremes<S>(samples: &[S], stretches: usize, measures: &[fn(&S) -> f64]) -> Vec<usize> {
    let kept_each = 1 + 2 * measures.len();
    if samples.len() <= stretches * kept_each {
        return (0..samples.len()).collect();
    }
    let mut kept = Vec::with_capacity(stretches * kept_each + 1);
    for stretch in 0..stretches {
        let start = stretch * samples.len() / stretches;
        let end = (stretch + 1) * samples.len() / stretches;
        kept.push(start);
        for measure in measures {
            let value = |index: &usize| measure(&samples[*index]);
            let known = || (start..end).filter(|index| value(index).is_finite());
            kept.extend(known().min_by(|a, b| value(a).total_cmp(&value(b))));
            kept.extend(known().max_by(|a, b| value(a).total_cmp(&value(b))));
        }
    }
    kept.push(samples.len() - 1);
    kept.sort_unstable();
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_samples_all_stay() {
        assert_eq!(keep_extremes(&[3.0, 1.0, 2.0], 10, &[|value| *value]), [0, 1, 2]);
        assert!(keep_extremes(&[], 10, &[|value: &f64| *value]).is_empty());
    }

    #[test]
    fn peaks_and_ends_stay() {
        let mut samples = vec![0.0; 10_000];
        samples[1234] = 5.0;
        samples[8765] = -7.0;
        samples[1230] = f64::NAN;
        let kept = keep_extremes(&samples, 50, &[|value| *value]);
        assert!(kept.len() <= 151);
        for index in [0, 1234, 8765, 9999] {
            assert!(kept.contains(&index), "{index}");
        }
        assert!(!kept.contains(&1230), "an unknown value is no peak");
        assert!(kept.is_sorted());
    }
}
