//! Radii made smaller until cuts fit, and until struts without a common node are apart. Where nothing else is left.
//!
//! What is wrong with a strut is wrong at one place of it. Cuts that are tight meet in one point, and there the radius is
//! `room / (cot ρ_a + cot ρ_b)`, whatever the taper; struts that overlap do so at one point of each. `Radii` then finds what each end gives.
//! A strut that has room for its touching cuts does not shrink for the sake of cuts: it gives way by them. The others go, each by steps, from
//! their full radii to those at which touching cuts fit; a step is taken by all those that a proof of conflict names.
//! At the end of all ways touching cuts fit everywhere, so this ends.

use super::bounds::bounds;
use super::problem::{Problem, SETTLED};
use super::radii::{Radii, Thinner};
use super::{Cuts, negotiate};
use crate::graph::proximity::{NearMiss, near_misses};
use std::f64::consts::FRAC_PI_2;

/// Parts of the way to the radii for touching cuts that steps take, from coarse to fine. Reason: the last is about how much
/// smaller than needed a radius may end; coarse ones first halve the time.
const STEPS: [f64; 4] = [1.0 / 4.0, 1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0];

/// Steps taken back before finer ones. Reason: a coarse step may have been one too many for some. Guessed.
const BACK: f64 = 2.0;

/// Smallest factor on a radius that a way may end at. Reason: where cones are wider than the angle between them it would end at 0.
const LEAST_FACTOR: f64 = 1.0 / 32.0;

/// Struts parted keep this share of their distance: a gap of a hundredth of the radii. Guessed.
const CLEAR: f64 = 0.99;

/// Radii at which cuts fit, and those cuts. Radii that fit are not changed.
pub fn shrink(radii: &mut Radii, lambda: f64) -> Cuts {
    loop {
        match negotiate(&radii.graph(), lambda) {
            Ok(cuts) => return cuts,
            Err(_) => shrink_once(radii, lambda),
        }
    }
}

/// Radii at which no struts without a common node overlap; on failure all pairs that no radii can part.
pub fn part(radii: &mut Radii) -> Result<(), Vec<NearMiss>> {
    loop {
        let misses = near_misses(&radii.graph());
        if misses.is_empty() {
            return Ok(());
        }
        let wishes = |m: &NearMiss| {
            let to = CLEAR * m.distance / m.wanted;
            [(m.a, m.along[0]), (m.b, m.along[1])].map(|(strut, t)| Thinner { strut, t, to })
        };
        radii.thin(misses.iter().flat_map(wishes));
        let hopeless = |m: &NearMiss| [m.a, m.b].iter().any(|&k| radii.least(k) < LEAST_FACTOR);
        if misses.iter().any(hopeless) {
            return Err(misses.into_iter().filter(hopeless).collect());
        }
    }
}

/// Make radii smaller until bounds do not cross.
fn shrink_once(radii: &mut Radii, lambda: f64) {
    let mut ways = Ways::new(Problem::new(&radii.graph(), lambda), radii);
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
}

/// How far each strut has gone from its full radii to those at which its touching cuts fit. All by strut.
struct Ways<'r, 'g> {
    p: Problem,
    radii: &'r mut Radii<'g>,
    /// Part of the way, 0 to 1.
    gone: Vec<f64>,
    /// Factors on the radii at the beginning and at the end of the way; equal where there is no way to go.
    first: Vec<[f64; 2]>,
    last: Vec<[f64; 2]>,
}

impl<'r, 'g> Ways<'r, 'g> {
    fn new(mut p: Problem, radii: &'r mut Radii<'g>) -> Self {
        let first = radii.factors.clone();
        let last = (0..p.struts()).map(|k| if p.fits(k, &p.touching) { first[k] } else { touching_factors(&mut p, radii, k) }).collect();
        Ways { gone: vec![0.0; p.struts()], first, last, p, radii }
    }

    fn can_go(&self, k: usize) -> bool {
        self.last[k] != self.first[k] && self.gone[k] < 1.0
    }

    fn go(&mut self, k: usize, step: f64) {
        if self.last[k] == self.first[k] {
            return;
        }
        self.gone[k] = (self.gone[k] + step).clamp(0.0, 1.0);
        let (first, last, gone) = (self.first[k], self.last[k], self.gone[k]);
        self.set(k, [0, 1].map(|e| first[e] - gone * (first[e] - last[e])));
    }

    fn go_beyond(&mut self, k: usize, step: f64) {
        self.set(k, self.radii.factors[k].map(|f| f * (1.0 - step)));
    }

    fn set(&mut self, k: usize, factors: [f64; 2]) {
        self.radii.factors[k] = factors;
        self.p.set_radii(k, self.radii.of(k, factors));
    }
}

/// The factors on a strut's radii at which cuts with its touching caps fit; the radius where the two cuts meet is not made smaller than
/// by `LEAST_FACTOR`. The strut of the problem is left as it was.
fn touching_factors(p: &mut Problem, radii: &Radii, k: usize) -> [f64; 2] {
    let ends = [2 * k, 2 * k + 1];
    let now = radii.factors[k];
    // a cone wider than its angle leaves its neighbour no cap at all
    let caps = ends.map(|e| if p.is_free(e) { FRAC_PI_2 } else { p.cap(e, p.touching[e]).max(SETTLED) });
    let [a, b] = caps.map(|cap| 1.0 / cap.tan());
    let thinned = |to: f64| radii.thinned(k, now, a / (a + b), to);
    // cuts grow with the radii, from 0
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        p.set_radii(k, radii.of(k, thinned(middle)));
        if p.cut(ends[0], caps[0]) + p.cut(ends[1], caps[1]) <= p.room[k] { low = middle } else { high = middle }
    }
    p.set_radii(k, radii.of(k, now));
    thinned(low.max(LEAST_FACTOR))
}
