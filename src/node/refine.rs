//! Nodal soap film subdivision. Luo & Zou 2025, section 3.4: circle sampling on the rims (equation 6), Loop's rules
//! (equations 7-9) and the point-normal lift (equations 10 and 11; Yang 2023), with the normal configuration of
//! figure 11b.
//!
//! Differs from the paper in one point: the lift's terms divide by (n_j + n)·n, which vanishes where the walls of a
//! sharp crotch face each other. A neighbour whose normal is more than 60° from the new one gives no lift (`LEAST_COS`).
//!
//! Nearly all vertices have valence 6 and lie in the grids of `sleeve`: their rules run over whole rows. The vertices of a cell
//! side are computed in both its sleeves, from the same terms paired the same way, so both get the same bits.

use crate::math::wide::{Wide, Wide3};
use crate::node::film::Control;
use crate::node::mesh::{Facet, Mesh};
use crate::node::sleeve::{Place, Seams, Sleeve};
use crate::node::star::Star;
use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

/// Least cosine between a neighbour's normal and the new normal for it to lift the new point. Measured on 64 random
/// nodes: 56 star-shaped with it, 53 without.
const LEAST_COS: f64 = 0.5;

/// Refine a faired control mesh `levels` times.
pub fn refine(control: &Control, star: &Star, levels: u32) -> Mesh {
    let seams = Seams::new(control);
    let mut sleeves = first_sleeves(control);
    for level in 0..levels {
        seams.reach_over(&mut sleeves, level);
        let mut finer: Vec<Sleeve> = sleeves.iter().enumerate().map(|(arm, old)| finer_sleeve(old, star, arm)).collect();
        // whole rows took all vertices for regular
        for places in seams.meets.iter().filter(|places| places.len() != 2) {
            let (p, n) = corner_point(&sleeves, places, level);
            for place in places {
                let sleeve = &mut finer[place.arm];
                sleeve.set(sleeve.layers, place.column << (level + 1), p, n);
            }
        }
        for sleeve in &mut finer {
            (0..=sleeve.layers).for_each(|row| sleeve.close(row));
        }
        sleeves = finer;
    }
    let inward = normals(&mut sleeves, &seams, star, levels);
    Mesh::new(sleeves, seams, levels, &inward)
}

/// The control mesh, with the normals of figure 11b: the struts' on rims and their 1-ring, elsewhere the mean of the unit normals of the
/// facets.
fn first_sleeves(control: &Control) -> Vec<Sleeve> {
    let mut mean = vec![DVec3::ZERO; control.points.len()];
    for t in &control.triangles.0 {
        let [a, b, c] = t.map(|v| control.points[v as usize]);
        let n = (b - a).cross(c - a).normalize_or_zero();
        t.iter().for_each(|&v| mean[v as usize] += n);
    }
    let sleeve = |rows: &Vec<Vec<u32>>| {
        let mut sleeve = Sleeve::new(rows[0].len(), rows.len() - 1);
        for (row, vertices) in rows.iter().enumerate() {
            for (column, &v) in vertices.iter().enumerate() {
                let v = v as usize;
                sleeve.set(row, column, control.points[v], control.normals[v].unwrap_or_else(|| mean[v].normalize_or_zero()));
            }
            sleeve.close(row);
        }
        sleeve
    };
    control.rows.iter().map(sleeve).collect()
}

/// β_n of equation 8.
fn beta(n: usize) -> f64 {
    let n = n as f64;
    (5.0 / 8.0 - (3.0 / 8.0 + 0.25 * (std::f64::consts::TAU / n).cos()).powi(2)) / n
}

/// Vertices of a row and their normals.
type Vertices<S> = [Wide3<S>; 2];

/// Those from column `at` - 1 on. All that runs over rows is written without closures: they would not be inlined.
#[inline(always)]
fn load<S: Simd>(simd: S, row: &[&[f64]; 6], at: usize) -> Vertices<S> {
    let [x, y, z, nx, ny, nz] = row;
    [Wide3::load(simd, [x, y, z], at), Wide3::load(simd, [nx, ny, nz], at)]
}

/// One term of the lift: the height of the tangent-plane crossing of neighbour (v, n) above t along unit `normal`.
#[inline(always)]
fn lift<S: Simd>([v, n]: Vertices<S>, t: Wide3<S>, normal: Wide3<S>) -> Wide<S> {
    let cos = n.dot(normal);
    ((n + normal).dot(v - t) / (cos + 1.0)).where_at_least(cos, LEAST_COS)
}

/// Equation 10 at vertices `v` of valence 6, from their neighbours in opposite pairs.
#[inline(always)]
fn vertex_point<S: Simd>(v: Vertices<S>, [a, b, c]: [[Vertices<S>; 2]; 3], beta: f64) -> Vertices<S> {
    let own = 1.0 - 6.0 * beta;
    let t = v[0] * own + ((a[0][0] + a[1][0]) + (b[0][0] + b[1][0]) + (c[0][0] + c[1][0])) * beta;
    let normal = (v[1] * own + ((a[0][1] + a[1][1]) + (b[0][1] + b[1][1]) + (c[0][1] + c[1][1])) * beta).normalize_or_zero();
    let lifts = lift2(a, t, normal) + lift2(b, t, normal) + lift2(c, t, normal);
    [t + normal * (lift(v, t, normal) * own + lifts * beta), normal]
}

/// Equation 11 on edges between the vertices `ends`, with `wings` across.
#[inline(always)]
fn edge_point<S: Simd>(ends: [Vertices<S>; 2], wings: [Vertices<S>; 2]) -> Vertices<S> {
    let t = (ends[0][0] + ends[1][0]) * 0.375 + (wings[0][0] + wings[1][0]) * 0.125;
    let normal = ((ends[0][1] + ends[1][1]) * 0.375 + (wings[0][1] + wings[1][1]) * 0.125).normalize_or_zero();
    let height = lift2(ends, t, normal) * 0.375 + lift2(wings, t, normal) * 0.125;
    [t + normal * height, normal]
}

/// Both lifts of a pair.
#[inline(always)]
fn lift2<S: Simd>([a, b]: [Vertices<S>; 2], t: Wide3<S>, normal: Wide3<S>) -> Wide<S> {
    lift(a, t, normal) + lift(b, t, normal)
}

/// All rows of a finer sleeve but its rim.
struct Rows<'a> {
    old: &'a Sleeve,
    new: &'a mut Sleeve,
}

impl WithSimd for Rows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Rows { old, new } = self;
        let beta = beta(6);
        // every second vertex of a finer row, from the first and from the second on
        let mut halves = [vec![0.0; 6 * old.row(0)[0].len()], vec![0.0; 6 * old.row(0)[0].len()]];
        for row in 0..=old.layers {
            let here = old.row(row);
            let above = old.row(row + 1);
            if row > 0 {
                let below = old.row(row - 1);
                for c in (0..old.columns).step_by(S::F64_LANES) {
                    let (left, v, right) = (load(simd, &here, c), load(simd, &here, c + 1), load(simd, &here, c + 2));
                    let (under, over) = (load(simd, &below, c + 1), load(simd, &above, c + 2));
                    let near = [[left, right], [under, load(simd, &above, c + 1)], [load(simd, &below, c), over]];
                    put(&mut halves[0], c, vertex_point(v, near, beta));
                    put(&mut halves[1], c, edge_point([v, right], [over, under]));
                }
                merge(&halves, new, 2 * row);
            }
            if row < old.layers {
                for c in (0..old.columns).step_by(S::F64_LANES) {
                    let (v, up, over) = (load(simd, &here, c + 1), load(simd, &above, c + 1), load(simd, &above, c + 2));
                    put(&mut halves[0], c, edge_point([v, up], [over, load(simd, &here, c)]));
                    put(&mut halves[1], c, edge_point([v, over], [up, load(simd, &here, c + 2)]));
                }
                merge(&halves, new, 2 * row + 1);
            }
        }
    }
}

/// Put vertices into half a row, from column `c` of it on.
#[inline(always)]
fn put<S: Simd>(half: &mut [f64], c: usize, [p, n]: Vertices<S>) {
    let (points, normals) = half.split_at_mut(half.len() / 2);
    p.store(points, c);
    n.store(normals, c);
}

/// A finer row from its halves.
#[inline(always)]
fn merge([even, odd]: &[Vec<f64>; 2], new: &mut Sleeve, row: usize) {
    let (columns, stride) = (new.columns, even.len() / 6);
    for (k, part) in new.row_mut(row).into_iter().enumerate() {
        let halves = even[k * stride..].iter().zip(&odd[k * stride..]);
        for (pair, (a, b)) in part[1..=columns].chunks_exact_mut(2).zip(halves) {
            (pair[0], pair[1]) = (*a, *b);
        }
    }
}

/// One level.
fn finer_sleeve(old: &Sleeve, star: &Star, arm: usize) -> Sleeve {
    let mut new = Sleeve::new(2 * old.columns, 2 * old.layers);
    // equation 6: rim vertices stay, and c((u_i + u_j) / 2) is the middle of the arc between two of them
    let (axis, taper) = (star.axes[arm], star.tapers[arm]);
    for column in 0..old.columns {
        new.set(0, 2 * column, old.point(0, column), old.normal(0, column));
        let normal = (old.normal(0, column) + old.normal(0, column + 1)).normalize();
        let out = if taper == 0.0 { normal } else { normal.reject_from_normalized(axis).normalize() };
        new.set(0, 2 * column + 1, star.cuts[arm] * axis + star.rim_radius(arm) * out, star.normal(arm, out));
    }
    Arch::new().dispatch(Rows { old, new: &mut new });
    new
}

/// Equation 10 at a vertex where any number of sleeves meet, from its places in the control mesh.
fn corner_point(sleeves: &[Sleeve], places: &[Place], level: u32) -> (DVec3, DVec3) {
    let vertex = |sleeve: &Sleeve, row: usize, column: usize| (sleeve.point(row, column), sleeve.normal(row, column));
    // of each sleeve the next vertex along the cell side, and two of the row before
    let mut near = Vec::with_capacity(3 * places.len());
    for place in places {
        let sleeve = &sleeves[place.arm];
        let (layers, column) = (sleeve.layers, place.column << level);
        let before = (column + sleeve.columns - 1) % sleeve.columns;
        near.extend([vertex(sleeve, layers, column + 1), vertex(sleeve, layers - 1, column), vertex(sleeve, layers - 1, before)]);
    }
    let sleeve = &sleeves[places[0].arm];
    let (p, n) = vertex(sleeve, sleeve.layers, places[0].column << level);
    let beta = beta(near.len());
    let own = 1.0 - near.len() as f64 * beta;
    let sum = near.iter().fold([DVec3::ZERO; 2], |[a, b], (p, n)| [a + *p, b + *n]);
    let t = own * p + beta * sum[0];
    let normal = (own * n + beta * sum[1]).normalize();
    let lift = |&(v, n): &(DVec3, DVec3)| {
        let cos = n.dot(normal);
        if cos < LEAST_COS { 0.0 } else { (n + normal).dot(v - t) / (1.0 + cos) }
    };
    let height = own * lift(&(p, n)) + beta * near.iter().map(lift).sum::<f64>();
    (t + height * normal, normal)
}

/// Normals of the refined surface: from its facets, by their areas, and from the strut on the rims. Returns the facets that do not face
/// outward.
fn normals(sleeves: &mut [Sleeve], seams: &Seams, star: &Star, levels: u32) -> Vec<Facet> {
    let mut inward = Vec::new();
    for (arm, sleeve) in sleeves.iter_mut().enumerate() {
        for row in Arch::new().dispatch(Means { sleeve }) {
            for column in 0..sleeve.columns {
                let facets = [0, 1].map(|half| Facet { arm, row, column, half });
                inward.extend(facets.into_iter().filter(|f| {
                    let [a, b, c] = f.corners().map(|(row, column)| sleeve.point(row, column));
                    !(a.dot((b - a).cross(c - a)) > 0.0)
                }));
            }
        }
        for column in 0..=sleeve.columns {
            let out = sleeve.point(0, column) - star.cuts[arm] * star.axes[arm];
            sleeve.set_normal(0, column, star.normal(arm, out.normalize()));
        }
    }
    // the last rows hold each sleeve's share
    let parts = 1usize << levels;
    let mut join = |places: &[Place]| {
        let sum: DVec3 = places.iter().map(|p| sleeves[p.arm].normal(sleeves[p.arm].layers, p.column)).sum();
        let mean = sum.normalize_or_zero();
        for p in places {
            let sleeve = &mut sleeves[p.arm];
            sleeve.set_normal(sleeve.layers, p.column, mean);
        }
    };
    for places in &seams.meets {
        join(&places.iter().map(|p| Place { column: p.column * parts, ..*p }).collect::<Vec<_>>());
    }
    for (arm, edges) in seams.across.iter().enumerate() {
        for (edge, other) in edges.iter().enumerate().filter(|(_, other)| other.arm > arm) {
            for k in 1..parts {
                join(&[Place { arm, column: edge * parts + k }, Place { arm: other.arm, column: (other.column + 1) * parts - k }]);
            }
        }
    }
    for sleeve in sleeves {
        sleeve.close(sleeve.layers);
    }
    inward
}

/// The normals of a sleeve between its rim and its last row, and on the last row the sum of its own facets' normals, twice their area long.
struct Means<'a> {
    sleeve: &'a mut Sleeve,
}

impl WithSimd for Means<'_> {
    /// Layers with facets that may not face outward.
    type Output = Vec<usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<usize> {
        let sleeve = self.sleeve;
        let (columns, stride) = (sleeve.columns, sleeve.row(0)[0].len());
        let mut doubtful = Vec::new();
        // of a layer's facets: both in each quad, by column + 1; those of the layer before
        let mut crosses = [[vec![0.0; 3 * stride], vec![0.0; 3 * stride]], [vec![0.0; 3 * stride], vec![0.0; 3 * stride]]];
        for row in 0..=sleeve.layers {
            let [before, now] = &mut crosses;
            std::mem::swap(before, now);
            if row < sleeve.layers {
                let (here, above) = (sleeve.row(row), sleeve.row(row + 1));
                let mut outward = true;
                // quads from column -1 on
                for c in (0..=columns).step_by(S::F64_LANES) {
                    let (a, b) = (points(simd, &here, c), points(simd, &here, c + 1));
                    let (d, e) = (points(simd, &above, c), points(simd, &above, c + 1));
                    let across = e - a;
                    let (lower, upper) = ((d - a).cross(across), across.cross(b - a));
                    lower.store(&mut now[0], c);
                    upper.store(&mut now[1], c);
                    outward &= a.dot(lower).min(a.dot(upper)).all_positive(columns + 1 - c);
                }
                if !outward {
                    doubtful.push(row);
                }
            }
            if row == 0 {
                continue;
            }
            let last = row == sleeve.layers;
            let [.., x, y, z] = sleeve.row_mut(row);
            let mut to = [x, y, z];
            for c in (0..columns).step_by(S::F64_LANES) {
                let under = thirds(simd, &before[0], c + 1) + (thirds(simd, &before[0], c) + thirds(simd, &before[1], c));
                let normal = if last {
                    under
                } else {
                    (under + (thirds(simd, &now[0], c + 1) + thirds(simd, &now[1], c + 1)) + thirds(simd, &now[1], c)).normalize_or_zero()
                };
                // lanes beyond the row fall into its slack
                normal.store_in(&mut to, c + 1);
            }
        }
        for row in 1..sleeve.layers {
            sleeve.close(row);
        }
        doubtful
    }
}

/// Points of a row from column `at` - 1 on.
#[inline(always)]
fn points<S: Simd>(simd: S, [x, y, z, ..]: &[&[f64]; 6], at: usize) -> Wide3<S> {
    Wide3::load(simd, [x, y, z], at)
}

/// Vectors whose x, y, z are the thirds of a list.
#[inline(always)]
fn thirds<S: Simd>(simd: S, from: &[f64], at: usize) -> Wide3<S> {
    let n = from.len() / 3;
    Wide3::load(simd, [&from[..n], &from[n..2 * n], &from[2 * n..]], at)
}

#[cfg(test)]
mod tests {
    use super::beta;

    #[test]
    fn vertex_weights_are_loop_s() {
        for (n, want) in [(3, 3.0 / 16.0), (4, 31.0 / 256.0), (6, 1.0 / 16.0), (9, 0.0337850)] {
            assert!((beta(n) - want).abs() < 1e-7, "valence {n}: {}", beta(n));
        }
        // the neighbours' share tends to 5/8 - (5/8)²
        assert!((2000.0 * beta(2000) - 15.0 / 64.0).abs() < 1e-5);
    }
}
