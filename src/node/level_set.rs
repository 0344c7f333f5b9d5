//! The level-set film: `Σ_j g(d_j) = g(1)` with `g(d) = (1 - d²/R²)³` inside R, `d_j` the distance to strut ray j
//! over the strut's radius there (for a cone: minus its growth, so that d_j = 1 is the cone).
//! The project's own fall-back, not from the paper. Along a ray from the node every d_j grows linearly, so the
//! sum falls and meets its level exactly once: star-shaped by proof. It is the cylinder wherever all other struts are R away.

use crate::node::Hit;
use crate::node::star::Star;
use glam::DVec3;

/// Largest blend reach R, in node radii: where the cuts leave room for it (λ = 0.3 at a right angle leaves 1.3).
const REACH: f64 = 1.3;

#[derive(Clone, Debug)]
pub struct LevelSet {
    star: Star,
    /// R: the least d_j of a rim circle of another strut, at most `REACH`.
    reach: f64,
}

impl LevelSet {
    pub fn new(star: &Star) -> LevelSet {
        let mut reach = REACH;
        for (i, (&c, &cut)) in star.axes.iter().zip(&star.cuts).enumerate() {
            for (j, &other) in star.axes.iter().enumerate() {
                if i != j {
                    // the nearest point of a circle to a ray: on the side facing it, unless the ray's start is nearest
                    let side = other - other.dot(c) * c;
                    let toward = if side.length() > 1e-9 { side.normalize() } else { crate::node::star::perpendicular(c) };
                    reach = reach.min(distance(star, j, cut * c + star.rim_radius(i) * toward));
                }
            }
        }
        LevelSet { star: star.clone(), reach: reach.max(1.0 + 1e-3) }
    }

    /// The film along a direction (any length).
    pub fn hit(&self, direction: DVec3) -> Hit {
        let u = direction.normalize();
        // d_j = t k_j along the ray
        let least = (0..self.star.degree()).map(|j| distance(&self.star, j, u)).fold(f64::INFINITY, f64::min);
        let (mut low, mut high) = (1.0 / least, self.reach / least);
        for _ in 0..60 {
            let t = 0.5 * (low + high);
            if self.value(t * u) > self.bump(1.0) { low = t } else { high = t }
        }
        let distance = 0.5 * (low + high);
        Hit { distance, normal: -self.gradient(distance * u).normalize() }
    }

    fn bump(&self, d: f64) -> f64 {
        (1.0 - (d / self.reach).powi(2)).max(0.0).powi(3)
    }

    fn value(&self, p: DVec3) -> f64 {
        (0..self.star.degree()).map(|j| self.bump(distance(&self.star, j, p))).sum()
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let r2 = self.reach * self.reach;
        let term = |j: usize| {
            let c = self.star.axes[j];
            let ahead = p.dot(c).max(0.0);
            let d = distance(&self.star, j, p);
            let q = (1.0 - d * d / r2).max(0.0);
            let out = (p - ahead * c).normalize_or_zero();
            let slope = out - if ahead > 0.0 { self.star.tapers[j] } else { 0.0 } * c;
            -6.0 / r2 * q * q * d / self.star.radii[j] * slope
        };
        (0..self.star.degree()).map(term).sum()
    }
}

/// d_j of a point: homogeneous of degree 1, 1 on the surface of strut j.
fn distance(star: &Star, j: usize, p: DVec3) -> f64 {
    let c = star.axes[j];
    let ahead = p.dot(c).max(0.0);
    (p.distance(ahead * c) - star.tapers[j] * ahead) / star.radii[j]
}
