//! Missions as a navigator writes them: items, and the files they are kept in.
//!
//! [`read_plan`] takes every format of [`Format`], told apart by their content; [`read`] only wants the mission
//! of it. [`Format::encode`] makes a file of any format, and says what it could not hold.

mod command;
mod csv;
mod decimal;
mod diff;
mod error;
pub(crate) mod fence;
mod format;
mod geojson;
mod gpx;
mod item;
mod kml;
mod kmz;
mod qgc;
mod wpl;
mod xml;

use std::io::Read as _;
use std::path::Path;
use std::str::FromStr;

use helmlink_wire::enums::MAV_FRAME_GLOBAL_RELATIVE_ALT;

pub use command::CommandName;
pub use diff::{Difference, canonical, differences};
pub use error::{Fault, Place, PlanError};
pub use fence::{Area, Fence, Outline, RallyPoint};
pub use format::{Format, Loss};
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

/// The frame of a waypoint where nothing else is said.
const DEFAULT_FRAME: u8 = MAV_FRAME_GLOBAL_RELATIVE_ALT;

/// Everything that a mission file may hold.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    /// What to do.
    pub mission: Mission,
    /// Where the boat may not go.
    pub fence: Fence,
    /// Where it may return to.
    pub rally: Vec<RallyPoint>,
}

impl Plan {
    /// Nothing to do, nothing to stay clear of, nowhere to return to.
    pub fn is_empty(&self) -> bool {
        self.mission.items.is_empty() && self.fence.is_empty() && self.rally.is_empty()
    }
}

/// A file, read.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// What it holds.
    pub plan: Plan,
    /// Its format.
    pub format: Format,
    /// What in it was left out or had to be guessed, in words.
    pub notes: Vec<String>,
}

impl Reading {
    fn of(plan: Plan) -> Self {
        Self { plan, format: Format::Wpl, notes: Vec::new() }
    }

    /// What the bytes of a file hold.
    ///
    /// # Errors
    /// Content that is no plan; says where and what to do.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PlanError> {
        if bytes.starts_with(kmz::MAGIC) {
            let reading = Self::from_text(&kmz::unpack(bytes)?)?;
            return Ok(Self { format: Format::Kmz, ..reading });
        }
        match std::str::from_utf8(bytes) {
            Ok(text) => Self::from_text(text),
            Err(_) => Err(PlanError::at(Place::File, Fault::NotText)),
        }
    }

    fn from_text(text: &str) -> Result<Self, PlanError> {
        let text = text.trim_start_matches('\u{feff}');
        let format = Format::of_content(text)?;
        let reading = match format {
            Format::Wpl => wpl::parse(text),
            Format::Qgc => qgc::parse(text),
            Format::GeoJson => geojson::parse(text),
            Format::Gpx => gpx::parse(text),
            Format::Kml | Format::Kmz => kml::parse(text),
            Format::Csv => csv::parse(text),
        }?;
        Ok(Self { format, ..reading })
    }
}

/// The mission in a file of any format.
///
/// # Errors
/// A file that cannot be read, or whose content is not a mission; says where and what to do.
pub fn read(path: impl AsRef<Path>) -> Result<Mission, PlanError> {
    let path = path.as_ref();
    let mission = read_plan(path)?.plan.mission;
    if mission.items.is_empty() {
        return Err(PlanError::at(Place::File, Fault::Empty).in_file(path));
    }
    Ok(mission)
}

/// Everything in a file of any format.
///
/// # Errors
/// A file that cannot be read, or whose content is no plan; says where and what to do.
pub fn read_plan(path: impl AsRef<Path>) -> Result<Reading, PlanError> {
    let path = path.as_ref();
    let failed = |source| PlanError::Read { path: path.into(), source };
    let file = std::fs::File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    let limit = MAX_FILE_MB * 1_000_000;
    // One more than the limit shows that there is more; a pipe or a device has no length to ask for.
    if file.take(limit + 1).read_to_end(&mut bytes).map_err(failed)? as u64 > limit {
        return Err(PlanError::TooLarge { path: path.into(), limit_mb: MAX_FILE_MB });
    }
    Reading::from_bytes(&bytes).map_err(|error| error.in_file(path))
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

    /// The mission in a text of any format.
    fn from_str(text: &str) -> Result<Self, PlanError> {
        let mission = Reading::from_text(text)?.plan.mission;
        if mission.items.is_empty() { Err(PlanError::at(Place::File, Fault::Empty)) } else { Ok(mission) }
    }
}

/// As much of a text as an error quotes.
fn excerpt(text: &str) -> String {
    text.chars().take(EXCERPT_CHARS).collect()
}
