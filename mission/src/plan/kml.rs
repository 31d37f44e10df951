//! KML 2.2: paths as missions of plain waypoints.
//!
//! Lines (`LineString`) are joined in their order; a file without lines is read as its track (`gx:Track`) or
//! else as its points. Polygons are areas of the fence where the file says so: it does in the files written
//! here, by an extended datum "helmlink". Source: <https://developers.google.com/kml/documentation/kmlreference>.

use std::fmt::Write as _;

use super::error::{Fault, Place, PlanError};
use super::gpx::places;
use super::xml::{Node, Walker, number, position};
use super::{Area, Item, Outline, Plan, RallyPoint, Reading};
use crate::geodesy::{Geodetic, LocalFrame, NorthEast};

/// Values of the extended datum.
const HOME: &str = "home";
const RALLY: &str = "rally";
const INCLUSION: &str = "fence inclusion";
const EXCLUSION: &str = "fence exclusion";
/// Corners with which a circle is drawn.
const CIRCLE_CORNERS: usize = 72;

type Place3 = (Geodetic, f32);

/// What the file has been found to hold.
#[derive(Debug, Default)]
struct Content {
    lines: Vec<Vec<Place3>>,
    track: Vec<Place3>,
    points: Vec<Place3>,
    polygons_left_out: usize,
    plan: Plan,
}

/// A placemark being read.
#[derive(Debug, Default)]
struct Placemark {
    /// The extended datum.
    datum: String,
    lines: Vec<Vec<Place3>>,
    points: Vec<Place3>,
    outlines: Vec<Vec<Place3>>,
}

/// The plan of a KML document.
pub(super) fn parse(text: &str) -> Result<Reading, PlanError> {
    let mut content = collect(text)?;
    let mut notes = Vec::new();
    if content.polygons_left_out > 0 {
        notes.push(format!(
            "{} polygons were left out: a polygon is part of the fence only where its extended datum \
             \"helmlink\" is \"{INCLUSION}\" or \"{EXCLUSION}\"",
            content.polygons_left_out
        ));
    }
    if content.lines.len() > 1 {
        notes.push(format!("the {} lines were joined in their order", content.lines.len()));
    }
    let mut points: Vec<Place3> = content.lines.concat();
    if !points.is_empty() {
        if !content.points.is_empty() {
            notes.push(format!("{} single points were left out: the line was taken", content.points.len()));
        }
    } else if !content.track.is_empty() {
        points = content.track;
    } else {
        if content.points.len() > 1 {
            notes.push("there is no line: the points were taken in their order".to_owned());
        }
        points = content.points;
    }
    content.plan.mission.items =
        points.into_iter().map(|(position, z)| Item { z, ..Item::waypoint(position) }).collect();
    if content.plan.is_empty() {
        return Err(PlanError::at(Place::File, Fault::Empty));
    }
    Ok(Reading { notes, ..Reading::of(content.plan) })
}

fn collect(text: &str) -> Result<Content, PlanError> {
    let mut walker = Walker::new(text);
    let mut content = Content::default();
    let mut placemark = Placemark::default();
    let mut around = Vec::new();
    let mut value = String::new();
    while let Some(node) = walker.next()? {
        match node {
            Node::Open { name, attributes } => {
                value.clear();
                let ours = attributes.iter().any(|(key, value)| key == "name" && value == "helmlink");
                around.push(if name == "Data" && ours { "helmlink".to_owned() } else { name });
            }
            Node::Text(text) => value.push_str(&text),
            Node::Close(name) => {
                around.pop();
                let fault = |fault| walker.fault(fault);
                match name.as_str() {
                    "coordinates" => {
                        let places = coordinates(&value).map_err(fault)?;
                        let within = |name: &str| around.iter().any(|element| element == name);
                        if within("innerBoundaryIs") {
                            content.polygons_left_out += 1;
                        } else if within("Polygon") {
                            placemark.outlines.push(places);
                        } else if within("Point") {
                            placemark.points.extend(places);
                        } else {
                            placemark.lines.push(places);
                        }
                    }
                    "coord" => content.track.push(track_place(&value).map_err(fault)?),
                    "value" if around.iter().any(|element| element == "helmlink") => {
                        placemark.datum = value.trim().to_owned();
                    }
                    "Placemark" => content.take(std::mem::take(&mut placemark)).map_err(fault)?,
                    _ => {}
                }
                value.clear();
            }
        }
    }
    // Geometry outside of any placemark: not allowed, but in no doubt either.
    content.take(placemark).map_err(|fault| walker.fault(fault))?;
    Ok(content)
}

impl Content {
    fn take(&mut self, placemark: Placemark) -> Result<(), Fault> {
        match placemark.datum.as_str() {
            HOME => self.plan.mission.home = placemark.points.first().map(|(home, _)| *home),
            RALLY => self.plan.rally.extend(
                placemark.points.iter().map(|&(position, altitude_m)| RallyPoint { position, altitude_m }),
            ),
            _ => self.points.extend(placemark.points),
        }
        for outline in placemark.outlines {
            let inclusion = placemark.datum == INCLUSION;
            if inclusion || placemark.datum == EXCLUSION {
                let corners = outline.into_iter().map(|(corner, _)| corner).collect();
                self.plan.fence.areas.push(Area { inclusion, outline: Outline::polygon(corners)? });
            } else {
                self.polygons_left_out += 1;
            }
        }
        self.lines.extend(placemark.lines.into_iter().filter(|line| !line.is_empty()));
        Ok(())
    }
}

/// Longitude, latitude and perhaps altitude, joined by commas; places apart by blanks.
fn coordinates(text: &str) -> Result<Vec<Place3>, Fault> {
    text.split_whitespace()
        .map(|tuple| {
            let mut numbers = tuple.split(',');
            let longitude = numbers.next().unwrap_or("");
            let Some(latitude) = numbers.next() else {
                let (column, found) = ("a place", super::excerpt(tuple));
                return Err(Fault::Number {
                    column,
                    found,
                    expected: "longitude,latitude or longitude,latitude,altitude",
                });
            };
            place(latitude, longitude, numbers.next())
        })
        .collect()
}

/// Longitude, latitude and perhaps altitude, joined by blanks.
fn track_place(text: &str) -> Result<Place3, Fault> {
    let mut numbers = text.split_whitespace();
    let (longitude, latitude) = (numbers.next().unwrap_or(""), numbers.next().unwrap_or(""));
    place(latitude, longitude, numbers.next())
}

fn place(latitude: &str, longitude: &str, altitude: Option<&str>) -> Result<Place3, Fault> {
    let altitude_m = match altitude.map(str::trim).filter(|text| !text.is_empty()) {
        Some(text) => number("altitude", text, "metres")? as f32,
        None => 0.0,
    };
    Ok((position(latitude, longitude)?, altitude_m))
}

/// The document of a plan.
pub(super) fn format(plan: &Plan) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>Helmlink mission</name>\n",
    );
    let track: Vec<Place3> =
        places(&plan.mission).map(|(_, place, altitude_m)| (place, altitude_m)).collect();
    if !track.is_empty() {
        let _ = writeln!(
            text,
            "<Placemark><name>Mission</name><LineString><coordinates>{}</coordinates></LineString></Placemark>",
            coordinate_text(&track)
        );
    }
    if let Some(home) = plan.mission.home {
        write_point(&mut text, "Home", HOME, (home, 0.0));
    }
    for (number, rally) in (1..).zip(&plan.rally) {
        write_point(&mut text, &format!("Rally {number}"), RALLY, (rally.position, rally.altitude_m));
    }
    for (number, area) in (1..).zip(&plan.fence.areas) {
        let datum = if area.inclusion { INCLUSION } else { EXCLUSION };
        let mut corners: Vec<Place3> = corners(&area.outline).into_iter().map(|place| (place, 0.0)).collect();
        corners.extend(corners.first().copied());
        let _ = writeln!(
            text,
            "<Placemark><name>Fence {number}</name>{}<Polygon><outerBoundaryIs><LinearRing><coordinates>{}\
             </coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>",
            datum_text(datum),
            coordinate_text(&corners)
        );
    }
    text.push_str("</Document>\n</kml>\n");
    text
}

fn corners(outline: &Outline) -> Vec<Geodetic> {
    match outline {
        Outline::Polygon(corners) => corners.clone(),
        Outline::Circle { centre, radius_m } => {
            let frame = LocalFrame::new(*centre);
            (0..CIRCLE_CORNERS)
                .map(|index| {
                    let bearing_rad = std::f64::consts::TAU * index as f64 / CIRCLE_CORNERS as f64;
                    frame.to_geodetic(NorthEast::from_polar(f64::from(*radius_m), bearing_rad))
                })
                .collect()
        }
    }
}

fn write_point(text: &mut String, name: &str, datum: &str, place: Place3) {
    let _ = writeln!(
        text,
        "<Placemark><name>{name}</name>{}<Point><coordinates>{}</coordinates></Point></Placemark>",
        datum_text(datum),
        coordinate_text(&[place])
    );
}

fn datum_text(value: &str) -> String {
    format!("<ExtendedData><Data name=\"helmlink\"><value>{value}</value></Data></ExtendedData>")
}

fn coordinate_text(places: &[Place3]) -> String {
    let texts: Vec<String> = places
        .iter()
        .map(|(place, altitude_m)| {
            format!("{:.8},{:.8},{altitude_m}", place.longitude_deg, place.latitude_deg)
        })
        .collect();
    texts.join(" ")
}
