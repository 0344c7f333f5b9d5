//! Floor: plain geometry and numbers that every layer may use. Knows nothing of lattices.

pub mod bernstein;
pub mod gauss;
pub mod nurbs;
pub mod sparse;

use glam::DVec3;

/// The angle between two unit vectors, exact also near 0 and π. Radians.
pub fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
