//! QGroundControl's `.plan` files (JSON): mission, fence and rally points; and its older `.mission` files.
//!
//! Source: <https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html>.

use std::collections::HashMap;

use helmlink_wire::enums::{
    MAV_CMD_DO_JUMP, MAV_CMD_NAV_WAYPOINT, MAV_FRAME_GLOBAL_RELATIVE_ALT, MAV_FRAME_MISSION,
};
use serde::Deserialize;
use serde_json::{Value, json};

use super::error::{Fault, Place, PlanError};
use super::item::check_and_scale;
use super::{Area, Fence, Item, Mission, Outline, Plan, RallyPoint, Reading, decimal};
use crate::geodesy::Geodetic;

/// ArduPilot, in MAVLink's MAV_AUTOPILOT, and a boat in its MAV_TYPE.
const FIRMWARE: u8 = 3;
const VEHICLE: u8 = 11;

/// Whether a JSON text is GeoJSON rather than a plan: by the first of the words that only one of them has.
pub(super) fn looks_like_geojson(text: &str) -> bool {
    let first = |words: &[&str]| words.iter().filter_map(|word| text.find(word)).min();
    let geojson = first(&["\"FeatureCollection\"", "\"Feature\"", "\"geometry\"", "\"coordinates\""]);
    let plan = first(&[
        "\"fileType\"",
        "\"mission\"",
        "\"plannedHomePosition\"",
        "\"SimpleItem\"",
        "\"missionItem\"",
    ]);
    geojson.is_some_and(|at| plan.is_none_or(|other| at < other))
}

/// The plan of a file.
pub(super) fn parse(text: &str) -> Result<Reading, PlanError> {
    let at_file = |fault| PlanError::at(Place::File, fault);
    let mut file: Value = from_json(serde_json::from_str(text)).map_err(at_file)?;
    // The older files are what is now the part "mission".
    let mission = match file.get_mut("mission").map(Value::take) {
        Some(mission) => mission,
        None => file.clone(),
    };
    let mission: MissionPart = from_json(serde_json::from_value(mission)).map_err(at_file)?;
    let mut plan = Plan { mission: read_mission(mission)?, ..Plan::default() };
    if let Some(fence) = file.get_mut("geoFence").map(Value::take) {
        plan.fence = read_fence(fence)?;
    }
    for (number, point) in (1..).zip(list_at(&file, "/rallyPoints/points")) {
        let at = |fault| PlanError::at(Place::Rally(number), fault);
        plan.rally.push(rally_point(point).map_err(at)?);
    }
    if plan.is_empty() {
        return Err(at_file(Fault::Empty));
    }
    Ok(Reading::of(plan))
}

fn read_mission(part: MissionPart) -> Result<Mission, PlanError> {
    let home = part.planned_home_position.as_ref().and_then(home_position);
    let mut items = Vec::with_capacity(part.items.len());
    // What the file calls each item, and which number it gets: a jump speaks of the former.
    let mut numbers = HashMap::new();
    let mut take = |value: Value, place: Place| {
        if let Some(id) = value.get("doJumpId").and_then(Value::as_u64) {
            numbers.insert(id, items.len() + 1);
        }
        items.push(simple_item(value).map_err(|fault| PlanError::at(place, fault))?);
        Ok(())
    };
    for (number, value) in (1..).zip(part.items) {
        let at = |fault| PlanError::at(Place::Item(number), fault);
        match ItemType::of(&value).map_err(at)? {
            ItemType::Simple => take(value, Place::Item(number))?,
            ItemType::Complex => {
                for (inner, value) in (1..).zip(parts_of(value).map_err(at)?) {
                    take(value, Place::Within(number, inner))?;
                }
            }
        }
    }
    for item in items.iter_mut().filter(|item: &&mut Item| item.command == MAV_CMD_DO_JUMP) {
        if let Some(number) = numbers.get(&(item.params[0] as u64)) {
            item.params[0] = *number as f32;
        }
    }
    Ok(Mission { home, items })
}

fn read_fence(part: Value) -> Result<Fence, PlanError> {
    let mut fence = Fence::default();
    let inclusion = |area: &Value| area.get("inclusion").and_then(Value::as_bool).unwrap_or(true);
    for polygon in list_at(&part, "/polygons") {
        let at = |fault| PlanError::at(Place::Area(fence.areas.len() + 1), fault);
        let corners =
            list_at(polygon, "/polygon").iter().map(|corner| position(corner).map(|(place, _)| place));
        let corners: Vec<Geodetic> = corners.collect::<Result<_, _>>().map_err(at)?;
        let outline = Outline::polygon(corners).map_err(at)?;
        fence.areas.push(Area { inclusion: inclusion(polygon), outline });
    }
    for circle in list_at(&part, "/circles") {
        let at = |fault| PlanError::at(Place::Area(fence.areas.len() + 1), fault);
        let centre = circle.pointer("/circle/center").unwrap_or(&Value::Null);
        let radius_m = circle.pointer("/circle/radius").and_then(Value::as_f64).unwrap_or(f64::NAN);
        let (centre, _) = position(centre).map_err(at)?;
        let outline = Outline::circle(centre, radius_m as f32).map_err(at)?;
        fence.areas.push(Area { inclusion: inclusion(circle), outline });
    }
    if let Some(point) = part.get("breachReturn") {
        fence.return_point = Some(rally_point(point).map_err(|fault| PlanError::at(Place::File, fault))?);
    }
    Ok(fence)
}

fn rally_point(value: &Value) -> Result<RallyPoint, Fault> {
    position(value).map(|(position, altitude_m)| RallyPoint { position, altitude_m })
}

/// Latitude, longitude and perhaps altitude in a list.
fn position(value: &Value) -> Result<(Geodetic, f32), Fault> {
    let number = |index: usize| value.get(index).and_then(Value::as_f64);
    let (Some(latitude_deg), Some(longitude_deg)) = (number(0), number(1)) else {
        return Err(Fault::Json(format!("\"{}\" is no position", super::excerpt(&value.to_string()))));
    };
    let place = Geodetic { latitude_deg, longitude_deg };
    place.check()?;
    Ok((place, number(2).unwrap_or_default() as f32))
}

fn list_at<'a>(value: &'a Value, pointer: &str) -> &'a [Value] {
    value.pointer(pointer).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

#[derive(Deserialize)]
struct MissionPart {
    items: Vec<Value>,
    #[serde(rename = "plannedHomePosition")]
    planned_home_position: Option<Value>,
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
            // The older files' word.
            "SimpleItem" | "missionItem" => Ok(Self::Simple),
            "ComplexItem" => Ok(Self::Complex),
            other => Err(Fault::ItemType(super::excerpt(other))),
        }
    }
}

/// The simple items that a survey or corridor scan was made into when it was saved; where there are none, the places of
/// its transects.
fn parts_of(mut complex: Value) -> Result<Vec<Value>, Fault> {
    let part = |complex: &mut Value, name: &str| match complex.pointer_mut(name).map(Value::take) {
        Some(Value::Array(parts)) if !parts.is_empty() => Some(parts),
        _ => None,
    };
    if let Some(items) = part(&mut complex, "/TransectStyleComplexItem/Items") {
        return Ok(items);
    }
    if let Some(points) = part(&mut complex, "/TransectStyleComplexItem/VisualTransectPoints") {
        return points.iter().map(transect_point).collect();
    }
    Err(match text_at(&complex, "complexItemType") {
        "StructureScan" => Fault::NotForBoats("a structure scan flies around a building at several heights"),
        "fwLandingPattern" | "vtolLandingPattern" => Fault::NotForBoats("a landing pattern is for aircraft"),
        other => Fault::ComplexItem(super::excerpt(other)),
    })
}

/// A corner of a transect as a waypoint.
fn transect_point(point: &Value) -> Result<Value, Fault> {
    let (place, _) = position(point)?;
    Ok(json!({
        "command": MAV_CMD_NAV_WAYPOINT,
        "frame": MAV_FRAME_GLOBAL_RELATIVE_ALT,
        "params": [0, 0, 0, Value::Null, place.latitude_deg, place.longitude_deg, 0],
    }))
}

/// The older files give the parameters one by one, and the position in a list of its own.
fn with_params(mut value: Value) -> Value {
    if value.get("params").is_none()
        && let Some(Value::Array(coordinates)) = value.get_mut("coordinate").map(Value::take)
    {
        let mut params: Vec<Value> = ["param1", "param2", "param3", "param4"]
            .iter()
            .map(|name| value.get(name).cloned().unwrap_or(Value::Null))
            .collect();
        params.extend(coordinates);
        value["params"] = Value::Array(params);
    }
    value
}

fn simple_item(value: Value) -> Result<Item, Fault> {
    let value = with_params(value);
    if let Some(count) =
        value.get("params").and_then(Value::as_array).map(Vec::len).filter(|count| *count != 7)
    {
        return Err(Fault::Json(format!("\"params\" has {count} values, expected 7")));
    }
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
fn home_position(value: &Value) -> Option<Geodetic> {
    // The older files have an item there.
    let coordinates = value.get("coordinate").unwrap_or(value);
    position(coordinates).ok().map(|(home, _)| home)
}

fn text_at<'a>(value: &'a Value, key: &str) -> &'a str {
    value.get(key).and_then(Value::as_str).unwrap_or("(none)")
}

fn from_json<T>(result: Result<T, serde_json::Error>) -> Result<T, Fault> {
    result.map_err(|error| Fault::Json(error.to_string()))
}

/// The text of a plan.
pub(super) fn format(plan: &Plan) -> Result<String, PlanError> {
    let home = plan.mission.home.map(|home| json!([home.latitude_deg, home.longitude_deg, 0.0]));
    let items: Vec<Value> = (1..).zip(&plan.mission.items).map(|(id, item)| item_value(id, item)).collect();
    let point = |point: &RallyPoint| {
        let altitude = decimal::widened(if point.altitude_m.is_finite() { point.altitude_m } else { 0.0 });
        json!([point.position.latitude_deg, point.position.longitude_deg, altitude])
    };
    let rally: Vec<Value> = plan.rally.iter().map(point).collect();
    let mut file = json!({
        "fileType": "Plan",
        "groundStation": "Helmlink",
        "version": 1,
        "mission": {
            "cruiseSpeed": 2,
            "firmwareType": FIRMWARE,
            "hoverSpeed": 2,
            "items": items,
            "vehicleType": VEHICLE,
            "version": 2,
        },
        "geoFence": fence_value(&plan.fence),
        "rallyPoints": { "points": rally, "version": 2 },
    });
    // QGroundControl insists on a planned home; zeroes are read as none.
    file["mission"]["plannedHomePosition"] = home.unwrap_or_else(|| json!([0.0, 0.0, 0.0]));
    if let Some(place) = &plan.fence.return_point {
        file["geoFence"]["breachReturn"] = point(place);
    }
    let text = serde_json::to_string_pretty(&file)
        .map_err(|error| PlanError::at(Place::File, Fault::Json(error.to_string())))?;
    Ok(text + "\n")
}

fn item_value(id: usize, item: &Item) -> Value {
    let [x, y] = item.coordinates();
    let parameter =
        |value: f32| if value.is_finite() { Value::from(decimal::widened(value)) } else { Value::Null };
    let mut params: Vec<Value> = item.params.iter().map(|value| parameter(*value)).collect();
    params.extend([json!(x), json!(y), parameter(item.z)]);
    let mut value = json!({
        "autoContinue": item.autocontinue,
        "command": item.command,
        "doJumpId": id,
        "frame": item.frame,
        "params": params,
        "type": "SimpleItem",
    });
    if item.frame != MAV_FRAME_MISSION {
        value["Altitude"] = parameter(item.z);
        value["AltitudeMode"] = json!(1);
        value["AMSLAltAboveTerrain"] = Value::Null;
    }
    value
}

fn fence_value(fence: &Fence) -> Value {
    let (mut circles, mut polygons) = (Vec::new(), Vec::new());
    for area in &fence.areas {
        match &area.outline {
            Outline::Polygon(corners) => {
                let corners: Vec<[f64; 2]> =
                    corners.iter().map(|corner| [corner.latitude_deg, corner.longitude_deg]).collect();
                polygons.push(json!({ "inclusion": area.inclusion, "polygon": corners, "version": 1 }));
            }
            Outline::Circle { centre, radius_m } => circles.push(json!({
                "circle": {
                    "center": [centre.latitude_deg, centre.longitude_deg],
                    "radius": decimal::widened(*radius_m),
                },
                "inclusion": area.inclusion,
                "version": 1,
            })),
        }
    }
    json!({ "circles": circles, "polygons": polygons, "version": 2 })
}

#[cfg(test)]
mod tests;
