//! Checks of a solid's topology: loops, edge uses, truck's own opinion, and the Euler number.

use super::error::BrepError;
use super::model::{Model, Solid};
use truck_topology::{Edge, Face, Shell, Solid as TruckSolid, Vertex, Wire};

/// Vertices, edges and faces of one solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Counts {
    pub vertices: usize,
    pub edges: usize,
    pub faces: usize,
}

impl Counts {
    pub fn of(solid: &Solid) -> Self {
        let shell = solid.shell();
        Counts { vertices: shell.vertices.len(), edges: shell.edges.len(), faces: shell.faces.len() }
    }

    /// V - E + F
    pub fn euler(self) -> i64 {
        self.vertices as i64 - self.edges as i64 + self.faces as i64
    }
}

/// All topological checks on all solids; one fault a solid at most, the first.
pub fn check_topology(model: &Model) -> Result<(), Vec<BrepError>> {
    let check = |(index, solid): (usize, &Solid)| {
        loops(index, solid)?;
        edge_uses(index, solid)?;
        euler(index, solid)?;
        accepted_by_truck(index, solid)
    };
    let faults: Vec<_> = model.solids.iter().enumerate().filter_map(|s| check(s).err()).collect();
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Every face has one loop, and each edge of a loop starts where the one before ends.
pub fn loops(index: usize, solid: &Solid) -> Result<(), BrepError> {
    let shell = solid.shell();
    for (face, label) in shell.faces.iter().zip(&solid.labels) {
        let open = BrepError::OpenLoop { solid: index, face: label.to_string() };
        let [boundary] = &face.boundaries[..] else { return Err(open) };
        let ends = |k: usize| {
            let e = boundary[k % boundary.len()];
            let (front, back) = shell.edges[e.index].vertices;
            if e.orientation { (front, back) } else { (back, front) }
        };
        if boundary.is_empty() || (0..boundary.len()).any(|k| ends(k).1 != ends(k + 1).0) {
            return Err(open);
        }
    }
    Ok(())
}

/// Every edge is used twice, in opposite senses (by two faces, or twice by one: a seam).
pub fn edge_uses(index: usize, solid: &Solid) -> Result<(), BrepError> {
    let shell = solid.shell();
    let mut uses = vec![[0usize; 2]; shell.edges.len()];
    for e in shell.faces.iter().flat_map(|f| &f.boundaries).flatten() {
        uses[e.index][e.orientation as usize] += 1;
    }
    match uses.iter().position(|&u| u != [1, 1]) {
        Some(edge) => {
            let [backward, forward] = uses[edge];
            Err(BrepError::EdgeUse { solid: index, edge, forward, backward })
        }
        None => Ok(()),
    }
}

/// V - E + F = 2 (1 - g), g = struts - nodes + 1: the skin over a graph is a sphere with one
/// handle per independent ring of struts. Every face is a disc (cylinders are cut by their seam,
/// caps by nothing), and no edge is without a vertex, so the count is that of a cell complex.
pub fn euler(index: usize, solid: &Solid) -> Result<(), BrepError> {
    let genus = solid.struts.len() as i64 - solid.nodes.len() as i64 + 1;
    let (found, wanted) = (Counts::of(solid).euler(), 2 * (1 - genus));
    if found == wanted { Ok(()) } else { Err(BrepError::Euler { solid: index, found, wanted }) }
}

/// truck's `Solid` accepts the shell: not empty, connected, closed and oriented, and no vertex
/// where two cones of faces touch. Faces are built unchecked, since truck's face forbids seams and
/// closed edges; `loops` stands in for that. Topology alone is handed over, no geometry.
pub fn accepted_by_truck(index: usize, solid: &Solid) -> Result<(), BrepError> {
    let shell = solid.shell();
    let vertices: Vec<Vertex<()>> = shell.vertices.iter().map(|_| Vertex::new(())).collect();
    let edge = |(front, back): (usize, usize)| Edge::new_unchecked(&vertices[front], &vertices[back], ());
    let edges: Vec<Edge<(), ()>> = shell.edges.iter().map(|e| edge(e.vertices)).collect();
    let faces = shell.faces.iter().map(|face| {
        let wires = face.boundaries.iter().map(|boundary| {
            let oriented = |e: &truck_topology::compress::CompressedEdgeIndex| {
                if e.orientation { edges[e.index].clone() } else { edges[e.index].inverse() }
            };
            boundary.iter().map(oriented).collect::<Wire<(), ()>>()
        });
        Face::new_unchecked(wires.collect(), ())
    });
    let shell: Shell<(), (), ()> = faces.collect();
    match TruckSolid::try_new(vec![shell]) {
        Ok(_) => Ok(()),
        Err(reason) => Err(BrepError::Truck { solid: index, reason: reason.to_string() }),
    }
}

/// All faces, breadth first over shared edges from the first face on: each but the first of a
/// connected shell shares an edge with one before it.
pub fn connected_order(solid: &Solid) -> Vec<usize> {
    let shell = solid.shell();
    let loops = |f: usize| shell.faces[f].boundaries.iter().flatten();
    let mut of_edge: Vec<[usize; 2]> = vec![[usize::MAX; 2]; shell.edges.len()];
    for f in 0..shell.faces.len() {
        for e in loops(f) {
            of_edge[e.index][e.orientation as usize] = f;
        }
    }
    let mut seen = vec![false; shell.faces.len()];
    let mut order: Vec<usize> = Vec::with_capacity(shell.faces.len());
    for start in 0..shell.faces.len() {
        let mut next = order.len();
        if !std::mem::replace(&mut seen[start], true) {
            order.push(start);
        }
        while next < order.len() {
            for &f in loops(order[next]).flat_map(|e| &of_edge[e.index]) {
                if f != usize::MAX && !std::mem::replace(&mut seen[f], true) {
                    order.push(f);
                }
            }
            next += 1;
        }
    }
    order
}
