//! Can the cuts fit at all? Bounds on caps, pushed along struts and across nodes until they rest or cross.
//!
//! A cap has a least value (its cut cannot be longer than its strut leaves) and a most value (its neighbours need their least
//! angle): least_a = cap_a(room - cut_b(most_b)), most_i = min over j (Θ_ij - least_j). Both only ever tighten.
//! - Where they rest, the middle of both is a solution: at a node ½(least_i + most_i) + ½(least_j + most_j) <= Θ_ij; on a strut
//!   because cuts are convex in their caps. (`least <= most` is not even needed.)
//! - Every solution lies between the bounds. So where a strut's least cuts exceed its room, there is no solution,
//!   and the steps that led there prove it.

use super::problem::{EndIndex, Problem, SETTLED, across};

const NONE: u32 = u32::MAX;

/// One step of a proof: `beside` at the same node has to take so large a cap that `end` is left `most`.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub end: EndIndex,
    pub beside: EndIndex,
    /// Least cap of `beside`, radians.
    pub least: f64,
    /// Most cap of `end`, radians.
    pub most: f64,
    /// The step that bounds the far end of `beside`'s strut; `NONE`: that end has its least cut.
    before: u32,
}

/// Bounds at rest.
pub struct Bounds {
    /// Least and most cap by strut end, radians; of the ends that were free to move.
    pub least: Vec<f64>,
    pub most: Vec<f64>,
    /// Struts whose least cuts exceed their room, with the last step for each end.
    pub crossed: Vec<(usize, [u32; 2])>,
    steps: Vec<Step>,
}

impl Bounds {
    /// The steps that lead to `last`, from the last to the first.
    pub fn proof(&self, last: u32) -> Vec<Step> {
        let mut out = Vec::new();
        let mut at = last;
        while at != NONE {
            let step = self.steps[at as usize];
            out.push(step);
            at = step.before;
        }
        out
    }

    /// The middle of an end's bounds.
    pub fn middle(&self, e: EndIndex) -> f64 {
        0.5 * (self.least[e] + self.most[e])
    }
}

/// Bounds for the struts in `moving`; the ends of all others keep their cap `at`, which fits among themselves.
pub fn bounds(p: &Problem, moving: &[bool], at: &[f64]) -> Bounds {
    let count = p.cones.len();
    let mut b = Bounds { least: vec![0.0; count], most: vec![0.0; count], crossed: Vec::new(), steps: Vec::new() };
    let mut last = vec![NONE; count];
    let mut dead = vec![false; p.struts()];
    let mut queued = vec![false; p.struts()];
    let mut queue: Vec<usize> = (0..p.struts()).filter(|&k| moving[k]).collect();
    for &k in &queue {
        for e in [2 * k, 2 * k + 1].into_iter().filter(|&e| !p.is_free(e)) {
            b.most[e] = p.cap(e, p.least(e));
            for (j, angle) in p.beside(e).filter(|&(j, _)| !moving[j / 2]) {
                if angle - at[j] < b.most[e] {
                    b.most[e] = angle - at[j];
                    last[e] = b.steps.len() as u32;
                    b.steps.push(Step { end: e, beside: j, least: at[j], most: b.most[e], before: NONE });
                }
            }
        }
    }
    // All struts of a round first, then all nodes: so the bounds do not depend on the order of struts.
    while !queue.is_empty() {
        let mut raised = Vec::new();
        for &k in &queue {
            queued[k] = false;
            if dead[k] {
                continue;
            }
            let cuts = [2 * k, 2 * k + 1].map(|e| p.cut(e, b.most[e]));
            if cuts[0] + cuts[1] > p.room[k] * (1.0 + SETTLED) {
                b.crossed.push((k, [last[2 * k], last[2 * k + 1]]));
                dead[k] = true;
                continue;
            }
            for (e, beyond) in [(2 * k, cuts[1]), (2 * k + 1, cuts[0])] {
                if p.is_free(e) {
                    continue;
                }
                let least = p.cap(e, p.room[k] - beyond).min(b.most[e]);
                if least > b.least[e] + SETTLED {
                    b.least[e] = least;
                    raised.push((e, last[across(e)]));
                }
            }
        }
        queue.clear();
        for &(i, before) in &raised {
            for (j, angle) in p.beside(i).filter(|&(j, _)| moving[j / 2] && !dead[j / 2]) {
                let most = angle - b.least[i];
                if most < b.most[j] - SETTLED {
                    b.most[j] = most;
                    last[j] = b.steps.len() as u32;
                    b.steps.push(Step { end: j, beside: i, least: b.least[i], most, before });
                    if !queued[j / 2] {
                        queued[j / 2] = true;
                        queue.push(j / 2);
                    }
                }
            }
        }
    }
    b
}
