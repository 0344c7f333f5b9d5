//! Film smoothing by a second-order Laplacian. Luo & Zou 2025, section 3.3.2, equation 2 applied twice.
//!
//! Three ways, and a fourth without it (`Fairing::Ball`). `Fairing::Paper`: `L² V = 0` at the free vertices with uniform weights, as printed; the vertices move in
//! space, and on most irregular nodes the result folds. `Fairing::Ray`: each free vertex keeps its ray
//! from the node, `V_i = t_i u_i`, and `Σ |(L V)_i|²`, with cotangent weights, is least over the t_i; a small term (`HOLD`)
//! keeps wide faces without struts from sinking far into the node. One unknown a vertex, one SPD system, and a control mesh that stays star-shaped as long as all t_i > 0, which is checked.
//! `Fairing::Filled` (default): the same from where a ball leaves the valleys (`rolling`), L too; the sharp creases of the struts' union make a poor L, whose
//! film ripples where the rows stop being fixed.

use crate::math::sparse::Symmetric;
use crate::node::Fairing;
use crate::node::film::Control;
use crate::node::rolling::{self, Rolling};
use crate::node::star::Star;
use faer::Mat;
use glam::DVec3;

/// How strongly a vertex is held where the original shape has it, in 1/r²: a vertex moved by r costs as much as a change of
/// its Laplacian by 2/r. Measured on 12 random nodes of degree 3 to 20: without it the worst (degree 4, all struts in a
/// half-space) loses 2.35 r³ of the union of its struts, at 2 it loses 1.1; the distance between patches and film is the same.
pub const HOLD: f64 = 2.0;

/// The ball of `Fairing::Filled`, node radii, and its hold. Measured on the nodes of `evaluate nodes` and of a tet lattice: balls of 0.1 to 0.2 and holds of 2 to
/// 64 lie on one curve of distance against fairness; with more ball or less hold the icosahedral node's Avg comes over a quarter of the paper's, or the
/// cuboctahedral node's Max over half of it (docs/decisions/0010-filled-films.md).
pub const FILL: f64 = 0.185;
pub const FILLED_HOLD: f64 = 24.0;

/// Fair a control mesh in place; only its free vertices move. `hold`: `HOLD`, or another for `Fairing::Ray`, where less is smoother.
pub fn fair(mesh: &mut Control, star: &Star, how: Fairing, hold: f64) -> Result<(), String> {
    let mut slot = vec![usize::MAX; mesh.points.len()];
    let mut count = 0;
    for (v, &free) in mesh.free.iter().enumerate() {
        if free {
            slot[v] = count;
            count += 1;
        }
    }
    if count == 0 {
        return Ok(());
    }
    match how {
        Fairing::Filled => {
            roll(mesh, star, FILL);
            let laplacian = cotangent(mesh);
            along_rays(mesh, &laplacian, &slot, count, FILLED_HOLD)
        }
        Fairing::Ray => {
            let laplacian = cotangent(mesh);
            along_rays(mesh, &laplacian, &slot, count, hold)
        }
        Fairing::Paper => {
            let laplacian = uniform(mesh);
            in_space(mesh, &laplacian, &slot, count)
        }
        Fairing::Ball(ball) => {
            roll(mesh, star, ball);
            Ok(())
        }
    }
}

/// All but the rims and their 1-ring to where the ball leaves them: the filling may begin before the rows that are free otherwise.
/// A smaller ball where cuts are too short.
fn roll(mesh: &mut Control, star: &Star, ball: f64) {
    let mut rolling = Rolling::new(star, ball.min(rolling::most(star)));
    let mut done = vec![false; mesh.points.len()];
    for &v in mesh.rows.iter().flat_map(|rows| rows[2..].iter().flatten()) {
        if !std::mem::replace(&mut done[v as usize], true) {
            let u = mesh.points[v as usize].normalize();
            mesh.points[v as usize] = rolling.distance(u) * u;
        }
    }
}

/// Rows of a Laplacian: (vertex, weight) with the vertex itself among them; empty for rim vertices.
type Rows = Vec<Vec<(usize, f64)>>;

/// `L = D⁻¹A - I`.
fn uniform(mesh: &Control) -> Rows {
    let mut near: Vec<Vec<usize>> = vec![Vec::new(); mesh.points.len()];
    for t in &mesh.triangles.0 {
        for k in 0..3 {
            let (a, b) = (t[k] as usize, t[(k + 1) % 3] as usize);
            near[a].push(b);
            near[b].push(a);
        }
    }
    near.iter_mut()
        .enumerate()
        .map(|(v, list)| {
            if mesh.rims[v].is_some() {
                return Vec::new();
            }
            list.sort_unstable();
            list.dedup();
            let w = 1.0 / list.len() as f64;
            list.iter().map(|&n| (n, w)).chain([(v, -1.0)]).collect()
        })
        .collect()
}

/// `L = M⁻¹ C`: cotangent weights over a third of the area of the triangles around.
fn cotangent(mesh: &Control) -> Rows {
    // four entries for each of a vertex's triangles, mostly six
    let mut rows: Rows = mesh.points.iter().map(|_| Vec::with_capacity(24)).collect();
    let mut area = vec![0.0; mesh.points.len()];
    for t in &mesh.triangles.0 {
        let [a, b, c] = t.map(|v| v as usize);
        let twice = (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).length().max(1e-300);
        for (i, j, k) in [(a, b, c), (b, c, a), (c, a, b)] {
            area[i] += twice / 6.0;
            let w = 0.5 * (mesh.points[i] - mesh.points[k]).dot(mesh.points[j] - mesh.points[k]) / twice;
            for (p, q) in [(i, j), (j, i)] {
                rows[p].push((q, w));
                rows[p].push((p, -w));
            }
        }
    }
    for (v, row) in rows.iter_mut().enumerate() {
        if mesh.rims[v].is_some() {
            row.clear();
            continue;
        }
        row.sort_by_key(|e| e.0);
        row.dedup_by(|b, a| {
            let same = a.0 == b.0;
            if same {
                a.1 += b.1;
            }
            same
        });
        row.iter_mut().for_each(|e| e.1 /= area[v]);
    }
    rows
}

/// min over t of Σ_i |(L V)_i|² + hold² (t_i - |V_i|)², V_i = t_i u_i at free vertices.
fn along_rays(mesh: &mut Control, rows: &Rows, slot: &[usize], count: usize, hold: f64) -> Result<(), String> {
    let mut matrix = Symmetric::with_capacity(count + rows.iter().map(|row| row.len() * (row.len() + 1) / 2).sum::<usize>());
    let mut rhs = Mat::<f64>::zeros(count, 1);
    let unit: Vec<DVec3> = mesh.points.iter().map(|p| p.normalize()).collect();
    for row in rows {
        let fixed: DVec3 = row.iter().filter(|e| slot[e.0] == usize::MAX).map(|&(v, w)| w * mesh.points[v]).sum();
        for &(p, wp) in row.iter().filter(|e| slot[e.0] != usize::MAX) {
            rhs[(slot[p], 0)] -= wp * unit[p].dot(fixed);
            // one half: the other is its mirror image, and `slot` is largest where nothing is free
            for &(q, wq) in row.iter().filter(|e| slot[e.0] <= slot[p]) {
                matrix.add(slot[p], slot[q], wp * wq * unit[p].dot(unit[q]));
            }
        }
    }
    for v in (0..slot.len()).filter(|&v| slot[v] != usize::MAX) {
        matrix.add(slot[v], slot[v], hold * hold);
        rhs[(slot[v], 0)] += hold * hold * mesh.points[v].length();
    }
    let t = matrix.solve(count, rhs)?;
    for v in (0..slot.len()).filter(|&v| slot[v] != usize::MAX) {
        let t = t[(slot[v], 0)];
        if t.is_nan() || t <= 0.0 {
            return Err("fairing pulled a film vertex through the node".into());
        }
        mesh.points[v] = t * unit[v];
    }
    Ok(())
}

/// Least squares of `L² V = 0` at the free vertices, each coordinate by itself.
fn in_space(mesh: &mut Control, rows: &Rows, slot: &[usize], count: usize) -> Result<(), String> {
    let mut matrix = Symmetric::default();
    let mut rhs = Mat::<f64>::zeros(count, 3);
    for v in (0..slot.len()).filter(|&v| slot[v] != usize::MAX) {
        // row v of L²
        let mut square: Vec<(usize, f64)> = rows[v].iter().flat_map(|&(n, w)| rows[n].iter().map(move |&(m, x)| (m, w * x))).collect();
        square.sort_by_key(|e| e.0);
        let fixed: DVec3 = square.iter().filter(|e| slot[e.0] == usize::MAX).map(|&(m, w)| w * mesh.points[m]).sum();
        for &(p, wp) in square.iter().filter(|e| slot[e.0] != usize::MAX) {
            for (axis, f) in fixed.to_array().into_iter().enumerate() {
                rhs[(slot[p], axis)] -= wp * f;
            }
            for &(q, wq) in square.iter().filter(|e| slot[e.0] != usize::MAX) {
                matrix.add(slot[p], slot[q], wp * wq);
            }
        }
    }
    let x = matrix.solve(count, rhs)?;
    for v in (0..slot.len()).filter(|&v| slot[v] != usize::MAX) {
        mesh.points[v] = DVec3::new(x[(slot[v], 0)], x[(slot[v], 1)], x[(slot[v], 2)]);
    }
    Ok(())
}
