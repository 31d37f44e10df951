//! QGroundControl's `.plan` files (JSON), as far as they are missions.
//!
//! Source: <https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html>. Fences and
//! rally points in the file are left alone.

use serde::Deserialize;
use serde_json::Value;

use super::error::{Fault, Place, PlanError};
use super::item::check_and_scale;
use super::{Item, Mission};
use crate::geodesy::Geodetic;

/// The mission of a plan file.
pub(super) fn parse(text: &str) -> Result<Mission, PlanError> {
    let file: PlanFile =
        from_json(serde_json::from_str(text)).map_err(|fault| PlanError::at(Place::File, fault))?;
    let mut items = Vec::with_capacity(file.mission.items.len());
    for (number, value) in (1..).zip(file.mission.items) {
        match ItemType::of(&value).map_err(|fault| PlanError::at(Place::Item(number), fault))? {
            ItemType::Simple => {
                items.push(simple_item(value).map_err(|fault| PlanError::at(Place::Item(number), fault))?);
            }
            ItemType::Complex => {
                let parts = parts_of(value).map_err(|fault| PlanError::at(Place::Item(number), fault))?;
                for (inner, part) in (1..).zip(parts) {
                    let place = Place::Within(number, inner);
                    items.push(simple_item(part).map_err(|fault| PlanError::at(place, fault))?);
                }
            }
        }
    }
    if items.is_empty() {
        return Err(PlanError::at(Place::File, Fault::Empty));
    }
    let home = file.mission.planned_home_position.as_deref().and_then(home_position);
    Ok(Mission { home, items })
}

#[derive(Deserialize)]
struct PlanFile {
    mission: MissionPart,
}

#[derive(Deserialize)]
struct MissionPart {
    items: Vec<Value>,
    #[serde(rename = "plannedHomePosition")]
    planned_home_position: Option<Vec<Option<f64>>>,
}

#[derive(Deserialize)]
struct SimpleItem {
    command: u16,
    frame: u8,
    /// Seven of them; `null` is NaN.
    params: [Option<f64>; 7],
    #[serde(rename = "autoContinue", default = "yes")]
    auto_continue: bool,
}

fn yes() -> bool {
    true
}

enum ItemType {
    Simple,
    Complex,
}

impl ItemType {
    fn of(value: &Value) -> Result<Self, Fault> {
        match text_at(value, "type") {
            "SimpleItem" => Ok(Self::Simple),
            "ComplexItem" => Ok(Self::Complex),
            other => Err(Fault::ItemType(super::excerpt(other))),
        }
    }
}

/// The simple items that a survey or corridor scan was made into when it was saved.
fn parts_of(mut complex: Value) -> Result<Vec<Value>, Fault> {
    let stored = complex.pointer_mut("/TransectStyleComplexItem/Items").map(Value::take);
    match stored {
        Some(Value::Array(parts)) if !parts.is_empty() => Ok(parts),
        _ => Err(Fault::ComplexItem(super::excerpt(text_at(&complex, "complexItemType")))),
    }
}

fn simple_item(value: Value) -> Result<Item, Fault> {
    let item: SimpleItem = from_json(serde_json::from_value(value))?;
    let [p1, p2, p3, p4, latitude_deg, longitude_deg, altitude_m] = item.params;
    // A command without a position has no use for parameters 5 and 6 either.
    let coordinates = [latitude_deg.unwrap_or_default(), longitude_deg.unwrap_or_default()];
    let [x, y] = check_and_scale(item.command, item.frame, coordinates)?;
    Ok(Item {
        command: item.command,
        frame: item.frame,
        params: [parameter(p1)?, parameter(p2)?, parameter(p3)?, parameter(p4)?],
        x,
        y,
        z: parameter(altitude_m.or(Some(0.0)))?,
        autocontinue: item.auto_continue,
    })
}

/// A parameter as MAVLink carries it, NaN for `null`.
fn parameter(value: Option<f64>) -> Result<f32, Fault> {
    let narrow = value.map_or(f32::NAN, |value| value as f32);
    if narrow.is_infinite() {
        let found = super::excerpt(&value.unwrap_or_default().to_string());
        return Err(Fault::Number {
            column: "a parameter",
            found,
            expected: "a number of the size MAVLink carries",
        });
    }
    Ok(narrow)
}

/// Home, unless it is missing or no position: a planned home is only where the map was when planning began.
fn home_position(coordinates: &[Option<f64>]) -> Option<Geodetic> {
    let &[Some(latitude_deg), Some(longitude_deg), ..] = coordinates else { return None };
    Some(Geodetic { latitude_deg, longitude_deg }).filter(|home| home.is_valid())
}

fn text_at<'a>(value: &'a Value, key: &str) -> &'a str {
    value.get(key).and_then(Value::as_str).unwrap_or("(none)")
}

fn from_json<T>(result: Result<T, serde_json::Error>) -> Result<T, Fault> {
    result.map_err(|error| Fault::Json(error.to_string()))
}

#[cfg(test)]
mod tests;
