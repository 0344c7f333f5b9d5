//! A lattice in blocks: neighbouring nodes with the struts between them are solids of their own; a strut that leads to another block is
//! closed by a disc in the middle of its visible part, the same in both blocks to the bit: circle, start and end of the seam.
//!
//! Neighbours touch in coincident discs. All else is, bit for bit, what it is in the one solid.

use super::assemble::{AssembleOptions, Caps, solids};
use super::error::BrepError;
use super::model::Model;
use crate::graph::Graph;
use crate::graph::components::apart;
use crate::ids::NodeId;
use crate::math::halves::split;
use crate::patch::Shelved;
use glam::DVec3;
use std::ops::Range;

/// The solids of so many blocks (1 to the number of nodes with struts), one for each connected part of a block, and which solids each block has.
/// Nodes are halved again and again, across the longest side of the box around them.
pub fn blocks(graph: &Graph, skins: &[Option<Shelved>], options: &AssembleOptions, count: usize) -> Result<(Model, Vec<Range<usize>>), Vec<BrepError>> {
    let nodes: Vec<NodeId> = graph.used_nodes().collect();
    let places: Vec<DVec3> = nodes.iter().map(|n| graph.nodes()[n.index()]).collect();
    let mut block_of = vec![0; graph.nodes().len()];
    let mut next = 0;
    split(&mut (0..nodes.len()).collect::<Vec<_>>(), &places, count, &mut |block| {
        block.iter().for_each(|&k| block_of[nodes[k].index()] = next);
        next += 1;
    });
    let parts = apart(graph, &block_of);
    let ends: Vec<usize> = (0..next).map(|b| parts.partition_point(|part| block_of[part.nodes[0].index()] <= b)).collect();
    let model = solids(graph, skins, parts, &|_| options.caps == Caps::Sphere)?;
    let ranges = ends.iter().enumerate().map(|(b, &end)| if b == 0 { 0..end } else { ends[b - 1]..end });
    Ok((model, ranges.collect()))
}
