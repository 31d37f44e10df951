//! Faults as they are written on the command line and in scenario files.

use std::fmt;
use std::str::FromStr;

use super::{Fault, FaultError, Thrusters};

/// The forms of all faults, for help and errors.
const FORMS: &str = "link-loss=PERCENT, link-delay=MS[,JITTER_MS], link-duplicate=PERCENT, link-reorder=PERCENT, \
                     link-corrupt=PERCENT, gps-loss, gps-freeze, gps-jump=NORTH_M,EAST_M, \
                     gps-drift=NORTH_MPS,EAST_MPS, compass-offset=DEGREES, rudder-stuck[=POSITION], \
                     rudder-weak=SHARE, thruster-stuck[=left|right], thruster-weak=SHARE[,left|right], \
                     low-battery=PERCENT, reboot, ekf-failure";

/// Why a text is no fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FaultTextError {
    /// No fault of that name.
    #[error("`{0}` is no fault: choose one of {FORMS}")]
    Unknown(String),
    /// The figures are not as they should be.
    #[error("fault `{text}`: write {form}")]
    Form {
        /// What was given.
        text: String,
        /// What was expected.
        form: &'static str,
    },
    /// A figure outside its range.
    #[error(transparent)]
    Range(#[from] FaultError),
}

impl FromStr for Fault {
    type Err = FaultTextError;

    fn from_str(text: &str) -> Result<Self, FaultTextError> {
        let (name, arguments) = match text.trim().split_once('=') {
            Some((name, rest)) => (name.trim(), rest.split(',').map(str::trim).collect()),
            None => (text.trim(), Vec::new()),
        };
        let fault = read(name, &Arguments { text, given: arguments })?;
        fault.check()?;
        Ok(fault)
    }
}

fn read(name: &str, arguments: &Arguments<'_>) -> Result<Fault, FaultTextError> {
    let percent = |form| Ok::<f64, FaultTextError>(arguments.one(form)? / 100.0);
    Ok(match name {
        "link-loss" => Fault::LinkLoss { share: percent("link-loss=PERCENT, such as link-loss=30")? },
        "link-delay" => {
            let form = "link-delay=MS or link-delay=MS,JITTER_MS, such as link-delay=200,50";
            let [delay_ms, jitter_ms] = arguments.one_or_two(form)?;
            Fault::LinkDelay { delay_s: delay_ms / 1000.0, jitter_s: jitter_ms / 1000.0 }
        }
        "link-duplicate" => Fault::LinkDuplication { share: percent("link-duplicate=PERCENT")? },
        "link-reorder" => Fault::LinkReordering { share: percent("link-reorder=PERCENT")? },
        "link-corrupt" => Fault::LinkCorruption { share: percent("link-corrupt=PERCENT")? },
        "gps-loss" => arguments.none("gps-loss alone", Fault::GpsLoss)?,
        "gps-freeze" => arguments.none("gps-freeze alone", Fault::GpsFreeze)?,
        "gps-jump" => {
            let [north_m, east_m] = arguments.two("gps-jump=NORTH_M,EAST_M, such as gps-jump=20,-5")?;
            Fault::GpsJump { north_m, east_m }
        }
        "gps-drift" => {
            let [north_mps, east_mps] =
                arguments.two("gps-drift=NORTH_MPS,EAST_MPS, such as gps-drift=0.5,0")?;
            Fault::GpsDrift { north_mps, east_mps }
        }
        "compass-offset" => {
            let degrees = arguments.one("compass-offset=DEGREES, such as compass-offset=15")?;
            Fault::CompassOffset { offset_rad: degrees.to_radians() }
        }
        "rudder-stuck" if arguments.given.is_empty() => Fault::RudderStuck { at: None },
        "rudder-stuck" => {
            let form = "rudder-stuck alone for where it is, or rudder-stuck=POSITION between -1 and 1";
            Fault::RudderStuck { at: Some(arguments.one(form)?) }
        }
        "rudder-weak" => {
            Fault::RudderWeak { share: arguments.one("rudder-weak=SHARE, such as rudder-weak=0.3")? }
        }
        "thruster-stuck" => {
            let form = "thruster-stuck, thruster-stuck=left or thruster-stuck=right";
            Fault::ThrusterStuck { which: arguments.thrusters(0, form)? }
        }
        "thruster-weak" => {
            let form = "thruster-weak=SHARE or thruster-weak=SHARE,left, such as thruster-weak=0.5,right";
            Fault::ThrusterWeak { share: arguments.number(0, form)?, which: arguments.thrusters(1, form)? }
        }
        "low-battery" => {
            Fault::LowBattery { percent: arguments.one("low-battery=PERCENT, such as low-battery=15")? }
        }
        "reboot" => arguments.none("reboot alone", Fault::Reboot)?,
        "ekf-failure" => arguments.none("ekf-failure alone", Fault::EkfFailure)?,
        _ => return Err(FaultTextError::Unknown(arguments.text.trim().to_owned())),
    })
}

/// What stands behind the `=`.
struct Arguments<'a> {
    text: &'a str,
    given: Vec<&'a str>,
}

impl Arguments<'_> {
    fn wrong(&self, form: &'static str) -> FaultTextError {
        FaultTextError::Form { text: self.text.trim().to_owned(), form }
    }

    fn number(&self, index: usize, form: &'static str) -> Result<f64, FaultTextError> {
        let number = self.given.get(index).and_then(|text| text.parse::<f64>().ok());
        number.filter(|number| number.is_finite()).ok_or_else(|| self.wrong(form))
    }

    fn at_most(&self, count: usize, form: &'static str) -> Result<(), FaultTextError> {
        if self.given.len() > count { Err(self.wrong(form)) } else { Ok(()) }
    }

    fn none(&self, form: &'static str, fault: Fault) -> Result<Fault, FaultTextError> {
        self.at_most(0, form).map(|()| fault)
    }

    fn one(&self, form: &'static str) -> Result<f64, FaultTextError> {
        self.at_most(1, form)?;
        self.number(0, form)
    }

    fn two(&self, form: &'static str) -> Result<[f64; 2], FaultTextError> {
        self.at_most(2, form)?;
        Ok([self.number(0, form)?, self.number(1, form)?])
    }

    fn one_or_two(&self, form: &'static str) -> Result<[f64; 2], FaultTextError> {
        match self.given.len() {
            1 => Ok([self.number(0, form)?, 0.0]),
            _ => self.two(form),
        }
    }

    /// The thrusters named last, or all.
    fn thrusters(&self, index: usize, form: &'static str) -> Result<Thrusters, FaultTextError> {
        self.at_most(index + 1, form)?;
        match self.given.get(index) {
            None => Ok(Thrusters::All),
            Some(&"left") => Ok(Thrusters::Left),
            Some(&"right") => Ok(Thrusters::Right),
            Some(_) => Err(self.wrong(form)),
        }
    }
}

/// Six decimals at the most, none that say nothing.
fn short(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| short(100.0 * share);
        match *self {
            Self::LinkLoss { share } => write!(f, "link-loss={}", percent(share)),
            Self::LinkDelay { delay_s, jitter_s } => {
                write!(f, "link-delay={},{}", short(1000.0 * delay_s), short(1000.0 * jitter_s))
            }
            Self::LinkDuplication { share } => write!(f, "link-duplicate={}", percent(share)),
            Self::LinkReordering { share } => write!(f, "link-reorder={}", percent(share)),
            Self::LinkCorruption { share } => write!(f, "link-corrupt={}", percent(share)),
            Self::GpsLoss => f.write_str("gps-loss"),
            Self::GpsFreeze => f.write_str("gps-freeze"),
            Self::GpsJump { north_m, east_m } => write!(f, "gps-jump={},{}", short(north_m), short(east_m)),
            Self::GpsDrift { north_mps, east_mps } => {
                write!(f, "gps-drift={},{}", short(north_mps), short(east_mps))
            }
            Self::CompassOffset { offset_rad } => {
                write!(f, "compass-offset={}", short(offset_rad.to_degrees()))
            }
            Self::RudderStuck { at: None } => f.write_str("rudder-stuck"),
            Self::RudderStuck { at: Some(at) } => write!(f, "rudder-stuck={}", short(at)),
            Self::RudderWeak { share } => write!(f, "rudder-weak={}", short(share)),
            Self::ThrusterStuck { which } => write!(f, "thruster-stuck{}", which.suffix("=")),
            Self::ThrusterWeak { which, share } => {
                write!(f, "thruster-weak={}{}", short(share), which.suffix(","))
            }
            Self::LowBattery { percent } => write!(f, "low-battery={}", short(percent)),
            Self::Reboot => f.write_str("reboot"),
            Self::EkfFailure => f.write_str("ekf-failure"),
        }
    }
}

impl Thrusters {
    fn suffix(self, separator: &str) -> String {
        match self {
            Self::All => String::new(),
            Self::Left => format!("{separator}left"),
            Self::Right => format!("{separator}right"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_reads_back_as_it_is_written() {
        for text in [
            "link-loss=30",
            "link-delay=200,50",
            "link-duplicate=5",
            "link-reorder=10",
            "link-corrupt=1",
            "gps-loss",
            "gps-freeze",
            "gps-jump=20,-5",
            "gps-drift=0.5,0",
            "compass-offset=15",
            "rudder-stuck",
            "rudder-stuck=-0.25",
            "rudder-weak=0.3",
            "thruster-stuck",
            "thruster-stuck=left",
            "thruster-weak=0.5,right",
            "thruster-weak=0",
            "low-battery=15",
            "reboot",
            "ekf-failure",
        ] {
            let fault: Fault = text.parse().unwrap();
            assert_eq!(fault.to_string(), text);
        }
    }

    #[test]
    fn nonsense_is_refused_with_what_would_do() {
        for (text, hint) in [
            ("gps", "choose one of"),
            ("link-loss", "PERCENT"),
            ("link-loss=nan", "PERCENT"),
            ("link-loss=130", "between 0 and 1"),
            ("gps-loss=3", "alone"),
            ("gps-jump=1", "NORTH_M,EAST_M"),
            ("gps-jump=1e9,0", "at most 50 km"),
            ("rudder-stuck=2", "between -1 and 1"),
            ("thruster-weak=0.5,up", "SHARE,left"),
            ("low-battery=-1", "between 0 and 100"),
        ] {
            let message = text.parse::<Fault>().unwrap_err().to_string();
            assert!(message.contains(hint), "{text}: {message}");
        }
    }
}
