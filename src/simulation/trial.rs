//! One run as a description: everything that decides it, so that the same description gives the same run.

use std::time::Duration;

use helmlink_mission::geodesy::Geodetic;
use helmlink_mission::plan::Mission;
use helmlink_mission::route::Route;
use helmlink_sitl::physics::{Hull, Sea, SensorSettings};
use helmlink_sitl::{Sitl, SitlError, SitlSettings};
use thiserror::Error;

use super::closed_loop::{ClosedLoop, Outcome};
use crate::bridge::{Bridge, BridgeSettings};
use crate::control::{Boat, Controller};
use crate::vehicle::OutputKind;

/// A run may take this many times as long as its distance at the wanted speed, plus [`GRACE_S`].
const PATIENCE: f64 = 3.0;
/// Time for getting ready and for the way to the first waypoint, seconds.
const GRACE_S: f64 = 300.0;

/// Why a trial cannot be run.
#[derive(Debug, Error)]
pub enum TrialError {
    /// The simulated boat refuses its settings.
    #[error(transparent)]
    Sitl(#[from] SitlError),
    /// More items than the boat stores.
    #[error("the mission is too long: the boat stores {0} items, home included")]
    TooLong(u16),
}

/// Everything that decides one run.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The controller's model, limits and gains.
    pub boat: Boat,
    /// The controller.
    pub controller: Controller,
    /// By which messages the bridge steers.
    pub output: OutputKind,
    /// Speed over ground where the mission does not say, m/s; the boat's cruising speed if not given.
    pub speed_mps: Option<f64>,
    /// Interval of the control loop, s.
    pub interval_s: f64,
    /// The simulated boat.
    pub hull: Hull,
    /// The sea.
    pub sea: Sea,
    /// The sensors.
    pub sensors: SensorSettings,
    /// Decides gusts, waves and sensor noise.
    pub seed: u64,
    /// Time that the bridge's bytes need to the boat, s.
    pub delay_s: f64,
    /// The mission.
    pub mission: Mission,
    /// Its route.
    pub route: Route,
    /// Where the boat starts.
    pub home: Geodetic,
    /// Heading there, rad.
    pub heading_rad: f64,
}

impl Trial {
    /// The simulated boat with its mission on board, and a bridge that may arm and drive it.
    ///
    /// # Errors
    /// The simulated boat refuses its settings or its mission.
    pub fn parties(&self) -> Result<(Sitl, Bridge), TrialError> {
        let settings = BridgeSettings {
            controller: self.controller,
            output: self.output,
            speed_mps: Some(self.wanted_speed_mps()),
            control_interval_s: self.interval_s,
            engage: true,
            may_arm: true,
            ..BridgeSettings::new(self.boat.clone())
        };
        let mut sitl = Sitl::new(SitlSettings {
            sea: self.sea,
            sensors: self.sensors,
            seed: self.seed,
            home: self.home,
            heading_rad: self.heading_rad,
            ..SitlSettings::new(self.hull.clone())
        })?;
        sitl.set_mission(&self.mission.items).map_err(TrialError::TooLong)?;
        Ok((sitl, Bridge::new(settings)))
    }

    /// The two of [`Self::parties`], joined.
    ///
    /// # Errors
    /// See [`Self::parties`].
    pub fn closed_loop(&self) -> Result<ClosedLoop, TrialError> {
        let (sitl, bridge) = self.parties()?;
        let delay = Duration::from_secs_f64(self.delay_s.max(0.0));
        Ok(ClosedLoop::new(sitl, bridge, self.home).with_delay(delay))
    }

    /// Runs to the end, or as long as is reasonable for this distance and speed.
    ///
    /// # Errors
    /// See [`Self::closed_loop`].
    pub fn run(&self) -> Result<Outcome, TrialError> {
        Ok(self.closed_loop()?.run(self.limit()))
    }

    /// The longest that the run may reasonably take.
    #[must_use]
    pub fn limit(&self) -> Duration {
        let points = std::iter::once(self.home).chain(self.route.waypoints.iter().map(|w| w.position));
        let points: Vec<Geodetic> = points.collect();
        let legs_m: f64 = points.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum();
        let distance_m = legs_m + self.route.circles_m();
        let hold_s: f64 = self.route.waypoints.iter().map(|w| w.hold_s).sum();
        Duration::from_secs_f64(PATIENCE * distance_m / self.wanted_speed_mps() + hold_s + GRACE_S)
    }

    fn wanted_speed_mps(&self) -> f64 {
        self.speed_mps.unwrap_or(self.boat.limits.cruise_mps)
    }
}
