//! Weld: nodes nearer than a tolerance become one.
//!
//! Greedy, not transitive: in the order of ids, a node that is further than the tolerance from all heads becomes a head; every other
//! node goes into its nearest head (of equals the first). So no node moves further than the tolerance, heads stay where they are and
//! are further than the tolerance apart, and a chain of close nodes does not shrink to a point.
//! Struts that end up with both ends in one node, or beside another, are dropped.

use super::record::{Draft, Repair, Step};
use crate::graph::{Input, check};
use crate::ids::NodeId;
use glam::DVec3;
use std::collections::HashMap;

/// Nodes at most `tolerance` (mm, above 0) apart become one.
pub fn weld(input: &Input, tolerance: f64) -> (Input, Repair) {
    let mut grid = Grid { edge: tolerance, cells: HashMap::new() };
    let nodes = &input.nodes;
    let usable = || (0..nodes.len()).filter(|&n| check::is_usable(nodes[n]));
    for n in usable() {
        if grid.nearest(nodes, nodes[n]).is_none() {
            grid.cells.entry(grid.cell(nodes[n])).or_default().push(NodeId(n as u32));
        }
    }
    let mut head: Vec<NodeId> = (0..nodes.len() as u32).map(NodeId).collect();
    for n in usable() {
        head[n] = grid.nearest(nodes, nodes[n]).expect("a node that is no head is near one");
    }
    let mut draft = Draft::new(input);
    draft.join(|n| head[n.index()]);
    draft.finish(Step::Weld, tolerance)
}

/// Heads by cubes as wide as the tolerance: those near a point are in its cube or beside it.
struct Grid {
    edge: f64,
    cells: HashMap<[i64; 3], Vec<NodeId>>,
}

impl Grid {
    fn cell(&self, p: DVec3) -> [i64; 3] {
        p.to_array().map(|x| (x / self.edge).floor() as i64)
    }

    /// The nearest head within the tolerance; of equals the first.
    fn nearest(&self, nodes: &[DVec3], p: DVec3) -> Option<NodeId> {
        let [x, y, z] = self.cell(p);
        let beside = |x: i64| x.saturating_sub(1)..=x.saturating_add(1);
        let cubes = beside(x).flat_map(|x| beside(y).flat_map(move |y| beside(z).map(move |z| [x, y, z])));
        let heads = cubes.filter_map(|cube| self.cells.get(&cube)).flatten();
        let near = heads.map(|&head| (nodes[head.index()].distance(p), head)).filter(|(distance, _)| *distance <= self.edge);
        near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, head)| head)
    }
}
