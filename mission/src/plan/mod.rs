//! Missions as a navigator writes them: items, and the files they are kept in.
//!
//! [`read`] takes the plain-text format of ArduPilot's tools (`QGC WPL 110`) and QGroundControl's `.plan`,
//! told apart by their content; [`write`](write()) makes the former, which every ground station reads.

mod command;
mod error;
mod item;
mod qgc;
mod wpl;

use std::io::Read as _;
use std::path::Path;
use std::str::FromStr;

pub use command::CommandName;
pub use error::{Fault, Place, PlanError};
pub use item::Item;
use serde::{Deserialize, Serialize};

use crate::geodesy::Geodetic;

/// Files larger than this, in megabytes, are not read: the largest mission that MAVLink can number has
/// some 10 MB.
const MAX_FILE_MB: u64 = 64;

/// The longest piece of a file that an error quotes, in characters.
const EXCERPT_CHARS: usize = 40;

/// A mission: what to do, in order.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
pub struct Mission {
    /// Where the boat was launched, when the source says so.
    pub home: Option<Geodetic>,
    /// The items without home. On ArduPilot, where home is item 0, `items[0]` has sequence number 1.
    pub items: Vec<Item>,
}

/// The mission in a file of either format.
///
/// # Errors
/// A file that cannot be read, or whose content is not a mission; says where and what to do.
pub fn read(path: impl AsRef<Path>) -> Result<Mission, PlanError> {
    let path = path.as_ref();
    let failed = |source| PlanError::Read { path: path.into(), source };
    let file = std::fs::File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    let limit = MAX_FILE_MB * 1_000_000;
    // One more than the limit shows that there is more; a pipe or a device has no length to ask for.
    if file.take(limit + 1).read_to_end(&mut bytes).map_err(failed)? as u64 > limit {
        return Err(PlanError::TooLarge { path: path.into(), limit_mb: MAX_FILE_MB });
    }
    match std::str::from_utf8(&bytes) {
        Ok(text) => text.parse().map_err(|error: PlanError| error.in_file(path)),
        Err(_) => Err(PlanError::at(Place::File, Fault::NotText).in_file(path)),
    }
}

/// Writes a mission as `QGC WPL 110`.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: impl AsRef<Path>, mission: &Mission) -> Result<(), PlanError> {
    let path = path.as_ref();
    std::fs::write(path, mission.to_wpl()).map_err(|source| PlanError::Write { path: path.into(), source })
}

impl Mission {
    /// The mission as the text of a `QGC WPL 110` file.
    pub fn to_wpl(&self) -> String {
        wpl::format(self)
    }
}

impl FromStr for Mission {
    type Err = PlanError;

    /// The mission in a text of either format.
    fn from_str(text: &str) -> Result<Self, PlanError> {
        let text = text.trim_start_matches('\u{feff}');
        let first_line = text
            .lines()
            .map(str::trim)
            .find(|line| !line.is_empty() && !line.starts_with('#'))
            .unwrap_or_default();
        if first_line.starts_with(wpl::MAGIC) {
            wpl::parse(text)
        } else if first_line.starts_with('{') {
            qgc::parse(text)
        } else {
            Err(PlanError::at(Place::File, Fault::NotAMission(excerpt(first_line))))
        }
    }
}

/// As much of a text as an error quotes.
fn excerpt(text: &str) -> String {
    text.chars().take(EXCERPT_CHARS).collect()
}
