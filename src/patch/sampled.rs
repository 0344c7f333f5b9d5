//! The film as a node's sectors see it: what w should be at the sample parameters of a fit, and what an error of w there counts for.
//!
//! On the ray along Y the skin is at |Y| / w and the film at ρ: w should be |Y| / ρ, and per unit of w the surface moves by
//! ρ² / |Y| along the ray, that times cos(normal, ray) along its normal.

use crate::math::{Loops, axpy, combine_all, padded, vectorised};
use crate::node::{Film, Sampler};
use crate::patch::fit::Samples;
use crate::patch::forms::Tables;
use crate::patch::layout::Layout;
use crate::patch::map::SectorMap;
use glam::DVec3;

/// The steepest film (cosine between normal and ray) that still counts in full.
const LEAST_FACING: f64 = 0.05;

const MISSED: &str = "a ray from the node misses the film";

/// The samples of all sectors of a node.
pub struct Sampled {
    pub sectors: Vec<SectorSamples>,
}

/// The samples of one sector, `[along * samples across + across]`.
pub struct SectorSamples {
    /// The strut's own gauge: Bernstein coefficients, `[is * (q + 1) + iv]`.
    pub own: Vec<f64>,
    /// What w should be beyond the strut's own gauge.
    pub targets: Vec<f64>,
    /// Squared distance along the normal that the surface moves per unit of w.
    pub moves: Vec<f64>,
    /// The same integrated over the area that a sample stands for; rows are padded.
    pub weights: Vec<f64>,
}

/// The places across, there and back: neighbours are near for the film's sampler.
pub fn snake(along: usize, across: usize) -> impl Iterator<Item = usize> {
    (0..across).map(move |step| if along % 2 == 0 { step } else { across - 1 - step })
}

impl Sampled {
    /// Look at the film along the directions of all sectors' maps.
    pub fn new(tables: &Tables, samples: &Samples, layout: &Layout, film: &Film) -> Result<Sampled, String> {
        let mut sampler = film.sampler();
        let sectors =
            (0..layout.sectors.len()).map(|k| SectorSamples::new(tables, samples, &SectorMap::new(layout, k), &mut sampler)).collect::<Option<Vec<_>>>();
        Ok(Sampled { sectors: sectors.ok_or(MISSED)? })
    }

    /// The same, but none where the film's roughness exceeds `most`, node units: the largest distance of the film, at the samples, from the surfaces whose w is of
    /// one degree less both ways, each sector's by itself, of least squares. A forecast of what the fit will miss, without its borders: of 357 nodes of tet lattices
    /// the logarithms of both correlate by 0.97.
    ///
    /// Films are roughest where struts are closest: a sector there is looked at first, enough for two of three rough films.
    pub fn unless_rougher(tables: &Tables, samples: &Samples, layout: &Layout, film: &Film, most: f64) -> Result<Option<Sampled>, String> {
        let is_rough = |sector: &SectorSamples| sector.roughness(samples) > most;
        let angle = |k: &usize| layout.creases[layout.sectors[*k].crease].frame.theta;
        let closest = (0..layout.sectors.len()).min_by(|a, b| angle(a).total_cmp(&angle(b)));
        let mut sampler = film.sampler();
        let seen = closest.and_then(|k| SectorSamples::new(tables, samples, &SectorMap::new(layout, k), &mut sampler));
        if seen.is_some_and(|sector| is_rough(&sector)) {
            return Ok(None);
        }
        let mut sampler = film.sampler();
        let mut sectors = Vec::with_capacity(layout.sectors.len());
        for k in 0..layout.sectors.len() {
            let sector = SectorSamples::new(tables, samples, &SectorMap::new(layout, k), &mut sampler).ok_or(MISSED)?;
            if is_rough(&sector) {
                return Ok(None);
            }
            sectors.push(sector);
        }
        Ok(Some(Sampled { sectors }))
    }
}

impl SectorSamples {
    fn new(tables: &Tables, samples: &Samples, map: &SectorMap, sampler: &mut Sampler) -> Option<SectorSamples> {
        let (np, n) = (tables.p + 1, tables.q + 1);
        let (na, m) = (samples.along.rule.len(), samples.across.rule.len());
        let own = own_gauge(tables, map);
        let ys = map.ys(&tables.map[0].nodes, &tables.map[1].nodes);
        let line = padded(m);
        let lines = vectorised(Directions { samples, ys: &ys, own: &own, counts: [np, n] });
        let (mut targets, mut moves, mut weights) = (vec![0.0; na * m], vec![0.0; na * m], vec![0.0; na * line]);
        for ((a, &(_, ws)), lines) in samples.along.rule.iter().enumerate().zip(lines.chunks_exact(5 * line)) {
            for b in snake(a, m) {
                let [x, y, z, solid_angle, own] = std::array::from_fn(|k| lines[k * line + b]);
                let y = DVec3::new(x, y, z);
                let hit = sampler.hit(y)?;
                let (rho, length) = (hit.distance, y.length());
                let facing = hit.normal.dot(y / length).max(LEAST_FACING);
                let area = solid_angle * rho * rho / facing;
                let moved = (rho * rho / length * facing).powi(2);
                targets[a * m + b] = length / rho - own;
                moves[a * m + b] = moved;
                weights[a * line + b] = moved * ws * samples.across.rule[b].1 * area;
            }
        }
        Some(SectorSamples { own, targets, moves, weights })
    }

    /// See `Sampled::unless_rougher`.
    fn roughness(&self, samples: &Samples) -> f64 {
        let (along, across) = (&samples.along.projection, &samples.across.projection);
        let (na, m) = (samples.along.rule.len(), samples.across.rule.len());
        let product = |f: &[f64], g: &[f64]| f.iter().zip(g).map(|(f, g)| f * g).sum::<f64>();
        let lines: Vec<f64> = self.targets.chunks_exact(m).flat_map(|line| across.chunks_exact(m).map(move |row| product(row, line))).collect();
        let mut nearest = vec![0.0; na * m];
        for (row, to) in along.chunks_exact(na).zip(nearest.chunks_exact_mut(m)) {
            row.iter().zip(lines.chunks_exact(m)).for_each(|(f, line)| axpy(to, *f, line));
        }
        let off = self.targets.iter().zip(&nearest).zip(&self.moves).map(|((target, near), moved)| (target - near).powi(2) * moved);
        off.fold(0.0, f64::max).sqrt()
    }
}

/// The matrix from values at the points of Gauss's rule to those of the nearest polynomial made of x^from to x^to, row by row.
pub(super) fn projection(rule: &[(f64, f64)], from: usize, to: usize) -> Vec<f64> {
    let product = |f: &[f64], g: &[f64]| f.iter().zip(g).zip(rule).map(|((f, g), r)| f * g * r.1).sum::<f64>();
    // Gram and Schmidt, twice for round-off
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for power in from..=to {
        let mut f: Vec<f64> = rule.iter().map(|r| r.0.powi(power as i32)).collect();
        for g in basis.iter().chain(&basis) {
            let along = product(&f, g);
            axpy(&mut f, -along, g);
        }
        let length = product(&f, &f).sqrt();
        f.iter_mut().for_each(|x| *x /= length);
        basis.push(f);
    }
    let n = rule.len();
    (0..n * n).map(|k| basis.iter().map(|f| f[k / n] * f[k % n]).sum::<f64>() * rule[k % n].1).collect()
}

/// A map's direction Y at all samples, and its solid angle per unit of parameter: through its values `ys` at as many nodes as fix
/// the polynomial that it is. The map is regular, so the sign of its volume is known. Also the strut's own gauge there, from its coefficients.
///
/// For each sample along s five padded lines: x, y, z, solid angle, own gauge.
struct Directions<'a> {
    samples: &'a Samples,
    /// `[node of s * nodes of v + node of v]`.
    ys: &'a [DVec3],
    own: &'a [f64],
    /// Coefficients along and across.
    counts: [usize; 2],
}

impl Loops for Directions<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run(self) -> Vec<f64> {
        let Directions { samples: Samples { along, across, .. }, ys, own, counts: [np, n] } = self;
        let (na, line) = (along.rule.len(), padded(across.rule.len()));
        let (s_nodes, v_nodes) = (along.lagrange[0].len() / na, across.turned[0].len() / line);
        let [value, slope] = &along.lagrange;
        let mut out = vec![0.0; na * 5 * line];
        let mut own_at_s = vec![0.0; n];
        // at one s: x, y, z of Y and of its slope by s, a line of the nodes of v each
        let mut nodes = vec![0.0; 6 * v_nodes];
        // slopes of Y by s and by v
        let mut slopes = vec![0.0; 6 * line];
        for (a, out) in out.chunks_exact_mut(5 * line).enumerate() {
            for l in 0..v_nodes {
                let (mut y, mut by_s) = (DVec3::ZERO, DVec3::ZERO);
                for k in 0..s_nodes {
                    y += value[a * s_nodes + k] * ys[k * v_nodes + l];
                    by_s += slope[a * s_nodes + k] * ys[k * v_nodes + l];
                }
                [y.x, y.y, y.z, by_s.x, by_s.y, by_s.z].into_iter().enumerate().for_each(|(c, x)| nodes[c * v_nodes + l] = x);
            }
            for c in 0..3 {
                let [at, by_s] = [c, 3 + c].map(|c| &nodes[c * v_nodes..(c + 1) * v_nodes]);
                combine_all(&mut out[c * line..(c + 1) * line], at, &across.turned[0], line);
                combine_all(&mut slopes[c * line..(c + 1) * line], by_s, &across.turned[0], line);
                combine_all(&mut slopes[(3 + c) * line..(4 + c) * line], at, &across.turned[1], line);
            }
            own_at_s.fill(0.0);
            along.basis[a * np..(a + 1) * np].iter().zip(own.chunks_exact(n)).for_each(|(f, column)| axpy(&mut own_at_s, *f, column));
            combine_all(&mut out[4 * line..], &own_at_s, &across.turned_basis, line);
            let (y, rest) = out.split_at_mut(3 * line);
            for (j, angles) in rest[..line].as_chunks_mut::<4>().0.iter_mut().enumerate() {
                let part = |from: &[f64], c: usize| *from[c * line + 4 * j..].first_chunk::<4>().expect("lines are padded");
                let [x, y, z] = [part(y, 0), part(y, 1), part(y, 2)];
                let [xs, ys, zs] = [part(&slopes, 0), part(&slopes, 1), part(&slopes, 2)];
                let [xv, yv, zv] = [part(&slopes, 3), part(&slopes, 4), part(&slopes, 5)];
                for k in 0..4 {
                    let cross = [ys[k] * zv[k] - yv[k] * zs[k], zs[k] * xv[k] - zv[k] * xs[k], xs[k] * yv[k] - xv[k] * ys[k]];
                    let length = (x[k] * x[k] + y[k] * y[k] + z[k] * z[k]).sqrt();
                    angles[k] = (x[k] * cross[0] + y[k] * cross[1] + z[k] * cross[2]).abs() / (length * length * length);
                }
            }
        }
        out
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::gauss;

    /// A polynomial of the space is its own nearest one; x^5 is off that of degree 4 by a Legendre polynomial, 1/252 at the ends.
    #[test]
    fn projections_keep_their_own_space() {
        let rule = gauss::rule(9);
        let at = |matrix: &[f64], f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            matrix.chunks_exact(9).map(|row| row.iter().zip(&rule).map(|(m, r)| m * f(r.0)).sum::<f64>()).collect()
        };
        let from_square = projection(&rule, 2, 5);
        for (x, r) in at(&from_square, &|x| x * x - 3.0 * x.powi(5)).iter().zip(&rule) {
            assert!((x - (r.0 * r.0 - 3.0 * r.0.powi(5))).abs() < 1e-12);
        }
        let fourth = projection(&rule, 0, 4);
        for (x, r) in at(&fourth, &|x| x.powi(5)).iter().zip(&rule) {
            let y = 2.0 * r.0 - 1.0;
            let legendre = (63.0 * y.powi(5) - 70.0 * y.powi(3) + 15.0 * y) / 8.0;
            assert!((r.0.powi(5) - x - legendre / 252.0).abs() < 1e-13);
        }
    }
}
