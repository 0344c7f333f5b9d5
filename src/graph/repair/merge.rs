//! Merge: where cuts do not fit, nodes become one; struts at a node that run closer than an angle become one.
//!
//! Until nothing is left to do:
//!
//! 1. Angles. Two struts n-c and n-b (c the nearer node) closer than the limit run together as far as c: n-b becomes c-b, and n-c takes
//!    the larger radius. The closest pairs first, each strut once a round. With angles below 60° struts only get shorter.
//! 2. Nodes, once no angle is left: the two nodes of a strut that no cuts fit, and two nodes without a strut whose balls (the largest
//!    radius at the node) touch. The nearest pairs first. After a merge its node and all nodes beside it wait until conflicts have been
//!    asked for again. The new node is at the mean of all nodes that went into it; it has the smallest of their ids.
//!
//! Struts with both ends in one node are dropped, and of struts between the same nodes all but the first, which takes the largest radii.
//! Every round leaves fewer nodes or less strut length, so it ends. What it does to the shape is the price of the policy: read the record.
//!
//! No merge goes far: any two nodes that go into one reach each other, `|p - q| <= reach_p + reach_q`, all as it was in the lattice given. A pair
//! that this keeps apart stays; a strut that no cuts fit and that has to stay for this reason is `Stuck`.

use super::record::{Draft, Fate, Repair, Step};
use crate::error::Fault;
use crate::graph::proximity::{self, Body};
use crate::graph::{Graph, Input, Strut};
use crate::ids::{NodeId, StrutId};
use std::collections::HashSet;

/// Struts closer than this become one where no angle is given, degrees. Reason: at 5° a cut is 23 radii long. Guessed.
pub const MERGE_ANGLE: f64 = 5.0;
/// The angle has to be below this, degrees. Reason: at 60° and more a rerouted strut need not be shorter.
pub const LARGEST_ANGLE: f64 = 60.0;

/// What the cuts say of a graph.
pub struct Fit {
    /// The struts that no cuts fit.
    pub conflicts: Vec<StrutId>,
    /// How far each node reaches, by `NodeId` (mm): no less than its struts' largest radius.
    pub reach: Vec<f64>,
}

/// A strut that no cuts fit and whose nodes may not become one. All in the ids before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stuck {
    pub strut: StrutId,
    /// Two nodes that would go into one and do not reach each other: those that lack most.
    pub nodes: [NodeId; 2],
    /// Distance between them, and how far they reach together (mm).
    pub distance: f64,
    pub reach: f64,
}

impl Stuck {
    /// As a fault of the strut.
    pub fn fault(&self) -> Fault {
        let [a, b] = self.nodes.map(|n| n.0);
        let found = format!("no cuts that fit, and to merge its nodes would join nodes {a} and {b}, {:.6} mm apart", self.distance);
        Fault::new(format!("struts[{}]", self.strut.0), found, format!("nodes within the {:.6} mm that their cuts reach", self.reach))
    }
}

/// A merged lattice, its record, and what could not be merged.
pub struct Merged {
    pub input: Input,
    pub repair: Repair,
    /// By strut.
    pub stuck: Vec<Stuck>,
}

/// Merge until no struts at a node are closer than `angle` (degrees, below 60) and no nodes are left that have to become one and may.
/// `fit` is asked again after every change; it must depend on its graph alone. Nodes without struts keep their ids in that graph.
pub fn merge(input: &Input, angle: f64, fit: &dyn Fn(&Graph) -> Fit) -> Merged {
    let mut state = State { draft: Draft::new(input), groups: (0..input.nodes.len() as u32).map(|n| vec![NodeId(n)]).collect(), reach: Vec::new() };
    state.reach = fit(&state.graph().0).reach;
    loop {
        let (graph, ids) = state.graph();
        if state.merge_angles(&graph, &ids, angle.to_radians()) {
            continue;
        }
        let conflicts = fit(&graph).conflicts;
        if !state.merge_nodes(&graph, &conflicts) {
            let stuck = conflicts.iter().filter_map(|&k| state.stuck(&graph, &ids, k)).collect();
            let (input, repair) = state.draft.finish(Step::Merge, angle);
            return Merged { input, repair, stuck };
        }
    }
}

struct State<'a> {
    draft: Draft<'a>,
    /// The nodes, as given, that went into each.
    groups: Vec<Vec<NodeId>>,
    /// How far each node reached in the lattice given (mm).
    reach: Vec<f64>,
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

    fn merge_nodes(&mut self, graph: &Graph, conflicts: &[StrutId]) -> bool {
        let at = |n: NodeId| graph.nodes()[n.index()];
        let mut pairs: Vec<(NodeId, NodeId)> = conflicts.iter().map(|&k| ends(graph, k)).chain(touching_nodes(graph)).collect();
        pairs.retain(|&(a, b)| self.out_of_reach(a, b).is_none());
        pairs.sort_by(|&p, &q| at(p.0).distance(at(p.1)).total_cmp(&at(q.0).distance(at(q.1))).then(p.cmp(&q)));
        let mut into: Vec<NodeId> = graph.node_ids().collect();
        let mut waits = vec![false; into.len()];
        for &(a, b) in &pairs {
            if waits[a.index()] || waits[b.index()] {
                continue;
            }
            for n in [a, b] {
                waits[n.index()] = true;
                graph.arms(n).iter().for_each(|&arm| waits[graph.far(arm).index()] = true);
            }
            into[b.index()] = a;
            let joined = std::mem::take(&mut self.groups[b.index()]);
            let share = joined.len() as f64 / (joined.len() + self.groups[a.index()].len()) as f64;
            self.draft.at[a.index()] = at(a).lerp(at(b), share);
            self.groups[a.index()].extend(joined);
        }
        self.draft.join(|n| into[n.index()]);
        !pairs.is_empty()
    }

    /// The two nodes of both groups that lack most to reach each other, their distance and how far they reach (mm); none if all do.
    fn out_of_reach(&self, a: NodeId, b: NodeId) -> Option<([NodeId; 2], f64, f64)> {
        let at = |n: NodeId| self.draft.given().nodes[n.index()];
        let pairs = self.groups[a.index()].iter().flat_map(|&p| self.groups[b.index()].iter().map(move |&q| [p, q]));
        let measured = pairs.map(|[p, q]| ([p, q], at(p).distance(at(q)), self.reach[p.index()] + self.reach[q.index()]));
        measured.filter(|(_, distance, reach)| distance > reach).max_by(|x, y| (x.1 - x.2).total_cmp(&(y.1 - y.2)))
    }

    fn stuck(&self, graph: &Graph, ids: &[usize], strut: StrutId) -> Option<Stuck> {
        let (a, b) = ends(graph, strut);
        let (nodes, distance, reach) = self.out_of_reach(a, b)?;
        Some(Stuck { strut: StrutId(ids[strut.index()] as u32), nodes, distance, reach })
    }
}

/// The nodes of a strut, the smaller id first.
fn ends(graph: &Graph, strut: StrutId) -> (NodeId, NodeId) {
    let s = &graph.struts()[strut.index()];
    (s.a.min(s.b), s.a.max(s.b))
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

/// Nodes without a strut between them whose balls touch, the smaller id first.
fn touching_nodes(graph: &Graph) -> Vec<(NodeId, NodeId)> {
    let ball = |n: NodeId| {
        let (radius, at) = (graph.largest_radius(n), graph.nodes()[n.index()]);
        // a ball in place of a strut: its id is the node's
        Body { strut: StrutId(n.0), ends: [n.0; 2], p: at, q: at, radii: [radius; 2] }
    };
    let balls: Vec<Body> = graph.used_nodes().map(ball).collect();
    let joined = |a: NodeId, b: NodeId| graph.arms(a).iter().any(|&arm| graph.far(arm) == b);
    let pairs = proximity::among(&balls).into_iter().map(|m| (NodeId(m.a.0), NodeId(m.b.0)));
    pairs.filter(|&(a, b)| !joined(a, b)).collect()
}
