//! Border rows of the patches as linear functions of the node's free numbers: the C1 conditions of `map`, solved by
//! hand once and for all, so that every choice of the free numbers is an exactly G1 skin.
//!
//! Free numbers of a corner: the 2-jet of the gauge there (value, gradient along two tangents, Hessian: 6). With it all
//! conditions where many patches meet (twists, the vertex enclosure at even valence) hold by themselves. Free numbers of
//! an edge: what its two polynomials have beyond the jets at their ends.
//!
//! The gauge w along an edge has degree `p - 1`, its derivative across the edge degree p.

use crate::math::bernstein::{Interpolation, basis, elevate};
use crate::patch::layout::{Corner, Crease, Layout, Radial};
use crate::patch::map::SectorMap;
use glam::DVec3;

/// Free numbers of a corner.
pub const JET: usize = 6;

/// A linear function of a few numbers; entry 0 is the constant.
pub type Form = Vec<f64>;

/// Tables that depend on the degree alone.
#[derive(Clone, Debug)]
pub struct Tables {
    /// Degree of the patches in both directions, at least 6.
    pub p: usize,
    pub interpolation: Interpolation,
}

impl Tables {
    pub fn new(p: usize) -> Self {
        assert!(p >= 6, "patch degree {p}: corners with full 2-jets need degree 6");
        Tables { p, interpolation: Interpolation::new(p) }
    }

    /// Free numbers of a crease: of w, then of δ.
    pub fn crease_free(&self) -> usize {
        (self.p - 6) + (self.p - 4)
    }

    /// Free numbers of a radial: of w, then of χ.
    pub fn radial_free(&self) -> usize {
        (self.p - 5) + (self.p - 3)
    }

    /// Coefficients (degree p) of a polynomial form given by its value at parameters.
    fn coefficients(&self, value: impl Fn(f64) -> Form) -> Vec<Form> {
        let values: Vec<Form> = self.interpolation.nodes.iter().map(|&x| value(x)).collect();
        let width = values[0].len();
        let mut out = vec![vec![0.0; width]; self.p + 1];
        for k in 0..width {
            let column: Vec<f64> = values.iter().map(|v| v[k]).collect();
            for (row, c) in out.iter_mut().zip(self.interpolation.coefficients(&column)) {
                row[k] = c;
            }
        }
        out
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

fn axpy(into: &mut Form, f: f64, from: &[f64]) {
    into.iter_mut().zip(from).for_each(|(x, y)| *x += f * y);
}

/// Value of a polynomial of forms, and its derivative.
fn at(coefficients: &[Form], x: f64) -> [Form; 2] {
    let [b, d, _] = basis(coefficients.len() - 1, x);
    [b, d].map(|weights| {
        let mut out = vec![0.0; coefficients[0].len()];
        coefficients.iter().zip(weights).for_each(|(c, w)| axpy(&mut out, w, c));
        out
    })
}

/// Forms of degree n + 1.
fn elevated(c: &[Form]) -> Vec<Form> {
    let width = c[0].len();
    let mut out = vec![vec![0.0; width]; c.len() + 1];
    for k in 0..width {
        let column: Vec<f64> = c.iter().map(|row| row[k]).collect();
        out.iter_mut().zip(elevate(&column)).for_each(|(row, x)| row[k] = x);
    }
    out
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
        let width = 1 + 2 * JET + tables.crease_free();
        let place = |end: usize, jet: [f64; JET]| {
            let mut form = vec![0.0; width];
            form[1 + end * JET..1 + (end + 1) * JET].copy_from_slice(&jet);
            form
        };
        let unit = |k: usize| {
            let mut form = vec![0.0; width];
            form[1 + 2 * JET + k] = 1.0;
            form
        };
        let e = p - 1; // degree of w and δ
        let mut w = vec![Vec::new(); e + 1];
        let mut delta = vec![Vec::new(); e + 1];
        let n = e as f64;
        let apart = crease.frame.c[0] - crease.frame.c[1];
        for end in 0..2 {
            let jet = JetForms(&layout.corners[crease.corners[end]]);
            let t = crease.t[end];
            let w2 = 1.0 + t * t;
            let [_, y1, y2] = maps[0].crease(end as f64);
            let step = if end == 0 { dt } else { -dt };
            let f0 = scale(w2, jet.value());
            let f1 = scale(step, jet.slope(y1));
            let f2 = scale(step * step, add(jet.slope(y2), 1.0 / w2, jet.second(y1, y1)));
            let k = |i: usize| if end == 0 { i } else { e - i };
            w[k(0)] = place(end, f0);
            w[k(1)] = place(end, add(f0, 1.0 / n, f1));
            w[k(2)] = place(end, add(add(f0, 2.0 / n, f1), 1.0 / (n * (n - 1.0)), f2));
            // δ = -½ w2 ∇g·(c_i - c_j)
            let d0 = scale(-0.5 * w2, jet.slope(apart));
            let d1 = scale(step, add(scale(-t, jet.slope(apart)), -0.5, jet.second(y1, apart)));
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
        let across = [1.0, -1.0].map(|side| {
            let map = &maps[usize::from(side < 0.0)];
            tables.coefficients(|s| {
                let t = map.t(s);
                let [value, by_s] = at(&w, s);
                let [d, _] = at(&delta, s);
                let mut form = vec![0.0; width];
                let l = map.speed(s);
                axpy(&mut form, l * bend, &value);
                axpy(&mut form, -l * bend * t / dt, &by_s);
                axpy(&mut form, l * side, &d);
                form
            })
        });
        CreaseForms { w: elevated(&w), across }
    }
}

/// A radial: forms of (constant, jet at the corner, free). In cylinder scale: the strut itself has w = 1.
pub struct RadialForms {
    /// Coefficients of the gauge along the radial, degree p.
    pub w: Vec<Form>,
    /// Coefficients of χ, its slope counter-clockwise about the axis at constant height, degree p.
    chi: Vec<Form>,
}

impl RadialForms {
    pub fn new(tables: &Tables, layout: &Layout, index: usize) -> Self {
        let p = tables.p;
        let radial: &Radial = &layout.radials[index];
        let jet = JetForms(&layout.corners[radial.corner]);
        let width = 1 + JET + tables.radial_free();
        let place = |jet: [f64; JET]| {
            let mut form = vec![0.0; width];
            form[1..1 + JET].copy_from_slice(&jet);
            form
        };
        let unit = |k: usize| {
            let mut form = vec![0.0; width];
            form[k] = 1.0;
            form
        };
        let (c, l) = (radial.c, radial.speed);
        let turn = c.cross(radial.e);
        let e = p - 1;
        let n = e as f64;
        let (g0, g1, g2) = (jet.value(), scale(-l, jet.slope(c)), add(scale(l * l, jet.second(c, c)), radial.bend, jet.slope(c)));
        let mut w = vec![Vec::new(); e + 1];
        // at the rim the cylinder, to first order
        w[0] = unit(0);
        w[1] = unit(0);
        w[e] = place(g0);
        w[e - 1] = place(add(g0, -1.0 / n, g1));
        w[e - 2] = place(add(add(g0, -2.0 / n, g1), 1.0 / (n * (n - 1.0)), g2));
        for k in 0..p - 5 {
            w[2 + k] = unit(1 + JET + k);
        }
        let (x0, x1) = (jet.slope(turn), scale(-l, jet.second(turn, c)));
        let mut chi = vec![vec![0.0; width]; p + 1];
        chi[p] = place(x0);
        chi[p - 1] = place(add(x0, -1.0 / p as f64, x1));
        for k in 0..p - 3 {
            chi[2 + k] = unit(1 + JET + p - 5 + k);
        }
        RadialForms { w: elevated(&w), chi }
    }

    /// Coefficients of ∂w/∂s of a sector at its start (end 0) or end (end 1), in the sector's own scale (w2 times).
    pub fn across(&self, tables: &Tables, map: &SectorMap, which: usize, end: usize) -> Vec<Form> {
        let t = map.t(end as f64);
        let turn = if which == 0 { 1.0 } else { -1.0 };
        tables.coefficients(|v| {
            let [value, by_v] = at(&self.w, v);
            let [chi, _] = at(&self.chi, v);
            let mut form = vec![0.0; value.len()];
            axpy(&mut form, 2.0 * map.dt() * turn, &chi);
            axpy(&mut form, 2.0 * map.dt() * map.shear(end, v), &by_v);
            axpy(&mut form, 2.0 * map.dt() * t, &value);
            form
        })
    }
}
