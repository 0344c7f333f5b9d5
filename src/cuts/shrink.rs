//! Radii made smaller until cuts fit. Where nothing else is left.
//!
//! Cuts that are tight on a strut meet in one point, and there the radius is `room / (cot ρ_a + cot ρ_b)`, whatever the taper: to shrink one
//! end alone would gain nothing that is seen, so a strut shrinks as a whole and a cylinder stays a cylinder.
//! A strut that has room for its touching cuts never shrinks: it gives way by its cuts. The others go, each by steps, from
//! their full radius to the one at which touching cuts fit; a step is taken by all those that a proof of conflict names.
//! At the end of all ways touching cuts fit everywhere, so this ends.

use super::bounds::bounds;
use super::problem::{Problem, across};
use super::{Cuts, negotiate};
use crate::graph::{Graph, Strut};
use crate::ids::StrutId;
use std::f64::consts::PI;

/// Part of the way to the radius for touching cuts that one step takes. Reason: the most that a radius may be smaller than
/// needed. Guessed.
const STEP: f64 = 1.0 / 32.0;

/// A strut whose radii were made smaller.
#[derive(Clone, Copy, Debug)]
pub struct Shrunk {
    pub strut: StrutId,
    /// Radii at ends a and b, mm.
    pub before: [f64; 2],
    pub after: [f64; 2],
    /// Volume lost of the strut from node to node, mm³.
    pub volume: f64,
}

/// The graph with radii at which cuts fit, those cuts, and what was changed. A graph that fits is not changed.
pub fn shrink(graph: &Graph, lambda: f64) -> (Graph, Cuts, Vec<Shrunk>) {
    let mut now = graph.clone();
    let cuts = loop {
        match negotiate(&now, lambda) {
            Ok(cuts) => break cuts,
            Err(_) => now = shrink_once(&now, lambda),
        }
    };
    let mut shrunk = Vec::new();
    for (k, (old, new)) in graph.struts().iter().zip(now.struts()).enumerate().filter(|(_, (old, new))| old != new) {
        let strut = StrutId(k as u32);
        let volume = |s: &Strut| PI / 3.0 * graph.length(strut) * (s.ra * s.ra + s.ra * s.rb + s.rb * s.rb);
        shrunk.push(Shrunk { strut, before: [old.ra, old.rb], after: [new.ra, new.rb], volume: volume(old) - volume(new) });
    }
    (now, cuts, shrunk)
}

/// Radii for which bounds do not cross.
fn shrink_once(graph: &Graph, lambda: f64) -> Graph {
    let mut p = Problem::new(graph, lambda);
    let full = p.cones.clone();
    let all = vec![true; p.struts()];
    // the factor at the end of the way, and how far each strut has gone
    let last: Vec<f64> = (0..p.struts()).map(|k| if p.fits(k, &p.touching) { 1.0 } else { touching_factor(&p, k) }).collect();
    let mut way = vec![0.0; p.struts()];
    let mut factor = vec![1.0; p.struts()];
    loop {
        let bounds = bounds(&p, &all, &[]);
        if bounds.crossed.is_empty() {
            break;
        }
        let mut named: Vec<usize> = Vec::new();
        for &(k, steps) in &bounds.crossed {
            named.push(k);
            named.extend(steps.iter().flat_map(|&s| bounds.proof(s)).map(|step| step.beside / 2));
        }
        named.sort_unstable();
        named.dedup();
        let mut moved = false;
        for &k in &named {
            if last[k] < 1.0 && way[k] < 1.0 {
                way[k] = (way[k] + STEP).min(1.0);
                factor[k] = 1.0 - way[k] * (1.0 - last[k]);
                moved = true;
            }
        }
        if !moved {
            // the end of the way: round-off, or cones wider than the angle between them
            named.iter().for_each(|&k| factor[k] *= 1.0 - STEP);
        }
        for k in named {
            for e in [2 * k, across(2 * k)] {
                p.cones[e] = full[e].scaled(factor[k]);
            }
        }
    }
    let struts = graph.struts().iter().zip(&factor).map(|(s, f)| if *f < 1.0 { Strut { ra: s.ra * f, rb: s.rb * f, ..*s } } else { *s });
    Graph::new(graph.nodes().to_vec(), struts.collect())
}

/// The factor on a strut's radii at which cuts with its touching caps fit; not below `STEP`.
fn touching_factor(p: &Problem, k: usize) -> f64 {
    let ends = [2 * k, 2 * k + 1];
    let caps = ends.map(|e| p.cap(e, p.touching[e]));
    let cuts = |f: f64| -> f64 { ends.iter().zip(caps).filter(|&(&e, _)| !p.is_free(e)).map(|(&e, cap)| p.cones[e].scaled(f).cut(cap)).sum() };
    // cuts grow with the radii, from 0
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if cuts(middle) <= p.room[k] { low = middle } else { high = middle }
    }
    low.max(STEP)
}
