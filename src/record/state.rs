//! What the controller thought at one step, as DEBUG_FLOAT_ARRAY.

use helmlink_wire::Message;
use helmlink_wire::dialect::{CharArray, DEBUG_FLOAT_ARRAY_DATA};

use crate::control::Diagnostics;
use crate::guidance::VesselState;
use crate::pilot::Progress;
use crate::vehicle::output::Demand;

/// Name in the DEBUG_FLOAT_ARRAY.
pub const NAME: &str = "HELMLINK";
/// `array_id` of this layout.
pub const LAYOUT: u16 = 1;

/// Declares the values of a control step once: field, name in the log (at most 10 letters), unit, meaning.
macro_rules! control_state {
    ($($field:ident $name:literal $unit:literal $meaning:literal),* $(,)?) => {
        /// One control step. Every value is what was recorded: a single-precision float.
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub struct ControlState {
            /// Vehicle time, seconds since the flight controller's boot.
            pub boot_s: f64,
            $(#[doc = concat!($meaning, ", ", $unit, ".")] pub $field: f32,)*
        }

        /// Name, unit and meaning of each value, in the order of the array.
        pub const VALUES: &[(&str, &str, &str)] = &[$(($name, $unit, $meaning)),*];

        impl ControlState {
            /// The values in the order of the array.
            pub fn values(&self) -> Vec<f32> {
                vec![$(self.$field),*]
            }

            fn from_values(boot_s: f64, values: &[f32]) -> Self {
                let mut values = values.iter().copied();
                Self { boot_s, $($field: values.next().unwrap_or_default(),)* }
            }
        }
    };
}

control_state! {
    cross_track_m "XTRACK" "m" "distance right of the smooth path",
    surface_u "S_U" "m/s" "sliding surface in surge",
    surface_r "S_R" "rad/s" "sliding surface in yaw",
    disturbance_u "DELTA_U" "m/s2" "disturbance bound in surge",
    disturbance_r "DELTA_R" "rad/s2" "disturbance bound in yaw",
    surge_wanted_mps "ALPHA_U" "m/s" "surge speed demanded",
    yaw_rate_wanted_radps "ALPHA_R" "rad/s" "yaw rate demanded",
    throttle "THROTTLE" "1" "throttle demanded, -1 to 1",
    steering "STEERING" "1" "steering demanded, -1 to 1",
    speed_wanted_mps "SPEED_WANT" "m/s" "speed over ground that the mission wants",
    speed_mps "SPEED" "m/s" "speed over ground",
    heading_error_rad "HDG_ERR" "rad" "heading error",
    surge_force_n "TAU_U" "N" "surge force demanded",
    yaw_moment_nm "TAU_R" "N m" "yaw moment demanded",
    current_north_mps "CURRENT_N" "m/s" "estimated current toward north",
    current_east_mps "CURRENT_E" "m/s" "estimated current toward east",
    waypoint "WAYPOINT" "1" "index of the waypoint under way to, 0 for the first",
    to_go_m "TO_GO" "m" "distance still to go",
    north_m "NORTH" "m" "position north of the first waypoint",
    east_m "EAST" "m" "position east of the first waypoint",
    heading_rad "HEADING" "rad" "heading, clockwise from north",
    surge_mps "SURGE" "m/s" "surge speed over ground",
    sway_mps "SWAY" "m/s" "sway speed over ground",
    yaw_rate_radps "YAW_RATE" "rad/s" "yaw rate",
    lead_m "LEAD" "m" "the virtual ship's distance ahead along the path",
}

impl ControlState {
    /// What one step has taken in and given.
    pub fn new(
        boot_s: f64,
        state: &VesselState,
        progress: &Progress,
        demand: &Demand,
        diagnostics: &Diagnostics,
    ) -> Self {
        let (reference, law) = (&diagnostics.reference, &diagnostics.law);
        Self {
            boot_s,
            cross_track_m: reference.cross_track_m as f32,
            surface_u: law.surface_u as f32,
            surface_r: law.surface_r as f32,
            disturbance_u: law.disturbance_u as f32,
            disturbance_r: law.disturbance_r as f32,
            surge_wanted_mps: law.alpha_u_mps as f32,
            yaw_rate_wanted_radps: law.alpha_r_radps as f32,
            throttle: demand.throttle as f32,
            steering: demand.steering as f32,
            speed_wanted_mps: progress.wanted_speed_mps as f32,
            speed_mps: progress.speed_mps as f32,
            heading_error_rad: reference.heading_error_rad as f32,
            surge_force_n: diagnostics.surge_demand_n as f32,
            yaw_moment_nm: diagnostics.yaw_demand_nm as f32,
            current_north_mps: diagnostics.water.current.north_m as f32,
            current_east_mps: diagnostics.water.current.east_m as f32,
            waypoint: progress.next as f32,
            to_go_m: progress.to_go_m as f32,
            north_m: state.position.north_m as f32,
            east_m: state.position.east_m as f32,
            heading_rad: state.heading_rad as f32,
            surge_mps: state.surge_mps as f32,
            sway_mps: state.sway_mps as f32,
            yaw_rate_radps: state.yaw_rate_radps as f32,
            lead_m: reference.lead_m as f32,
        }
    }

    /// The whole state as one message.
    pub fn to_message(&self) -> Message {
        let mut data = [0.0; 58];
        data.iter_mut().zip(self.values()).for_each(|(place, value)| *place = value);
        Message::DEBUG_FLOAT_ARRAY(DEBUG_FLOAT_ARRAY_DATA {
            time_usec: (self.boot_s * 1e6).round() as u64,
            name: CharArray::from(NAME),
            array_id: LAYOUT,
            data,
        })
    }

    /// The state in a message; `None` for any other message.
    pub fn from_message(message: &Message) -> Option<Self> {
        match message {
            Message::DEBUG_FLOAT_ARRAY(data) if data.array_id == LAYOUT && data.name.to_str() == Ok(NAME) => {
                Some(Self::from_values(data.time_usec as f64 / 1e6, &data.data))
            }
            _ => None,
        }
    }
}
