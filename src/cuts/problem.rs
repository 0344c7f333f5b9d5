//! All strut ends of a graph, the angles between them, and what binds their cuts.
//!
//! Unknown: the cap ρ_e of each strut end e (radians). Bounds: at a node ρ_i + ρ_j <= Θ_ij; on a strut
//! d_a(ρ_a) + d_b(ρ_b) <= room; ρ_e <= the cap of the least cut. Each binds two unknowns at most.

use super::cone::Cone;
use super::preferred::{self, LEAST_ROOM, shared};
use crate::graph::{Arm, End, Graph};
use crate::ids::{NodeId, StrutId};
use crate::math::angle;
use glam::DVec3;
use rayon::prelude::*;

/// Caps together take at most this much less than the angle between their struts. Reason: sectors between two rims are then at
/// least 4 % of the angle wide; for two equal struts 60° apart that is λ = 0.05, a sixth of the usual. Guessed.
pub const MARGIN: f64 = 0.04;

/// Least free length of a strut between its rims, as a part of its length. Reason: a face of a strut must be wider than
/// readers' tolerances (1e-5 of the part in OCC at worst), and a thousandth is lost on nobody. Guessed.
pub const FREE: f64 = 1e-3;

/// Caps and cuts are settled to this (radians; and as a part of the strut's length). Reason: far below `MARGIN` of the least
/// angle in use (0.3°: 2e-4 rad), far above round-off.
pub const SETTLED: f64 = 1e-8;

/// An index of strut ends: strut k has ends 2k (at `a`) and 2k + 1 (at `b`).
pub type EndIndex = usize;

/// The other end of the same strut.
pub fn across(e: EndIndex) -> EndIndex {
    e ^ 1
}

pub fn index(arm: Arm) -> EndIndex {
    2 * arm.strut.index() + arm.end as usize
}

pub fn end_of(e: EndIndex) -> (StrutId, End) {
    (StrutId((e / 2) as u32), if e % 2 == 0 { End::A } else { End::B })
}

/// All vectors but the last three are indexed by strut end.
pub struct Problem {
    pub cones: Vec<Cone>,
    /// Preferred cut (mm).
    pub preferred: Vec<f64>,
    /// Cut with almost touching caps (mm): where all ends of a node have at least this, no caps overlap.
    pub touching: Vec<f64>,
    /// Angle left to a pair of caps (radians), for each end: one value for each arm of its node.
    pairs: Vec<f64>,
    first_pair: Vec<usize>,
    /// Node of the end.
    pub node: Vec<NodeId>,
    /// Ends at each node, in the order of its arms: `ends[first[n]..first[n + 1]]`.
    ends: Vec<EndIndex>,
    first: Vec<usize>,
    /// Length of each strut that its two cuts may take together (mm).
    pub room: Vec<f64>,
}

/// What is found node by node: cut and touching cut of each arm, and the angle left to each pair.
struct AtNode {
    preferred: Vec<f64>,
    touching: Vec<f64>,
    pairs: Vec<f64>,
}

impl Problem {
    pub fn new(graph: &Graph, lambda: f64) -> Problem {
        let count = 2 * graph.struts().len();
        let mut cones = vec![Cone { r: 0.0, k: 0.0 }; count];
        let mut node = vec![NodeId(0); count];
        let mut room = Vec::with_capacity(count / 2);
        for (k, s) in graph.struts().iter().enumerate() {
            let length = graph.length(StrutId(k as u32));
            [cones[2 * k], cones[2 * k + 1]] = Cone::pair([s.ra, s.rb], length);
            node[2 * k] = s.a;
            node[2 * k + 1] = s.b;
            room.push(length * (1.0 - FREE));
        }
        let nodes: Vec<NodeId> = graph.node_ids().collect();
        let found: Vec<AtNode> = nodes.par_iter().map(|&n| at_node(graph, n, &cones, lambda)).collect();
        let mut p = Problem {
            cones,
            node,
            room,
            preferred: vec![0.0; count],
            touching: vec![0.0; count],
            pairs: Vec::with_capacity(found.iter().map(|f| f.pairs.len()).sum()),
            first_pair: vec![0; count],
            ends: Vec::with_capacity(count),
            first: vec![0],
        };
        for (&n, found) in nodes.iter().zip(found) {
            let degree = graph.degree(n);
            for (i, &arm) in graph.arms(n).iter().enumerate() {
                let e = index(arm);
                p.preferred[e] = found.preferred[i];
                p.touching[e] = found.touching[i];
                p.first_pair[e] = p.pairs.len() + i * degree;
                p.ends.push(e);
            }
            p.pairs.extend(found.pairs);
            p.first.push(p.ends.len());
        }
        p
    }

    /// The ends at a node.
    pub fn ends_at(&self, node: NodeId) -> &[EndIndex] {
        &self.ends[self.first[node.index()]..self.first[node.index() + 1]]
    }

    /// The other ends at the node of `e`, each with the angle left to its cap and that of `e` (radians).
    pub fn beside(&self, e: EndIndex) -> impl Iterator<Item = (EndIndex, f64)> {
        let ends = self.ends_at(self.node[e]);
        let pairs = &self.pairs[self.first_pair[e]..][..ends.len()];
        ends.iter().copied().zip(pairs.iter().copied()).filter(move |&(j, _)| j != e)
    }

    /// A free end: its strut is the only one at its node, and is not cut.
    pub fn is_free(&self, e: EndIndex) -> bool {
        self.ends_at(self.node[e]).len() == 1
    }

    /// Cut of an end (mm) for its cap (radians).
    pub fn cut(&self, e: EndIndex, cap: f64) -> f64 {
        if self.is_free(e) { 0.0 } else { self.cones[e].cut(cap) }
    }

    /// Cap of an end (radians) for its cut (mm).
    pub fn cap(&self, e: EndIndex, cut: f64) -> f64 {
        self.cones[e].cap(cut)
    }

    /// Least cut of an end (mm).
    pub fn least(&self, e: EndIndex) -> f64 {
        if self.is_free(e) { 0.0 } else { LEAST_ROOM * self.cones[e].r }
    }

    /// Number of struts.
    pub fn struts(&self) -> usize {
        self.room.len()
    }

    /// Give a strut other radii at its ends a and b (mm). What was found at its nodes stays.
    pub fn set_radii(&mut self, strut: usize, radii: [f64; 2]) {
        let length = self.room[strut] / (1.0 - FREE);
        [self.cones[2 * strut], self.cones[2 * strut + 1]] = Cone::pair(radii, length);
    }

    /// Does the strut have room for these cuts (mm, by strut end)?
    pub fn fits(&self, strut: usize, cuts: &[f64]) -> bool {
        cuts[2 * strut] + cuts[2 * strut + 1] <= self.room[strut]
    }
}

fn at_node(graph: &Graph, node: NodeId, all: &[Cone], lambda: f64) -> AtNode {
    let arms = graph.arms(node);
    let degree = arms.len();
    if degree < 2 {
        return AtNode { preferred: vec![0.0; degree], touching: vec![0.0; degree], pairs: vec![0.0; degree] };
    }
    let at = graph.nodes()[node.index()];
    let axes: Vec<DVec3> = arms.iter().map(|&arm| (graph.nodes()[graph.far(arm).index()] - at).normalize()).collect();
    let cones: Vec<Cone> = arms.iter().map(|&arm| all[index(arm)]).collect();
    let mut angles = vec![0.0; degree * degree];
    for i in 0..degree {
        for j in (0..degree).filter(|&j| j != i) {
            angles[i * degree + j] = angle(axes[i], axes[j]);
        }
    }
    let theta = |i: usize, j: usize| angles[i * degree + j];
    // At a node of one radius, a λ so small that caps almost touch is the user's own wish. Cones may need more than λ.
    let even = cones.iter().all(|&c| c == Cone { r: cones[0].r, k: 0.0 });
    let mut preferred = Vec::with_capacity(degree);
    let mut touching = Vec::with_capacity(degree);
    for (i, &arm) in arms.iter().enumerate() {
        let me = cones[i];
        let others = (0..degree).filter(|&j| j != i);
        let least = others.map(|j| shared(me, cones[j], (1.0 - MARGIN) * theta(i, j))).fold(f64::INFINITY, f64::min);
        // A cut that no strut can have is as good as one four times the strut's length.
        let most = 4.0 * graph.length(arm.strut);
        let wanted = preferred::cut(&cones, i, |j| theta(i, j), lambda);
        let touch = me.cut(least).max(LEAST_ROOM * me.r);
        let wanted = if even { wanted } else { wanted.max(touch) };
        preferred.push(if wanted.is_finite() { wanted } else { most });
        touching.push(touch.min(wanted));
    }
    let caps: Vec<f64> = cones.iter().zip(&preferred).map(|(c, &d)| c.cap(d)).collect();
    let mut pairs = angles;
    for (at, angle) in pairs.iter_mut().enumerate() {
        *angle *= 1.0 - MARGIN;
        if even {
            *angle = angle.max(caps[at / degree] + caps[at % degree]);
        }
    }
    AtNode { preferred, touching, pairs }
}
