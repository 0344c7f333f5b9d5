//! Triangle meshes in flat arrays, with twin half-edges, and ray casting from the node by walking.

use crate::node::Hit;
use glam::DVec3;
use std::sync::OnceLock;

/// No twin: the half-edge lies on a rim.
pub const NONE: u32 = u32::MAX;

/// Triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Triangles(pub Vec<[u32; 3]>);

/// Place of a vertex on a rim circle.
#[derive(Clone, Copy, Debug)]
pub struct Rim {
    pub arm: u32,
}

impl Triangles {
    /// Half-edge `3 f + k` runs from vertex k to vertex k + 1 of triangle f. Returns its twin, or `NONE` on a rim.
    pub fn twins(&self) -> Vec<u32> {
        let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * self.0.len());
        for (f, t) in self.0.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                edges.push((a.min(b), a.max(b), (3 * f + k) as u32));
            }
        }
        edges.sort_unstable();
        let mut twins = vec![NONE; edges.len()];
        for w in edges.windows(2) {
            if w[0].0 == w[1].0 && w[0].1 == w[1].1 {
                twins[w[0].2 as usize] = w[1].2;
                twins[w[1].2 as usize] = w[0].2;
            }
        }
        twins
    }
}

/// Triangles with the twins of their half-edges.
#[derive(Clone, Debug)]
pub struct Facets {
    pub triangles: Triangles,
    pub twins: Vec<u32>,
}

/// A refined film.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub points: Vec<DVec3>,
    /// Unit normals of the refined surface at its vertices: cylinder normals on the rims, else the mean of the facets'.
    pub normals: Vec<DVec3>,
    pub triangles: Triangles,
    pub twins: Vec<u32>,
    /// What was refined, coarsest first: facet f has the parts `4 f + k` at its vertices k and `4 f + 3` in the middle.
    coarse: Vec<Facets>,
    /// Per cell of a cube map of directions: a facet seen there, or `NONE`. Rays start their walk from it.
    starts: Vec<u32>,
    folds: Option<Folds>,
}

/// Where a film is folded: there a ray meets several facets. It meets one more that faces outward than inward, so
/// everywhere else it meets one.
#[derive(Clone, Debug)]
struct Folds {
    /// Per cell of the cube map: some facet that faces inward may be seen there.
    cells: Vec<bool>,
    /// Square of the longest edge of all facets, once a search asks for it.
    reach_sq: OnceLock<f64>,
}

/// Cells along each edge of the cube map.
const GRID: usize = 16;

/// The cube map cell of a direction.
fn cell(u: DVec3) -> usize {
    let m = u.abs();
    let (face, a, b, c) = if m.x >= m.y && m.x >= m.z {
        (usize::from(u.x < 0.0), u.y, u.z, m.x)
    } else if m.y >= m.z {
        (2 + usize::from(u.y < 0.0), u.z, u.x, m.y)
    } else {
        (4 + usize::from(u.z < 0.0), u.x, u.y, m.z)
    };
    let place = |x: f64| ((0.5 + 0.5 * x / c) * GRID as f64).clamp(0.0, GRID as f64 - 1.0) as usize;
    (face * GRID + place(a)) * GRID + place(b)
}

/// Middles of all cells of the cube map, in their order.
fn middles() -> impl Iterator<Item = DVec3> {
    (0..6 * GRID * GRID).map(|k| {
        let [a, b] = [k / GRID % GRID, k % GRID].map(|x| (2 * x + 1) as f64 / GRID as f64 - 1.0);
        let c = if k / (GRID * GRID) % 2 == 0 { 1.0 } else { -1.0 };
        match k / (2 * GRID * GRID) {
            0 => DVec3::new(c, a, b),
            1 => DVec3::new(b, c, a),
            _ => DVec3::new(a, b, c),
        }
        .normalize()
    })
}

impl Folds {
    /// Angle between a cell's middle and its farthest corner, radians: at most half the diagonal of a cell.
    const CELL: f64 = 1.5 / GRID as f64;

    /// `inward`: the facets that do not face outward.
    fn new(points: &[DVec3], triangles: &Triangles, inward: &[usize]) -> Folds {
        let corners = |t: &[u32; 3]| t.map(|v| points[v as usize]);
        let middles: Vec<DVec3> = middles().collect();
        let mut cells = vec![false; middles.len()];
        for &f in inward {
            // all that the facet hides lies in the cone about its corners
            let [a, b, c] = corners(&triangles.0[f]).map(|p| p.normalize());
            let axis = (a + b + c).normalize_or_zero();
            let wide = axis.dot(a).min(axis.dot(b)).min(axis.dot(c));
            let least = if wide > 0.0 { (wide.min(1.0).acos() + Folds::CELL).cos() } else { -1.0 };
            cells.iter_mut().zip(&middles).for_each(|(cell, m)| *cell |= m.dot(axis) >= least);
        }
        Folds { cells, reach_sq: OnceLock::new() }
    }

    fn reach_sq(&self, mesh: &Mesh) -> f64 {
        let longest = |t: &[u32; 3]| {
            let [a, b, c] = mesh.corners(*t);
            a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
        };
        *self.reach_sq.get_or_init(|| mesh.triangles.0.iter().map(longest).fold(0.0, f64::max))
    }
}

impl Mesh {
    /// `inward`: the facets that do not face outward.
    pub fn new(points: Vec<DVec3>, normals: Vec<DVec3>, facets: Facets, coarse: Vec<Facets>, inward: &[usize]) -> Mesh {
        let Facets { triangles, twins } = facets;
        let mut starts = vec![NONE; 6 * GRID * GRID];
        // facets come in families of 4^levels neighbours: one in eight is enough to hit every cell that matters
        for (f, t) in triangles.0.iter().enumerate().step_by(8) {
            starts[cell(points[t[0] as usize])] = f as u32;
        }
        let folds = (!inward.is_empty()).then(|| Folds::new(&points, &triangles, inward));
        Mesh { points, normals, triangles, twins, coarse, starts, folds }
    }

    fn corners(&self, t: [u32; 3]) -> [DVec3; 3] {
        [self.points[t[0] as usize], self.points[t[1] as usize], self.points[t[2] as usize]]
    }

    /// Least cosine between a facet's normal and the ray from the node to it (negative: the film is folded there),
    /// and the number of facets turned away from the node.
    pub fn facing(&self) -> (f64, usize) {
        let mut least = 1.0f64;
        let mut folded = 0;
        for t in &self.triangles.0 {
            let [a, b, c] = self.corners(*t);
            let cos = (b - a).cross(c - a).normalize_or_zero().dot((a + b + c).normalize_or_zero());
            least = least.min(cos);
            folded += usize::from(cos <= 0.0);
        }
        (least, folded)
    }
}

/// Casts rays from the node at a mesh. Walks from facet to facet, so near rays in turn are cheap.
pub struct Caster<'a> {
    mesh: &'a Mesh,
    at: usize,
}

impl<'a> Caster<'a> {
    pub fn new(mesh: &'a Mesh) -> Self {
        Caster { mesh, at: 0 }
    }

    /// Where the ray meets the mesh. The facets are lifted towards the smooth surface by their vertex normals:
    /// half the mean distance to the vertices' tangent planes, exact to second order for every quadric.
    pub fn hit(&mut self, direction: DVec3) -> Option<Hit> {
        let u = direction.normalize();
        let mesh = self.mesh;
        let place = cell(u);
        let known = || if mesh.starts[place] == NONE { self.at } else { mesh.starts[place] as usize };
        let near = mesh.points[mesh.triangles.0[self.at][0] as usize].normalize().dot(u) > 0.995;
        let (first, second) = if near { (self.at, known()) } else { (known(), self.at) };
        // where the film is folded the way decides which facet is met: it keeps to the finest level
        let single = mesh.folds.as_ref().is_none_or(|f| !f.cells[place]);
        let quick = if single { self.descend(first, u) } else { None };
        let face = quick.or_else(|| self.along(first, u)).or_else(|| self.along(second, u)).or_else(|| self.search(u))?;
        self.at = face;
        let t = self.mesh.triangles.0[face];
        let [a, b, c] = self.mesh.corners(t);
        let weight = [u.dot(b.cross(c)), u.dot(c.cross(a)), u.dot(a.cross(b))];
        let sum: f64 = weight.iter().sum();
        let p = (weight[0] * a + weight[1] * b + weight[2] * c) / sum;
        let mut normal = DVec3::ZERO;
        let mut lift = 0.0;
        for (v, (corner, weight)) in t.into_iter().zip([a, b, c].into_iter().zip(weight)) {
            let n = self.mesh.normals[v as usize];
            normal += weight / sum * n;
            lift += 0.5 * weight / sum * n.dot(corner - p);
        }
        let normal = normal.normalize();
        // steep facets: the lift along the ray is bounded by the size of the facet
        let along = lift / normal.dot(u).max(0.2);
        let size = a.distance(b).max(b.distance(c));
        Some(Hit { distance: p.length() + along.clamp(-0.2 * size, 0.2 * size), normal })
    }

    /// The facet that holds the ray, by walking from `start` over the coarsest facets first: they are few enough to stay
    /// in the cache.
    fn descend(&self, start: usize, u: DVec3) -> Option<usize> {
        let mut face = start >> (2 * self.mesh.coarse.len());
        for Facets { triangles, twins } in &self.mesh.coarse {
            face = 4 * self.walk(face, u, triangles, twins)? + 3;
        }
        self.along(face, u)
    }

    /// The facet that holds the ray, by walking from `start` over the finest facets.
    fn along(&self, start: usize, u: DVec3) -> Option<usize> {
        self.walk(start, u, &self.mesh.triangles, &self.mesh.twins).filter(|&f| self.inside(f, u))
    }

    /// Walk towards the ray over the facets of one level, as far as that leads; none where it does not end.
    fn walk(&self, mut face: usize, u: DVec3, triangles: &Triangles, twins: &[u32]) -> Option<usize> {
        const MOST_STEPS: usize = 200;
        let mut from = NONE;
        for _ in 0..MOST_STEPS {
            let [a, b, c] = self.mesh.corners(triangles.0[face]);
            let twins = &twins[3 * face..3 * face + 3];
            let side = [u.dot(a.cross(b)), u.dot(b.cross(c)), u.dot(c.cross(a))];
            let mut next = NONE;
            let mut worst = 0.0;
            for k in 0..3 {
                if side[k] < worst && twins[k] != NONE && (3 * face + k) as u32 != from {
                    worst = side[k];
                    next = twins[k];
                }
            }
            if next == NONE {
                return Some(face);
            }
            from = next;
            face = next as usize / 3;
        }
        None
    }

    /// Facet `face` faces outward and holds the ray.
    fn inside(&self, face: usize, u: DVec3) -> bool {
        let [a, b, c] = self.mesh.corners(self.mesh.triangles.0[face]);
        let slack = -1e-12 * a.length_squared();
        u.dot(a.cross(b)) >= slack && u.dot(b.cross(c)) >= slack && u.dot(c.cross(a)) >= slack && a.dot(b.cross(c)) > 0.0
    }

    /// All facets, the outermost hit first.
    fn search(&self, u: DVec3) -> Option<usize> {
        let first = |f: usize| self.mesh.points[self.mesh.triangles.0[f][0] as usize];
        let reach = |f: usize| first(f).dot(u);
        // a facet that holds the ray has no vertex farther from it than its longest edge
        let reach_sq = self.mesh.folds.as_ref().map_or(f64::INFINITY, |f| f.reach_sq(self.mesh) * (1.0 + 1e-9));
        let near = |f: usize| reach(f) > 0.0 && first(f).length_squared() - reach(f).powi(2) <= reach_sq;
        (0..self.mesh.triangles.0.len()).filter(|&f| near(f) && self.inside(f, u)).max_by(|&f, &g| reach(f).total_cmp(&reach(g)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn middles_lie_in_their_cells() {
        for (k, m) in middles().enumerate() {
            assert_eq!(cell(m), k);
        }
        // the farthest corner of a cell, at the middle of a cube's face
        let (middle, corner) = (DVec3::new(1.0, 1.0 / GRID as f64, 1.0 / GRID as f64), DVec3::X);
        assert!(middle.angle_between(corner) < Folds::CELL);
    }
}
