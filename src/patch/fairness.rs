//! How fair a skin is: mean curvature and its variation over the patches, from exact first and second derivatives.
//! Source: the first and second fundamental forms (do Carmo, *Differential Geometry of Curves and Surfaces*, section 3.3).
//! Mean curvature is positive where the solid bulges: 1/2 on a strut of radius 1. Node units.

use crate::math::gauss;
use crate::math::nurbs::{Jet2, NurbsSurface};
use crate::patch::{Skin, SkinCurve};

/// Gauss points each way on a patch.
const POINTS: usize = 16;
/// Step in u and v of the differences that give the slope of the mean curvature. The outermost Gauss points keep inside by 5e-3.
const STEP: f64 = 1e-4;
/// Places along an inner edge where the curvatures of both patches are compared.
const ALONG: usize = 9;

/// Sums over the patches of a skin; r is the strut radius.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fairness {
    /// In r².
    pub area: f64,
    /// Largest absolute mean curvature, in 1/r.
    pub most_mean: f64,
    /// The absolute mean curvature that 99 % of the area keeps to, in 1/r.
    pub usual_mean: f64,
    /// Largest concave curvature, and the one that 99 % of the area keeps below: 1 over the radius of the tightest valley. In 1/r, 0 where nothing
    /// is concave.
    pub most_concave: f64,
    pub usual_concave: f64,
    /// Thin-plate energy ∫ k1² + k2² dA, without unit; on a cylinder it is the area.
    pub thin_plate: f64,
    /// Variation of the mean curvature ∫ |grad H|² dA, in 1/r².
    pub variation: f64,
    /// Largest difference of the mean curvatures of two patches at their common edge, in 1/r: normals agree there, curvatures need not.
    pub most_jump: f64,
}

/// First fundamental form, and curvatures, at a point.
struct Curved {
    /// E, F, G.
    first: [f64; 3],
    mean: f64,
    gauss: f64,
}

impl Curved {
    fn new(jet: &Jet2) -> Curved {
        let normal = jet.du.cross(jet.dv).normalize();
        let first @ [e, f, g] = [jet.du.dot(jet.du), jet.du.dot(jet.dv), jet.dv.dot(jet.dv)];
        let [l, m, n] = [jet.duu, jet.duv, jet.dvv].map(|d| d.dot(normal));
        let det = e * g - f * f;
        Curved { first, mean: -(e * n - 2.0 * f * m + g * l) / (2.0 * det), gauss: (l * n - m * m) / det }
    }

    /// Square of the length of a gradient with the slopes `hu`, `hv`, and the area element.
    fn gradient_sq(&self, hu: f64, hv: f64) -> f64 {
        let [e, f, g] = self.first;
        (g * hu * hu - 2.0 * f * hu * hv + e * hv * hv) / (e * g - f * f)
    }

    /// Minus the smaller principal curvature, at least 0.
    fn concave(&self) -> f64 {
        ((self.mean * self.mean - self.gauss).max(0.0).sqrt() - self.mean).max(0.0)
    }

    fn area(&self) -> f64 {
        let [e, f, g] = self.first;
        (e * g - f * f).sqrt()
    }
}

impl Fairness {
    fn raise(&mut self, at: &Curved) {
        self.most_mean = self.most_mean.max(at.mean.abs());
        self.most_concave = self.most_concave.max(at.concave());
    }
}

/// Mean curvature at (u, v), in 1/r.
pub fn mean(surface: &NurbsSurface, u: f64, v: f64) -> f64 {
    Curved::new(&surface.jet2(u, v)).mean
}

/// Mean curvature, and largest concave curvature (minus the smaller principal one, at least 0), at several u of one v, in 1/r.
pub fn curvatures(surface: &NurbsSurface, us: impl Iterator<Item = f64>, v: f64) -> impl Iterator<Item = (f64, f64)> {
    surface.jets2(us, v).map(|jet| {
        let at = Curved::new(&jet);
        (at.mean, at.concave())
    })
}

/// Measure all patches of a skin and the edges between them.
pub fn measure(skin: &Skin) -> Fairness {
    let mut sum = Fairness::default();
    let mut shares = [vec![], vec![]];
    for patch in &skin.patches {
        add(&mut sum, &mut shares, &patch.surface);
    }
    [sum.usual_mean, sum.usual_concave] = shares.map(|mut values| share(&mut values, 0.99));
    jumps(&mut sum, skin);
    sum
}

/// The value that a share of the area does not exceed; values come with their areas.
pub fn share(values: &mut [(f64, f64)], share: f64) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut left = share * values.iter().map(|m| m.1).sum::<f64>();
    let last = values.iter().find(|(_, area)| {
        left -= area;
        left <= 0.0
    });
    last.map_or(0.0, |m| m.0)
}

/// Measure one patch over [0, 1]²; absolute mean curvatures and concave curvatures go to `shares`, with the areas they stand for.
fn add(sum: &mut Fairness, shares: &mut [Vec<(f64, f64)>; 2], surface: &NurbsSurface) {
    let rule = gauss::rule(POINTS);
    for &(u, wu) in &rule {
        for &(v, wv) in &rule {
            let at = Curved::new(&surface.jet2(u, v));
            let hu = (mean(surface, u + STEP, v) - mean(surface, u - STEP, v)) / (2.0 * STEP);
            let hv = (mean(surface, u, v + STEP) - mean(surface, u, v - STEP)) / (2.0 * STEP);
            let area = wu * wv * at.area();
            sum.area += area;
            sum.raise(&at);
            shares[0].push((at.mean.abs(), area));
            shares[1].push((at.concave(), area));
            // k1² + k2² = (k1 + k2)² - 2 k1 k2
            sum.thin_plate += area * (4.0 * at.mean * at.mean - 2.0 * at.gauss);
            sum.variation += area * at.gradient_sq(hu, hv);
        }
    }
}

/// Compare mean curvatures along the inner edges.
fn jumps(sum: &mut Fairness, skin: &Skin) {
    sum.most_jump = most_jump(skin, |patch, side| {
        std::array::from_fn::<_, ALONG, _>(|k| {
            let x = k as f64 / (ALONG - 1) as f64;
            let [u, v] = [[x, 0.0], [1.0, x], [1.0 - x, 1.0], [0.0, 1.0 - x]][side];
            let at = Curved::new(&skin.patches[patch].surface.jet2(u, v));
            sum.raise(&at);
            at.mean
        })
    });
}

/// The largest difference, along the inner edges, of what the two patches have there; `along` gives it for the side of a patch (as in `boundary`), in that side's own sense.
pub fn most_jump<const N: usize>(skin: &Skin, mut along: impl FnMut(usize, usize) -> [f64; N]) -> f64 {
    let mut first: Vec<Option<[f64; N]>> = vec![None; skin.edges.len()];
    let mut most = 0.0f64;
    for (k, patch) in skin.patches.iter().enumerate() {
        for (side, &(edge, forward)) in patch.boundary.iter().enumerate() {
            let mut along = along(k, side);
            if matches!(skin.edges[edge].curve, SkinCurve::RimArc(_)) {
                continue;
            }
            if !forward {
                along.reverse();
            }
            match first[edge] {
                None => first[edge] = Some(along),
                Some(other) => most = other.iter().zip(along).fold(most, |most, (a, b)| most.max((a - b).abs())),
            }
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::f64::consts::FRAC_PI_2;

    /// A quarter of the outer upper quarter of a torus: radius of the tube 1, of its centre line `far`; u runs around, v up.
    fn torus(far: f64) -> NurbsSurface {
        let (quarter, weights) = ([(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], [1.0, 0.5f64.sqrt(), 1.0]);
        let place = |(c, s): (f64, f64), (x, z): (f64, f64)| DVec3::new(c * (far + x), s * (far + x), z);
        NurbsSurface {
            degree: [2, 2],
            knots: [0, 1].map(|_| [0.0, 0.0, 0.0, 1.0, 1.0, 1.0].into()),
            points: quarter.iter().flat_map(|&a| quarter.map(|p| place(a, p))).collect(),
            weights: weights.iter().flat_map(|a| weights.map(|b| a * b)).collect(),
        }
    }

    #[test]
    fn a_torus_as_by_its_formulas() {
        let far = 3.0;
        let mut found = Fairness::default();
        let mut shares = [vec![], vec![]];
        add(&mut found, &mut shares, &torus(far));
        // curvatures 1 and cos t / (far + cos t), t the angle around the tube; area element far + cos t
        let integral = |f: &dyn Fn(f64) -> f64| -> f64 {
            gauss::rule(30).iter().map(|&(x, w)| w * FRAC_PI_2 * FRAC_PI_2 * f(FRAC_PI_2 * x) * (far + (FRAC_PI_2 * x).cos())).sum()
        };
        let other = |t: f64| t.cos() / (far + t.cos());
        let slope = |t: f64| -0.5 * far * t.sin() / (far + t.cos()).powi(2);
        for (name, found, wanted) in [
            ("area", found.area, integral(&|_| 1.0)),
            ("thin plate", found.thin_plate, integral(&|t| 1.0 + other(t).powi(2))),
            ("variation", found.variation, integral(&|t| slope(t).powi(2))),
        ] {
            assert!((found / wanted - 1.0).abs() < 1e-6, "{name}: {found} instead of {wanted}");
        }
        // mean curvature falls from 0.625 at t = 0; the share of the area beyond t is 1 - (far t + sin t) / (far π/2 + 1)
        let median = share(&mut shares[0], 0.5);
        let t = (2.0 * median - 1.0) * far / (2.0 - 2.0 * median);
        assert!((t.acos() * far + t.acos().sin() - 0.5 * (far * FRAC_PI_2 + 1.0)).abs() < 0.1, "{median}");
        assert!(found.most_mean < 0.625 && found.most_mean > 0.6249, "{}", found.most_mean);
    }

    #[test]
    fn the_sign_is_that_of_a_bulge() {
        assert!((mean(&torus(3.0), 0.3, 0.0) - 0.625).abs() < 1e-12);
    }
}
