//! Radii made smaller until cuts fit, and until struts without a common node are apart. Where nothing else is left.
//!
//! Cuts that are tight on a strut meet in one point, and there the radius is `room / (cot ρ_a + cot ρ_b)`, whatever the taper: to shrink one
//! end alone would gain nothing that is seen, so a strut shrinks as a whole and a cylinder stays a cylinder.
//! A strut that has room for its touching cuts never shrinks: it gives way by its cuts. The others go, each by steps, from
//! their full radius to the one at which touching cuts fit; a step is taken by all those that a proof of conflict names.
//! At the end of all ways touching cuts fit everywhere, so this ends.

use super::bounds::bounds;
use super::problem::{Problem, across};
use super::{Cone, Cuts, negotiate};
use crate::graph::proximity::{NearMiss, near_misses};
use crate::graph::{Graph, Strut};
use crate::ids::StrutId;
use std::f64::consts::PI;

/// Parts of the way to the radius for touching cuts that steps take, from coarse to fine. Reason: the last is about how much
/// smaller than needed a radius may end; coarse ones first halve the time.
const STEPS: [f64; 4] = [1.0 / 4.0, 1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0];

/// Steps taken back before finer ones. Reason: a coarse step may have been one too many for some. Guessed.
const BACK: f64 = 2.0;

/// Smallest factor on a radius that a way may end at. Reason: where cones are wider than the angle between them it would end at 0.
const LEAST_FACTOR: f64 = 1.0 / 32.0;

/// Struts parted keep this share of their distance: a gap of a hundredth of the radii. Guessed.
const CLEAR: f64 = 0.99;

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

/// The graph with radii at which cuts fit, and those cuts. A graph that fits is not changed.
pub fn shrink(graph: &Graph, lambda: f64) -> (Graph, Cuts) {
    let mut now = graph.clone();
    let cuts = loop {
        match negotiate(&now, lambda) {
            Ok(cuts) => break cuts,
            Err(_) => now = shrink_once(&now, lambda),
        }
    };
    (now, cuts)
}

/// What was made smaller.
pub fn shrunk(before: &Graph, after: &Graph) -> Vec<Shrunk> {
    let changed = before.struts().iter().zip(after.struts()).enumerate().filter(|(_, (old, new))| old != new);
    let one = |(k, (old, new)): (usize, (&Strut, &Strut))| {
        let strut = StrutId(k as u32);
        let volume = |s: &Strut| PI / 3.0 * before.length(strut) * (s.ra * s.ra + s.ra * s.rb + s.rb * s.rb);
        Shrunk { strut, before: [old.ra, old.rb], after: [new.ra, new.rb], volume: volume(old) - volume(new) }
    };
    changed.map(one).collect()
}

/// All radii at the struts multiplied by a factor each.
pub fn scaled(graph: &Graph, factors: &[f64]) -> Graph {
    let struts = graph.struts().iter().zip(factors).map(|(s, f)| if *f < 1.0 { Strut { ra: s.ra * f, rb: s.rb * f, ..*s } } else { *s });
    Graph::new(graph.nodes().to_vec(), struts.collect())
}

/// Radii at which no struts without a common node overlap, or all pairs that no radii can part.
pub fn part(graph: &Graph) -> Result<Graph, Vec<NearMiss>> {
    let mut factors = vec![1.0; graph.struts().len()];
    loop {
        let now = scaled(graph, &factors);
        let misses = near_misses(&now);
        if misses.is_empty() {
            return Ok(now);
        }
        let mut step = vec![1.0f64; factors.len()];
        for miss in &misses {
            let factor = CLEAR * miss.distance / miss.wanted;
            for strut in [miss.a, miss.b] {
                step[strut.index()] = step[strut.index()].min(factor);
            }
        }
        factors.iter_mut().zip(&step).for_each(|(f, s)| *f *= s);
        let hopeless = |m: &NearMiss| [m.a, m.b].iter().any(|k| factors[k.index()] < LEAST_FACTOR);
        if misses.iter().any(hopeless) {
            return Err(misses.into_iter().filter(hopeless).collect());
        }
    }
}

/// Radii for which bounds do not cross.
fn shrink_once(graph: &Graph, lambda: f64) -> Graph {
    let mut ways = Ways::new(Problem::new(graph, lambda));
    let all = vec![true; ways.p.struts()];
    let mut coarser = None;
    for step in STEPS {
        if let Some(coarser) = coarser {
            (0..all.len()).for_each(|k| ways.go(k, -BACK * coarser));
        }
        coarser = Some(step);
        loop {
            let bounds = bounds(&ways.p, &all, &[]);
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
            if named.iter().any(|&k| ways.can_go(k)) {
                named.iter().for_each(|&k| ways.go(k, step));
            } else {
                // round-off at the end of all ways, or cones wider than the angle between them
                named.iter().for_each(|&k| ways.go_beyond(k, step));
            }
        }
    }
    scaled(graph, &ways.factor)
}

/// How far each strut has gone from its full radii to those at which its touching cuts fit. All by strut but `full`.
struct Ways {
    p: Problem,
    /// By strut end, radii not shrunk.
    full: Vec<Cone>,
    /// Part of the way, 0 to 1.
    gone: Vec<f64>,
    /// Factor on the radii at the end of the way; 1: no way to go.
    last: Vec<f64>,
    /// Factor on the radii now.
    factor: Vec<f64>,
}

impl Ways {
    fn new(p: Problem) -> Ways {
        let last = (0..p.struts()).map(|k| if p.fits(k, &p.touching) { 1.0 } else { touching_factor(&p, k) }).collect();
        Ways { full: p.cones.clone(), gone: vec![0.0; p.struts()], factor: vec![1.0; p.struts()], last, p }
    }

    fn can_go(&self, k: usize) -> bool {
        self.last[k] < 1.0 && self.gone[k] < 1.0
    }

    fn go(&mut self, k: usize, step: f64) {
        if self.last[k] < 1.0 {
            self.gone[k] = (self.gone[k] + step).clamp(0.0, 1.0);
            self.set(k, 1.0 - self.gone[k] * (1.0 - self.last[k]));
        }
    }

    fn go_beyond(&mut self, k: usize, step: f64) {
        self.set(k, self.factor[k] * (1.0 - step));
    }

    fn set(&mut self, k: usize, factor: f64) {
        self.factor[k] = factor;
        for e in [2 * k, across(2 * k)] {
            self.p.cones[e] = self.full[e].scaled(factor);
        }
    }
}

/// The factor on a strut's radii at which cuts with its touching caps fit; not below `LEAST_FACTOR`.
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
    low.max(LEAST_FACTOR)
}
