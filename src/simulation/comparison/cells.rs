//! One sea with one perturbation, all controllers; and the verdict over all of them.

use serde::Serialize;

use crate::control::Controller;
use crate::simulation::statistics::Mean;

/// The runs of one controller in one cell, one per seed, in the order of the seeds.
#[derive(Debug, Clone)]
pub struct Column {
    /// Which controller.
    pub controller: String,
    /// Error of every run, m.
    pub errors: Vec<f64>,
    /// Steering variation of every run, per minute.
    pub steering: Vec<f64>,
    /// How many runs completed their mission.
    pub completed: usize,
}

/// One controller in one cell.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// Its name.
    pub controller: String,
    /// Error over the seeds, m.
    #[serde(serialize_with = "mean_as_pair")]
    pub error_m: Mean,
    /// Steering variation over the seeds, per minute.
    #[serde(serialize_with = "mean_as_pair")]
    pub steering_per_min: Mean,
    /// How many runs completed their mission.
    pub completed: usize,
    /// How many runs there were.
    pub runs: usize,
    /// Error of the first controller minus this one's, pair by pair, m.
    #[serde(serialize_with = "mean_as_pair")]
    pub first_minus_this_m: Mean,
}

fn mean_as_pair<S: serde::Serializer>(mean: &Mean, serializer: S) -> Result<S::Ok, S::Error> {
    [mean.mean, mean.half_width].serialize(serializer)
}

/// One sea with one perturbation.
#[derive(Debug, Clone, Serialize)]
pub struct Cell {
    /// The sea.
    pub sea: String,
    /// The perturbation.
    pub perturbation: String,
    /// Every controller; the first one is judged.
    pub columns: Vec<Figures>,
    /// The first controller is no worse than any other, with 95 % confidence.
    pub no_worse: bool,
    /// The first controller is better than every other, with 95 % confidence.
    pub better: bool,
}

impl Cell {
    /// From the runs of every controller; the first one is judged.
    #[must_use]
    pub fn new(sea: String, perturbation: String, columns: Vec<Column>) -> Self {
        let ours: Vec<f64> = columns.first().map_or(Vec::new(), |column| column.errors.clone());
        let figures: Vec<Figures> = columns
            .into_iter()
            .map(|column| Figures {
                controller: column.controller,
                error_m: Mean::of(&column.errors),
                steering_per_min: Mean::of(&column.steering),
                completed: column.completed,
                runs: column.errors.len(),
                first_minus_this_m: Mean::of_differences(&ours, &column.errors),
            })
            .collect();
        let rivals = || figures.iter().skip(1).map(|figures| figures.first_minus_this_m);
        let no_worse = rivals().all(|difference| !difference.is_above_zero());
        let better = rivals().all(|difference| difference.mean + difference.half_width < 0.0);
        Self { sea, perturbation, no_worse, better, columns: figures }
    }

    /// Sea and perturbation.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{}, {}", self.sea, self.perturbation)
    }

    /// How the first controller does here: `+` better than all, `=` no worse than any, `-` worse than one.
    #[must_use]
    pub fn mark(&self) -> char {
        match (self.better, self.no_worse) {
            (true, _) => '+',
            (false, true) => '=',
            (false, false) => '-',
        }
    }
}

/// What all cells say together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// The controller that is judged.
    pub controller: String,
    /// Cells in all.
    pub cells: usize,
    /// Cells in which it is no worse than any other.
    pub no_worse: usize,
    /// Cells in which it is better than every other.
    pub better: usize,
    /// Mean error over all cells of every controller, m.
    pub means_m: Vec<(String, f64)>,
    /// The cell in which the judged controller has its largest error, m.
    pub worst: Option<(String, f64)>,
    /// Largest ratio of its steering variation to that of `pid` in any cell.
    pub most_steering_of_pid: Option<f64>,
}

/// Judges the first controller over all cells.
#[must_use]
pub fn verdict(cells: &[Cell]) -> Verdict {
    let names: Vec<String> =
        cells.first().map_or(Vec::new(), |cell| cell.columns.iter().map(|c| c.controller.clone()).collect());
    let mean = |column: usize| {
        let errors: Vec<f64> = cells.iter().map(|cell| cell.columns[column].error_m.mean).collect();
        Mean::of(&errors).mean
    };
    let pid = names.iter().position(|name| name == Controller::Pid.as_str()).filter(|index| *index > 0);
    let steering_ratio = |cell: &Cell, pid: usize| {
        cell.columns[0].steering_per_min.mean / cell.columns[pid].steering_per_min.mean.max(1e-9)
    };
    let errors = cells.iter().filter_map(|cell| Some((cell.name(), cell.columns.first()?.error_m.mean)));
    Verdict {
        controller: names.first().cloned().unwrap_or_default(),
        worst: errors.max_by(|(_, a), (_, b)| a.total_cmp(b)),
        cells: cells.len(),
        no_worse: cells.iter().filter(|cell| cell.no_worse).count(),
        better: cells.iter().filter(|cell| cell.better).count(),
        means_m: names.iter().enumerate().map(|(column, name)| (name.clone(), mean(column))).collect(),
        most_steering_of_pid: pid
            .map(|pid| cells.iter().map(|cell| steering_ratio(cell, pid)).fold(0.0, f64::max)),
    }
}

impl Verdict {
    /// A few lines for people.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let part = 100.0 * self.no_worse as f64 / self.cells.max(1) as f64;
        let means: Vec<String> =
            self.means_m.iter().map(|(name, mean_m)| format!("{name} {mean_m:.3}")).collect();
        let mut lines = vec![
            format!(
                "{} is no worse than any other in {} of {} cells ({part:.0} %), better than all in {}",
                self.controller, self.no_worse, self.cells, self.better
            ),
            format!("mean over the cells, m: {}", means.join(", ")),
        ];
        if let Some((cell, error_m)) = self.worst.as_ref().filter(|_| self.cells > 1) {
            lines.push(format!("its largest error: {error_m:.3} in {cell}"));
        }
        if let Some(ratio) = self.most_steering_of_pid {
            lines.push(format!("its steering is at most {ratio:.2} times that of pid in any cell"));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(ours: [f64; 3], theirs: [f64; 3]) -> Cell {
        let column = |controller: Controller, errors: [f64; 3]| Column {
            controller: controller.to_string(),
            errors: errors.to_vec(),
            steering: vec![1.0; 3],
            completed: 3,
        };
        Cell::new(
            "calm".to_owned(),
            "nominal".to_owned(),
            vec![column(Controller::PiSmc, ours), column(Controller::Pid, theirs)],
        )
    }

    #[test]
    fn a_cell_is_won_lost_or_neither() {
        assert_eq!(cell([0.10, 0.20, 0.30], [0.20, 0.30, 0.41]).mark(), '+');
        assert_eq!(cell([0.20, 0.30, 0.41], [0.10, 0.20, 0.30]).mark(), '-');
        assert_eq!(cell([0.10, 0.30, 0.20], [0.20, 0.10, 0.30]).mark(), '=');
    }

    #[test]
    fn the_verdict_counts_cells() {
        let cells = [cell([0.1, 0.2, 0.3], [0.2, 0.3, 0.41]), cell([0.2, 0.3, 0.41], [0.1, 0.2, 0.3])];
        let verdict = verdict(&cells);
        assert_eq!((verdict.cells, verdict.no_worse, verdict.better), (2, 1, 1));
        assert_eq!(verdict.most_steering_of_pid, Some(1.0));
        assert!(verdict.lines()[0].contains("50 %"));
    }
}
