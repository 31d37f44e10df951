//! From mission items to a route.

use helmlink_wire::enums::*;

use super::{Ending, MAX_DISTANCE_M, MERGE_DISTANCE_M, Route, RouteError, Waypoint};
use crate::geodesy::Geodetic;
use crate::plan::{CommandName, Item, Mission};

impl Route {
    /// What `mission` means to a boat.
    ///
    /// | command | meaning |
    /// |---|---|
    /// | NAV_WAYPOINT | go there, count it reached within parameter 2 (0: the vehicle's radius), wait parameter 1 seconds |
    /// | DO_CHANGE_SPEED | parameter 2 m/s from here on, through water and over ground alike; −1 no change, −2 the vehicle's own |
    /// | NAV_DELAY | wait parameter 1 seconds more |
    /// | NAV_LOITER_UNLIM, last | go there (0, 0: stay) and keep the position |
    /// | NAV_RETURN_TO_LAUNCH, last | go home |
    ///
    /// Yaw, altitude and autocontinue mean nothing to a boat, and ArduPilot's own boats ignore them.
    ///
    /// # Errors
    /// The first item that cannot be carried out, and what to do about it.
    pub fn from_mission(mission: &Mission) -> Result<Self, RouteError> {
        let mut reader = Reader::new(mission.home);
        for (index, item) in mission.items.iter().enumerate() {
            let number = u16::try_from(index + 1).map_err(|_| RouteError::TooLong(mission.items.len()))?;
            reader.take(number, item)?;
        }
        reader.finish()
    }
}

struct Reader {
    route: Route,
    speed_mps: Option<f64>,
    ended_by: Option<u16>,
}

impl Reader {
    fn new(home: Option<Geodetic>) -> Self {
        let home = home.filter(|home| home.is_valid());
        let route = Route { home, start_delay_s: 0.0, waypoints: Vec::new(), ending: Ending::Hold };
        Self { route, speed_mps: None, ended_by: None }
    }

    fn take(&mut self, number: u16, item: &Item) -> Result<(), RouteError> {
        let here = Here { number, item };
        if let Some(last) = self.ended_by {
            return Err(RouteError::AfterTheEnd { item: number, command: here.command(), last });
        }
        match item.command {
            MAV_CMD_NAV_WAYPOINT => self.waypoint(here),
            MAV_CMD_DO_CHANGE_SPEED => self.change_speed(here),
            MAV_CMD_NAV_DELAY => self.delay(here),
            MAV_CMD_NAV_LOITER_UNLIM => self.loiter(here),
            MAV_CMD_NAV_RETURN_TO_LAUNCH => self.return_to_launch(here),
            _ => Err(RouteError::Unsupported { item: number, command: here.command() }),
        }
    }

    fn finish(self) -> Result<Route, RouteError> {
        if self.route.waypoints.is_empty() { Err(RouteError::NoWaypoint) } else { Ok(self.route) }
    }

    fn waypoint(&mut self, here: Here<'_>) -> Result<(), RouteError> {
        let waypoint = Waypoint {
            item: here.number,
            position: here.position()?,
            acceptance_radius_m: Some(here.duration_or_length(1, "the acceptance radius")?)
                .filter(|radius_m| *radius_m > 0.0),
            hold_s: here.duration_or_length(0, "the hold time")?,
            speed_mps: self.speed_mps,
        };
        self.push(waypoint)
    }

    fn change_speed(&mut self, here: Here<'_>) -> Result<(), RouteError> {
        let [kind, speed_mps, ..] = here.item.params;
        let kinds = [SPEED_TYPE_AIRSPEED, SPEED_TYPE_GROUNDSPEED].map(f32::from);
        if !kinds.contains(&kind) {
            return Err(here.fault("the speed type", kind, "0 or 1: a boat has no climb or descent speed"));
        }
        if speed_mps > 0.0 && speed_mps.is_finite() {
            self.speed_mps = Some(f64::from(speed_mps));
        } else if speed_mps == USE_DEFAULT_SPEED {
            self.speed_mps = None;
        } else if speed_mps != KEEP_SPEED {
            let expected = "a speed above 0 m/s (−1 keeps the speed, −2 is the vehicle's own)";
            return Err(here.fault("the speed", speed_mps, expected));
        }
        Ok(())
    }

    fn delay(&mut self, here: Here<'_>) -> Result<(), RouteError> {
        if here.item.params[0] < 0.0 {
            let expected = "seconds to wait: delays until a time of day are not supported";
            return Err(here.fault("the delay", here.item.params[0], expected));
        }
        let delay_s = here.duration_or_length(0, "the delay")?;
        match self.route.waypoints.last_mut() {
            Some(waypoint) => waypoint.hold_s += delay_s,
            None => self.route.start_delay_s += delay_s,
        }
        Ok(())
    }

    fn loiter(&mut self, here: Here<'_>) -> Result<(), RouteError> {
        self.end(here.number, Ending::Loiter);
        let is_here = here.item.x == 0 && here.item.y == 0;
        if is_here && !self.route.waypoints.is_empty() {
            return Ok(());
        }
        let position = here.position()?;
        self.push(self.plain_waypoint(here.number, position))
    }

    fn return_to_launch(&mut self, here: Here<'_>) -> Result<(), RouteError> {
        self.end(here.number, Ending::ReturnToLaunch);
        let home = self.route.home.ok_or(RouteError::NoHome { item: here.number })?;
        self.push(self.plain_waypoint(here.number, home))
    }

    fn end(&mut self, number: u16, ending: Ending) {
        self.ended_by = Some(number);
        self.route.ending = ending;
    }

    fn plain_waypoint(&self, item: u16, position: Geodetic) -> Waypoint {
        Waypoint { item, position, acceptance_radius_m: None, hold_s: 0.0, speed_mps: self.speed_mps }
    }

    /// Adds a waypoint, or merges it with the last when that is at the same place.
    fn push(&mut self, waypoint: Waypoint) -> Result<(), RouteError> {
        self.check_distance(&waypoint)?;
        match self.route.waypoints.last_mut() {
            Some(last) if last.position.distance_m(waypoint.position) < MERGE_DISTANCE_M => {
                last.item = waypoint.item;
                last.hold_s += waypoint.hold_s;
                last.acceptance_radius_m = smaller(last.acceptance_radius_m, waypoint.acceptance_radius_m);
            }
            _ => self.route.waypoints.push(waypoint),
        }
        Ok(())
    }

    fn check_distance(&self, waypoint: &Waypoint) -> Result<(), RouteError> {
        let first = self.route.waypoints.first().map(|first| (first.position, "the first waypoint"));
        let Some((reference, from)) = self.route.home.map(|home| (home, "home")).or(first) else {
            return Ok(());
        };
        let distance_m = reference.distance_m(waypoint.position);
        if distance_m > MAX_DISTANCE_M {
            return Err(RouteError::TooFar { item: waypoint.item, distance_km: distance_m / 1e3, from });
        }
        Ok(())
    }
}

/// Speeds of MAV_CMD_DO_CHANGE_SPEED with a meaning of their own.
const KEEP_SPEED: f32 = -1.0;
const USE_DEFAULT_SPEED: f32 = -2.0;

/// The item being read.
#[derive(Clone, Copy)]
struct Here<'a> {
    number: u16,
    item: &'a Item,
}

impl Here<'_> {
    fn command(&self) -> CommandName {
        CommandName(self.item.command)
    }

    fn position(&self) -> Result<Geodetic, RouteError> {
        let [latitude_deg, longitude_deg] = self.item.coordinates();
        self.item.position().ok_or(RouteError::NoPosition {
            item: self.number,
            command: self.command(),
            frame: self.item.frame,
            latitude_deg,
            longitude_deg,
        })
    }

    /// A parameter of seconds or metres, NaN meaning 0.
    fn duration_or_length(&self, index: usize, parameter: &'static str) -> Result<f64, RouteError> {
        let value = self.item.params[index];
        if value.is_nan() {
            Ok(0.0)
        } else if value.is_finite() && value >= 0.0 {
            Ok(f64::from(value))
        } else {
            Err(self.fault(parameter, value, "a number from 0 up"))
        }
    }

    fn fault(&self, parameter: &'static str, value: f32, expected: &'static str) -> RouteError {
        RouteError::Parameter { item: self.number, command: self.command(), parameter, value, expected }
    }
}

fn smaller(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}
