//! From a graph to built nodes: cuts for all struts, then each node by the ladder; where something does not fit, what the policy says.
//! `OnConflict::Refuse` answers with all reasons at once. `OnConflict::Shrink` makes radii smaller: of struts that overlap, of struts that
//! no cuts fit, and of the struts at nodes that no rung of the ladder can build, until all is built or there is no more to gain.

use crate::cuts::{self, Cuts, Shrunk};
use crate::error::Error;
use crate::graph::proximity::NearMiss;
use crate::graph::{Arm, Graph};
use crate::ids::NodeId;
use crate::ladder::{self, Built, Degrees};
use crate::node::{Star, cut};
use crate::options::{OnConflict, Options};
use rayon::prelude::*;

/// Factor on the radii of all struts at a node that could not be built, each round. Guessed: near the least that is needed, in few rounds.
const EASE: f64 = 0.93;
/// Rounds of easing before a node is given up: radii are then a twentieth of what they were.
const MOST_ROUNDS: usize = 40;

/// A graph whose nodes are all built.
pub struct Settled {
    /// As given, or with smaller radii.
    pub graph: Graph,
    pub cuts: Cuts,
    pub shrunk: Vec<Shrunk>,
    /// By `NodeId`; none where a node has no struts.
    pub built: Vec<Option<Built>>,
}

/// What became of one node in the last round, and what it was built from.
type Tried = (Star, Result<Built, Vec<String>>);

/// Settle cuts and build all nodes. `begin` is told how many nodes a round builds, `advance` each one, from any thread.
pub fn settle(given: &Graph, options: &Options, begin: &dyn Fn(u64), advance: &(dyn Fn() + Sync)) -> Result<Settled, Error> {
    let mut graph = match options.on_conflict {
        OnConflict::Shrink { part: true } => cuts::part(given).map_err(cannot_part)?,
        _ => given.clone(),
    };
    let degrees = Degrees::new();
    let mut tried: Vec<Option<Tried>> = (0..graph.nodes().len()).map(|_| None).collect();
    for round in 0.. {
        let cuts = match options.on_conflict {
            OnConflict::Refuse => cuts::negotiate(&graph, options.lambda).map_err(cannot_cut)?,
            OnConflict::Shrink { .. } => {
                let (smaller, cuts) = cuts::shrink(&graph, options.lambda);
                graph = smaller;
                cuts
            }
        };
        // a node whose star has not changed is as it was
        let stars = stars(&graph, &cuts, options);
        let is_new = |(star, old): &(&Star, &Option<Tried>)| star.degree() > 0 && old.as_ref().is_none_or(|(before, _)| before != *star);
        begin(stars.iter().zip(&tried).filter(is_new).count() as u64);
        tried = stars
            .into_par_iter()
            .zip(tried)
            .map(|(star, old)| match old {
                _ if star.degree() == 0 => None,
                Some((before, built)) if before == star => Some((before, built)),
                _ => {
                    let built = ladder::build(star.clone(), options, &degrees);
                    advance();
                    Some((star, built))
                }
            })
            .collect();
        let failed: Vec<NodeId> = graph.node_ids().filter(|n| matches!(tried[n.index()], Some((_, Err(_))))).collect();
        if failed.is_empty() {
            let built = tried.into_iter().map(|t| t.and_then(|(_, built)| built.ok())).collect();
            let shrunk = cuts::shrunk(given, &graph);
            return Ok(Settled { graph, cuts, shrunk, built });
        }
        if options.on_conflict == OnConflict::Refuse || round == MOST_ROUNDS {
            return Err(cannot_build(&graph, &failed, &tried));
        }
        let mut factors = vec![1.0; graph.struts().len()];
        for arm in failed.iter().flat_map(|&n| graph.arms(n)) {
            factors[arm.strut.index()] = EASE;
        }
        graph = cuts::scaled(&graph, &factors);
    }
    unreachable!("the loop returns")
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

fn cannot_build(graph: &Graph, failed: &[NodeId], tried: &[Option<Tried>]) -> Error {
    let reason = |&n: &NodeId| {
        let why = tried[n.index()].as_ref().and_then(|(_, built)| built.as_ref().err()).map(|why| why.join("; ")).unwrap_or_default();
        let struts: Vec<String> = graph.arms(n).iter().map(|a| a.strut.0.to_string()).collect();
        format!("node {} (struts {}): {why}", n.0, struts.join(", "))
    };
    Error::CannotBuild { reasons: failed.iter().map(reason).collect() }
}
