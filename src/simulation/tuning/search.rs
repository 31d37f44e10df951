//! Separable CMA-ES (Ros and Hansen 2008): a cloud of candidates whose centre, step and axis lengths follow the
//! best half of it. No derivatives, few settings, and the same result for the same seed.

/// A candidate and its cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Where.
    pub point: Vec<f64>,
    /// How good; smaller is better.
    pub cost: f64,
}

/// State of a search.
#[derive(Debug, Clone)]
pub struct Search {
    centre: Vec<f64>,
    sigma: f64,
    variances: Vec<f64>,
    step_path: Vec<f64>,
    axis_path: Vec<f64>,
    random: Random,
    generation: u32,
    best: Option<Found>,
    first: bool,
}

impl Search {
    /// Starts at `start` with steps of about `sigma` along every axis.
    #[must_use]
    pub fn new(start: Vec<f64>, sigma: f64, seed: u64) -> Self {
        let count = start.len();
        Self {
            centre: start,
            sigma,
            variances: vec![1.0; count],
            step_path: vec![0.0; count],
            axis_path: vec![0.0; count],
            random: Random(seed),
            generation: 0,
            best: None,
            first: true,
        }
    }

    /// Candidates of a generation: 4 + 3 ln n.
    #[must_use]
    pub fn generation_size(&self) -> usize {
        4 + (3.0 * (self.centre.len().max(1) as f64).ln()).floor() as usize
    }

    /// The next candidates; the very first is the start itself, so that the search never ends up worse.
    pub fn ask(&mut self) -> Vec<Vec<f64>> {
        let size = self.generation_size();
        let mut candidates: Vec<Vec<f64>> = (0..size)
            .map(|_| {
                let (centre, variances) = (&self.centre, &self.variances);
                let random = &mut self.random;
                let axes = centre.iter().zip(variances);
                axes.map(|(c, v)| c + self.sigma * v.sqrt() * random.normal()).collect()
            })
            .collect();
        if std::mem::take(&mut self.first) {
            candidates[0] = self.centre.clone();
        }
        candidates
    }

    /// Takes the candidates back with their costs; a cost that is not finite is the worst of all.
    pub fn tell(&mut self, mut evaluated: Vec<Found>) {
        for found in &mut evaluated {
            if !found.cost.is_finite() {
                found.cost = f64::MAX;
            }
        }
        evaluated.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let Some(leader) = evaluated.first() else { return };
        if self.best.as_ref().is_none_or(|best| leader.cost < best.cost) {
            self.best = Some(leader.clone());
        }
        self.generation += 1;
        self.adapt(&evaluated);
    }

    fn adapt(&mut self, evaluated: &[Found]) {
        let n = self.centre.len() as f64;
        let parents = (evaluated.len() / 2).max(1);
        let raw: Vec<f64> =
            (0..parents).map(|rank| (parents as f64 + 0.5).ln() - (rank as f64 + 1.0).ln()).collect();
        let total: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|weight| weight / total).collect();
        let mass = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        let step_rate = (mass + 2.0) / (n + mass + 5.0);
        let damping = 1.0 + step_rate + 2.0 * (((mass - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0);
        let axis_rate = (4.0 + mass / n) / (n + 4.0 + 2.0 * mass / n);
        // The diagonal has few parameters and may learn (n + 2)/3 times as fast.
        let speed_up = (n + 2.0) / 3.0;
        let one_rate = (speed_up * 2.0 / ((n + 1.3).powi(2) + mass)).min(0.5);
        let many_rate =
            (speed_up * 2.0 * (mass - 2.0 + 1.0 / mass) / ((n + 2.0).powi(2) + mass)).clamp(0.0, 0.5);
        let expected_norm = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));

        let old = self.centre.clone();
        for (axis, &old_centre) in old.iter().enumerate() {
            let mean: f64 = weights.iter().zip(evaluated).map(|(w, found)| w * found.point[axis]).sum();
            self.centre[axis] = mean;
            let shift = (mean - old_centre) / self.sigma;
            self.step_path[axis] = (1.0 - step_rate) * self.step_path[axis]
                + (step_rate * (2.0 - step_rate) * mass).sqrt() * shift / self.variances[axis].sqrt();
            self.axis_path[axis] = (1.0 - axis_rate) * self.axis_path[axis]
                + (axis_rate * (2.0 - axis_rate) * mass).sqrt() * shift;
            let spread: f64 = weights
                .iter()
                .zip(evaluated)
                .map(|(w, found)| w * ((found.point[axis] - old_centre) / self.sigma).powi(2))
                .sum();
            self.variances[axis] = ((1.0 - one_rate - many_rate) * self.variances[axis]
                + one_rate * self.axis_path[axis].powi(2)
                + many_rate * spread)
                .max(1e-6);
        }
        let norm = self.step_path.iter().map(|value| value * value).sum::<f64>().sqrt();
        self.sigma *= (step_rate / damping * (norm / expected_norm - 1.0)).clamp(-0.5, 0.5).exp();
    }

    /// The best candidate so far.
    #[must_use]
    pub fn best(&self) -> Option<&Found> {
        self.best.as_ref()
    }
}

/// SplitMix64 (Steele, Lea and Flood 2014): small, fast, good enough to scatter candidates.
#[derive(Debug, Clone)]
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Between 0 (not included) and 1.
    fn uniform(&mut self) -> f64 {
        ((self.next() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// Standard normal, by Box and Muller.
    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search(seed: u64, budget: usize, cost: impl Fn(&[f64]) -> f64) -> Found {
        let mut search = Search::new(vec![1.0; 6], 0.5, seed);
        let mut tried = 0;
        while tried < budget {
            let candidates = search.ask();
            tried += candidates.len();
            let told = candidates.into_iter().map(|point| Found { cost: cost(&point), point }).collect();
            search.tell(told);
        }
        search.best().unwrap().clone()
    }

    /// A narrow bowl with its bottom at 3, along axes of very different length.
    fn bowl(point: &[f64]) -> f64 {
        point.iter().zip(1..).map(|(x, axis)| 10f64.powi(axis % 3) * (x - 3.0).powi(2)).sum()
    }

    #[test]
    fn finds_the_bottom_of_a_bowl() {
        let found = search(1, 1500, bowl);
        assert!(found.cost < 1e-3, "{found:?}");
    }

    #[test]
    fn the_same_seed_finds_the_same_and_another_seed_something_else() {
        assert_eq!(search(7, 100, bowl), search(7, 100, bowl));
        assert_ne!(search(7, 100, bowl), search(8, 100, bowl));
    }

    #[test]
    fn never_ends_up_worse_than_it_started_and_survives_costs_that_are_no_numbers() {
        let start = bowl(&[1.0; 6]);
        assert!(search(3, 20, bowl).cost <= start);
        let patchy = |point: &[f64]| if point[0] > 1.2 { f64::NAN } else { bowl(point) };
        assert!(search(3, 200, patchy).cost < start);
    }
}
