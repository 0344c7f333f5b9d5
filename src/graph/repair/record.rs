//! What a repair did: for the report, complete enough to take it back.

use crate::error::Note;
use crate::graph::{Input, Strut, check};
use crate::ids::{NodeId, StrutId};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Which repair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Step {
    Weld,
    DropLoose,
    CollapseChains,
    Merge,
}

/// One repair: how much there was before and after, and all that changed, in the ids before it. Lengths in mm.
///
/// What stays keeps its order: of the elements that are not listed, and those listed with `stays`, the k-th has the id k afterwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Repair {
    pub step: Step,
    /// What was asked for: weld in mm, drop-loose as a share of the largest volume, collapse-chains in radii, merge in degrees.
    pub limit: f64,
    pub before: Size,
    pub after: Size,
    /// Sum over the struts of how much the volume of each, from node to node, grew or shrank; all of it for those that are gone (mm³).
    pub changed_mm3: f64,
    /// Nodes that moved, went into another or were dropped.
    pub nodes: Vec<NodeChange>,
    /// Struts that were dropped, went into another, or have other ends or radii than before.
    pub struts: Vec<StrutChange>,
}

/// Numbers of nodes and struts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Size {
    pub nodes: usize,
    pub struts: usize,
}

/// A node that is not what it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NodeChange {
    /// Its id before.
    pub node: NodeId,
    /// Where it was.
    pub at: [f64; 3],
    /// The node that it is now, in the ids after; none if it was dropped.
    pub into: Option<NodeId>,
    /// It is still there, moved. Else it is gone, or went into another.
    pub stays: bool,
    /// Distance to the node that it is now; none if it was dropped.
    pub moved: Option<f64>,
}

/// A strut that is not what it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StrutChange {
    /// Its id before.
    pub strut: StrutId,
    /// Its ends before, in the ids before.
    pub a: NodeId,
    pub b: NodeId,
    /// Its radii before.
    pub ra: f64,
    pub rb: f64,
    /// The strut that it is now, in the ids after; none if it was dropped.
    pub into: Option<StrutId>,
    /// Ends and radii of that strut.
    pub now: Option<Ends>,
    pub why: Why,
}

/// Ends, in the ids after, and radii of a strut (mm).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ends {
    pub a: NodeId,
    pub b: NodeId,
    pub ra: f64,
    pub rb: f64,
}

/// Why a strut is not what it was. All but `changed` are gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Why {
    /// Other ends or other radii.
    Changed,
    /// Both ends are in one node.
    Loop,
    /// An earlier strut joins the same nodes; it has the larger of the radii.
    Twin,
    /// Part of a chain that became one strut.
    Chain,
    /// In a part that was dropped.
    Loose,
}

impl Repair {
    /// For the list of changes: one line.
    pub fn note(&self) -> Note {
        let gone = |before: usize, after: usize| format!("{} of {before}", before - after);
        let (what, limit) = match self.step {
            Step::Weld => ("weld", format!("{} mm", self.limit)),
            Step::DropLoose => ("drop-loose", format!("below {} of the largest part's volume", self.limit)),
            Step::CollapseChains => ("collapse-chains", format!("{:?} radii", self.limit)),
            Step::Merge => ("merge", format!("{}°", self.limit)),
        };
        let (nodes, struts) = (gone(self.before.nodes, self.after.nodes), gone(self.before.struts, self.after.struts));
        let farthest = self.nodes.iter().filter_map(|n| n.moved).reduce(f64::max);
        let moved = farthest.map_or(String::new(), |by| format!(", the farthest node moved by {by:.6} mm"));
        let volume = format!("{:.6} mm³ of struts changed", self.changed_mm3);
        Note::new("document", format!("{what} ({limit}): {nodes} nodes and {struts} struts fewer{moved}, {volume}"))
    }

    /// The ids before of the nodes and struts after.
    pub fn origins(&self) -> (Vec<NodeId>, Vec<StrutId>) {
        let gone: HashMap<u32, bool> = self.nodes.iter().map(|n| (n.node.0, !n.stays)).collect();
        let nodes = (0..self.before.nodes as u32).filter(|n| !gone.get(n).copied().unwrap_or(false)).map(NodeId).collect();
        let gone: HashMap<u32, bool> = self.struts.iter().map(|s| (s.strut.0, s.why != Why::Changed)).collect();
        let struts = (0..self.before.struts as u32).filter(|s| !gone.get(s).copied().unwrap_or(false)).map(StrutId).collect();
        (nodes, struts)
    }
}

/// The lattice before these repairs, bit for bit. The repairs are in the order in which they were made; each must fit what it left.
pub fn undo(input: &Input, repairs: &[Repair]) -> Result<Input, String> {
    repairs.iter().rev().try_fold(input.clone(), |after, repair| undo_one(&after, repair))
}

fn undo_one(after: &Input, repair: &Repair) -> Result<Input, String> {
    let refused = || Err(format!("a record ({:?}) whose counts and lists do not agree", repair.step));
    let Size { nodes, struts } = repair.before;
    // before anything is made of these counts: what was there is there still or listed
    if nodes > after.nodes.len() + repair.nodes.len() || struts > after.struts.len() + repair.struts.len() {
        return refused();
    }
    let in_range = repair.nodes.iter().all(|n| n.node.index() < nodes) && repair.struts.iter().all(|s| s.strut.index() < struts);
    let (node_origins, strut_origins) = repair.origins();
    if !in_range || (node_origins.len(), strut_origins.len()) != (after.nodes.len(), after.struts.len()) {
        return refused();
    }
    let mut nodes = vec![DVec3::NAN; repair.before.nodes];
    for (&old, &at) in node_origins.iter().zip(&after.nodes) {
        nodes[old.index()] = at;
    }
    for n in &repair.nodes {
        nodes[n.node.index()] = DVec3::from_array(n.at);
    }
    // an end out of range is so before and after
    let end = |n: NodeId| node_origins.get(n.index()).copied().unwrap_or(n);
    let mut struts = vec![Strut { a: NodeId(0), b: NodeId(0), ra: 0.0, rb: 0.0 }; repair.before.struts];
    for (&old, s) in strut_origins.iter().zip(&after.struts) {
        struts[old.index()] = Strut { a: end(s.a), b: end(s.b), ..*s };
    }
    for s in &repair.struts {
        struts[s.strut.index()] = Strut { a: s.a, b: s.b, ra: s.ra, rb: s.rb };
    }
    Ok(Input { name: after.name.clone(), nodes, struts })
}

/// What becomes of a strut, in the ids before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fate {
    Stays(Strut),
    Gone { into: Option<StrutId>, why: Why },
}

/// A repair in the making, all in the ids before it.
pub(super) struct Draft<'a> {
    input: &'a Input,
    /// The node that each node becomes, itself if it stays; none if it is dropped.
    into: Vec<Option<NodeId>>,
    /// Where each node that stays will be (mm).
    pub at: Vec<DVec3>,
    pub fates: Vec<Fate>,
}

impl<'a> Draft<'a> {
    pub fn new(input: &'a Input) -> Self {
        let into = (0..input.nodes.len() as u32).map(|n| Some(NodeId(n))).collect();
        Draft { input, into, at: input.nodes.clone(), fates: input.struts.iter().map(|&s| Fate::Stays(s)).collect() }
    }

    /// The strut as it is now, if it stays, has two different ends, finite places and finite radii above zero.
    pub fn sound(&self, k: usize) -> Option<Strut> {
        let Fate::Stays(s) = self.fates[k] else { return None };
        let usable = |n: NodeId| self.at.get(n.index()).is_some_and(|&p| check::is_usable(p));
        (s.a != s.b && usable(s.a) && usable(s.b) && check::is_radius(s.ra) && check::is_radius(s.rb)).then_some(s)
    }

    /// The lattice before.
    pub fn given(&self) -> &Input {
        self.input
    }

    pub fn drop_node(&mut self, node: NodeId) {
        self.into[node.index()] = None;
    }

    /// Let each node go into the one given for it, which stays; then reroute the struts, and drop loops and twins.
    pub fn join(&mut self, into: impl Fn(NodeId) -> NodeId) {
        for to in self.into.iter_mut().flatten() {
            *to = into(*to);
        }
        let count = self.into.len();
        let end = |n: NodeId| if n.index() < count { into(n) } else { n };
        for fate in &mut self.fates {
            if let Fate::Stays(s) = fate {
                (s.a, s.b) = (end(s.a), end(s.b));
            }
        }
        self.drop_loops_and_twins();
    }

    /// Of struts between the same nodes the first stays, with the larger radius at each end.
    pub fn drop_loops_and_twins(&mut self) {
        let mut first_between: HashMap<(NodeId, NodeId), usize> = HashMap::new();
        for k in 0..self.fates.len() {
            let Fate::Stays(s) = self.fates[k] else { continue };
            if s.a.index().max(s.b.index()) >= self.at.len() {
                continue;
            }
            if s.a == s.b {
                self.fates[k] = Fate::Gone { into: None, why: Why::Loop };
                continue;
            }
            let first = *first_between.entry((s.a.min(s.b), s.a.max(s.b))).or_insert(k);
            if first != k {
                self.fates[k] = Fate::Gone { into: Some(StrutId(first as u32)), why: Why::Twin };
                let Fate::Stays(kept) = &mut self.fates[first] else { unreachable!("the first of twins stays") };
                let (ra, rb) = if kept.a == s.a { (s.ra, s.rb) } else { (s.rb, s.ra) };
                (kept.ra, kept.rb) = (kept.ra.max(ra), kept.rb.max(rb));
            }
        }
    }

    /// See `Repair::changed_mm3`; of the struts whose volumes are numbers.
    fn changed_volume(&self) -> f64 {
        let volume = |at: &[DVec3], s: &Strut| Some(s.volume(at.get(s.a.index())?.distance(*at.get(s.b.index())?)));
        let change = |(fate, s): (&Fate, &Strut)| {
            let now = if let Fate::Stays(s) = fate { volume(&self.at, s)? } else { 0.0 };
            Some((now - volume(&self.input.nodes, s)?).abs()).filter(|change| change.is_finite())
        };
        self.fates.iter().zip(&self.input.struts).filter_map(change).sum()
    }

    /// The repaired lattice, and the record of what changed.
    pub fn finish(self, step: Step, limit: f64) -> (Input, Repair) {
        let changed_mm3 = self.changed_volume();
        let Draft { input, into, at, fates } = self;
        let stays = |n: usize| into[n] == Some(NodeId(n as u32));
        let new_node = numbered((0..into.len()).map(stays));
        let new_strut = numbered(fates.iter().map(|f| matches!(f, Fate::Stays(_))));
        let mut nodes = Vec::new();
        for (n, to) in into.iter().enumerate() {
            if !stays(n) || at[n] != input.nodes[n] && check::is_usable(at[n]) {
                let moved = to.map(|to| at[to.index()].distance(input.nodes[n]));
                let into = to.map(|to| NodeId(new_node[to.index()]));
                nodes.push(NodeChange { node: NodeId(n as u32), at: input.nodes[n].to_array(), into, stays: stays(n), moved });
            }
        }
        let end = |n: NodeId| if n.index() < into.len() { NodeId(new_node[n.index()]) } else { n };
        let kept = fates.iter().filter_map(|f| if let Fate::Stays(s) = f { Some(Strut { a: end(s.a), b: end(s.b), ..*s }) } else { None });
        let kept: Vec<Strut> = kept.collect();
        let mut struts = Vec::new();
        for (k, (&fate, &Strut { a, b, ra, rb })) in fates.iter().zip(&input.struts).enumerate() {
            let why = match fate {
                Fate::Stays(s) if s == input.struts[k] || s.ra.is_nan() || s.rb.is_nan() => continue,
                Fate::Stays(_) => Why::Changed,
                Fate::Gone { why, .. } => why,
            };
            let mut now = Some(StrutId(k as u32));
            while let Some(Fate::Gone { into, .. }) = now.map(|k| fates[k.index()]) {
                now = into;
            }
            let into = now.map(|k| StrutId(new_strut[k.index()]));
            let now = into.map(|k| kept[k.index()]).map(|s| Ends { a: s.a, b: s.b, ra: s.ra, rb: s.rb });
            struts.push(StrutChange { strut: StrutId(k as u32), a, b, ra, rb, into, now, why });
        }
        let after = Input { name: input.name.clone(), nodes: (0..into.len()).filter(|&n| stays(n)).map(|n| at[n]).collect(), struts: kept };
        let size = |input: &Input| Size { nodes: input.nodes.len(), struts: input.struts.len() };
        let repair = Repair { step, limit, before: size(input), after: size(&after), changed_mm3, nodes, struts };
        (after, repair)
    }
}

/// The new ids of those that stay; of the others, the id that the next to stay has.
fn numbered(stays: impl Iterator<Item = bool>) -> Vec<u32> {
    let next = |next: &mut u32, stays: bool| {
        let id = *next;
        *next += u32::from(stays);
        Some(id)
    };
    stays.scan(0, next).collect()
}
