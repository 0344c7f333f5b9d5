//! Fit of the gauge to the film: one sparse, symmetric positive definite solve per node.
//!
//! Least over all exactly G1 skins (`forms`) of  ∫ (distance to the film along its normal)² dA  +  `FAIRNESS` · thin-plate
//! energy of the deviation from the strut's cylinder. The distance is linear in w: on the ray along Y the skin is at
//! |Y| / w, so near the film (distance ρ) it is off by ρ² / |Y| · (w - |Y| / ρ). The inner numbers of each patch are
//! eliminated first; the sparse system holds those of corners, creases and radials.
//!
//! Bernstein coefficients may swing far beyond the function they stand for, and a weight must not reach 0: second
//! differences of the control net have a weight of their own (`stiffness`), which the caller raises until all are positive.

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

/// The fitted gauges of a node.
pub struct Fit {
    /// Per sector: Bernstein coefficients of w, `[is * (p + 1) + iv]`, s along the crease, v from the rim.
    pub sectors: Vec<Vec<f64>>,
    /// Coefficients of w along each crease (degree p).
    pub creases: Vec<Vec<f64>>,
    /// Coefficients of w along each radial, cylinder scale (degree p).
    pub radials: Vec<Vec<f64>>,
    /// Value of the gauge at each corner.
    pub corners: Vec<f64>,
}

/// The least squares problem of one node, ready to be solved with more or less stiff control nets.
pub struct Problem<'a> {
    tables: &'a Tables,
    layout: &'a Layout,
    creases: Vec<CreaseForms>,
    radials: Vec<RadialForms>,
    sectors: Vec<SectorProblem>,
}

/// One sector's part: the quadratic forms ½ (1, x)ᵀ N (1, x) in the patch's own numbers.
struct SectorProblem {
    /// `forms[is * (p + 1) + iv]`, of (constant, border numbers, inner numbers).
    forms: Vec<Form>,
    /// Global number of each border number.
    border: Vec<usize>,
    /// Distance to the film and thin-plate energy.
    film: Mat<f64>,
    /// Second differences of the control net.
    net: Mat<f64>,
}

impl<'a> Problem<'a> {
    /// Sample the film for all sectors of a node.
    pub fn new(tables: &'a Tables, layout: &'a Layout, film: &Film) -> Result<Self, String> {
        let creases: Vec<CreaseForms> = (0..layout.creases.len()).map(|k| CreaseForms::new(tables, layout, k)).collect();
        let radials: Vec<RadialForms> = (0..layout.radials.len()).map(|k| RadialForms::new(tables, layout, k)).collect();
        let mut problem = Problem { tables, layout, creases, radials, sectors: Vec::with_capacity(layout.sectors.len()) };
        let samples = Samples::new(tables.p);
        let mut sampler = film.sampler();
        for (index, sector) in layout.sectors.iter().enumerate() {
            let map = SectorMap::new(layout, index);
            let mut border = problem.crease_numbers(sector.crease);
            border.extend(sector.radials.iter().flat_map(|&r| problem.radial_free(r)));
            let forms = sector_forms(tables, layout, index, &map, &problem.creases[sector.crease], sector.radials.map(|r| &problem.radials[r]));
            let [film, net] = normal_equations(tables, &samples, &map, &forms, &mut sampler)?;
            problem.sectors.push(SectorProblem { forms, border, film, net });
        }
        Ok(problem)
    }

    /// Global numbers of a crease: the jets at its ends, then its own.
    fn crease_numbers(&self, k: usize) -> Vec<usize> {
        let free = self.tables.crease_free();
        let at = JET * self.layout.corners.len() + free * k;
        self.layout.creases[k].corners.iter().flat_map(|&c| JET * c..JET * (c + 1)).chain(at..at + free).collect()
    }

    /// Global numbers of a radial's own.
    fn radial_free(&self, k: usize) -> std::ops::Range<usize> {
        let free = self.tables.radial_free();
        let at = JET * self.layout.corners.len() + self.tables.crease_free() * self.layout.creases.len() + free * k;
        at..at + free
    }

    /// The skin of least error, with weight `stiffness` (r²) on the second differences of the control nets.
    pub fn solve(&self, stiffness: f64) -> Result<Fit, String> {
        let total = self.radial_free(self.layout.radials.len()).start;
        let mut matrix = Symmetric::default();
        let mut rhs = Mat::<f64>::zeros(total, 1);
        let mut inner = Vec::with_capacity(self.sectors.len());
        for sector in &self.sectors {
            let normal = &sector.film + stiffness * &sector.net;
            let nb = 1 + sector.border.len();
            let ni = normal.nrows() - nb;
            // eliminate the inner numbers: N_ii x_i = -N_ib (1, x_b)
            let mixed = normal.submatrix(nb, 0, ni, nb);
            let factor = normal.submatrix(nb, nb, ni, ni).llt(faer::Side::Lower).map_err(|e| format!("a patch's own equations are singular: {e:?}"))?;
            let solved = factor.solve(&mixed) * -1.0;
            let condensed = normal.submatrix(0, 0, nb, nb) + mixed.transpose() * &solved;
            for (a, &ga) in sector.border.iter().enumerate() {
                rhs[(ga, 0)] -= condensed[(a + 1, 0)];
                for (b, &gb) in sector.border.iter().enumerate() {
                    matrix.add(ga, gb, 0.5 * (condensed[(a + 1, b + 1)] + condensed[(b + 1, a + 1)]));
                }
            }
            inner.push(solved);
        }
        let x = matrix.solve(total, &rhs)?;
        let value = |form: &Form, numbers: &[usize]| form[0] + form[1..].iter().zip(numbers).map(|(f, &k)| f * x[(k, 0)]).sum::<f64>();
        let radial_numbers = |k: usize| -> Vec<usize> {
            let corner = self.layout.radials[k].corner;
            (JET * corner..JET * (corner + 1)).chain(self.radial_free(k)).collect()
        };
        Ok(Fit {
            sectors: self.sectors.iter().zip(&inner).map(|(sector, inner)| sector.gauge(inner, &x)).collect(),
            creases: self.creases.iter().enumerate().map(|(k, f)| f.w.iter().map(|w| value(w, &self.crease_numbers(k))).collect()).collect(),
            radials: self.radials.iter().enumerate().map(|(k, f)| f.w.iter().map(|w| value(w, &radial_numbers(k))).collect()).collect(),
            corners: (0..self.layout.corners.len()).map(|k| x[(JET * k, 0)]).collect(),
        })
    }
}

impl SectorProblem {
    /// All coefficients, from the border numbers `x` and the inner numbers as functions of (constant, border).
    fn gauge(&self, inner: &Mat<f64>, x: &Mat<f64>) -> Vec<f64> {
        let mut numbers = vec![1.0];
        numbers.extend(self.border.iter().map(|&k| x[(k, 0)]));
        let nb = numbers.len();
        for row in 0..inner.nrows() {
            numbers.push((0..nb).map(|k| inner[(row, k)] * numbers[k]).sum());
        }
        self.forms.iter().map(|f| f.iter().zip(&numbers).map(|(a, b)| a * b).sum()).collect()
    }
}

/// No fit at all: each sector the cylinder of its strut, w = w2.
pub fn cylinders(tables: &Tables, layout: &Layout) -> Fit {
    let n = tables.p + 1;
    let w2 = |index: usize| -> Vec<f64> {
        let map = SectorMap::new(layout, index);
        tables.interpolation.coefficients(&tables.interpolation.nodes.iter().map(|&s| 1.0 + map.t(s).powi(2)).collect::<Vec<_>>())
    };
    Fit {
        sectors: (0..layout.sectors.len()).map(|k| w2(k).into_iter().flat_map(|w| std::iter::repeat_n(w, n)).collect()).collect(),
        creases: (0..layout.creases.len()).map(|k| w2(2 * k)).collect(),
        radials: vec![vec![1.0; n]; layout.radials.len()],
        corners: vec![1.0; layout.corners.len()],
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
        let w2 = map.w2_of_ends()[end];
        let across = radials[end].across(tables, map, which, end);
        let (edge, next, sign) = if end == 0 { (0, 1, -1.0) } else { (p, p - 1, 1.0) };
        for iv in 0..=p {
            let border = from_radial(&radials[end].w[iv], end, w2);
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
        let rule = gauss::rule(p + 3);
        let all: Vec<[Vec<f64>; 3]> = rule.iter().map(|&(x, _)| basis(p, x)).collect();
        let gram = [0, 1, 2].map(|order| (0..=p).map(|i| (0..=p).map(|j| rule.iter().zip(&all).map(|(&(_, w), b)| w * b[order][i] * b[order][j]).sum()).collect()).collect());
        Samples { rule, basis: all.into_iter().map(|[b, _, _]| b).collect(), gram }
    }
}

/// The two quadratic forms of a sector (see `SectorProblem`).
fn normal_equations(tables: &Tables, samples: &Samples, map: &SectorMap, forms: &[Form], sampler: &mut Sampler) -> Result<[Mat<f64>; 2], String> {
    let n = tables.p + 1;
    let width = forms[0].len();
    let m = samples.rule.len();
    let coefficients = Mat::<f64>::from_fn(n * n, width, |i, j| forms[i][j]);
    // distance to the film: one row per sample
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
    let mut film = rows.transpose() * &rows;
    // energies of w - w2, in cylinder coordinates of the strut
    let (dphi, deta, w2) = map.extent();
    let (dphi, deta) = (dphi.clamp(LEAST_WIDTH, 1.0), deta.clamp(LEAST_WIDTH, 1.0));
    let area = dphi * deta / (w2 * w2);
    let [g0, g1, g2] = &samples.gram;
    let plate = Mat::<f64>::from_fn(n * n, n * n, |r, c| {
        let (i, j, k, l) = (r / n, r % n, c / n, c % n);
        FAIRNESS * area * (g2[i][k] * g0[j][l] / dphi.powi(4) + 2.0 * g1[i][k] * g1[j][l] / (dphi * deta).powi(2) + g0[i][k] * g2[j][l] / deta.powi(4))
    });
    let mut deviation = coefficients;
    for i in 0..n {
        for j in 0..n {
            deviation[(i * n + j, 0)] -= forms[i * n][0]; // the rim row holds w2
        }
    }
    film += deviation.transpose() * (&plate * &deviation);
    let triples: Vec<[usize; 3]> =
        (0..n * n).flat_map(|k| [(k / n + 2 < n).then_some([k, k + n, k + 2 * n]), (k % n + 2 < n).then_some([k, k + 1, k + 2])]).flatten().collect();
    let bends = Mat::<f64>::from_fn(triples.len(), width, |r, c| {
        let [a, b, d] = triples[r];
        area.sqrt() * (deviation[(a, c)] - 2.0 * deviation[(b, c)] + deviation[(d, c)])
    });
    Ok([film, bends.transpose() * &bends])
}
