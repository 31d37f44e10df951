//! `helmlink replay --compare A B`: two boats (or gains) on one log.

use serde::Serialize;

use super::engine::{Engine, Wishes};
use super::what_if::{check_driven, wishes};
use super::{LogFiles, ReplayArgs};
use crate::app::console;
use crate::app::failure::Failure;
use crate::app::log_report;
use crate::replay::picture::Side;
use crate::replay::what_if::{Moment, Sink, WhatIfResult};
use crate::report::{Curve, Panel, curves_svg};
use crate::thin::Sampled;

/// Vehicle time between two commands that are compared, seconds.
const SAMPLE_S: f64 = 0.1;
/// Commands kept at the most.
const MOST_COMMANDS: usize = 200_000;

/// What one of the two has given.
#[derive(Debug, Serialize)]
struct Sided {
    boat: String,
    #[serde(flatten)]
    result: WhatIfResult,
}

/// What `--compare --json` prints.
#[derive(Debug, Serialize)]
struct Report {
    log: String,
    a: Sided,
    b: Sided,
    steering_difference_rms: f64,
    steering_difference_max: f64,
    throttle_difference_rms: f64,
    throttle_difference_max: f64,
    notes: Vec<String>,
}

pub(super) fn run(args: &ReplayArgs, files: &LogFiles) -> Result<(), Failure> {
    let [name_a, name_b] = args.compare.as_slice() else {
        return Err(Failure::usage("--compare needs two boats: names or files"));
    };
    let mut engine = Engine::scan(files.clone(), args.system.map(u8::from))?;
    let mut sides = Vec::new();
    for name in [name_a, name_b] {
        let wishes = Wishes { boat: Some(name.as_str()), ..wishes(args) };
        let settings = engine.settings(&wishes, args.window.window())?;
        let mut replayed = Commands::new();
        let outcome = engine.run(settings, Side::Replayed, &mut [&mut replayed])?;
        check_driven(&engine, &outcome, args)?;
        let commands = replayed.kept.iter().copied().collect::<Vec<_>>();
        sides.push((Sided { boat: name.clone(), result: outcome.result }, commands, outcome.notes));
    }
    let (Some((b, of_b, notes)), Some((a, of_a, _))) = (sides.pop(), sides.pop()) else { return Ok(()) };
    let panels = panels([name_a, name_b], &of_a, &of_b);
    let [steering, throttle] = [2, 3].map(|panel: usize| spread(&panels[panel]));
    let report = Report {
        log: files.name(),
        a,
        b,
        steering_difference_rms: steering.0,
        steering_difference_max: steering.1,
        throttle_difference_rms: throttle.0,
        throttle_difference_max: throttle.1,
        notes,
    };
    let json = serde_json::to_string_pretty(&report).map_err(Failure::failed)?;
    if !args.no_report {
        let title = format!("{} through {name_a} and {name_b}", report.log);
        let picture =
            curves_svg(&title, "commands of the two controllers on the same recorded states", &panels);
        let files = [("compared.svg", picture.as_bytes()), ("result.json", json.as_bytes())];
        log_report::write_files(&args.report, files.into_iter())?;
        tracing::info!("picture in {}", args.report.join("compared.svg").display());
    }
    console::say(&if args.common.json { json } else { text(&report) });
    Ok(())
}

/// The commands of one side by their number and time, the same instants of a log for either side.
struct Commands {
    kept: Sampled<(f64, [f64; 2])>,
    first_s: Option<f64>,
    last: Option<u64>,
}

impl Commands {
    fn new() -> Self {
        Self { kept: Sampled::new(MOST_COMMANDS), first_s: None, last: None }
    }
}

impl Sink for Commands {
    fn moment(&mut self, moment: &Moment) {
        let time_s = moment.time_s - *self.first_s.get_or_insert(moment.time_s);
        let number = (time_s / SAMPLE_S).floor() as u64;
        if self.last.replace(number) == Some(number) {
            return;
        }
        let Some(thought) = moment.thought else { return };
        self.kept.push(number, (time_s, [thought.steering.into(), thought.throttle.into()]));
    }

    fn command(&mut self, _time_us: u64, _frame: &[u8]) {}

    fn event(&mut self, _time_s: f64, _text: &str) {}
}

fn text(report: &Report) -> String {
    let row = |side: &Sided| {
        let score = side.result.replayed.as_ref();
        let of = |value: fn(&crate::simulation::score::Score) -> f64| score.map_or(f64::NAN, value);
        format!(
            "  {:<24} {:>12.2} {:>10.3} {:>22.3}",
            side.boat,
            of(|score| score.steering_variation_per_min),
            of(|score| score.effort),
            side.result.difference.map_or(f64::NAN, |difference| difference.steering_rms)
        )
    };
    format!(
        "  {:<24} {:>12} {:>10} {:>22}\n{}\n{}\n  between the two: steering {:.3} rms, {:.3} max; throttle {:.3} rms, {:.3} max",
        "",
        "steering/min",
        "effort",
        "steering vs recorded",
        row(&report.a),
        row(&report.b),
        report.steering_difference_rms,
        report.steering_difference_max,
        report.throttle_difference_rms,
        report.throttle_difference_max
    )
}

/// Steering and throttle of both, then their differences.
fn panels(names: [&str; 2], a: &[(f64, [f64; 2])], b: &[(f64, [f64; 2])]) -> Vec<Panel> {
    let curve = |name: &str, side: &[(f64, [f64; 2])], axis: usize| Curve {
        name: name.to_owned(),
        readings: side.iter().map(|(time_s, commands)| (*time_s, commands[axis])).collect(),
    };
    let difference = |axis: usize| Curve {
        name: format!("{} minus {}", names[1], names[0]),
        readings: at_equal_times(a, b).map(|(time_s, a, b)| (time_s, b[axis] - a[axis])).collect(),
    };
    let of_both = |title: &str, axis| Panel {
        title: title.to_owned(),
        curves: vec![curve(names[0], a, axis), curve(names[1], b, axis)],
    };
    let between = |title: &str, axis| Panel { title: title.to_owned(), curves: vec![difference(axis)] };
    vec![
        of_both("Steering, −1 to 1", 0),
        of_both("Throttle, −1 to 1", 1),
        between("Steering, difference", 0),
        between("Throttle, difference", 1),
    ]
}

/// The commands of both at every instant for which both are there.
fn at_equal_times<'a>(
    a: &'a [(f64, [f64; 2])],
    b: &'a [(f64, [f64; 2])],
) -> impl Iterator<Item = (f64, [f64; 2], [f64; 2])> + 'a {
    let mut others = b.iter().peekable();
    a.iter().filter_map(move |(time_s, a)| {
        while others.next_if(|(other_s, _)| other_s < time_s).is_some() {}
        others.next_if(|(other_s, _)| other_s == time_s).map(|(_, b)| (*time_s, *a, *b))
    })
}

/// Root mean square and largest of a panel's only curve.
fn spread(panel: &Panel) -> (f64, f64) {
    let values = || panel.curves.iter().flat_map(|curve| &curve.readings).map(|(_, value)| *value);
    let count = values().count().max(1) as f64;
    let squares: f64 = values().map(|value| value * value).sum();
    ((squares / count).sqrt(), values().fold(0.0, |most: f64, value| most.max(value.abs())))
}
