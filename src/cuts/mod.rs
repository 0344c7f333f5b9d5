//! Cuts layer: `Graph ▶ Cuts`. Where each strut is cut, settled over the whole graph.
//!
//! In: a checked graph, any radii, and λ. Out: two cuts a strut (mm), such that at each node the rims' caps are apart by
//! `MARGIN` of the angle between their struts, and on each strut a part `FREE` of its length stays; or, where no cuts can do
//! that, for each strut without room a proof. `shrink` then makes radii smaller until cuts fit.
//! Struts with room for their preferred cuts have them to the bit, unless a neighbour without room needs them longer.
//! Preferred cuts also keep rims outside of all other struts; the others promise no more than caps that are apart.

mod bounds;
mod cone;
mod conflict;
pub mod preferred;
mod problem;
mod radii;
mod settle;
mod shrink;

pub use cone::Cone;
pub use conflict::{Binding, Conflict};
pub use problem::{FREE, MARGIN};
pub use radii::{Radii, Shrunk, Thinner};
pub use shrink::{part, shrink};

use crate::graph::Graph;
use crate::ids::StrutId;
use problem::Problem;

/// How a strut came to its cuts, in the order in which means are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Means {
    /// Both cuts are the preferred ones.
    Preferred,
    /// Between the preferred cuts and those with almost touching caps.
    SmallerLambda,
    /// One end is cut shorter than its neighbours, or longer to make room for one.
    UnequalCuts,
    /// The strut's length is shared between its ends in another proportion than their cuts asked for.
    UnequalSharing,
}

impl Means {
    /// In words, for the report.
    pub fn name(self) -> &'static str {
        match self {
            Means::Preferred => "preferred cuts",
            Means::SmallerLambda => "smaller lambda",
            Means::UnequalCuts => "unequal cuts",
            Means::UnequalSharing => "unequal sharing",
        }
    }
}

/// Cuts of a whole graph, by `StrutId`.
#[derive(Clone, Debug)]
pub struct Cuts {
    /// Distance of the rims from the nodes at ends a and b, mm.
    pub at: Vec<[f64; 2]>,
    /// The same as each node would have liked it, mm.
    pub preferred: Vec<[f64; 2]>,
    pub means: Vec<Means>,
}

/// Cuts that fit, or all struts for which there are none.
pub fn negotiate(graph: &Graph, lambda: f64) -> Result<Cuts, Vec<Conflict>> {
    let problem = Problem::new(graph, lambda);
    let all = vec![true; problem.struts()];
    // bounds are needed only where some strut is too short even for touching caps
    if (0..problem.struts()).any(|k| !problem.fits(k, &problem.touching)) {
        let bounds = bounds::bounds(&problem, &all, &[]);
        if !bounds.crossed.is_empty() {
            return Err(conflict::conflicts(graph, &problem, &bounds));
        }
    }
    let (cuts, means) = settle::settle(&problem);
    let pairs = |all: &[f64]| all.chunks_exact(2).map(|c| [c[0], c[1]]).collect();
    Ok(Cuts { at: pairs(&cuts), preferred: pairs(&problem.preferred), means })
}

/// How far each node reaches, by `NodeId` (mm): its largest radius, and the longest touching cut of its struts that have no room for
/// touching cuts, on each no further than the strut's end.
pub fn reach(graph: &Graph, lambda: f64) -> Vec<f64> {
    let problem = Problem::new(graph, lambda);
    let mut reach: Vec<f64> = graph.node_ids().map(|n| graph.largest_radius(n)).collect();
    for k in (0..problem.struts()).filter(|&k| !problem.fits(k, &problem.touching)) {
        for e in [2 * k, 2 * k + 1] {
            let at = &mut reach[problem.node[e].index()];
            *at = at.max(problem.touching[e].min(graph.length(StrutId(k as u32))));
        }
    }
    reach
}
