//! What can be wrong with a mission file.

use std::fmt;
use std::path::{Path, PathBuf};

use super::CommandName;
use crate::geodesy::PositionFault;

/// Why a mission file could not be read or written: which file, where in it, what was found there, what was
/// expected, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The file cannot be read at all.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file is larger than any mission.
    #[error("{} is larger than {limit_mb} MB, which no mission is: check the path", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The limit, megabytes.
        limit_mb: u64,
    },
    /// The text is not a mission.
    #[error("{}{place}{fault}", path.as_ref().map(|path| format!("{}: ", path.display())).unwrap_or_default())]
    Content {
        /// The file, when the text came from one.
        path: Option<PathBuf>,
        /// Where in the text.
        place: Place,
        /// What is wrong there.
        fault: Fault,
    },
}

impl PlanError {
    pub(super) fn at(place: Place, fault: impl Into<Fault>) -> Self {
        Self::Content { path: None, place, fault: fault.into() }
    }

    /// The same error with the name of the file it was found in.
    pub(super) fn in_file(self, file: &Path) -> Self {
        match self {
            Self::Content { place, fault, .. } => Self::Content { path: Some(file.into()), place, fault },
            other => other,
        }
    }

    /// What is wrong, for errors of content.
    pub fn fault(&self) -> Option<&Fault> {
        match self {
            Self::Content { fault, .. } => Some(fault),
            _ => None,
        }
    }
}

/// Where in a mission file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(usize),
    /// An item of a `.plan` file, counted from 1.
    Item(usize),
    /// An item stored within a complex item, both counted from 1.
    Within(usize, usize),
    /// A feature of a GeoJSON file, counted from 1.
    Feature(usize),
    /// An area of a fence, counted from 1.
    Area(usize),
    /// A rally point, counted from 1.
    Rally(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, "line {line}: "),
            Self::Item(item) => write!(f, "item {item}: "),
            Self::Within(item, inner) => write!(f, "item {item}, its part {inner}: "),
            Self::Feature(feature) => write!(f, "feature {feature}: "),
            Self::Area(area) => write!(f, "fence, area {area}: "),
            Self::Rally(point) => write!(f, "rally point {point}: "),
        }
    }
}

/// What is wrong in a mission file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// None of the formats.
    #[error(
        "starts with \"{0}\", which begins none of the formats that are read (QGC WPL 110, QGroundControl's \
         .plan, GeoJSON, GPX, KML, KMZ, CSV with headings): save the mission again from a ground station"
    )]
    NotAMission(String),
    /// No line with anything on it.
    #[error("the file is empty: save the mission again from a ground station, as \"QGC WPL 110\" or .plan")]
    Nothing,
    /// Not text.
    #[error("is not UTF-8 text, so it is not a mission file: save the mission again from a ground station")]
    NotText,
    /// A WPL header of another version.
    #[error("\"{0}\" is a version of the waypoint format that is not supported: save it as \"QGC WPL 110\"")]
    Version(String),
    /// A line with the wrong number of columns.
    #[error(
        "found {0} columns, expected 12 (index, current, frame, command, 4 parameters, latitude, longitude, \
         altitude, autocontinue): was a line broken or joined?"
    )]
    Columns(usize),
    /// A column that is not the number it should be.
    #[error("{column} is \"{found}\", expected {expected}")]
    Number {
        /// Name of the column.
        column: &'static str,
        /// The text found.
        found: String,
        /// What belongs there.
        expected: &'static str,
    },
    /// Items out of order.
    #[error("the index is {found}, expected {expected}: number the items one after the other from 0")]
    Index {
        /// The index that follows from the lines before.
        expected: usize,
        /// The index found.
        found: u16,
    },
    /// A position that is none.
    #[error("{0}: correct the position of this item")]
    Position(#[from] PositionFault),
    /// A frame that is not supported.
    #[error(
        "frame {0} is not supported: save the mission with altitudes relative to home (frame 3); \
         supported are 0, 2, 3, 5, 6, 10 and 11"
    )]
    Frame(u8),
    /// A waypoint in the frame of commands without a position.
    #[error("{0} in frame 2 has no position: give it frame 3")]
    NoFrame(CommandName),
    /// Not JSON, or JSON of another shape.
    #[error("{0}: this is not how QGroundControl writes a plan; save the mission again from it")]
    Json(String),
    /// A complex item whose waypoints are not in the file.
    #[error(
        "a complex item \"{0}\" without stored waypoints cannot be read: in QGroundControl, split it into \
         waypoints or save the mission as \"QGC WPL 110\""
    )]
    ComplexItem(String),
    /// A complex item for aircraft.
    #[error("{0}, a boat cannot drive it: remove the item in QGroundControl")]
    NotForBoats(&'static str),
    /// An item that is neither simple nor complex.
    #[error("type is \"{0}\", expected \"SimpleItem\" or \"ComplexItem\"")]
    ItemType(String),
    /// Not XML.
    #[error("this is not well-formed XML: {0}")]
    Xml(String),
    /// Not GeoJSON.
    #[error("this is not GeoJSON: {0}")]
    GeoJson(String),
    /// Not a zip archive with a KML document in it.
    #[error("this archive cannot be read: {0}")]
    Zip(String),
    /// A table without the headings it needs.
    #[error("the first line has no headings \"latitude\" and \"longitude\": add a line of headings")]
    Headings,
    /// Something else, described in full.
    #[error("{0}")]
    Described(String),
    /// No items.
    #[error("the mission has no items: add at least one waypoint")]
    Empty,
}
