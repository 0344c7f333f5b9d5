//! Fit of the gauge to the film: one sparse, symmetric positive definite solve per node.
//!
//! Least over all exactly G1 skins (`forms`) of  ∫ (distance to the film along its normal)² dA  +  `FAIRNESS` · thin-plate
//! energy of the deviation from the strut's own gauge. The distance is linear in w: on the ray along Y the skin is at
//! |Y| / w, so near the film (distance ρ) it is off by ρ² / |Y| · (w - |Y| / ρ). The inner numbers of each patch are
//! eliminated first; the sparse system holds those of corners, creases and radials.
//!
//! Bernstein coefficients may swing far beyond the function they stand for, and a weight must not reach 0: second
//! differences of the control net have a weight of their own (`stiffness`), which the caller raises until all are positive.

use crate::math::bernstein::{Interpolation, basis};
use crate::math::gauss;
use crate::math::sparse::{Order, Symmetric};
use crate::math::{Loops, axpy, axpy2, padded, vectorised};
use crate::node::{Film, Sampler};
use crate::patch::forms::{CreaseForms, Form, JET, RadialForms, Tables};
use crate::patch::layout::Layout;
use crate::patch::map::SectorMap;
use faer::Mat;
use glam::DVec3;

/// Weight of the thin-plate energy, in r². Measured: at 1e-5 and above the fit error grows, below 1e-7 thin sectors ripple.
const FAIRNESS: f64 = 1e-6;

/// The steepest film (cosine between normal and ray) that still counts in full.
const LEAST_FACING: f64 = 0.05;

/// Rows of each patch, from the rim on, that are the strut: there w is the strut's own gauge, whatever the free numbers.
const RIM_ROWS: usize = 2;

/// Thinnest sector (radians, node radii) for the fairness weight, which grows with the fourth power of thinness.
const LEAST_WIDTH: f64 = 0.02;

/// The fitted gauges of a node.
pub struct Fit {
    /// Per sector: Bernstein coefficients of w, `[is * (q + 1) + iv]`, s along the crease, v from the rim.
    pub sectors: Vec<Vec<f64>>,
    /// Coefficients of w along each crease (degree p).
    pub creases: Vec<Vec<f64>>,
    /// Coefficients of w along each radial, per unit of distance from the axis (degree q).
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
    samples: &'a Samples,
    order: Order,
}

/// One sector's part: a quadratic form ½ (1, x)ᵀ N (1, x) in the patch's own numbers. It is kept in the control values
/// of w less the strut's own gauge behind the `RIM_ROWS`, numbered `[is * (q + 1 - RIM_ROWS) + iv - RIM_ROWS]`.
struct SectorProblem {
    /// Global number of each border number.
    border: Vec<usize>,
    /// The strut's own gauge, `[is * (q + 1) + iv]`.
    own: Vec<f64>,
    /// w less the strut's own gauge, as forms of the patch's own numbers.
    deviation: SparseRows,
    /// Distance to the film and thin-plate energy: the quadratic part, and the linear part with its sign turned.
    energy: Vec<f64>,
    pull: Vec<f64>,
    /// Area of the sector: what the second differences of the control net count for.
    area: f64,
    /// As `Samples::bends`, where the layout is fine.
    bends: Option<Vec<f64>>,
}

impl<'a> Problem<'a> {
    /// Sample the film for all sectors of a node.
    pub fn new(tables: &'a Tables, samples: &'a Samples, layout: &'a Layout, film: &Film) -> Result<Self, String> {
        let creases: Vec<CreaseForms> = (0..layout.creases.len()).map(|k| CreaseForms::new(tables, layout, k)).collect();
        let radials: Vec<RadialForms> = (0..layout.radials.len()).map(|k| RadialForms::new(tables, layout, k)).collect();
        let order = order(tables, layout)?;
        let mut problem = Problem { tables, layout, creases, radials, sectors: Vec::with_capacity(layout.sectors.len()), samples, order };
        let mut sampler = film.sampler();
        for (index, sector) in layout.sectors.iter().enumerate() {
            let map = SectorMap::new(layout, index);
            let mut border = problem.crease_numbers(sector.crease);
            border.extend(sector.radials.iter().flat_map(|&r| problem.radial_free(r)));
            let own = own_gauge(tables, &map);
            let deviation = deviation(tables, layout, index, &map, &own, &problem.creases[sector.crease], sector.radials.map(|r| &problem.radials[r]));
            let Energy { energy, pull, area, bends } = Energy::new(tables, samples, &map, &own, &mut sampler, layout.fine)?;
            problem.sectors.push(SectorProblem { border, own, deviation, energy, pull, area, bends });
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
        let mut scratch = Scratch::default();
        for sector in &self.sectors {
            let (width, nb) = (sector.deviation.width, 1 + sector.border.len());
            let line = padded(width);
            let normal = vectorised(Reduction { sector, samples: self.samples, stiffness, scratch: &mut scratch })?;
            for (a, &ga) in sector.border.iter().enumerate() {
                let row = &normal[(a + 1) * line..(a + 1) * line + nb];
                rhs[(ga, 0)] -= row[0];
                for (&gb, &value) in sector.border[..=a].iter().zip(&row[1..]) {
                    matrix.add(ga.max(gb), ga.min(gb), value);
                }
            }
            inner.push(normal[nb * line..].to_vec());
        }
        let x = matrix.solve(total, &rhs, Some(&self.order))?;
        let value = |form: &Form, numbers: &[usize]| form[0] + form[1..].iter().zip(numbers).map(|(f, &k)| f * x[(k, 0)]).sum::<f64>();
        let radial_numbers = |k: usize| -> Vec<usize> {
            let corner = self.layout.radials[k].corner;
            (JET * corner..JET * (corner + 1)).chain(self.radial_free(k)).collect()
        };
        Ok(Fit {
            sectors: self.sectors.iter().zip(&inner).map(|(sector, inner)| sector.gauge(self.tables.q + 1, inner, &x)).collect(),
            creases: self.creases.iter().enumerate().map(|(k, f)| f.w.iter().map(|w| value(w, &self.crease_numbers(k))).collect()).collect(),
            radials: self.radials.iter().enumerate().map(|(k, f)| f.w.iter().map(|w| value(w, &radial_numbers(k))).collect()).collect(),
            corners: (0..self.layout.corners.len()).map(|k| x[(JET * k, 0)]).collect(),
        })
    }
}

impl SectorProblem {
    /// All coefficients, n in each column, from the border numbers `x` and the eliminated rows of the inner numbers.
    fn gauge(&self, n: usize, inner: &[f64], x: &Mat<f64>) -> Vec<f64> {
        let mut numbers = vec![1.0];
        numbers.extend(self.border.iter().map(|&k| x[(k, 0)]));
        for row in inner.chunks_exact(padded(self.deviation.width)) {
            let k = numbers.len();
            numbers.push(-row.iter().zip(&numbers).map(|(a, b)| a * b).sum::<f64>() / row[k]);
        }
        let mut w = self.own.clone();
        let free = w.chunks_exact_mut(n).flat_map(|column| &mut column[RIM_ROWS..]);
        for (w, entries) in free.zip(self.deviation.rows()) {
            *w += entries.iter().map(|&(k, f)| f * numbers[k]).sum::<f64>();
        }
        w
    }
}

/// The order in which the numbers of corners, creases and radials are eliminated: those of a sector all meet.
fn order(tables: &Tables, layout: &Layout) -> Result<Order, String> {
    let (nc, nk, nr) = (layout.corners.len(), layout.creases.len(), layout.radials.len());
    let sizes = [(nc, JET), (nk, tables.crease_free()), (nr, tables.radial_free())];
    let mut end = 0;
    let block = |size: usize| {
        end += size;
        end - size..end
    };
    let blocks: Vec<_> = sizes.into_iter().flat_map(|(count, size)| std::iter::repeat_n(size, count)).map(block).collect();
    let cliques = layout.sectors.iter().map(|s| {
        let ([a, b], [c, d]) = (layout.creases[s.crease].corners, s.radials);
        [a, b, nc + s.crease, nc + nk + c, nc + nk + d]
    });
    Order::of_blocks(&blocks, cliques)
}

/// A sector's equations, its inner numbers eliminated.
struct Reduction<'a> {
    sector: &'a SectorProblem,
    samples: &'a Samples,
    stiffness: f64,
    scratch: &'a mut Scratch,
}

impl<'a> Loops for Reduction<'a> {
    type Output = Result<&'a mut [f64], String>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let normal = self.sector.normal(self.samples, self.stiffness, self.scratch);
        eliminate(normal, self.sector.deviation.width, 1 + self.sector.border.len())?;
        Ok(normal)
    }
}

/// Eliminate the numbers from `nb` on, the last first, from a symmetric matrix given by its rows, padded; only the lower triangle
/// is read and kept up. Row k then gives number k by those before it.
#[inline(always)]
fn eliminate(normal: &mut [f64], width: usize, nb: usize) -> Result<(), String> {
    let line = padded(width);
    let mut left = width;
    while left > nb {
        // two at a time: the rows above are read and written half as often
        let both = left - nb > 1;
        let first = left - if both { 2 } else { 1 };
        let (above, rows) = normal.split_at_mut(first * line);
        let (one, other) = rows.split_at_mut(line);
        if both {
            let pivot = positive(other[first + 1])?;
            axpy(&mut one[..padded(first + 1)], -other[first] / pivot, other);
            let pivots = [pivot, positive(one[first])?];
            for i in 0..first {
                axpy2(&mut above[i * line..i * line + padded(i + 1)], [-other[i] / pivots[0], -one[i] / pivots[1]], [other, one]);
            }
        } else {
            let pivot = positive(one[first])?;
            for i in 0..first {
                axpy(&mut above[i * line..i * line + padded(i + 1)], -one[i] / pivot, one);
            }
        }
        left = first;
    }
    Ok(())
}

#[inline(always)]
fn positive(pivot: f64) -> Result<f64, String> {
    if pivot > 0.0 { Ok(pivot) } else { Err(format!("a patch's own equations are singular (pivot {pivot:e})")) }
}

/// Bernstein coefficients of the strut's own gauge on a sector: |E_rim| / r for a cylinder, less what a cone grows by.
fn own_gauge(tables: &Tables, map: &SectorMap) -> Vec<f64> {
    let n = tables.q + 1;
    let nodes = &tables.interpolation.nodes;
    let rim = tables.interpolation.coefficients(&nodes.iter().map(|&s| map.rim_length(s)).collect::<Vec<_>>());
    let radial = map.start();
    if radial.taper == 0.0 {
        return rim.into_iter().flat_map(|w| std::iter::repeat_n(w / radial.radius, n)).collect();
    }
    // the height is a polynomial: first along v, then along s
    let heights: Vec<Vec<f64>> =
        nodes.iter().map(|&s| tables.columns.coefficients(&tables.columns.nodes.iter().map(|&v| map.height_at(s, v)).collect::<Vec<_>>())).collect();
    let mut out = vec![0.0; (tables.p + 1) * n];
    for iv in 0..n {
        let row: Vec<f64> = heights.iter().map(|h| h[iv]).collect();
        for (is, height) in tables.interpolation.coefficients(&row).into_iter().enumerate() {
            out[is * n + iv] = (rim[is] - radial.taper * height) / radial.radius;
        }
    }
    out
}

/// No fit at all: each sector the cylinder of its strut, w = w2. Of cylinders of one radius only: others do not meet on the cells' sides.
pub fn cylinders(tables: &Tables, layout: &Layout) -> Fit {
    let n = tables.p + 1;
    let w2 = |t: &dyn Fn(f64) -> f64| tables.interpolation.coefficients(&tables.interpolation.nodes.iter().map(|&s| 1.0 + t(s).powi(2)).collect::<Vec<_>>());
    let sector = |k: usize| {
        let map = SectorMap::new(layout, k);
        w2(&|s| map.t(s)).into_iter().flat_map(|w| std::iter::repeat_n(w, n)).collect()
    };
    // where corners were joined, the crease's azimuths are not those of its sectors' rims
    let crease = |k: usize| {
        let map = SectorMap::new(layout, 2 * k);
        w2(&|s| map.crease_t(s))
    };
    Fit {
        sectors: (0..layout.sectors.len()).map(sector).collect(),
        creases: (0..layout.creases.len()).map(crease).collect(),
        radials: vec![vec![1.0; n]; layout.radials.len()],
        corners: vec![1.0; layout.corners.len()],
    }
}

/// The control values of a sector behind the `RIM_ROWS`, less the strut's own, as forms of (constant, start jet, end jet, crease,
/// start radial, end radial, inner).
fn deviation(tables: &Tables, layout: &Layout, index: usize, map: &SectorMap, own: &[f64], crease: &CreaseForms, radials: [&RadialForms; 2]) -> SparseRows {
    let (p, q) = (tables.p, tables.q);
    let across = &crease.across[layout.sectors[index].which];
    let (jets, nk, nr) = (2 * JET, tables.crease_free(), tables.radial_free());
    let inner_at = 1 + jets + nk + 2 * nr;
    let mut rows = SparseRows { width: inner_at + tables.inner(), starts: vec![0], entries: Vec::new() };
    // the columns next to the radials: at the border, and the next
    let columns = [0, 1].map(|end| {
        let scale = map.scale_of_ends()[end];
        let step = if end == 0 { 1.0 } else { -1.0 } / p as f64;
        let border: Vec<Form> = radials[end].w.iter().map(|w| w.map(|x| scale * x)).collect();
        let next: Vec<Form> = border.iter().zip(radials[end].across(map, end)).map(|(b, a)| std::array::from_fn(|k| b[k] + step * a[k])).collect();
        [border, next]
    });
    let place = |end: usize, k: usize| match k {
        0 => 0,
        _ if k <= JET => end * JET + k,
        _ => jets + nk + end * nr + k - JET,
    };
    let mut inner = inner_at..;
    for is in 0..=p {
        for iv in RIM_ROWS..=q {
            let own = own[is * (q + 1) + iv];
            let less = |k: usize, x: f64| if k == 0 { x - own } else { x };
            if iv == q {
                rows.push(crease.w[is].iter().enumerate().map(|(k, &x)| (k, less(k, x))));
            } else if iv == q - 1 {
                // where columns are borders too, both give the same twist
                rows.push(crease.w[is].iter().zip(&across[is]).enumerate().map(|(k, (x, y))| (k, less(k, x - y / q as f64))));
            } else if is < 2 || is > p - 2 {
                let (end, row) = if is < 2 { (0, is) } else { (1, p - is) };
                rows.push(columns[end][row][iv].iter().enumerate().map(|(k, &x)| (place(end, k), less(k, x))));
            } else {
                rows.push([(0, -own), (inner.next().expect("no last number"), 1.0)].into_iter());
            }
        }
    }
    rows
}

/// Sample parameters and tables at them, the same for every patch of a degree. Matrices are flat, row by row.
pub struct Samples {
    along: Direction,
    across: Direction,
    /// Products of two basis values across, from `RIM_ROWS` on: the lower triangle row by row, padded for each sample.
    products: Vec<f64>,
    /// What remains of the Gram matrices across from `RIM_ROWS` on, likewise.
    gram_rows: [Vec<f64>; 3],
    /// Sum of the squared second differences of a control net that is 0 in the `RIM_ROWS`: rows padded.
    bends: Vec<f64>,
}

/// Sample parameters of one direction of the patches, and the basis at them.
struct Direction {
    /// (parameter, weight).
    rule: Vec<(f64, f64)>,
    /// Basis values, `[sample * n + i]`.
    basis: Vec<f64>,
    /// Value and slope at each sample of the polynomial that is 1 at one node of the direction map, `[sample * nodes + node]`.
    lagrange: [Vec<f64>; 2],
    /// Gram matrices of the basis, its first and its second derivatives.
    gram: [Vec<f64>; 3],
}

impl Direction {
    /// Of degree n - 1.
    fn new(n: usize, map: &Interpolation) -> Self {
        let rule = gauss::rule(n + 2);
        let all: Vec<_> = rule.iter().map(|&(x, _)| basis(n - 1, x)).collect();
        let gram = [0, 1, 2].map(|order| {
            let entry = |i: usize, j: usize| rule.iter().zip(&all).map(|(&(_, w), b)| w * b[order][i] * b[order][j]).sum::<f64>();
            square(n, entry)
        });
        // coefficients of the polynomial that is 1 at node k
        let nodes = map.nodes.len();
        let units: Vec<Vec<f64>> = (0..nodes).map(|k| map.coefficients(&(0..nodes).map(|i| f64::from(i == k)).collect::<Vec<_>>())).collect();
        let lagrange = [0, 1].map(|order| all.iter().flat_map(|b| units.iter().map(|c| c.iter().zip(&b[order]).map(|(c, b)| c * b).sum())).collect());
        Direction { rule, basis: all.iter().flat_map(|[b, ..]| &b[..n]).copied().collect(), lagrange, gram }
    }
}

impl Samples {
    pub fn new(tables: &Tables) -> Self {
        let (np, n, rows) = (tables.p + 1, tables.q + 1, tables.q + 1 - RIM_ROWS);
        let (along, across) = (Direction::new(np, &tables.map[0]), Direction::new(n, &tables.map[1]));
        let flat = |entry: &dyn Fn(usize, usize) -> f64| {
            let mut out: Vec<f64> = (0..rows).flat_map(|j| (0..=j).map(move |l| entry(j, l))).collect();
            out.resize(padded(out.len()), 0.0);
            out
        };
        let gram_rows = [0, 1, 2].map(|order| flat(&|j, l| across.gram[order][(j + RIM_ROWS) * n + l + RIM_ROWS]));
        let products = across.basis.chunks_exact(n).flat_map(|b| flat(&|j, l| b[j + RIM_ROWS] * b[l + RIM_ROWS])).collect();
        let bends = bends(tables, |_| 1.0);
        Samples { along, across, products, gram_rows, bends }
    }

    /// A map's direction Y at all samples, and its solid angle per unit of parameter: through its values at as many nodes as fix
    /// the polynomial that it is. The map is regular, so the sign of its volume is known.
    fn directions(&self, tables: &Tables, map: &SectorMap) -> Vec<(DVec3, f64)> {
        let [s_nodes, v_nodes] = [0, 1].map(|k| &tables.map[k].nodes);
        let (np, n, m) = (s_nodes.len(), v_nodes.len(), self.along.rule.len());
        let [value, slope] = &self.along.lagrange;
        // along s first: `[sample * n + node of v]`, Y and its derivative by s
        let mut along = vec![[DVec3::ZERO; 2]; m * n];
        for (k, &s) in s_nodes.iter().enumerate() {
            for (l, &v) in v_nodes.iter().enumerate() {
                let y = map.y(s, v);
                for a in 0..m {
                    let [at, by_s] = &mut along[a * n + l];
                    *at += value[a * np + k] * y;
                    *by_s += slope[a * np + k] * y;
                }
            }
        }
        let [value, slope] = &self.across.lagrange;
        let mut out = Vec::with_capacity(m * self.across.rule.len());
        for row in along.chunks_exact(n) {
            for (value, slope) in value.chunks_exact(n).zip(slope.chunks_exact(n)) {
                let (mut y, mut by_s, mut by_v) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
                for (&[at, at_s], (f, d)) in row.iter().zip(value.iter().zip(slope)) {
                    y += *f * at;
                    by_s += *f * at_s;
                    by_v += *d * at;
                }
                out.push((y, y.dot(by_s.cross(by_v)).abs() / y.length().powi(3)));
            }
        }
        out
    }
}

/// Sum of the squared second differences of a control net that is 0 in the `RIM_ROWS`, each times the factor at its middle
/// (`[is * (q + 1) + iv]`). Row by row, padded.
fn bends(tables: &Tables, factor: impl Fn(usize) -> f64) -> Vec<f64> {
    let (np, n, rows) = (tables.p + 1, tables.q + 1, tables.q + 1 - RIM_ROWS);
    let line = padded(np * rows);
    let mut bends = vec![0.0; np * rows * line];
    let slot = |k: usize| (k % n >= RIM_ROWS).then(|| k / n * rows + k % n - RIM_ROWS);
    let triples = (0..np * n).flat_map(|k| [(k / n + 2 < np).then_some([k, k + n, k + 2 * n]), (k % n + 2 < n).then_some([k, k + 1, k + 2])]).flatten();
    for triple in triples {
        let weights = [1.0, -2.0, 1.0];
        let factor = factor(triple[1]);
        for (a, f) in triple.into_iter().zip(weights) {
            for (b, g) in triple.into_iter().zip(weights) {
                if let (Some(a), Some(b)) = (slot(a), slot(b)) {
                    bends[a * line + b] += factor * f * g;
                }
            }
        }
    }
    bends
}

/// The sum of w² at the samples by `weights`, and of the Gram matrices of the thin plate by `plate`: both are products of a
/// matrix in s and one in v, block by block over pairs of s. Weights are padded for each sample along s, rows of the result too.
struct Quadratic<'a> {
    samples: &'a Samples,
    weights: &'a [f64],
    plate: [f64; 3],
    np: usize,
    rows: usize,
}

impl Loops for Quadratic<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run(self) -> Vec<f64> {
        let Quadratic { samples, weights, plate, np, rows } = self;
        let (size, m) = (padded(np * rows), padded(samples.across.rule.len()));
        let mut energy = vec![0.0; np * rows * size];
        let triangle = samples.gram_rows[0].len();
        let mut block = vec![0.0; triangle];
        let mut line = vec![0.0; m];
        for i in 0..np {
            for k in 0..=i {
                line.fill(0.0);
                for (along, weights) in samples.along.basis.chunks_exact(np).zip(weights.chunks_exact(m)) {
                    axpy(&mut line, along[i] * along[k], weights);
                }
                block.fill(0.0);
                for (f, products) in line.iter().zip(samples.products.chunks_exact(triangle)) {
                    axpy(&mut block, *f, products);
                }
                for (order, f) in plate.into_iter().enumerate() {
                    axpy(&mut block, f * samples.along.gram[2 - order][i * np + k], &samples.gram_rows[order]);
                }
                let mut entries = block.iter();
                for j in 0..rows {
                    for (l, &x) in (0..=j).zip(&mut entries) {
                        for (r, c) in [(i * rows + j, k * rows + l), (i * rows + l, k * rows + j), (k * rows + j, i * rows + l), (k * rows + l, i * rows + j)] {
                            energy[r * size + c] = x;
                        }
                    }
                }
            }
        }
        energy
    }
}

/// A square matrix, row by row.
fn square(n: usize, entry: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    (0..n * n).map(|k| entry(k / n, k % n)).collect()
}

/// What one sector's fit has to keep small (see `SectorProblem`).
struct Energy {
    energy: Vec<f64>,
    pull: Vec<f64>,
    area: f64,
    bends: Option<Vec<f64>>,
}

impl Energy {
    /// With `scaled`, fairness and stiffness count what the surface moves, not what w does.
    fn new(tables: &Tables, samples: &Samples, map: &SectorMap, own: &[f64], sampler: &mut Sampler, scaled: bool) -> Result<Energy, String> {
        let (np, n, rows) = (tables.p + 1, tables.q + 1, tables.q + 1 - RIM_ROWS);
        let m = samples.across.rule.len();
        let size = np * rows;
        let line = padded(m);
        // squared distance to the film: weight and target at each sample
        let directions = samples.directions(tables, map);
        let mut weights = vec![0.0; samples.along.rule.len() * line];
        let mut pull = vec![0.0; size];
        let mut moves = vec![1.0; samples.along.rule.len() * m];
        let mut own_at_s = vec![0.0; n];
        let mut pull_at_s = vec![0.0; rows];
        for (a, &(_, ws)) in samples.along.rule.iter().enumerate() {
            let along = &samples.along.basis[a * np..(a + 1) * np];
            own_at_s.fill(0.0);
            pull_at_s.fill(0.0);
            along.iter().zip(own.chunks_exact(n)).for_each(|(f, column)| axpy(&mut own_at_s, *f, column));
            for step in 0..m {
                let b = if a % 2 == 0 { step } else { m - 1 - step };
                let (y, solid_angle) = directions[a * m + b];
                let all = &samples.across.basis[b * n..(b + 1) * n];
                let own: f64 = all.iter().zip(&own_at_s).map(|(f, x)| f * x).sum();
                let hit = sampler.hit(y).ok_or("a ray from the node misses the film")?;
                let (rho, length) = (hit.distance, y.length());
                let facing = hit.normal.dot(y / length).max(LEAST_FACING);
                let area = solid_angle * rho * rho / facing;
                // squared distance along the normal that the surface moves per unit of w
                let move_sq = (rho * rho / length * facing).powi(2);
                if scaled {
                    moves[a * m + b] = move_sq * map.start().radius.powi(2);
                }
                let weight = move_sq * ws * samples.across.rule[b].1 * area;
                weights[a * line + b] = weight;
                axpy(&mut pull_at_s, weight * (length / rho - own), &all[RIM_ROWS..]);
            }
            along.iter().zip(pull.chunks_exact_mut(rows)).for_each(|(f, column)| axpy(column, *f, &pull_at_s));
        }
        // energies of what w is beyond the strut's own gauge, in cylinder coordinates of the strut
        let (dphi, deta, w2) = map.extent();
        let (dphi, deta) = (dphi.clamp(LEAST_WIDTH, 1.0), deta.clamp(LEAST_WIDTH, 1.0));
        let area = dphi * deta / (w2 * w2);
        let mean_move = if scaled { (moves.iter().map(|x: &f64| x.ln()).sum::<f64>() / moves.len() as f64).exp() } else { 1.0 };
        let plate = [1.0 / dphi.powi(4), 2.0 / (dphi * deta).powi(2), 1.0 / deta.powi(4)].map(|f| FAIRNESS * mean_move * area * f);
        let energy = vectorised(Quadratic { samples, weights: &weights, plate, np, rows });
        // the sample nearest to a control value's parameters
        let last = [samples.along.rule.len() - 1, m - 1];
        let near = |k: usize, of: usize, last: usize| (k * last + of / 2) / of;
        let bends = scaled.then(|| bends(tables, |k| moves[near(k / n, np - 1, last[0]) * m + near(k % n, n - 1, last[1])]));
        Ok(Energy { energy, pull, area, bends })
    }
}

/// A matrix of few entries: `entries[starts[r]..starts[r + 1]]` are (column, value) of row r.
struct SparseRows {
    width: usize,
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
}

impl SparseRows {
    /// One more row: its entries that are not 0.
    fn push(&mut self, entries: impl Iterator<Item = (usize, f64)>) {
        self.entries.extend(entries.filter(|e| e.1 != 0.0));
        self.starts.push(self.entries.len());
    }

    fn rows(&self) -> impl Iterator<Item = &[(usize, f64)]> {
        self.starts.windows(2).map(|w| &self.entries[w[0]..w[1]])
    }
}

impl SectorProblem {
    /// N, row by row, padded: Dᵀ Q D for the deviation D, less the pull in the column of the constant. The row of the constant lacks
    /// its pull: no one asks for it.
    #[inline(always)]
    fn normal<'a>(&self, samples: &Samples, stiffness: f64, scratch: &'a mut Scratch) -> &'a mut [f64] {
        let (width, size) = (padded(self.deviation.width), padded(self.pull.len()));
        let Scratch { quadratic, turned, row, normal } = scratch;
        quadratic.clone_from(&self.energy);
        axpy(quadratic, stiffness * self.area, self.bends.as_ref().unwrap_or(&samples.bends));
        // (Q D)ᵀ, row by row
        refill(turned, width * size);
        for (line, entries) in quadratic.chunks_exact(size).zip(self.deviation.rows()) {
            for &(c, f) in entries {
                axpy(&mut turned[c * size..(c + 1) * size], f, line);
            }
        }
        refill(normal, self.deviation.width * width);
        refill(row, width);
        for (r, entries) in self.deviation.rows().enumerate() {
            row.iter_mut().zip(turned.iter().skip(r).step_by(size)).for_each(|(x, t)| *x = *t);
            row[0] -= self.pull[r];
            for &(c, f) in entries {
                axpy(&mut normal[c * width..c * width + padded(c + 1)], f, row);
            }
        }
        normal
    }
}

/// Room for one sector's equations, used again for the next.
#[derive(Default)]
struct Scratch {
    quadratic: Vec<f64>,
    turned: Vec<f64>,
    row: Vec<f64>,
    normal: Vec<f64>,
}

/// So many zeros.
fn refill(x: &mut Vec<f64>, n: usize) {
    x.clear();
    x.resize(n, 0.0);
}
