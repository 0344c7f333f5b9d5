//! Fairing: what must not move, what must shrink, and that nothing folds.

mod common;

use common::*;
use glam::DVec3;
use lattice_brep::node::fair::{FILL, FILLED_HOLD, HOLD, fair};
use lattice_brep::node::film::{Control, control_mesh};
use lattice_brep::node::{Cells, Fairing};
use std::collections::BTreeMap;

fn faired(name: &str, axes: Vec<DVec3>, how: Fairing) -> (Control, Control) {
    let star = star(axes);
    let before = control_mesh(&star, &Cells::new(&star).unwrap());
    let mut after = before.clone();
    fair(&mut after, &star, how, HOLD).unwrap_or_else(|e| panic!("{name}: {e}"));
    (before, after)
}

/// Rows of a Laplacian, written down here once more; none for rim vertices.
type Rows = Vec<BTreeMap<usize, f64>>;

/// `(L V)_i = 1/A_i Σ_j ½ (cot α_ij + cot β_ij) (V_j - V_i)`, A a third of the area around.
fn cotangent(mesh: &Control) -> Rows {
    let mut rows = vec![BTreeMap::new(); mesh.points.len()];
    let mut area = vec![0.0; mesh.points.len()];
    for t in &mesh.triangles.0 {
        for k in 0..3 {
            let [i, j, o] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]].map(|v| v as usize);
            let (a, b) = (mesh.points[i] - mesh.points[o], mesh.points[j] - mesh.points[o]);
            let half_cot = 0.5 / a.angle_between(b).tan();
            area[i] += 0.5 * a.cross(b).length() / 3.0;
            for (p, q) in [(i, j), (j, i)] {
                *rows[p].entry(q).or_insert(0.0) += half_cot;
                *rows[p].entry(p).or_insert(0.0) -= half_cot;
            }
        }
    }
    for (v, row) in rows.iter_mut().enumerate() {
        row.values_mut().for_each(|w| *w /= area[v]);
        if mesh.rims[v].is_some() {
            row.clear();
        }
    }
    rows
}

/// `L = D⁻¹A - I`.
fn uniform(mesh: &Control) -> Rows {
    let mut rows: Rows = vec![BTreeMap::new(); mesh.points.len()];
    for t in &mesh.triangles.0 {
        for k in 0..3 {
            let v = t[k] as usize;
            if mesh.rims[v].is_none() {
                rows[v].insert(t[(k + 1) % 3] as usize, 1.0);
                rows[v].insert(t[(k + 2) % 3] as usize, 1.0);
            }
        }
    }
    for (v, row) in rows.iter_mut().enumerate().filter(|(_, row)| !row.is_empty()) {
        let n = row.len() as f64;
        row.values_mut().for_each(|w| *w /= n);
        row.insert(v, -1.0);
    }
    rows
}

fn apply(rows: &Rows, points: &[DVec3]) -> Vec<DVec3> {
    rows.iter().map(|row| row.iter().map(|(&v, &w)| w * points[v]).sum()).collect()
}

fn energy(rows: &Rows, points: &[DVec3]) -> f64 {
    apply(rows, points).iter().map(|l| l.length_squared()).sum()
}

#[test]
fn rows_that_are_fixed_do_not_move() {
    for how in [Fairing::Ray, Fairing::Paper] {
        for (name, axes) in catalogue() {
            let (before, after) = faired(name, axes, how);
            let mut moved = 0;
            for (v, (a, b)) in before.points.iter().zip(&after.points).enumerate() {
                if before.free[v] {
                    moved += usize::from(a.distance(*b) > 1e-3);
                } else {
                    assert_eq!(a, b, "{name}, {how:?}: fixed vertex {v}");
                }
            }
            // a straight node is a cylinder already; the paper's fairing pulls it in
            assert_eq!(moved > 0, name != "straight" || how == Fairing::Paper, "{name}, {how:?}: {moved} moved");
        }
    }
}

#[test]
fn ray_fairing_keeps_each_vertex_on_its_ray() {
    for ((name, axes), how) in all_nodes().flat_map(|node| [(node.clone(), Fairing::Ray), (node, Fairing::Filled)]) {
        let (before, after) = faired(&name, axes, how);
        for (a, b) in before.points.iter().zip(&after.points) {
            assert!(a.normalize().distance(b.normalize()) < 1e-12, "{name}: {a} went to {b}");
        }
    }
}

/// A ball fills valleys and moves nothing else: the rim and its 1-ring stay, and so does a straight strut. From there the fairing is the minimum.
#[test]
fn valleys_are_filled_then_faired() {
    for (name, axes) in catalogue() {
        let (before, rolled) = faired(name, axes.clone(), Fairing::Ball(FILL));
        let (_, after) = faired(name, axes, Fairing::Filled);
        let row = |k: usize| before.rows.iter().flat_map(move |rows| rows[k].iter().map(|&v| v as usize));
        assert!(row(0).chain(row(1)).all(|v| after.points[v] == before.points[v]), "{name}");
        assert!(row(2).all(|v| after.points[v] == rolled.points[v]), "{name}");
        let rows = cotangent(&rolled);
        let held: f64 = after.points.iter().zip(&rolled.points).map(|(a, b)| (FILLED_HOLD * (a.length() - b.length())).powi(2)).sum();
        let (high, low) = (energy(&rows, &rolled.points), energy(&rows, &after.points) + held);
        assert!(low <= high * (1.0 + 1e-9) && (name == "straight" || low < 0.97 * high), "{name}: {high} to {low}");
    }
}

/// The result is the minimum: lower than before, and no vertex can lower it further.
#[test]
fn ray_fairing_minimises_the_bending_energy() {
    for (name, axes) in catalogue() {
        let (before, after) = faired(name, axes, Fairing::Ray);
        let rows = cotangent(&before);
        // the term that holds vertices where they were is 0 before
        let held = |v: usize| HOLD * (after.points[v].length() - before.points[v].length());
        let away: f64 = (0..rows.len()).filter(|&v| after.free[v]).map(|v| held(v).powi(2)).sum();
        let (high, low) = (energy(&rows, &before.points), energy(&rows, &after.points) + away);
        if name == "straight" {
            assert!(low < high * (1.0 + 1e-9), "{name}: {high} to {low}");
        } else {
            assert!(low < 0.95 * high, "{name}: {high} to {low}");
        }
        let residual = apply(&rows, &after.points);
        let mut slope = vec![DVec3::ZERO; rows.len()];
        let mut size = vec![0.0; rows.len()];
        for (row, r) in rows.iter().zip(&residual) {
            for (&v, &w) in row {
                slope[v] += w * *r;
                size[v] += w.abs() * r.length();
            }
        }
        for v in (0..rows.len()).filter(|&v| after.free[v]) {
            let off = slope[v].dot(after.points[v].normalize()) + HOLD * held(v);
            assert!(off.abs() < 1e-6 * (size[v] + (HOLD * held(v)).abs()).max(1e-3), "{name}: vertex {v} is not at its minimum, {off}");
        }
    }
}

#[test]
fn ray_fairing_leaves_no_folded_facet() {
    for ((name, axes), how) in all_nodes().flat_map(|node| [(node.clone(), Fairing::Ray), (node, Fairing::Filled)]) {
        let (_, after) = faired(&name, axes, how);
        let folded = after.triangles.0.iter().filter(|t| {
            let [a, b, c] = t.map(|v| after.points[v as usize]);
            a.dot(b.cross(c)) <= 0.0
        });
        assert_eq!(folded.count(), 0, "{name}");
    }
}

#[test]
fn the_paper_s_fairing_solves_its_equation() {
    for (name, axes) in [("octahedron", octahedron()), ("bcc", bcc()), ("tetrahedron", tetrahedron()), ("random", random(1, 6, 35.0))] {
        let (before, after) = faired(name, axes, Fairing::Paper);
        let rows = uniform(&before);
        let twice = apply(&rows, &apply(&rows, &after.points));
        for v in (0..twice.len()).filter(|&v| after.free[v]) {
            assert!(twice[v].length() < 1e-9, "{name}: vertex {v}, {}", twice[v]);
        }
    }
}
