//! Volume, area and centroid by exact integration, from the faces alone: closed forms for
//! cylinders, cones and caps, the divergence theorem with Gauss's rule over the knot spans of patches.
//!
//! Every rim circle is closed by its disc, which cuts the solid into closed bodies: one cylinder or
//! frustum a strut and one blob a node. Each body is measured about its own origin, so a lattice far from
//! the origin, or a long one, loses no digits. Bodies are added in the order of their ids.

use super::error::BrepError;
use super::model::{Circle, Solid, Surface};
use crate::graph::End;
use crate::math::gauss;
use crate::math::nurbs::{NurbsSurface, Table, breaks};
use crate::math::{Loops, combine_all, room, vectorised};
use crate::patch::Shelved;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;
use std::sync::Arc;

/// Gauss points per knot span and direction: so many at first (u, v), which tell how many are needed, and at most so many.
const FIRST: [usize; 2] = [12, 16];
const MOST: usize = 96;

/// Points that are looked at side by side.
const WIDE: usize = 4;

/// The last Legendre coefficients that a rule of n points can see, those of degree n - 2 and n - 1, may be this part of the area. They fall geometrically, and the
/// rule's error is that of the coefficients from degree 2 n on: about the square of this. Volumes converge faster, as they have no root.
const TAIL: f64 = 2.5e-4;

/// What a body holds. mm, mm², mm³.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measure {
    pub volume: f64,
    /// Outer surface only; rim discs do not count.
    pub area: f64,
    pub centroid: DVec3,
}

/// Surface integrals with outward normal n over part of a boundary, y relative to some origin.
#[derive(Clone, Copy, Debug, Default)]
pub struct Flux {
    /// ∫ dA
    pub area: f64,
    /// ∫ y_i n_i dA: each component of a closed surface is its volume.
    pub volume: DVec3,
    /// ½ ∫ y_i² n_i dA: of a closed surface the first moment of volume.
    pub moment: DVec3,
}

impl std::ops::AddAssign for Flux {
    fn add_assign(&mut self, other: Flux) {
        self.area += other.area;
        self.volume += other.volume;
        self.moment += other.moment;
    }
}

/// Measure a solid. An inside-out node is an error: nothing below it would mean anything.
pub fn measure(solid: &Solid) -> Result<Measure, BrepError> {
    let skins = skin_fluxes(solid);
    let nodes: Vec<Measure> = (0..solid.nodes.len()).into_par_iter().map(|n| node_body(solid, n, &skins[&solid.skins[n].1.place()])).collect();
    for (&node, body) in solid.nodes.iter().zip(&nodes) {
        if body.volume < 0.0 || body.volume.is_nan() {
            return Err(BrepError::InsideOut { node, volume: body.volume });
        }
    }
    let struts = (0..solid.struts.len()).map(|k| strut_body(solid, k));
    Ok(total(nodes.iter().copied().chain(struts)))
}

/// The patches of each distinct skin, about its node and in its units: nodes that share a skin are measured once.
fn skin_fluxes(solid: &Solid) -> HashMap<(usize, u64), Flux> {
    let distinct: BTreeMap<(usize, u64), &Shelved> = solid.skins.iter().map(|(_, skin)| (skin.place(), skin)).collect();
    let flux = |(place, skin): ((usize, u64), &Shelved)| {
        let (mut sum, mut rules) = (Flux::default(), Rules::default());
        skin.skin().patches.iter().for_each(|patch| sum += rules.flux(&patch.surface));
        (place, sum)
    };
    distinct.into_par_iter().map(flux).collect()
}

/// The cylinder or frustum between a strut's rims.
fn strut_body(solid: &Solid, k: usize) -> Measure {
    let [a, b] = [0, 1].map(|end| solid.rim(k, end));
    let length = (b.center - a.center).dot(a.axis);
    if solid.slopes[k] == 0.0 {
        let volume = PI * a.radius * a.radius * length;
        return Measure { volume, area: 2.0 * PI * a.radius * length, centroid: 0.5 * (a.center + b.center) };
    }
    let (p, q) = (a.radius, b.radius);
    let squares = p * p + p * q + q * q;
    let height = 0.25 * (p * p + 2.0 * p * q + 3.0 * q * q) / squares;
    let area = PI * (p + q) * length.hypot(q - p);
    Measure { volume: PI / 3.0 * squares * length, area, centroid: a.center.lerp(b.center, height) }
}

/// Sum of disjoint bodies, in the order given; their common centroid.
pub fn total(bodies: impl Iterator<Item = Measure>) -> Measure {
    let mut sum = Measure::default();
    let mut origin = None;
    let mut moment = DVec3::ZERO;
    for body in bodies {
        // Moments about the first body, not about the origin of the model.
        let origin = *origin.get_or_insert(body.centroid);
        sum.volume += body.volume;
        sum.area += body.area;
        moment += body.volume * (body.centroid - origin);
    }
    sum.centroid = origin.unwrap_or_default() + if sum.volume > 0.0 { moment / sum.volume } else { DVec3::ZERO };
    sum
}

/// The body between a node's skin (or cap) and the discs of its rims.
fn node_body(solid: &Solid, n: usize, skin: &Flux) -> Measure {
    let (origin, unit) = (solid.centers[n], solid.skins[n].0);
    match solid.cap(n).map(|face| face.surface) {
        Some(Surface::Plane { circle, .. }) => {
            let c = &solid.circles[circle];
            return Measure { volume: 0.0, area: PI * c.radius * c.radius, centroid: c.center };
        }
        Some(Surface::Sphere { circle, flipped }) => {
            let c = &solid.circles[circle];
            let out = if flipped { -c.axis } else { c.axis };
            let square = PI * c.radius * c.radius;
            let centroid = c.center + 0.375 * c.radius * out;
            return Measure { volume: 2.0 / 3.0 * square * c.radius, area: 2.0 * square, centroid };
        }
        _ => {}
    }
    let area = unit.powi(2) * skin.area;
    let mut sum = Flux { area, volume: unit.powi(3) * skin.volume, moment: unit.powi(4) * skin.moment };
    for &(k, end) in solid.arms_of(n) {
        // outward: against the circle's axis at end b
        sum += disc_flux(solid.rim(k as usize, end as usize), if end == End::A { 1.0 } else { -1.0 }, origin);
    }
    // The three components agree but for round-off (and the quadrature's error).
    let volume = sum.volume.element_sum() / 3.0;
    Measure { volume, area, centroid: origin + if volume > 0.0 { sum.moment / volume } else { DVec3::ZERO } }
}

/// The disc in a circle, normal `sign * axis`, about `origin`.
pub fn disc_flux(circle: &Circle, sign: f64, origin: DVec3) -> Flux {
    let (n, c, r) = (sign * circle.axis, circle.center - origin, circle.radius);
    let area = PI * r * r;
    // Mean of y_i² over the disc: c_i² + r²/4 (1 - n_i²).
    let square = c * c + 0.25 * r * r * (DVec3::ONE - n * n);
    Flux { area, volume: area * c * n, moment: 0.5 * area * square * n }
}

/// One patch, about its own origin, by Gauss's rule on every knot span.
pub fn patch_flux(s: &NurbsSurface) -> Flux {
    Rules::default().flux(s)
}

/// Rules of the last patch's degrees and knots, which its neighbours mostly share, by the number of points: of u and of v.
#[derive(Default)]
struct Rules {
    kept: [BTreeMap<usize, Rule>; 2],
    scratch: Scratch,
}

/// Room for one patch's integrals, used again for the next.
#[derive(Default)]
struct Scratch {
    rows: Vec<f64>,
    at: Vec<f64>,
    mirrored: Vec<f64>,
    factors: Vec<f64>,
    sums: Sums,
}

impl Rules {
    /// By as many points in each direction as its coefficients ask for.
    fn flux(&mut self, s: &NurbsSurface) -> Flux {
        let mut counts = FIRST;
        loop {
            let (flux, tails) = self.by(s, counts);
            let more = [0, 1].map(|d| needed(counts[d], tails[d]).next_multiple_of(2 + 2 * d).min(MOST));
            if more.iter().zip(&counts).all(|(more, count)| more <= count) {
                return flux;
            }
            counts = [0, 1].map(|d| counts[d].max(more[d]));
        }
    }

    /// By so many points of u and of v; and what tells of more.
    fn by(&mut self, s: &NurbsSurface, counts: [usize; 2]) -> (Flux, [f64; 2]) {
        for d in 0..2 {
            if self.kept[d].first_key_value().is_some_and(|(_, rule)| !rule.table.fits(s.degree[d], &s.knots[d])) {
                self.kept[d].clear();
            }
            self.kept[d].entry(counts[d]).or_insert_with(|| Rule::new(s.degree[d], &s.knots[d], counts[d]));
        }
        let rules = [0, 1].map(|d| &self.kept[d][&counts[d]]);
        vectorised(Integral { surface: s, rules, scratch: &mut self.scratch })
    }
}

/// How many points in place of `count` bring the last coefficients, now this part of the area, below the limit.
fn needed(count: usize, tail: f64) -> usize {
    let degree = (count - 2) as f64;
    if tail <= TAIL {
        count
    } else if tail < 0.5 {
        (3.0 + degree * TAIL.ln() / tail.ln()).ceil() as usize
    } else {
        2 * count
    }
}

/// Sums over the points of a patch, in lanes.
#[derive(Default)]
struct Sums {
    /// Area, volume and moment.
    flux: [[f64; WIDE]; 7],
    /// The last two coefficients of the area along u, of each v in turn.
    along_u: [Vec<f64>; 2],
    /// Along v, without their signs, summed over u.
    along_v: [f64; 2],
}

/// The integrals over a patch, many points of one u at a time.
struct Integral<'a> {
    surface: &'a NurbsSurface,
    rules: [&'a Rule; 2],
    scratch: &'a mut Scratch,
}

impl Loops for Integral<'_> {
    type Output = (Flux, [f64; 2]);

    #[inline(always)]
    fn run(self) -> (Flux, [f64; 2]) {
        let Integral { surface: s, rules: [us, vs], scratch: Scratch { rows, at, mirrored, factors, sums } } = self;
        let ([nu, nv], n) = (s.size(), vs.weights.len());
        // of each row of control points its curve at all v: four lines (weight · point, weight), and their slopes
        let rows = room(rows, nu * 8 * n);
        for ((row, points), weights) in rows.chunks_exact_mut(8 * n).zip(s.points.chunks_exact(nv)).zip(s.weights.chunks_exact(nv)) {
            let (values, slopes) = row.split_at_mut(4 * n);
            for (c, (values, slopes)) in values.chunks_exact_mut(n).zip(slopes.chunks_exact_mut(n)).enumerate() {
                factors.clear();
                match c {
                    0 => factors.extend(points.iter().zip(weights).map(|(p, w)| p.x * w)),
                    1 => factors.extend(points.iter().zip(weights).map(|(p, w)| p.y * w)),
                    2 => factors.extend(points.iter().zip(weights).map(|(p, w)| p.z * w)),
                    _ => factors.extend_from_slice(weights),
                }
                combine_all(values, factors, &vs.values, n);
                combine_all(slopes, factors, &vs.slopes, n);
            }
        }
        sums.clear(n);
        let at = room(at, 12 * n);
        let line = us.weights.len();
        if !us.mirrored {
            for u in 0..us.count {
                // the lines at one u, and the slopes by u behind them
                for (table, part) in [(&us.values, 0..8 * n), (&us.slopes, 8 * n..12 * n)] {
                    factors.clear();
                    factors.extend(table.iter().skip(u).step_by(line));
                    combine_all(&mut at[part], factors, rows, 8 * n);
                }
                sums.add(at, vs, us, u);
            }
            return sums.total();
        }
        // points come in pairs u and 1 - u: there the even part of what is summed is the same, and the odd part has the other sign
        let half = nu / 2;
        let (front, back) = rows.split_at_mut((nu - half) * 8 * n);
        for (one, other) in front.chunks_exact_mut(8 * n).zip(back.chunks_exact_mut(8 * n).rev()) {
            one.iter_mut().zip(other).for_each(|(one, other)| (*one, *other) = (0.5 * (*one + *other), 0.5 * (*one - *other)));
        }
        let mirrored = room(mirrored, 12 * n);
        for u in 0..us.count / 2 {
            for (table, part, sign) in [(&us.values, 0..8 * n, 1.0), (&us.slopes, 8 * n..12 * n, -1.0)] {
                let (even, odd) = (&mut at[part.clone()], &mut mirrored[part]);
                let first = |i: usize| table[i * line + u];
                let last = |i: usize| table[(nu - 1 - i) * line + u];
                // the middle row, if there is one, is its own mirror image
                factors.clear();
                factors.extend((0..nu - half).map(|i| if i < half { first(i) + last(i) } else { first(i) }));
                combine_all(even, factors, front, 8 * n);
                factors.clear();
                factors.extend((0..half).rev().map(|i| first(i) - last(i)));
                combine_all(odd, factors, back, 8 * n);
                even.iter_mut().zip(odd).for_each(|(even, odd)| (*even, *odd) = (*even + *odd, sign * (*even - *odd)));
            }
            sums.add(at, vs, us, u);
            sums.add(mirrored, vs, us, us.count - 1 - u);
        }
        sums.total()
    }
}

impl Sums {
    fn clear(&mut self, line: usize) {
        self.flux = [[0.0; WIDE]; 7];
        self.along_v = [0.0; 2];
        for along in &mut self.along_u {
            along.clear();
            along.resize(line, 0.0);
        }
    }

    /// Add the points of one u: `at` are twelve lines, (weight · point, weight), their slopes by v, and by u.
    #[inline(always)]
    fn add(&mut self, at: &[f64], vs: &Rule, us: &Rule, u: usize) {
        let (n, wu) = (vs.weights.len(), us.weights[u]);
        let last_of_u = [us.last[0][u], us.last[1][u]];
        let mut along_v = [[0.0; WIDE]; 2];
        for (j, wv) in vs.weights.as_chunks::<WIDE>().0.iter().enumerate() {
            let line = |c: usize| at[c * n + j * WIDE..].first_chunk::<WIDE>().expect("lines are padded");
            let [x, y, z, w, xv, yv, zv, wv_, xu, yu, zu, wu_] = std::array::from_fn(line);
            let mut areas = [0.0; WIDE];
            for k in 0..WIDE {
                let scale = 1.0 / w[k];
                let p = [x[k] * scale, y[k] * scale, z[k] * scale];
                let du = [(xu[k] - wu_[k] * p[0]) * scale, (yu[k] - wu_[k] * p[1]) * scale, (zu[k] - wu_[k] * p[2]) * scale];
                let dv = [(xv[k] - wv_[k] * p[0]) * scale, (yv[k] - wv_[k] * p[1]) * scale, (zv[k] - wv_[k] * p[2]) * scale];
                let f = wu * wv[k];
                let normal = [du[1] * dv[2] - du[2] * dv[1], du[2] * dv[0] - du[0] * dv[2], du[0] * dv[1] - du[1] * dv[0]].map(|n| n * f);
                areas[k] = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
                self.flux[0][k] += areas[k];
                for c in 0..3 {
                    let part = p[c] * normal[c];
                    self.flux[1 + c][k] += part;
                    self.flux[4 + c][k] += 0.5 * p[c] * part;
                }
            }
            for (c, along_v) in along_v.iter_mut().enumerate() {
                let along_u = self.along_u[c][j * WIDE..].first_chunk_mut::<WIDE>().expect("lines are padded");
                let last_of_v = vs.last[c][j * WIDE..].first_chunk::<WIDE>().expect("lines are padded");
                for k in 0..WIDE {
                    along_u[k] += last_of_u[c] * areas[k];
                    along_v[k] += last_of_v[k] * areas[k];
                }
            }
        }
        self.along_v.iter_mut().zip(along_v).for_each(|(sum, lanes)| *sum += lanes.iter().sum::<f64>().abs());
    }

    fn total(&self) -> (Flux, [f64; 2]) {
        let [area, rest @ ..] = self.flux.map(|lanes| lanes.iter().sum::<f64>());
        let [volume, moment] = [0, 3].map(|k| DVec3::from_slice(&rest[k..]));
        let along_u = [0, 1].map(|c: usize| self.along_u[c].iter().map(|x| x.abs()).sum::<f64>());
        let tails = [along_u, self.along_v].map(|[a, b]| a.max(b) / area);
        (Flux { area, volume, moment }, tails)
    }
}

/// Gauss's rule on the knot spans of one parameter: the basis functions at its points, and their weights (shares of the
/// parameter's length). Lines are padded with points of weight 0.
struct Rule {
    table: Table,
    count: usize,
    /// The knots are their own mirror image: so are the points and the basis.
    mirrored: bool,
    weights: Vec<f64>,
    /// The last two Legendre polynomials that the rule can see, each times 2 degree + 1, at its points.
    last: [Vec<f64>; 2],
    /// A line for each control point.
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Rule {
    fn new(degree: usize, knots: &Arc<[f64]>, points: usize) -> Rule {
        let breaks = breaks(degree, knots);
        let rule = gauss::rule(points);
        let both = breaks.windows(2).flat_map(|part| rule.iter().map(move |&(x, w)| (part[0] + x * (part[1] - part[0]), w * (part[1] - part[0]))));
        let (mut parameters, mut weights): (Vec<f64>, Vec<f64>) = both.unzip();
        let count = weights.len();
        let line = count.next_multiple_of(WIDE);
        parameters.resize(line, parameters[0]);
        weights.resize(line, 0.0);
        let size = line * (knots.len() - degree - 1);
        let (mut values, mut slopes) = (vec![0.0; size], vec![0.0; size]);
        let table = Table::new(degree, knots, parameters.into_iter());
        for (k, sample) in table.samples().iter().enumerate() {
            for r in 0..=degree {
                values[(sample.first + r) * line + k] = sample.value[r];
                slopes[(sample.first + r) * line + k] = sample.slope[r];
            }
        }
        let (first, last) = (knots[0], knots[knots.len() - 1]);
        let mirrored = count % 2 == 0 && knots.iter().zip(knots.iter().rev()).all(|(a, b)| a - first == last - b);
        let last = [points - 2, points - 1].map(|degree| {
            let scale = (2 * degree + 1) as f64;
            let of_span: Vec<f64> = rule.iter().map(|&(x, _)| scale * gauss::legendre(degree, 2.0 * x - 1.0).0).collect();
            of_span.iter().cycle().copied().take(line).collect()
        });
        Rule { table, count, mirrored, weights, last, values, slopes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Surface of revolution about z of a rational curve in the xz-plane, one octant (90°).
    fn quarter_turn(profile: &[(f64, f64, f64)], degree: usize) -> NurbsSurface {
        let ends = |d: usize| [vec![0.0; d + 1], vec![1.0; d + 1]].concat().into();
        let arc = [(DVec3::X, 1.0), (DVec3::X + DVec3::Y, 0.5f64.sqrt()), (DVec3::Y, 1.0)];
        let mut points = vec![];
        let mut weights = vec![];
        for (d, w) in arc {
            for &(x, z, v) in profile {
                points.push(d * x + DVec3::Z * z);
                weights.push(w * v);
            }
        }
        NurbsSurface { degree: [2, degree], knots: [ends(2), ends(degree)], points, weights: weights.into() }
    }

    fn assert_close(found: f64, exact: f64, tolerance: f64) {
        assert!((found - exact).abs() < tolerance * exact.abs().max(1.0), "{found} against {exact}");
    }

    /// An octant of the unit ball: the three flat sides contribute nothing to y · n, and their
    /// part of the moment is known.
    #[test]
    fn sphere_octant() {
        let half = 0.5f64.sqrt();
        let flux = patch_flux(&quarter_turn(&[(1.0, 0.0, 1.0), (1.0, 1.0, half), (0.0, 1.0, 1.0)], 2));
        assert_close(flux.area, PI / 2.0, 1e-12);
        for k in 0..3 {
            assert_close(flux.volume[k], PI / 6.0, 1e-12);
            assert_close(flux.moment[k], PI / 16.0, 1e-12);
        }
    }

    #[test]
    fn cylinder_quarter() {
        let flux = patch_flux(&quarter_turn(&[(1.0, 0.0, 1.0), (1.0, 3.0, 1.0)], 1));
        assert_close(flux.area, 1.5 * PI, 1e-12);
        assert_close(flux.volume.x, 0.75 * PI, 1e-12);
        assert_close(flux.moment.x, 1.0, 1e-12);
    }

    /// A flat square over knots that are not their own mirror image, one over the origin.
    #[test]
    fn knots_need_no_symmetry() {
        let (ku, kv) = ([0.0, 0.0, 0.0, 0.3, 1.0, 1.0, 1.0].into(), [0.0, 0.0, 1.0, 1.0].into());
        let points = [0.0, 0.15, 0.65, 1.0].iter().flat_map(|&x| [0.0, 1.0].map(|y| DVec3::new(x, y, 1.0))).collect();
        let flux = patch_flux(&NurbsSurface { degree: [2, 1], knots: [ku, kv], points, weights: [1.0; 8].into() });
        assert_close(flux.area, 1.0, 1e-14);
        assert_close(flux.volume.z, 1.0, 1e-14);
        assert_close(flux.moment.z, 0.5, 1e-14);
    }

    /// Quarter turn of the outer-upper quarter of a torus's tube (R = 3, r = 1).
    #[test]
    fn torus_quarter() {
        let half = 0.5f64.sqrt();
        let surface = quarter_turn(&[(4.0, 0.0, 1.0), (4.0, 1.0, half), (3.0, 1.0, 1.0)], 2);
        // Pappus: length of the tube's quarter times the way of its centroid.
        assert_close(patch_flux(&surface).area, PI / 2.0 * (3.0 * PI / 2.0 + 1.0), 1e-12);
    }

    /// Each point more gains at least a digit on an arc of 90° (its nearest pole decides).
    #[test]
    fn the_rule_converges_geometrically() {
        let half = 0.5f64.sqrt();
        let surface = quarter_turn(&[(4.0, 0.0, 1.0), (4.0, 1.0, half), (3.0, 1.0, 1.0)], 2);
        let exact = PI / 2.0 * (3.0 * PI / 2.0 + 1.0);
        let error = |n: usize| {
            let rule = gauss::rule(n);
            let both = rule.iter().flat_map(|u| rule.iter().map(move |v| (u, v)));
            let sum: f64 = both
                .map(|(u, v)| {
                    let jet = surface.jet1(u.0, v.0);
                    u.1 * v.1 * jet.du.cross(jet.dv).length()
                })
                .sum();
            (sum / exact - 1.0).abs()
        };
        let errors = [2, 4, 6, 8].map(error);
        assert!(errors.windows(2).all(|e| e[1] < 0.02 * e[0]), "{errors:?}");
    }
}
