//! Turns the moments of a log into a run that can be drawn.

use helmlink_mission::geodesy::{Geodetic, LocalFrame};

use super::scan::Scan;
use super::what_if::{Moment, Sink, WhatIf};
use crate::report::{Curve, FenceArea, Panel, Run, TrackPoint};
use crate::thin::Thinned;

/// Spacing of the points that show a smooth path, metres.
const PATH_SPACING_M: f64 = 0.5;
/// Vehicle time between two points of the track, seconds.
const POINT_S: f64 = 0.1;
/// Points of the track kept, of the commands as many; a log longer than an hour or two is thinned.
const MOST_POINTS: usize = 60_000;
/// Points of smooth paths kept.
const MOST_PATH_POINTS: usize = 200_000;
/// Events kept.
const MOST_EVENTS: usize = 10_000;

/// Whose commands are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Those that were given when the log was made.
    Recorded,
    /// Those of the controller it is replayed through.
    Replayed,
}

/// A place of the track.
type Place = (Geodetic, TrackPoint);
/// Time, then steering and throttle recorded and replayed.
type Commands = (f64, [f64; 2], [f64; 2]);

/// Collects what a report needs, in bounded memory however long the log is.
#[derive(Debug)]
pub struct PictureSink {
    side: Side,
    track: Thinned<Place>,
    path: Vec<Geodetic>,
    stretches: usize,
    events: Vec<(f64, String)>,
    start_s: Option<f64>,
    /// Steering and throttle of both sides, for a comparison.
    commands: Thinned<Commands>,
}

impl PictureSink {
    /// Collects one side.
    pub fn new(side: Side) -> Self {
        Self {
            side,
            track: Thinned::new(
                MOST_POINTS,
                |(_, point)| point.time_s,
                &[
                    |(place, _)| place.latitude_deg,
                    |(place, _)| place.longitude_deg,
                    |(_, point)| point.cross_track_m,
                    |(_, point)| point.speed_mps,
                    |(_, point)| point.steering,
                ],
            ),
            path: Vec::new(),
            stretches: 0,
            events: Vec::new(),
            start_s: None,
            commands: Thinned::new(
                MOST_POINTS,
                |(time_s, ..)| *time_s,
                &[|(_, recorded, _)| recorded[0], |(.., replayed)| replayed[0], |(.., replayed)| replayed[1]],
            ),
        }
    }

    /// Takes down the path when it is a new one.
    pub fn note_path(&mut self, what_if: &WhatIf) {
        let Some((stretches, path)) = what_if.path().filter(|(stretches, _)| *stretches > self.stretches)
        else {
            return;
        };
        let Some(frame) = what_if.frame() else { return };
        self.stretches = stretches;
        if self.path.len() > MOST_PATH_POINTS {
            return;
        }
        let count = (path.length_m() / PATH_SPACING_M).ceil().max(1.0);
        let points = (0..=count as usize)
            .map(|index| frame.to_geodetic(path.point(path.length_m() * index as f64 / count).position));
        self.path.extend(points);
    }

    /// The run with the fence and the rally points of the log, still without title and figures.
    pub fn to_run(&self, what_if: &WhatIf, scan: &Scan) -> Run {
        let origin = self.track.iter().next().map(|(place, _)| LocalFrame::new(*place));
        let Some(frame) = what_if.frame().copied().or(origin) else { return Run::default() };
        let start_s = self.start_s.unwrap_or_default();
        let track = self.track.iter().map(|(place, point)| TrackPoint {
            position: frame.to_local(*place),
            time_s: point.time_s - start_s,
            ..*point
        });
        Run {
            mission: what_if.waypoints(),
            path: self.path.iter().map(|place| frame.to_local(*place)).collect(),
            fence: FenceArea::all_of(&scan.fence, &frame),
            rally: scan.rally.iter().map(|rally| frame.to_local(rally.position)).collect(),
            track: track.collect(),
            events: self
                .events
                .iter()
                .map(|(time_s, text)| ((time_s - start_s).max(0.0), text.clone()))
                .collect(),
            ..Run::default()
        }
    }

    /// Recorded and replayed commands over time.
    pub fn panels(&self) -> Vec<Panel> {
        let start_s = self.start_s.unwrap_or_default();
        let curve = |name: &str, of: &dyn Fn(&[f64; 2], &[f64; 2]) -> f64| Curve {
            name: name.to_owned(),
            readings: self.commands.iter().map(|(time_s, a, b)| (time_s - start_s, of(a, b))).collect(),
        };
        ["Steering, −1 to 1", "Throttle, −1 to 1"]
            .into_iter()
            .enumerate()
            .map(|(axis, title)| Panel {
                title: title.to_owned(),
                curves: vec![
                    curve("recorded", &|recorded, _| recorded[axis]),
                    curve("replayed", &|_, replayed| replayed[axis]),
                ],
            })
            .collect()
    }
}

impl Sink for PictureSink {
    fn moment(&mut self, moment: &Moment) {
        let start_s = *self.start_s.get_or_insert(moment.time_s);
        let last_s = self.track.last().map_or(f64::NEG_INFINITY, |(_, point)| point.time_s);
        if moment.time_s < last_s + POINT_S - 1e-9 && moment.time_s > start_s {
            return;
        }
        let outputs = moment.outputs.map(|outputs| [outputs.steering, outputs.throttle]);
        let commanded =
            moment.thought.map(|thought| [f64::from(thought.steering), f64::from(thought.throttle)]);
        let unknown = [f64::NAN; 2];
        let (shown, thought) = match self.side {
            Side::Recorded => (outputs, moment.recorded),
            Side::Replayed => (commanded, moment.thought),
        };
        if let Some(commanded) = commanded {
            self.commands.push((moment.time_s, outputs.unwrap_or(unknown), commanded));
        }
        let [steering, throttle] = shown.unwrap_or(unknown);
        let of = |value: fn(&crate::record::ControlState) -> f32| {
            thought.as_ref().map_or(f64::NAN, |thought| f64::from(value(thought)))
        };
        let point = TrackPoint {
            time_s: moment.time_s,
            heading_rad: moment.state.heading_rad,
            cross_track_m: moment.leg_error_m.unwrap_or(f64::NAN),
            speed_mps: moment.state.surge_mps.hypot(moment.state.sway_mps),
            wanted_speed_mps: of(|thought| thought.speed_wanted_mps),
            steering,
            throttle,
            surfaces: [of(|thought| thought.surface_u), of(|thought| thought.surface_r)],
            disturbances: [of(|thought| thought.disturbance_u), of(|thought| thought.disturbance_r)],
            ..TrackPoint::UNKNOWN
        };
        self.track.push((moment.place, point));
    }

    fn command(&mut self, _time_us: u64, _frame: &[u8]) {}

    fn event(&mut self, time_s: f64, text: &str) {
        if self.events.len() < MOST_EVENTS {
            self.events.push((time_s, text.to_owned()));
        }
    }
}
