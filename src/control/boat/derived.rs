//! A boat about which little is known: a boat file from its length, top speed, turning circle and loop delay.
//!
//! The rule is Froude's: what a hull does in a second a larger one does in √(length) as many. Its constants were
//! fitted to the boats that come with Helmlink (the Otter of 2 m and the ship of 38 m); the gains follow the tuning
//! table of `docs/controller.md`. Forces are in units of the boat's mass: only their effect is known.

use super::{Boat, BoatError};

/// What an owner can measure with a GPS and a watch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Particulars {
    /// Length of the hull, m.
    pub length_m: f64,
    /// Speed through the water at full throttle, m/s.
    pub top_speed_mps: f64,
    /// Diameter of the circle at full steering and half throttle, m.
    pub turning_circle_m: f64,
    /// From a command to its effect: transport, autopilot and servo, s.
    pub delay_s: f64,
}

/// Surge time constant at half of the top speed over √length, s/√m.
const SURGE_TIME: f64 = 0.9;
/// Yaw time constant over √length, s/√m: how soon full steering brings a hull to the rate of its circle. It is the Otter's,
/// the quickest of the boats that come with Helmlink: of a hull that is slower the loop is softer, of one that is quicker
/// it would ring.
const YAW_TIME: f64 = 0.15;
/// Sway time constant over √length, s/√m.
const SWAY_TIME: f64 = 0.5;
/// Sway mass over surge mass: the mean of the boats that come with Helmlink.
const SWAY_MASS: f64 = 1.5;
/// Largest yaw reaching gain times √length, √m/s.
const MOST_REACHING: f64 = 3.0;
/// Time constant of the yaw command filter in those of the hull: shorter, the noise of the wanted turn steers.
const FILTER_PART: f64 = 2.0;
/// Total yaw gain times delay; half a second of comfort.
const GAIN_TIMES_DELAY: f64 = 0.6;
/// Bandwidth of the observer times the yaw time constant: quick, because the model is only a guess.
const OBSERVER_PART: f64 = 4.0;
/// The largest yaw rate that is asked for, as a part of what full steering gives at cruising speed.
const YAW_RATE_PART: f64 = 0.7;

impl Boat {
    /// A boat by rule.
    ///
    /// # Errors
    /// Names the value that makes no sense of a boat.
    pub fn derived(name: &str, particulars: &Particulars) -> Result<Self, BoatError> {
        Self::from_toml(&Self::derived_file(name, particulars)?)
    }

    /// The text of its boat file, to be kept and refined.
    ///
    /// # Errors
    /// Names the value that makes no sense of a boat.
    pub fn derived_file(name: &str, particulars: &Particulars) -> Result<String, BoatError> {
        let Particulars { length_m, top_speed_mps, turning_circle_m, delay_s } = *particulars;
        super::ranges::check(&[
            ("length", length_m, 0.3, 200.0, "length of the hull, m"),
            ("top-speed", top_speed_mps, 0.2, 30.0, "speed at full throttle, m/s"),
            ("turning-circle", turning_circle_m, 0.1, 5000.0, "diameter at full steering, m"),
            ("delay", delay_s, 0.0, 2.0, "from a command to its effect, s"),
        ])?;
        let rule = Rule::new(particulars);
        let head = format!(
            "# By rule, from length {length_m} m, top speed {top_speed_mps} m/s, turning circle {turning_circle_m} m,\n\
             # delay {delay_s} s. Forces are per kilogram: only their effect is known. Refine with helmlink tune.\n\
             name = {name:?}\ndescription = \"by rule, from length, top speed and turning circle\"\n"
        );
        Ok([head, rule.hull(), rule.actuators(), rule.limits(), rule.guidance(), rule.surge(), rule.yaw()]
            .join("\n"))
    }
}

/// What follows from the particulars.
struct Rule {
    particulars: Particulars,
    cruise_mps: f64,
    /// Time constants.
    surge_s: f64,
    yaw_s: f64,
    sway_s: f64,
    /// Full thrust, N per kg.
    full_n: f64,
    rate_max: f64,
    reaching: f64,
}

impl Rule {
    fn new(particulars: &Particulars) -> Self {
        let root = particulars.length_m.sqrt();
        let cruise_mps = 0.5 * particulars.top_speed_mps;
        let (surge_s, yaw_s) = (SURGE_TIME * root, YAW_TIME * root);
        Self {
            particulars: *particulars,
            cruise_mps,
            surge_s,
            yaw_s,
            sway_s: SWAY_TIME * root,
            full_n: drag(surge_s, cruise_mps) * particulars.top_speed_mps.powi(2),
            rate_max: YAW_RATE_PART * 2.0 * cruise_mps / particulars.turning_circle_m,
            // The servo and the hull's own lag count as part of the delay.
            reaching: (GAIN_TIMES_DELAY / (particulars.delay_s + 0.15 * yaw_s)).min(MOST_REACHING / root),
        }
    }

    fn filter_s(&self) -> f64 {
        (FILTER_PART * self.yaw_s).max(0.1)
    }

    fn heading_gain(&self) -> f64 {
        0.5 * self.reaching
    }

    /// As long as the boat needs it, and as its heading loop can follow.
    fn lead_m(&self) -> f64 {
        (1.7 * self.particulars.length_m).max(1.25 * self.cruise_mps / self.heading_gain())
    }

    fn hull(&self) -> String {
        let inertia = self.particulars.length_m.powi(2) / 16.0;
        format!(
            "[hull]\nm11_kg = 1.0\nm22_kg = {SWAY_MASS:?}\nm33_kgm2 = {inertia:?}\n\
             surge_damping = [0.0, {:?}, 0.0]\nsway_damping = [{:?}, 0.0, 0.0]\nyaw_damping = [{:?}, 0.0, 0.0]\n",
            drag(self.surge_s, self.cruise_mps),
            SWAY_MASS / self.sway_s,
            inertia / self.yaw_s
        )
    }

    fn actuators(&self) -> String {
        let root = self.particulars.length_m.sqrt();
        format!(
            "[actuators]\nkind = \"turning_circle\"\n\
             thrust = {{ ahead_n = {:?}, astern_n = {:?}, exponent = 2.0 }}\ndiameter_m = {:?}\n\
             angle_max_rad = 0.6\nsteering_slew_per_s = {slew:?}\nthrottle_slew_per_s = {slew:?}\nlag_s = {:?}\n\
             kick_below_mps = {:?}\nkick_part = 0.2\n",
            self.full_n,
            0.5 * self.full_n,
            self.particulars.turning_circle_m,
            0.1 * root,
            0.2 * self.cruise_mps,
            slew = 4.0 / root,
        )
    }

    fn limits(&self) -> String {
        let Particulars { length_m, top_speed_mps, turning_circle_m, .. } = self.particulars;
        format!(
            "[limits]\ncruise_mps = {:?}\nturn_radius_m = {:?}\nspeed_max_mps = {:?}\nsteerage_mps = {:?}\n\
             yaw_rate_max_radps = {:?}\nturn_rate_radps = {:?}\nlateral_acceleration_mps2 = 0.5\n\
             deceleration_mps2 = {:?}\n",
            self.cruise_mps,
            (1.2 * turning_circle_m).max(2.0 * length_m),
            0.9 * top_speed_mps,
            0.15 * self.cruise_mps,
            self.rate_max,
            0.65 * self.rate_max,
            0.15 * self.cruise_mps / self.surge_s,
        )
    }

    fn guidance(&self) -> String {
        let (lead_m, cruise_mps) = (self.lead_m(), self.cruise_mps);
        format!(
            "[observer]\nnoise_radps = {:?}\nnoise_mps = {:?}\nturn_bandwidth_radps = {:?}\n\
             move_bandwidth_radps = {:?}\n\n[guidance]\nlead_m = {lead_m:?}\nlead_time_s = 0.0\n\
             lead_softness_m = {:?}\ndrift_time_s = {:?}\npreview_s = {:?}\nspeed_preview_s = {:?}\n\
             creep_mps = {:?}\n",
            0.15 * self.rate_max,
            0.04 * cruise_mps,
            OBSERVER_PART / self.yaw_s,
            OBSERVER_PART / self.yaw_s,
            3.0 * lead_m,
            0.8 * lead_m / cruise_mps,
            self.filter_s() + 0.2 * self.yaw_s,
            0.3 * self.surge_s,
            0.15 * cruise_mps,
        )
    }

    fn surge(&self) -> String {
        let (surge_s, cruise_mps) = (self.surge_s, self.cruise_mps);
        format!(
            "[control]\nheading_gain = {:?}\n\n[control.surge]\nfilter_s = {:?}\nacceleration_max = {:?}\n\
             reaching_gain = {:?}\nintegral_slope = {:?}\nboundary = {:?}\ndisturbance_max = {:?}\n\
             disturbance_rate = 0.3\ndisturbance_leak = 0.05\nparameter_rate = 0.03\nparameter_leak = 0.005\n\
             dead_zone = {:?}\nintegral_max = {:?}\ndamping_at_command = 0.0\ntypical_rate = {cruise_mps:?}\n",
            self.heading_gain(),
            0.8 * surge_s,
            0.5 * cruise_mps / surge_s,
            0.4 / surge_s,
            0.2 / surge_s,
            0.15 * cruise_mps,
            0.2 * self.full_n,
            0.02 * cruise_mps,
            2.0 * cruise_mps,
        )
    }

    fn yaw(&self) -> String {
        let (rate_max, reaching) = (self.rate_max, self.reaching);
        format!(
            "[control.yaw]\nfilter_s = {:?}\nacceleration_max = {:?}\nreaching_gain = {reaching:?}\n\
             integral_slope = {:?}\nboundary = {rate_max:?}\ndisturbance_max = {:?}\ndisturbance_rate = 0.5\n\
             disturbance_leak = 0.05\nparameter_rate = 0.05\nparameter_leak = 0.005\ndead_zone = {:?}\n\
             integral_max = 0.8\ndamping_at_command = 1.0\ntypical_rate = {:?}\n",
            self.filter_s(),
            2.0 * rate_max / self.yaw_s,
            0.35 * reaching,
            0.3 * rate_max / self.yaw_s,
            0.06 * rate_max,
            0.5 * rate_max,
        )
    }
}

/// Drag d of a mass of one, N/(m/s)²: the slope of d|u|u at cruising speed is one over the time constant.
fn drag(surge_s: f64, cruise_mps: f64) -> f64 {
    1.0 / (2.0 * surge_s * cruise_mps)
}

#[cfg(test)]
mod tests;
