//! MCAP with JSON messages and their schemas (<https://mcap.dev/spec>). `/track`, `/mission` and `/events` follow
//! Foxglove's own schemas (<https://docs.foxglove.dev/docs/visualization/message-schemas/introduction>), so that its map
//! and log panels show them without being taught.

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};
use std::mem::ManuallyDrop;

use helmlink_mission::geodesy::Geodetic;
use helmlink_wire::Frame;
use mcap::records::MessageHeader;
use serde_json::{Value, json};

use super::Export;
use crate::record::state::VALUES;
use crate::replay::what_if::Moment;

/// The topics, each with the name of its schema and the schema.
const TOPICS: [&str; 7] = ["/track", "/state", "/errors", "/commands", "/parameters", "/events", "/mission"];

/// Nothing is said about how good a position is.
const NO_COVARIANCE: [f64; 9] = [0.0; 9];

/// Writes an MCAP file.
pub struct McapExport<W: Write + Seek> {
    /// Never dropped: the crate panics there when the file has failed. [`Export::finish`] writes everything out.
    writer: ManuallyDrop<mcap::Writer<W>>,
    channels: BTreeMap<&'static str, u16>,
    sequences: BTreeMap<u16, u32>,
    /// What is written once, with the first time stamp: topic and message.
    first: Vec<(&'static str, Value)>,
}

impl<W: Write + Seek> McapExport<W> {
    /// Writes to `out`, which should be buffered; `parameters` are the vehicle's, `mission` its waypoints.
    ///
    /// # Errors
    /// Those of the file.
    pub fn new(out: W, parameters: &BTreeMap<String, f64>, mission: &[Geodetic]) -> io::Result<Self> {
        let options = mcap::WriteOptions::new().compression(None).profile("").library("helmlink");
        let mut writer = options.create(out).map_err(io::Error::other)?;
        let mut channels = BTreeMap::new();
        for topic in TOPICS {
            let (name, schema) = schema(topic);
            let schema = serde_json::to_vec(&schema)?;
            let schema = writer.add_schema(name, "jsonschema", &schema).map_err(io::Error::other)?;
            let channel =
                writer.add_channel(schema, topic, "json", &BTreeMap::new()).map_err(io::Error::other)?;
            channels.insert(topic, channel);
        }
        let mut first = vec![("/parameters", json!(parameters))];
        if !mission.is_empty() {
            first.push(("/mission", json!({ "geojson": geojson(mission).to_string() })));
        }
        Ok(Self { writer: ManuallyDrop::new(writer), channels, sequences: BTreeMap::new(), first })
    }

    fn put(&mut self, topic: &str, time_us: u64, message: &Value) -> io::Result<()> {
        let Some(&channel_id) = self.channels.get(topic) else { return Ok(()) };
        let sequence = self.sequences.entry(channel_id).or_default();
        *sequence = sequence.wrapping_add(1);
        let time_ns = time_us.saturating_mul(1000);
        let header =
            MessageHeader { channel_id, sequence: *sequence, log_time: time_ns, publish_time: time_ns };
        self.writer.write_to_known_channel(&header, &serde_json::to_vec(message)?).map_err(io::Error::other)
    }
}

fn timestamp(time_us: u64) -> Value {
    json!({ "sec": time_us / 1_000_000, "nsec": time_us % 1_000_000 * 1000 })
}

fn geojson(mission: &[Geodetic]) -> Value {
    let points: Vec<[f64; 2]> =
        mission.iter().map(|place| [place.longitude_deg, place.latitude_deg]).collect();
    let waypoints = points.iter().enumerate().map(|(number, point)| {
        json!({ "type": "Feature", "properties": { "name": format!("waypoint {}", number + 1) },
                "geometry": { "type": "Point", "coordinates": point } })
    });
    let mut features: Vec<Value> = waypoints.collect();
    features.push(json!({ "type": "Feature", "properties": { "name": "mission" },
                          "geometry": { "type": "LineString", "coordinates": points } }));
    json!({ "type": "FeatureCollection", "features": features })
}

/// Name and JSON schema of the messages of a topic.
fn schema(topic: &str) -> (&'static str, Value) {
    let number = |description: &str| json!({ "type": "number", "description": description });
    let time = json!({ "type": "object", "title": "time",
        "properties": { "sec": { "type": "integer" }, "nsec": { "type": "integer" } } });
    let object = |title: &str, properties: Value| json!({ "title": title, "type": "object", "properties": properties });
    match topic {
        "/track" => (
            "foxglove.LocationFix",
            object(
                "foxglove.LocationFix",
                json!({
                    "timestamp": time, "frame_id": { "type": "string" },
                    "latitude": number("degrees"), "longitude": number("degrees"), "altitude": number("m"),
                    "position_covariance": { "type": "array", "items": { "type": "number" } },
                    "position_covariance_type": { "type": "integer" },
                }),
            ),
        ),
        "/events" => (
            "foxglove.Log",
            object(
                "foxglove.Log",
                json!({
                    "timestamp": time, "level": { "type": "integer" }, "message": { "type": "string" },
                    "name": { "type": "string" }, "file": { "type": "string" }, "line": { "type": "integer" },
                }),
            ),
        ),
        "/mission" => {
            ("foxglove.GeoJSON", object("foxglove.GeoJSON", json!({ "geojson": { "type": "string" } })))
        }
        "/state" => (
            "helmlink.State",
            object(
                "helmlink.State",
                json!({
                    "time_s": number("vehicle time, s"), "north_m": number("m"), "east_m": number("m"),
                    "heading_deg": number("clockwise from north"), "surge_mps": number("over ground, m/s"),
                    "sway_mps": number("over ground, m/s"), "yaw_rate_degps": number("degrees/s"),
                    "speed_mps": number("over ground, m/s"),
                }),
            ),
        ),
        "/errors" => (
            "helmlink.Errors",
            object(
                "helmlink.Errors",
                VALUES
                    .iter()
                    .map(|(name, unit, meaning)| (name.to_lowercase(), number(&format!("{meaning}, {unit}"))))
                    .chain([("leg_error".to_owned(), number("distance right of the straight leg, m"))])
                    .collect(),
            ),
        ),
        "/commands" => (
            "helmlink.Commands",
            object(
                "helmlink.Commands",
                json!({
                    "steering": number("the controller's, -1 to 1"), "throttle": number("the controller's, -1 to 1"),
                    "recorded_steering": number("put out when the log was made, -1 to 1"),
                    "recorded_throttle": number("put out when the log was made, -1 to 1"),
                    "message": { "type": "string" }, "frame": { "type": "string", "description": "hexadecimal" },
                }),
            ),
        ),
        _ => (
            "helmlink.Parameters",
            json!({ "title": "helmlink.Parameters", "type": "object",
                                             "additionalProperties": { "type": "number" } }),
        ),
    }
}

impl<W: Write + Seek> Export for McapExport<W> {
    fn moment(&mut self, moment: &Moment) -> io::Result<()> {
        let time_us = moment.time_us;
        for (topic, message) in std::mem::take(&mut self.first) {
            self.put(topic, time_us, &message)?;
        }
        let state = &moment.state;
        self.put(
            "/track",
            time_us,
            &json!({
                "timestamp": timestamp(time_us), "frame_id": "boat", "latitude": moment.place.latitude_deg,
                "longitude": moment.place.longitude_deg, "altitude": 0.0,
                "position_covariance": NO_COVARIANCE, "position_covariance_type": 0,
            }),
        )?;
        self.put(
            "/state",
            time_us,
            &json!({
                "time_s": moment.time_s, "north_m": state.position.north_m, "east_m": state.position.east_m,
                "heading_deg": state.heading_rad.to_degrees(), "surge_mps": state.surge_mps,
                "sway_mps": state.sway_mps, "yaw_rate_degps": state.yaw_rate_radps.to_degrees(),
                "speed_mps": state.surge_mps.hypot(state.sway_mps),
            }),
        )?;
        let outputs = moment.outputs;
        let thought = moment.thought.or(moment.recorded);
        if let Some(thought) = thought {
            let values = VALUES.iter().zip(thought.values());
            let mut errors: serde_json::Map<String, Value> =
                values.map(|((name, ..), value)| (name.to_lowercase(), value.into())).collect();
            errors.insert("leg_error".to_owned(), moment.leg_error_m.into());
            self.put("/errors", time_us, &Value::Object(errors))?;
        }
        self.put(
            "/commands",
            time_us,
            &json!({
                "steering": thought.map(|thought| thought.steering),
                "throttle": thought.map(|thought| thought.throttle),
                "recorded_steering": outputs.map(|outputs| outputs.steering),
                "recorded_throttle": outputs.map(|outputs| outputs.throttle),
            }),
        )
    }

    fn command(&mut self, time_us: u64, frame: &[u8]) -> io::Result<()> {
        let message = Frame::parse(frame).ok().and_then(|frame| frame.name()).unwrap_or("unknown");
        let frame = crate::replay::proof::hex(frame);
        self.put("/commands", time_us, &json!({ "message": message, "frame": frame }))
    }

    fn event(&mut self, time_us: u64, text: &str) -> io::Result<()> {
        let info = 2;
        self.put(
            "/events",
            time_us,
            &json!({
                "timestamp": timestamp(time_us), "level": info, "message": text, "name": "helmlink",
                "file": "", "line": 0,
            }),
        )
    }

    fn finish(&mut self) -> io::Result<()> {
        self.writer.finish().map(drop).map_err(io::Error::other)
    }
}
