//! From the fitted gauges to the skin: control points, shared borders, and which edge borders which patch.

use crate::math::nurbs::{NurbsCurve, NurbsSurface};
use crate::patch::fit::Fit;
use crate::patch::forms::Tables;
use crate::patch::layout::Layout;
use crate::patch::map::{self, SectorMap};
use crate::patch::{Patch, Rim, Skin, SkinCurve, SkinEdge};
use glam::DVec3;
use std::sync::Arc;

/// Most that weights may change from one control point to the next, as a factor. Reason: where they fall like a needle the surface folds its
/// parameters on a spot, and readers lose the patch. Measured on shrunk real lattices, 10,000 patches: OCC 8 finds five invalid, of factors 37 to
/// 135; of those it finds valid, two reach 50 and all others stay below 24.
const MOST_STEP: f64 = 25.0;

/// How unevenly the weights of a fit run: the largest factor by which a weight is off the geometric mean of its two neighbours in a row or column, squared.
pub fn bend(tables: &Tables, fit: &Fit) -> f64 {
    let n = tables.q + 1;
    let of_sector = |w: &Vec<f64>| {
        let logs: Vec<f64> = w.iter().map(|w| w.ln()).collect();
        let across = |k: usize| if k % n + 2 < n { logs[k] - 2.0 * logs[k + 1] + logs[k + 2] } else { 0.0 };
        let along = |k: usize| if k + 2 * n < logs.len() { logs[k] - 2.0 * logs[k + n] + logs[k + 2 * n] } else { 0.0 };
        (0..logs.len()).map(|k| across(k).abs().max(along(k).abs())).fold(0.0, f64::max)
    };
    fit.sectors.iter().map(of_sector).fold(0.0, f64::max).exp()
}

/// Build the skin. Border rows are computed once per edge and copied into both patches, so that shared points are equal
/// to the bit. Fails where a weight is not positive, or far from its neighbour's.
pub fn skin(tables: &Tables, layout: &Layout, fit: &Fit) -> Result<Skin, String> {
    let (p, q) = (tables.p, tables.q);
    let clamped = |p: usize| -> Arc<[f64]> { std::iter::repeat_n(0.0, p + 1).chain(std::iter::repeat_n(1.0, p + 1)).collect() };
    let knots = [clamped(p), clamped(q)];
    if !(fit.sectors.iter().all(|w| is_even(w, q + 1)) && fit.creases.iter().chain(&fit.radials).all(|w| is_even(w, w.len()))) {
        return Err("the skin has a weight that is not positive, or far from its neighbour's".into());
    }
    let divide = |y: Vec<DVec3>, w: &[f64]| -> Vec<DVec3> { y.into_iter().zip(w).map(|(y, w)| y / *w).collect() };

    // vertices: the corners, then the rim end of each radial
    let (nc, nk, nr) = (layout.corners.len(), layout.creases.len(), layout.radials.len());
    let mut vertices: Vec<DVec3> = layout.corners.iter().zip(&fit.corners).map(|(c, g)| c.k / *g).collect();
    vertices.extend(layout.radials.iter().map(|r| (r.cut * r.c + r.e) / r.own(r.cut)));

    // edges: creases, radials, then one rim arc per sector
    let mut edges = Vec::with_capacity(nk + nr + 2 * nk);
    for (k, crease) in layout.creases.iter().enumerate() {
        let map = SectorMap::new(layout, 2 * k);
        let y: Vec<DVec3> = tables.interpolation.nodes.iter().map(|&s| map.crease(s)[0]).collect();
        let mut points = divide(tables.interpolation.coefficients(&y), &fit.creases[k]);
        (points[0], points[p]) = (vertices[crease.corners[0]], vertices[crease.corners[1]]);
        let curve = NurbsCurve { degree: p, knots: knots[0].clone(), points, weights: fit.creases[k][..].into() };
        edges.push(SkinEdge { ends: crease.corners, curve: SkinCurve::Spline(curve) });
    }
    for (k, radial) in layout.radials.iter().enumerate() {
        let y: Vec<DVec3> = tables.columns.nodes.iter().map(|&v| map::radial(radial, layout.corners[radial.corner].k, v)).collect();
        let mut points = divide(tables.columns.coefficients(&y), &fit.radials[k]);
        (points[0], points[q]) = (vertices[nc + k], vertices[radial.corner]);
        let curve = NurbsCurve { degree: q, knots: knots[1].clone(), points, weights: fit.radials[k][..].into() };
        edges.push(SkinEdge { ends: [nc + k, radial.corner], curve: SkinCurve::Spline(curve) });
    }
    let mut patches = Vec::with_capacity(layout.sectors.len());
    for (index, sector) in layout.sectors.iter().enumerate() {
        // counter-clockwise about the axis: along s on the first strut, against it on the second
        let ccw = if sector.which == 0 { sector.radials } else { [sector.radials[1], sector.radials[0]] };
        edges.push(SkinEdge { ends: ccw.map(|r| nc + r), curve: SkinCurve::RimArc(sector.arm) });
        let surface = surface(tables, layout, fit, index, &edges, &knots);
        // u runs clockwise about the axis, so that du × dv points out
        let boundary = [(nk + nr + index, false), (nk + ccw[0], true), (sector.crease, sector.which == 0), (nk + ccw[1], false)];
        patches.push(Patch { surface, boundary, arm: sector.arm });
    }
    let rims = layout
        .around
        .iter()
        .map(|ring| {
            let radial = &layout.radials[layout.sectors[ring[0]].radials[0]];
            let radius = 1.0 / radial.own(radial.cut);
            Rim { axis: radial.c, cut: radial.cut * radius, radius, taper: radial.taper, arcs: ring.iter().map(|&s| nk + nr + s).collect() }
        })
        .collect();
    Ok(Skin { vertices, edges, patches, rims })
}

/// Whether weights, in rows of `width`, are positive and near those next to them.
fn is_even(w: &[f64], width: usize) -> bool {
    let near = |a: f64, b: f64| a <= MOST_STEP * b && b <= MOST_STEP * a;
    let along = |k: usize| (k + 1) % width == 0 || near(w[k], w[k + 1]);
    let across = |k: usize| k + width >= w.len() || near(w[k], w[k + width]);
    (0..w.len()).all(|k| w[k] > 0.0 && along(k) && across(k))
}

/// The patch of one sector, with the borders of its edges.
fn surface(tables: &Tables, layout: &Layout, fit: &Fit, index: usize, edges: &[SkinEdge], knots: &[Arc<[f64]>; 2]) -> NurbsSurface {
    let (p, n) = (tables.p, tables.q + 1);
    let sector = &layout.sectors[index];
    let map = SectorMap::new(layout, index);
    let mut weights = fit.sectors[index].clone();
    // coefficients of Y: first along v, then along s
    let [along, across] = &tables.map;
    let columns: Vec<Vec<DVec3>> = map.ys(&along.nodes, &across.nodes).chunks_exact(across.nodes.len()).map(|y| across.coefficients(y)).collect();
    let mut points = vec![DVec3::ZERO; (p + 1) * n];
    for iv in 0..n {
        let row: Vec<DVec3> = columns.iter().map(|c| c[iv]).collect();
        for (is, y) in along.coefficients(&row).into_iter().enumerate() {
            points[is * n + iv] = y / weights[is * n + iv];
        }
    }
    let spline = |edge: usize| match &edges[edge].curve {
        SkinCurve::Spline(c) => c,
        SkinCurve::RimArc(_) => unreachable!("creases and radials are splines"),
    };
    // Where corners were joined, the rim's ends have another w2 than the crease's. A geometric progression of weights along
    // a row changes its parameter, not its shape: the rim stays the circle, and all four borders share their corners' weights.
    let ratio = map.rim_ratio();
    for is in 0..=p {
        let f = is as f64 / p as f64;
        let factor = ratio[0].powf(1.0 - f) * ratio[1].powf(f);
        weights[is * n] *= factor;
        weights[is * n + 1] *= factor;
    }
    let nk = layout.creases.len();
    let crease = spline(sector.crease);
    for is in 0..=p {
        points[is * n + n - 1] = crease.points[is];
        weights[is * n + n - 1] = crease.weights[is];
    }
    for end in 0..2 {
        let radial = spline(nk + sector.radials[end]);
        let scale = map.scale_of_ends()[end];
        for iv in 0..n {
            points[end * p * n + iv] = radial.points[iv];
            weights[end * p * n + iv] = scale * radial.weights[iv];
        }
    }
    if sector.which == 0 {
        for is in 0..(p + 1) / 2 {
            for iv in 0..n {
                points.swap(is * n + iv, (p - is) * n + iv);
                weights.swap(is * n + iv, (p - is) * n + iv);
            }
        }
    }
    NurbsSurface { degree: [p, tables.q], knots: knots.clone(), points, weights: weights.into() }
}
