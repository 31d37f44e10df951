//! The plain-text waypoint format, `QGC WPL 110`.
//!
//! One item a line, twelve columns separated by tabs or spaces: index, current, frame, command, four
//! parameters, latitude, longitude, altitude, autocontinue. Item 0 is home. In version 120, an older
//! habit of QGroundControl, there is no home and item 0 is the first to be done.
//! Source: <https://mavlink.io/en/file_formats/>.

use std::fmt::Write as _;

use helmlink_wire::enums::MAV_CMD_NAV_WAYPOINT;

use super::error::{Fault, Place, PlanError};
use super::item::check_and_scale;
use super::{CommandName, Item, Mission};
use crate::geodesy::Geodetic;

/// The first words of every version of the format.
pub(super) const MAGIC: &str = "QGC WPL";

/// The mission in a text of this format.
///
/// Blank lines and lines that start with `#` are skipped. Integers may be written as `3.000000`.
pub(super) fn parse(text: &str) -> Result<Mission, PlanError> {
    let mut lines = (1..)
        .zip(text.lines())
        .map(|(number, line)| (number, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let (number, header) = lines.next().unwrap_or((1, ""));
    let has_home = match header.strip_prefix(MAGIC).map(str::trim) {
        Some("110") => true,
        Some("120") => false,
        _ => return Err(PlanError::at(Place::Line(number), Fault::Version(super::excerpt(header)))),
    };

    let mut mission = Mission::default();
    for (index, (number, line)) in lines.enumerate() {
        let here = |fault| PlanError::at(Place::Line(number), fault);
        let row = Row::parse(line).map_err(here)?;
        if usize::from(row.index) != index {
            return Err(here(Fault::Index { expected: index, found: row.index }));
        }
        if index == 0 && has_home {
            mission.home = row.home().map_err(here)?;
        } else {
            mission.items.push(row.item().map_err(here)?);
        }
    }
    if mission.items.is_empty() {
        return Err(PlanError::at(Place::File, Fault::Empty));
    }
    Ok(mission)
}

/// The text of a mission in version 110. An unknown home is written as zeroes, as ArduPilot's tools do.
pub(super) fn format(mission: &Mission) -> String {
    let mut text = format!("{MAGIC} 110\n");
    let home = mission.home.unwrap_or_default();
    write_line(&mut text, 0, &Item::home(mission.home), [home.latitude_deg, home.longitude_deg]);
    for (index, item) in (1..).zip(&mission.items) {
        write_line(&mut text, index, item, item.coordinates());
    }
    text
}

fn write_line(text: &mut String, index: usize, item: &Item, coordinates: [f64; 2]) {
    let [p1, p2, p3, p4] = item.params;
    let [x, y] = coordinates;
    let current = u8::from(index == 0);
    let autocontinue = u8::from(item.autocontinue);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{index}\t{current}\t{}\t{}\t{p1}\t{p2}\t{p3}\t{p4}\t{x:.8}\t{y:.8}\t{}\t{autocontinue}",
        item.frame, item.command, item.z,
    );
}

/// A line, column by column.
struct Row {
    index: u16,
    frame: u8,
    command: u16,
    params: [f32; 4],
    coordinates: [f64; 2],
    altitude_m: f32,
    autocontinue: bool,
}

impl Row {
    fn parse(line: &str) -> Result<Self, Fault> {
        let columns: Vec<&str> = line.split_whitespace().collect();
        let &[index, current, frame, command, p1, p2, p3, p4, latitude, longitude, altitude, autocontinue] =
            columns.as_slice()
        else {
            return Err(Fault::Columns(columns.len()));
        };
        integer::<u8>("current", current, "0 or 1")?;
        Ok(Self {
            index: integer("index", index, "a whole number from 0 to 65535")?,
            frame: integer("frame", frame, "a MAV_FRAME, a whole number from 0 to 255")?,
            command: integer("command", command, "a MAV_CMD, a whole number from 0 to 65535")?,
            params: [
                parameter("parameter 1", p1)?,
                parameter("parameter 2", p2)?,
                parameter("parameter 3", p3)?,
                parameter("parameter 4", p4)?,
            ],
            coordinates: [
                number("latitude", latitude, "degrees north")?,
                number("longitude", longitude, "degrees east")?,
            ],
            altitude_m: number("altitude", altitude, "metres")? as f32,
            autocontinue: integer::<u8>("autocontinue", autocontinue, "0 or 1")? != 0,
        })
    }

    fn home(&self) -> Result<Option<Geodetic>, Fault> {
        if self.command != MAV_CMD_NAV_WAYPOINT {
            return Err(Fault::NotHome(CommandName(self.command)));
        }
        let [latitude_deg, longitude_deg] = self.coordinates;
        let home = Geodetic { latitude_deg, longitude_deg };
        // Zeroes: the file was saved before the boat knew where it was.
        if home == Geodetic::default() {
            return Ok(None);
        }
        home.check()?;
        Ok(Some(home))
    }

    fn item(&self) -> Result<Item, Fault> {
        let [x, y] = check_and_scale(self.command, self.frame, self.coordinates)?;
        Ok(Item {
            command: self.command,
            frame: self.frame,
            params: self.params,
            x,
            y,
            z: self.altitude_m,
            autocontinue: self.autocontinue,
        })
    }
}

/// A whole number, perhaps written with a fraction of zero.
fn integer<T: TryFrom<i64>>(column: &'static str, found: &str, expected: &'static str) -> Result<T, Fault> {
    let fault = || Fault::Number { column, found: super::excerpt(found), expected };
    let value: f64 = found.parse().map_err(|_| fault())?;
    if value.fract() != 0.0 || value.abs() > 1e9 {
        return Err(fault());
    }
    T::try_from(value as i64).map_err(|_| fault())
}

/// A finite number.
fn number(column: &'static str, found: &str, expected: &'static str) -> Result<f64, Fault> {
    let fault = || Fault::Number { column, found: super::excerpt(found), expected };
    found.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(fault)
}

/// A parameter: a number, or NaN where it is left to the vehicle.
fn parameter(column: &'static str, found: &str) -> Result<f32, Fault> {
    let fault = || Fault::Number {
        column,
        found: super::excerpt(found),
        expected: "a number, or nan for \"as you like\"",
    };
    found.parse().ok().filter(|value: &f32| !value.is_infinite()).ok_or_else(fault)
}

#[cfg(test)]
mod tests;
