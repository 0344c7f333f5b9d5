//! The proof that a strut's cuts cannot fit, as numbers to check by hand.

use super::bounds::{Bounds, Step};
use super::problem::{Problem, end_of};
use crate::error::Fault;
use crate::graph::{End, Graph};
use crate::ids::{NodeId, StrutId};
use std::fmt::Write as _;

/// Most links of a proof in a message; the structure holds all.
const LINKS_TOLD: usize = 3;

/// A strut whose length is less than its least cuts.
#[derive(Clone, Debug)]
pub struct Conflict {
    pub strut: StrutId,
    /// Length of the strut, mm.
    pub length: f64,
    /// Least cuts at ends a and b, mm.
    pub least: [f64; 2],
    /// Why the cuts at ends a and b cannot be shorter: the neighbour there, the neighbour of that strut's far end, and so on.
    pub because: [Vec<Binding>; 2],
    /// The factor by which the strut's radii would have to shrink, all else as it is.
    pub factor: f64,
}

/// One link of a proof: `beside` cannot be cut further than `most` from `node`, so its cap is at least atan(radius / most). What is
/// left of the angle makes the cut of `strut` at least `least`.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    pub node: NodeId,
    pub strut: StrutId,
    pub end: End,
    pub beside: StrutId,
    /// Angle left to both caps (`MARGIN` taken off), radians.
    pub angle: f64,
    /// Longest cut of `beside` at the node, mm: its length less the least cut at its far end.
    pub most: f64,
    /// Least cut of `strut` at the node, mm.
    pub least: f64,
}

/// All conflicts, by strut.
pub fn conflicts(graph: &Graph, p: &Problem, bounds: &Bounds) -> Vec<Conflict> {
    let binding = |step: Step| Binding {
        node: p.node[step.end],
        strut: end_of(step.end).0,
        end: end_of(step.end).1,
        beside: end_of(step.beside).0,
        angle: step.least + step.most,
        most: p.cut(step.beside, step.least),
        least: p.cut(step.end, step.most),
    };
    let mut out: Vec<Conflict> = bounds
        .crossed
        .iter()
        .map(|&(k, last)| {
            let because = last.map(|last| bounds.proof(last).into_iter().map(binding).collect::<Vec<_>>());
            let least = [0, 1].map(|end| because[end].first().map_or(p.least(2 * k + end), |b| b.least));
            let strut = StrutId(k as u32);
            let factor = if least.iter().all(|d| d.is_finite()) { p.room[k] / (least[0] + least[1]) } else { 0.0 };
            Conflict { strut, length: graph.length(strut), least, because, factor }
        })
        .collect();
    out.sort_by_key(|c| c.strut);
    out
}

impl Conflict {
    /// The conflict as a fault of the input.
    pub fn fault(&self) -> Fault {
        let [a, b] = self.least;
        let mut found = format!("cuts of at least {a:.6} mm and {b:.6} mm on a length of {:.6} mm", self.length);
        for (chain, end) in self.because.iter().zip(["a", "b"]) {
            for (k, link) in chain.iter().take(LINKS_TOLD).enumerate() {
                let (of, degrees) = (link.strut.0, link.angle.to_degrees());
                let start = if k == 0 { format!("; at {end}") } else { ", because".into() };
                let _ = write!(
                    found,
                    "{start} {of} shares {degrees:.3}° at node {} with {}, which is cut at {:.6} mm at most",
                    link.node.0, link.beside.0, link.most
                );
            }
            if chain.len() > LINKS_TOLD {
                let _ = write!(found, ", and so on ({} links)", chain.len());
            }
        }
        let wanted = format!("cuts that leave some strut between them: its radii smaller by a factor of {:.4}, all else as it is", self.factor);
        Fault::new(format!("struts[{}]", self.strut.0), found, wanted)
    }
}
