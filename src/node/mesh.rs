//! Triangle meshes in flat arrays, with twin half-edges, and ray casting from the node by walking.

use crate::node::Hit;
use glam::DVec3;

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
    /// None of it where the film is folded: a ray may then meet several facets, and which one must not depend on the levels.
    coarse: Vec<Facets>,
    /// Per cell of a cube map of directions: a facet seen there, or `NONE`. Rays start their walk from it.
    starts: Vec<u32>,
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

impl Mesh {
    /// `folded`: some facet does not face outward.
    pub fn new(points: Vec<DVec3>, normals: Vec<DVec3>, facets: Facets, coarse: Vec<Facets>, folded: bool) -> Mesh {
        let Facets { triangles, twins } = facets;
        let mut starts = vec![NONE; 6 * GRID * GRID];
        // facets come in families of 4^levels neighbours: one in eight is enough to hit every cell that matters
        for (f, t) in triangles.0.iter().enumerate().step_by(8) {
            starts[cell(points[t[0] as usize])] = f as u32;
        }
        let coarse = if folded { Vec::new() } else { coarse };
        Mesh { points, normals, triangles, twins, coarse, starts }
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
        let known = || match self.mesh.starts[cell(u)] {
            NONE => self.at,
            known => known as usize,
        };
        let near = self.mesh.points[self.mesh.triangles.0[self.at][0] as usize].normalize().dot(u) > 0.995;
        let (first, second) = if near { (self.at, known()) } else { (known(), self.at) };
        let face = self.locate(first, u).or_else(|| self.locate(second, u)).or_else(|| self.search(u))?;
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

    /// The facet that holds the ray, by walking from `start`: over the coarsest facets first, which are few enough to stay in
    /// the cache.
    fn locate(&self, start: usize, u: DVec3) -> Option<usize> {
        let mesh = self.mesh;
        let mut face = start;
        if !mesh.coarse.is_empty() {
            face >>= 2 * mesh.coarse.len();
            for Facets { triangles, twins } in &mesh.coarse {
                face = 4 * self.walk(face, u, triangles, twins)? + 3;
            }
        }
        self.walk(face, u, &mesh.triangles, &mesh.twins).filter(|&f| self.inside(f, u))
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
        let reach = |f: usize| self.mesh.points[self.mesh.triangles.0[f][0] as usize].dot(u);
        (0..self.mesh.triangles.0.len()).filter(|&f| reach(f) > 0.0 && self.inside(f, u)).max_by(|&f, &g| reach(f).total_cmp(&reach(g)))
    }
}
