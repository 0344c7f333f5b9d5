//! Merge: where cuts do not fit, nodes become one; struts at a node that run closer than an angle become one.
//!
//! Until nothing is left to do:
//!
//! 1. Angles. Two struts n-c and n-b (c the nearer node) closer than the limit run together as far as c: n-b becomes c-b, and n-c takes
//!    the larger radius. The closest pairs first, each strut once a round. With angles below 60° struts only get shorter.
//! 2. Nodes, once no angle is left: the two nodes of a strut that its cuts do not fit, and two nodes without a strut whose balls (the
//!    largest radius at the node) touch. The worst pairs first, each node once a round. The new node is at the mean of all nodes
//!    that went into it; it has the smallest of their ids.
//!
//! Struts with both ends in one node are dropped, and of struts between the same nodes all but the first, which takes the largest radii.
//! Every round leaves fewer nodes or less strut length, so it ends. What it does to the shape is the price of the policy: read the record.

use super::record::{Draft, Fate, Repair, Step};
use crate::graph::proximity::{self, Body};
use crate::graph::{Graph, Input, Strut};
use crate::ids::{NodeId, StrutId};
use std::collections::HashSet;

/// Struts closer than this become one where no angle is given, degrees. Reason: at 5° a cut is 23 radii long. Guessed.
pub const MERGE_ANGLE: f64 = 5.0;
/// The angle has to be below this, degrees. Reason: at 60° and more a rerouted strut need not be shorter.
pub const LARGEST_ANGLE: f64 = 60.0;

/// A strut whose cuts do not fit, and by how much: the length they want over the length there is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conflict {
    pub strut: StrutId,
    pub excess: f64,
}

/// Merge until no struts at a node are closer than `angle` (degrees, below 60), `conflicts` finds no strut, and no nodes touch.
/// `conflicts` is asked again after every change; it must depend on its graph alone. Nodes without struts keep their ids in that graph.
pub fn merge(input: &Input, angle: f64, conflicts: &dyn Fn(&Graph) -> Vec<Conflict>) -> (Input, Repair) {
    let mut state = State { draft: Draft::new(input), weight: vec![1.0; input.nodes.len()] };
    loop {
        let (graph, ids) = state.graph();
        if !state.merge_angles(&graph, &ids, angle.to_radians()) && !state.merge_nodes(&graph, &conflicts(&graph)) {
            return state.draft.finish(Step::Merge, angle);
        }
    }
}

struct State<'a> {
    draft: Draft<'a>,
    /// How many nodes went into each.
    weight: Vec<f64>,
}

impl State<'_> {
    /// The sound struts as they are now, in the nodes' old ids, and their old ids.
    fn graph(&self) -> (Graph, Vec<usize>) {
        let (ids, struts) = (0..self.draft.fates.len()).filter_map(|k| Some((k, self.draft.sound(k)?))).unzip();
        (Graph::new(self.draft.at.clone(), struts), ids)
    }

    fn merge_angles(&mut self, graph: &Graph, ids: &[usize], limit: f64) -> bool {
        let mut pairs = close_pairs(graph, limit);
        pairs.sort_by(|p, q| p.angle.total_cmp(&q.angle).then((p.node, p.near, p.far).cmp(&(q.node, q.near, q.far))));
        let mut touched = HashSet::new();
        for p in &pairs {
            if touched.contains(&p.near) || touched.contains(&p.far) {
                continue;
            }
            touched.extend([p.near, p.far]);
            let (near, far) = (graph.struts()[p.near.index()], graph.struts()[p.far.index()]);
            let ((c, near_n, near_c), (b, r_n, r_b)) = (seen(&near, p.node), seen(&far, p.node));
            let t = p.angle.cos() * graph.length(p.near) / graph.length(p.far);
            let r_c = r_n + t * (r_b - r_n);
            let widened = laid(&near, p.node, [p.node, c], [near_n.max(r_n), near_c.max(r_c)]);
            self.draft.fates[ids[p.near.index()]] = Fate::Stays(widened);
            self.draft.fates[ids[p.far.index()]] = Fate::Stays(laid(&far, p.node, [c, b], [r_c, r_b]));
        }
        self.draft.drop_loops_and_twins();
        !pairs.is_empty()
    }

    fn merge_nodes(&mut self, graph: &Graph, conflicts: &[Conflict]) -> bool {
        let ends = |k: StrutId| (graph.struts()[k.index()].a, graph.struts()[k.index()].b);
        let mut pairs: Vec<(f64, NodeId, NodeId)> = conflicts.iter().map(|c| (c.excess, ends(c.strut).0, ends(c.strut).1)).collect();
        pairs.extend(touching_nodes(graph));
        pairs.iter_mut().for_each(|p| (p.1, p.2) = (p.1.min(p.2), p.1.max(p.2)));
        pairs.sort_by(|p, q| q.0.total_cmp(&p.0).then((p.1, p.2).cmp(&(q.1, q.2))));
        let mut into: Vec<NodeId> = graph.node_ids().collect();
        let mut touched = vec![false; into.len()];
        for &(_, a, b) in &pairs {
            if touched[a.index()] || touched[b.index()] {
                continue;
            }
            (touched[a.index()], touched[b.index()]) = (true, true);
            into[b.index()] = a;
            let total = self.weight[a.index()] + self.weight[b.index()];
            self.draft.at[a.index()] = self.draft.at[a.index()].lerp(self.draft.at[b.index()], self.weight[b.index()] / total);
            self.weight[a.index()] = total;
        }
        self.draft.join(|n| into[n.index()]);
        !pairs.is_empty()
    }
}

/// Two struts at one node: the one to the nearer node, and the other.
struct ClosePair {
    angle: f64,
    node: NodeId,
    near: StrutId,
    far: StrutId,
}

/// A strut seen from one of its nodes: the other node, and the radii here and there.
fn seen(s: &Strut, node: NodeId) -> (NodeId, f64, f64) {
    if s.a == node { (s.b, s.ra, s.rb) } else { (s.a, s.rb, s.ra) }
}

/// The strut with other ends and radii, given as seen from this node of its own, in its own direction.
fn laid(s: &Strut, node: NodeId, [from, to]: [NodeId; 2], [r_from, r_to]: [f64; 2]) -> Strut {
    if s.a == node { Strut { a: from, b: to, ra: r_from, rb: r_to } } else { Strut { a: to, b: from, ra: r_to, rb: r_from } }
}

/// All pairs of struts at one node closer than the limit (radians).
fn close_pairs(graph: &Graph, limit: f64) -> Vec<ClosePair> {
    let mut pairs = Vec::new();
    for node in graph.used_nodes() {
        let arms = graph.arms(node);
        let along: Vec<_> = arms.iter().map(|&arm| (graph.nodes()[graph.far(arm).index()] - graph.nodes()[node.index()]).normalize()).collect();
        for (i, j) in (0..arms.len()).flat_map(|j| (0..j).map(move |i| (i, j))) {
            let angle = along[i].cross(along[j]).length().atan2(along[i].dot(along[j]));
            if angle < limit {
                let (first, second) = (arms[i].strut, arms[j].strut);
                let (near, far) = if graph.length(second) < graph.length(first) { (second, first) } else { (first, second) };
                pairs.push(ClosePair { angle, node, near, far });
            }
        }
    }
    pairs
}

/// Nodes without a strut between them whose balls touch, and the sum of their radii over their distance.
fn touching_nodes(graph: &Graph) -> Vec<(f64, NodeId, NodeId)> {
    let ball = |n: NodeId| {
        let radius = graph.arms(n).iter().map(|&arm| graph.radius(arm)).fold(0.0, f64::max);
        let at = graph.nodes()[n.index()];
        // a ball in place of a strut: its id is the node's
        Body { strut: StrutId(n.0), ends: [n.0; 2], p: at, q: at, radii: [radius; 2] }
    };
    let balls: Vec<Body> = graph.used_nodes().map(ball).collect();
    let joined = |a: NodeId, b: NodeId| graph.arms(a).iter().any(|&arm| graph.far(arm) == b);
    let pairs = proximity::among(&balls).into_iter().map(|m| (m.wanted / m.distance, NodeId(m.a.0), NodeId(m.b.0)));
    pairs.filter(|&(_, a, b)| !joined(a, b)).collect()
}
