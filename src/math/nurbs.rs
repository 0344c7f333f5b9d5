//! Rational B-spline curves and surfaces: storage and evaluation.
//! Source: Piegl & Tiller, The NURBS Book, algorithms A2.1-A2.3 and equation 4.20.

use crate::math::{Loops, vectorised};
use glam::{DVec3, DVec4};
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
    pub weights: Arc<[f64]>,
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
    pub weights: Arc<[f64]>,
}

/// Highest degree that evaluation supports (the basis lives on the stack).
pub const MAX_DEGREE: usize = 11;

/// The `degree + 1` basis functions that do not vanish on one knot span: `[0]` values,
/// `[1]` first and `[2]` second derivatives.
pub type Basis = [[f64; MAX_DEGREE + 1]; 3];

/// Position and first derivatives of a surface at one parameter.
#[derive(Clone, Copy, Debug)]
pub struct Jet1 {
    pub p: DVec3,
    pub du: DVec3,
    pub dv: DVec3,
}

/// Position, first and second derivatives of a surface at one parameter.
#[derive(Clone, Copy, Debug)]
pub struct Jet2 {
    pub p: DVec3,
    pub du: DVec3,
    pub dv: DVec3,
    pub duu: DVec3,
    pub duv: DVec3,
    pub dvv: DVec3,
}

/// Position and first derivative of a curve at one parameter.
#[derive(Clone, Copy, Debug)]
pub struct CurveJet1 {
    pub p: DVec3,
    pub d: DVec3,
}

/// Index `s` with `knots[s] <= t < knots[s + 1]` (A2.1); at the upper end of the domain the last
/// span that is not empty. Parameters outside of the domain get the nearest span (and so the
/// polynomial continuation).
pub fn span(degree: usize, knots: &[f64], t: f64) -> usize {
    let last = knots.len() - degree - 2;
    let inner = &knots[degree + 1..=last];
    degree + inner.partition_point(|&k| k <= t)
}

/// Basis functions and their derivatives up to `order` (at most 2) on span `s` (A2.3).
/// Rows above `order` stay zero.
pub fn basis(degree: usize, knots: &[f64], s: usize, t: f64, order: usize) -> Basis {
    debug_assert!(degree <= MAX_DEGREE && order <= 2);
    if knots.len() == 2 * (degree + 1) && knots[0] == 0.0 && knots[degree + 1] == 1.0 {
        return bezier_basis(degree, t, order);
    }
    spline_basis(degree, knots, s, t, order)
}

/// The same on the one span from 0 to 1, without its divisions by 1; the same bits.
fn bezier_basis(degree: usize, t: f64, order: usize) -> Basis {
    let mut out = [[0.0; MAX_DEGREE + 1]; 3];
    let mut value = [0.0; MAX_DEGREE + 1];
    value[0] = 1.0;
    for p in 0..=degree {
        if p > 0 {
            let mut saved = 0.0;
            for v in &mut value[..p] {
                let before = *v;
                *v = saved + (1.0 - t) * before;
                saved = t * before;
            }
            value[p] = saved;
        }
        // derivatives of order k start from the values of degree `degree - k`
        let k = degree - p;
        if (1..=order).contains(&k) {
            out[k] = (1..=k).fold(value, |lower, raised| {
                let p = p + raised;
                let mut row = [0.0; MAX_DEGREE + 1];
                for r in 0..p {
                    let slope = p as f64 * lower[r];
                    row[r] -= slope;
                    row[r + 1] += slope;
                }
                row
            });
        }
    }
    out[0] = value;
    out
}

fn spline_basis(degree: usize, knots: &[f64], s: usize, t: f64, order: usize) -> Basis {
    let mut out = [[0.0; MAX_DEGREE + 1]; 3];
    // `low[k]` keeps the values of degree `degree - k`, which the derivatives of order k need.
    let mut low = [[0.0; MAX_DEGREE + 1]; 3];
    let mut value = [0.0; MAX_DEGREE + 1];
    value[0] = 1.0;
    for p in 0..=degree {
        if p > 0 {
            let mut saved = 0.0;
            for r in 0..p {
                let (left, right) = (knots[s + 1 + r - p], knots[s + 1 + r]);
                let ratio = value[r] / (right - left);
                value[r] = saved + (right - t) * ratio;
                saved = (t - left) * ratio;
            }
            value[p] = saved;
        }
        if degree - p <= 2 {
            low[degree - p] = value;
        }
    }
    out[0] = low[0];
    if order >= 1 && degree >= 1 {
        out[1] = derive(degree, knots, s, &low[1]);
    }
    if order >= 2 && degree >= 2 {
        out[2] = derive(degree, knots, s, &derive(degree - 1, knots, s, &low[2]));
    }
    out
}

/// From `Σ c_i N_{i, p-1}` derivatives to those of degree p, on span `s` (eq. 2.7):
/// `N'_{i,p} = p (N_{i,p-1} / (t_{i+p} - t_i) - N_{i+1,p-1} / (t_{i+p+1} - t_{i+1}))`.
fn derive(p: usize, knots: &[f64], s: usize, lower: &[f64; MAX_DEGREE + 1]) -> [f64; MAX_DEGREE + 1] {
    let mut out = [0.0; MAX_DEGREE + 1];
    for r in 0..p {
        // Basis function of degree p - 1 with index s - p + 1 + r; its support is p knots long.
        let i = s + 1 + r - p;
        let slope = p as f64 * lower[r] / (knots[i + p] - knots[i]);
        out[r] -= slope;
        out[r + 1] += slope;
    }
    out
}

/// First and last parameter of a clamped knot vector.
pub fn domain(degree: usize, knots: &[f64]) -> [f64; 2] {
    [knots[degree], knots[knots.len() - degree - 1]]
}

/// The ends of the spans that are not empty, first and last parameter included.
pub fn breaks(degree: usize, knots: &[f64]) -> Vec<f64> {
    let mut out = knots[degree..knots.len() - degree].to_vec();
    out.dedup();
    out
}

/// Values and slopes of the basis functions of one knot vector at fixed parameters, for many curves or surfaces over it.
#[derive(Clone, Debug)]
pub struct Table {
    degree: usize,
    knots: Arc<[f64]>,
    samples: Vec<Sample>,
}

/// One parameter of a [`Table`].
#[derive(Clone, Debug)]
pub struct Sample {
    /// First control point with a basis function here.
    pub first: usize,
    pub value: [f64; MAX_DEGREE + 1],
    pub slope: [f64; MAX_DEGREE + 1],
}

impl Table {
    pub fn new(degree: usize, knots: &Arc<[f64]>, parameters: impl Iterator<Item = f64>) -> Table {
        let sample = |t: f64| {
            let s = span(degree, knots, t);
            let [value, slope, _] = basis(degree, knots, s, t, 1);
            Sample { first: s - degree, value, slope }
        };
        Table { degree, knots: knots.clone(), samples: parameters.map(sample).collect() }
    }

    /// `count` parameters (at least 2) in equal steps over the domain, ends included.
    pub fn even(degree: usize, knots: &Arc<[f64]>, count: usize) -> Table {
        let [a, b] = domain(degree, knots);
        Table::new(degree, knots, (0..count).map(|k| if k + 1 == count { b } else { a + k as f64 / (count - 1) as f64 * (b - a) }))
    }

    /// Whether this table serves curves of this degree and knot vector.
    pub fn fits(&self, degree: usize, knots: &Arc<[f64]>) -> bool {
        self.degree == degree && (Arc::ptr_eq(&self.knots, knots) || self.knots == *knots)
    }

    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }
}

impl NurbsCurve {
    /// The points at all parameters of a table that fits; the same bits as `point`.
    pub fn points_at(&self, table: &Table) -> impl Iterator<Item = DVec3> {
        debug_assert!(table.fits(self.degree, &self.knots));
        table.samples.iter().map(|sample| {
            let mut a = DVec4::ZERO;
            for r in 0..=self.degree {
                let w = self.weights[sample.first + r];
                a += sample.value[r] * (self.points[sample.first + r] * w).extend(w);
            }
            a.truncate() / a.w
        })
    }

    /// First and last parameter.
    pub fn domain(&self) -> [f64; 2] {
        domain(self.degree, &self.knots)
    }

    /// The point at parameter `t`.
    pub fn point(&self, t: f64) -> DVec3 {
        let a = self.homogeneous(t, 0);
        a[0].truncate() / a[0].w
    }

    /// Point and first derivative at parameter `t`.
    pub fn jet1(&self, t: f64) -> CurveJet1 {
        let a = self.homogeneous(t, 1);
        let p = a[0].truncate() / a[0].w;
        CurveJet1 { p, d: (a[1].truncate() - a[1].w * p) / a[0].w }
    }

    /// Derivatives of (weight · point, weight) up to `order` (at most 1).
    fn homogeneous(&self, t: f64, order: usize) -> [DVec4; 2] {
        let s = span(self.degree, &self.knots, t);
        let b = basis(self.degree, &self.knots, s, t, order);
        let mut a = [DVec4::ZERO; 2];
        for r in 0..=self.degree {
            let i = s - self.degree + r;
            let w = self.weights[i];
            let h = (self.points[i] * w).extend(w);
            a[0] += b[0][r] * h;
            a[1] += b[1][r] * h;
        }
        a
    }
}

impl NurbsSurface {
    /// Number of control points in u and v.
    pub fn size(&self) -> [usize; 2] {
        [0, 1].map(|k| self.knots[k].len() - self.degree[k] - 1)
    }

    /// First and last parameter in u and in v.
    pub fn domain(&self) -> [[f64; 2]; 2] {
        [0, 1].map(|k| domain(self.degree[k], &self.knots[k]))
    }

    /// The point at `(u, v)`.
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        let a = self.homogeneous(u, v, 0);
        a[0][0].truncate() / a[0][0].w
    }

    /// Point and first derivatives at `(u, v)`.
    pub fn jet1(&self, u: f64, v: f64) -> Jet1 {
        let a = self.homogeneous(u, v, 1);
        let w = a[0][0].w;
        let p = a[0][0].truncate() / w;
        Jet1 { p, du: (a[1][0].truncate() - a[1][0].w * p) / w, dv: (a[0][1].truncate() - a[0][1].w * p) / w }
    }

    /// [`jet1`](Self::jet1) at all pairs of parameters of two tables that fit, `[iu * count of v + iv]`; the same bits.
    pub fn jets1(&self, tables: [&Table; 2]) -> Vec<Jet1> {
        debug_assert!([0, 1].iter().all(|&k| tables[k].fits(self.degree[k], &self.knots[k])));
        vectorised(Jets { surface: self, tables })
    }

    /// Point, first and second derivatives at `(u, v)` (eq. 4.20).
    pub fn jet2(&self, u: f64, v: f64) -> Jet2 {
        self.jets2(std::iter::once(u), v).next().expect("one parameter, one jet")
    }

    /// The same at several u of one v.
    pub fn jets2(&self, us: impl Iterator<Item = f64>, v: f64) -> impl Iterator<Item = Jet2> {
        let ([p, q], nv) = (self.degree, self.size()[1]);
        let sv = span(q, &self.knots[1], v);
        let bv = basis(q, &self.knots[1], sv, v, 2);
        // of each row of control points: (weight · point, weight) and its derivatives in v
        let mut rows = vec![[DVec4::ZERO; 3]; self.size()[0]];
        for (u, row) in rows.iter_mut().enumerate() {
            for c in 0..=q {
                let at = u * nv + sv - q + c;
                let w = self.weights[at];
                let h = (self.points[at] * w).extend(w);
                (0..3).for_each(|l| row[l] += bv[l][c] * h);
            }
        }
        us.map(move |u| {
            let su = span(p, &self.knots[0], u);
            let bu = basis(p, &self.knots[0], su, u, 2);
            let sum = |k: usize, l: usize| (0..=p).fold(DVec4::ZERO, |sum, r| sum + bu[k][r] * rows[su - p + r][l]);
            let [a, au, av, auu, auv, avv] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]].map(|[k, l]| sum(k, l));
            let w = a.w;
            let p = a.truncate() / w;
            let du = (au.truncate() - au.w * p) / w;
            let dv = (av.truncate() - av.w * p) / w;
            Jet2 {
                p,
                du,
                dv,
                duu: (auu.truncate() - 2.0 * au.w * du - auu.w * p) / w,
                duv: (auv.truncate() - au.w * dv - av.w * du - auv.w * p) / w,
                dvv: (avv.truncate() - 2.0 * av.w * dv - avv.w * p) / w,
            }
        })
    }

    /// Derivatives of (weight · point, weight), `[k][l]` k times in u and l times in v, up to `order` (at most 1) in all.
    fn homogeneous(&self, u: f64, v: f64, order: usize) -> [[DVec4; 2]; 2] {
        let [p, q] = self.degree;
        let nv = self.size()[1];
        let (su, sv) = (span(p, &self.knots[0], u), span(q, &self.knots[1], v));
        let bu = basis(p, &self.knots[0], su, u, order);
        let bv = basis(q, &self.knots[1], sv, v, order);
        let mut a = [[DVec4::ZERO; 2]; 2];
        for r in 0..=p {
            let at = (su - p + r) * nv + sv - q;
            let mut row = [DVec4::ZERO; 2];
            for c in 0..=q {
                let w = self.weights[at + c];
                let h = (self.points[at + c] * w).extend(w);
                (0..=order).for_each(|l| row[l] += bv[l][c] * h);
            }
            a[0][0] += bu[0][r] * row[0];
            a[0][1] += bu[0][r] * row[1];
            a[1][0] += bu[1][r] * row[0];
        }
        a
    }
}

/// Points and tangents of a surface at all pairs of parameters of two tables.
struct Jets<'a> {
    surface: &'a NurbsSurface,
    tables: [&'a Table; 2],
}

impl Loops for Jets<'_> {
    type Output = Vec<Jet1>;

    #[inline(always)]
    fn run(self) -> Vec<Jet1> {
        let Jets { surface, tables: [u, v] } = self;
        let [p, q] = surface.degree;
        let [nu, nv] = surface.size();
        let count = v.samples.len();
        // along v first: `[iu * count + sample]`, (weight · point, weight) and its v-derivative
        let mut rows = vec![[DVec4::ZERO; 2]; nu * count];
        let mut line = vec![DVec4::ZERO; nv];
        for (i, rows) in rows.chunks_exact_mut(count).enumerate() {
            for (h, (point, &w)) in line.iter_mut().zip(surface.points[i * nv..].iter().zip(&surface.weights[i * nv..])) {
                *h = (*point * w).extend(w);
            }
            for (row, sample) in rows.iter_mut().zip(&v.samples) {
                for (&h, (&value, &slope)) in line[sample.first..=sample.first + q].iter().zip(sample.value.iter().zip(&sample.slope)) {
                    row[0] += value * h;
                    row[1] += slope * h;
                }
            }
        }
        let mut out = Vec::with_capacity(u.samples.len() * count);
        for sample in &u.samples {
            for k in 0..count {
                let (mut a, mut au, mut av) = (DVec4::ZERO, DVec4::ZERO, DVec4::ZERO);
                let rows = rows[sample.first * count + k..].iter().step_by(count).take(p + 1);
                for (row, (&value, &slope)) in rows.zip(sample.value.iter().zip(&sample.slope)) {
                    a += value * row[0];
                    av += value * row[1];
                    au += slope * row[0];
                }
                let point = a.truncate() / a.w;
                out.push(Jet1 { p: point, du: (au.truncate() - au.w * point) / a.w, dv: (av.truncate() - av.w * point) / a.w });
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn one_span_has_the_bits_of_many() {
        for degree in 0..=MAX_DEGREE {
            let knots: Vec<f64> = [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat();
            for k in -3..=103 {
                let t = k as f64 / 100.0;
                for order in 0..=2 {
                    let bits = |basis: Basis| basis.map(|row| row.map(|x| (x + 0.0).to_bits()));
                    assert_eq!(bits(basis(degree, &knots, degree, t, order)), bits(spline_basis(degree, &knots, degree, t, order)), "{degree} {t} {order}");
                }
            }
        }
    }

    use super::*;

    /// A bumpy rational surface with inner knots, degrees 4 and 3.
    fn sample() -> NurbsSurface {
        let ku: Arc<[f64]> = [0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 0.7, 0.7, 2.0, 2.0, 2.0, 2.0, 2.0].into();
        let kv: Arc<[f64]> = [0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0].into();
        let mut points = vec![];
        let mut weights = vec![];
        for i in 0..8 {
            for j in 0..5 {
                let (x, y) = (i as f64, j as f64);
                points.push(DVec3::new(x, y, (1.3 * x + 0.7 * y * y).sin()));
                weights.push(1.0 + 0.3 * (x - 2.0 * y).cos());
            }
        }
        NurbsSurface { degree: [4, 3], knots: [ku, kv], points, weights: weights.into() }
    }

    #[test]
    fn derivatives_match_central_differences() {
        let s = sample();
        let h = 1e-5;
        for (u, v) in [(0.1, 0.2), (0.5, 0.7), (1.3, 0.9), (0.69, 0.49)] {
            let j = s.jet2(u, v);
            let du = (s.point(u + h, v) - s.point(u - h, v)) / (2.0 * h);
            let dv = (s.point(u, v + h) - s.point(u, v - h)) / (2.0 * h);
            let duu = (s.jet1(u + h, v).du - s.jet1(u - h, v).du) / (2.0 * h);
            let duv = (s.jet1(u, v + h).du - s.jet1(u, v - h).du) / (2.0 * h);
            let dvv = (s.jet1(u, v + h).dv - s.jet1(u, v - h).dv) / (2.0 * h);
            for (exact, approx) in [(j.du, du), (j.dv, dv), (j.duu, duu), (j.duv, duv), (j.dvv, dvv)] {
                assert!(exact.distance(approx) < 1e-7 * (1.0 + exact.length()), "{exact} {approx} at {u} {v}");
            }
        }
    }

    #[test]
    fn tables_give_the_same_bits() {
        let s = sample();
        let (u, v) = (Table::even(4, &s.knots[0], 7), Table::even(3, &s.knots[1], 5));
        let jets = s.jets1([&u, &v]);
        for (k, jet) in jets.iter().enumerate() {
            let single = s.jet1((k / 5) as f64 / 6.0 * 2.0, (k % 5) as f64 / 4.0);
            assert_eq!((jet.p, jet.du, jet.dv), (single.p, single.du, single.dv));
        }
    }

    #[test]
    fn corners_are_control_points_and_basis_sums_to_one() {
        let s = sample();
        assert_eq!(s.point(0.0, 0.0), s.points[0]);
        assert!(s.point(2.0, 1.0).distance(s.points[39]) < 1e-15);
        for t in [0.0, 0.3, 0.5, 0.7, 1.99, 2.0] {
            let b = basis(4, &s.knots[0], span(4, &s.knots[0], t), t, 2);
            let sum = b.map(|row| row.iter().sum::<f64>());
            assert!((sum[0] - 1.0).abs() < 1e-14 && sum[1].abs() < 1e-12 && sum[2].abs() < 1e-11, "{sum:?}");
        }
    }

    #[test]
    fn quarter_circle_is_exact() {
        let c = NurbsCurve {
            degree: 2,
            knots: [0.0, 0.0, 0.0, 1.0, 1.0, 1.0].into(),
            points: vec![DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
            weights: [1.0, 0.5f64.sqrt(), 1.0].into(),
        };
        for k in 0..=16 {
            let j = c.jet1(k as f64 / 16.0);
            assert!((j.p.length() - 1.0).abs() < 1e-15 && j.p.dot(j.d).abs() < 1e-14);
        }
        assert_eq!(breaks(2, &c.knots), [0.0, 1.0]);
    }
}
