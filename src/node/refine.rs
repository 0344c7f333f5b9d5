//! Nodal soap film subdivision. Luo & Zou 2025, section 3.4: circle sampling on the rims (equation 6), Loop's rules
//! (equations 7-9) and the point-normal lift (equations 10 and 11; Yang 2023), with the normal configuration of
//! figure 11b.
//!
//! Differs from the paper in one point: the lift's terms divide by (n_j + n)·n, which vanishes where the walls of a
//! sharp crotch face each other. A neighbour whose normal is more than 60° from the new one gives no lift (`LEAST_COS`).

use crate::node::film::Control;
use crate::node::mesh::{Mesh, NONE, Rim, Triangles};
use crate::node::star::Star;
use glam::DVec3;

/// Least cosine between a neighbour's normal and the new normal for it to lift the new point. Measured on 64 random
/// nodes: 56 star-shaped with it, 53 without.
const LEAST_COS: f64 = 0.5;

/// Refine a faired control mesh `levels` times.
pub fn refine(control: Control, star: &Star, levels: u32) -> Mesh {
    let normals = initial_normals(&control);
    let twins = control.triangles.twins();
    let mut state = State { points: control.points, normals, triangles: control.triangles, twins, rims: control.rims };
    for _ in 0..levels {
        state = step(&state, star);
    }
    finish(state, star)
}

struct State {
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
    triangles: Triangles,
    twins: Vec<u32>,
    rims: Vec<Option<Rim>>,
}

/// Figure 11b: the struts' normals on rims and their 1-ring, elsewhere the mean of the unit normals of the facets.
fn initial_normals(control: &Control) -> Vec<DVec3> {
    let mean = facet_means(&control.points, &control.triangles, |_| 1.0);
    control.normals.iter().zip(mean).map(|(set, mean)| set.unwrap_or(mean)).collect()
}

/// Unit mean of the facet normals around each vertex, weighted by a function of the facet's area.
fn facet_means(points: &[DVec3], triangles: &Triangles, weight: impl Fn(f64) -> f64) -> Vec<DVec3> {
    let mut sum = vec![DVec3::ZERO; points.len()];
    for t in &triangles.0 {
        let [a, b, c] = t.map(|v| points[v as usize]);
        let cross = (b - a).cross(c - a);
        let area = 0.5 * cross.length();
        let n = cross.normalize_or_zero() * weight(area);
        t.iter().for_each(|&v| sum[v as usize] += n);
    }
    sum.iter().map(|n| n.normalize_or_zero()).collect()
}

/// β_n of equation 8.
fn beta(n: usize) -> f64 {
    let n = n as f64;
    (5.0 / 8.0 - (3.0 / 8.0 + 0.25 * (std::f64::consts::TAU / n).cos()).powi(2)) / n
}

/// One term of the lift: the height of the tangent-plane crossing of neighbour (v, n) above t along `normal`.
fn lift(v: DVec3, n: DVec3, t: DVec3, normal: DVec3) -> f64 {
    if n.dot(normal) < LEAST_COS {
        return 0.0;
    }
    let s = n + normal;
    s.dot(v - t) / s.dot(normal)
}

fn step(old: &State, star: &Star) -> State {
    let (nv, nf) = (old.points.len(), old.triangles.0.len());
    // number the edges: by the first of their half-edges
    let mut edge = vec![NONE; 3 * nf];
    let mut first = Vec::new();
    for h in 0..3 * nf {
        let twin = old.twins[h];
        if twin == NONE || (h as u32) < twin {
            edge[h] = first.len() as u32;
            first.push(h);
        } else {
            edge[h] = edge[twin as usize];
        }
    }
    let total = nv + first.len();
    let mut new = State {
        points: vec![DVec3::ZERO; total],
        normals: vec![DVec3::ZERO; total],
        triangles: Triangles(Vec::with_capacity(4 * nf)),
        twins: vec![NONE; 12 * nf],
        rims: vec![None; total],
    };
    vertex_points(old, &mut new);
    for (e, &h) in first.iter().enumerate() {
        edge_point(old, star, h, nv + e, &mut new);
    }
    for f in 0..nf {
        let t = old.triangles.0[f];
        let mid = [0, 1, 2].map(|k| nv as u32 + edge[3 * f + k]);
        for k in 0..3 {
            new.triangles.0.push([t[k], mid[k], mid[(k + 2) % 3]]);
        }
        new.triangles.0.push(mid);
        for k in 0..3 {
            let (corner, centre) = (3 * (4 * f + k) + 1, 3 * (4 * f + 3) + (k + 2) % 3);
            new.twins[corner] = centre as u32;
            new.twins[centre] = corner as u32;
            let twin = old.twins[3 * f + k];
            if twin != NONE {
                let (g, m) = (twin as usize / 3, twin as usize % 3);
                let (near, far) = (3 * (4 * f + k), 3 * (4 * g + (m + 1) % 3) + 2);
                new.twins[near] = far as u32;
                new.twins[far] = near as u32;
            }
        }
    }
    new
}

/// Equation 10; rim vertices stay.
fn vertex_points(old: &State, new: &mut State) {
    let nv = old.points.len();
    let mut valence = vec![0usize; nv];
    let mut sum = vec![DVec3::ZERO; nv];
    let mut normal_sum = vec![DVec3::ZERO; nv];
    for t in &old.triangles.0 {
        for k in 0..3 {
            let (a, b) = (t[k] as usize, t[(k + 1) % 3] as usize);
            valence[a] += 1;
            sum[a] += old.points[b];
            normal_sum[a] += old.normals[b];
        }
    }
    let mut height = vec![0.0; nv];
    for v in 0..nv {
        new.rims[v] = old.rims[v];
        let (p, n) = (old.points[v], old.normals[v]);
        if old.rims[v].is_some() {
            (new.points[v], new.normals[v]) = (p, n);
            continue;
        }
        let b = beta(valence[v]);
        let own = 1.0 - valence[v] as f64 * b;
        let t = own * p + b * sum[v];
        let normal = (own * n + b * normal_sum[v]).normalize();
        (new.points[v], new.normals[v]) = (t, normal);
        height[v] = own * lift(p, n, t, normal);
    }
    for t in &old.triangles.0 {
        for k in 0..3 {
            let (a, b) = (t[k] as usize, t[(k + 1) % 3] as usize);
            if old.rims[a].is_none() {
                height[a] += beta(valence[a]) * lift(old.points[b], old.normals[b], new.points[a], new.normals[a]);
            }
        }
    }
    for v in 0..nv {
        new.points[v] += height[v] * new.normals[v];
    }
}

/// Equation 11, and on rims equation 6.
fn edge_point(old: &State, star: &Star, h: usize, at: usize, new: &mut State) {
    let corner = |h: usize| old.triangles.0[h / 3][h % 3] as usize;
    let next = |h: usize| h - h % 3 + (h + 1) % 3;
    let (i, j) = (corner(h), corner(next(h)));
    if old.twins[h] == NONE {
        let rim = old.rims[i].expect("an edge without a twin lies on a rim");
        let arm = rim.arm as usize;
        // c((u_i + u_j) / 2): the middle of the arc between both ends
        let normal = (old.normals[i] + old.normals[j]).normalize();
        let (c, taper) = (star.axes[arm], star.tapers[arm]);
        let out = if taper == 0.0 { normal } else { normal.reject_from_normalized(c).normalize() };
        new.points[at] = star.cuts[arm] * c + star.rim_radius(arm) * out;
        new.normals[at] = star.normal(arm, out);
        new.rims[at] = Some(rim);
        return;
    }
    let (p, q) = (corner(next(next(h))), corner(next(next(old.twins[h] as usize))));
    let weights = [(i, 3.0 / 8.0), (j, 3.0 / 8.0), (p, 1.0 / 8.0), (q, 1.0 / 8.0)];
    let t: DVec3 = weights.iter().map(|&(v, w)| w * old.points[v]).sum();
    let normal = weights.iter().map(|&(v, w)| w * old.normals[v]).sum::<DVec3>().normalize();
    let height: f64 = weights.iter().map(|&(v, w)| w * lift(old.points[v], old.normals[v], t, normal)).sum();
    new.points[at] = t + height * normal;
    new.normals[at] = normal;
}

/// Normals of the refined surface: from its facets, and from the cylinder on the rims.
fn finish(state: State, star: &Star) -> Mesh {
    let mut normals = facet_means(&state.points, &state.triangles, |area| area);
    for (v, rim) in state.rims.iter().enumerate() {
        if let Some(rim) = rim {
            let arm = rim.arm as usize;
            normals[v] = star.normal(arm, (state.points[v] - star.cuts[arm] * star.axes[arm]).normalize());
        }
    }
    Mesh::new(state.points, normals, state.triangles, state.twins)
}
