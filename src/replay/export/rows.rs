//! One row for each control step: CSV, or one JSON object a line.

use std::io::{self, Write};

use super::Export;
use crate::record::state::VALUES;
use crate::replay::what_if::Moment;

/// The columns before those of the controller's state.
const COLUMNS: [&str; 11] = [
    "time_utc_us",
    "time_s",
    "latitude_deg",
    "longitude_deg",
    "north_m",
    "east_m",
    "heading_deg",
    "speed_mps",
    "leg_error_m",
    "recorded_steering",
    "recorded_throttle",
];

/// How rows are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowFormat {
    /// A header line, then values separated by commas; empty where nothing is known.
    Csv,
    /// One JSON object a line; null where nothing is known.
    JsonLines,
}

/// Writes rows.
pub struct Rows<W> {
    out: W,
    format: RowFormat,
    begun: bool,
}

impl<W: Write> Rows<W> {
    /// Writes to `out`, which should be buffered.
    pub fn new(out: W, format: RowFormat) -> Self {
        Self { out, format, begun: false }
    }

    fn begin(&mut self) -> io::Result<()> {
        if self.begun || self.format == RowFormat::JsonLines {
            return Ok(());
        }
        self.begun = true;
        let names: Vec<String> = names().collect();
        writeln!(self.out, "{}", names.join(","))
    }
}

/// The names of all columns.
fn names() -> impl Iterator<Item = String> {
    let state = VALUES.iter().map(|(name, ..)| name.to_lowercase());
    COLUMNS.iter().map(|name| (*name).to_owned()).chain(state)
}

fn values(moment: &Moment) -> impl Iterator<Item = Option<f64>> {
    let outputs = moment.outputs;
    let state: Vec<f32> = moment.thought.map(|thought| thought.values()).unwrap_or_default();
    let first = [
        None, // the time stamp is a whole number
        Some(moment.time_s),
        Some(moment.place.latitude_deg),
        Some(moment.place.longitude_deg),
        Some(moment.state.position.north_m),
        Some(moment.state.position.east_m),
        Some(moment.state.heading_rad.to_degrees()),
        Some(moment.state.surge_mps.hypot(moment.state.sway_mps)),
        moment.leg_error_m,
        outputs.map(|outputs| outputs.steering),
        outputs.map(|outputs| outputs.throttle),
    ];
    let rest = (0..VALUES.len()).map(move |index| state.get(index).map(|value| f64::from(*value)));
    first.into_iter().chain(rest)
}

impl<W: Write> Export for Rows<W> {
    fn moment(&mut self, moment: &Moment) -> io::Result<()> {
        self.begin()?;
        match self.format {
            RowFormat::Csv => {
                write!(self.out, "{}", moment.time_us)?;
                for (column, value) in values(moment).enumerate().skip(1) {
                    match value.filter(|value| value.is_finite()) {
                        // Degrees need nine decimals to be good to a tenth of a millimetre.
                        Some(value) if column < COLUMNS.len() => write!(self.out, ",{value:.9}")?,
                        Some(value) => write!(self.out, ",{value:.6}")?,
                        None => write!(self.out, ",")?,
                    }
                }
                writeln!(self.out)
            }
            RowFormat::JsonLines => {
                let pairs = names().zip(values(moment)).skip(1).map(|(name, value)| (name, value.into()));
                let mut object: serde_json::Map<String, serde_json::Value> = pairs.collect();
                object.insert(COLUMNS[0].to_owned(), moment.time_us.into());
                serde_json::to_writer(&mut self.out, &object)?;
                writeln!(self.out)
            }
        }
    }

    fn command(&mut self, _time_us: u64, _frame: &[u8]) -> io::Result<()> {
        Ok(())
    }

    fn event(&mut self, _time_us: u64, _text: &str) -> io::Result<()> {
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        self.begin()?;
        self.out.flush()
    }
}
