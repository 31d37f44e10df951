use super::*;
use geographiclib_rs::{DirectGeodesic, Geodesic, InverseGeodesic};
use proptest::prelude::*;

/// The azimuthal-equidistant coordinates of `position` about `origin`: geodesic distance and azimuth.
fn azimuthal_equidistant(origin: Geodetic, position: Geodetic) -> NorthEast {
    let (distance_m, azimuth_deg, _, _): (f64, f64, f64, f64) = Geodesic::wgs84().inverse(
        origin.latitude_deg,
        origin.longitude_deg,
        position.latitude_deg,
        position.longitude_deg,
    );
    NorthEast::from_polar(distance_m, azimuth_deg.to_radians())
}

fn along_geodesic(origin: Geodetic, azimuth_deg: f64, distance_m: f64) -> Geodetic {
    let (latitude_deg, longitude_deg): (f64, f64) =
        Geodesic::wgs84().direct(origin.latitude_deg, origin.longitude_deg, azimuth_deg, distance_m);
    Geodetic { latitude_deg, longitude_deg }
}

#[test]
fn within_a_millimetre_of_the_geodesic_at_five_kilometres() {
    let mut worst_m: f64 = 0.0;
    for latitude_deg in [-78.0, -43.5, -0.3, 0.0, 22.2, 45.0, 59.9, 63.4, 85.0] {
        let origin = Geodetic::new(latitude_deg, 10.4);
        let frame = LocalFrame::new(origin);
        for azimuth_deg in (0..360).step_by(15) {
            let position = along_geodesic(origin, f64::from(azimuth_deg), 5_000.0);
            let error_m = (frame.to_local(position) - azimuthal_equidistant(origin, position)).norm();
            worst_m = worst_m.max(error_m);
        }
    }
    assert!(worst_m < 1e-3, "worst error {worst_m} m");
    assert!(worst_m > 1e-4, "the comparison is with itself: {worst_m} m");
}

#[test]
fn the_frame_has_its_origin_and_axes() {
    let frame = LocalFrame::new(Geodetic::new(63.4389, 10.399));
    assert!(frame.to_local(frame.origin()).norm() < 1e-9);
    let north = frame.to_local(Geodetic::new(63.4399, 10.399));
    assert!(north.north_m > 111.0 && north.north_m < 112.0 && north.east_m.abs() < 1e-9);
    let east = frame.to_local(Geodetic::new(63.4389, 10.400));
    assert!(east.east_m > 49.0 && east.east_m < 51.0 && east.north_m.abs() < 1e-3);
}

#[test]
fn works_across_the_antimeridian() {
    let frame = LocalFrame::new(Geodetic::new(-17.0, 179.9999));
    let east = frame.to_local(Geodetic::new(-17.0, -179.9999));
    assert!((east.east_m - 21.3).abs() < 0.1, "{east:?}");
}

#[test]
fn says_what_is_wrong_with_a_position() {
    let fault = |latitude_deg, longitude_deg| Geodetic::new(latitude_deg, longitude_deg).check();
    assert_eq!(fault(0.0, 0.0), Err(PositionFault::NoPosition));
    assert_eq!(fault(91.0, 0.0), Err(PositionFault::Latitude(91.0)));
    assert_eq!(fault(0.0, -180.1), Err(PositionFault::Longitude(-180.1)));
    assert_eq!(fault(f64::NAN, 0.0), Err(PositionFault::NotFinite));
    assert_eq!(fault(0.0, 7.5), Ok(()));
    assert!(!Geodetic::default().is_valid());
}

#[test]
fn nonsense_in_nonsense_out_without_a_panic() {
    let frame = LocalFrame::new(Geodetic::new(f64::NAN, 1e300));
    assert!(!frame.to_local(Geodetic::new(1.0, 1.0)).is_finite());
    let frame = LocalFrame::new(Geodetic::new(10.0, 10.0));
    let far = frame.to_geodetic(NorthEast::new(1e9, 0.0));
    assert!(far.latitude_deg.is_finite());
    assert_eq!(Geodetic::new(f64::NAN, 1e300).to_e7(), (0, i32::MAX));
}

proptest! {
    #[test]
    fn there_and_back_within_a_micrometre(
        latitude_deg in -85.0..85.0, longitude_deg in -180.0..180.0,
        north_m in -20e3..20e3, east_m in -20e3..20e3,
    ) {
        let frame = LocalFrame::new(Geodetic::new(latitude_deg, longitude_deg));
        let local = NorthEast::new(north_m, east_m);
        let error_m = (frame.to_local(frame.to_geodetic(local)) - local).norm();
        prop_assert!(error_m < 1e-6, "{} m", error_m);
    }

    #[test]
    fn integers_round_to_half_a_step(latitude_deg in -90.0..90.0, longitude_deg in -180.0..180.0) {
        let position = Geodetic::new(latitude_deg, longitude_deg);
        let (latitude_e7, longitude_e7) = position.to_e7();
        let back = Geodetic::from_e7(latitude_e7, longitude_e7);
        prop_assert!((back.latitude_deg - latitude_deg).abs() <= 0.51e-7);
        prop_assert!((back.longitude_deg - longitude_deg).abs() <= 0.51e-7);
        prop_assert_eq!(back.to_e7(), (latitude_e7, longitude_e7));
    }

    #[test]
    fn distance_agrees_with_the_geodesic(
        latitude_deg in -85.0..85.0, azimuth_deg in 0.0..360.0, distance_m in 1.0..100e3,
    ) {
        let here = Geodetic::new(latitude_deg, -5.65);
        let there = along_geodesic(here, azimuth_deg, distance_m);
        prop_assert!((here.distance_m(there) - distance_m).abs() < 0.02);
    }
}
