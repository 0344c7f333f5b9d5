//! Unit cells, repeated. Nodes are named by whole quarters of a cell, so coincident nodes and struts merge exactly.
//!
//! A cell is a list of struts in the box [0, 4]³; its neighbours repeat it by 4. In none of the cells, and in no block of them,
//! do two struts cross without a node. Ordered by position: nodes by (z, y, x), struts by (a, b) with a < b.

use super::{Graph, Strut};
use crate::error::{Error, Fault};
use crate::ids::NodeId;
use glam::DVec3;

/// A place in quarters of a cell, as (z, y, x): its order is the order of the nodes.
type Place = [u32; 3];

/// Most struts a block may have. Reason: ids are 32 bits wide and arms are counted twice; 24 GB long before. Guessed.
const MOST_STRUTS: u64 = 200_000_000;

/// A unit cell of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    Cubic,
    Bcc,
    Fcc,
    BccEdges,
    Octet,
    Diamond,
    Kelvin,
}

impl Cell {
    pub const ALL: [Cell; 7] = [Cell::Cubic, Cell::Bcc, Cell::Fcc, Cell::BccEdges, Cell::Octet, Cell::Diamond, Cell::Kelvin];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Cell::Cubic => "cubic",
            Cell::Bcc => "bcc",
            Cell::Fcc => "fcc",
            Cell::BccEdges => "bcc-edges",
            Cell::Octet => "octet",
            Cell::Diamond => "diamond",
            Cell::Kelvin => "kelvin",
        }
    }

    /// One line on what it is.
    pub fn description(self) -> &'static str {
        match self {
            Cell::Cubic => "the edges of the cube",
            Cell::Bcc => "body centre to the eight corners",
            Cell::Fcc => "face centres to the corners of their faces",
            Cell::BccEdges => "bcc with the edges of the cube",
            Cell::Octet => "fcc with the octahedron between the face centres",
            Cell::Diamond => "the bonds of diamond: four struts at each inner node",
            Cell::Kelvin => "the edges of the truncated octahedron",
        }
    }

    /// The struts of one cell, in quarters, as (x, y, z). Struts on a face appear in both cells that share it.
    fn struts(self) -> Vec<[[u32; 3]; 2]> {
        match self {
            Cell::Cubic => pairs(&corners(), 16),
            Cell::Bcc => spokes([2, 2, 2], &corners()),
            Cell::BccEdges => [Cell::Cubic.struts(), Cell::Bcc.struts()].concat(),
            Cell::Fcc => {
                let all = [face_centres(), corners()].concat();
                let from_face_to_corner = |[p, q]: &[[u32; 3]; 2]| face_centres().contains(p) && corners().contains(q);
                pairs(&all, 8).into_iter().filter(from_face_to_corner).collect()
            }
            Cell::Octet => [Cell::Fcc.struts(), pairs(&face_centres(), 8)].concat(),
            Cell::Diamond => [[1, 1, 1], [3, 3, 1], [3, 1, 3], [1, 3, 3]].into_iter().flat_map(bonds).collect(),
            Cell::Kelvin => pairs(&truncated_octahedron(), 2),
        }
    }
}

impl std::str::FromStr for Cell {
    type Err = Fault;

    fn from_str(name: &str) -> Result<Cell, Fault> {
        let names = || Cell::ALL.map(Cell::name).join(", ");
        Cell::ALL.into_iter().find(|cell| cell.name() == name).ok_or_else(|| Fault::new("name", name, format!("one of {}", names())))
    }
}

/// A block of `repeat` cells along x, y, z, each a cube of edge `size` (mm), with struts of one `radius` (mm). Its lowest corner is
/// the origin. Whether the radius leaves room for the nodes is for `check` and the node layer to say.
pub fn generate(cell: Cell, size: f64, repeat: [u32; 3], radius: f64) -> Result<Graph, Error> {
    let pattern = cell.struts();
    check(&pattern, size, repeat, radius)?;
    let [nx, ny, nz] = repeat;
    let mut struts: Vec<[Place; 2]> = Vec::with_capacity(pattern.len() * (nx * ny * nz) as usize);
    for (cz, cy, cx) in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x)))) {
        let place = |[x, y, z]: [u32; 3]| [4 * cz + z, 4 * cy + y, 4 * cx + x];
        struts.extend(pattern.iter().map(|&[p, q]| [place(p).min(place(q)), place(p).max(place(q))]));
    }
    struts.sort_unstable();
    struts.dedup();
    let mut places: Vec<Place> = struts.iter().flatten().copied().collect();
    places.sort_unstable();
    places.dedup();
    let id = |place: Place| NodeId(places.binary_search(&place).expect("every end is a place") as u32);
    let position = |&[z, y, x]: &Place| DVec3::from_array([x, y, z].map(|quarters| size * f64::from(quarters) / 4.0));
    let strut = |&[p, q]: &[Place; 2]| Strut { a: id(p), b: id(q), ra: radius, rb: radius };
    Ok(Graph::new(places.iter().map(position).collect(), struts.iter().map(strut).collect()))
}

fn check(pattern: &[[[u32; 3]; 2]], size: f64, repeat: [u32; 3], radius: f64) -> Result<(), Error> {
    let mut faults = Vec::new();
    for (path, length) in [("size", size), ("radius", radius)] {
        if !(length.is_finite() && length > 0.0) {
            faults.push(Fault::new(path, length.to_string(), format!("a {path} > 0 mm")));
        }
    }
    let cells = repeat.iter().try_fold(1u64, |product, &n| product.checked_mul(n.into()));
    let struts = cells.and_then(|cells| cells.checked_mul(pattern.len() as u64));
    if !struts.is_some_and(|struts| (1..=MOST_STRUTS).contains(&struts)) {
        let found = repeat.map(|n| n.to_string()).join("x");
        faults.push(Fault::new("repeat", found, format!("at least 1 along each axis, and at most {MOST_STRUTS} struts in all")));
    }
    Error::unless_empty(faults)
}

/// The eight corners of the cell.
fn corners() -> Vec<[u32; 3]> {
    (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1].map(|bit| 4 * bit)).collect()
}

/// The six face centres of the cell.
fn face_centres() -> Vec<[u32; 3]> {
    vec![[0, 2, 2], [4, 2, 2], [2, 0, 2], [2, 4, 2], [2, 2, 0], [2, 2, 4]]
}

/// The permutations of (0, ±1, ±2) about the body centre: the 24 corners of the truncated octahedron.
fn truncated_octahedron() -> Vec<[u32; 3]> {
    let mut places = Vec::new();
    for [zero, one, two] in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        for (by_one, by_two) in [(1, 0), (1, 4), (3, 0), (3, 4)] {
            let mut place = [0; 3];
            (place[zero], place[one], place[two]) = (2, by_one, by_two);
            places.push(place);
        }
    }
    places
}

/// The bonds of an inner node of diamond: along (-,-,-), (+,+,-), (+,-,+), (-,+,+).
fn bonds([x, y, z]: [u32; 3]) -> Vec<[[u32; 3]; 2]> {
    spokes([x, y, z], &[[x - 1, y - 1, z - 1], [x + 1, y + 1, z - 1], [x + 1, y - 1, z + 1], [x - 1, y + 1, z + 1]])
}

fn spokes(centre: [u32; 3], ends: &[[u32; 3]]) -> Vec<[[u32; 3]; 2]> {
    ends.iter().map(|&end| [centre, end]).collect()
}

/// All pairs of places at this squared distance (quarters).
fn pairs(places: &[[u32; 3]], distance_sq: u32) -> Vec<[[u32; 3]; 2]> {
    let far = |p: [u32; 3], q: [u32; 3]| (0..3).map(|k| p[k].abs_diff(q[k]).pow(2)).sum::<u32>();
    let later = |(k, &p): (usize, &[u32; 3])| places[k + 1..].iter().filter(move |&&q| far(p, q) == distance_sq).map(move |&q| [p, q]).collect::<Vec<_>>();
    places.iter().enumerate().flat_map(later).collect()
}
