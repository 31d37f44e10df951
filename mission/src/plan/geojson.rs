//! GeoJSON (RFC 7946).
//!
//! A `FeatureCollection` written here holds one feature an item, with the item's fields as properties, so that
//! nothing is lost; maps draw it as it is. Any other GeoJSON is read as a path: its lines joined, or else its
//! points in their order; polygons whose property "fence" says "inclusion" or "exclusion" are the fence.

use serde_json::{Map, Value, json};

use super::error::{Fault, Place, PlanError};
use super::item::check_and_scale;
use super::{Area, Item, Outline, Plan, RallyPoint, Reading, decimal};
use crate::geodesy::Geodetic;

/// What is found besides features of our own.
#[derive(Default)]
struct Foreign {
    lines: Vec<Vec<(Geodetic, f32)>>,
    points: Vec<(Geodetic, f32)>,
    polygons: usize,
}

/// The plan of a GeoJSON text.
pub(super) fn parse(text: &str) -> Result<Reading, PlanError> {
    let value: Value = serde_json::from_str(text)
        .map_err(|error| PlanError::at(Place::File, Fault::GeoJson(error.to_string())))?;
    let mut plan = Plan::default();
    let mut foreign = Foreign::default();
    let lone = std::slice::from_ref(&value);
    let features = match text_at(&value, "type") {
        "FeatureCollection" => value.get("features").and_then(Value::as_array).map_or(&[][..], Vec::as_slice),
        _ => lone,
    };
    for (number, feature) in (1..).zip(features) {
        read_feature(feature, &mut plan, &mut foreign)
            .map_err(|fault| PlanError::at(Place::Feature(number), fault))?;
    }
    let notes = add_foreign(&mut plan, foreign);
    if plan.is_empty() {
        return Err(PlanError::at(Place::File, Fault::Empty));
    }
    Ok(Reading { notes, ..Reading::of(plan) })
}

fn add_foreign(plan: &mut Plan, foreign: Foreign) -> Vec<String> {
    let mut notes = Vec::new();
    if foreign.polygons > 0 {
        notes.push(format!(
            "{} polygons were left out: a polygon is part of the fence only where its property \"fence\" is \
             \"inclusion\" or \"exclusion\"",
            foreign.polygons
        ));
    }
    let loose = foreign.points.len() + foreign.lines.len();
    if !plan.mission.items.is_empty() {
        if loose > 0 {
            notes.push(format!("{loose} lines and points without a command were left out"));
        }
        return notes;
    }
    let points = if foreign.lines.is_empty() {
        foreign.points
    } else {
        if foreign.lines.len() > 1 {
            notes.push(format!("the {} lines were joined in their order", foreign.lines.len()));
        }
        if !foreign.points.is_empty() {
            notes.push(format!("{} single points were left out: the line was taken", foreign.points.len()));
        }
        foreign.lines.concat()
    };
    plan.mission.items =
        points.into_iter().map(|(position, z)| Item { z, ..Item::waypoint(position) }).collect();
    notes
}

fn read_feature(feature: &Value, plan: &mut Plan, foreign: &mut Foreign) -> Result<(), Fault> {
    let (geometry, properties) = match text_at(feature, "type") {
        "Feature" => (feature.get("geometry").unwrap_or(&Value::Null), feature.get("properties")),
        _ => (feature, None),
    };
    let no_properties = Map::new();
    let properties = properties.and_then(Value::as_object).unwrap_or(&no_properties);
    if properties.contains_key("command") {
        plan.mission.items.push(item(geometry, properties)?);
        return Ok(());
    }
    let role = properties.get("role").and_then(Value::as_str).unwrap_or("");
    let fence = properties.get("fence").and_then(Value::as_str).unwrap_or("");
    let coordinates = geometry.get("coordinates").unwrap_or(&Value::Null);
    match (text_at(geometry, "type"), role, fence) {
        ("Point", "home", _) => plan.mission.home = Some(place(coordinates)?.0),
        ("Point", "rally", _) => {
            let (position, altitude_m) = place(coordinates)?;
            plan.rally.push(RallyPoint { position, altitude_m });
        }
        ("Point", "fence return", _) => {
            let (position, altitude_m) = place(coordinates)?;
            plan.fence.return_point = Some(RallyPoint { position, altitude_m });
        }
        ("Point", _, "inclusion" | "exclusion") => {
            let radius_m = number(properties.get("radius_m"), "radius_m", "metres")? as f32;
            let outline = Outline::circle(place(coordinates)?.0, radius_m)?;
            plan.fence.areas.push(Area { inclusion: fence == "inclusion", outline });
        }
        ("Polygon", _, "inclusion" | "exclusion") => {
            let ring = coordinates.get(0).unwrap_or(&Value::Null);
            let corners = places(ring)?.into_iter().map(|(corner, _)| corner).collect();
            plan.fence
                .areas
                .push(Area { inclusion: fence == "inclusion", outline: Outline::polygon(corners)? });
        }
        // The line through the items, drawn for maps.
        ("LineString", "path", _) => {}
        ("Point", ..) => foreign.points.push(place(coordinates)?),
        ("MultiPoint", ..) => foreign.points.extend(places(coordinates)?),
        ("LineString", ..) => foreign.lines.push(places(coordinates)?),
        ("MultiLineString", ..) => {
            for line in list(coordinates)? {
                foreign.lines.push(places(line)?);
            }
        }
        ("Polygon" | "MultiPolygon", ..) => foreign.polygons += 1,
        ("GeometryCollection", ..) => {
            for part in list(geometry.get("geometries").unwrap_or(&Value::Null))? {
                // Parts of a collection cannot be collections again, so this goes no deeper.
                if text_at(part, "type") != "GeometryCollection" {
                    read_feature(part, plan, foreign)?;
                }
            }
        }
        _ if geometry.is_null() => {}
        (other, ..) => {
            return Err(Fault::GeoJson(format!("there is no geometry called \"{}\"", super::excerpt(other))));
        }
    }
    Ok(())
}

fn item(geometry: &Value, properties: &Map<String, Value>) -> Result<Item, Fault> {
    let whole = |key: &'static str, most: f64| {
        let value = number(properties.get(key), key, "a whole number")?;
        if value.fract() != 0.0 || !(0.0..=most).contains(&value) {
            let found = value.to_string();
            return Err(Fault::Number { column: key, found, expected: "a whole number of MAVLink's" });
        }
        Ok(value)
    };
    let command = whole("command", f64::from(u16::MAX))? as u16;
    let frame = match properties.get("frame") {
        Some(_) => whole("frame", f64::from(u8::MAX))? as u8,
        None => super::DEFAULT_FRAME,
    };
    let (coordinates, z) = match (geometry.get("coordinates"), properties.get("x")) {
        (Some(coordinates), None) => {
            let (position, altitude_m) = place_unchecked(coordinates)?;
            ([position.latitude_deg, position.longitude_deg], altitude_m)
        }
        _ => {
            let optional = |key: &'static str| match properties.get(key) {
                None => Ok(0.0),
                value => number(value, key, "a number"),
            };
            ([optional("x")?, optional("y")?], optional("z")? as f32)
        }
    };
    let params = match properties.get("params").and_then(Value::as_array) {
        None => [0.0; 4],
        Some(list) => {
            let mut params = [0.0; 4];
            for (param, value) in params.iter_mut().zip(list) {
                *param = decimal::from_json(value)?;
            }
            params
        }
    };
    let z = properties.get("altitude").map_or(Ok(z), decimal::from_json)?;
    let [x, y] = check_and_scale(command, frame, coordinates)?;
    let autocontinue = properties.get("autocontinue").and_then(Value::as_bool).unwrap_or(true);
    Ok(Item { command, frame, params, x, y, z, autocontinue })
}

fn place(value: &Value) -> Result<(Geodetic, f32), Fault> {
    let (position, altitude_m) = place_unchecked(value)?;
    position.check()?;
    Ok((position, altitude_m))
}

fn place_unchecked(value: &Value) -> Result<(Geodetic, f32), Fault> {
    let numbers = list(value)?;
    if numbers.len() < 2 {
        let found = super::excerpt(&value.to_string());
        return Err(Fault::Number { column: "a place", found, expected: "[longitude, latitude]" });
    }
    let longitude_deg = number(numbers.first(), "longitude", "degrees east")?;
    let latitude_deg = number(numbers.get(1), "latitude", "degrees north")?;
    let altitude_m = match numbers.get(2) {
        None | Some(Value::Null) => 0.0,
        value => number(value, "altitude", "metres")? as f32,
    };
    Ok((Geodetic { latitude_deg, longitude_deg }, altitude_m))
}

fn places(value: &Value) -> Result<Vec<(Geodetic, f32)>, Fault> {
    list(value)?.iter().map(place).collect()
}

fn list(value: &Value) -> Result<&Vec<Value>, Fault> {
    value.as_array().ok_or_else(|| Fault::GeoJson("coordinates are not a list".to_owned()))
}

fn number(value: Option<&Value>, column: &'static str, expected: &'static str) -> Result<f64, Fault> {
    value.and_then(Value::as_f64).ok_or_else(|| Fault::Number {
        column,
        found: super::excerpt(&value.map_or_else(String::new, Value::to_string)),
        expected,
    })
}

fn text_at<'a>(value: &'a Value, key: &str) -> &'a str {
    value.get(key).and_then(Value::as_str).unwrap_or("(none)")
}

/// The text of a plan.
pub(super) fn format(plan: &Plan) -> Result<String, PlanError> {
    let mut features = Vec::new();
    let feature = |geometry: Value, properties: Value| json!({ "type": "Feature", "geometry": geometry, "properties": properties });
    let at = |place: Geodetic, altitude_m: f32| {
        let altitude = if altitude_m.is_finite() { decimal::widened(altitude_m) } else { 0.0 };
        json!({ "type": "Point", "coordinates": [place.longitude_deg, place.latitude_deg, altitude] })
    };
    if let Some(home) = plan.mission.home {
        features.push(feature(at(home, 0.0), json!({ "role": "home", "name": "Home" })));
    }
    let path: Vec<[f64; 2]> = super::gpx::places(&plan.mission)
        .map(|(_, place, _)| [place.longitude_deg, place.latitude_deg])
        .collect();
    if path.len() > 1 {
        features.push(feature(
            json!({ "type": "LineString", "coordinates": path }),
            json!({ "role": "path", "name": "Mission" }),
        ));
    }
    for (number, item) in (1..).zip(&plan.mission.items) {
        features.push(item_feature(number, item));
    }
    for area in &plan.fence.areas {
        let side = if area.inclusion { "inclusion" } else { "exclusion" };
        features.push(match &area.outline {
            Outline::Polygon(corners) => {
                let mut ring: Vec<[f64; 2]> =
                    corners.iter().map(|corner| [corner.longitude_deg, corner.latitude_deg]).collect();
                ring.extend(ring.first().copied());
                feature(json!({ "type": "Polygon", "coordinates": [ring] }), json!({ "fence": side }))
            }
            Outline::Circle { centre, radius_m } => {
                feature(at(*centre, 0.0), json!({ "fence": side, "radius_m": decimal::widened(*radius_m) }))
            }
        });
    }
    if let Some(point) = plan.fence.return_point {
        features.push(feature(at(point.position, point.altitude_m), json!({ "role": "fence return" })));
    }
    for rally in &plan.rally {
        features.push(feature(at(rally.position, rally.altitude_m), json!({ "role": "rally" })));
    }
    let collection = json!({ "type": "FeatureCollection", "features": features });
    let text = serde_json::to_string_pretty(&collection)
        .map_err(|error| PlanError::at(Place::File, Fault::GeoJson(error.to_string())))?;
    Ok(text + "\n")
}

fn item_feature(number: usize, item: &Item) -> Value {
    let [x, y] = item.coordinates();
    let mut properties = json!({
        "item": number,
        "command": item.command,
        "frame": item.frame,
        "params": item.params.map(decimal::to_json),
        "altitude": decimal::to_json(item.z),
        "autocontinue": item.autocontinue,
    });
    let geometry = match item.position() {
        Some(_) => json!({ "type": "Point", "coordinates": [y, x] }),
        None => {
            properties["x"] = json!(x);
            properties["y"] = json!(y);
            Value::Null
        }
    };
    json!({ "type": "Feature", "geometry": geometry, "properties": properties })
}
