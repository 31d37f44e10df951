//! Positions on the WGS 84 ellipsoid and on a local plane.
//!
//! Everything of this crate and of the controller is computed in one local frame, a [`LocalFrame`]; degrees
//! appear only where a position comes from a file or a message, or goes back to one.

mod local_frame;
mod vector;

pub use local_frame::LocalFrame;
pub use vector::NorthEast;

use local_frame::ecef_m;
use serde::{Deserialize, Serialize};

/// Mean radius of the Earth, (2a + b)/3 of WGS 84, in metres.
const MEAN_RADIUS_M: f64 = 6_371_008.771_4;

/// A position on the WGS 84 ellipsoid, at height zero, in degrees.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
pub struct Geodetic {
    /// Geodetic latitude, degrees north, −90 to 90.
    pub latitude_deg: f64,
    /// Longitude, degrees east, −180 to 180.
    pub longitude_deg: f64,
}

/// Why a pair of numbers is not a usable position.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PositionFault {
    /// A coordinate is NaN or infinite.
    #[error("a coordinate is not a finite number")]
    NotFinite,
    /// The latitude is outside −90 to 90 degrees.
    #[error("latitude {0}° is outside −90…90")]
    Latitude(f64),
    /// The longitude is outside −180 to 180 degrees.
    #[error("longitude {0}° is outside −180…180")]
    Longitude(f64),
    /// Latitude and longitude are both zero, which MAVLink autopilots send when they have no position.
    #[error("latitude and longitude are both 0, which means \"no position\"")]
    NoPosition,
}

impl Geodetic {
    /// A position from degrees; not checked, see [`Geodetic::check`].
    pub fn new(latitude_deg: f64, longitude_deg: f64) -> Self {
        Self { latitude_deg, longitude_deg }
    }

    /// A position from MAVLink's integers, degrees × 10⁷.
    pub fn from_e7(latitude_e7: i32, longitude_e7: i32) -> Self {
        Self { latitude_deg: f64::from(latitude_e7) * 1e-7, longitude_deg: f64::from(longitude_e7) * 1e-7 }
    }

    /// MAVLink's integers, degrees × 10⁷, rounded to the nearest (about 11 mm a step of latitude).
    /// Numbers that do not fit are clamped, NaN becomes 0: check first.
    pub fn to_e7(self) -> (i32, i32) {
        ((self.latitude_deg * 1e7).round() as i32, (self.longitude_deg * 1e7).round() as i32)
    }

    /// Whether this can be where a boat is.
    ///
    /// # Errors
    /// The first reason found: a coordinate that is not finite, out of range, or both exactly zero.
    pub fn check(self) -> Result<(), PositionFault> {
        if !self.latitude_deg.is_finite() || !self.longitude_deg.is_finite() {
            Err(PositionFault::NotFinite)
        } else if self.latitude_deg.abs() > 90.0 {
            Err(PositionFault::Latitude(self.latitude_deg))
        } else if self.longitude_deg.abs() > 180.0 {
            Err(PositionFault::Longitude(self.longitude_deg))
        } else if self.latitude_deg == 0.0 && self.longitude_deg == 0.0 {
            Err(PositionFault::NoPosition)
        } else {
            Ok(())
        }
    }

    /// Whether [`Geodetic::check`] finds nothing wrong.
    pub fn is_valid(self) -> bool {
        self.check().is_ok()
    }

    /// Distance over the surface to `other` in metres, from the chord and the mean radius: within 2 cm of
    /// the geodesic up to 100 km, within 0.4 % anywhere. Good for checking a plan, not for control.
    pub fn distance_m(self, other: Self) -> f64 {
        let (here, there) = (ecef_m(self), ecef_m(other));
        let square_m2: f64 = (0..3).map(|axis| (here[axis] - there[axis]).powi(2)).sum();
        let half_chord = (square_m2.sqrt() / (2.0 * MEAN_RADIUS_M)).min(1.0);
        2.0 * MEAN_RADIUS_M * half_chord.asin()
    }
}

impl std::fmt::Display for Geodetic {
    /// Latitude and longitude in degrees with eight decimals, about a millimetre.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.8}, {:.8}", self.latitude_deg, self.longitude_deg)
    }
}

#[cfg(test)]
mod tests;
