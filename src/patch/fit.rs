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
use crate::math::sparse::Blocks;
use crate::math::{Loops, axpy, axpy2, combine, combine_all, padded, room, vectorised};
use crate::patch::forms::{CreaseForms, Form, JET, RadialForms, Tables};
use crate::patch::layout::Layout;
use crate::patch::map::SectorMap;
use crate::patch::sampled::{Sampled, SectorSamples, projection, snake};
use std::ops::Range;

/// Weight of the thin-plate energy, in r². Measured: at 1e-5 and above the fit error grows, below 1e-7 thin sectors ripple.
const FAIRNESS: f64 = 1e-6;

/// Rows of each patch, from the rim on, that are the strut: there w is the strut's own gauge, whatever the free numbers.
pub(super) const RIM_ROWS: usize = 2;

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
    sectors: Vec<SectorProblem<'a>>,
    samples: &'a Samples,
    /// Of corners, creases and radials, and their numbers.
    blocks: Blocks,
    ranges: Vec<Range<usize>>,
}

/// One sector's part: a quadratic form ½ (1, x)ᵀ N (1, x) in the patch's own numbers. It is kept in the control values
/// of w less the strut's own gauge behind the `RIM_ROWS`, in the order of `Samples::values`: the inner ones are numbers themselves.
struct SectorProblem<'a> {
    /// Global number of each border number.
    border: Vec<usize>,
    /// The strut's own gauge, `[is * (q + 1) + iv]`.
    own: &'a [f64],
    /// The outer control values, as forms of the constant and the border numbers.
    deviation: SparseColumns,
    /// Distance to the film and thin-plate energy: the quadratic part (see `kept`), and the linear part with its sign turned.
    energy: Vec<f64>,
    pull: Vec<f64>,
    /// Area of the sector: what the second differences of the control net count for.
    area: f64,
    /// As `Samples::bends`, where the layout is fine.
    bends: Option<Vec<f64>>,
}

impl<'a> Problem<'a> {
    /// The equations of all sectors of a node.
    pub fn new(tables: &'a Tables, samples: &'a Samples, layout: &'a Layout, sampled: &'a Sampled) -> Result<Self, String> {
        let creases: Vec<CreaseForms> = (0..layout.creases.len()).map(|k| CreaseForms::new(tables, layout, k)).collect();
        let radials: Vec<RadialForms> = (0..layout.radials.len()).map(|k| RadialForms::new(tables, layout, k)).collect();
        let ranges = ranges(tables, layout);
        let blocks = Blocks::new(&ranges, (0..layout.sectors.len()).map(|k| meeting(layout, k)))?;
        let mut problem = Problem { tables, layout, creases, radials, sectors: Vec::with_capacity(layout.sectors.len()), samples, blocks, ranges };
        for (index, (sector, seen)) in layout.sectors.iter().zip(&sampled.sectors).enumerate() {
            let map = SectorMap::new(layout, index);
            let mut border = problem.crease_numbers(sector.crease);
            border.extend(sector.radials.iter().flat_map(|&r| problem.radial_free(r)));
            let own = &seen.own;
            let deviation = deviation(tables, layout, index, &map, own, &problem.creases[sector.crease], sector.radials.map(|r| &problem.radials[r]));
            let Energy { energy, pull, area, bends } = Energy::new(tables, samples, &map, seen, layout.fine);
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
    fn radial_free(&self, k: usize) -> Range<usize> {
        let free = self.tables.radial_free();
        let at = JET * self.layout.corners.len() + self.tables.crease_free() * self.layout.creases.len() + free * k;
        at..at + free
    }

    /// The skin of least error, with weight `stiffness` (r²) on the second differences of the control nets.
    pub fn solve(&self, stiffness: f64) -> Result<Fit, String> {
        let mut matrix = self.blocks.zeros();
        let mut rhs = vec![0.0; self.radial_free(self.layout.radials.len()).start];
        let mut inner = Vec::with_capacity(self.sectors.len());
        let mut scratch = Scratch::default();
        for (k, sector) in self.sectors.iter().enumerate() {
            let (nb, line) = (1 + sector.border.len(), padded(sector.width(self.samples)));
            let normal = vectorised(Reduction { sector, samples: self.samples, stiffness, scratch: &mut scratch })?;
            let row = |a: usize| &normal[(a + 1) * line..(a + 2) * line];
            sector.border.iter().enumerate().for_each(|(a, &number)| rhs[number] -= row(a)[0]);
            self.blocks.add(&mut matrix, &self.ranges, &meeting(self.layout, k), |a| &row(a)[1..]);
            inner.push(normal[nb * line..].to_vec());
        }
        let x = self.blocks.solve(&matrix, &rhs)?;
        let value = |form: &Form, numbers: &[usize]| form[0] + form[1..].iter().zip(numbers).map(|(f, &k)| f * x[k]).sum::<f64>();
        let radial_numbers = |k: usize| -> Vec<usize> {
            let corner = self.layout.radials[k].corner;
            (JET * corner..JET * (corner + 1)).chain(self.radial_free(k)).collect()
        };
        Ok(Fit {
            sectors: self.sectors.iter().zip(&inner).map(|(sector, inner)| sector.gauge(self.samples, inner, &x)).collect(),
            creases: self.creases.iter().enumerate().map(|(k, f)| f.w.iter().map(|w| value(w, &self.crease_numbers(k))).collect()).collect(),
            radials: self.radials.iter().enumerate().map(|(k, f)| f.w.iter().map(|w| value(w, &radial_numbers(k))).collect()).collect(),
            corners: (0..self.layout.corners.len()).map(|k| x[JET * k]).collect(),
        })
    }
}

impl SectorProblem<'_> {
    /// How many numbers there are, the constant included.
    fn width(&self, samples: &Samples) -> usize {
        1 + self.border.len() + samples.values.len() - samples.outer
    }

    /// All coefficients from the border numbers `x` and the eliminated rows of the inner numbers.
    fn gauge(&self, samples: &Samples, inner: &[f64], x: &[f64]) -> Vec<f64> {
        let mut numbers = vec![1.0];
        numbers.extend(self.border.iter().map(|&k| x[k]));
        let mut w = self.own.to_vec();
        let (outer, rest) = samples.values.split_at(samples.outer);
        for (&number, column) in numbers.iter().zip(self.deviation.columns()) {
            column.iter().for_each(|&(k, f)| w[outer[k]] += f * number);
        }
        for (row, &at) in inner.chunks_exact(padded(self.width(samples))).zip(rest) {
            let k = numbers.len();
            let number = -row.iter().zip(&numbers).map(|(a, b)| a * b).sum::<f64>() / row[k];
            w[at] += number;
            numbers.push(number);
        }
        w
    }
}

/// The numbers of the corners, the creases and the radials.
fn ranges(tables: &Tables, layout: &Layout) -> Vec<Range<usize>> {
    let sizes = [(layout.corners.len(), JET), (layout.creases.len(), tables.crease_free()), (layout.radials.len(), tables.radial_free())];
    let mut end = 0;
    let range = |size: usize| {
        end += size;
        end - size..end
    };
    sizes.into_iter().flat_map(|(count, size)| std::iter::repeat_n(size, count)).map(range).collect()
}

/// Which of these meet in a sector, in the order of its border numbers.
fn meeting(layout: &Layout, sector: usize) -> [usize; 5] {
    let (nc, nk) = (layout.corners.len(), layout.creases.len());
    let s = &layout.sectors[sector];
    let ([a, b], [c, d]) = (layout.creases[s.crease].corners, s.radials);
    [a, b, nc + s.crease, nc + nk + c, nc + nk + d]
}

/// A sector's equations, its inner numbers eliminated.
struct Reduction<'a> {
    sector: &'a SectorProblem<'a>,
    samples: &'a Samples,
    stiffness: f64,
    scratch: &'a mut Scratch,
}

impl<'a> Loops for Reduction<'a> {
    type Output = Result<&'a mut [f64], String>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let normal = self.sector.normal(self.samples, self.stiffness, self.scratch);
        eliminate(normal, self.sector.width(self.samples), 1 + self.sector.border.len())?;
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

/// The outer control values of a sector behind the `RIM_ROWS`, less the strut's own, as forms of (constant, start jet, end jet,
/// crease, start radial, end radial).
fn deviation(tables: &Tables, layout: &Layout, index: usize, map: &SectorMap, own: &[f64], crease: &CreaseForms, radials: [&RadialForms; 2]) -> SparseColumns {
    let (p, q) = (tables.p, tables.q);
    let across = &crease.across[layout.sectors[index].which];
    let (jets, nk, nr) = (2 * JET, tables.crease_free(), tables.radial_free());
    let mut rows = Rows::new(1 + jets + nk + 2 * nr);
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
    for is in 0..=p {
        for iv in (RIM_ROWS..=q).filter(|&iv| !is_inner(tables, is, iv)) {
            let own = own[is * (q + 1) + iv];
            let less = |k: usize, x: f64| if k == 0 { x - own } else { x };
            if iv == q {
                rows.push(crease.w[is].iter().enumerate().map(|(k, &x)| (k, less(k, x))));
            } else if iv == q - 1 {
                // where columns are borders too, both give the same twist
                rows.push(crease.w[is].iter().zip(&across[is]).enumerate().map(|(k, (x, y))| (k, less(k, x - y / q as f64))));
            } else {
                let (end, row) = if is < 2 { (0, is) } else { (1, p - is) };
                rows.push(columns[end][row][iv].iter().enumerate().map(|(k, &x)| (place(end, k), less(k, x))));
            }
        }
    }
    rows.columns()
}

/// Whether a control value is two or more away from all borders but the rim.
fn is_inner(tables: &Tables, is: usize, iv: usize) -> bool {
    (2..=tables.p - 2).contains(&is) && iv <= tables.q - 2
}

/// Sample parameters and tables at them, the same for every patch of a degree. Matrices are flat, row by row.
pub struct Samples {
    pub(super) along: Direction,
    pub(super) across: Direction,
    /// The control values behind the `RIM_ROWS`, `is * (q + 1) + iv`: outer ones first, so many, then the inner ones (`is_inner`).
    values: Vec<usize>,
    outer: usize,
    /// For each entry of a form in the control values (see `kept`) its place among the blocks of `Quadratic`.
    sources: Vec<u32>,
    /// Products of two basis values across, from `RIM_ROWS` on: the lower triangle row by row, padded for each sample.
    products: Vec<f64>,
    /// What remains of the Gram matrices across from `RIM_ROWS` on, likewise.
    gram_rows: [Vec<f64>; 3],
    /// Sum of the squared second differences of a control net that is 0 in the `RIM_ROWS` (see `kept`).
    bends: Vec<f64>,
}

/// Sample parameters of one direction of the patches, and the basis at them.
pub(super) struct Direction {
    /// (parameter, weight).
    pub(super) rule: Vec<(f64, f64)>,
    /// Basis values, `[sample * n + i]`.
    pub(super) basis: Vec<f64>,
    /// Value and slope at each sample of the polynomial that is 1 at one node of the direction map, `[sample * nodes + node]`.
    pub(super) lagrange: [Vec<f64>; 2],
    /// The same turned, `[node * padded samples + sample]`.
    pub(super) turned: [Vec<f64>; 2],
    /// The basis turned, `[i * padded samples + sample]`.
    pub(super) turned_basis: Vec<f64>,
    /// From values at the samples to those of the nearest polynomial of one degree less; 0 in the `RIM_ROWS` across.
    pub(super) projection: Vec<f64>,
    /// Gram matrices of the basis, its first and its second derivatives.
    gram: [Vec<f64>; 3],
}

impl Direction {
    /// Of degree n - 1, of which the first `zeros` coefficients are 0 for the projection.
    fn new(n: usize, zeros: usize, map: &Interpolation) -> Self {
        let rule = gauss::rule(n + 2);
        let all: Vec<_> = rule.iter().map(|&(x, _)| basis(n - 1, x)).collect();
        let gram = [0, 1, 2].map(|order| {
            let entry = |i: usize, j: usize| rule.iter().zip(&all).map(|(&(_, w), b)| w * b[order][i] * b[order][j]).sum::<f64>();
            square(n, entry)
        });
        // coefficients of the polynomial that is 1 at node k
        let nodes = map.nodes.len();
        let units: Vec<Vec<f64>> = (0..nodes).map(|k| map.coefficients(&(0..nodes).map(|i| f64::from(i == k)).collect::<Vec<_>>())).collect();
        let lagrange: [Vec<f64>; 2] =
            [0, 1].map(|order| all.iter().flat_map(|b| units.iter().map(|c| c.iter().zip(&b[order]).map(|(c, b)| c * b).sum())).collect());
        let basis: Vec<f64> = all.iter().flat_map(|[b, ..]| &b[..n]).copied().collect();
        let turn = |rows: &[f64], width: usize| -> Vec<f64> {
            (0..width).flat_map(|k| (0..padded(rule.len())).map(move |a| if a * width + k < rows.len() { rows[a * width + k] } else { 0.0 })).collect()
        };
        let turned = [0, 1].map(|order: usize| turn(&lagrange[order], nodes));
        let (turned_basis, projection) = (turn(&basis, n), projection(&rule, zeros, n - 2));
        Direction { basis, lagrange, turned, turned_basis, projection, gram, rule }
    }
}

impl Samples {
    pub fn new(tables: &Tables) -> Self {
        let (np, n, rows) = (tables.p + 1, tables.q + 1, tables.q + 1 - RIM_ROWS);
        let (along, across) = (Direction::new(np, 0, &tables.map[0]), Direction::new(n, RIM_ROWS, &tables.map[1]));
        let flat = |entry: &dyn Fn(usize, usize) -> f64| {
            let mut out: Vec<f64> = (0..rows).flat_map(|j| (0..=j).map(move |l| entry(j, l))).collect();
            out.resize(padded(out.len()), 0.0);
            out
        };
        let gram_rows = [0, 1, 2].map(|order| flat(&|j, l| across.gram[order][(j + RIM_ROWS) * n + l + RIM_ROWS]));
        let products = across.basis.chunks_exact(n).flat_map(|b| flat(&|j, l| b[j + RIM_ROWS] * b[l + RIM_ROWS])).collect();
        let all = (0..np).flat_map(|is| (RIM_ROWS..n).map(move |iv| (is, iv)));
        let (inner, outer): (Vec<_>, Vec<_>) = all.partition(|&(is, iv)| is_inner(tables, is, iv));
        let values: Vec<usize> = outer.iter().chain(&inner).map(|(is, iv)| is * n + iv).collect();
        let bends = bends(tables, &values, outer.len(), |_| 1.0);
        let sources = sources(&values, outer.len(), n, gram_rows[0].len());
        Samples { along, across, values, outer: outer.len(), sources, products, gram_rows, bends }
    }
}

/// What is kept of a quadratic form in so many control values, in the order of `Samples::values`: the rows of the outer ones,
/// padded, then the triangle of the inner ones, row by row. Pairs (row, column) of numbers of values; none where rows are padded.
fn kept(outer: usize, size: usize) -> impl Iterator<Item = Option<(usize, usize)>> {
    let whole = (0..outer).flat_map(move |a| (0..padded(size)).map(move |b| (b < size).then_some((a, b))));
    whole.chain((outer..size).flat_map(move |a| (outer..=a).map(move |b| Some((a, b)))))
}

/// See `Samples::sources`: `n` values a column, blocks are `triangle` long.
fn sources(values: &[usize], outer: usize, n: usize, triangle: usize) -> Vec<u32> {
    let triangular = |a: usize, b: usize| a.max(b) * (a.max(b) + 1) / 2 + a.min(b);
    let at = |a: usize, b: usize| triangular(a / n, b / n) * triangle + triangular(a % n - RIM_ROWS, b % n - RIM_ROWS);
    kept(outer, values.len()).map(|pair| pair.map_or(0, |(a, b)| at(values[a], values[b]) as u32)).collect()
}

/// Sum of the squared second differences of a control net that is 0 in the `RIM_ROWS`, each times the factor at its middle
/// (`[is * (q + 1) + iv]`), as `kept`.
fn bends(tables: &Tables, values: &[usize], outer: usize, factor: impl Fn(usize) -> f64) -> Vec<f64> {
    let (np, n, size) = (tables.p + 1, tables.q + 1, values.len());
    let mut bends = vec![0.0; size * size];
    let mut slots = vec![None; np * n];
    values.iter().enumerate().for_each(|(slot, &k)| slots[k] = Some(slot));
    let triples = (0..np * n).flat_map(|k| [(k / n + 2 < np).then_some([k, k + n, k + 2 * n]), (k % n + 2 < n).then_some([k, k + 1, k + 2])]).flatten();
    for triple in triples {
        let weights = [1.0, -2.0, 1.0];
        let factor = factor(triple[1]);
        for (a, f) in triple.into_iter().zip(weights) {
            for (b, g) in triple.into_iter().zip(weights) {
                if let (Some(a), Some(b)) = (slots[a], slots[b]) {
                    bends[a * size + b] += factor * f * g;
                }
            }
        }
    }
    kept(outer, size).map(|pair| pair.map_or(0.0, |(a, b)| bends[a * size + b])).collect()
}

/// The sum of w² at the samples by `weights`, and of the Gram matrices of the thin plate by `plate`: both are products of a
/// matrix in s and one in v, so that all entries for two columns of control values are one symmetric block. Weights are padded
/// for each sample along s. The result as `kept`.
struct Quadratic<'a> {
    samples: &'a Samples,
    weights: &'a [f64],
    plate: [f64; 3],
    np: usize,
}

impl Loops for Quadratic<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run(self) -> Vec<f64> {
        let Quadratic { samples, weights, plate, np } = self;
        let m = padded(samples.across.rule.len());
        let triangle = samples.gram_rows[0].len();
        let mut blocks = vec![0.0; np * (np + 1) / 2 * triangle];
        let (mut line, mut along) = (vec![0.0; m], Vec::with_capacity(samples.along.rule.len()));
        let mut rest = blocks.chunks_exact_mut(triangle);
        for i in 0..np {
            for (k, block) in (0..=i).zip(&mut rest) {
                along.clear();
                along.extend(samples.along.basis.chunks_exact(np).map(|along| along[i] * along[k]));
                combine_all(&mut line, &along, weights, m);
                combine_all(block, &line, &samples.products, triangle);
                for (order, f) in plate.into_iter().enumerate() {
                    axpy(block, f * samples.along.gram[2 - order][i * np + k], &samples.gram_rows[order]);
                }
            }
        }
        let mut out = vec![0.0; samples.sources.len()];
        let ((from, from_rest), (to, to_rest)) = (samples.sources.as_chunks::<8>(), out.as_chunks_mut::<8>());
        to.iter_mut().zip(from).for_each(|(to, from)| *to = from.map(|at| blocks[at as usize]));
        to_rest.iter_mut().zip(from_rest).for_each(|(to, &at)| *to = blocks[at as usize]);
        out
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
    fn new(tables: &Tables, samples: &Samples, map: &SectorMap, seen: &SectorSamples, scaled: bool) -> Energy {
        let (np, n, rows) = (tables.p + 1, tables.q + 1, tables.q + 1 - RIM_ROWS);
        let m = samples.across.rule.len();
        let mut pull = vec![0.0; np * rows];
        let mut pull_at_s = vec![0.0; rows];
        for (a, basis) in samples.along.basis.chunks_exact(np).enumerate() {
            pull_at_s.fill(0.0);
            for b in snake(a, m) {
                axpy(&mut pull_at_s, seen.weights[a * padded(m) + b] * seen.targets[a * m + b], &samples.across.basis[b * n + RIM_ROWS..(b + 1) * n]);
            }
            basis.iter().zip(pull.chunks_exact_mut(rows)).for_each(|(f, column)| axpy(column, *f, &pull_at_s));
        }
        // what the surface moves per unit of w, in radii of the strut
        let moves: Vec<f64> = if scaled { seen.moves.iter().map(|x| x * map.start().radius.powi(2)).collect() } else { vec![] };
        // energies of what w is beyond the strut's own gauge, in cylinder coordinates of the strut
        let (dphi, deta, w2) = map.extent();
        let (dphi, deta) = (dphi.clamp(LEAST_WIDTH, 1.0), deta.clamp(LEAST_WIDTH, 1.0));
        let area = dphi * deta / (w2 * w2);
        let mean_move = if scaled { (moves.iter().map(|x| x.ln()).sum::<f64>() / moves.len() as f64).exp() } else { 1.0 };
        let plate = [1.0 / dphi.powi(4), 2.0 / (dphi * deta).powi(2), 1.0 / deta.powi(4)].map(|f| FAIRNESS * mean_move * area * f);
        let energy = vectorised(Quadratic { samples, weights: &seen.weights, plate, np });
        let pull = samples.values.iter().map(|&k| pull[k / n * rows + k % n - RIM_ROWS]).collect();
        // the sample nearest to a control value's parameters
        let last = [samples.along.rule.len() - 1, m - 1];
        let near = |k: usize, of: usize, last: usize| (k * last + of / 2) / of;
        let bends = scaled.then(|| bends(tables, &samples.values, samples.outer, |k| moves[near(k / n, np - 1, last[0]) * m + near(k % n, n - 1, last[1])]));
        Energy { energy, pull, area, bends }
    }
}

/// A matrix of few entries: `entries[starts[c]..starts[c + 1]]` are (row, value) of column c.
struct SparseColumns {
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
}

impl SparseColumns {
    fn columns(&self) -> impl Iterator<Item = &[(usize, f64)]> {
        self.starts.windows(2).map(|w| &self.entries[w[0]..w[1]])
    }
}

/// The same matrix under assembly, row by row.
struct Rows {
    count: usize,
    /// (column, row, value).
    entries: Vec<(usize, usize, f64)>,
    /// How many entries the columns before a column have, and it itself.
    ends: Vec<usize>,
}

impl Rows {
    fn new(width: usize) -> Self {
        Rows { count: 0, entries: Vec::with_capacity(16 * width), ends: vec![0; width] }
    }

    /// One more row: its entries that are not 0.
    fn push(&mut self, entries: impl Iterator<Item = (usize, f64)>) {
        for (column, value) in entries.filter(|e| e.1 != 0.0) {
            self.entries.push((column, self.count, value));
            self.ends[column] += 1;
        }
        self.count += 1;
    }

    fn columns(self) -> SparseColumns {
        let mut starts = Vec::with_capacity(self.ends.len() + 1);
        starts.push(0);
        starts.extend(self.ends.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        }));
        let mut at = starts.clone();
        let mut entries = vec![(0, 0.0); self.entries.len()];
        for (column, row, value) in self.entries {
            entries[at[column]] = (row, value);
            at[column] += 1;
        }
        SparseColumns { starts, entries }
    }
}

impl SectorProblem<'_> {
    /// N, the lower triangle row by row, padded: Dᵀ Q D for D = (deviation, inner values as they are), less the pull in the column
    /// of the constant. What lies above the triangle, and the row of the constant, hold what they held: no one asks for them.
    #[inline(always)]
    fn normal<'a>(&self, samples: &Samples, stiffness: f64, scratch: &'a mut Scratch) -> &'a mut [f64] {
        let (outer, nb) = (samples.outer, 1 + self.border.len());
        let (width, size, line) = (padded(self.width(samples)), padded(self.pull.len()), padded(nb));
        let Scratch { quadratic, turned, product, normal } = scratch;
        let (bends, weight) = (self.bends.as_ref().unwrap_or(&samples.bends), stiffness * self.area);
        quadratic.clear();
        quadratic.extend(self.energy.iter().zip(bends).map(|(x, bend)| x + weight * bend));
        let (whole, triangle) = quadratic.split_at(outer * size);
        // (Q D)ᵀ of the outer columns, row by row, and the same turned
        let turned = room(turned, nb * size);
        let product = room(product, self.pull.len() * line);
        for (c, (row, entries)) in turned.chunks_exact_mut(size).zip(self.deviation.columns()).enumerate() {
            combine(row, entries, whole, size);
            product.iter_mut().skip(c).step_by(line).zip(row).for_each(|(to, x)| *to = *x);
        }
        for (row, pull) in product.chunks_exact_mut(line).zip(&self.pull) {
            row[0] -= pull;
        }
        let normal = room(normal, self.width(samples) * width);
        let (border, inner) = normal.split_at_mut(nb * width);
        for (c, (row, entries)) in border.chunks_exact_mut(width).zip(self.deviation.columns()).enumerate().skip(1) {
            combine(&mut row[..padded(c + 1)], entries, product, line);
        }
        let mut rest = triangle;
        for (k, (row, product)) in inner.chunks_exact_mut(width).zip(product[outer * line..].chunks_exact(line)).enumerate() {
            let (own, others) = rest.split_at(k + 1);
            row[..nb].copy_from_slice(&product[..nb]);
            row[nb..nb + k + 1].copy_from_slice(own);
            rest = others;
        }
        normal
    }
}

/// Room for one sector's equations, used again for the next.
#[derive(Default)]
struct Scratch {
    quadratic: Vec<f64>,
    turned: Vec<f64>,
    product: Vec<f64>,
    normal: Vec<f64>,
}
