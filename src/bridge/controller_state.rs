//! What the controller thinks, as MAVLink messages: for a ground station now and then, for a log at every step.
//!
//! One NAMED_VALUE_FLOAT per quantity: every ground station can plot those without being taught.

use helmlink_wire::Message;
use helmlink_wire::dialect::{CharArray, NAMED_VALUE_FLOAT_DATA};

use crate::control::Diagnostics;
use crate::vehicle::output::Demand;

/// Bit of [`Quantity::Saturation`]: a limit cut the surge force off.
pub const SURGE_SATURATED: u8 = 1;
/// Bit of [`Quantity::Saturation`]: a limit cut the yaw moment off.
pub const YAW_SATURATED: u8 = 2;

/// One quantity of the controller's state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Quantity {
    /// Distance to the right of the path, m.
    CrossTrack,
    /// Heading error ψ_e, rad.
    HeadingError,
    /// Surge speed asked for α_u, m/s.
    SpeedWanted,
    /// Yaw rate asked for α_r, rad/s.
    YawRateWanted,
    /// Sliding surface S_u, m/s.
    SurfaceSurge,
    /// Sliding surface S_r, rad/s.
    SurfaceYaw,
    /// Disturbance bound δ̂_u, m/s².
    DisturbanceSurge,
    /// Disturbance bound δ̂_r, rad/s².
    DisturbanceYaw,
    /// [`SURGE_SATURATED`] and [`YAW_SATURATED`], added.
    Saturation,
    /// Throttle commanded, −1…1.
    Throttle,
    /// Steering commanded, −1…1.
    Steering,
}

/// Every quantity with its name on the wire, in the order in which they are sent.
pub const QUANTITIES: [(Quantity, &str); 11] = [
    (Quantity::CrossTrack, "HL_XTRACK"),
    (Quantity::HeadingError, "HL_PSI_E"),
    (Quantity::SpeedWanted, "HL_ALPHA_U"),
    (Quantity::YawRateWanted, "HL_ALPHA_R"),
    (Quantity::SurfaceSurge, "HL_S_U"),
    (Quantity::SurfaceYaw, "HL_S_R"),
    (Quantity::DisturbanceSurge, "HL_D_U"),
    (Quantity::DisturbanceYaw, "HL_D_R"),
    (Quantity::Saturation, "HL_SAT"),
    (Quantity::Throttle, "HL_THR"),
    (Quantity::Steering, "HL_STEER"),
];

/// The messages that carry one control step, stamped with vehicle time `boot_s` (seconds since its boot).
pub fn messages(
    boot_s: f64,
    diagnostics: &Diagnostics,
    demand: &Demand,
) -> impl Iterator<Item = Message> + use<> {
    let (diagnostics, demand) = (*diagnostics, *demand);
    QUANTITIES
        .into_iter()
        .map(move |(quantity, name)| named_value(boot_s, name, value(quantity, &diagnostics, &demand) as f32))
}

/// The quantity that a message carries, and its value; `None` for every other message.
pub fn from_message(message: &Message) -> Option<(Quantity, f64)> {
    let Message::NAMED_VALUE_FLOAT(data) = message else { return None };
    let name = data.name.to_str().ok()?;
    let (quantity, _) = QUANTITIES.into_iter().find(|(_, known)| *known == name)?;
    Some((quantity, f64::from(data.value)))
}

/// A NAMED_VALUE_FLOAT; of a name longer than ten characters the first ten are sent.
pub fn named_value(boot_s: f64, name: &str, value: f32) -> Message {
    // The message's clock has milliseconds in 32 bits; a conversion from f64 saturates.
    let time_boot_ms = (boot_s * 1000.0) as u32;
    Message::NAMED_VALUE_FLOAT(NAMED_VALUE_FLOAT_DATA { time_boot_ms, name: CharArray::from(name), value })
}

fn value(quantity: Quantity, diagnostics: &Diagnostics, demand: &Demand) -> f64 {
    let (reference, law) = (&diagnostics.reference, &diagnostics.law);
    let bit = |is_set: bool, bit: u8| f64::from(if is_set { bit } else { 0 });
    match quantity {
        Quantity::CrossTrack => reference.cross_track_m,
        Quantity::HeadingError => reference.heading_error_rad,
        Quantity::SpeedWanted => law.alpha_u_mps,
        Quantity::YawRateWanted => law.alpha_r_radps,
        Quantity::SurfaceSurge => law.surface_u,
        Quantity::SurfaceYaw => law.surface_r,
        Quantity::DisturbanceSurge => law.disturbance_u,
        Quantity::DisturbanceYaw => law.disturbance_r,
        Quantity::Saturation => {
            bit(diagnostics.surge_saturated, SURGE_SATURATED) + bit(diagnostics.yaw_saturated, YAW_SATURATED)
        }
        Quantity::Throttle => demand.throttle,
        Quantity::Steering => demand.steering,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_comes_back_under_its_own_name() {
        let mut diagnostics = Diagnostics { yaw_saturated: true, ..Diagnostics::default() };
        diagnostics.reference.cross_track_m = -1.5;
        diagnostics.law.surface_r = 0.25;
        let demand = Demand { throttle: 0.5, ..Demand::NEUTRAL };
        let read: Vec<_> =
            messages(12.5, &diagnostics, &demand).map(|message| from_message(&message).unwrap()).collect();
        let order: Vec<_> = read.iter().map(|(quantity, _)| *quantity).collect();
        assert_eq!(order, QUANTITIES.map(|(quantity, _)| quantity));
        let of = |wanted| read.iter().find(|(quantity, _)| *quantity == wanted).unwrap().1;
        assert_eq!(of(Quantity::CrossTrack), -1.5);
        assert_eq!(of(Quantity::SurfaceYaw), 0.25);
        assert_eq!(of(Quantity::Saturation), f64::from(YAW_SATURATED));
        assert_eq!(of(Quantity::Throttle), 0.5);
    }

    #[test]
    fn names_fit_and_other_messages_are_not_taken() {
        assert!(QUANTITIES.iter().all(|(_, name)| name.len() <= 10));
        assert_eq!(from_message(&named_value(1.0, "OTHER", 2.0)), None);
        let Message::NAMED_VALUE_FLOAT(data) = named_value(1.5, "HL_S_U", 2.0) else { panic!() };
        assert_eq!((data.time_boot_ms, data.value), (1500, 2.0));
    }
}
