//! The plain-text waypoint format, `QGC WPL 110`.
//!
//! One item a line, twelve columns separated by tabs or spaces: index, current, frame, command, four
//! parameters, latitude, longitude, altitude, autocontinue. Item 0 is home, unless it is no waypoint or the
//! first line has another number. In version 120, an older habit of QGroundControl, there is no home and item 0
//! is the first to be done. MAVProxy keeps fences and rally points in files of this format, too, without home.
//! Source: <https://mavlink.io/en/file_formats/>.

use std::fmt::Write as _;

use helmlink_wire::enums::{MAV_CMD_DO_JUMP, MAV_CMD_NAV_RALLY_POINT, MAV_CMD_NAV_WAYPOINT};

use super::error::{Fault, Place, PlanError};
use super::fence::is_fence_item;
use super::item::check_and_scale;
use super::{CommandName, Fence, Item, Mission, Plan, RallyPoint, Reading};
use crate::geodesy::Geodetic;

/// The first words of every version of the format.
pub(super) const MAGIC: &str = "QGC WPL";

/// The plan in a text of this format.
///
/// Blank lines and lines that start with `#` are skipped. Integers may be written as `3.000000`.
pub(super) fn parse(text: &str) -> Result<Reading, PlanError> {
    let mut lines = (1..)
        .zip(text.lines())
        .map(|(number, line)| (number, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let (number, header) = lines.next().unwrap_or((1, ""));
    let may_have_home = match header.strip_prefix(MAGIC).map(str::trim) {
        Some("110") => true,
        Some("120") => false,
        _ => return Err(PlanError::at(Place::Line(number), Fault::Version(super::excerpt(header)))),
    };

    let mut lists = Lists::default();
    let mut first_index = 0;
    let mut notes = Vec::new();
    for (count, (number, line)) in lines.enumerate() {
        let here = |fault| PlanError::at(Place::Line(number), fault);
        let row = Row::parse(line).map_err(here)?;
        if count == 0 {
            // A file that begins with item 1 has left home out.
            first_index = usize::from(may_have_home && row.index == 1);
            if may_have_home && first_index == 0 {
                if row.command == MAV_CMD_NAV_WAYPOINT {
                    lists.home = row.home().map_err(here)?;
                    continue;
                }
                notes.extend(lists.without_home(&row));
            }
        }
        let expected = first_index + count;
        if usize::from(row.index) != expected {
            return Err(here(Fault::Index { expected, found: row.index }));
        }
        lists.take(&row).map_err(here)?;
    }
    // Items are numbered from 1 here: where the file has no home, its jumps count from 0.
    if lists.shift_jumps || !may_have_home {
        for item in lists.mission.iter_mut().filter(|item| item.command == MAV_CMD_DO_JUMP) {
            item.params[0] += 1.0;
        }
    }
    let plan = lists.finish()?;
    Ok(Reading { notes, ..Reading::of(plan) })
}

/// What the lines of a file belong to.
#[derive(Default)]
struct Lists {
    home: Option<Geodetic>,
    mission: Vec<Item>,
    fence: Vec<Item>,
    rally: Vec<RallyPoint>,
    shift_jumps: bool,
}

impl Lists {
    /// The first line is no home; what there is to say about that.
    fn without_home(&mut self, row: &Row) -> Option<String> {
        let is_mission = !is_fence_item(row.command) && row.command != MAV_CMD_NAV_RALLY_POINT;
        self.shift_jumps = is_mission;
        is_mission.then(|| {
            format!("the first item is {}, not home: the file has no home", CommandName(row.command))
        })
    }

    fn take(&mut self, row: &Row) -> Result<(), Fault> {
        let item = row.item()?;
        if is_fence_item(row.command) {
            self.fence.push(item);
        } else if row.command == MAV_CMD_NAV_RALLY_POINT {
            self.rally.push(RallyPoint::from_item(&item)?);
        } else {
            self.mission.push(item);
        }
        Ok(())
    }

    fn finish(self) -> Result<Plan, PlanError> {
        let at_file = |fault| PlanError::at(Place::File, fault);
        let fence = Fence::from_items(&self.fence).map_err(at_file)?;
        let mission = Mission { home: self.home, items: self.mission };
        let plan = Plan { mission, fence, rally: self.rally };
        if plan.is_empty() { Err(at_file(Fault::Empty)) } else { Ok(plan) }
    }
}

/// The text of a plan: its mission, or where there is none its fence or else its rally points, as MAVProxy
/// keeps those.
pub(super) fn format_plan(plan: &Plan) -> String {
    let alone = if !plan.mission.items.is_empty() {
        return format(&plan.mission);
    } else if !plan.fence.is_empty() {
        plan.fence.to_items()
    } else {
        plan.rally.iter().map(|rally| rally.to_item()).collect()
    };
    let mut text = format!("{MAGIC} 110\n");
    for (index, item) in alone.iter().enumerate() {
        write_line(&mut text, index, item, item.coordinates());
    }
    text
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
