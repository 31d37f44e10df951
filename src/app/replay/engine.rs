//! Drives a log through the controller: scan first, then replay.

use std::path::Path;
use std::time::Instant;

use helmlink_mission::plan::Mission;

use super::{Failure, LogFiles};
use crate::app::{boat, mission};
use crate::bridge::MissionSource;
use crate::control::{Boat, Controller};
use crate::replay::explain::explain;
use crate::replay::picture::{PictureSink, Side};
use crate::replay::reorder::Ordered;
use crate::replay::scan::Scan;
use crate::replay::what_if::{Moment, Sink, WhatIf, WhatIfResult, WhatIfSettings, Window};
use crate::vehicle::OutputKind;

/// What the user has said about a replay; the rest comes from the log.
#[derive(Debug, Clone, Default)]
pub(in crate::app) struct Wishes<'a> {
    pub(in crate::app) boat: Option<&'a str>,
    pub(in crate::app) mission: Option<&'a Path>,
    pub(in crate::app) controller: Option<Controller>,
    pub(in crate::app) output: Option<OutputKind>,
    pub(in crate::app) speed_mps: Option<f64>,
}

/// A log that has been scanned.
pub(in crate::app) struct Engine {
    files: LogFiles,
    pub(in crate::app) scan: Scan,
    pub(in crate::app) vehicle: helmlink_wire::Identity,
    /// What the user should know.
    pub(in crate::app) notes: Vec<String>,
}

/// What a replay has given.
pub(in crate::app) struct Outcome {
    pub(in crate::app) result: WhatIfResult,
    pub(in crate::app) picture: PictureSink,
    pub(in crate::app) what_if: Run,
    pub(in crate::app) wall_s: f64,
    pub(in crate::app) notes: Vec<String>,
}

/// The track over the mission, still without title and figures.
pub(in crate::app) type Run = crate::report::Run;

impl Engine {
    /// Scans a log.
    ///
    /// # Errors
    /// The log cannot be read, or holds no vehicle.
    pub(in crate::app) fn scan(files: LogFiles, system: Option<u8>) -> Result<Self, Failure> {
        let name = files.shown();
        let scan =
            Scan::of(files.open()).map_err(|error| Failure::usage(format!("cannot read {name}: {error}")))?;
        if scan.records == 0 {
            return Err(Failure::usage(format!(
                "{name} is no telemetry log: there is no MAVLink frame in its {} bytes (expected 8 bytes of time, then a \
                 frame that begins with 0xFD or 0xFE; ArduPilot's .bin logs are another format)",
                files.bytes()
            )));
        }
        let Some(vehicle) = scan.vehicle(system) else {
            let which =
                system.map_or_else(|| "a flight controller".to_owned(), |system| format!("system {system}"));
            return Err(Failure::usage(format!(
                "{name} holds {} frames, but no heartbeat of {which}: there is no boat to replay",
                scan.records
            )));
        };
        let notes = explain(&scan, vehicle);
        Ok(Self { files, scan, vehicle, notes })
    }

    /// The settings of a replay: what the user says, else what was recorded, else what fits the log.
    ///
    /// # Errors
    /// A boat or a mission that cannot be read.
    pub(in crate::app) fn settings(
        &mut self,
        wishes: &Wishes<'_>,
        window: Window,
    ) -> Result<WhatIfSettings, Failure> {
        let recorded = self.scan.header.as_ref().map(|header| header.settings.clone());
        let boat = match (wishes.boat, &recorded) {
            (Some(name), _) => boat::load(name)?,
            (None, Some(settings)) => settings.boat.clone(),
            (None, None) => self.guessed_boat()?,
        };
        let given = wishes.mission.map(mission::load).transpose()?.map(|drivable| drivable.mission);
        let of_recording = recorded.as_ref().and_then(|settings| match &settings.mission {
            MissionSource::Given(mission) => Some(mission.clone()),
            MissionSource::Vehicle => None,
        });
        let mission: Option<Mission> = given.or(of_recording);
        if mission.is_none() && self.scan.missions.is_empty() {
            self.notes.push(
                "no mission was transferred while this log was made: give it with --mission FILE".to_owned(),
            );
        }
        Ok(WhatIfSettings {
            output: wishes
                .output
                .or(recorded.as_ref().map(|settings| settings.output))
                .unwrap_or(OutputKind::RcOverride),
            speed_mps: wishes.speed_mps.or(recorded.as_ref().and_then(|settings| settings.speed_mps)),
            ground_station_system: recorded.as_ref().map_or(255, |settings| settings.ground_station_system),
            controller: wishes
                .controller
                .or(recorded.as_ref().map(|settings| settings.controller))
                .unwrap_or_default(),
            boat,
            mission,
            window,
        })
    }

    /// Replays the whole log; everything that comes out also goes to `sinks`.
    ///
    /// # Errors
    /// The log cannot be read.
    pub(in crate::app) fn run(
        &self,
        settings: WhatIfSettings,
        side: Side,
        sinks: &mut [&mut dyn Sink],
    ) -> Result<Outcome, Failure> {
        let started = Instant::now();
        let summary = self.scan.vehicles.get(&self.vehicle).cloned().unwrap_or_default();
        let mut what_if = WhatIf::new(
            settings,
            self.vehicle,
            summary.interval_s(),
            self.scan.missions.clone(),
            &self.scan.parameters,
        );
        let mut all = Fan { picture: PictureSink::new(side), sinks };
        let mut log = Ordered::new(self.files.open(), self.scan.disordered > 0);
        let read_on = |error| Failure::failed(format!("cannot read {}: {error}", self.files.shown()));
        while log
            .next(|time_us, frame| {
                if let Ok(message) = frame.decode() {
                    what_if.on_message(time_us, frame.identity(), &message, &mut all);
                    all.picture.note_path(&what_if);
                }
            })
            .map_err(read_on)?
        {}
        let wall_s = started.elapsed().as_secs_f64();
        let run = all.picture.to_run(&what_if, &self.scan);
        let picture = all.picture;
        let (result, faults) = what_if.finish();
        let notes = self.notes.iter().cloned().chain(faults).collect();
        Ok(Outcome { result, picture, what_if: run, wall_s, notes })
    }

    /// The files of the log.
    pub(in crate::app) fn files(&self) -> &LogFiles {
        &self.files
    }

    fn guessed_boat(&mut self) -> Result<Boat, Failure> {
        let is_simulated = self.scan.vehicles.get(&self.vehicle).is_some_and(|vehicle| vehicle.is_simulated);
        let (name, why) = if is_simulated {
            ("motorboat", "the log is from ArduPilot's simulator")
        } else {
            ("otter", "the log does not say which boat it is")
        };
        self.notes.push(format!("boat {name}: {why} (--boat chooses another)"));
        boat::load(name)
    }
}

/// The picture and the files of the user.
struct Fan<'a, 'b> {
    picture: PictureSink,
    sinks: &'a mut [&'b mut dyn Sink],
}

impl Sink for Fan<'_, '_> {
    fn moment(&mut self, moment: &Moment) {
        self.picture.moment(moment);
        self.sinks.iter_mut().for_each(|sink| sink.moment(moment));
    }

    fn command(&mut self, time_us: u64, frame: &[u8]) {
        self.sinks.iter_mut().for_each(|sink| sink.command(time_us, frame));
    }

    fn event(&mut self, time_s: f64, text: &str) {
        self.picture.event(time_s, text);
        self.sinks.iter_mut().for_each(|sink| sink.event(time_s, text));
    }
}
