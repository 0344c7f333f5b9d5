//! From a graph to built nodes: cuts for all struts, then each node by the ladder; where something does not fit, what the policy says.
//! `OnConflict::Refuse` answers with all reasons at once. `OnConflict::Shrink` makes radii smaller: of struts that overlap, of struts that
//! no cuts fit, of the ends at nodes that no rung of the ladder can build, and where skins cross, until all is well or there is no more to gain.

use crate::cuts::{self, Cuts, Radii, Shrunk, Thinner};
use crate::error::Error;
use crate::graph::proximity::NearMiss;
use crate::graph::{Arm, End, Graph};
use crate::ids::NodeId;
use crate::ladder::{self, Built, Degrees, Rung};
use crate::node::{Star, cut};
use crate::options::{OnConflict, Options};
use crate::patch::check::Quality;
use crate::patch::figures::Figures;
use crate::patch::{Shelf, Shelved};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Factor on radii at a node that could not be built, or where its skin crosses something, each round. Guessed: near the least that
/// is needed, in few rounds.
const EASE: f64 = 0.93;
/// Rounds of easing before a node is given up: radii are then a twentieth of what they were.
const MOST_ROUNDS: usize = 40;

/// A node that was built.
pub struct Kept {
    pub skin: Shelved,
    pub rung: Rung,
    pub quality: Quality,
    pub figures: Figures,
    /// Why each higher rung failed.
    pub reasons: Vec<String>,
}

/// A graph on its way to nodes that are all built.
pub struct Settling<'a> {
    given: &'a Graph,
    options: &'a Options,
    radii: Radii<'a>,
    degrees: Degrees,
    shelf: Shelf,
    known: Known,
    /// How often radii have been eased.
    rounds: usize,
}

/// What became of each different star, by its key.
type Known = HashMap<Vec<u64>, Result<Arc<Kept>, Vec<String>>>;

/// The graph, as given or with smaller radii, and its cuts, for which all nodes are built.
pub struct Settled {
    pub graph: Graph,
    pub cuts: Cuts,
    pub shrunk: Vec<Shrunk>,
    /// By `NodeId`; none where a node has no struts. Nodes of one star, to the last bit, share what was built (`Options::cache`).
    pub built: Vec<Option<Arc<Kept>>>,
}

impl<'a> Settling<'a> {
    /// Struts that overlap are parted here, if the policy says so.
    pub fn new(given: &'a Graph, options: &'a Options) -> Result<Self, Error> {
        let mut radii = Radii::new(given);
        if options.on_conflict == (OnConflict::Shrink { part: true }) {
            cuts::part(&mut radii).map_err(cannot_part)?;
        }
        let shelf = Shelf::new(options.scratch.clone(), options.skins_in_memory);
        Ok(Settling { given, options, radii, degrees: Degrees::new(), shelf, known: Known::new(), rounds: 0 })
    }

    /// Settle cuts and build all nodes. `begin` is told how many nodes a round builds, `advance` each one, from any thread.
    pub fn settle(&mut self, begin: &dyn Fn(u64), advance: &(dyn Fn() + Sync)) -> Result<Settled, Error> {
        loop {
            let cuts = match self.options.on_conflict {
                OnConflict::Refuse => cuts::negotiate(self.given, self.options.lambda).map_err(cannot_cut)?,
                OnConflict::Shrink { .. } => cuts::shrink(&mut self.radii, self.options.lambda),
            };
            let graph = self.radii.graph();
            let stars = stars(&graph, &cuts, self.options);
            let keys: Vec<Vec<u64>> = graph.node_ids().zip(&stars).map(|(node, star)| self.key(node, star)).collect();
            let new = unknown(&stars, &keys, &self.known);
            drop(stars);
            self.build(new, begin, advance)?;
            let of = |n: NodeId| self.known.get(&keys[n.index()]);
            let failed: Vec<(NodeId, &[String])> = graph.node_ids().filter_map(|n| Some((n, of(n)?.as_ref().err()?.as_slice()))).collect();
            if failed.is_empty() {
                let built = graph.node_ids().map(|n| of(n)?.as_ref().ok().cloned()).collect();
                return Ok(Settled { graph, cuts, shrunk: self.radii.shrunk(), built });
            }
            if !self.may_ease() {
                return Err(cannot_build(&graph, &failed));
            }
            let wishes = failed.iter().flat_map(|&(n, _)| easings(&graph, n)).collect();
            self.ease(wishes);
        }
    }

    /// By what a star is known: its bits, and its node if each is to be built for itself.
    fn key(&self, node: NodeId, star: &Star) -> Vec<u64> {
        let own = (!self.options.cache).then_some(u64::from(node.0));
        star.bits().into_iter().chain(own).collect()
    }

    fn build(&mut self, new: Vec<(Vec<u64>, Star)>, begin: &dyn Fn(u64), advance: &(dyn Fn() + Sync)) -> Result<(), Error> {
        begin(new.len() as u64);
        let build = |(key, star): (Vec<u64>, Star)| {
            let kept = match ladder::build(star, self.options, &self.degrees) {
                Ok(Built { skin, rung, quality, figures, reasons }) => Ok(Arc::new(Kept { skin: self.shelf.keep(skin)?, rung, quality, figures, reasons })),
                Err(reasons) => Err(reasons),
            };
            advance();
            Ok((key, kept))
        };
        let built: Vec<_> = new.into_par_iter().map(build).collect::<std::io::Result<_>>().map_err(Error::io("temporary file"))?;
        self.known.extend(built);
        Ok(())
    }

    /// Skins of these nodes meet at these places (mm) what they should not: make the node's strut that points there thinner at that height.
    /// False if the policy does not allow it or there is no more to gain; else settle again.
    pub fn part(&mut self, meetings: &[(NodeId, DVec3)]) -> bool {
        let thinner = |&(node, at): &(NodeId, DVec3)| {
            let to = at - self.given.nodes()[node.index()];
            let axes = Star::directions(self.given, node);
            let (arm, axis) = self.given.arms(node).iter().zip(axes).max_by(|(_, a), (_, b)| a.dot(to).total_cmp(&b.dot(to))).expect("a skin has struts");
            let part = (axis.dot(to) / self.given.length(arm.strut)).clamp(0.0, 1.0);
            Thinner { strut: arm.strut, t: if arm.end == End::A { part } else { 1.0 - part }, to: EASE }
        };
        let may = !meetings.is_empty() && self.options.on_conflict == (OnConflict::Shrink { part: true }) && self.may_ease();
        if may {
            self.ease(meetings.iter().map(thinner).collect());
        }
        may
    }

    fn may_ease(&self) -> bool {
        self.options.on_conflict != OnConflict::Refuse && self.rounds < MOST_ROUNDS
    }

    fn ease(&mut self, wishes: Vec<Thinner>) {
        self.rounds += 1;
        self.radii.thin(wishes);
    }
}

/// Make the radii at a node that cannot be built more equal, as such nodes are easier to build: its thick struts thinner, but none thinner than its
/// thinnest. Where they are equal, all of them: cuts that were squeezed then get more room.
fn easings(graph: &Graph, node: NodeId) -> Vec<Thinner> {
    let arms = graph.arms(node);
    let least = arms.iter().map(|&arm| graph.radius(arm)).fold(f64::INFINITY, f64::min);
    let equal = arms.iter().all(|&arm| graph.radius(arm) <= least * (1.0 + 1e-9));
    let to = |arm: &Arm| if equal { EASE } else { EASE.max(least / graph.radius(*arm)) };
    let ease = |arm: &Arm| Thinner { strut: arm.strut, t: if arm.end == End::A { 0.0 } else { 1.0 }, to: to(arm) };
    arms.iter().map(ease).filter(|wish| wish.to < 1.0).collect()
}

/// The stars with struts that are not known yet, each once, in the order of their first nodes.
fn unknown(stars: &[Star], keys: &[Vec<u64>], known: &Known) -> Vec<(Vec<u64>, Star)> {
    let mut met: HashSet<&[u64]> = HashSet::new();
    let all = stars.iter().zip(keys);
    all.filter(|(star, key)| star.degree() > 0 && !known.contains_key(*key) && met.insert(key)).map(|(star, key)| (key.clone(), star.clone())).collect()
}

/// All nodes of a graph whose cuts fit, by `NodeId`.
pub fn negotiated(graph: &Graph, options: &Options) -> Result<Vec<Star>, Error> {
    let cuts = cuts::negotiate(graph, options.lambda).map_err(cannot_cut)?;
    Ok(stars(graph, &cuts, options))
}

/// Directions, radii and cuts of all nodes, by `NodeId`, in node units: a node's largest radius is 1.
fn stars(graph: &Graph, cuts: &Cuts, options: &Options) -> Vec<Star> {
    let star = |node: NodeId| {
        let arms = graph.arms(node);
        let unit = graph.largest_radius(node);
        let axes = Star::directions(graph, node);
        // between struts of one radius the preferred cut stays as it is: to divide what was multiplied would change its last bit
        let own = cut::cuts(&axes, options.lambda);
        let cut = |(arm, own): (&Arm, &f64)| {
            let mm = cuts.at[arm.strut.index()][arm.end as usize];
            if own * unit == mm { *own } else { mm / unit }
        };
        Star {
            cuts: arms.iter().zip(&own).map(cut).collect(),
            axes,
            radii: arms.iter().map(|&arm| graph.radius(arm) / unit).collect(),
            tapers: arms.iter().map(|&arm| graph.taper(arm)).collect(),
        }
    };
    graph.node_ids().collect::<Vec<_>>().into_par_iter().map(star).collect()
}

fn cannot_part(misses: Vec<NearMiss>) -> Error {
    Error::CannotBuild { reasons: misses.iter().map(|m| format!("{}; no radii would part them", m.fault())).collect() }
}

fn cannot_cut(conflicts: Vec<cuts::Conflict>) -> Error {
    Error::CannotBuild { reasons: conflicts.iter().map(|c| c.fault().to_string()).collect() }
}

/// Nodes that no rung of the ladder can build.
pub fn cannot_build(graph: &Graph, failed: &[(NodeId, &[String])]) -> Error {
    let reason = |&(n, why): &(NodeId, &[String])| {
        let struts: Vec<String> = graph.arms(n).iter().map(|a| a.strut.0.to_string()).collect();
        format!("node {} (struts {}): {}", n.0, struts.join(", "), why.join("; "))
    };
    Error::CannotBuild { reasons: failed.iter().map(reason).collect() }
}
