//! Drop loose parts: connected parts of little volume beside the largest, and nodes without struts.
//!
//! Volume of a part: the sum over its struts of that of the truncated cone from node to node; what overlaps counts twice.
//! A part with less than the given share of the largest part's volume is dropped. Share 1 keeps just the largest and its equals.

use super::record::{Draft, Fate, Repair, Step, Why};
use crate::graph::components::split;
use crate::graph::{Input, Strut, check};
use crate::ids::NodeId;

/// Share of the largest part's volume below which a part is loose, where none is given. Reason: scraps that a crop or a trim leaves
/// have a strut or two, a hundredth of any part that is worth building; bodies meant to be there are not that unequal. Guessed.
pub const LOOSE: f64 = 0.01;

/// Parts of less volume than `share` (in (0, 1]) of the largest part's are dropped, and nodes without struts.
pub fn drop_loose(input: &Input, share: f64) -> (Input, Repair) {
    let mut draft = Draft::new(input);
    let in_range = |s: &Strut| s.a.index().max(s.b.index()) < input.nodes.len();
    let ids: Vec<usize> = (0..input.struts.len()).filter(|&k| in_range(&input.struts[k])).collect();
    let struts: Vec<Strut> = ids.iter().map(|&k| input.struts[k]).collect();
    let parts = split(input.nodes.len(), &struts);
    let mut volumes = vec![0.0; parts.count()];
    for (s, part) in struts.iter().zip(&parts.of_strut) {
        volumes[part.index()] += volume(input, s);
    }
    // A part whose volume is not a number stays, for the checks to tell why.
    let least = share * volumes.iter().copied().fold(0.0, f64::max);
    let loose: Vec<bool> = volumes.iter().map(|&v| v < least).collect();
    for (&k, part) in ids.iter().zip(&parts.of_strut) {
        if loose[part.index()] {
            draft.fates[k] = Fate::Gone { into: None, why: Why::Loose };
        }
    }
    let mut held = vec![false; input.nodes.len()];
    for s in input.struts.iter().filter(|s| !in_range(s)) {
        [s.a, s.b].into_iter().filter(|n| n.index() < input.nodes.len()).for_each(|n| held[n.index()] = true);
    }
    for (n, part) in parts.of_node.iter().enumerate() {
        if part.is_none_or(|part| loose[part.index()]) && !held[n] && check::is_usable(input.nodes[n]) {
            draft.drop_node(NodeId(n as u32));
        }
    }
    draft.finish(Step::DropLoose, share)
}

/// Volume of a strut from node to node (mm³).
fn volume(input: &Input, s: &Strut) -> f64 {
    let length = input.nodes[s.a.index()].distance(input.nodes[s.b.index()]);
    s.volume(length)
}
