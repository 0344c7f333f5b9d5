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
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

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
    /// By `NodeId`; none where a node has no struts. Nodes of one star, to the last bit, share what was built.
    pub built: Vec<Option<Arc<Built>>>,
}

/// What became of each different star, by its bits.
type Known = HashMap<Vec<u64>, Result<Arc<Built>, Vec<String>>>;

/// Settle cuts and build all nodes. `begin` is told how many nodes a round builds, `advance` each one, from any thread.
pub fn settle(given: &Graph, options: &Options, begin: &dyn Fn(u64), advance: &(dyn Fn() + Sync)) -> Result<Settled, Error> {
    let mut graph = match options.on_conflict {
        OnConflict::Shrink { part: true } => cuts::part(given).map_err(cannot_part)?,
        _ => given.clone(),
    };
    let degrees = Degrees::new();
    let mut known = Known::new();
    for round in 0.. {
        let cuts = match options.on_conflict {
            OnConflict::Refuse => cuts::negotiate(&graph, options.lambda).map_err(cannot_cut)?,
            OnConflict::Shrink { .. } => {
                let (smaller, cuts) = cuts::shrink(&graph, options.lambda);
                graph = smaller;
                cuts
            }
        };
        let stars = stars(&graph, &cuts, options);
        let keys: Vec<Vec<u64>> = stars.iter().map(Star::bits).collect();
        let new = unknown(&stars, &keys, &known);
        begin(new.len() as u64);
        let build = |(key, star): (Vec<u64>, Star)| {
            let built = ladder::build(star, options, &degrees).map(Arc::new);
            advance();
            (key, built)
        };
        known.extend(new.into_par_iter().map(build).collect::<Vec<_>>());
        let of = |n: NodeId| known.get(&keys[n.index()]);
        let failed: Vec<(NodeId, &[String])> = graph.node_ids().filter_map(|n| Some((n, of(n)?.as_ref().err()?.as_slice()))).collect();
        if failed.is_empty() {
            let built = graph.node_ids().map(|n| of(n)?.as_ref().ok().cloned()).collect();
            let shrunk = cuts::shrunk(given, &graph);
            return Ok(Settled { graph, cuts, shrunk, built });
        }
        if options.on_conflict == OnConflict::Refuse || round == MOST_ROUNDS {
            return Err(cannot_build(&graph, &failed));
        }
        let mut factors = vec![1.0; graph.struts().len()];
        for arm in failed.iter().flat_map(|&(n, _)| graph.arms(n)) {
            factors[arm.strut.index()] = EASE;
        }
        graph = cuts::scaled(&graph, &factors);
    }
    unreachable!("the loop returns")
}

/// The stars with struts that are not known yet, each once, in the order of their first nodes.
fn unknown(stars: &[Star], keys: &[Vec<u64>], known: &Known) -> Vec<(Vec<u64>, Star)> {
    let mut met: HashSet<&[u64]> = HashSet::new();
    let all = stars.iter().zip(keys);
    all.filter(|(star, key)| star.degree() > 0 && !known.contains_key(*key) && met.insert(key)).map(|(star, key)| (key.clone(), star.clone())).collect()
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

fn cannot_build(graph: &Graph, failed: &[(NodeId, &[String])]) -> Error {
    let reason = |&(n, why): &(NodeId, &[String])| {
        let struts: Vec<String> = graph.arms(n).iter().map(|a| a.strut.0.to_string()).collect();
        format!("node {} (struts {}): {}", n.0, struts.join(", "), why.join("; "))
    };
    Error::CannotBuild { reasons: failed.iter().map(reason).collect() }
}
