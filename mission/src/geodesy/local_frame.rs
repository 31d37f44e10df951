//! The plane a boat works on: tangent to the ellipsoid at an origin.

use super::{Geodetic, NorthEast};

/// WGS 84 equatorial radius a, metres.
const SEMI_MAJOR_M: f64 = 6_378_137.0;
/// WGS 84 flattening f.
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared, e² = f(2 − f).
const ECCENTRICITY_SQUARED: f64 = FLATTENING * (2.0 - FLATTENING);
/// Polar radius b = a(1 − f), metres.
const SEMI_MINOR_M: f64 = SEMI_MAJOR_M * (1.0 - FLATTENING);

type Vector3 = [f64; 3];

/// A local north-east frame: the plane tangent to WGS 84 at its origin.
///
/// Surface points are projected on the plane along the vertical of the origin by way of Earth-centred
/// coordinates (Fossen 2021, §2.3), both ways exactly. Against distance and azimuth over the ellipsoid the
/// plane is short by d³/6R²: 0.5 mm at 5 km, 3.3 cm at 20 km.
#[derive(Debug, Clone, Copy)]
pub struct LocalFrame {
    origin: Geodetic,
    origin_m: Vector3,
    north: Vector3,
    east: Vector3,
    down: Vector3,
}

impl LocalFrame {
    /// The frame at `origin`, which should be a valid position; an invalid one gives NaN results.
    pub fn new(origin: Geodetic) -> Self {
        let (sin_lat, cos_lat) = origin.latitude_deg.to_radians().sin_cos();
        let (sin_lon, cos_lon) = origin.longitude_deg.to_radians().sin_cos();
        Self {
            origin,
            origin_m: ecef_m(origin),
            north: [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat],
            east: [-sin_lon, cos_lon, 0.0],
            down: [-cos_lat * cos_lon, -cos_lat * sin_lon, -sin_lat],
        }
    }

    /// Where north and east are both zero.
    pub fn origin(&self) -> Geodetic {
        self.origin
    }

    /// The local coordinates of a position at sea level.
    pub fn to_local(&self, position: Geodetic) -> NorthEast {
        let point_m = ecef_m(position);
        let offset_m: Vector3 = std::array::from_fn(|axis| point_m[axis] - self.origin_m[axis]);
        NorthEast { north_m: dot(self.north, offset_m), east_m: dot(self.east, offset_m) }
    }

    /// The position at sea level of local coordinates: the inverse of [`LocalFrame::to_local`] within a
    /// thousand kilometres of the origin.
    pub fn to_geodetic(&self, local: NorthEast) -> Geodetic {
        let on_plane_m: Vector3 = std::array::from_fn(|axis| {
            self.origin_m[axis] + local.north_m * self.north[axis] + local.east_m * self.east[axis]
        });
        let depth_m = self.depth_of_ellipsoid_m(on_plane_m);
        let [x, y, z]: Vector3 = std::array::from_fn(|axis| on_plane_m[axis] + depth_m * self.down[axis]);
        // On the surface the geodetic latitude is closed: tan φ = z / ((1 − e²) √(x² + y²)).
        let latitude_rad = z.atan2((1.0 - ECCENTRICITY_SQUARED) * x.hypot(y));
        Geodetic { latitude_deg: latitude_rad.to_degrees(), longitude_deg: y.atan2(x).to_degrees() }
    }

    /// How far below a point of the plane the ellipsoid lies: the smaller root d of
    /// |p + d·down|² = 1 in coordinates scaled by the axes of the ellipsoid.
    fn depth_of_ellipsoid_m(&self, point_m: Vector3) -> f64 {
        let scale = |v: Vector3| [v[0] / SEMI_MAJOR_M, v[1] / SEMI_MAJOR_M, v[2] / SEMI_MINOR_M];
        let (point, down) = (scale(point_m), scale(self.down));
        let (a, b, c) = (dot(down, down), dot(point, down), dot(point, point) - 1.0);
        // Beyond the limb of the Earth there is no root; the nearest approach serves as well as any.
        let root = (b * b - a * c).max(0.0).sqrt();
        // Written without the difference of two nearly equal numbers: b is negative.
        c / (root - b)
    }
}

/// Earth-centred, Earth-fixed coordinates of a position at height zero, metres.
pub(super) fn ecef_m(position: Geodetic) -> Vector3 {
    let (sin_lat, cos_lat) = position.latitude_deg.to_radians().sin_cos();
    let (sin_lon, cos_lon) = position.longitude_deg.to_radians().sin_cos();
    let normal_radius_m = SEMI_MAJOR_M / (1.0 - ECCENTRICITY_SQUARED * sin_lat * sin_lat).sqrt();
    [
        normal_radius_m * cos_lat * cos_lon,
        normal_radius_m * cos_lat * sin_lon,
        normal_radius_m * (1.0 - ECCENTRICITY_SQUARED) * sin_lat,
    ]
}

fn dot(a: Vector3, b: Vector3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
