//! A refined film, its facets, and ray casting from the node by walking over them.

use crate::math::{Loops, vectorised};
use crate::node::Hit;
use crate::node::sleeve::{Place, Seams, Sleeve};
use glam::DVec3;
use std::sync::OnceLock;

/// Triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Triangles(pub Vec<[u32; 3]>);

/// Place of a vertex on a rim circle.
#[derive(Clone, Copy, Debug)]
pub struct Rim {
    pub arm: u32,
}

/// A facet: one half of a quad of a sleeve, in which its diagonal ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facet {
    pub arm: usize,
    pub row: usize,
    pub column: usize,
    /// 0: the half with the edge of the next row, 1: with that of its own row.
    pub half: usize,
}

impl Facet {
    /// Rows and columns of its vertices, counter-clockwise seen from outside. The first is the quad's own.
    #[inline(always)]
    pub fn corners(&self) -> [(usize, usize); 3] {
        let (row, column) = (self.row, self.column);
        let across = (row + 1, column + 1);
        if self.half == 0 { [(row, column), (row + 1, column), across] } else { [(row, column), across, (row, column + 1)] }
    }
}

/// A refined film.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// One per arm. Unit normals of the refined surface at its vertices: those of the strut on the rims, else the mean of the facets'.
    pub sleeves: Vec<Sleeve>,
    seams: Seams,
    levels: u32,
    /// Per cell of a cube map of directions: a facet seen there, if one is known. Rays start their walk from it.
    starts: Vec<Option<Facet>>,
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
#[inline(always)]
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

    /// `inward`: corners of the facets that do not face outward.
    fn new(inward: impl Iterator<Item = [DVec3; 3]>) -> Folds {
        let cones = inward.map(|corners| {
            // all that the facet hides lies in the cone about its corners
            let [a, b, c] = corners.map(|p| p.normalize());
            let axis = (a + b + c).normalize_or_zero();
            let wide = axis.dot(a).min(axis.dot(b)).min(axis.dot(c));
            (axis, if wide > 0.0 { (wide.min(1.0).acos() + Folds::CELL).cos() } else { -1.0 })
        });
        Folds { cells: vectorised(Hidden { cones: &cones.collect::<Vec<_>>() }), reach_sq: OnceLock::new() }
    }

    fn reach_sq(&self, mesh: &Mesh) -> f64 {
        *self.reach_sq.get_or_init(|| vectorised(Longest { sleeves: &mesh.sleeves }))
    }
}

/// Which cells of the cube map have their middle in one of these cones (axis, least cosine).
struct Hidden<'a> {
    cones: &'a [(DVec3, f64)],
}

impl Loops for Hidden<'_> {
    type Output = Vec<bool>;

    #[inline(always)]
    fn run(self) -> Vec<bool> {
        let middles: Vec<DVec3> = middles().collect();
        let [x, y, z] = [0, 1, 2].map(|k| middles.iter().map(|m| m[k]).collect::<Vec<f64>>());
        // the most by which a cosine exceeds the least
        let mut excess = vec![f64::NEG_INFINITY; middles.len()];
        for (axis, least) in self.cones {
            for (((most, x), y), z) in excess.iter_mut().zip(&x).zip(&y).zip(&z) {
                let over = x * axis.x + y * axis.y + z * axis.z - least;
                *most = if over > *most { over } else { *most };
            }
        }
        excess.into_iter().map(|most| most >= 0.0).collect()
    }
}

/// Square of the longest edge of all facets.
struct Longest<'a> {
    sleeves: &'a [Sleeve],
}

impl Loops for Longest<'_> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        const WIDE: usize = 8;
        let mut most = [0.0f64; WIDE];
        for sleeve in self.sleeves {
            let n = sleeve.columns;
            for row in 0..=sleeve.layers {
                let [x, y, z, ..] = sleeve.row(row);
                let [ax, ay, az, ..] = sleeve.row((row + 1).min(sleeve.layers));
                // to the next column, to the next row, and along the diagonal: each edge of the row's quads is one of them
                for (here, there) in [([x, y, z], [&x[1..], &y[1..], &z[1..]]), ([x, y, z], [ax, ay, az]), ([x, y, z], [&ax[1..], &ay[1..], &az[1..]])] {
                    let [hx, hy, hz] = here.map(|part| &part[1..=n]);
                    let [tx, ty, tz] = there.map(|part| &part[1..=n]);
                    for at in (0..n).step_by(WIDE) {
                        // the last ones of a row overlap those before them
                        let at = at.min(n.saturating_sub(WIDE));
                        let part = |from: &[f64]| from[at..].first_chunk::<WIDE>().copied().unwrap_or_else(|| std::array::from_fn(|k| from[k.min(n - 1)]));
                        let ([hx, hy, hz], [tx, ty, tz]) = ([hx, hy, hz].map(part), [tx, ty, tz].map(part));
                        for (k, lane) in most.iter_mut().enumerate() {
                            let (dx, dy, dz) = (hx[k] - tx[k], hy[k] - ty[k], hz[k] - tz[k]);
                            let square = dx * dx + dy * dy + dz * dz;
                            *lane = if square > *lane { square } else { *lane };
                        }
                    }
                }
            }
        }
        most.into_iter().fold(0.0, f64::max)
    }
}

impl Mesh {
    /// `inward`: the facets that do not face outward.
    pub fn new(sleeves: Vec<Sleeve>, seams: Seams, levels: u32, inward: &[Facet]) -> Mesh {
        // one facet in 32 is enough to hit every cell that matters
        const APART: usize = 4;
        let mut starts = vec![None; 6 * GRID * GRID];
        for (arm, sleeve) in sleeves.iter().enumerate() {
            for row in (0..sleeve.layers).step_by(APART) {
                for column in (0..sleeve.columns).step_by(APART) {
                    starts[cell(sleeve.point(row, column))] = Some(Facet { arm, row, column, half: 0 });
                }
            }
        }
        let mut mesh = Mesh { sleeves, seams, levels, starts, folds: None };
        mesh.folds = (!inward.is_empty()).then(|| Folds::new(inward.iter().map(|&f| mesh.corners(f))));
        mesh
    }

    /// All facets.
    pub fn facets(&self) -> impl Iterator<Item = Facet> {
        let quads = self.sleeves.iter().enumerate().flat_map(|(arm, s)| (0..s.layers * s.columns).map(move |k| (arm, k / s.columns, k % s.columns)));
        quads.flat_map(|(arm, row, column)| [0, 1].map(|half| Facet { arm, row, column, half }))
    }

    /// The points of a facet's vertices.
    #[inline(always)]
    pub fn corners(&self, facet: Facet) -> [DVec3; 3] {
        let (sleeve, [a, b, c]) = (&self.sleeves[facet.arm], facet.corners());
        [sleeve.point(a.0, a.1), sleeve.point(b.0, b.1), sleeve.point(c.0, c.1)]
    }

    /// Whether there is a facet across edge k (from vertex k to the next): not on a rim.
    #[inline(always)]
    fn goes_on(&self, facet: Facet, k: usize) -> bool {
        facet.half == 0 || k < 2 || facet.row > 0
    }

    /// The facet across edge k, and which of its edges that is.
    #[inline(always)]
    fn across(&self, facet: Facet, k: usize) -> (Facet, usize) {
        let Facet { arm, row, column, half } = facet;
        let sleeve = &self.sleeves[arm];
        match (half, k) {
            (0, 0) => (Facet { column: if column == 0 { sleeve.columns } else { column } - 1, half: 1, ..facet }, 1),
            (0, 1) if row + 1 < sleeve.layers => (Facet { row: row + 1, half: 1, ..facet }, 2),
            (0, 1) => {
                let Place { arm, column } = self.seams.across(arm, column, self.levels);
                (Facet { arm, row: self.sleeves[arm].layers - 1, column, half: 0 }, 1)
            }
            (0, _) => (Facet { half: 1, ..facet }, 0),
            (_, 0) => (Facet { half: 0, ..facet }, 2),
            (_, 1) => (Facet { column: if column + 1 == sleeve.columns { 0 } else { column + 1 }, half: 0, ..facet }, 0),
            _ => (Facet { row: row - 1, half: 0, ..facet }, 1),
        }
    }

    /// Least cosine between a facet's normal and the ray from the node to it (negative: the film is folded there),
    /// and the number of facets turned away from the node.
    pub fn facing(&self) -> (f64, usize) {
        let mut least = 1.0f64;
        let mut folded = 0;
        for facet in self.facets() {
            let [a, b, c] = self.corners(facet);
            let cos = (b - a).cross(c - a).normalize_or_zero().dot((a + b + c).normalize_or_zero());
            least = least.min(cos);
            folded += usize::from(cos <= 0.0);
        }
        (least, folded)
    }
}

/// Volumes of the ray with each edge of a facet, from vertex k to the next: all positive where the ray passes within it.
#[inline(always)]
fn sides([a, b, c]: [DVec3; 3], u: DVec3) -> [f64; 3] {
    [u.dot(a.cross(b)), u.dot(b.cross(c)), u.dot(c.cross(a))]
}

/// A facet with these `sides` faces outward and holds the ray.
#[inline(always)]
fn holds([a, b, c]: [DVec3; 3], side: [f64; 3]) -> bool {
    let slack = -1e-12 * a.length_squared();
    side[0] >= slack && side[1] >= slack && side[2] >= slack && a.dot(b.cross(c)) > 0.0
}

/// A facet that holds a ray: its vertices' points, and the ray's `sides`.
#[derive(Clone, Copy)]
struct Met {
    facet: Facet,
    corners: [DVec3; 3],
    sides: [f64; 3],
}

/// Leaps of a ray before it goes step by step.
const MOST_LEAPS: usize = 6;

/// Casts rays from the node at a mesh. Walks from facet to facet, so near rays in turn are cheap.
pub struct Caster<'a> {
    mesh: &'a Mesh,
    at: Facet,
}

/// One ray: not many numbers at once, but the instructions of wide vectors need fewer moves.
struct Ray<'a, 'b> {
    caster: &'a mut Caster<'b>,
    direction: DVec3,
}

impl Loops for Ray<'_, '_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run(self) -> Option<Hit> {
        self.caster.cast(self.direction)
    }
}

impl<'a> Caster<'a> {
    pub fn new(mesh: &'a Mesh) -> Self {
        Caster { mesh, at: Facet { arm: 0, row: 0, column: 0, half: 0 } }
    }

    /// Where the ray meets the mesh. The facets are lifted towards the smooth surface by their vertex normals:
    /// half the mean distance to the vertices' tangent planes, exact to second order for every quadric.
    pub fn hit(&mut self, direction: DVec3) -> Option<Hit> {
        vectorised(Ray { caster: self, direction })
    }

    #[inline(always)]
    fn cast(&mut self, direction: DVec3) -> Option<Hit> {
        let u = direction.normalize();
        let Met { facet, corners: [a, b, c], sides: [third, first, second] } = self.find(u)?;
        self.at = facet;
        let sleeve = &self.mesh.sleeves[facet.arm];
        let scale = 1.0 / (first + second + third);
        let (first, second, third) = (first * scale, second * scale, third * scale);
        let p = first * a + second * b + third * c;
        let [i, j, k] = facet.corners();
        let (na, nb, nc) = (sleeve.normal(i.0, i.1), sleeve.normal(j.0, j.1), sleeve.normal(k.0, k.1));
        let normal = (first * na + second * nb + third * nc).normalize();
        let lift = 0.5 * (first * na.dot(a - p) + second * nb.dot(b - p) + third * nc.dot(c - p));
        // steep facets: the lift along the ray is bounded by the size of the facet
        let along = lift / normal.dot(u).max(0.2);
        let most = 0.2 * a.distance_squared(b).max(b.distance_squared(c)).sqrt();
        Some(Hit { distance: p.length() + along.clamp(-most, most), normal })
    }

    /// The facet that holds the ray.
    #[inline(always)]
    fn find(&self, u: DVec3) -> Option<Met> {
        const NEAR: f64 = 0.995; // cosine
        let mesh = self.mesh;
        let p = mesh.sleeves[self.at.arm].point(self.at.row, self.at.column);
        let along = p.dot(u);
        let near = along > 0.0 && along * along > NEAR * NEAR * p.length_squared();
        if near
            && mesh.folds.is_none()
            && let Some(met) = self.walk(self.at, u, MOST_LEAPS)
        {
            return Some(met);
        }
        let place = cell(u);
        let known = mesh.starts[place].unwrap_or(self.at);
        let (first, second) = if near { (self.at, known) } else { (known, self.at) };
        // where the film is folded the way decides which facet is met: it goes step by step
        let single = mesh.folds.as_ref().is_none_or(|f| !f.cells[place]);
        let quick = if single { self.walk(first, u, MOST_LEAPS) } else { None };
        quick.or_else(|| self.walk(first, u, 0)).or_else(|| self.walk(second, u, 0)).or_else(|| self.search(u))
    }

    /// The facet that holds the ray, by walking from `facet` towards it, with some leaps at first; none where that does not lead there.
    #[inline(always)]
    fn walk(&self, mut facet: Facet, u: DVec3, mut leaps: usize) -> Option<Met> {
        const MOST_STEPS: usize = 200;
        let mut from = 3;
        for _ in 0..MOST_STEPS {
            let corners = self.mesh.corners(facet);
            let side = sides(corners, u);
            if holds(corners, side) {
                return Some(Met { facet, corners, sides: side });
            }
            if leaps > 0 {
                leaps -= 1;
                let far = self.leap(facet, side);
                if far != facet {
                    (facet, from) = (far, 3);
                    continue;
                }
            }
            // the edge that the ray passes farthest out, but for the one across which the way came, and rims
            let (mut worst, mut least) = (3, 0.0);
            for k in 0..3 {
                if side[k] < least && k != from && self.mesh.goes_on(facet, k) {
                    (worst, least) = (k, side[k]);
                }
            }
            if worst == 3 {
                return None;
            }
            (facet, from) = self.mesh.across(facet, worst);
        }
        None
    }

    /// Where the ray would be, in the same sleeve, if rows and columns went on as they do at a facet; `side` are its `sides`.
    #[inline(always)]
    fn leap(&self, facet: Facet, side: [f64; 3]) -> Facet {
        let sleeve = &self.mesh.sleeves[facet.arm];
        let sum = side[0] + side[1] + side[2];
        if !(sum > 0.0) {
            return facet;
        }
        // rows and columns beyond the quad's own
        let (up, along) = if facet.half == 0 { (side[2] + side[0], side[0]) } else { (side[2], side[2] + side[0]) };
        let (up, along) = (up / sum, along / sum);
        let (rows, columns, most) = (up.floor(), along.floor(), sleeve.columns as f64);
        let row = (facet.row as f64 + rows).clamp(0.0, sleeve.layers as f64 - 1.0);
        let column = facet.column as f64 + columns.clamp(-most, most);
        let column = if column < 0.0 { column + most } else { column } as usize;
        let column = if column >= sleeve.columns { column - sleeve.columns } else { column };
        Facet { row: row as usize, column: column.min(sleeve.columns - 1), half: usize::from(along - columns > up - rows), ..facet }
    }

    /// All facets, the outermost hit first.
    fn search(&self, u: DVec3) -> Option<Met> {
        // a facet that holds the ray has no vertex farther from it than its longest edge
        let reach_sq = self.mesh.folds.as_ref().map_or(f64::INFINITY, |f| f.reach_sq(self.mesh) * (1.0 + 1e-9));
        let (mut found, mut farthest) = (None, 0.0);
        for (arm, sleeve) in self.mesh.sleeves.iter().enumerate() {
            for row in 0..sleeve.layers {
                let [x, y, z, ..] = sleeve.row(row).map(|part| &part[1..=sleeve.columns]);
                for (column, (&x, (&y, &z))) in x.iter().zip(y.iter().zip(z)).enumerate() {
                    // the first vertex of both facets of a quad
                    let p = DVec3::new(x, y, z);
                    let reach = p.dot(u);
                    if reach < farthest || p.length_squared() - reach * reach > reach_sq {
                        continue;
                    }
                    for facet in [0, 1].map(|half| Facet { arm, row, column, half }) {
                        let corners = self.mesh.corners(facet);
                        let sides = sides(corners, u);
                        if holds(corners, sides) {
                            (found, farthest) = (Some(Met { facet, corners, sides }), reach);
                        }
                    }
                }
            }
        }
        found
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
