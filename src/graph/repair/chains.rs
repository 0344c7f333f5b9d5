//! Collapse chains: straight runs of struts through nodes of degree 2, as finite-element programs write them, become one strut.
//!
//! A chain runs between two nodes of other degree, or round a ring of its own. It is simplified as Douglas and Peucker do (1973): a
//! piece becomes one strut if at every node between its ends the distance from that strut's axis and the difference from its
//! radius there together are at most δ, in order along it; else it is parted at the node that is furthest off. So the surface moves by
//! at most δ (to first order in the angles), radii equal or linear along the piece stay so, and corners stay. A piece stays as it is
//! where a strut joins its ends already.
//! Nodes with a strut that is not sound (out of range, not finite) count as ends.
//! `straight` is the same for chains that are one cylinder or cone but for round-off: made by export unasked.

use super::record::{Draft, Fate, Repair, Step, Why};
use crate::graph::{Input, Strut};
use crate::ids::{NodeId, StrutId};
use glam::DVec3;
use std::collections::HashSet;

/// δ of chains that are one cylinder or cone but for round-off. Reason: the gap that may be written (`pipeline::MOST_GAP`), far above the round-off of
/// doubles; at a strut length of one radius a kink of 1e-9 to 2e-9 rad.
pub const EXACT: f64 = 1e-9;

/// δ in radii of the chain's thinnest strut, where none is given. Reason: a fifth of the distance that patches may keep from their
/// film (0.05 radii), far above the round-off of coordinates printed with six digits. Guessed.
pub const STRAIGHT: f64 = 0.01;

/// Straight chains become one strut; `delta` (above 0) in radii of the chain's thinnest strut.
pub fn collapse(input: &Input, delta: f64) -> (Input, Repair) {
    let mut draft = Draft::new(input);
    let net = Net::new(&draft, input);
    let mut taken: HashSet<(NodeId, NodeId)> = net.sound.iter().flatten().map(|s| between(s.a, s.b)).collect();
    for chain in net.chains(&draft.at) {
        let least = chain.links.iter().map(|l| l.radii[0].min(l.radii[1])).fold(f64::INFINITY, f64::min);
        for (i, j) in chain.pieces(&draft.at, delta * least, EXACT * least) {
            let (from, to) = (chain.nodes[i], chain.nodes[j]);
            if j - i < 2 || from == to || !taken.insert(between(from, to)) {
                continue;
            }
            let links = &chain.links[i..j];
            let first = links.iter().min_by_key(|l| l.strut).expect("a piece of two or more");
            let (ra, rb) = (links[0].radii[0], links[links.len() - 1].radii[1]);
            for l in links {
                draft.fates[l.strut] = Fate::Gone { into: Some(StrutId(first.strut as u32)), why: Why::Chain };
            }
            let whole = if first.forward { Strut { a: from, b: to, ra, rb } } else { Strut { a: to, b: from, ra: rb, rb: ra } };
            draft.fates[first.strut] = Fate::Stays(whole);
            chain.nodes[i + 1..j].iter().for_each(|&n| draft.drop_node(n));
        }
    }
    draft.finish(Step::CollapseChains, delta)
}

/// Chains that need no node between their ends become one strut. None where there are none.
pub fn straight(input: &Input) -> Option<(Input, Repair)> {
    Some(collapse(input, EXACT)).filter(|(_, repair)| !repair.struts.is_empty())
}

fn between(a: NodeId, b: NodeId) -> (NodeId, NodeId) {
    (a.min(b), a.max(b))
}

/// A strut as a chain passes it.
struct Link {
    strut: usize,
    /// The chain runs from its `a` to its `b`.
    forward: bool,
    /// At the end where the chain comes in, and where it goes out (mm).
    radii: [f64; 2],
}

/// A run of struts: link k joins nodes k and k + 1.
struct Chain {
    nodes: Vec<NodeId>,
    links: Vec<Link>,
}

/// The sound struts, and for each node of degree 2 its two struts.
struct Net {
    sound: Vec<Option<Strut>>,
    inner: Vec<Option<[usize; 2]>>,
}

impl Net {
    fn new(draft: &Draft, input: &Input) -> Net {
        let sound: Vec<Option<Strut>> = (0..input.struts.len()).map(|k| draft.sound(k)).collect();
        let mut inner = vec![None; input.nodes.len()];
        let mut count = vec![0usize; input.nodes.len()];
        for (k, s) in input.struts.iter().enumerate() {
            for n in [s.a, s.b].into_iter().map(NodeId::index).filter(|&n| n < input.nodes.len()) {
                // a strut that is not sound makes an end of its node
                count[n] += if sound[k].is_some() { 1 } else { 3 };
                let pair: &mut [usize; 2] = inner[n].get_or_insert([k; 2]);
                pair[1] = k;
            }
        }
        for (pair, _) in inner.iter_mut().zip(count).filter(|(_, count)| *count != 2) {
            *pair = None;
        }
        Net { sound, inner }
    }

    /// All chains of two struts and more: those between ends in the order of their first strut, then rings.
    fn chains(&self, at: &[DVec3]) -> Vec<Chain> {
        let mut seen = vec![false; self.sound.len()];
        let mut chains = Vec::new();
        for (k, s) in self.sound.iter().enumerate().filter_map(|(k, s)| s.map(|s| (k, s))) {
            let Some(start) = [s.a, s.b].into_iter().find(|n| self.inner[n.index()].is_none()).filter(|_| !seen[k]) else { continue };
            chains.push(self.walk(k, start, &mut seen));
        }
        for (k, s) in self.sound.iter().enumerate().filter_map(|(k, s)| s.map(|s| (k, s))) {
            if !seen[k] {
                let ring = self.walk(k, s.a, &mut seen);
                let corner = ring.sharpest(at);
                ring.links.iter().for_each(|l| seen[l.strut] = false);
                chains.push(self.walk(ring.links[corner].strut, ring.nodes[corner], &mut seen));
            }
        }
        chains.retain(|c| c.links.len() > 1);
        chains
    }

    /// From a node along a strut, to a node that is no inner one, or back to the first.
    fn walk(&self, strut: usize, start: NodeId, seen: &mut [bool]) -> Chain {
        let mut chain = Chain { nodes: vec![start], links: Vec::new() };
        let (mut strut, mut node) = (strut, start);
        loop {
            let s = self.sound[strut].expect("chains pass sound struts");
            let forward = s.a == node;
            let radii = if forward { [s.ra, s.rb] } else { [s.rb, s.ra] };
            seen[strut] = true;
            node = if forward { s.b } else { s.a };
            chain.nodes.push(node);
            chain.links.push(Link { strut, forward, radii });
            match self.inner[node.index()] {
                Some([first, second]) if node != start => strut = if first == strut { second } else { first },
                _ => return chain,
            }
        }
    }
}

impl Chain {
    /// Of a ring: the node at which it turns most, of equals the first.
    fn sharpest(&self, at: &[DVec3]) -> usize {
        let place = |k: usize| at[self.nodes[k % self.links.len()].index()];
        let count = self.links.len();
        let turn = |k: usize| (place(k + 1) - place(k)).angle_between(place(k) - place(k + count - 1));
        (0..count).rev().max_by(|&j, &k| turn(j).total_cmp(&turn(k))).expect("a ring has nodes")
    }

    /// The pieces, as pairs of positions in the chain, each within `delta` (mm) of one strut or a single link.
    fn pieces(&self, at: &[DVec3], delta: f64, equal: f64) -> Vec<(usize, usize)> {
        let mut todo = vec![(0, self.links.len())];
        let mut pieces = Vec::new();
        while let Some((i, j)) = todo.pop() {
            match self.worst(at, i, j, equal) {
                Some((m, off)) if off > delta => todo.extend([(m, j), (i, m)]),
                _ => pieces.push((i, j)),
            }
        }
        pieces
    }

    /// The node between two others that is furthest from the strut that would join these, and how far (mm). Of equals, to within `equal` (mm), the first: where a
    /// straight run lies along that strut, the corner that it begins at.
    fn worst(&self, at: &[DVec3], i: usize, j: usize, equal: f64) -> Option<(usize, f64)> {
        let place = |k: usize| at[self.nodes[k].index()];
        let (p, u) = (place(i), place(j) - place(i));
        let [ra, rb] = [self.links[i].radii[0], self.links[j - 1].radii[1]];
        let mut passed = 0.0;
        let mut worst = None;
        for m in i + 1..j {
            let along = u.dot(place(m) - p) / u.length_squared();
            let t = if along.is_finite() { along.clamp(0.0, 1.0) } else { 0.0 };
            let wanted = ra + t * (rb - ra);
            let off_radius = (self.links[m - 1].radii[1] - wanted).abs().max((self.links[m].radii[0] - wanted).abs());
            let off = if t < passed { f64::INFINITY } else { off_radius + place(m).distance(p + t * u) };
            passed = t;
            if worst.is_none_or(|(_, most)| off > most + equal) {
                worst = Some((m, off));
            }
        }
        worst
    }
}
