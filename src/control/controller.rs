//! The controllers that can be chosen by name, and what each is made of.

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::baselines::{Pid, SignSmc, SpeedPi};
use super::boat::{Boat, ControlSettings};
use super::law::Law;
use super::pi_smc::PiSmc;
use crate::guidance::{EndOfPath, Guidance, LineOfSight, Practical, ToVirtualShip};

/// A controller: guidance and law together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Controller {
    /// Adaptive PI sliding mode behind the practical guidance, with delay prediction: Helmlink's own.
    #[default]
    PiSmc,
    /// The same law behind the paper's guidance: the bow at the virtual ship.
    PiSmcPaper,
    /// PID in heading and PI in speed behind the practical guidance.
    Pid,
    /// Integral line of sight with a heading autopilot (Børhaug, Pavlov and Pettersen 2008; Fossen 2021, §12.5).
    IlosPid,
    /// Adaptive line of sight with a heading autopilot (Fossen 2023).
    AlosPid,
    /// Sliding mode with a sign function and no integral, behind the practical guidance.
    SignSmc,
}

/// No controller has this name.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("there is no controller called {0:?}; choose one of {known}", known = Controller::names())]
pub struct UnknownController(String);

/// What the helm does for a controller besides guidance, law and allocation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Equipment {
    /// The sway model and the estimate of the current; without it the motion over ground is taken for the one
    /// through the water.
    pub(super) observes_water: bool,
    /// Waves and noise are taken out of the state.
    pub(super) observes_state: bool,
    /// The state is predicted across a known delay.
    pub(super) predicts: bool,
    /// The rate of the wanted heading reaches the law.
    pub(super) feeds_forward: bool,
    /// The law learns parameters and disturbance bounds, and the helm the hull's sway.
    pub(super) adapts: bool,
}

impl Controller {
    /// All of them, Helmlink's own first.
    pub const ALL: [Self; 6] =
        [Self::PiSmc, Self::PiSmcPaper, Self::Pid, Self::IlosPid, Self::AlosPid, Self::SignSmc];

    /// The name as it is typed.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::PiSmc => "pi-smc",
            Self::PiSmcPaper => "pi-smc-paper",
            Self::Pid => "pid",
            Self::IlosPid => "ilos-pid",
            Self::AlosPid => "alos-pid",
            Self::SignSmc => "sign-smc",
        }
    }

    /// All names, for a message.
    #[must_use]
    pub fn names() -> String {
        Self::ALL.map(Self::as_str).join(", ")
    }

    pub(super) fn equipment(self) -> Equipment {
        let is_ours = self == Self::PiSmc;
        Equipment {
            observes_water: matches!(self, Self::PiSmc | Self::Pid | Self::SignSmc),
            observes_state: is_ours,
            predicts: is_ours,
            feeds_forward: true,
            adapts: matches!(self, Self::PiSmc | Self::PiSmcPaper),
        }
    }

    pub(super) fn guidance(self, boat: &Boat, end: EndOfPath) -> Box<dyn Guidance> {
        let practical =
            |settings| Box::new(Practical::new(settings, boat.limits.clone(), boat.hull.clone(), end));
        match self {
            Self::PiSmc => practical(boat.guidance.clone()),
            Self::Pid => practical(boat.baselines.pid.guidance.clone()),
            Self::SignSmc => practical(boat.baselines.sign_smc.guidance.clone()),
            Self::PiSmcPaper => Box::new(ToVirtualShip::new(
                boat.baselines.pi_smc_paper.guidance.clone(),
                boat.limits.clone(),
                end,
            )),
            Self::IlosPid => {
                Box::new(LineOfSight::new(boat.baselines.ilos_pid.los.clone(), boat.limits.clone(), end))
            }
            Self::AlosPid => {
                Box::new(LineOfSight::new(boat.baselines.alos_pid.los.clone(), boat.limits.clone(), end))
            }
        }
    }

    pub(super) fn law(self, boat: &Boat) -> Box<dyn Law> {
        let pid = |heading, speed| Box::new(Pid::new(boat, heading, SpeedPi::new(speed)));
        let baselines = &boat.baselines;
        let sliding = |control: &ControlSettings| {
            let adapts = boat.parts.applied(self.equipment()).adapts;
            let control = if adapts { control.clone() } else { control.without_adaptation() };
            Box::new(PiSmc::with_gains(boat, &control))
        };
        match self {
            Self::PiSmc => sliding(&boat.control),
            Self::PiSmcPaper => sliding(&baselines.pi_smc_paper.control),
            Self::Pid => pid(baselines.pid.heading.clone(), baselines.pid.speed.clone()),
            Self::IlosPid => pid(baselines.ilos_pid.heading.clone(), baselines.ilos_pid.speed.clone()),
            Self::AlosPid => pid(baselines.alos_pid.heading.clone(), baselines.alos_pid.speed.clone()),
            Self::SignSmc => Box::new(SignSmc::new(boat)),
        }
    }
}

impl FromStr for Controller {
    type Err = UnknownController;

    fn from_str(text: &str) -> Result<Self, UnknownController> {
        Self::ALL
            .into_iter()
            .find(|controller| controller.as_str() == text)
            .ok_or_else(|| UnknownController(text.to_owned()))
    }
}

impl std::fmt::Display for Controller {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}
