//! Where a rim arc runs on its patch: the patch's parameter u as a function of the circle's
//! azimuth.
//!
//! A rim arc's curve is a CIRCLE, parametrised by azimuth; on the patch it is the border v = 0,
//! whose parameter is no linear function of azimuth. Readers that rebuild this relation by
//! themselves miss by 2e-6 r on an arc of 90° (measured, OCC 7.6 and 8.0), twenty times their own
//! tolerance. So it is computed here and written with the file: one polynomial in Bernstein form,
//! through Chebyshev-Lobatto points, of the lowest degree that is good enough.

use super::assemble::outward_sign;
use super::model::{Circle, Face, Part, Solid, SplineSurface, Surface};
use crate::graph::End;
use crate::math::bernstein::{Interpolation, MOST_DEGREE, basis};
use crate::math::nurbs::NurbsCurve;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

/// Largest distance between the mapped point and the circle's point, in radii. Well below the
/// 1e-7 mm of readers for any radius up to 30 mm; round-off stays below 1e-13.
const TOLERANCE: f64 = 3e-9;
/// Share of the border's parameter below which an arc's end and the border's end are one.
const SAME: f64 = 1e-9;
/// Degrees tried in turn, each from this length of arc on (radians): a rational quadratic arc of 9°,
/// 31°, 62°, 96°, 129° and 159° is the longest that each degree holds. Shorter arcs start lower.
const DEGREES: [(usize, f64); 6] = [(3, 0.0), (5, 0.158), (7, 0.549), (9, 1.094), (11, 1.686), (13, 2.265)];
/// Pieces are halved this often before the map is taken as it is (borders with weak knots).
const MOST_HALVINGS: usize = 6;

/// A clamped plane B-spline: azimuth on the circle (radians) ▶ u, on the patch's first row (v at its least).
#[derive(Clone, Debug, PartialEq)]
pub struct RimMap {
    pub degree: u8,
    /// Polynomials, of equal lengths of arc.
    pieces: u8,
    /// Azimuths of the ends, in the sense of the circle.
    arc: [f64; 2],
    /// Control values of u.
    pub us: Box<[f64]>,
}

impl RimMap {
    /// Full knot vector: azimuths in the sense of the circle.
    pub fn knots(&self) -> Vec<f64> {
        let degree = self.degree as usize;
        let mut knots = vec![self.arc[0]; degree + 1];
        (1..self.pieces as usize).for_each(|k| knots.extend(vec![joint(self.arc, k, self.pieces as usize); degree]));
        knots.extend(vec![self.arc[1]; degree + 1]);
        knots
    }
}

/// Where the k-th of so many equal pieces of an arc begins.
fn joint(arc: [f64; 2], k: usize, pieces: usize) -> f64 {
    arc[0] + (arc[1] - arc[0]) * k as f64 / pieces as f64
}

/// Fit where each rim arc of each node's patches runs on its patch, in the order of faces and `Part::arcs`. Nodes that differ in nothing but
/// their places share what is fitted once.
pub(super) fn map_rims(solid: &Solid) -> Vec<Arc<[RimMap]>> {
    let keys: Vec<Key> = (0..solid.nodes.len()).into_par_iter().map(|n| key(solid, n)).collect();
    let (mut known, mut firsts) = (HashMap::new(), vec![]);
    let of_node = |(n, key): (usize, Key)| {
        *known.entry(key).or_insert_with(|| {
            firsts.push(n);
            firsts.len() - 1
        })
    };
    let of_nodes: Vec<usize> = keys.into_iter().enumerate().map(of_node).collect();
    let maps: Vec<Arc<[RimMap]>> = firsts.into_par_iter().map(|n| maps_of(solid, n)).collect();
    of_nodes.into_iter().map(|k| maps[k].clone()).collect()
}

/// All that a node's maps depend on, to the bit: its skin, its unit of length, and the frame, radius and seam of each rim.
type Key = ((usize, u64), Vec<u64>);

fn key(solid: &Solid, n: usize) -> Key {
    let (unit, skin) = &solid.skins[n];
    let of_arm = |&(k, end): &(u32, End)| {
        let circle = solid.rim(k as usize, end as usize);
        let split = solid.strut_ends[k as usize][end as usize].split.map_or(u64::MAX, u64::from);
        let numbers = [circle.axis, circle.x, solid.seams[k as usize]].map(|v| v.to_array().map(f64::to_bits));
        numbers.as_flattened().iter().copied().chain([circle.radius.to_bits(), split, end as u64]).collect::<Vec<u64>>()
    };
    (skin.place(), std::iter::once(unit.to_bits()).chain(solid.arms_of(n).iter().flat_map(of_arm)).collect())
}

fn maps_of(solid: &Solid, n: usize) -> Arc<[RimMap]> {
    let skin = solid.skins[n].1.skin();
    let part = solid.part_at_origin(n, &skin);
    let of_face = |face: &Face| {
        let Surface::Spline(s) = &face.surface else { return vec![] };
        let map = |(circle, edge): (usize, u32)| {
            let (k, end) = (circle / 2, [End::A, End::B][circle % 2]);
            let arm = solid.arms_of(n).iter().position(|&a| a == (k as u32, end)).expect("an arm is listed at its node");
            let circle = &solid.circles[circle];
            let center = solid.skins[n].0 * skin.rims[arm].cut * (outward_sign(end) * circle.axis);
            let border = border_row(&part, s, center);
            // a vertex that is not the skin's is where the seam splits the arc
            let from_center = |vertex: u32| part.vertex(vertex).map_or(circle.radius * solid.seams[k], |p| p - center);
            let arc = azimuths(circle, part.edge(edge).vertices.map(from_center));
            let [low, high] = border.domain();
            let jet = border.jet1(0.5 * (low + high));
            let along = circle.axis.cross(jet.p).dot(jet.d) > 0.0;
            fit(&border, circle, arc, if along { [low, high] } else { [high, low] })
        };
        part.arcs(face).map(map).collect()
    };
    part.faces.iter().flat_map(of_face).collect()
}

/// The row v = 0 of a patch, about `origin` (mm).
fn border_row(part: &Part, s: &SplineSurface, origin: DVec3) -> NurbsCurve {
    let columns = s.knots[1].len() - s.degree[1] - 1;
    NurbsCurve {
        degree: s.degree[0],
        knots: s.knots[0].clone(),
        points: s.points.iter().step_by(columns).map(|&i| part.points[i as usize] - origin).collect(),
        weights: s.weights.iter().step_by(columns).copied().collect(),
    }
}

/// Azimuths of an arc's two ends, given from the circle's centre, the first in [0, 2π), the second above it by at most 2π.
fn azimuths(circle: &Circle, ends: [DVec3; 2]) -> [f64; 2] {
    let [a, b] = ends.map(|p| circle.azimuth(p).rem_euclid(TAU));
    [a, if b > a { b } else { b + TAU }]
}

/// Fit the map of one arc. `border` is the patch's first row, about the circle's centre (mm);
/// `arc` are the azimuths of the arc's ends, `us` the parameters of the border between which the
/// arc lies, in the arc's sense.
pub fn fit(border: &NurbsCurve, circle: &Circle, arc: [f64; 2], us: [f64; 2]) -> RimMap {
    let map = Inverse { border, circle };
    // An end at the border's end is exactly there.
    let end = |k: usize| {
        let u = map.solve(arc[k], us, us[k]);
        if (u - us[k]).abs() <= SAME * (us[1] - us[0]).abs() { us[k] } else { u }
    };
    let us = [end(0), end(1)];
    let length = arc[1] - arc[0];
    let start = DEGREES.iter().rposition(|d| length > d.1).unwrap_or(0);
    for &(degree, _) in &DEGREES[start..] {
        let values = map.interpolate(degree, arc, us);
        if map.miss(&values, arc) <= TOLERANCE {
            return RimMap { degree: degree as u8, pieces: 1, arc, us: values.into() };
        }
    }
    // No single polynomial will do: equal pieces of a middle degree, joined with equal values.
    let degree = 7;
    let mut halvings = 1;
    loop {
        let pieces = 1 << halvings;
        let at = |k: usize| joint(arc, k, pieces);
        let ends: Vec<f64> = (0..=pieces)
            .map(|k| {
                if k == 0 {
                    us[0]
                } else if k == pieces {
                    us[1]
                } else {
                    map.solve(at(k), us, us[0] + (us[1] - us[0]) * k as f64 / pieces as f64)
                }
            })
            .collect();
        let parts: Vec<Vec<f64>> = (0..pieces).map(|k| map.interpolate(degree, [at(k), at(k + 1)], [ends[k], ends[k + 1]])).collect();
        let good = (0..pieces).all(|k| map.miss(&parts[k], [at(k), at(k + 1)]) <= TOLERANCE);
        if good || halvings == MOST_HALVINGS {
            let mut values = vec![us[0]];
            parts.iter().for_each(|part| values.extend(&part[1..]));
            return RimMap { degree: degree as u8, pieces: pieces as u8, arc, us: values.into() };
        }
        halvings += 1;
    }
}

/// The border as a function azimuth ▶ u.
struct Inverse<'a> {
    border: &'a NurbsCurve,
    circle: &'a Circle,
}

impl Inverse<'_> {
    /// The u in `bracket` (in the arc's sense, ends included) whose point has this azimuth;
    /// `start` is a guess.
    fn solve(&self, azimuth: f64, bracket: [f64; 2], start: f64) -> f64 {
        let [mut low, mut high] = bracket;
        let close = 1e-8 * (high - low).abs();
        let mut u = start.clamp(low.min(high), low.max(high));
        for _ in 0..60 {
            let jet = self.border.jet1(u);
            // The sign tells on which side of the answer u lies.
            let away = wrap(self.circle.azimuth(jet.p) - azimuth);
            if away < 0.0 {
                low = u
            } else {
                high = u
            }
            let slope = self.circle.axis.cross(jet.p).dot(jet.d) / jet.p.length_squared();
            let newton = u - away / slope;
            let inside = (newton - low) * (newton - high) <= 0.0;
            let next = if inside { newton } else { 0.5 * (low + high) };
            let step = (next - u).abs();
            u = next;
            // Newton's next step would be the square of this one.
            if inside && step <= close {
                break;
            }
        }
        u
    }

    /// Bernstein coefficients of the polynomial through Lobatto's points of this piece.
    fn interpolate(&self, degree: usize, arc: [f64; 2], us: [f64; 2]) -> Vec<f64> {
        let Points { lobatto, .. } = Points::of(degree);
        let mut values = vec![us[0]; degree + 1];
        values[degree] = us[1];
        for k in 1..degree {
            let x = lobatto.nodes[k];
            values[k] = self.solve(arc[0] + x * (arc[1] - arc[0]), us, us[0] + x * (us[1] - us[0]));
        }
        let mut out = lobatto.coefficients(&values);
        (out[0], out[degree]) = (us[0], us[1]);
        out
    }

    /// Largest distance (in radii) between circle and mapped border, between the fitted points.
    fn miss(&self, values: &[f64], arc: [f64; 2]) -> f64 {
        let mut worst = 0.0f64;
        for (x, basis) in &Points::of(values.len() - 1).between {
            let u: f64 = basis.iter().zip(values).map(|(b, v)| b * v).sum();
            let away = wrap(self.circle.azimuth(self.border.point(u)) - (arc[0] + x * (arc[1] - arc[0])));
            worst = worst.max(away.abs());
        }
        worst
    }
}

/// Where the map of one degree is fitted and where it is checked, made once.
struct Points {
    lobatto: Interpolation,
    /// (x, all Bernstein polynomials at x).
    between: Vec<(f64, [f64; MOST_DEGREE + 1])>,
}

impl Points {
    fn of(degree: usize) -> &'static Points {
        static ALL: [OnceLock<Points>; MOST_DEGREE + 1] = [const { OnceLock::new() }; MOST_DEGREE + 1];
        ALL[degree].get_or_init(|| {
            let x = |k: usize| (k as f64 + 0.5) / (2.0 * degree as f64);
            Points { lobatto: Interpolation::new(degree), between: (0..2 * degree).map(|k| (x(k), basis(degree, x(k))[0])).collect() }
        })
    }
}

/// To (-π, π].
fn wrap(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const CIRCLE: Circle = Circle { center: DVec3::ZERO, axis: DVec3::Z, x: DVec3::X, radius: 1.0 };

    /// An arc from `from` over `angle` (radians, may be negative) as a rational quadratic.
    fn arc(from: f64, angle: f64) -> NurbsCurve {
        let at = |t: f64| DVec3::new(t.cos(), t.sin(), 0.0);
        let w = (angle / 2.0).cos();
        NurbsCurve {
            degree: 2,
            knots: [0.0, 0.0, 0.0, 1.0, 1.0, 1.0].into(),
            points: vec![at(from), at(from + angle / 2.0) / w, at(from + angle)],
            weights: [1.0, w, 1.0].into(),
        }
    }

    /// Largest distance of the mapped border from the circle, sampled.
    fn worst(border: &NurbsCurve, map: &RimMap) -> f64 {
        let (d, knots) = (map.degree as usize, map.knots());
        let pieces = (map.us.len() - 1) / d;
        let sample = |k: usize, j: usize| {
            let (from, to) = (knots[d + k * d], knots[d + (k + 1) * d]);
            let x = j as f64 / 40.0;
            let u: f64 = basis(d, x)[0].iter().zip(&map.us[k * d..]).map(|(b, u)| b * u).sum();
            border.point(u).distance(CIRCLE.radial(from + x * (to - from)))
        };
        (0..pieces).flat_map(|k| (0..=40).map(move |j| sample(k, j))).fold(0.0, f64::max)
    }

    #[test]
    fn usual_arcs_need_one_polynomial() {
        for (degrees, most) in [(30.0f64, 5), (60.0, 7), (90.0, 9), (120.0, 11), (150.0, 13)] {
            let angle = degrees.to_radians();
            let border = arc(0.3, angle);
            let map = fit(&border, &CIRCLE, [0.3, 0.3 + angle], [0.0, 1.0]);
            assert!(map.degree == most && map.knots().len() == 2 * most as usize + 2, "{degrees}: {}", map.degree);
            assert!(worst(&border, &map) < 1e-8);
            assert_eq!((map.us[0], map.us[map.degree as usize]), (0.0, 1.0));
        }
    }

    #[test]
    fn borders_may_run_against_the_circle_and_over_its_start() {
        let border = arc(1.0, -1.5);
        let map = fit(&border, &CIRCLE, [TAU - 0.5, TAU + 1.0], [1.0, 0.0]);
        assert!(worst(&border, &map) < 1e-8);
    }

    #[test]
    fn half_a_border_is_mapped_where_a_seam_splits_it() {
        let border = arc(0.2, 1.6);
        let map = fit(&border, &CIRCLE, [0.9, 1.8], [0.0, 1.0]);
        assert!(worst(&border, &map) < 1e-8);
        assert!(map.us[0] > 0.3 && map.us[0] < 0.6);
    }

    #[test]
    fn almost_half_a_turn_takes_pieces() {
        let border = arc(0.1, 3.0);
        let map = fit(&border, &CIRCLE, [0.1, 3.1], [0.0, 1.0]);
        assert!(map.knots().len() > 2 * map.degree as usize + 2);
        assert!(worst(&border, &map) < 1e-8);
    }

    #[test]
    fn azimuths_are_ordered() {
        let [a, b] = azimuths(&CIRCLE, [DVec3::new(0.0, -1.0, 0.0), DVec3::X]);
        assert!((a - 1.5 * PI).abs() < 1e-15 && (b - TAU).abs() < 1e-15);
    }
}
