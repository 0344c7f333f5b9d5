//! Border rows of the patches as linear functions of the node's free numbers: the C1 conditions of `map`, solved by
//! hand once and for all, so that every choice of the free numbers is an exactly G1 skin.
//!
//! Free numbers of a corner: the 2-jet of the gauge there (value, gradient along two tangents, Hessian: 6). With it all
//! conditions where many patches meet (twists, the vertex enclosure at even valence) hold by themselves. Free numbers of
//! an edge: what its two polynomials have beyond the jets at their ends.
//!
//! The gauge w along a crease has degree `p - 1`, its derivative across degree p. Along a radial, the same; where columns turn
//! the relation across has coefficients of degree 3 instead of 0 and 2, so patches have degree p + 3 in v,
//! and w and χ along radials have degree p.

use crate::math::axpy;
use crate::math::bernstein::{Interpolation, MOST_DEGREE, share};
use crate::patch::layout::{Corner, Crease, Layout, Radial};
use crate::patch::map::{self, SectorMap};
use glam::DVec3;

/// Free numbers of a corner.
pub const JET: usize = 6;

/// A linear function of a few numbers; entry 0 is the constant, and zeros follow the last.
pub type Form = [f64; MOST_NUMBERS];

/// Room for the numbers of a crease up to degree 10.
const MOST_NUMBERS: usize = 24;

/// Tables that depend on the degree alone.
#[derive(Clone, Debug)]
pub struct Tables {
    /// Degree of the patches along the crease, at least 6, and from rim to crease.
    pub p: usize,
    pub q: usize,
    /// Degree of the gauge and of χ along radials.
    along: usize,
    turn: usize,
    pub interpolation: Interpolation,
    /// Of degree q.
    pub columns: Interpolation,
    /// Of the direction map's degrees in s and v, with coefficients of degrees p and q.
    pub map: [Interpolation; 2],
}

impl Tables {
    pub fn new(p: usize) -> Self {
        assert!((6..=10).contains(&p), "patch degree {p}: corners with full 2-jets need degree 6, forms have room up to degree 10");
        let map = [(map::DEGREE, p), (map::COLUMN_DEGREE, p)].map(|(degree, to)| Interpolation::new(degree).raised(to));
        Tables { p, q: p, along: p - 1, turn: p, interpolation: Interpolation::new(p), columns: Interpolation::new(p), map }
    }

    /// For columns that turn.
    pub fn turned(p: usize) -> Self {
        let q = p + 3;
        let map = [(map::TURNED_DEGREE, p), (map::TURNED_COLUMN_DEGREE, q)].map(|(degree, to)| Interpolation::new(degree).raised(to));
        Tables { q, along: p, turn: p, columns: Interpolation::new(q), map, ..Tables::new(p) }
    }

    /// Free numbers of a crease: of w, then of δ.
    pub fn crease_free(&self) -> usize {
        (self.p - 6) + (self.p - 4)
    }

    /// Free numbers of a radial: of w, then of χ.
    pub fn radial_free(&self) -> usize {
        (self.along - 4) + (self.turn - 3)
    }

    /// Inner numbers of a patch: those of the control points two rows away from all borders.
    pub fn inner(&self) -> usize {
        (self.p - 3) * (self.q - 3)
    }
}

/// The jet of the gauge at a corner: linear functions of its 6 free numbers (value, 2 slopes, 3 second slopes).
struct JetForms<'a>(&'a Corner);

impl JetForms<'_> {
    fn value(&self) -> [f64; JET] {
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    /// ∇g · d.
    fn slope(&self, d: DVec3) -> [f64; JET] {
        let Corner { k, tangent: [a, b] } = self.0;
        [k.dot(d) / k.length_squared(), a.dot(d), b.dot(d), 0.0, 0.0, 0.0]
    }

    /// dᵀ ∇²g f at the corner.
    fn second(&self, d: DVec3, f: DVec3) -> [f64; JET] {
        let [a, b] = self.0.tangent;
        let (da, db, fa, fb) = (a.dot(d), b.dot(d), a.dot(f), b.dot(f));
        [0.0, 0.0, 0.0, da * fa, da * fb + db * fa, db * fb]
    }
}

fn add(a: [f64; JET], f: f64, b: [f64; JET]) -> [f64; JET] {
    std::array::from_fn(|k| a[k] + f * b[k])
}

fn scale(f: f64, a: [f64; JET]) -> [f64; JET] {
    a.map(|x| f * x)
}

/// Product of a polynomial and a polynomial of forms, both by their Bernstein coefficients.
fn times(factor: &[f64], forms: &[Form]) -> Vec<Form> {
    let (m, n) = (factor.len() - 1, forms.len() - 1);
    let mut out = vec![[0.0; MOST_NUMBERS]; m + n + 1];
    for (i, &f) in factor.iter().enumerate() {
        for (j, form) in forms.iter().enumerate() {
            axpy(&mut out[i + j], share(m, i, n, j) * f, form);
        }
    }
    out
}

/// The same polynomial at a degree that is higher by so much.
fn elevated(forms: &[Form], by: usize) -> Vec<Form> {
    times(&[1.0; MOST_DEGREE][..=by], forms)
}

/// Derivative of a polynomial of forms.
fn slope(forms: &[Form]) -> Vec<Form> {
    let n = (forms.len() - 1) as f64;
    forms.windows(2).map(|w| std::array::from_fn(|k| n * (w[1][k] - w[0][k]))).collect()
}

/// A crease: forms of (constant, jet at start, jet at end, free).
pub struct CreaseForms {
    /// Coefficients of w along the crease, degree p.
    pub w: Vec<Form>,
    /// Coefficients of ∂w/∂v there, for the sectors of the first and the second strut.
    pub across: [Vec<Form>; 2],
}

impl CreaseForms {
    pub fn new(tables: &Tables, layout: &Layout, index: usize) -> Self {
        let p = tables.p;
        let crease: &Crease = &layout.creases[index];
        let maps = [0, 1].map(|which| SectorMap::new(layout, 2 * index + which));
        let dt = maps[0].dt();
        let place = |end: usize, jet: [f64; JET]| {
            let mut form = [0.0; MOST_NUMBERS];
            form[1 + end * JET..1 + (end + 1) * JET].copy_from_slice(&jet);
            form
        };
        let unit = |k: usize| {
            let mut form = [0.0; MOST_NUMBERS];
            form[1 + 2 * JET + k] = 1.0;
            form
        };
        let e = p - 1; // degree of w and δ
        let mut w = vec![[0.0; MOST_NUMBERS]; e + 1];
        let mut delta = vec![[0.0; MOST_NUMBERS]; e + 1];
        let n = e as f64;
        // M sin θ = a_0 c_0 + a_1 c_1, with a_0 = λ_1, a_1 = λ_0, and λ_0 λ_1 = 1
        let wide = crease.frame.wide;
        let apart = wide[1] * crease.frame.c[0] - wide[0] * crease.frame.c[1];
        for end in 0..2 {
            let jet = JetForms(&layout.corners[crease.corners[end]]);
            let t = crease.t[end];
            let w2 = 1.0 + t * t;
            let [_, y1, y2] = maps[0].crease(end as f64);
            let step = if end == 0 { dt } else { -dt };
            let stretch = crease.stretch[end];
            let f0 = scale(w2 * stretch, jet.value());
            let f1 = scale(step, jet.slope(y1));
            let f2 = scale(step * step, add(jet.slope(y2), 1.0 / (w2 * stretch), jet.second(y1, y1)));
            let k = |i: usize| if end == 0 { i } else { e - i };
            w[k(0)] = place(end, f0);
            w[k(1)] = place(end, add(f0, 1.0 / n, f1));
            w[k(2)] = place(end, add(add(f0, 2.0 / n, f1), 1.0 / (n * (n - 1.0)), f2));
            // δ = -½ w2 ∇g·(a_i c_i - a_j c_j)
            let d0 = scale(-0.5 * w2, jet.slope(apart));
            let d1 = scale(step, add(scale(-t, jet.slope(apart)), -0.5 / stretch, jet.second(y1, apart)));
            delta[k(0)] = place(end, d0);
            delta[k(1)] = place(end, add(d0, 1.0 / n, d1));
        }
        for k in 0..p - 6 {
            w[3 + k] = unit(k);
        }
        for k in 0..p - 4 {
            delta[2 + k] = unit(p - 6 + k);
        }
        let bend = -0.5 * crease.sign * crease.frame.theta.sin();
        // w_v = l (-½ σ sin θ (w - t w_t) ± δ)
        let slope = slope(&w);
        let across = [1.0, -1.0].map(|side| {
            let map = &maps[usize::from(side < 0.0)];
            let t_over_dt = [0.0, 1.0].map(|s| if layout.turned { map.crease_t(s) } else { map.t(s) } / dt);
            let speed = [0.0, 1.0].map(|s| map.speed(s) * wide[usize::from(side < 0.0)]);
            let mut sum = times(&t_over_dt, &slope);
            for ((sum, w), delta) in sum.iter_mut().zip(&w).zip(&delta) {
                sum.iter_mut().zip(w.iter().zip(delta)).for_each(|(x, (w, d))| *x = bend * (w - *x) + side * d);
            }
            times(&speed, &sum)
        });
        CreaseForms { w: elevated(&w, 1), across }
    }
}

/// A radial: forms of (constant, jet at the corner, free), per unit of distance from the axis: a cylinder of radius 1 has w = 1.
pub struct RadialForms {
    /// Coefficients of the gauge along the radial, degree q.
    pub w: Vec<Form>,
    /// The gauge W, W_v, and χ, its slope counter-clockwise about the axis at constant height: each at its own degree.
    terms: [Vec<Form>; 3],
}

impl RadialForms {
    pub fn new(tables: &Tables, layout: &Layout, index: usize) -> Self {
        let radial: &Radial = &layout.radials[index];
        let jet = JetForms(&layout.corners[radial.corner]);
        let place = |jet: [f64; JET]| {
            let mut form = [0.0; MOST_NUMBERS];
            form[1..1 + JET].copy_from_slice(&jet);
            form
        };
        let unit = |k: usize| {
            let mut form = [0.0; MOST_NUMBERS];
            form[k] = 1.0;
            form
        };
        let (c, l) = (radial.c, radial.speed);
        let turn = c.cross(radial.e);
        let e = tables.along;
        let n = e as f64;
        let reach = radial.scale; // the corner's k over the point at distance 1
        let (g0, g1) = (scale(1.0 / reach, jet.value()), scale(-l, jet.slope(c)));
        let g2 = add(scale(l * l * reach, jet.second(c, c)), radial.bend, jet.slope(c));
        let mut w = vec![[0.0; MOST_NUMBERS]; e + 1];
        // at the rim the strut itself, to first order
        let [height, by_q, _] = radial.height(1.0);
        let own = radial.own(height);
        w[0] = scaled(own, unit(0));
        w[1] = scaled(own + radial.taper * by_q / (radial.radius * n), unit(0));
        w[e] = place(g0);
        w[e - 1] = place(add(g0, -1.0 / n, g1));
        w[e - 2] = place(add(add(g0, -2.0 / n, g1), 1.0 / (n * (n - 1.0)), g2));
        for k in 0..e - 4 {
            w[2 + k] = unit(1 + JET + k);
        }
        let (x0, x1) = (jet.slope(turn), scale(-l * reach, jet.second(turn, c)));
        let d = tables.turn;
        let mut chi = vec![[0.0; MOST_NUMBERS]; d + 1];
        chi[d] = place(x0);
        chi[d - 1] = place(add(x0, -1.0 / d as f64, x1));
        for k in 0..d - 3 {
            chi[2 + k] = unit(1 + JET + e - 4 + k);
        }
        RadialForms { w: elevated(&w, tables.q - e), terms: [w.clone(), slope(&w), chi] }
    }

    /// Coefficients of ∂w/∂s of a sector at its start (end 0) or end (end 1), degree q.
    pub fn across(&self, map: &SectorMap, end: usize) -> Vec<Form> {
        let factors = map.across_radial(end);
        let [mut sum, slope, turn] = std::array::from_fn(|k| times(&factors[k], &self.terms[k]));
        for (sum, (slope, turn)) in sum.iter_mut().zip(slope.iter().zip(&turn)) {
            axpy(sum, 1.0, slope);
            axpy(sum, 1.0, turn);
        }
        sum
    }
}

fn scaled(f: f64, form: Form) -> Form {
    form.map(|x| f * x)
}
