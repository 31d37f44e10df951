//! What has to be looked after from time to time: requests, parameters, missions.

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::route::Ending;
use helmlink_wire::enums;

use super::fence::FenceNews;
use super::mission::News;
use super::{Bridge, HOUSEKEEPING, Vehicle};
use crate::control::boat::Actuators;
use crate::pilot::rejoin::{self, Underway};
use crate::pilot::supervisor::State;
use crate::pilot::{MissionRun, RunSettings};
use crate::vehicle::output::checks;
use crate::vehicle::telemetry::Position;
use crate::vehicle::{Mode, output};

impl Bridge {
    pub(super) fn tell_of_actions(&mut self) {
        while let Some(outcome) = self.actions.poll_outcome() {
            self.event(outcome.severity, outcome.text);
        }
    }

    pub(super) fn housekeeping(&mut self) {
        let is_due = self.last_housekeeping.is_none_or(|then| self.now.saturating_sub(then) >= HOUSEKEEPING);
        if !is_due {
            return;
        }
        self.last_housekeeping = Some(self.now);
        self.report();
        self.send_parameter_list();
        self.send_files();
        self.take_mission_news();
        if let Some(vehicle) = self.vehicle {
            self.ask(vehicle);
            self.check_output();
        }
        self.supervise();
        self.try_to_resume();
        self.keep_sending();
    }

    /// Sends what is due to be asked of the flight controller.
    pub(super) fn ask(&mut self, vehicle: Vehicle) {
        let own = self.own(vehicle.id);
        let Vehicle { link, id } = vehicle;
        while let Some(message) = self.streams.poll(self.now, id) {
            self.links.send(link, own, &message);
        }
        if let Some(message) = self.timesync.poll(self.driver_now, id) {
            self.links.send(link, own, &message);
        }
        while let Some(message) = self.parameters.poll(self.now, id) {
            self.links.send(link, own, &message);
        }
        while let Some(message) = self.mission.poll(self.now, own, id) {
            self.links.send(link, own, &message);
        }
        let is_free = self.mission.is_ready() || self.run.is_none();
        while let Some(message) = self.observer.fence.poll(self.now, own, id, is_free) {
            self.links.send(link, own, &message);
        }
        while let Some(message) = self.current.poll(self.now, id) {
            self.links.send(link, own, &message);
        }
        while let Some(message) = self.actions.poll(self.now, id) {
            self.links.send(link, own, &message);
        }
        self.tell_of_actions();
    }

    pub(super) fn check_output(&mut self) {
        if self.output_ready || !self.parameters.is_complete() {
            return;
        }
        self.parameters.require(&output::further_parameters(&self.parameters));
        if self.settings.output.uses_sticks() {
            self.parameters.watch(&checks::WATCHED);
        }
        if self.parameters.is_complete() {
            self.output_ready = self.configure_output();
            if self.output_ready {
                self.warn_of_parameters();
            }
        }
    }

    /// Fits the output to the vehicle's parameters; says what stands against it.
    pub(super) fn configure_output(&mut self) -> bool {
        self.watch.configure(self.failsafes_in_force());
        let (kind, system) = (self.settings.output, self.settings.ground_station_system);
        let configured = self.output.configure(&self.parameters);
        let obstacle = checks::obstacle(kind, system, &self.parameters);
        let complaint = configured.err().or(obstacle);
        self.observer.output_refused = complaint.is_some();
        match complaint {
            None => true,
            Some(text) => {
                if self.reporter.is_new_problem(&text) {
                    self.event(enums::MAV_SEVERITY_ERROR, text);
                }
                false
            }
        }
    }

    pub(super) fn warn_of_parameters(&mut self) {
        let is_twin = matches!(self.settings.boat.actuators, Actuators::TwinThrusters(_));
        for warning in checks::warnings(self.settings.output, is_twin, &self.parameters) {
            self.event(enums::MAV_SEVERITY_WARNING, warning);
        }
    }

    pub(super) fn take_mission_news(&mut self) {
        match self.mission.poll_news(self.now) {
            Some(News::Loaded(route)) => {
                // To stay for ever at the end is the flight controller's to do: it goes on without the bridge.
                let stays = route.ending == Ending::Loiter;
                self.supervisor.set_end_mode(if stays { Mode::LOITER } else { self.settings.end_mode });
                let text = format!("mission loaded: {} waypoints", route.waypoints.len());
                let speed_mps = self.usual_speed_mps();
                let settings = RunSettings { speed_mps, controller: self.settings.controller };
                let run = MissionRun::new(route, self.settings.boat.clone(), settings);
                self.event(enums::MAV_SEVERITY_INFO, text);
                self.take_up(run);
            }
            Some(News::Unusable(text)) => {
                self.run = None;
                if self.reporter.is_new_problem(&text) {
                    self.event(enums::MAV_SEVERITY_ERROR, text);
                }
            }
            Some(News::NotRead(text)) if self.reporter.is_new_problem(&text) => {
                self.event(enums::MAV_SEVERITY_WARNING, text);
            }
            Some(News::NotRead(_)) | None => {}
        }
        match self.observer.fence.poll_news(self.now) {
            Some(FenceNews::Loaded) => {
                self.event(enums::MAV_SEVERITY_INFO, "fence loaded: the bridge watches it too");
            }
            Some(FenceNews::NotRead(why)) => {
                let text = format!("the fence could not be read, so it is not watched: {why}");
                self.event(enums::MAV_SEVERITY_WARNING, text);
            }
            None => {}
        }
    }

    /// Another mission is there. One that comes under way is followed from where the boat is.
    pub(super) fn take_up(&mut self, mut run: MissionRun) {
        let under_way = matches!(self.supervisor.state(), State::Engaged | State::Holding);
        if let (Some(old), Some(position)) =
            (self.run.as_ref().filter(|_| under_way), self.telemetry.position)
        {
            let Position { place, north_mps, east_mps, .. } = position.value;
            let velocity = NorthEast::new(north_mps, east_mps);
            let underway = Underway { route: old.route(), next: old.progress().next, place, velocity };
            run.join(rejoin::next_waypoint(run.route(), &underway), place);
            let next = run.progress().next + 1;
            let text = format!("the mission has changed under way: going on with waypoint {next}");
            self.event(enums::MAV_SEVERITY_NOTICE, text);
        }
        self.run = Some(run);
        self.tell_delay();
        self.current.clear();
        self.watch.on_new_way();
        if self.supervisor.state() == State::Engaged {
            self.engage_run();
        }
    }

    /// Speed over ground where the mission does not say, m/s.
    pub(super) fn usual_speed_mps(&self) -> f64 {
        self.settings
            .speed_mps
            .or_else(|| output::full_speed_mps(&self.parameters))
            .unwrap_or(self.settings.boat.limits.cruise_mps)
    }
}
