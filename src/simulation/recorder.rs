//! Watches a run of a simulated boat: figures, track and events.

use helmlink_mission::geodesy::{Geodetic, LocalFrame, NorthEast};
use helmlink_sitl::Sitl;

use super::score::{Sample, Score, Scorer};
use crate::bridge::{Bridge, Event};
use crate::pilot::supervisor::State;
use crate::report::TrackPoint;

/// Spacing of the points that show a smooth path in a picture, metres.
const PATH_SPACING_M: f64 = 0.5;

/// Collects what a report needs while the boat is driven by the bridge.
pub struct RunRecorder {
    sitl_frame: LocalFrame,
    scorer: Option<Scorer>,
    track: Vec<TrackPoint>,
    path: Vec<NorthEast>,
    waypoints: Vec<NorthEast>,
    stretches: usize,
    events: Vec<(f64, String)>,
}

impl RunRecorder {
    /// A recorder for a simulated boat whose home is `home`.
    pub fn new(home: Geodetic) -> Self {
        Self {
            sitl_frame: LocalFrame::new(home),
            scorer: None,
            track: Vec::new(),
            path: Vec::new(),
            waypoints: Vec::new(),
            stretches: 0,
            events: Vec::new(),
        }
    }

    /// Notes an event of the bridge.
    pub fn on_event(&mut self, time_s: f64, event: &Event) {
        self.events.push((time_s, event.text.clone()));
    }

    /// Looks at the boat; call it at even intervals of simulated time.
    pub fn sample(&mut self, time_s: f64, sitl: &Sitl, bridge: &Bridge) {
        let status = bridge.status();
        let Some(run) = bridge.run().filter(|_| status.state == State::Engaged) else { return };
        if self.waypoints.is_empty() {
            self.waypoints = run.waypoints().to_vec();
            self.scorer = Some(Scorer::new(self.waypoints.clone()));
        }
        self.note_path(run);
        let progress = run.progress();
        let (truth, estimate) = (sitl.truth(), sitl.estimate());
        let hull = truth.hull;
        let local = NorthEast { north_m: hull.north_m, east_m: hull.east_m };
        let position = run.frame().to_local(self.sitl_frame.to_geodetic(local));
        let (north_mps, east_mps) = hull.velocity_ned_mps();
        let speed_mps = north_mps.hypot(east_mps);
        let reference = status.diagnostics.reference;
        let foot = run.path().map(|path| path.point(path.project(position, reference.progress_m)));
        let across_m = |way: NorthEast| {
            foot.map_or(0.0, |foot| NorthEast::from_polar(1.0, foot.heading_rad).cross(way).abs())
        };
        let path_error_m = foot.map_or(0.0, |foot| across_m(position - foot.position));
        let wave = truth.wave_motion;
        let navigated = NorthEast {
            north_m: estimate.north_m - (hull.north_m + wave.north_m),
            east_m: estimate.east_m - (hull.east_m + wave.east_m),
        };
        self.track.push(TrackPoint {
            time_s,
            position,
            heading_rad: hull.psi_rad,
            cross_track_m: reference.cross_track_m,
            speed_mps,
            wanted_speed_mps: progress.wanted_speed_mps,
            steering: status.demand.steering,
            throttle: status.demand.throttle,
            surfaces: [status.diagnostics.law.surface_u, status.diagnostics.law.surface_r],
            disturbances: [status.diagnostics.law.disturbance_u, status.diagnostics.law.disturbance_r],
        });
        // The score begins at the first waypoint, when the boat is on a leg of the mission.
        if let (Some(scorer), Some(leg)) = (self.scorer.as_mut(), progress.leg) {
            scorer.on_sample(Sample {
                time_s,
                position,
                speed_mps,
                leg,
                path_error_m,
                path_is_straight: foot.is_some_and(|foot| foot.curvature_radpm == 0.0),
                navigation_error_m: Some(across_m(navigated)),
                wanted_speed_mps: progress.wanted_speed_mps,
                steering: status.demand.steering,
                throttle: status.demand.throttle,
            });
        }
    }

    fn note_path(&mut self, run: &crate::pilot::MissionRun) {
        if let Some(path) = run.path().filter(|_| run.stretches() > self.stretches) {
            self.stretches = run.stretches();
            let count = (path.length_m() / PATH_SPACING_M).ceil().max(1.0);
            let points =
                (0..=count as usize).map(|index| path.point(path.length_m() * index as f64 / count).position);
            self.path.extend(points);
        }
    }

    /// The figures so far; none before the first waypoint.
    pub fn score(&self) -> Option<Score> {
        self.scorer.as_ref().map(Scorer::score)
    }

    /// The run as a picture wants it, in metres from the first waypoint, still without title and figures.
    pub fn into_run(self) -> crate::report::Run {
        crate::report::Run {
            mission: self.waypoints,
            path: self.path,
            track: self.track,
            events: self.events,
            ..crate::report::Run::default()
        }
    }
}
