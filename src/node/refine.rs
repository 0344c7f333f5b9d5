//! Nodal soap film subdivision. Luo & Zou 2025, section 3.4: circle sampling on the rims (equation 6), Loop's rules
//! (equations 7-9) and the point-normal lift (equations 10 and 11; Yang 2023), with the normal configuration of
//! figure 11b.
//!
//! Differs from the paper in one point: the lift's terms divide by (n_j + n)·n, which vanishes where the walls of a
//! sharp crotch face each other. A neighbour whose normal is more than 60° from the new one gives no lift (`LEAST_COS`).

use crate::math::{Loops, vectorised};
use crate::node::film::Control;
use crate::node::mesh::{Facets, Mesh, NONE, Rim, Triangles};
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
    let mut coarse = Vec::with_capacity(levels as usize);
    for _ in 0..levels {
        let finer = vectorised(Step { old: &state, star });
        coarse.push(Facets { triangles: state.triangles, twins: state.twins });
        state = finer;
    }
    finish(state, star, coarse)
}

struct State {
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
    triangles: Triangles,
    twins: Vec<u32>,
    rims: Vec<Option<Rim>>,
}

/// One level of refinement.
struct Step<'a> {
    old: &'a State,
    star: &'a Star,
}

impl Loops for Step<'_> {
    type Output = State;

    #[inline(always)]
    fn run(self) -> State {
        step(self.old, self.star)
    }
}

/// Figure 11b: the struts' normals on rims and their 1-ring, elsewhere the mean of the unit normals of the facets.
fn initial_normals(control: &Control) -> Vec<DVec3> {
    let mean = facet_means(&control.points, &control.triangles, |_, cross| cross.normalize_or_zero());
    control.normals.iter().zip(mean).map(|(set, mean)| set.unwrap_or(mean)).collect()
}

/// Unit mean around each vertex of a function of the facets: of a corner, and of the normal that is twice its area long.
fn facet_means(points: &[DVec3], triangles: &Triangles, mut share: impl FnMut(DVec3, DVec3) -> DVec3) -> Vec<DVec3> {
    let mut sum = vec![DVec3::ZERO; points.len()];
    for &[i, j, k] in &triangles.0 {
        let [a, b, c] = [points[i as usize], points[j as usize], points[k as usize]];
        let n = share(a, (b - a).cross(c - a));
        sum[i as usize] += n;
        sum[j as usize] += n;
        sum[k as usize] += n;
    }
    sum.iter_mut().for_each(|n| *n = n.normalize_or_zero());
    sum
}

/// β_n of equation 8.
fn beta(n: usize) -> f64 {
    let n = n as f64;
    (5.0 / 8.0 - (3.0 / 8.0 + 0.25 * (std::f64::consts::TAU / n).cos()).powi(2)) / n
}

/// One term of the lift: the height of the tangent-plane crossing of neighbour (v, n) above t along unit `normal`.
#[inline(always)]
fn lift(v: DVec3, n: DVec3, t: DVec3, normal: DVec3) -> f64 {
    let cos = n.dot(normal);
    if cos < LEAST_COS {
        return 0.0;
    }
    (n + normal).dot(v - t) / (1.0 + cos)
}

/// One level. Triangle f becomes 4 f + k at its vertices k, and 4 f + 3 in the middle; vertices keep their numbers, those
/// of the edges follow.
#[inline(always)]
fn step(old: &State, star: &Star) -> State {
    let (nv, nf) = (old.points.len(), old.triangles.0.len());
    let rim_edges = old.twins.iter().filter(|&&t| t == NONE).count();
    let total = nv + (3 * nf + rim_edges) / 2;
    let mut new = State {
        points: Vec::with_capacity(total),
        normals: Vec::with_capacity(total),
        triangles: Triangles(Vec::with_capacity(4 * nf)),
        twins: Vec::with_capacity(12 * nf),
        rims: Vec::with_capacity(total),
    };
    vertex_points(old, &mut new);
    // vertex on each edge; an edge is met first at the lower of its half-edges
    let mut middle = vec![NONE; 3 * nf];
    for f in 0..nf {
        for k in 0..3 {
            let h = 3 * f + k;
            let twin = old.twins[h];
            middle[h] = if twin == NONE || h < twin as usize {
                edge_point(old, star, f, k, &mut new);
                new.points.len() as u32 - 1
            } else {
                middle[twin as usize]
            };
        }
    }
    for (f, &[a, b, c]) in old.triangles.0.iter().enumerate() {
        let (ab, bc, ca) = (middle[3 * f], middle[3 * f + 1], middle[3 * f + 2]);
        new.triangles.0.extend_from_slice(&[[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        // the half-edges across the first and the second half of edge k
        let across = |k: usize| match old.twins[3 * f + k] {
            NONE => [NONE; 2],
            twin => {
                let (g, m) = (twin / 3, twin % 3);
                [3 * (4 * g + (m + 1) % 3) + 2, 3 * (4 * g + m)]
            }
        };
        let ([a0, a1], [b0, b1], [c0, c1]) = (across(0), across(1), across(2));
        // first half-edge of part k
        let at = |k: u32| 3 * (4 * f as u32 + k);
        let m = at(3);
        new.twins.extend_from_slice(&[a0, m + 2, c1, b0, m, a1, c0, m + 1, b1, at(1) + 1, at(2) + 1, at(0) + 1]);
    }
    new
}

/// Equation 10; rim vertices stay.
#[inline(always)]
fn vertex_points(old: &State, new: &mut State) {
    let nv = old.points.len();
    let mut valence = vec![0u32; nv];
    let mut sums = vec![[DVec3::ZERO; 2]; nv];
    for t in &old.triangles.0 {
        for k in 0..3 {
            let (a, b) = (t[k] as usize, t[(k + 1) % 3] as usize);
            valence[a] += 1;
            sums[a][0] += old.points[b];
            sums[a][1] += old.normals[b];
        }
    }
    let most = valence.iter().copied().max().unwrap_or(0);
    let betas: Vec<f64> = (0..=most as usize).map(beta).collect();
    let mut height = vec![0.0; nv];
    for v in 0..nv {
        let (p, n) = (old.points[v], old.normals[v]);
        let (mut t, mut normal) = (p, n);
        if old.rims[v].is_none() {
            let b = betas[valence[v] as usize];
            let own = 1.0 - valence[v] as f64 * b;
            t = own * p + b * sums[v][0];
            normal = (own * n + b * sums[v][1]).normalize();
            height[v] = own * lift(p, n, t, normal);
        }
        new.points.push(t);
        new.normals.push(normal);
        new.rims.push(old.rims[v]);
    }
    for t in &old.triangles.0 {
        for k in 0..3 {
            let (a, b) = (t[k] as usize, t[(k + 1) % 3] as usize);
            if old.rims[a].is_none() {
                height[a] += betas[valence[a] as usize] * lift(old.points[b], old.normals[b], new.points[a], new.normals[a]);
            }
        }
    }
    for v in (0..nv).filter(|&v| old.rims[v].is_none()) {
        new.points[v] += height[v] * new.normals[v];
    }
}

/// Equation 11 on edge k of facet f, and on rims equation 6.
#[inline(always)]
fn edge_point(old: &State, star: &Star, f: usize, k: usize, new: &mut State) {
    let corner = |f: usize, k: usize| old.triangles.0[f][k % 3] as usize;
    let (i, j) = (corner(f, k), corner(f, k + 1));
    let twin = old.twins[3 * f + k];
    if twin == NONE {
        let rim = old.rims[i].expect("an edge without a twin lies on a rim");
        let arm = rim.arm as usize;
        // c((u_i + u_j) / 2): the middle of the arc between both ends
        let normal = (old.normals[i] + old.normals[j]).normalize();
        let (c, taper) = (star.axes[arm], star.tapers[arm]);
        let out = if taper == 0.0 { normal } else { normal.reject_from_normalized(c).normalize() };
        new.points.push(star.cuts[arm] * c + star.rim_radius(arm) * out);
        new.normals.push(star.normal(arm, out));
        new.rims.push(Some(rim));
        return;
    }
    let (p, q) = (corner(f, k + 2), corner(twin as usize / 3, twin as usize % 3 + 2));
    let (points, normals) = (&old.points, &old.normals);
    let t = 0.375 * (points[i] + points[j]) + 0.125 * (points[p] + points[q]);
    let normal = (0.375 * (normals[i] + normals[j]) + 0.125 * (normals[p] + normals[q])).normalize();
    let height = |v: usize| lift(points[v], normals[v], t, normal);
    let height = 0.375 * (height(i) + height(j)) + 0.125 * (height(p) + height(q));
    new.points.push(t + height * normal);
    new.normals.push(normal);
    new.rims.push(None);
}

/// Normals of the refined surface: from its facets, by their areas, and from the cylinder on the rims.
fn finish(state: State, star: &Star, coarse: Vec<Facets>) -> Mesh {
    let (mut facet, mut inward) = (0, Vec::new());
    let mut normals = facet_means(&state.points, &state.triangles, |corner, cross| {
        if !(corner.dot(cross) > 0.0) {
            inward.push(facet);
        }
        facet += 1;
        cross
    });
    for (v, rim) in state.rims.iter().enumerate() {
        if let Some(rim) = rim {
            let arm = rim.arm as usize;
            normals[v] = star.normal(arm, (state.points[v] - star.cuts[arm] * star.axes[arm]).normalize());
        }
    }
    Mesh::new(state.points, normals, Facets { triangles: state.triangles, twins: state.twins }, coarse, &inward)
}
