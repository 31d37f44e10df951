//! GPX 1.1: routes and tracks as missions of plain waypoints.
//!
//! A file with routes is read as its first route; one with tracks only as its first track, all segments in a
//! row; one with neither as its waypoints. Source: <https://www.topografix.com/GPX/1/1/>.

use std::fmt::Write as _;

use super::error::{Fault, Place, PlanError};
use super::xml::{Node, Walker, escape, number, position};
use super::{Item, Mission, Plan, RallyPoint, Reading};
use crate::geodesy::Geodetic;

/// Types of waypoints with a meaning of their own.
const HOME: &str = "home";
const RALLY: &str = "rally";

/// A point of the file.
#[derive(Debug, Clone, Default)]
struct Point {
    position: Geodetic,
    altitude_m: f32,
    kind: String,
}

/// The points of the file, by what they belong to.
#[derive(Debug, Default)]
struct Content {
    waypoints: Vec<Point>,
    routes: Vec<Vec<Point>>,
    tracks: Vec<Vec<Point>>,
    segments: usize,
}

/// The plan of a GPX document.
pub(super) fn parse(text: &str) -> Result<Reading, PlanError> {
    let mut content = collect(text)?;
    let mut notes = Vec::new();
    let mut plan = Plan::default();
    for point in &content.waypoints {
        if point.kind == HOME {
            plan.mission.home = Some(point.position);
        } else if point.kind == RALLY {
            plan.rally.push(RallyPoint { position: point.position, altitude_m: point.altitude_m });
        }
    }
    content.waypoints.retain(|point| point.kind != HOME && point.kind != RALLY);
    content.routes.retain(|route| !route.is_empty());
    content.tracks.retain(|track| !track.is_empty());
    let loose = content.waypoints.len();
    let points = if let Some(route) = content.routes.first() {
        note_rest(&mut notes, "route", content.routes.len() - 1);
        note_rest(&mut notes, "track", content.tracks.len());
        if loose > 0 {
            notes.push(format!("{loose} single waypoints were left out: the route was taken"));
        }
        route
    } else if let Some(track) = content.tracks.first() {
        note_rest(&mut notes, "track", content.tracks.len() - 1);
        if content.segments > 1 && content.tracks.len() == 1 {
            notes.push(format!("the {} segments of the track were joined", content.segments));
        }
        if loose > 0 {
            notes.push(format!("{loose} single waypoints were left out: the track was taken"));
        }
        track
    } else {
        if loose > 1 {
            notes.push("there is no route and no track: the waypoints were taken in their order".to_owned());
        }
        &content.waypoints
    };
    if points.is_empty() && plan.rally.is_empty() {
        return Err(PlanError::at(Place::File, Fault::Empty));
    }
    plan.mission.items =
        points.iter().map(|point| Item { z: point.altitude_m, ..Item::waypoint(point.position) }).collect();
    Ok(Reading { notes, ..Reading::of(plan) })
}

fn note_rest(notes: &mut Vec<String>, what: &str, count: usize) {
    match count {
        0 => {}
        1 => notes.push(format!("one more {what} was left out")),
        _ => notes.push(format!("{count} more {what}s were left out")),
    }
}

fn collect(text: &str) -> Result<Content, PlanError> {
    let mut walker = Walker::new(text);
    let mut content = Content::default();
    let mut point: Option<Point> = None;
    let mut value: Option<String> = None;
    while let Some(node) = walker.next()? {
        match node {
            Node::Open { name, attributes } => {
                value = None;
                match name.as_str() {
                    "rte" => content.routes.push(Vec::new()),
                    "trk" => content.tracks.push(Vec::new()),
                    "trkseg" => content.segments += 1,
                    "wpt" | "rtept" | "trkpt" => {
                        let attribute = |wanted: &str| {
                            attributes.iter().find(|(name, _)| name == wanted).map_or("", |(_, value)| value)
                        };
                        let position = position(attribute("lat"), attribute("lon"))
                            .map_err(|fault| walker.fault(fault))?;
                        point = Some(Point { position, ..Point::default() });
                    }
                    "ele" | "type" => value = Some(String::new()),
                    _ => {}
                }
            }
            Node::Text(text) => {
                if let Some(value) = &mut value {
                    value.push_str(&text);
                }
            }
            Node::Close(name) => {
                match (name.as_str(), &mut point, value.take()) {
                    ("ele", Some(point), Some(value)) => {
                        point.altitude_m = number("the elevation", &value, "metres")
                            .map_err(|fault| walker.fault(fault))?
                            as f32;
                    }
                    ("type", Some(point), Some(value)) => point.kind = value.trim().to_ascii_lowercase(),
                    _ => {}
                }
                let list = match name.as_str() {
                    "wpt" => Some(&mut content.waypoints),
                    "rtept" => content.routes.last_mut(),
                    "trkpt" => content.tracks.last_mut(),
                    _ => None,
                };
                if let (Some(list), true) = (list, matches!(name.as_str(), "wpt" | "rtept" | "trkpt")) {
                    list.extend(point.take());
                }
            }
        }
    }
    Ok(content)
}

/// The document of a plan.
pub(super) fn format(plan: &Plan) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <gpx version=\"1.1\" creator=\"Helmlink\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n",
    );
    if let Some(home) = plan.mission.home {
        write_point(&mut text, "wpt", home, 0.0, "Home", Some(HOME));
    }
    for (number, place) in (1..).zip(&plan.rally) {
        let name = format!("Rally {number}");
        write_point(&mut text, "wpt", place.position, place.altitude_m, &name, Some(RALLY));
    }
    if !plan.mission.items.is_empty() {
        text.push_str("<rte>\n");
        for (number, position, altitude_m) in places(&plan.mission) {
            write_point(&mut text, "rtept", position, altitude_m, &format!("WP{number}"), None);
        }
        text.push_str("</rte>\n");
    }
    text.push_str("</gpx>\n");
    text
}

/// The items that are somewhere: number, place, altitude.
pub(super) fn places(mission: &Mission) -> impl Iterator<Item = (usize, Geodetic, f32)> + '_ {
    (1..).zip(&mission.items).filter_map(|(number, item)| {
        let altitude_m = if item.z.is_finite() { item.z } else { 0.0 };
        item.position().map(|position| (number, position, altitude_m))
    })
}

fn write_point(
    text: &mut String,
    element: &str,
    position: Geodetic,
    altitude_m: f32,
    name: &str,
    kind: Option<&str>,
) {
    // The schema wants elevation, name and type in this order. Writing to a string cannot fail.
    let _ = write!(
        text,
        "<{element} lat=\"{:.8}\" lon=\"{:.8}\"><ele>{altitude_m}</ele><name>{}</name>",
        position.latitude_deg,
        position.longitude_deg,
        escape(name)
    );
    if let Some(kind) = kind {
        let _ = write!(text, "<type>{kind}</type>");
    }
    let _ = writeln!(text, "</{element}>");
}
