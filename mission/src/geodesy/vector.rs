//! Vectors of the local plane.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A position or displacement in a local plane: metres north and east. Angles are clockwise from north.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NorthEast {
    /// Metres north.
    pub north_m: f64,
    /// Metres east.
    pub east_m: f64,
}

impl NorthEast {
    /// The origin, or no displacement.
    pub const ZERO: Self = Self { north_m: 0.0, east_m: 0.0 };

    /// A vector from its components in metres.
    pub fn new(north_m: f64, east_m: f64) -> Self {
        Self { north_m, east_m }
    }

    /// The vector of a length in metres along a bearing, clockwise from north.
    pub fn from_polar(length_m: f64, bearing_rad: f64) -> Self {
        Self { north_m: length_m * bearing_rad.cos(), east_m: length_m * bearing_rad.sin() }
    }

    /// Scalar product, m².
    #[inline]
    pub fn dot(self, other: Self) -> f64 {
        self.north_m * other.north_m + self.east_m * other.east_m
    }

    /// The downward component of the vector product, m²: positive when `other` lies clockwise of `self`.
    #[inline]
    pub fn cross(self, other: Self) -> f64 {
        self.north_m * other.east_m - self.east_m * other.north_m
    }

    /// Length in metres.
    #[inline]
    pub fn norm(self) -> f64 {
        self.north_m.hypot(self.east_m)
    }

    /// Bearing in (−π, π], clockwise from north; 0 for the zero vector.
    #[inline]
    pub fn bearing_rad(self) -> f64 {
        self.east_m.atan2(self.north_m)
    }

    /// This vector turned clockwise by an angle.
    pub fn rotated(self, angle_rad: f64) -> Self {
        let (sin, cos) = angle_rad.sin_cos();
        Self {
            north_m: self.north_m * cos - self.east_m * sin,
            east_m: self.north_m * sin + self.east_m * cos,
        }
    }

    /// This vector turned clockwise by a right angle: the starboard side of a boat heading along it.
    #[inline]
    pub fn starboard(self) -> Self {
        Self { north_m: -self.east_m, east_m: self.north_m }
    }

    /// Whether both components are finite.
    pub fn is_finite(self) -> bool {
        self.north_m.is_finite() && self.east_m.is_finite()
    }
}

impl Add for NorthEast {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { north_m: self.north_m + other.north_m, east_m: self.east_m + other.east_m }
    }
}

impl AddAssign for NorthEast {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for NorthEast {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { north_m: self.north_m - other.north_m, east_m: self.east_m - other.east_m }
    }
}

impl Neg for NorthEast {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { north_m: -self.north_m, east_m: -self.east_m }
    }
}

impl Mul<f64> for NorthEast {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self { north_m: self.north_m * factor, east_m: self.east_m * factor }
    }
}

impl Div<f64> for NorthEast {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f64) -> Self {
        Self { north_m: self.north_m / divisor, east_m: self.east_m / divisor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn bearings_are_clockwise_from_north() {
        assert_eq!(NorthEast::new(0.0, 2.0).bearing_rad(), FRAC_PI_2);
        let east = NorthEast::from_polar(3.0, FRAC_PI_2);
        assert!((east - NorthEast::new(0.0, 3.0)).norm() < 1e-15);
        let north = NorthEast::new(1.0, 0.0);
        assert_eq!(north.starboard(), NorthEast::new(0.0, 1.0));
        assert!(north.cross(north.starboard()) > 0.0);
        assert!((north.rotated(FRAC_PI_2) - north.starboard()).norm() < 1e-15);
    }

    #[test]
    fn arithmetic_is_by_component() {
        let (a, b) = (NorthEast::new(1.0, 2.0), NorthEast::new(-3.0, 5.0));
        assert_eq!(a + b, NorthEast::new(-2.0, 7.0));
        assert_eq!(a - b, NorthEast::new(4.0, -3.0));
        assert_eq!(-a * 2.0, NorthEast::new(-2.0, -4.0));
        assert_eq!(b / 2.0, NorthEast::new(-1.5, 2.5));
        assert_eq!(a.dot(b), 7.0);
        assert_eq!(a.cross(b), 11.0);
    }
}
