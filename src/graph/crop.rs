//! Crop a graph to a box: for looking at, or judging, a block of a large lattice.
//!
//! - A strut with both nodes in the box (faces included) stays.
//! - A strut with one node in the box is cut where it leaves, but at its middle at the latest, and ends there in a new node of
//!   degree 1: beyond the middle, the cut ends of struts that run to one outer node would overlap. Where less than `room` is left
//!   of it, the cut end would lie within the node's own blend: then it is cut at `room`, outside the box, or stays whole where
//!   that is most of it. Where less than its radius is left, it is dropped: a block cut through a plane of nodes shows no stubs.
//! - A strut with no node in the box is dropped, even where it passes through: a loose piece belongs to no node.
//! - Nodes left without struts are dropped. Nodes keep their order; new nodes follow, in the order of their struts.
//!
//! Room, with the larger radius of a tapered strut: three radii, and along each neighbouring strut's silhouette 1.5 r / tan(θ/2) + 2 r, θ the angle between the two: the cut
//! of the paper's eq. 3 with λ = 0.5 and two radii for the cut end. Guessed; the node layer measures the real cuts.

use super::{Arm, End, Graph, Strut};
use crate::ids::{NodeId, StrutId};
use glam::DVec3;

/// A cropped graph and where its parts come from.
#[derive(Clone, Debug)]
pub struct Cropped {
    pub graph: Graph,
    /// The original of each node, indexed by the new `NodeId`; none for a new end on a face.
    pub nodes: Vec<Option<NodeId>>,
    /// The original of each strut, indexed by the new `StrutId`.
    pub struts: Vec<StrutId>,
}

/// A strut that keeps more than this part of its length stays whole.
const MOST_CUT: f64 = 0.9;

/// What becomes of one strut.
enum Fate {
    Dropped,
    Whole,
    /// Only its part between two parameters, one of them 0 or 1: that end is old, the other new.
    Cut(f64, f64),
}

/// The part of the graph in the closed box from `min` to `max` (mm), `min` below `max` along each axis.
pub fn crop(graph: &Graph, min: DVec3, max: DVec3) -> Cropped {
    let fates: Vec<Fate> = (0..graph.struts().len() as u32).map(|k| fate(graph, StrutId(k), min, max)).collect();

    // Original nodes first, those that keep a strut.
    let mut kept = vec![false; graph.nodes().len()];
    for (s, fate) in graph.struts().iter().zip(&fates) {
        let (a, b) = match *fate {
            Fate::Dropped => (false, false),
            Fate::Whole => (true, true),
            Fate::Cut(from, to) => (from == 0.0, to == 1.0),
        };
        kept[s.a.index()] |= a;
        kept[s.b.index()] |= b;
    }
    let originals: Vec<NodeId> = graph.node_ids().filter(|n| kept[n.index()]).collect();
    let mut new_id = vec![None; graph.nodes().len()];
    for (k, n) in originals.iter().enumerate() {
        new_id[n.index()] = Some(NodeId(k as u32));
    }
    let mut places: Vec<DVec3> = originals.iter().map(|n| graph.nodes()[n.index()]).collect();
    let mut nodes: Vec<Option<NodeId>> = originals.into_iter().map(Some).collect();

    let mut struts = Vec::new();
    let mut strut_origins = Vec::new();
    for (k, fate) in fates.iter().enumerate() {
        let s = graph.struts()[k];
        let (from, to) = match *fate {
            Fate::Dropped => continue,
            Fate::Whole => (0.0, 1.0),
            Fate::Cut(from, to) => (from, to),
        };
        let (p, q) = (graph.nodes()[s.a.index()], graph.nodes()[s.b.index()]);
        let mut end = |t: f64, old: NodeId| {
            new_id[old.index()].filter(|_| t == 0.0 || t == 1.0).unwrap_or_else(|| {
                places.push(p.lerp(q, t));
                nodes.push(None);
                NodeId(places.len() as u32 - 1)
            })
        };
        let (a, b) = (end(from, s.a), end(to, s.b));
        // An old end keeps its radius bit for bit.
        let radius = |t: f64| if t == 1.0 { s.rb } else { s.ra + t * (s.rb - s.ra) };
        struts.push(Strut { a, b, ra: radius(from), rb: radius(to) });
        strut_origins.push(StrutId(k as u32));
    }
    Cropped { graph: Graph::new(places, struts), nodes, struts: strut_origins }
}

fn fate(graph: &Graph, strut: StrutId, min: DVec3, max: DVec3) -> Fate {
    let s = graph.struts()[strut.index()];
    let (p, q) = (graph.nodes()[s.a.index()], graph.nodes()[s.b.index()]);
    let inside = |p: DVec3| p.cmpge(min).all() && p.cmple(max).all();
    let Some((from, to)) = clip(p, q, min, max) else { return Fate::Dropped };
    let length = graph.length(strut);
    let left = (to - from) * length;
    let end = match (inside(p), inside(q)) {
        (true, true) => return Fate::Whole,
        (false, false) => return Fate::Dropped,
        (true, false) => End::A,
        (false, true) => End::B,
    };
    if left < graph.widest(strut) {
        return Fate::Dropped;
    }
    let kept = left.min(0.5 * length).max(room(graph, Arm { strut, end })) / length;
    match end {
        _ if kept > MOST_CUT => Fate::Whole,
        End::A => Fate::Cut(0.0, if kept * length == left { to } else { kept }),
        End::B => Fate::Cut(if kept * length == left { from } else { 1.0 - kept }, 1.0),
    }
}

/// The parameters between which the segment is in the box (slabs).
fn clip(p: DVec3, q: DVec3, min: DVec3, max: DVec3) -> Option<(f64, f64)> {
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for axis in 0..3 {
        let (x, u) = (p[axis], q[axis] - p[axis]);
        if u == 0.0 {
            if x < min[axis] || x > max[axis] {
                return None;
            }
            continue;
        }
        let (s, t) = ((min[axis] - x) / u, (max[axis] - x) / u);
        from = from.max(s.min(t));
        to = to.min(s.max(t));
    }
    (from <= to).then_some((from, to))
}

/// The length (mm) a strut needs from this node to a cut end of its own.
fn room(graph: &Graph, arm: Arm) -> f64 {
    let direction = |arm: Arm| (graph.nodes()[graph.far(arm).index()] - graph.nodes()[graph.near(arm).index()]).normalize();
    let own = direction(arm);
    let others = graph.arms(graph.near(arm)).iter().filter(|other| other.strut != arm.strut);
    others.fold(3.0 * graph.widest(arm.strut), |room, &other| {
        let r = graph.widest(arm.strut).max(graph.widest(other.strut));
        let half_angle = 0.5 * own.angle_between(direction(other));
        room.max(1.5 * r / half_angle.tan() + 2.0 * r)
    })
}
