//! The clothoid: a curve whose curvature grows in proportion to its length.

use crate::geodesy::NorthEast;

/// Terms of each power series below. With this many the remainder is below one part in 10¹³ for turns of up
/// to π radians, more than one clothoid ever makes here.
const TERMS: usize = 13;

/// 1/((2k)!(4k+1)) with alternating sign: the even series, for the distance made good ahead.
const AHEAD: [f64; TERMS] = coefficients(0);
/// 1/((2k+1)!(4k+3)) with alternating sign: the odd series, for the distance made to starboard.
const STARBOARD: [f64; TERMS] = coefficients(1);

/// Displacement along a clothoid that starts northward with no curvature, after `length_m` with sharpness
/// `sharpness_radpm2` (dκ/ds, positive to starboard).
///
/// The Fresnel integrals ∫exp(iσs²/2)ds as their Maclaurin series in the angle turned, a = σs²/2
/// (Abramowitz & Stegun 1964, 7.3.11 and 7.3.13, with the variable changed). `|a|` must not exceed π.
#[inline]
pub(super) fn displacement(length_m: f64, sharpness_radpm2: f64) -> NorthEast {
    let turned_rad = 0.5 * sharpness_radpm2 * length_m * length_m;
    let square = turned_rad * turned_rad;
    NorthEast {
        north_m: length_m * horner(&AHEAD, square),
        east_m: length_m * turned_rad * horner(&STARBOARD, square),
    }
}

#[inline]
fn horner(coefficients: &[f64; TERMS], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// (−1)ᵏ/(n!(2n+1)) for n = 2k + parity.
const fn coefficients(parity: usize) -> [f64; TERMS] {
    let mut series = [0.0; TERMS];
    let mut factorial = 1.0;
    let mut sign = 1.0;
    let mut n = 0;
    while n < 2 * TERMS {
        if n > 0 {
            factorial *= n as f64;
        }
        if n % 2 == parity {
            series[n / 2] = sign / (factorial * (2 * n + 1) as f64);
            sign = -sign;
        }
        n += 1;
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// The same integral by Simpson's rule.
    fn integrated(length_m: f64, sharpness_radpm2: f64) -> NorthEast {
        let panels = 4000;
        let step_m = length_m / f64::from(panels);
        (0..=panels).fold(NorthEast::ZERO, |sum, i| {
            let weight = if i == 0 || i == panels { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
            let s_m = f64::from(i) * step_m;
            sum + NorthEast::from_polar(weight * step_m / 3.0, 0.5 * sharpness_radpm2 * s_m * s_m)
        })
    }

    #[test]
    fn agrees_with_quadrature_up_to_half_a_turn() {
        for turned_rad in [-PI, -1.0, 0.0, 1e-6, 0.3, 1.5, 2.6, PI] {
            let length_m = 100.0;
            let sharpness_radpm2 = 2.0 * turned_rad / (length_m * length_m);
            let error_m =
                (displacement(length_m, sharpness_radpm2) - integrated(length_m, sharpness_radpm2)).norm();
            assert!(error_m < 1e-9, "{error_m} m after {turned_rad} rad");
        }
    }
}
