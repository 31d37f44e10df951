//! What comes out of a replay, instant by instant.

use helmlink_mission::geodesy::Geodetic;

use crate::guidance::VesselState;
use crate::record::ControlState;
use crate::replay::servo::Outputs;

/// One instant of the log at which a control step was due.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// The log's time stamp, microseconds since 1970 UTC.
    pub time_us: u64,
    /// Vehicle time, seconds.
    pub time_s: f64,
    /// Where the boat was.
    pub place: Geodetic,
    /// The boat in the local frame.
    pub state: VesselState,
    /// What the controller thinks; none while it is not asked.
    pub thought: Option<ControlState>,
    /// What went to motors and rudder.
    pub outputs: Option<Outputs>,
    /// What a bridge had thought when the log was made.
    pub recorded: Option<ControlState>,
    /// Distance to the right of the straight leg being driven, metres.
    pub leg_error_m: Option<f64>,
}

/// Takes what comes out.
pub trait Sink {
    /// A control step was due.
    fn moment(&mut self, moment: &Moment);
    /// The controller sends a frame.
    fn command(&mut self, time_us: u64, frame: &[u8]);
    /// Something happened at this vehicle time, seconds.
    fn event(&mut self, time_s: f64, text: &str);
}
