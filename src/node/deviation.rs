//! Signed distance to the original node: the union of the half cylinders from the node and the node sphere, all of radius 1
//! (Luo & Zou 2025, footnote 1; Case study 1 measures the new node against it). The formulas are this project's own.
//!
//! A point p is in the union where its distance to some strut's half axis is at most 1. Outside, the distance to a union is the
//! least of the distances to its parts. Inside that is a bound only, since much of each part's surface lies inside the others. The nearest
//! point of what is left of the surface is one of
//! - the foot of p on a cylinder or on the sphere, where no other part covers it;
//! - the nearest point of a crease, the arc of an ellipse in which two cylinders meet, ends (where three meet) included.
//!
//! Sphere and cylinders touch along whole circles, without a crease. Not promised: points on an axis or at the node, which have no single foot
//! (one is chosen, so the depth may be off).
//! Struts of one radius, without taper: creases of others are no ellipses.

use crate::node::star::{Star, angle, perpendicular};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// How far inside another part a foot may lie and count as on the surface, in radii: above round-off.
const COVER: f64 = 1e-12;

/// The original shape of a node. Node units.
#[derive(Clone, Debug)]
pub struct Original {
    /// Unit vectors along the struts.
    axes: Vec<DVec3>,
    creases: Vec<Crease>,
}

/// What is left of the ellipse y(φ) = long cos φ `a` + sin φ `n` in which two unit cylinders meet, |φ| <= 90°.
#[derive(Clone, Debug)]
struct Crease {
    /// Unit vector between both struts: along the long half axis.
    a: DVec3,
    /// Unit normal of the plane of both struts: along the short half axis.
    n: DVec3,
    /// Half axis along `a`, 1/sin(θ/2) >= 1. The other is 1.
    long: f64,
    /// First and last φ, radians.
    ends: [f64; 2],
}

impl Original {
    /// Fails for struts of different radii or with taper.
    pub fn new(star: &Star) -> Result<Original, String> {
        if !star.is_of_equal_cylinders() {
            return Err("the distance to the original node is known for struts of one radius without taper only".into());
        }
        let axes = star.axes.clone();
        let pairs = (0..axes.len()).flat_map(|i| (i + 1..axes.len()).map(move |j| (i, j)));
        let creases = pairs.filter_map(|(i, j)| Crease::new(&axes, i, j)).collect();
        Ok(Original { axes, creases })
    }

    /// Distance of `p` to the surface: positive outside, negative inside.
    pub fn distance(&self, p: DVec3) -> f64 {
        let bound = self.to_parts(p);
        if bound >= 0.0 { bound } else { -self.depth(p) }
    }

    /// The least signed distance to a part: exact outside, inside -(a lower bound of the depth).
    fn to_parts(&self, p: DVec3) -> f64 {
        let nearest_sq = |least: f64, c: &DVec3| least.min((p - p.dot(*c).max(0.0) * *c).length_squared());
        self.axes.iter().fold(p.length_squared(), nearest_sq).sqrt() - 1.0
    }

    /// Distance to the surface of a point inside.
    fn depth(&self, p: DVec3) -> f64 {
        let mut least = f64::INFINITY;
        if self.axes.iter().all(|c| p.dot(*c) <= 0.0) {
            least = 1.0 - p.length();
        }
        for &c in &self.axes {
            let height = p.dot(c);
            let off = p - height * c;
            let gap = (off.length() - 1.0).abs();
            if height < 0.0 || gap >= least {
                continue;
            }
            let foot = height * c + off.try_normalize().unwrap_or_else(|| perpendicular(c));
            // |foot|² = height² + 1, so it lies in the cylinder of another strut where that strut's height is larger
            if self.axes.iter().all(|other| foot.dot(*other) <= height + COVER) {
                least = gap;
            }
        }
        self.creases.iter().fold(least, |least, crease| crease.nearest(p, least))
    }
}

impl Crease {
    /// The crease of struts i and j, as far as no other cylinder covers it; none where nothing is left.
    fn new(axes: &[DVec3], i: usize, j: usize) -> Option<Crease> {
        let theta = angle(axes[i], axes[j]);
        // cylinders of opposite struts touch, as with the sphere
        let a = (axes[i] + axes[j]).try_normalize()?;
        let n = axes[i].cross(axes[j]).try_normalize()?;
        let long = 1.0 / (0.5 * theta).sin();
        // strut k covers the crease where y . (c_k - c_i) > 0: bounds on tan φ
        let mut tan = [f64::NEG_INFINITY, f64::INFINITY];
        for (k, &c) in axes.iter().enumerate().filter(|&(k, _)| k != i && k != j) {
            let apart = c - axes[i];
            let (p, q) = (long * apart.dot(a), apart.dot(n));
            debug_assert!(p != 0.0 || q != 0.0, "struts {k}, {i} and {j} are not three");
            if q > 0.0 {
                tan[1] = tan[1].min(-p / q);
            } else if q < 0.0 {
                tan[0] = tan[0].max(-p / q);
            } else if p > 0.0 {
                return None;
            }
        }
        let ends = tan.map(f64::atan);
        (ends[0] < ends[1]).then_some(Crease { a, n, long, ends })
    }

    /// The distance of `p` to the crease, if it is below `least`; else `least`.
    fn nearest(&self, p: DVec3, least: f64) -> f64 {
        let (x, z) = (p.dot(self.a), p.dot(self.n));
        let aside_sq = p.length_squared() - x * x - z * z;
        if aside_sq >= least * least {
            return least;
        }
        least.min((aside_sq.max(0.0) + self.nearest_sq(x, z)).sqrt())
    }

    /// Square of the least distance from (x, z) in the plane of the ellipse, x along `a` and z along `n`.
    ///
    /// Half the slope of the squared distance is cos φ g(φ), g = (1 - long²) sin φ + long x tan φ - z. Its own slope vanishes where
    /// cos³ φ = long x / (long² - 1): g grows beyond that angle on both sides, and only there can the distance have minima, one a side.
    fn nearest_sq(&self, x: f64, z: f64) -> f64 {
        let distance_sq = |phi: f64| (self.long * phi.cos() - x).powi(2) + (phi.sin() - z).powi(2);
        let [first, last] = self.ends;
        let least = distance_sq(first).min(distance_sq(last));
        let (bend, pull) = (self.long * self.long - 1.0, self.long * x);
        if pull <= 0.0 {
            return least;
        }
        let turn = if pull < bend { (pull / bend).cbrt().acos() } else { 0.0 };
        // half the slope, and its own slope
        let slope = |phi: f64| {
            let (sin, cos) = phi.sin_cos();
            ((pull - bend * cos) * sin - z * cos, pull * cos - bend * (cos * cos - sin * sin) + z * sin)
        };
        [[first.max(turn), last], [first, last.min(-turn)]].into_iter().filter_map(|range| root(slope, range)).map(distance_sq).fold(least, f64::min)
    }
}

/// The root of a function that goes once from negative to positive in a range, none where it does not: Newton's method kept inside by
/// bisection. To 1e-9: where a distance is least, that is its error squared.
fn root(f: impl Fn(f64) -> (f64, f64), [mut low, mut high]: [f64; 2]) -> Option<f64> {
    if !(low < high && f(low).0 <= 0.0 && f(high).0 >= 0.0) {
        return None;
    }
    debug_assert!(low >= -FRAC_PI_2 && high <= FRAC_PI_2);
    let mut at = 0.5 * (low + high);
    while high - low > 1e-9 {
        let (value, slope) = f(at);
        if value < 0.0 {
            low = at
        } else {
            high = at
        }
        let next = at - value / slope;
        let inside = next > low && next < high;
        let step = (next - at).abs();
        at = if inside { next } else { 0.5 * (low + high) };
        if inside && step < 1e-9 {
            break;
        }
    }
    Some(at)
}
