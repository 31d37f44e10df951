//! The seam between guidance and allocation: a law that turns a reference into forces.

use super::allocation::Allocation;
use super::boat::Boat;
use super::command::Wrench;
use super::model::WaterMotion;
use crate::guidance::{Reference, VesselState};

/// What a law sees at one tick.
#[derive(Debug, Clone, Copy)]
pub struct LawInput<'a> {
    /// What guidance asks for.
    pub reference: &'a Reference,
    /// The boat.
    pub state: &'a VesselState,
    /// The boat's motion through the water, as far as it is known.
    pub motion: WaterMotion,
    /// How far ahead of the measurement state and motion are predicted, s.
    pub predicted_s: f64,
}

/// What a law thought at the last tick. A law without a quantity leaves it zero.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LawDiagnostics {
    /// Surge speed asked for α_u, m/s.
    pub alpha_u_mps: f64,
    /// Yaw rate asked for α_r, rad/s.
    pub alpha_r_radps: f64,
    /// Sliding surface in surge S_u, m/s.
    pub surface_u: f64,
    /// Sliding surface in yaw S_r, rad/s.
    pub surface_r: f64,
    /// Disturbance bound in surge δ̂_u, m/s².
    pub disturbance_u: f64,
    /// Disturbance bound in yaw δ̂_r, rad/s².
    pub disturbance_r: f64,
}

/// A heading and speed controller: the seam where another one plugs in.
pub trait Law: Send {
    /// Starts from the measured motion without a jump; forgets everything learned.
    fn engage(&mut self, surge_mps: f64, yaw_rate_radps: f64);

    /// Forces wanted now.
    fn demand(&mut self, dt_s: f64, input: &LawInput<'_>) -> Wrench;

    /// Learns what the actuators made of the demand; called once after every [`Law::demand`].
    fn settle(&mut self, dt_s: f64, allocation: &Allocation);

    /// Takes over the gains of `boat` and keeps what has been learned; false for a law that cannot.
    fn retune(&mut self, _boat: &Boat) -> bool {
        false
    }

    /// What the law thought at the last tick.
    fn diagnostics(&self) -> LawDiagnostics;
}
