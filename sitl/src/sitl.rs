//! The whole boat: autopilot and physics in step.

use std::collections::VecDeque;
use std::time::Duration;

use helmlink_mission::geodesy::{Geodetic, PositionFault};
use helmlink_mission::plan::Item;
use helmlink_wire::LinkId;

use crate::autopilot::{Autopilot, AutopilotSettings, LOOP};
use crate::clock::ClockOrder;
use crate::faults::{Fault, FaultError, Lines, LinkWeather, Schedule, TimedFault, Turn};
use crate::physics::sea::{Current, Wind};
use crate::physics::{Estimate, Hull, Pose, STEP_S, Sea, SensorSettings, Truth, Vessel};
use crate::scenario::{Observation, Play, Scenario, Verdict};

/// Physics steps per loop of the autopilot.
const STEPS_PER_LOOP: u32 = 2;

/// Packets from bad lines that wait to be taken; what exceeds it is lost.
const MAX_OUTBOX: usize = 20_000;

/// What is simulated. Same settings, same run.
#[derive(Debug, Clone, PartialEq)]
pub struct SitlSettings {
    /// The boat.
    pub hull: Hull,
    /// Current, wind and waves.
    pub sea: Sea,
    /// How good the sensors are.
    pub sensors: SensorSettings,
    /// Decides gusts, waves and sensor noise.
    pub seed: u64,
    /// Where the boat lies at the start.
    pub home: Geodetic,
    /// Its heading there, clockwise from north, rad.
    pub heading_rad: f64,
    /// Whether the boat is held at its place until it is first armed, so that no current carries it off
    /// while the user gets ready (ArduPilot's simulator has no current before arming either).
    pub moored_until_armed: bool,
    /// The autopilot.
    pub autopilot: AutopilotSettings,
}

impl SitlSettings {
    /// A boat in calm water with perfect sensors, heading north in the harbour basin of Trondheim.
    pub fn new(hull: Hull) -> Self {
        Self {
            hull,
            sea: Sea::default(),
            sensors: SensorSettings::perfect(),
            seed: 1,
            home: Geodetic::new(63.4406, 10.4022),
            heading_rad: 0.0,
            moored_until_armed: true,
            autopilot: AutopilotSettings::default(),
        }
    }
}

/// Why a boat cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SitlError {
    /// The start is nowhere on the globe.
    #[error("the boat cannot start at home: {0}")]
    Home(PositionFault),
    /// A heading that is no angle.
    #[error("the heading at the start is {0} rad: it must be a finite number")]
    Heading(f64),
    /// A parameter that the autopilot does not take.
    #[error("parameter {name} cannot be set to {value}: {cause}")]
    Parameter {
        /// Its name.
        name: String,
        /// The value asked for.
        value: f32,
        /// What is wrong.
        cause: String,
    },
}

/// Why a scenario cannot be played with this boat.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlayError {
    /// A fault that it cannot have.
    #[error(transparent)]
    Fault(#[from] FaultError),
    /// A parameter that it does not have.
    #[error("the scenario sets the parameter `{0}`, which the autopilot does not have")]
    NoSuchParameter(String),
}

/// A simulated boat with an ArduRover-like autopilot.
///
/// The owner opens links, hands in the bytes that arrive on them, advances the simulated time and takes out
/// what is to be sent:
///
/// ```
/// use std::time::Duration;
/// use helmlink_sitl::{Sitl, SitlSettings, physics::Hull};
/// use helmlink_wire::LinkId;
///
/// let mut boat = Sitl::new(SitlSettings::new(Hull::builtin("otter")?))?;
/// boat.link_up(LinkId(1));
/// boat.advance(Duration::from_secs(1));
/// let (link, bytes) = boat.poll_transmit().ok_or("a heartbeat is due every second")?;
/// assert_eq!((link, bytes[0]), (LinkId(1), 0xFD));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Sitl {
    pub(crate) autopilot: Autopilot,
    pub(crate) vessel: Vessel,
    now: Duration,
    /// Whether the boat waits at its moorings to be armed.
    moored: bool,
    schedule: Schedule,
    lines: Lines,
    weather: LinkWeather,
    /// What has come out of bad lines.
    outbox: VecDeque<(LinkId, Vec<u8>)>,
    /// The parameters' revision that the faults were last read from, and what they said of tide and wind.
    faults_of: Option<u64>,
    sea_parameters: [f64; 4],
    play: Option<Box<Play>>,
    /// Whether the boat starts by itself as soon as it can.
    starts_itself: bool,
}

impl Sitl {
    /// A boat at its start, the autopilot just switched on. Takes some milliseconds: the autopilot is tuned
    /// to the hull by a short trial.
    ///
    /// # Errors
    /// [`SitlError`] if the settings make no sense; the physics' own settings were checked when they were
    /// made.
    pub fn new(settings: SitlSettings) -> Result<Self, SitlError> {
        settings.home.check().map_err(SitlError::Home)?;
        if !settings.heading_rad.is_finite() {
            return Err(SitlError::Heading(settings.heading_rad));
        }
        let pose = Pose { psi_rad: settings.heading_rad, ..Pose::default() };
        let autopilot = Autopilot::new(settings.autopilot, &settings.hull, settings.home)?;
        let mut vessel = Vessel::new(settings.hull, &settings.sea, &settings.sensors, settings.seed, pose);
        vessel.set_moored(settings.moored_until_armed);
        let mut sitl = Self {
            autopilot,
            vessel,
            now: Duration::ZERO,
            moored: settings.moored_until_armed,
            schedule: Schedule::default(),
            lines: Lines::new(settings.seed),
            weather: LinkWeather::default(),
            outbox: VecDeque::new(),
            faults_of: None,
            sea_parameters: [0.0; 4],
            play: None,
            starts_itself: false,
        };
        sitl.autopilot.put_gps_rate(settings.sensors.noise.map_or(5.0, |noise| noise.gps_rate_hz));
        sitl.autopilot.put_sea(&settings.sea);
        sitl.sea_parameters = sitl.autopilot.sea_parameters();
        sitl.autopilot.sense(sitl.vessel.estimate(), sitl.vessel.truth().hull, Duration::ZERO);
        Ok(sitl)
    }

    /// Opens a link. `false` if there are too many; bytes on it are then ignored.
    pub fn link_up(&mut self, link: LinkId) -> bool {
        self.autopilot.link_up(link)
    }

    /// Closes a link: its rates, its transfers and what waits to be sent on it are forgotten.
    pub fn link_down(&mut self, link: LinkId) {
        self.autopilot.link_down(link);
        self.lines.forget(link);
        self.outbox.retain(|(to, _)| *to != link);
    }

    /// Bytes of a stream that arrive now. They are acted upon in the next loop.
    pub fn on_bytes(&mut self, link: LinkId, bytes: &[u8]) {
        self.receive(link, bytes, false);
    }

    /// A datagram that arrives now: as [`Sitl::on_bytes`], but no frame goes on in the next one.
    pub fn on_datagram(&mut self, link: LinkId, bytes: &[u8]) {
        self.receive(link, bytes, true);
    }

    fn receive(&mut self, link: LinkId, bytes: &[u8], datagram: bool) {
        if self.lines.carries(link, &self.weather) {
            self.lines.take_in(link, bytes, self.now, &self.weather);
        } else {
            self.autopilot.on_bytes(link, bytes, datagram);
        }
    }

    /// Lets simulated time pass, in loops of 20 ms: all that end at or before `until`. Each loop reads what
    /// has arrived, steers, moves the boat, and sends what is due.
    pub fn advance(&mut self, until: Duration) {
        while self.now + LOOP <= until {
            if !self.autopilot.clock.may_run() {
                self.autopilot.serve();
            }
            if !self.autopilot.clock.may_run() {
                break;
            }
            self.run_loop();
        }
    }

    /// While time is held: answers what clients have asked and takes their orders; no time passes.
    pub fn serve(&mut self) {
        self.autopilot.serve();
    }

    /// Stops time (true) or lets it pass again (false). While it stands, [`Sitl::advance`] only answers what
    /// clients ask.
    pub fn set_paused(&mut self, paused: bool) {
        let order = if paused { ClockOrder::Pause } else { ClockOrder::Resume };
        self.autopilot.clock.obey(LinkId(0), order, self.now);
    }

    /// Runs one loop of 20 ms with time stopped before and after.
    pub fn step(&mut self) {
        self.set_paused(true);
        self.run_loop();
    }

    /// Whether time stands because somebody has paused it.
    pub fn is_paused(&self) -> bool {
        self.autopilot.clock.is_paused()
    }

    /// Whether time cannot pass now: it is paused, or a client in lockstep has not answered.
    pub fn is_held(&self) -> bool {
        !self.autopilot.clock.may_run()
    }

    /// The clients in lockstep that time waits for.
    pub fn waits_for(&self) -> Vec<LinkId> {
        self.autopilot.clock.waits_for()
    }

    /// No longer waits for a client in lockstep.
    pub fn leave_lockstep(&mut self, link: LinkId) {
        self.autopilot.clock.forget(link);
    }

    /// From now on time passes by `beat` at the most until the client on `link` has answered: it gets
    /// SYSTEM_TIME after each beat, and sends the same message back when it is done with all up to then.
    pub fn join_lockstep(&mut self, link: LinkId, beat: Duration) {
        self.autopilot.clock.obey(link, ClockOrder::Join(beat), self.now);
    }

    /// The multiple of real time that the parameter SIM_SPEEDUP asks for; 0 is as fast as it goes. It is up to
    /// the owner to keep that pace.
    pub fn speedup(&self) -> f64 {
        self.autopilot.speedup()
    }

    /// Shows ground stations the pace.
    pub fn set_speedup(&mut self, speedup: f64) {
        self.autopilot.put_speedup(speedup);
    }

    /// Puts a scenario on; its clock starts with the next loop, or with arming. An earlier one is over.
    ///
    /// # Errors
    /// [`FaultError`] if the boat lacks the part that is to fail, or a parameter is not known.
    pub fn play(&mut self, scenario: Scenario) -> Result<(), PlayError> {
        for fault in scenario.faults() {
            self.check_fault(fault)?;
        }
        if let Some(name) = scenario.parameters().find(|name| !self.autopilot.has_parameter(name)) {
            return Err(PlayError::NoSuchParameter(name.to_owned()));
        }
        self.play = Some(Box::new(Play::new(scenario)));
        Ok(())
    }

    /// What has become of the scenario's expectations; none without a scenario.
    pub fn verdicts(&self) -> &[Verdict] {
        self.play.as_ref().map_or(&[], |play| play.verdicts())
    }

    /// Whether the scenario is over; false without one.
    pub fn is_scenario_over(&self) -> bool {
        self.play.as_ref().is_some_and(|play| play.is_over())
    }

    /// Ends the scenario now: what is open is decided by how things stand.
    pub fn end_scenario(&mut self) {
        if let Some(mut play) = self.play.take() {
            play.end(self);
            self.play = Some(play);
        }
    }

    /// How things stand.
    pub fn observe(&self) -> Observation {
        self.autopilot.observe()
    }

    /// The sea as it was asked for.
    pub fn sea(&self) -> &Sea {
        self.vessel.sea()
    }

    /// Changes the sea from now on.
    pub fn set_sea(&mut self, sea: Sea) {
        self.vessel.set_sea(&sea);
        self.autopilot.put_sea(&sea);
        self.sea_parameters = self.autopilot.sea_parameters();
    }

    /// Names and values of the parameters that were changed by users, faults and the simulator's own left out:
    /// what a file of parameters is to keep.
    pub fn changed_parameters(&self) -> Vec<(String, f32)> {
        self.autopilot.changed_parameters()
    }

    /// A number that changes whenever a parameter does.
    pub fn parameter_revision(&self) -> u64 {
        self.autopilot.parameter_revision()
    }

    fn run_loop(&mut self) {
        self.starts_itself = self.starts_itself && !self.autopilot.start();
        if let Some(mut play) = self.play.take() {
            play.step(self);
            self.play = Some(play);
        }
        self.turn_faults();
        for (link, bytes) in self.lines.arriving(self.now) {
            self.autopilot.on_bytes(link, &bytes, true);
        }
        let command = self.autopilot.control(self.now);
        if self.moored && self.autopilot.is_armed() {
            self.moored = false;
            self.vessel.set_moored(false);
        }
        for _ in 0..STEPS_PER_LOOP {
            self.vessel.step(STEP_S, command);
        }
        self.now += LOOP;
        self.autopilot.sense(self.vessel.estimate(), self.vessel.truth().hull, self.now);
        self.autopilot.transmit();
        self.send_over_bad_lines();
    }

    /// Begins and ends scheduled faults, and puts into force what the parameters say.
    fn turn_faults(&mut self) {
        while let Some(turn) = self.schedule.due(self.now) {
            match turn {
                Turn::Begin(fault) => self.autopilot.put_fault(&fault),
                Turn::End(fault) => self.autopilot.lift_fault(&fault),
            }
        }
        let revision = self.autopilot.parameter_revision();
        if self.faults_of != Some(revision) {
            self.faults_of = Some(revision);
            self.vessel.set_faults(self.autopilot.vessel_faults());
            self.vessel.set_gps_rate(self.autopilot.gps_rate_hz());
            self.weather = self.autopilot.link_weather();
            self.turn_sea();
        }
    }

    /// Tide and wind follow their parameters.
    fn turn_sea(&mut self) {
        let wanted = self.autopilot.sea_parameters();
        if wanted == self.sea_parameters {
            return;
        }
        self.sea_parameters = wanted;
        let [tide_mps, tide_from_deg, wind_mps, wind_from_deg] = wanted;
        let mut sea = *self.vessel.sea();
        let current = sea.current.unwrap_or(Current { speed_mps: 0.0, toward_deg: 0.0, variability: 0.0 });
        let wind = sea.wind.unwrap_or(Wind { speed_mps: 0.0, from_deg: 0.0, gustiness: 0.0 });
        let toward_deg = (tide_from_deg + 180.0).rem_euclid(360.0);
        sea.current = (tide_mps > 0.0).then_some(Current { speed_mps: tide_mps, toward_deg, ..current });
        sea.wind = (wind_mps > 0.0).then_some(Wind { speed_mps: wind_mps, from_deg: wind_from_deg, ..wind });
        self.vessel.set_sea(&sea);
    }

    /// Takes what is to be sent on bad lines from the autopilot, and what arrives over them.
    fn send_over_bad_lines(&mut self) {
        for link in self.autopilot.links() {
            if self.lines.carries(link, &self.weather) {
                while let Some(bytes) = self.autopilot.poll_transmit_on(link) {
                    self.lines.take_out(link, &bytes, self.now, &self.weather);
                }
            }
        }
        for arrived in self.lines.leaving(self.now) {
            if self.outbox.len() < MAX_OUTBOX {
                self.outbox.push_back(arrived);
            }
        }
    }

    /// The next bytes to send, whole frames, at most 1400 bytes at a time. What is not taken for long is
    /// dropped: at most 256 KiB wait for a link and 1 MiB for all of them, answers longest.
    pub fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.outbox.pop_front().or_else(|| self.autopilot.poll_transmit())
    }

    /// Bytes that were dropped because nobody took them.
    pub fn lost_bytes(&self) -> u64 {
        self.autopilot.lost_bytes()
    }

    /// Simulated time since the start.
    pub fn now(&self) -> Duration {
        self.now
    }

    /// What really happens to the boat, in metres from home.
    pub fn truth(&self) -> Truth {
        self.vessel.truth()
    }

    /// What the flight controller knows of it, in metres from home.
    pub fn estimate(&self) -> Estimate {
        self.vessel.estimate()
    }

    /// The boat.
    pub fn hull(&self) -> &Hull {
        self.vessel.hull()
    }

    /// Whether the motors are armed.
    pub fn is_armed(&self) -> bool {
        self.autopilot.is_armed()
    }

    /// Makes something fail from the next loop on, in place of an earlier fault of the same kind.
    ///
    /// # Errors
    /// [`FaultError`] if a figure is out of its range, or the boat has no such part.
    pub fn inject(&mut self, fault: Fault) -> Result<(), FaultError> {
        self.check_fault(&fault)?;
        self.autopilot.put_fault(&fault);
        Ok(())
    }

    /// Repairs what a fault of this kind has done; its figures do not matter.
    pub fn lift(&mut self, fault: &Fault) {
        self.autopilot.lift_fault(fault);
    }

    /// Makes something fail at a time to come, and repairs it if the fault has an end.
    ///
    /// # Errors
    /// As [`Sitl::inject`].
    pub fn schedule(&mut self, timed: TimedFault) -> Result<(), FaultError> {
        self.check_fault(&timed.fault)?;
        self.schedule.add(timed);
        Ok(())
    }

    fn check_fault(&self, fault: &Fault) -> Result<(), FaultError> {
        fault.check()?;
        match fault.missing_part(self.hull().has_twin_thrusters()) {
            None => Ok(()),
            Some(part) => {
                let boat = self.hull().name.clone();
                Err(FaultError::NoSuchPart { fault: fault.to_string(), boat, part })
            }
        }
    }

    /// Arms the boat and starts its mission, or has it keep its place if there is none. False while it is not
    /// ready for that; try again later.
    pub fn start(&mut self) -> bool {
        self.autopilot.start()
    }

    /// Has the boat do as [`Sitl::start`] in the first loop in which it can.
    pub fn start_when_ready(&mut self) {
        self.starts_itself = true;
    }

    /// Stores a mission as if it had been uploaded; `items` are without home.
    ///
    /// # Errors
    /// The number of items that can be stored, home included, if there are more.
    pub fn set_mission(&mut self, items: &[Item]) -> Result<(), u16> {
        self.autopilot.set_mission(items)
    }
}

#[cfg(test)]
mod tests {
    use helmlink_wire::Framer;

    use super::*;

    fn boat(change: impl FnOnce(&mut SitlSettings)) -> Result<Sitl, SitlError> {
        let mut settings = SitlSettings::new(Hull::builtin("otter").unwrap());
        change(&mut settings);
        Sitl::new(settings)
    }

    fn sent(boat: &mut Sitl) -> Vec<u8> {
        let mut all = Vec::new();
        while let Some((_, bytes)) = boat.poll_transmit() {
            all.extend(bytes);
        }
        all
    }

    #[test]
    fn settings_that_make_no_sense_are_refused_by_name() {
        let home = boat(|settings| settings.home = Geodetic::new(95.0, 0.0));
        assert!(matches!(home, Err(SitlError::Home(_))));
        assert!(matches!(boat(|settings| settings.heading_rad = f64::NAN), Err(SitlError::Heading(_))));
        let unknown = boat(|settings| settings.autopilot.parameters = vec![("NO_SUCH".into(), 1.0)]);
        assert!(unknown.unwrap_err().to_string().contains("NO_SUCH"));
        assert!(boat(|settings| settings.autopilot.parameters = vec![("WP_SPEED".into(), 1.2)]).is_ok());
    }

    #[test]
    fn loops_run_only_when_they_end_in_time() {
        let mut boat = boat(|_| {}).unwrap();
        boat.advance(Duration::from_millis(59));
        assert_eq!(boat.now(), Duration::from_millis(40));
        boat.advance(Duration::from_millis(10));
        assert_eq!(boat.now(), Duration::from_millis(40), "time does not run back");
    }

    #[test]
    fn the_same_settings_and_bytes_give_the_same_bytes_in_any_portions() {
        let run = |portion_ms: u64| {
            let mut boat = boat(|settings| settings.sensors = SensorSettings::typical()).unwrap();
            boat.link_up(LinkId(1));
            let mut bytes = Vec::new();
            for end in (0..=6000).step_by(portion_ms as usize) {
                boat.advance(Duration::from_millis(end));
                bytes.extend(sent(&mut boat));
            }
            bytes
        };
        let reference = run(20);
        assert!(reference.len() > 1000);
        assert_eq!(run(20), reference);
        assert_eq!(run(200), reference);
        assert_eq!(run(1000), reference);
    }

    #[test]
    fn a_current_waits_until_the_boat_is_armed() {
        let current = Some("0.5@90".parse().unwrap());
        let mut boat = boat(|settings| settings.sea = Sea { current, ..Sea::default() }).unwrap();
        boat.advance(Duration::from_secs(10));
        assert!(boat.truth().hull.east_m.abs() < 1e-9);
        assert!(boat.autopilot.arm(false));
        boat.advance(Duration::from_secs(20));
        assert!(boat.truth().hull.east_m > 4.0, "{:?}", boat.truth());
    }

    #[test]
    fn whoever_comes_hears_a_heartbeat_within_a_second() {
        let mut boat = boat(|_| {}).unwrap();
        for (number, comes_at_ms) in [(1, 0), (2, 2020), (3, 5980)] {
            let (link, comes_at) = (LinkId(number), Duration::from_millis(comes_at_ms));
            boat.advance(comes_at);
            boat.link_up(link);
            while boat.poll_transmit().is_some() {}
            let heard = (1..=51).find(|loops| {
                boat.advance(comes_at + LOOP * *loops);
                let mut framer = Framer::new();
                while let Some((to, bytes)) = boat.poll_transmit() {
                    if to == link {
                        framer.push(&bytes);
                    }
                }
                std::iter::from_fn(|| framer.next_frame().map(|frame| frame.message_id())).any(|id| id == 0)
            });
            assert!(heard.is_some_and(|loops| loops <= 50), "{heard:?} loops after {comes_at:?}");
        }
    }

    #[test]
    fn unknown_links_are_ignored() {
        let mut boat = boat(|_| {}).unwrap();
        boat.on_bytes(LinkId(9), &[0xFD, 1, 2, 3]);
        boat.link_down(LinkId(9));
        boat.advance(Duration::from_secs(1));
        assert!(boat.poll_transmit().is_none());
    }
}
