//! Numbers and names that mean something, judged where they are read: so a mistake in a configuration file is told with
//! its line.
//!
//! Every kind of number has a type of its own, which takes nothing out of its range; the schema of configuration files
//! says the same ranges, because it asks the type.

use std::any::TypeId;
use std::fmt;
use std::ops::{Deref, RangeInclusive};
use std::str::FromStr;

use super::paced_sitl;
use crate::bridge::LEAST_SPEED_MPS;

/// The least and the largest number of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub(super) least: f64,
    pub(super) most: f64,
    /// There is nothing between 1 and 2.
    pub(super) is_whole: bool,
}

macro_rules! numbers {
    ($($(#[$doc:meta])* $name:ident($inner:ty): $least:expr, $most:expr, $what:literal;)*) => {
        $($(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name($inner);

        impl $name {
            const RANGE: RangeInclusive<$inner> = $least..=$most;
        }

        impl TryFrom<$inner> for $name {
            type Error = String;

            fn try_from(number: $inner) -> Result<Self, String> {
                within(Some(number), &Self::RANGE, $what).map(Self)
            }
        }

        impl FromStr for $name {
            type Err = String;

            fn from_str(text: &str) -> Result<Self, String> {
                within(text.parse().ok(), &Self::RANGE, $what).map(Self)
            }
        }

        impl Deref for $name {
            type Target = $inner;

            fn deref(&self) -> &$inner {
                &self.0
            }
        }

        impl From<$name> for $inner {
            fn from(number: $name) -> Self {
                number.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        })*

        /// The range of this kind of number, if it is one of these.
        pub(super) fn bounds(is: impl Fn(TypeId) -> bool) -> Option<Bounds> {
            $(if is(TypeId::of::<$name>()) {
                let (least, most) = (*$name::RANGE.start() as f64, *$name::RANGE.end() as f64);
                let is_whole = TypeId::of::<$inner>() != TypeId::of::<f64>();
                return Some(Bounds { least, most, is_whole });
            })*
            None
        }
    };
}

numbers! {
    /// Speed over ground, m/s; what the boat can do is asked of the boat.
    SpeedMps(f64): LEAST_SPEED_MPS, 100.0, "m/s";
    /// Rate of the control loop, Hz: ArduRover sends at most 40 messages of a kind per second.
    RateHz(f64): 2.0, 50.0, "Hz";
    /// Time that commands need to the boat, seconds.
    DelayS(f64): 0.0, 1.5, "s";
    /// Time to wait for somebody, seconds: a day at most.
    WaitS(f64): 0.0, 86_400.0, "seconds";
    /// Length of a simulated run, seconds.
    RunS(f64): 0.1, 31_536_000.0, "seconds";
    /// Place in a log, seconds from its beginning.
    LogS(f64): 0.0, 1.0e9, "seconds";
    /// Standing still, seconds.
    StopS(f64): 0.0, 86_400.0, "seconds";
    /// Multiples of real time.
    Speedup(f64): 0.01, 1000.0, "times as fast as real time";
    /// Distance from a track, m.
    ToleranceM(f64): 0.001, 10_000.0, "m";
    /// Depth of water, m.
    DepthM(f64): 0.1, 1000.0, "m";
    /// Radius of a path's corners, m.
    TurnRadiusM(f64): 0.1, 5000.0, "m";
    /// Length of a hull, m.
    LengthM(f64): 0.3, 200.0, "m";
    /// Speed at full throttle, m/s.
    TopSpeedMps(f64): 0.2, 30.0, "m/s";
    /// Diameter of a turning circle, m.
    TurningCircleM(f64): 0.1, 5000.0, "m";
    /// From a command to its effect, seconds.
    EffectDelayS(f64): 0.0, 2.0, "s";
    /// MAVLink system id.
    SystemId(u8): 1, 255, "for a system";
    /// How many of something are tried.
    Count(u32): 1, 1_000_000, "";
    /// Threads.
    Threads(u16): 1, 1024, "threads";
    /// Size of logs, MB.
    Megabytes(u32): 1, 100_000_000, "MB";
    /// Columns of a drawing.
    Columns(u16): 20, 400, "columns";
}

/// A multiple of real time, or `max`: as fast as the machine goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace(f64);

impl Pace {
    /// The word for as fast as the machine goes.
    pub(super) const MOST: &str = "max";
}

impl FromStr for Pace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == Self::MOST {
            return Ok(Self(paced_sitl::MAX));
        }
        let speedup = Speedup::from_str(text).map_err(|why| format!("{why}, or {}", Self::MOST))?;
        Ok(Self(*speedup))
    }
}

impl Deref for Pace {
    type Target = f64;

    fn deref(&self) -> &f64 {
        &self.0
    }
}

/// A number within `range`; `what` says what the numbers are, for the complaint.
fn within<N: PartialOrd + fmt::Display>(
    number: Option<N>,
    range: &RangeInclusive<N>,
    what: &str,
) -> Result<N, String> {
    // Not a number is in no range.
    let number = number.filter(|number| range.contains(number));
    number.ok_or_else(|| format!("choose {} to {} {what}", range.start(), range.end()).trim_end().to_owned())
}

/// Reads the name of a boat that comes with helmlink, or of a boat file: [`super::boat::load`] looks into it.
pub(super) fn boat(name: &str) -> Result<String, String> {
    if super::boat::is_file(name) {
        return Ok(name.to_owned());
    }
    super::boat::by_name(name).map(|_| name.to_owned())
}

#[cfg(test)]
mod tests {
    use helmlink_sitl::physics::sea::checked_depth_m;

    use super::*;
    use crate::control::Boat;
    use crate::control::boat::derived::Particulars;

    #[test]
    fn what_is_no_number_is_out_of_every_range() {
        assert_eq!(*"2".parse::<RateHz>().unwrap(), 2.0);
        assert_eq!(*"50.0".parse::<RateHz>().unwrap(), 50.0);
        for wrong in ["1.9", "51", "nan", "inf", "fast", ""] {
            assert_eq!(wrong.parse::<RateHz>().unwrap_err(), "choose 2 to 50 Hz", "{wrong}");
        }
        assert_eq!("0".parse::<Count>().unwrap_err(), "choose 1 to 1000000");
    }

    #[test]
    fn a_pace_is_a_number_or_max() {
        assert_eq!(*"max".parse::<Pace>().unwrap(), paced_sitl::MAX);
        assert_eq!(*"8".parse::<Pace>().unwrap(), 8.0);
        assert!("inf".parse::<Pace>().unwrap_err().ends_with("real time, or max"));
    }

    /// What the option takes and what the part behind it takes are the same.
    #[track_caller]
    fn ends_where(bounds: Option<Bounds>, takes: impl Fn(f64) -> bool) {
        let Bounds { least, most, .. } = bounds.unwrap();
        assert!(takes(least) && takes(most));
        assert!(!takes(least - 1e-6) && !takes(most * 1.000_001));
    }

    #[test]
    fn ranges_are_those_of_the_parts_that_use_the_numbers() {
        let of = |id: TypeId| bounds(move |kind| kind == id);
        ends_where(of(TypeId::of::<DepthM>()), |depth_m| checked_depth_m(depth_m).is_ok());
        ends_where(of(TypeId::of::<TurnRadiusM>()), |radius_m| {
            let mut boat = Boat::embedded("otter").unwrap();
            boat.limits.turn_radius_m = radius_m;
            boat.check().is_ok()
        });
        let usual = Particulars { length_m: 3.0, top_speed_mps: 3.0, turning_circle_m: 10.0, delay_s: 0.2 };
        let takes = |particulars: Particulars| Boat::derived_file("x", &particulars).is_ok();
        ends_where(of(TypeId::of::<LengthM>()), |length_m| takes(Particulars { length_m, ..usual }));
        ends_where(of(TypeId::of::<TopSpeedMps>()), |top_speed_mps| {
            takes(Particulars { top_speed_mps, ..usual })
        });
        ends_where(of(TypeId::of::<TurningCircleM>()), |turning_circle_m| {
            takes(Particulars { turning_circle_m, ..usual })
        });
        ends_where(of(TypeId::of::<EffectDelayS>()), |delay_s| takes(Particulars { delay_s, ..usual }));
    }
}
