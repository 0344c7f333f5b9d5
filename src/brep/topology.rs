//! Which edges bound which faces, as numbers alone, and the checks on it: loops, edge uses, one shell without pinched vertices, and
//! the Euler number.

use super::error::BrepError;
use super::model::{EdgeUse, Model, Part, Solid};
use rayon::prelude::*;

/// Vertices, edges and faces of one solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Counts {
    pub vertices: usize,
    pub edges: usize,
    pub faces: usize,
}

impl Counts {
    pub fn of(solid: &Solid) -> Self {
        Counts { vertices: solid.vertex_count(), edges: solid.edge_count(), faces: solid.face_count() }
    }

    /// V - E + F
    pub fn euler(self) -> i64 {
        self.vertices as i64 - self.edges as i64 + self.faces as i64
    }
}

/// The borders of one solid: vertices of edges, edges of faces.
#[derive(Clone, Debug)]
pub struct Borders {
    pub vertex_count: usize,
    /// First and second vertex of each edge.
    pub edges: Vec<[u32; 2]>,
    /// The loops of all faces, one after the other.
    pub uses: Vec<EdgeUse>,
    /// Where the loop of each face begins, and the end.
    pub first: Vec<u32>,
}

impl Borders {
    pub fn of(solid: &Solid) -> Borders {
        Borders::with(solid, |_, _| (), |()| ())
    }

    /// The same; `look` sees each node's part (without control points of patches) on the way, `take` gets what it saw, node by node.
    pub fn with<T: Send>(solid: &Solid, look: impl Fn(usize, &Part) -> T + Sync, mut take: impl FnMut(T)) -> Borders {
        let mut borders = Borders {
            vertex_count: solid.vertex_count(),
            edges: Vec::with_capacity(solid.edge_count()),
            uses: Vec::with_capacity(2 * solid.edge_count()),
            first: Vec::with_capacity(solid.face_count() + 1),
        };
        borders.first.push(0);
        (0..solid.struts.len()).for_each(|k| borders.add(&solid.strut_face(k).boundary));
        let of_node = |n: usize| {
            let part = solid.bordered(n);
            let seen = look(n, &part);
            let faces: Vec<Vec<EdgeUse>> = part.faces.into_iter().map(|face| face.boundary).collect();
            (part.edges.iter().map(|e| e.vertices).collect::<Vec<_>>(), faces, seen)
        };
        in_order(solid.nodes.len(), of_node, |(edges, faces, seen)| {
            borders.edges.extend(edges);
            faces.iter().for_each(|boundary| borders.add(boundary));
            take(seen);
        });
        borders.edges.extend((0..solid.struts.len()).flat_map(|k| solid.strut_edges(k)).chain(solid.meridians()).map(|e| e.vertices));
        borders
    }

    fn add(&mut self, boundary: &[EdgeUse]) {
        self.uses.extend(boundary);
        self.first.push(self.uses.len() as u32);
    }

    pub fn face_count(&self) -> usize {
        self.first.len() - 1
    }

    /// The loop of a face.
    pub fn boundary(&self, face: usize) -> &[EdgeUse] {
        &self.uses[self.first[face] as usize..self.first[face + 1] as usize]
    }

    /// Where an edge begins (0) and ends (1) on a loop.
    fn ends(&self, e: EdgeUse) -> [u32; 2] {
        let [a, b] = self.edges[e.edge as usize];
        if e.forward { [a, b] } else { [b, a] }
    }
}

/// Items made in parallel, some at a time, and taken in order.
fn in_order<T: Send>(count: usize, make: impl Fn(usize) -> T + Sync, mut take: impl FnMut(T)) {
    const AT_A_TIME: usize = 256;
    for start in (0..count).step_by(AT_A_TIME) {
        let made: Vec<T> = (start..count.min(start + AT_A_TIME)).into_par_iter().map(&make).collect();
        made.into_iter().for_each(&mut take);
    }
}

/// All topological checks on all solids; one fault a solid at most, the first.
pub fn check_topology(model: &Model) -> Result<(), Vec<BrepError>> {
    let check = |(index, solid): (usize, &Solid)| check_borders(index, &Borders::of(solid), solid.genus(), |f| solid.label(f).to_string());
    let faults: Vec<_> = model.solids.iter().enumerate().filter_map(|s| check(s).err()).collect();
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// The same on the borders of one solid, whose genus must be `genus`; `name` names its faces.
pub fn check_borders(index: usize, borders: &Borders, genus: i64, name: impl Fn(usize) -> String) -> Result<(), BrepError> {
    loops(index, borders, name)?;
    edge_uses(index, borders)?;
    euler(index, borders, genus)?;
    one_shell(index, borders)
}

/// Every face has one loop, and each edge of a loop starts where the one before ends.
pub fn loops(index: usize, borders: &Borders, name: impl Fn(usize) -> String) -> Result<(), BrepError> {
    let is_open = |&f: &usize| {
        let boundary = borders.boundary(f);
        let meets = |k: usize| borders.ends(boundary[k])[1] == borders.ends(boundary[(k + 1) % boundary.len()])[0];
        boundary.is_empty() || !(0..boundary.len()).all(meets)
    };
    match (0..borders.face_count()).find(is_open) {
        Some(face) => Err(BrepError::OpenLoop { solid: index, face: name(face) }),
        None => Ok(()),
    }
}

/// Every edge is used twice, in opposite senses (by two faces, or twice by one: a seam).
pub fn edge_uses(index: usize, borders: &Borders) -> Result<(), BrepError> {
    let mut uses = vec![[0u8; 2]; borders.edges.len()];
    for e in &borders.uses {
        let count = &mut uses[e.edge as usize][e.forward as usize];
        *count = count.saturating_add(1);
    }
    match uses.iter().position(|&u| u != [1, 1]) {
        Some(edge) => {
            let [backward, forward] = uses[edge].map(usize::from);
            Err(BrepError::EdgeUse { solid: index, edge, forward, backward })
        }
        None => Ok(()),
    }
}

/// V - E + F = 2 (1 - g), g = struts - nodes + 1: the skin over a graph is a sphere with one
/// handle per independent ring of struts. Every face is a disc (cylinders are cut by their seam,
/// caps by nothing), and no edge is without a vertex, so the count is that of a cell complex.
pub fn euler(index: usize, borders: &Borders, genus: i64) -> Result<(), BrepError> {
    let counts = Counts { vertices: borders.vertex_count, edges: borders.edges.len(), faces: borders.face_count() };
    let (found, wanted) = (counts.euler(), 2 * (1 - genus));
    if found == wanted { Ok(()) } else { Err(BrepError::Euler { solid: index, found, wanted }) }
}

/// One connected shell, and around each vertex one ring of faces: no vertex where two cones of faces touch, none without edges.
pub fn one_shell(index: usize, borders: &Borders) -> Result<(), BrepError> {
    let (_, islands) = walk(borders);
    if islands != 1 {
        return Err(BrepError::Islands { solid: index, islands });
    }
    // Around a vertex, ends of edges follow each other from face to face: as many rings as vertices.
    let mut ring: Vec<u32> = (0..2 * borders.edges.len() as u32).collect();
    let mut rings = ring.len();
    for face in 0..borders.face_count() {
        let boundary = borders.boundary(face);
        for (k, e) in boundary.iter().enumerate() {
            let next = boundary[(k + 1) % boundary.len()];
            let [a, b] = [2 * e.edge + e.forward as u32, 2 * next.edge + !next.forward as u32].map(|end| root(&mut ring, end));
            rings -= (a != b) as usize;
            ring[a.max(b) as usize] = a.min(b);
        }
    }
    if rings == borders.vertex_count { Ok(()) } else { Err(BrepError::Pinched { solid: index, rings, vertices: borders.vertex_count }) }
}

/// The root of an element's tree; halves the path on the way.
fn root(parent: &mut [u32], mut at: u32) -> u32 {
    while parent[at as usize] != at {
        parent[at as usize] = parent[parent[at as usize] as usize];
        at = parent[at as usize];
    }
    at
}

/// All faces, breadth first over shared edges from the first face on: each but the first of a
/// connected shell shares an edge with one before it.
pub fn connected_order(borders: &Borders) -> Vec<u32> {
    walk(borders).0
}

/// That order, and how often it had to start anew.
fn walk(borders: &Borders) -> (Vec<u32>, usize) {
    let mut of_edge: Vec<[u32; 2]> = vec![[u32::MAX; 2]; borders.edges.len()];
    for f in 0..borders.face_count() {
        for e in borders.boundary(f) {
            of_edge[e.edge as usize][e.forward as usize] = f as u32;
        }
    }
    let mut seen = vec![false; borders.face_count()];
    let mut order: Vec<u32> = Vec::with_capacity(borders.face_count());
    let mut islands = 0;
    for start in 0..borders.face_count() {
        let mut next = order.len();
        if !std::mem::replace(&mut seen[start], true) {
            order.push(start as u32);
            islands += 1;
        }
        while next < order.len() {
            for &f in borders.boundary(order[next] as usize).iter().flat_map(|e| &of_edge[e.edge as usize]) {
                if f != u32::MAX && !std::mem::replace(&mut seen[f as usize], true) {
                    order.push(f);
                }
            }
            next += 1;
        }
    }
    (order, islands)
}
