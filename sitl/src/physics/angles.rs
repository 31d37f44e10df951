//! Turning by small angles without the library's sine: the boat turns by milliradians per step, and so do the waves.

use std::ops::{Add, Mul, Sub};

use super::dynamics::NedVector;

/// Below this angle the series of [`small_sin_cos`] is exact to 4e-15, rad.
pub(super) const SMALL_ANGLE_RAD: f64 = 0.2;

/// Sine and cosine of angles below [`SMALL_ANGLE_RAD`] in magnitude, by their series.
#[inline]
pub(super) fn small_sin_cos(angle_rad: Pair) -> (Pair, Pair) {
    let square = angle_rad * angle_rad;
    let less = |share: f64, rest: Pair| Pair::both(1.0) - square * Pair::both(share) * rest;
    let sin = less(1.0 / 6.0, less(1.0 / 20.0, less(1.0 / 42.0, less(1.0 / 72.0, Pair::both(1.0)))));
    let cos = less(1.0 / 12.0, less(1.0 / 30.0, less(1.0 / 56.0, less(1.0 / 90.0, Pair::both(1.0)))));
    (angle_rad * sin, less(0.5, cos))
}

/// Sine and cosine of any angle; short ones do without the library.
#[inline]
pub(super) fn sin_cos(angle_rad: f64) -> (f64, f64) {
    if angle_rad.abs() < SMALL_ANGLE_RAD {
        let (sin, cos) = small_sin_cos(Pair::both(angle_rad));
        (sin.0[0], cos.0[0])
    } else {
        angle_rad.sin_cos()
    }
}

/// Two numbers that processors work on at once.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pair(pub(super) [f64; 2]);

impl Pair {
    #[inline]
    pub(super) fn both(value: f64) -> Pair {
        Pair([value; 2])
    }

    pub(super) fn sin_cos(self) -> (Pair, Pair) {
        let [a, b] = self.0.map(f64::sin_cos);
        (Pair([a.0, b.0]), Pair([a.1, b.1]))
    }

    #[inline]
    pub(super) fn sum(self) -> f64 {
        self.0[0] + self.0[1]
    }
}

impl Add for Pair {
    type Output = Pair;

    #[inline]
    fn add(self, other: Pair) -> Pair {
        Pair([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

impl Sub for Pair {
    type Output = Pair;

    #[inline]
    fn sub(self, other: Pair) -> Pair {
        Pair([self.0[0] - other.0[0], self.0[1] - other.0[1]])
    }
}

impl Mul for Pair {
    type Output = Pair;

    #[inline]
    fn mul(self, other: Pair) -> Pair {
        Pair([self.0[0] * other.0[0], self.0[1] * other.0[1]])
    }
}

/// The unit vector toward this bearing.
pub(super) fn unit(bearing_rad: f64) -> NedVector {
    let (sin, cos) = bearing_rad.sin_cos();
    NedVector { north: cos, east: sin }
}

/// A vector turned clockwise by this angle.
#[inline]
pub(super) fn turned(vector: NedVector, angle_rad: f64) -> NedVector {
    let (sin, cos) = sin_cos(angle_rad);
    NedVector { north: vector.north * cos - vector.east * sin, east: vector.east * cos + vector.north * sin }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_is_as_good_as_it_says() {
        for i in -1000..=1000 {
            let angle_rad = f64::from(i) * 2e-4 * 0.9999;
            let (sin, cos) = sin_cos(angle_rad);
            assert!((sin - angle_rad.sin()).abs() < 4e-15 && (cos - angle_rad.cos()).abs() < 4e-15);
        }
    }

    #[test]
    fn turning_is_clockwise_at_any_angle() {
        for angle_rad in [-3.0, -0.05, 0.0, 0.02, 0.099, 0.101, 2.0] {
            let (found, expected) = (turned(unit(0.7), angle_rad), unit(0.7 + angle_rad));
            assert!((found.north - expected.north).abs() < 1e-14, "{angle_rad}");
            assert!((found.east - expected.east).abs() < 1e-14, "{angle_rad}");
        }
    }
}
