//! Rational B-spline curves and surfaces: storage and evaluation.
//! Source: Piegl & Tiller, The NURBS Book, algorithms A2.1-A2.3 and equation 4.20.

use glam::DVec3;
use std::sync::Arc;

/// A clamped rational B-spline curve. `knots.len() == points.len() + degree + 1`.
#[derive(Clone, Debug)]
pub struct NurbsCurve {
    pub degree: usize,
    /// Full knot vector (end knots `degree + 1` times), non-decreasing.
    pub knots: Arc<[f64]>,
    /// Cartesian control points (not premultiplied by the weights).
    pub points: Vec<DVec3>,
    /// One positive weight per control point.
    pub weights: Vec<f64>,
}

/// A clamped rational B-spline surface over `u × v`.
#[derive(Clone, Debug)]
pub struct NurbsSurface {
    /// Degree in u and v.
    pub degree: [usize; 2],
    /// Full knot vectors in u and v.
    pub knots: [Arc<[f64]>; 2],
    /// Cartesian control points, `points[iu * nv + iv]`.
    pub points: Vec<DVec3>,
    /// One positive weight per control point, same order.
    pub weights: Vec<f64>,
}

/// Position and first derivatives of a surface at one parameter.
#[derive(Clone, Copy, Debug)]
pub struct Jet1 {
    pub p: DVec3,
    pub du: DVec3,
    pub dv: DVec3,
}
