//! Fit of the gauge to the film: one sparse, symmetric positive definite solve per node.
//!
//! Least over all exactly G1 skins (`forms`) of  ∫ (distance to the film along its normal)² dA  +  `FAIRNESS` · thin-plate
//! energy of the deviation from the strut's cylinder. The distance is linear in w: on the ray along Y the skin is at
//! |Y| / w, so near the film (distance ρ) it is off by ρ² / |Y| · (w - |Y| / ρ). The inner numbers of each patch are
//! eliminated first; the sparse system holds those of corners, creases and radials.

use crate::math::bernstein::basis;
use crate::math::gauss;
use crate::math::sparse::Symmetric;
use crate::node::{Film, Sampler};
use crate::patch::forms::{CreaseForms, Form, JET, RadialForms, Tables};
use crate::patch::layout::Layout;
use crate::patch::map::SectorMap;
use faer::Mat;
use faer::linalg::solvers::Solve;

/// Weight of the thin-plate energy, in r². Measured: at 1e-5 and above the fit error grows, below 1e-7 thin sectors ripple.
const FAIRNESS: f64 = 1e-6;

/// The steepest film (cosine between normal and ray) that still counts in full.
const LEAST_FACING: f64 = 0.05;

/// Thinnest sector (radians, node radii) for the fairness weight, which grows with the fourth power of thinness.
const LEAST_WIDTH: f64 = 0.02;

/// The gauge of one sector: Bernstein coefficients of w, `w[is * (p + 1) + iv]`, s along the crease, v from the rim.
pub struct Gauge {
    pub w: Vec<f64>,
}

/// The fitted gauges of a node.
pub struct Fit {
    /// One per sector.
    pub sectors: Vec<Gauge>,
    /// Coefficients of w along each crease (degree p).
    pub creases: Vec<Vec<f64>>,
    /// Coefficients of w along each radial, cylinder scale (degree p).
    pub radials: Vec<Vec<f64>>,
    /// Value of the gauge at each corner.
    pub corners: Vec<f64>,
}

/// Sector quantities on the way: all coefficients as forms of the patch's own numbers, and their normal equations.
struct Local {
    /// `forms[is * (p + 1) + iv]`, of (constant, border numbers, inner numbers).
    forms: Vec<Form>,
    /// Global number of each border number.
    border: Vec<usize>,
    /// The inner numbers as functions of (constant, border): rows = inner.
    inner: Mat<f64>,
}

/// Fit all sectors of a node to its film.
pub fn fit(tables: &Tables, layout: &Layout, film: &Film) -> Result<Fit, String> {
    let creases: Vec<CreaseForms> = (0..layout.creases.len()).map(|k| CreaseForms::new(tables, layout, k)).collect();
    let radials: Vec<RadialForms> = (0..layout.radials.len()).map(|k| RadialForms::new(tables, layout, k)).collect();
    let (nc, nk) = (layout.corners.len(), layout.creases.len());
    let crease_at = |k: usize| JET * nc + tables.crease_free() * k;
    let radial_at = |k: usize| crease_at(nk) + tables.radial_free() * k;
    let total = radial_at(layout.radials.len());

    let samples = Samples::new(tables.p);
    let mut matrix = Symmetric::default();
    let mut rhs = Mat::<f64>::zeros(total, 1);
    let mut sampler = film.sampler();
    let mut locals = Vec::with_capacity(layout.sectors.len());
    for (index, sector) in layout.sectors.iter().enumerate() {
        let map = SectorMap::new(layout, index);
        let mut border = Vec::new();
        for corner in layout.creases[sector.crease].corners {
            border.extend((0..JET).map(|k| JET * corner + k));
        }
        border.extend((0..tables.crease_free()).map(|k| crease_at(sector.crease) + k));
        for r in sector.radials {
            border.extend((0..tables.radial_free()).map(|k| radial_at(r) + k));
        }
        let forms = sector_forms(tables, layout, index, &map, &creases[sector.crease], sector.radials.map(|r| &radials[r]));
        let normal = normal_equations(tables, &samples, &map, &forms, &mut sampler)?;
        let nb = 1 + border.len();
        let ni = forms[0].len() - nb;
        // eliminate the inner numbers: N_ii x_i = -N_ib (1, x_b)
        let inner_matrix = normal.submatrix(nb, nb, ni, ni).to_owned();
        let mixed = normal.submatrix(nb, 0, ni, nb).to_owned();
        let factor = inner_matrix.llt(faer::Side::Lower).map_err(|e| format!("a patch's own equations are singular: {e:?}"))?;
        let inner = factor.solve(&mixed) * -1.0;
        let condensed = normal.submatrix(0, 0, nb, nb) + mixed.transpose() * &inner;
        for (a, &ga) in border.iter().enumerate() {
            rhs[(ga, 0)] -= condensed[(a + 1, 0)];
            for (b, &gb) in border.iter().enumerate() {
                matrix.add(ga, gb, 0.5 * (condensed[(a + 1, b + 1)] + condensed[(b + 1, a + 1)]));
            }
        }
        locals.push(Local { forms, border, inner });
    }
    let x = matrix.solve(total, &rhs)?;
    let value = |form: &Form, numbers: &[usize]| form[0] + form[1..].iter().zip(numbers).map(|(f, &k)| f * x[(k, 0)]).sum::<f64>();

    let sectors = locals.iter().map(|local| local.gauge(&x)).collect();
    let creases = creases
        .iter()
        .enumerate()
        .map(|(k, forms)| {
            let ends = layout.creases[k].corners;
            let numbers: Vec<usize> = ends.iter().flat_map(|&c| (0..JET).map(move |i| JET * c + i)).chain((0..tables.crease_free()).map(|i| crease_at(k) + i)).collect();
            forms.w.iter().map(|f| value(f, &numbers)).collect()
        })
        .collect();
    let radials = radials
        .iter()
        .enumerate()
        .map(|(k, forms)| {
            let corner = layout.radials[k].corner;
            let numbers: Vec<usize> = (0..JET).map(|i| JET * corner + i).chain((0..tables.radial_free()).map(|i| radial_at(k) + i)).collect();
            forms.w.iter().map(|f| value(f, &numbers)).collect()
        })
        .collect();
    let corners = (0..nc).map(|k| x[(JET * k, 0)]).collect();
    Ok(Fit { sectors, creases, radials, corners })
}

impl Local {
    fn gauge(&self, x: &Mat<f64>) -> Gauge {
        let mut numbers = vec![1.0];
        numbers.extend(self.border.iter().map(|&k| x[(k, 0)]));
        let nb = numbers.len();
        for row in 0..self.inner.nrows() {
            numbers.push((0..nb).map(|k| self.inner[(row, k)] * numbers[k]).sum());
        }
        Gauge { w: self.forms.iter().map(|f| f.iter().zip(&numbers).map(|(a, b)| a * b).sum()).collect() }
    }
}

/// All coefficients of a sector as forms of (constant, start jet, end jet, crease, start radial, end radial, inner).
fn sector_forms(tables: &Tables, layout: &Layout, index: usize, map: &SectorMap, crease: &CreaseForms, radials: [&RadialForms; 2]) -> Vec<Form> {
    let p = tables.p;
    let which = layout.sectors[index].which;
    let (jets, nk, nr) = (2 * JET, tables.crease_free(), tables.radial_free());
    let inner_at = 1 + jets + nk + 2 * nr;
    let width = inner_at + (p - 3) * (p - 3);
    let from_crease = |f: &Form| {
        let mut out = vec![0.0; width];
        out[..f.len()].copy_from_slice(f);
        out
    };
    let from_radial = |f: &Form, end: usize, factor: f64| {
        let mut out = vec![0.0; width];
        out[0] = factor * f[0];
        for k in 0..JET {
            out[1 + end * JET + k] = factor * f[1 + k];
        }
        for k in 0..nr {
            out[1 + jets + nk + end * nr + k] = factor * f[1 + JET + k];
        }
        out
    };
    let less = |a: &Form, f: f64, b: &Form| -> Form { a.iter().zip(b).map(|(x, y)| x - f * y).collect() };
    let mut forms = vec![Vec::new(); (p + 1) * (p + 1)];
    let at = |is: usize, iv: usize| is * (p + 1) + iv;
    // the columns next to the radials
    for end in 0..2 {
        let t = map.t(end as f64);
        let across = radials[end].across(tables, map, which, end);
        let (edge, next, sign) = if end == 0 { (0, 1, -1.0) } else { (p, p - 1, 1.0) };
        for iv in 0..=p {
            let border = from_radial(&radials[end].w[iv], end, 1.0 + t * t);
            forms[at(next, iv)] = less(&border, sign / p as f64, &from_radial(&across[iv], end, 1.0));
            forms[at(edge, iv)] = border;
        }
    }
    // the rows next to the crease; they meet the columns' twists by construction
    for is in 0..=p {
        let border = from_crease(&crease.w[is]);
        forms[at(is, p - 1)] = less(&border, 1.0 / p as f64, &from_crease(&crease.across[which][is]));
        forms[at(is, p)] = border;
    }
    // the rim and the row next to it: the cylinder, w = w2
    let rim = tables.interpolation.coefficients(&tables.interpolation.nodes.iter().map(|&s| 1.0 + map.t(s).powi(2)).collect::<Vec<_>>());
    for is in 0..=p {
        for iv in 0..2 {
            forms[at(is, iv)] = vec![0.0; width];
            forms[at(is, iv)][0] = rim[is];
        }
    }
    let mut k = inner_at;
    for is in 2..=p - 2 {
        for iv in 2..=p - 2 {
            forms[at(is, iv)] = vec![0.0; width];
            forms[at(is, iv)][k] = 1.0;
            k += 1;
        }
    }
    forms
}

/// Sample parameters and basis values, the same for every patch.
struct Samples {
    /// (parameter, weight).
    rule: Vec<(f64, f64)>,
    basis: Vec<Vec<f64>>,
    /// Gram matrices of the basis, its first and its second derivatives.
    gram: [Vec<Vec<f64>>; 3],
}

impl Samples {
    fn new(p: usize) -> Self {
        let rule = gauss::rule(p + 4);
        let all: Vec<[Vec<f64>; 3]> = rule.iter().map(|&(x, _)| basis(p, x)).collect();
        let gram = [0, 1, 2].map(|order| (0..=p).map(|i| (0..=p).map(|j| rule.iter().zip(&all).map(|(&(_, w), b)| w * b[order][i] * b[order][j]).sum()).collect()).collect());
        Samples { rule, basis: all.into_iter().map(|[b, _, _]| b).collect(), gram }
    }
}

/// The quadratic form  ½ (1, x)ᵀ N (1, x)  of a sector: distance to the film and fairness.
fn normal_equations(tables: &Tables, samples: &Samples, map: &SectorMap, forms: &[Form], sampler: &mut Sampler) -> Result<Mat<f64>, String> {
    let n = tables.p + 1;
    let width = forms[0].len();
    let m = samples.rule.len();
    let coefficients = Mat::<f64>::from_fn(n * n, width, |i, j| forms[i][j]);
    // rows of the least squares problem
    let mut design = Mat::<f64>::zeros(m * m, n * n);
    let mut target = vec![0.0; m * m];
    for (a, &(s, ws)) in samples.rule.iter().enumerate() {
        for step in 0..m {
            let b = if a % 2 == 0 { step } else { m - 1 - step };
            let (v, wv) = samples.rule[b];
            let y = map.y(s, v);
            let hit = sampler.hit(y).ok_or("a ray from the node misses the film")?;
            let (rho, length) = (hit.distance, y.length());
            let facing = hit.normal.dot(y / length).max(LEAST_FACING);
            let area = map.solid_angle(s, v) * rho * rho / facing;
            let weight = rho * rho / length * facing * (ws * wv * area).max(0.0).sqrt();
            let row = a * m + b;
            for i in 0..n {
                for j in 0..n {
                    design[(row, i * n + j)] = weight * samples.basis[a][i] * samples.basis[b][j];
                }
            }
            target[row] = weight * length / rho;
        }
    }
    let mut rows = &design * &coefficients;
    for (k, t) in target.iter().enumerate() {
        rows[(k, 0)] -= t;
    }
    let mut normal = rows.transpose() * &rows;
    // fairness of w - w2 in cylinder coordinates of the strut
    let (dphi, deta, w2) = map.extent();
    let (dphi, deta) = (dphi.clamp(LEAST_WIDTH, 1.0), deta.clamp(LEAST_WIDTH, 1.0));
    let factor = std::env::var("FAIR").ok().and_then(|s| s.parse().ok()).unwrap_or(FAIRNESS) * dphi * deta / (w2 * w2);
    let [g0, g1, g2] = &samples.gram;
    let energy = Mat::<f64>::from_fn(n * n, n * n, |r, c| {
        let (i, j, k, l) = (r / n, r % n, c / n, c % n);
        factor * (g2[i][k] * g0[j][l] / dphi.powi(4) + 2.0 * g1[i][k] * g1[j][l] / (dphi * deta).powi(2) + g0[i][k] * g2[j][l] / deta.powi(4))
    });
    let mut deviation = coefficients;
    for i in 0..n {
        for j in 0..n {
            deviation[(i * n + j, 0)] -= forms[i * n][0]; // the rim row holds w2
        }
    }
    let net: f64 = std::env::var("NET").ok().and_then(|s| s.parse().ok()).unwrap_or(0.0) * dphi * deta / (w2 * w2);
    let mut rows2 = Vec::new();
    for i in 0..n { for j in 0..n {
        let at = |i: usize, j: usize| i * n + j;
        if i + 2 < n { rows2.push([at(i, j), at(i + 1, j), at(i + 2, j)]); }
        if j + 2 < n { rows2.push([at(i, j), at(i, j + 1), at(i, j + 2)]); }
    } }
    let diff = Mat::<f64>::from_fn(rows2.len(), width, |r, c| { let [a, b, d] = rows2[r]; net.sqrt() * (deviation[(a, c)] - 2.0 * deviation[(b, c)] + deviation[(d, c)]) });
    normal += deviation.transpose() * (&energy * &deviation) + diff.transpose() * &diff;
    Ok(normal)
}
