//! Tables: one line an item, after a line of headings.
//!
//! Written here, a table holds everything; the column `list` says what a line belongs to. Any other table with
//! headings for latitude and longitude is read as waypoints in their order; commas, semicolons and tabs separate,
//! and with semicolons or tabs a decimal comma is understood.

use std::fmt::Write as _;

use helmlink_wire::enums::{MAV_CMD_DO_CHANGE_SPEED, MAV_CMD_NAV_WAYPOINT, MAV_FRAME_MISSION};

use super::error::{Fault, Place, PlanError};
use super::item::check_and_scale;
use super::{Fence, Item, Plan, RallyPoint, Reading};
use crate::geodesy::Geodetic;

/// A column with a meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    List,
    Command,
    Frame,
    Param(usize),
    Latitude,
    Longitude,
    Altitude,
    Autocontinue,
    Hold,
    Radius,
    Speed,
    Other,
}

impl Column {
    fn of(heading: &str) -> Self {
        let name: String = heading
            .trim_matches(|c: char| c.is_whitespace() || c == '"' || c == '\u{feff}')
            .to_ascii_lowercase()
            .split(['(', '[', '/'])
            .next()
            .unwrap_or_default()
            .chars()
            .filter(|c| c.is_alphanumeric())
            .collect();
        match name.as_str() {
            "list" => Self::List,
            "command" | "cmd" => Self::Command,
            "frame" => Self::Frame,
            "param1" | "p1" => Self::Param(0),
            "param2" | "p2" => Self::Param(1),
            "param3" | "p3" => Self::Param(2),
            "param4" | "p4" => Self::Param(3),
            "latitude" | "lat" | "latdeg" | "latitudedeg" | "y" => Self::Latitude,
            "longitude" | "lon" | "lng" | "long" | "londeg" | "longitudedeg" | "x" => Self::Longitude,
            "altitude" | "alt" | "altm" | "altitudem" | "elevation" | "ele" | "z" => Self::Altitude,
            "autocontinue" => Self::Autocontinue,
            "hold" | "holds" | "wait" | "delay" => Self::Hold,
            "radius" | "radiusm" | "acceptance" | "acceptanceradius" | "acceptanceradiusm" => Self::Radius,
            "speed" | "speedmps" | "speedms" => Self::Speed,
            _ => Self::Other,
        }
    }
}

const SEPARATORS: [char; 3] = ['\t', ';', ','];

/// Headings of a table, and what separates them.
struct Headings {
    separator: char,
    columns: Vec<Column>,
}

impl Headings {
    fn of(line: &str) -> Option<Self> {
        let separator = *SEPARATORS.iter().max_by_key(|separator| line.matches(**separator).count())?;
        let columns: Vec<Column> = line.split(separator).map(Column::of).collect();
        let has = |column| columns.contains(&column);
        (has(Column::Latitude) && has(Column::Longitude)).then_some(Self { separator, columns })
    }
}

/// Whether a line heads a table of places.
pub(super) fn looks_like_headings(line: &str) -> bool {
    Headings::of(line).is_some()
}

/// The plan of a table.
pub(super) fn parse(text: &str) -> Result<Reading, PlanError> {
    let mut lines = (1..)
        .zip(text.lines())
        .map(|(number, line)| (number, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let headings = lines.next().and_then(|(_, line)| Headings::of(line));
    let Some(headings) = headings else {
        return Err(PlanError::at(Place::Line(1), Fault::Headings));
    };
    let mut table = Table::default();
    for (number, line) in lines {
        table.take(&headings, line).map_err(|fault| PlanError::at(Place::Line(number), fault))?;
    }
    let mut plan = table.plan;
    plan.fence = Fence::from_items(&table.fence).map_err(|fault| PlanError::at(Place::File, fault))?;
    if plan.is_empty() {
        return Err(PlanError::at(Place::File, Fault::Empty));
    }
    Ok(Reading::of(plan))
}

#[derive(Default)]
struct Table {
    plan: Plan,
    fence: Vec<Item>,
    speed_mps: Option<f32>,
}

impl Table {
    fn take(&mut self, headings: &Headings, line: &str) -> Result<(), Fault> {
        let row = Row::parse(headings, line)?;
        let item = row.item()?;
        match row.list.as_str() {
            "home" => {
                let home = Geodetic { latitude_deg: row.coordinates[0], longitude_deg: row.coordinates[1] };
                home.check()?;
                self.plan.mission.home = Some(home);
            }
            "fence" => self.fence.push(item),
            "rally" => self.plan.rally.push(RallyPoint::from_item(&item)?),
            "" | "mission" => {
                if let Some(speed_mps) = row.speed_mps.filter(|_| self.speed_mps != row.speed_mps) {
                    self.speed_mps = Some(speed_mps);
                    self.plan.mission.items.push(Item::change_speed(speed_mps));
                }
                self.plan.mission.items.push(item);
            }
            other => {
                return Err(Fault::Number {
                    column: "the list",
                    found: super::excerpt(other),
                    expected: "home, mission, fence or rally",
                });
            }
        }
        Ok(())
    }
}

fn row_lacks(column: &'static str, expected: &'static str) -> Fault {
    Fault::Number { column, found: String::new(), expected }
}

/// A line of a table.
struct Row {
    list: String,
    command: u16,
    frame: Option<u8>,
    params: [f32; 4],
    coordinates: [f64; 2],
    z: f32,
    autocontinue: bool,
    speed_mps: Option<f32>,
}

impl Row {
    fn parse(headings: &Headings, line: &str) -> Result<Self, Fault> {
        let mut row = Self {
            list: String::new(),
            command: MAV_CMD_NAV_WAYPOINT,
            frame: None,
            params: [0.0; 4],
            coordinates: [f64::NAN; 2],
            z: 0.0,
            autocontinue: true,
            speed_mps: None,
        };
        let decimal_comma = headings.separator != ',';
        for (column, cell) in headings.columns.iter().zip(line.split(headings.separator)) {
            let cell = cell.trim().trim_matches('"').trim();
            if cell.is_empty() {
                continue;
            }
            let cell = if decimal_comma { cell.replace(',', ".") } else { cell.to_owned() };
            row.set(*column, &cell)?;
        }
        // Positions that half are there are in no frame.
        match row.coordinates.map(f64::is_nan) {
            [false, true] => Err(row_lacks("the longitude", "degrees east")),
            [true, false] => Err(row_lacks("the latitude", "degrees north")),
            [true, true] if row.command == MAV_CMD_NAV_WAYPOINT => {
                Err(row_lacks("the latitude", "degrees north"))
            }
            _ => Ok(row),
        }
    }

    fn set(&mut self, column: Column, cell: &str) -> Result<(), Fault> {
        let number = |column: &'static str, expected: &'static str| {
            let fault = || Fault::Number { column, found: super::excerpt(cell), expected };
            cell.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(fault)
        };
        let whole = |column: &'static str, most: u16| {
            let value = number(column, "a whole number")?;
            if value.fract() == 0.0 && (0.0..=f64::from(most)).contains(&value) {
                Ok(value as u16)
            } else {
                let found = super::excerpt(cell);
                Err(Fault::Number { column, found, expected: "a whole number of MAVLink's" })
            }
        };
        let single = |column: &'static str| {
            let fault = || Fault::Number { column, found: super::excerpt(cell), expected: "a number" };
            cell.parse::<f32>().map_err(|_| fault())
        };
        match column {
            Column::List => self.list = cell.to_ascii_lowercase(),
            Column::Command => self.command = whole("the command", u16::MAX)?,
            Column::Frame => self.frame = Some(whole("the frame", 255)? as u8),
            Column::Param(index) => self.params[index] = single("a parameter")?,
            Column::Latitude => self.coordinates[0] = number("the latitude", "degrees north")?,
            Column::Longitude => self.coordinates[1] = number("the longitude", "degrees east")?,
            Column::Altitude => self.z = single("the altitude")?,
            Column::Autocontinue => self.autocontinue = whole("autocontinue", 1)? != 0,
            Column::Hold => self.params[0] = number("the hold time", "seconds")? as f32,
            Column::Radius => self.params[1] = number("the radius", "metres")? as f32,
            Column::Speed => {
                let speed_mps = number("the speed", "m/s")?;
                if speed_mps <= 0.0 {
                    let found = super::excerpt(cell);
                    return Err(Fault::Number { column: "the speed", found, expected: "m/s above 0" });
                }
                self.speed_mps = Some(speed_mps as f32);
            }
            Column::Other => {}
        }
        Ok(())
    }

    fn item(&self) -> Result<Item, Fault> {
        let has_position = self.coordinates.iter().all(|value| value.is_finite());
        let frame = self.frame.unwrap_or(if has_position { super::DEFAULT_FRAME } else { MAV_FRAME_MISSION });
        let coordinates = self.coordinates.map(|value| if value.is_finite() { value } else { 0.0 });
        let [x, y] = check_and_scale(self.command, frame, coordinates)?;
        Ok(Item {
            command: self.command,
            frame,
            params: self.params,
            x,
            y,
            z: self.z,
            autocontinue: self.autocontinue,
        })
    }
}

/// The table of a plan.
pub(super) fn format(plan: &Plan) -> String {
    let mut text = String::from(
        "list,command,frame,param1,param2,param3,param4,latitude,longitude,altitude,autocontinue\n",
    );
    if let Some(home) = plan.mission.home {
        let coordinates = [home.latitude_deg, home.longitude_deg];
        write_row(&mut text, "home", &Item::home(plan.mission.home), coordinates);
    }
    let lists = [
        ("mission", plan.mission.items.clone()),
        ("fence", plan.fence.to_items()),
        ("rally", plan.rally.iter().map(|rally| rally.to_item()).collect()),
    ];
    for (list, items) in lists {
        for item in items {
            write_row(&mut text, list, &item, item.coordinates());
        }
    }
    text
}

fn write_row(text: &mut String, list: &str, item: &Item, [x, y]: [f64; 2]) {
    let [p1, p2, p3, p4] = item.params;
    let autocontinue = u8::from(item.autocontinue);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{list},{},{},{p1},{p2},{p3},{p4},{x:.8},{y:.8},{},{autocontinue}",
        item.command, item.frame, item.z
    );
}

impl Item {
    /// A change of the speed over ground, m/s (MAV_CMD_DO_CHANGE_SPEED).
    pub fn change_speed(speed_mps: f32) -> Self {
        Self {
            command: MAV_CMD_DO_CHANGE_SPEED,
            frame: MAV_FRAME_MISSION,
            params: [1.0, speed_mps, -1.0, 0.0],
            x: 0,
            y: 0,
            z: 0.0,
            autocontinue: true,
        }
    }
}
