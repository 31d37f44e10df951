//! What is to be tried on a log.

use helmlink_mission::plan::Mission;

use crate::control::{Boat, Controller};
use crate::vehicle::OutputKind;

/// When the controller is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Window {
    /// While the boat was armed and in AUTO or GUIDED, or steered by a companion
    Driven,
    /// While it was armed, whoever steered
    Armed,
    /// Always
    Any,
}

/// What is to be tried on a log.
#[derive(Debug, Clone)]
pub struct WhatIfSettings {
    /// Model, limits and gains.
    pub boat: Boat,
    /// The controller.
    pub controller: Controller,
    /// By which messages it would steer.
    pub output: OutputKind,
    /// Speed over ground where the mission gives none, m/s; the vehicle's own setting if not given.
    pub speed_mps: Option<f64>,
    /// A mission instead of those in the log.
    pub mission: Option<Mission>,
    /// When the controller is asked.
    pub window: Window,
    /// System id of the overrides.
    pub ground_station_system: u8,
}
