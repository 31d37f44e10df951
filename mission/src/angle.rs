//! Angles on the circle, in radians.

use std::f64::consts::{PI, TAU};

/// The smallest signed angle equivalent to `rad`, in (−π, π]. NaN and infinities give NaN.
///
/// ```
/// use helmlink_mission::angle::ssa;
/// assert!((ssa(3.5 * std::f64::consts::PI) + 0.5 * std::f64::consts::PI).abs() < 1e-12);
/// ```
#[inline]
pub fn ssa(rad: f64) -> f64 {
    // Most angles met in a control loop are small already: keep their last bit.
    if rad > -PI && rad <= PI {
        return rad;
    }
    let positive_rad = rad.rem_euclid(TAU);
    if positive_rad > PI { positive_rad - TAU } else { positive_rad }
}

/// The angle equivalent to `rad` in [0, 2π), as bearings are written. NaN and infinities give NaN.
#[inline]
pub fn wrap_positive(rad: f64) -> f64 {
    let positive_rad = rad.rem_euclid(TAU);
    // A negative angle smaller than half a unit in the last place of 2π rounds up to 2π itself.
    if positive_rad >= TAU { 0.0 } else { positive_rad }
}

/// The angle equivalent to `rad` that lies within π of `reference_rad`: removes the jump of a wrapped
/// angle when it is followed in time.
#[inline]
pub fn unwrap_near(rad: f64, reference_rad: f64) -> f64 {
    reference_rad + ssa(rad - reference_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ends_of_the_interval() {
        assert_eq!(ssa(PI), PI);
        assert_eq!(ssa(-PI), PI);
        assert_eq!(ssa(0.0), 0.0);
        assert_eq!(ssa(-1e-300), -1e-300);
        assert_eq!(wrap_positive(-1e-300), 0.0);
        assert!((ssa(PI + 0.1) - (0.1 - PI)).abs() < 1e-15);
    }

    #[test]
    fn what_is_not_a_number_stays_so() {
        for rad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(ssa(rad).is_nan());
            assert!(wrap_positive(rad).is_nan());
        }
    }

    proptest! {
        #[test]
        fn same_direction_within_range(rad in -1e4..1e4) {
            let small_rad = ssa(rad);
            prop_assert!(small_rad > -PI && small_rad <= PI);
            prop_assert!((small_rad.sin() - rad.sin()).abs() < 1e-9);
            prop_assert!((small_rad.cos() - rad.cos()).abs() < 1e-9);
            let bearing_rad = wrap_positive(rad);
            prop_assert!((0.0..TAU).contains(&bearing_rad));
            prop_assert!(ssa(bearing_rad - rad).abs() < 1e-9);
        }

        #[test]
        fn unwrapping_stays_near(rad in -50.0..50.0, reference_rad in -50.0..50.0) {
            let near_rad = unwrap_near(rad, reference_rad);
            prop_assert!((near_rad - reference_rad).abs() <= PI + 1e-12);
            prop_assert!(ssa(near_rad - rad).abs() < 1e-9);
        }
    }
}
